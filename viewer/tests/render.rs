//! The window's contents with a render behind them: what is done by labels ends up in pictures and files. `PATINA_DEVICE` names the
//! device, or it is the best that there is; skipped where there is none.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use device::{Device, DeviceChoice};
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use engine::denoise::{self, Denoiser};
use engine::scene::look::Value;
use engine::scene::view::{View, ViewChoice};
use engine::session::Edit;
use patina_viewer::host::{Changes, Finished, Host, OpenDenoiser};
use patina_viewer::link::{
    Command, Denoise, DenoiserState, Extent, FINE, Files, PickPurpose, PictureOrder, Reply, Saving,
    Waker,
};
use patina_viewer::picture::Picture;
use patina_viewer::thread::{RenderOptions, RenderThread};
use patina_viewer::viewer::{Preferences, Viewer};
use tempfile::TempDir;

#[path = "render/files.rs"]
mod files;
#[path = "render/noise.rs"]
mod noise;
#[path = "render/regions.rs"]
mod regions;

/// A triangle and a camera in front of it.
const SCENE: &str = r#"{
  "asset": { "version": "2.0" },
  "scene": 0,
  "scenes": [{ "nodes": [0, 1] }],
  "nodes": [{ "name": "Near", "mesh": 0 }, { "name": "View", "camera": 0, "translation": [0, 0, 3] }],
  "cameras": [{ "name": "View", "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
  "materials": [{ "name": "Brass" }],
  "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
  "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0] }],
  "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
  "buffers": [{ "byteLength": 36, "uri": "triangle.bin" }]
}"#;
const LOOK: &str = "# Light from everywhere.\nenvironment = { color = [1, 1, 1], intensity = 1.0 } # white\n\n[material.Brass] # of a lamp\nroughness = 0.5   # worn\n";

/// A picture of that name is a fault of the program.
const FAULT: &str = "fault.png";

/// A host whose files change when the test says so, and that writes names instead of pictures.
struct TestHost {
    changes: std::sync::mpsc::Receiver<Changes>,
    waker: Arc<Mutex<Option<Waker>>>,
    textures: PathBuf,
    ending: Arc<AtomicBool>,
}

/// Tells a host of changes, and wakes the render, which doesn't ask by itself.
struct Saves {
    sender: std::sync::mpsc::Sender<Changes>,
    waker: Arc<Mutex<Option<Waker>>>,
}

impl Saves {
    fn send(&self, changes: Changes) -> Result<(), std::sync::mpsc::SendError<Changes>> {
        self.sender.send(changes)?;
        let waker = self.waker.lock().expect("no panic");
        waker.as_ref().expect("it was handed in").wake();
        Ok(())
    }
}

impl Host for TestHost {
    fn texture_folders(&self, _: Option<&Path>) -> Result<Vec<PathBuf>, String> {
        Ok(vec![self.textures.clone()])
    }

    fn watch(&mut self, files: &[PathBuf], _: Option<&Path>, _: &[PathBuf]) -> Result<(), String> {
        assert!(!files.is_empty());
        Ok(())
    }

    fn changes(&mut self) -> Changes {
        self.changes.try_recv().unwrap_or_default()
    }

    fn wake_by(&mut self, waker: Waker) {
        *self.waker.lock().expect("no panic") = Some(waker);
    }

    fn is_ending(&self) -> bool {
        self.ending.load(Ordering::SeqCst)
    }

    fn patience(&self) -> Duration {
        Duration::from_secs(3600)
    }

    fn report(&self, text: &str) {
        assert!(!text.is_empty());
    }

    fn denoiser(&self) -> OpenDenoiser {
        Box::new(|| {
            let folder = std::env::var_os("OIDN_DIR").ok_or("OIDN_DIR doesn't say where it is")?;
            let library = Path::new(&folder).join("lib").join(denoise::FILE);
            Denoiser::open(&library).map_err(|error| error.to_string())
        })
    }

    fn recent(&self) -> Vec<Files> {
        vec![Files::default()]
    }

    fn keep_recent(&self, list: &[Files]) -> Result<(), String> {
        assert!(list[0].scene.is_absolute(), "{list:?}");
        assert_eq!(list.last(), Some(&Files::default()), "former ones stay");
        Ok(())
    }

    fn check_picture(&self, path: &Path) -> Result<(), String> {
        assert!(!path.ends_with(FAULT), "it is as if there were a fault");
        let has_folder = path.parent().is_some_and(Path::is_dir);
        has_folder.then_some(()).ok_or("no folder".to_owned())
    }

    fn write_picture(&self, path: &Path, picture: &Finished<'_>) -> Result<(), String> {
        let Finished {
            film, origin, view, ..
        } = *picture;
        let (least, most) = film.sample_bounds();
        assert_eq!(least, most, "each pixel has all of its samples");
        // Of few samples some are black, but no part of the picture is.
        let black = film.mean().iter().filter(|rgb| rgb[0] <= 0.0).count();
        assert!(black < film.mean().len() / 8, "{black} pixels are black");
        let layers = picture.layers.iter().count();
        let (width, height) = (film.width, film.height);
        let (depth, shown) = (origin.setting("max-depth"), view.transform.name());
        let clean = match picture.denoised {
            Some((radiance, by)) => {
                assert_eq!(radiance.len(), film.pixels());
                assert!(Denoiser::has_guides(film));
                format!(" without noise by {by},")
            }
            None => String::new(),
        };
        let text =
            format!("{width} x {height}, {least} spp, {layers} layers,{clean} {depth:?}, {shown}");
        fs::write(path, text).map_err(|error| error.to_string())
    }
}

fn usual_device() -> DeviceChoice {
    let name = std::env::var("PATINA_DEVICE");
    name.map_or(DeviceChoice::Best, DeviceChoice::Name)
}

struct Stage {
    device: Device,
    folder: TempDir,
    harness: Harness<'static, Viewer>,
    thread: RenderThread,
    changes: Saves,
    ending: Arc<AtomicBool>,
}

impl Stage {
    fn new() -> Option<Self> {
        let mut stage = Self::beginning(LOOK)?;
        stage.wait("a picture", |stage| {
            stage.harness.state().status().spp >= 4.0
        });
        Some(stage)
    }

    /// With a look that may be wrong.
    fn beginning(look: &str) -> Option<Self> {
        Self::on(&usual_device(), look, 4)
    }

    fn on(choice: &DeviceChoice, look: &str, target_spp: u32) -> Option<Self> {
        let device = match Device::open(choice) {
            Ok(device) => device,
            Err(error) => {
                assert!(
                    std::env::var_os("PATINA_REQUIRE_DEVICE").is_none(),
                    "{error}"
                );
                eprintln!("skipped: {error}");
                return None;
            }
        };
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        let corners = [-1.0f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
        let bytes: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
        fs::write(path("triangle.bin"), bytes).expect("written");
        fs::write(path("scene.gltf"), SCENE).expect("written");
        fs::write(path("scene.look.toml"), look).expect("written");
        let files = Files {
            scene: path("scene.gltf"),
            look: Some(path("scene.look.toml")),
            camera: None,
        };
        let options = RenderOptions {
            target_spp,
            max_depth: 2,
            seed: 0,
            size: [32, 18],
        };
        let (sender, changes) = std::sync::mpsc::channel();
        let textures = folder.path().to_owned();
        let waker = Arc::default();
        let ending = Arc::new(AtomicBool::new(false));
        let host = Box::new(TestHost {
            changes,
            waker: Arc::clone(&waker),
            textures,
            ending: Arc::clone(&ending),
        });
        let thread =
            RenderThread::start(device.clone(), Some(files), options, host, Box::new(|| {}));
        let thread = thread.expect("a thread");
        let preferences = Preferences {
            // Small pictures are enough.
            coarseness: 8,
            // Where that can be done, it makes kernels at a time of its own.
            denoises: false,
            ..Preferences::default()
        };
        let viewer = Viewer::new(thread.link.clone(), preferences, ViewChoice::default());
        let harness = Harness::builder()
            // So wide that the figures at the bottom need one line, however many digits they have.
            .with_size([1200.0, 400.0])
            .build_ui_state(|ui, viewer: &mut Viewer| viewer.ui(ui), viewer);
        Some(Self {
            device,
            folder,
            harness,
            thread,
            changes: Saves { sender, waker },
            ending,
        })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_default()
    }

    /// Frame by frame, until something is so.
    fn wait(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let end = Instant::now() + Duration::from_secs(60);
        while !is_so(self) {
            assert!(
                Instant::now() < end,
                "no {what}: {:?}",
                self.harness.state().status()
            );
            self.harness.run_steps(1);
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn edit(&mut self, edit: Edit) {
        let document = self.harness.state_mut().document_mut().expect("read");
        document.apply("test", &[edit], None).expect("a look");
        self.wait("unsaved edit", |stage| {
            stage.harness.state().status().has_unsaved_edits
        });
    }
}

#[test]
fn edits_are_seen_without_pipelines_and_saved_with_comments() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let pipelines = stage.device.counts().pipelines;
    stage.edit(Edit::material("Brass", "roughness", Value::number(0.25)));
    assert_eq!(
        stage.read("scene.look.toml"),
        LOOK,
        "nothing is written unasked"
    );
    stage
        .harness
        .key_press_modifiers(Modifiers::COMMAND, Key::S);
    stage.wait("saved look", |stage| {
        !stage.harness.state().status().has_unsaved_edits
    });
    assert_eq!(stage.read("scene.look.toml"), LOOK.replace("0.5 ", "0.25 "));
    // Figures are told less often than pictures are shown.
    stage.wait("picture with its figures", |stage| {
        let status = stage.harness.state().status();
        status.spp >= 4.0 && status.latency.is_some() && status.error.is_some()
    });
    assert_eq!(stage.device.counts().pipelines, pipelines);
    let status = stage.harness.state().status();
    assert_eq!(status.pipelines, pipelines);
    assert!(status.memory > 0);
    stage.thread.finish();
}

#[test]
fn a_scene_without_light_is_seen_in_a_studio_that_the_look_has_nothing_of() {
    const BARE: &str = "[material.Brass]\nroughness = 0.5\n";
    let Some(mut stage) = Stage::beginning(BARE) else {
        return;
    };
    let is_whole = |stage: &Stage, is_dark: bool| {
        let status = stage.harness.state().status();
        // Nothing but a black picture has no error at all.
        status.spp >= 4.0 && status.error.is_some_and(|error| (error == 0.0) == is_dark)
    };
    stage.wait("lit picture", |stage| is_whole(stage, false));
    for is_on in [false, true] {
        stage.harness.get_by_label("Studio light").click();
        stage.wait("other picture", |stage| is_whole(stage, !is_on));
        assert_eq!(stage.harness.state().preferences.studio_light, is_on);
    }
    assert!(!stage.harness.state().status().has_unsaved_edits);
    assert_eq!(stage.read("scene.look.toml"), BARE);
    // What is built anew has it, too, and a light of the look takes its place.
    stage.edit(Edit::environment("color", Value::numbers(&[0.0; 3])));
    stage.wait("dark picture", |stage| is_whole(stage, true));
    let studio = stage.harness.query_by_label("Studio light");
    assert!(studio.is_none(), "the look says what there is");
    stage.thread.finish();
}

#[test]
fn pictures_are_finished_before_they_are_written() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let size = stage.harness.state().status().size;
    let order = |stage: &Stage, name: &str, size, spp, layers| PictureOrder {
        path: stage.path(name),
        size,
        spp,
        layers,
        denoised: false,
        view: View::default(),
    };
    // In motion there is a coarse picture only; what is written is as large and as fine as it was asked for.
    let camera = stage.thread.link.board().scene.look_camera.clone();
    for (name, size, spp, layers, count) in [
        ("a.png", size, 5, false, 1),
        ("b.png", [40, 30], 3, false, 1),
        ("c.exr", [20, 10], 1, true, 2),
        ("d.png", size, 4, false, 1),
    ] {
        match name {
            // What has all of its samples is written as it is.
            "d.png" => stage.wait("whole picture", |stage| {
                let status = stage.harness.state().status();
                status.is_whole && status.spp >= 4.0
            }),
            _ => stage.thread.link.send(Command::View(camera.clone())),
        }
        let order = order(&stage, name, size, spp, layers);
        stage.thread.link.send(Command::SavePicture(order));
        stage.wait("written picture", |stage| !stage.read(name).is_empty());
        let text = stage.read(name);
        let start = format!("{} x {}, {spp} spp, ", size[0], size[1]);
        let rest = text
            .strip_prefix(&start)
            .unwrap_or_else(|| panic!("{text}"));
        let layers: usize = rest
            .split(' ')
            .next()
            .expect("a word")
            .parse()
            .expect("a number");
        assert!(layers >= count && rest.ends_with("standard"), "{text}");
    }
    // One that takes too long is given up, and one that has nowhere to go isn't begun.
    let long = order(&stage, "long.png", [300, 300], 1 << 20, false);
    stage.thread.link.send(Command::SavePicture(long));
    stage.wait("progress", |stage| {
        let saving = &stage.harness.state().status().saving;
        // That before may not have gone yet.
        let is_long = |saving: &Saving| saving.target == 1 << 20 && saving.spp > 0.0;
        saving.as_ref().is_some_and(is_long)
    });
    stage.harness.get_by_label("Cancel").click();
    stage.wait("end of it", |stage| {
        stage.harness.state().status().saving.is_none()
    });
    assert_eq!(stage.read("long.png"), "");
    let nowhere = order(&stage, "nowhere/a.png", [8, 8], 1, false);
    stage.thread.link.send(Command::SavePicture(nowhere));
    stage.wait("reason", |stage| {
        stage.harness.query_by_label_contains("no folder").is_some()
    });
    stage.thread.finish();
}

#[test]
fn paused_it_shows_edits_and_views_once_and_sleeps_until_it_is_woken() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let is_whole = |stage: &Stage| stage.harness.state().status().is_whole;
    let answered = |stage: &Stage| stage.harness.state().status().answered;
    stage.wait("whole picture", is_whole);
    stage.thread.link.send(Command::Target(1 << 20));
    stage.harness.get_by_label("Pause").click();
    stage.wait("pause", |stage| stage.harness.state().status().is_paused);
    let still = |stage: &mut Stage| {
        // So long that nothing follows any more of what was done.
        let end = Instant::now() + Duration::from_millis(1500);
        while Instant::now() < end {
            stage.harness.run_steps(1);
            std::thread::sleep(Duration::from_millis(20));
        }
        stage.harness.state().status().spp
    };
    let spp = still(&mut stage);
    assert_eq!(still(&mut stage), spp, "no more samples");
    let camera = stage.thread.link.board().scene.look_camera.clone();
    for what in ["edit", "orbit", "save of another program"] {
        let before = answered(&stage);
        match what {
            "edit" => stage.edit(Edit::material("Brass", "roughness", Value::number(0.25))),
            "orbit" => stage.thread.link.send(Command::View(camera.clone())),
            _ => {
                fs::write(stage.path("scene.gltf"), SCENE.replace("0.7", "0.75")).expect("written");
                let assets = Changes {
                    assets: true,
                    ..Changes::default()
                };
                stage.changes.send(assets).expect("heard");
            }
        }
        stage.wait(what, |stage| answered(stage) > before && is_whole(stage));
        let spp = still(&mut stage);
        assert!(is_whole(&stage) && spp >= 1.0, "{what}: {spp}");
        assert_eq!(still(&mut stage), spp, "{what}: no more samples");
    }
    // Going on, it renders again.
    stage.harness.get_by_label("Pause").click();
    let spp = stage.harness.state().status().spp;
    stage.wait("more samples", |stage| {
        stage.harness.state().status().spp >= spp + 4.0
    });
    stage.thread.finish();
}

#[test]
fn a_picture_that_is_kept_in_the_midst_of_a_motion_keeps_nothing_waiting() {
    let Some(stage) = Stage::new() else {
        return;
    };
    let full = [640, 360];
    // Columns of what is shown, and of what it is compared with; the window, which wants another size, has no frames.
    let wait = |what: &str, is_so: &dyn Fn(u32, u32) -> bool| {
        let end = Instant::now() + Duration::from_secs(60);
        loop {
            let shown = stage.thread.link.board().shown.clone();
            let sizes = shown.and_then(|shown| {
                let [now, before, _] = &shown.pictures;
                assert_eq!(now.as_ref().map(Picture::size), Some(shown.size));
                Some((shown.size[0], before.as_ref()?.size()[0]))
            });
            match sizes {
                Some((now, before)) if is_so(now, before) => return before,
                _ => assert!(Instant::now() < end, "no {what}: {sizes:?}"),
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    stage.thread.link.send(Command::Size(full));
    stage.thread.link.send(Command::KeepBefore(true));
    let before = wait("picture of before", &|_, _| true);
    if stage.device.traits().shares_the_processor {
        assert!(before < full[0], "{before} columns had to be waited for");
    }
    wait("both in full", &|now, before| [now, before] == [full[0]; 2]);
    stage.thread.finish();
}

#[test]
fn textures_are_timed_where_that_is_asked_for() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let texture = "fn userProc() -> f32 { return fract(readAttr(WorldPos).x); }\n";
    fs::write(stage.path("stripes.wgsl"), texture).expect("written");
    let look = LOOK.replace("0.5 ", "'bands' ") + "\n[node.bands]\ntexture = 'stripes'\n";
    fs::write(stage.path("scene.look.toml"), look).expect("written");
    let changes = Changes {
        look: true,
        textures: true,
        assets: false,
    };
    stage.changes.send(changes).expect("it listens");
    stage.wait("driven roughness", |stage| {
        let status = stage.harness.state().status();
        !status.is_building && status.pipelines > 0 && status.problems.is_empty()
    });
    stage.thread.link.send(Command::TimePasses(true));
    stage.wait("times", |stage| {
        let textures = &stage.harness.state().status().textures;
        textures.is_done && !textures.list.is_empty()
    });
    let textures = stage.harness.state().status().textures.list.clone();
    assert_eq!(textures[0].name, "bands");
    assert_eq!(textures[0].texture.as_deref(), Some("stripes"));
    assert!(textures[0].runs_per_pixel > 0.0 && textures[0].runs_per_pixel < 1.0);

    // What a texture does wrong is told, with its node.
    let texture = "fn userProc() -> f32 { return 1.0 / floor(0.0 * readAttr(WorldPos).x); }\n";
    fs::write(stage.path("stripes.wgsl"), texture).expect("written");
    let textures = Changes {
        textures: true,
        ..Changes::default()
    };
    stage.changes.send(textures).expect("it listens");
    stage.wait("doubts", |stage| {
        let doubts = &stage.harness.state().status().doubts;
        doubts.contains("node `bands` (texture `stripes`)")
    });
    assert!(stage.harness.query_by_label("warning").is_some());
    let said = "node `bands` (texture `stripes`) gives values";
    stage.wait("message", |stage| {
        stage.harness.query_all_by_label_contains(said).count() == 1
    });
    stage.thread.finish();
}

#[test]
fn a_picked_material_is_named() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    stage.harness.get_by_label("Viewport").click();
    stage.wait("material", |stage| {
        stage.harness.state().material() == Some("Brass")
    });
    // Moving shows a picture of the new view, smaller or not, and then one of the whole size.
    let full = stage.harness.state().status().size;
    stage.harness.key_press(Key::Home);
    stage.thread.link.send(Command::View(None));
    stage.wait("picture", move |stage| {
        let status = stage.harness.state().status();
        status.size == full && status.spp >= 4.0
    });
    stage.thread.finish();
}

#[test]
fn pictures_lie_on_the_board_as_the_device_has_them() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let has_textures = stage.device.gpu().is_some();
    let whole = |stage: &Stage| {
        let status = stage.harness.state().status();
        status.spp >= 4.0 && status.is_whole
    };
    stage.wait("whole picture", whole);
    let pictures = |stage: &Stage| {
        let shown = stage.thread.link.board().shown.clone();
        shown.map(|shown| shown.pictures).unwrap_or_default()
    };
    // Where they are pixels, the mean of each channel but the last.
    let mean = |picture: &Option<Picture>| match picture {
        Some(Picture::Pixels(pixels)) => {
            assert!(!has_textures);
            let count = pixels.size[0] * pixels.size[1];
            assert_eq!(pixels.rgba.len(), 4 * count as usize);
            let (pixels, _) = pixels.rgba.as_chunks::<4>();
            let sum = |i: usize| pixels.iter().map(|pixel| f64::from(pixel[i])).sum::<f64>();
            assert_eq!(
                sum(3),
                255.0 * f64::from(count),
                "they hide what is behind them"
            );
            Some([0, 1, 2].map(|i| sum(i) / f64::from(count)))
        }
        Some(Picture::Here(_)) => {
            assert!(has_textures);
            None
        }
        None => panic!("there is no picture"),
    };
    let size = stage.harness.state().status().size;
    let [now, before, beside] = pictures(&stage);
    assert_eq!(now.as_ref().map(Picture::size), Some(size));
    assert_eq!((before, beside), (None, None));
    let white = mean(&now);

    // Compared with, the picture that was stays as it is.
    stage.thread.link.send(Command::KeepBefore(true));
    stage.edit(Edit::environment("color", Value::numbers(&[1.0, 0.0, 0.0])));
    stage.wait("picture in red", |stage| {
        let [now, before, _] = pictures(stage);
        before.is_some() && whole(stage) && mean(&now).is_none_or(|[_, green, _]| green == 0.0)
    });
    let [now, before, _] = pictures(&stage);
    let (red, kept) = (mean(&now), mean(&before));
    assert_eq!(before.as_ref().map(Picture::size), Some(size));
    if let (Some(white), Some(red), Some(kept)) = (white, red, kept) {
        assert!(white.iter().all(|&mean| mean > 50.0), "{white:?}");
        assert!(red[0] > 50.0 && red[2] == 0.0, "{red:?}");
        let differs = (0..3).any(|i| (kept[i] - white[i]).abs() > 1.0);
        assert!(!differs, "{kept:?} {white:?}");
    }
    stage.thread.link.send(Command::KeepBefore(false));

    // What lies beside the region stays, too.
    stage
        .thread
        .link
        .send(Command::Region(Some([0.0, 0.0, 0.5, 1.0])));
    stage.edit(Edit::environment("color", Value::numbers(&[0.0, 0.0, 1.0])));
    stage.wait("region in blue", |stage| {
        let [now, _, beside] = pictures(stage);
        let is_blue = |[_, _, blue]: [f64; 3]| blue > 50.0;
        beside.is_some() && mean(&now).is_none_or(is_blue)
    });
    if let (Some(beside), Some(red)) = (mean(&pictures(&stage)[2]), red) {
        assert_eq!(beside, red);
    }
    // While nothing changes, nothing is handed over again.
    stage.wait("end", |stage| stage.harness.state().status().spp >= 4.0);
    std::thread::sleep(Duration::from_millis(200));
    let number = || {
        stage
            .thread
            .link
            .board()
            .shown
            .as_ref()
            .map(|shown| shown.number)
    };
    let last = number();
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(number(), last);
    stage.thread.finish();
}

#[test]
fn a_window_that_cannot_be_drawn_any_more_ends_the_render_and_keeps_the_edits() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    stage.edit(Edit::material("Brass", "roughness", Value::number(0.25)));
    for why in ["the window is gone", "it is still gone"] {
        stage.thread.link.send(Command::Abandon(why.to_owned()));
    }
    stage.wait("message", |stage| {
        stage.harness.state().status().fatal.is_some()
    });
    let fatal = stage.harness.state().status().fatal.clone();
    let fatal = fatal.expect("it has just been there");
    assert!(fatal.starts_with("the window is gone\n"), "{fatal}");
    assert!(fatal.contains("scene.look.toml.recovered"), "{fatal}");
    let recovered = stage.read("scene.look.toml.recovered");
    assert_eq!(recovered, LOOK.replace("0.5 ", "0.25 "));
    stage.thread.finish();
}

#[test]
fn a_program_that_is_to_end_keeps_the_edits() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    stage.edit(Edit::material("Brass", "roughness", Value::number(0.25)));
    fs::write(stage.path("scene.look.toml.recovered"), "older").expect("written");
    stage.ending.store(true, Ordering::SeqCst);
    stage.thread.link.send(Command::LookForChanges);
    stage.wait("end", |stage| stage.harness.state().status().is_ending);
    let kept = stage.read("scene.look.toml.recovered-2");
    assert_eq!(kept, LOOK.replace("0.5 ", "0.25 "));
    assert_eq!(stage.read("scene.look.toml.recovered"), "older");
    stage.thread.finish();
}

#[test]
fn a_fault_of_the_program_ends_the_render_and_keeps_the_edits() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    stage.edit(Edit::material("Brass", "roughness", Value::number(0.25)));
    let fault = PictureOrder {
        path: stage.path(FAULT),
        size: [8, 8],
        spp: 1,
        layers: false,
        denoised: false,
        view: View::default(),
    };
    stage.thread.link.send(Command::SavePicture(fault));
    stage.wait("message", |stage| {
        stage.harness.state().status().fatal.is_some()
    });
    let fatal = stage.harness.state().status().fatal.clone();
    let fatal = fatal.expect("it has just been there");
    assert!(fatal.contains("as if there were a fault"), "{fatal}");
    assert!(fatal.contains("scene.look.toml.recovered"), "{fatal}");
    let kept = |stage: &Stage| stage.read("scene.look.toml.recovered");
    assert_eq!(kept(&stage), LOOK.replace("0.5 ", "0.25 "));
    assert_eq!(stage.read("scene.look.toml"), LOOK, "the file is as it was");
    // What is done from then on is kept as well.
    let document = stage.harness.state_mut().document_mut().expect("read");
    let edit = Edit::material("Brass", "roughness", Value::number(0.75));
    document.apply("test", &[edit], None).expect("a look");
    stage.wait("later edit", |stage| {
        kept(stage) == LOOK.replace("0.5 ", "0.75 ")
    });
    // And files that are opened again are rendered.
    let files = Files {
        scene: stage.path("scene.gltf"),
        look: Some(stage.path("scene.look.toml")),
        camera: None,
    };
    stage.thread.link.send(Command::Open(files));
    stage.wait("a picture", |stage| {
        let status = stage.harness.state().status();
        status.fatal.is_none() && status.spp >= 4.0
    });
    stage.thread.finish();
}

#[test]
fn a_lost_device_ends_the_render_and_keeps_the_edits() {
    // The processor is never lost.
    let Some(mut stage) = Stage::on(&DeviceChoice::Driver, LOOK, 4) else {
        return;
    };
    stage.wait("a picture", |stage| {
        stage.harness.state().status().spp >= 4.0
    });
    // More than will be done before the device is gone.
    stage.thread.link.send(Command::Target(1 << 20));
    stage.edit(Edit::material("Brass", "roughness", Value::number(0.25)));
    stage.device.gpu().expect("a driver").device().destroy();
    stage.wait("message", |stage| {
        stage.harness.state().status().fatal.is_some()
    });
    let fatal = stage.harness.state().status().fatal.clone();
    let fatal = fatal.expect("it has just been there");
    assert!(fatal.contains("lost"), "{fatal}");
    assert!(fatal.contains("scene.look.toml.recovered"), "{fatal}");
    stage.harness.run_steps(3);
    assert!(stage.harness.query_by_label(fatal.trim_end()).is_some());
    let recovered = stage.read("scene.look.toml.recovered");
    assert_eq!(recovered, LOOK.replace("0.5 ", "0.25 "));
    assert_eq!(stage.read("scene.look.toml"), LOOK, "the file is as it was");

    // Whatever is asked for is answered or left alone, and nothing hangs or panics.
    let picture = stage.path("a.png");
    for command in [
        Command::View(None),
        Command::Size([64, 36]),
        Command::KeepBefore(true),
        Command::Pick(glam::Vec2::splat(0.5), PickPurpose::Material),
        Command::TimePasses(true),
        Command::Save(None, 0),
        Command::SavePicture(PictureOrder {
            path: picture,
            size: [8, 8],
            spp: 1,
            layers: false,
            denoised: false,
            view: View::default(),
        }),
    ] {
        stage.thread.link.send(command);
    }
    stage.harness.key_press(Key::F);
    stage.harness.run_steps(3);
    let Stage { thread, .. } = stage;
    thread.finish();
}
