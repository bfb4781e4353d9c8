//! Lights mixed in the window: what the panel sends, and, with a render behind it, that what is shown follows without another sample.
//! What needs a device is skipped where there is none.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use device::{Device, DeviceChoice};
use egui::Event;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use engine::denoise::{self, Denoiser};
use engine::film::{Film, LightMix};
use engine::scene::view::{View, ViewChoice};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use patina_viewer::host::{Changes, Finished, Host, OpenDenoiser};
use patina_viewer::link::{
    Board, Command, Denoise, DenoiserState, Files, Link, LookFacts, PictureOrder, SceneFacts,
    Shown, Waker,
};
use patina_viewer::picture::Picture;
use patina_viewer::thread::{RenderOptions, RenderThread};
use patina_viewer::viewer::{Preferences, Viewer};
use tempfile::TempDir;

#[path = "../../panels/tests/panel/picture.rs"]
mod picture;

/// A triangle that glows before an environment, and a camera.
const SCENE: &str = r#"{
  "asset": { "version": "2.0" },
  "scene": 0,
  "scenes": [{ "nodes": [0, 1] }],
  "nodes": [{ "mesh": 0 }, { "name": "View", "camera": 0, "translation": [0, 0, 3] }],
  "cameras": [{ "name": "View", "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
  "materials": [{ "name": "Screen", "emissiveFactor": [0.5, 0.25, 0.05] }],
  "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
  "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0] }],
  "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
  "buffers": [{ "byteLength": 36, "uri": "triangle.bin" }]
}"#;

/// The look with a colour of the environment and one of the screen.
fn look(day: [f32; 3], screen: [f32; 3]) -> String {
    format!(
        "environment = {{ color = {day:?}, group = \"day\" }}\n\n[material.Screen]\nemission = {screen:?}\ngroup = \"screen\"\n"
    )
}

const DAY: [f32; 3] = [0.1, 0.2, 0.4];
const SCREEN: [f32; 3] = [0.5, 0.25, 0.05];
const DARK: [f32; 3] = [0.0; 3];
const SPP: u32 = 4;
/// Pixels before the window has asked for its own.
const FIRST: [u32; 2] = [8, 8];

/// Keeps the film of the last picture that was written.
struct TestHost(Arc<Mutex<Option<Film>>>);

impl Host for TestHost {
    fn texture_folders(&self, _: Option<&Path>) -> Result<Vec<PathBuf>, String> {
        Ok(Vec::new())
    }

    fn watch(&mut self, _: &[PathBuf], _: Option<&Path>, _: &[PathBuf]) -> Result<(), String> {
        Ok(())
    }

    fn changes(&mut self) -> Changes {
        Changes::default()
    }

    fn wake_by(&mut self, _: Waker) {}

    fn patience(&self) -> Duration {
        Duration::from_millis(10)
    }

    fn report(&self, text: &str) {
        panic!("{text}");
    }

    fn denoiser(&self) -> OpenDenoiser {
        Box::new(|| {
            let folder = std::env::var_os("OIDN_DIR").ok_or("OIDN_DIR doesn't say where it is")?;
            let library = Path::new(&folder).join("lib").join(denoise::FILE);
            Denoiser::open(&library).map_err(|error| error.to_string())
        })
    }

    fn recent(&self) -> Vec<Files> {
        Vec::new()
    }

    fn keep_recent(&self, _: &[Files]) -> Result<(), String> {
        Ok(())
    }

    fn check_picture(&self, _: &Path) -> Result<(), String> {
        Ok(())
    }

    fn write_picture(&self, _: &Path, picture: &Finished<'_>) -> Result<(), String> {
        *self.0.lock().expect("no panic") = Some(picture.film.clone());
        Ok(())
    }
}

struct Stage {
    device: Device,
    _folder: TempDir,
    harness: Harness<'static, Viewer>,
    thread: RenderThread,
    written: Arc<Mutex<Option<Film>>>,
}

impl Stage {
    fn new(look: &str) -> Option<Self> {
        let name = std::env::var("PATINA_DEVICE");
        let choice = name.map_or(DeviceChoice::Best, DeviceChoice::Name);
        let device = match Device::open(&choice) {
            Ok(device) => device,
            Err(error) => {
                let is_required = std::env::var_os("PATINA_REQUIRE_DEVICE").is_some();
                assert!(!is_required, "{error}");
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
            target_spp: SPP,
            // Only what is seen itself: without noise pictures can be compared.
            max_depth: 0,
            seed: 0,
            size: FIRST,
        };
        let written = Arc::default();
        let host = Box::new(TestHost(Arc::clone(&written)));
        let wake = Box::new(|| {});
        let thread = RenderThread::start(device.clone(), Some(files), options, host, wake);
        let thread = thread.expect("a thread");
        let preferences = Preferences {
            coarseness: 8,
            denoises: false,
            ..Preferences::default()
        };
        let viewer = Viewer::new(thread.link.clone(), preferences, ViewChoice::default());
        let harness = Harness::builder()
            // The figures stay in one line: with another one the picture would have another size.
            .with_size([2000.0, 400.0])
            .build_ui_state(|ui, viewer: &mut Viewer| viewer.ui(ui), viewer);
        let mut stage = Self {
            device,
            _folder: folder,
            harness,
            thread,
            written,
        };
        stage.wait("a picture", Self::is_done);
        Some(stage)
    }

    fn is_done(&self) -> bool {
        let status = self.harness.state().status();
        status.spp >= f64::from(SPP) && status.is_whole && status.size != FIRST
    }

    /// Frame by frame, until something is so.
    fn wait(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let end = Instant::now() + Duration::from_secs(60);
        while !is_so(self) {
            let status = self.harness.state().status();
            assert!(Instant::now() < end, "no {what}: {status:?}");
            self.harness.run_steps(1);
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.harness.run_steps(2);
    }

    fn shown(&self) -> Shown {
        let shown = self.thread.link.board().shown.clone();
        shown.expect("there is a picture")
    }

    fn now(&self) -> Vec<u8> {
        let [now, ..] = self.shown().pictures;
        self.read(&now.expect("it is shown"))
    }

    /// What becomes of a picture, of which no further sample is taken meanwhile.
    fn after(&mut self, former: &[u8]) -> Vec<u8> {
        self.wait("other picture", |stage| {
            assert!(stage.is_done(), "nothing begins anew");
            stage.now() != former
        });
        self.now()
    }

    /// RGBA of what is shown.
    fn read(&self, picture: &Picture) -> Vec<u8> {
        let view = match picture {
            Picture::Here(view) => view,
            Picture::Pixels(pixels) => return pixels.rgba.clone(),
        };
        let gpu = self.device.gpu().expect("a driver");
        let texture = view.texture();
        let (width, height) = (texture.width(), texture.height());
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row * height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let copy = wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), copy, texture.size());
        gpu.queue().submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        let waited = gpu.device().poll(wgpu::PollType::wait_indefinitely());
        waited.expect("read");
        let bytes = buffer.slice(..).get_mapped_range().expect("mapped");
        let rows = bytes.chunks(row as usize);
        rows.flat_map(|bytes| bytes[..4 * width as usize].to_vec())
            .collect()
    }

    /// The film of a picture as it is written.
    fn save(&mut self, name: &str) -> Film {
        let order = PictureOrder {
            path: PathBuf::from(name),
            size: self.harness.state().status().size,
            spp: SPP,
            layers: false,
            denoised: false,
            view: View::default(),
        };
        self.thread.link.send(Command::SavePicture(order));
        self.wait("written picture", |stage| {
            stage.written.lock().expect("no panic").is_some()
        });
        let film = self.written.lock().expect("no panic").take();
        film.expect("it has come")
    }
}

fn is_close(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1)
}

fn assert_close(a: &[u8], b: &[u8]) {
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(off <= Some(1), "{off:?} of 255 off");
}

fn press_l(harness: &mut Harness<'_, Viewer>) {
    harness.event(Event::Text("l".to_owned()));
    harness.run_steps(2);
}

#[test]
fn what_is_shown_follows_the_mix_without_another_sample() {
    let Some(mut stage) = Stage::new(&look(DAY, SCREEN)) else {
        return;
    };
    let both = stage.now();
    press_l(&mut stage.harness);
    stage.wait("groups that are kept apart", |stage| {
        stage.harness.state().status().keeps_groups && stage.is_done()
    });
    assert!(stage.now() == both, "the picture is the same");
    let made = stage.device.counts().pipelines;
    stage.click("day");
    let screen = stage.after(&both);
    // It is kept, to compare with, as it is mixed now.
    stage.thread.link.send(Command::KeepBefore(true));
    stage.wait("picture to compare with", |stage| {
        stage.shown().pictures[1].is_some()
    });
    let made_by_comparison = stage.device.counts().pipelines;
    stage.click("day");
    assert!(stage.after(&screen) == both);
    stage.click("Solo day");
    let day = stage.after(&both);
    assert_eq!(stage.device.counts().pipelines, made_by_comparison);
    let [_, before, _] = stage.shown().pictures;
    let before = before.expect("kept");
    assert!(stage.read(&before) == screen, "its mix stays");
    stage.thread.link.send(Command::KeepBefore(false));
    // Pictures are written as they are shown, radiance as it is rendered; neither has groups that nobody asked for.
    let rendered = stage.save("a.exr");
    let mixed = stage.save("a.png");
    assert!(rendered.layers().is_picture_alone() && mixed.layers().is_picture_alone());
    let center = rendered.pixels() / 2 + rendered.width as usize / 2;
    assert!(rendered.mean()[center][0] > 0.4);
    assert!(mixed.mean()[center][0] < 1e-6);
    stage.click("Reset");
    assert!(stage.after(&day) == both);
    assert!(made_by_comparison >= made);
    stage.thread.finish();
    for (look, expected) in [(look(DARK, SCREEN), &screen), (look(DAY, DARK), &day)] {
        let alone = Stage::new(&look).expect("as before");
        assert_close(&alone.now(), expected);
        alone.thread.finish();
    }
}

#[test]
fn noise_is_taken_out_of_what_is_mixed() {
    let Some(mut stage) = Stage::new(&look(DAY, SCREEN)) else {
        return;
    };
    let state = |stage: &Stage| stage.harness.state().status().denoiser.clone();
    stage.wait("answer", |stage| state(stage) != DenoiserState::Unknown);
    if let DenoiserState::Absent(why) = state(&stage) {
        eprintln!("skipped: {why}");
        return stage.thread.finish();
    }
    press_l(&mut stage.harness);
    stage.wait("groups that are kept apart", |stage| {
        stage.harness.state().status().keeps_groups && stage.is_done()
    });
    let both = stage.now();
    stage.click("day");
    let screen = stage.after(&both);
    stage.thread.link.send(Command::Denoise(Denoise::Always));
    let is_clean = |stage: &Stage| stage.harness.state().status().denoised.is_some();
    stage.wait("picture without noise", is_clean);
    assert_alike(&stage.now(), &screen);
    // Another mix is shown as it is until there is one of it.
    stage.click("day");
    stage.wait("mix with noise", |stage| !is_clean(stage));
    assert_alike(&stage.now(), &both);
    stage.wait("mix without noise", is_clean);
    assert_alike(&stage.now(), &both);
    assert!(stage.is_done(), "nothing began anew");
    stage.thread.finish();
}

/// On average: of edges the denoiser has views of its own.
fn assert_alike(a: &[u8], b: &[u8]) {
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)));
    let mean = off.sum::<f64>() / a.len() as f64;
    assert!(mean < 2.0, "{mean} of 255 off");
}

/// A window whose render does nothing.
fn idle(
    groups: &[&str],
) -> (
    Harness<'static, Viewer>,
    Receiver<Command>,
    picture::Painter,
) {
    let (sender, commands) = channel();
    let board = Board {
        scene: Arc::new(SceneFacts {
            light_groups: groups.iter().map(|&name| name.to_owned()).collect(),
            ..SceneFacts::default()
        }),
        look: Some(LookFacts::default()),
        ..Board::default()
    };
    let link = Link::new(sender, Arc::new(Mutex::new(board)));
    link.board().status.keeps_groups = true;
    let viewer = Viewer::new(link, Preferences::default(), ViewChoice::default());
    let painter = picture::Painter::default();
    let mut harness = Harness::builder()
        .with_size([1100.0, 420.0])
        .renderer(painter.clone())
        .build_ui_state(|ui, viewer: &mut Viewer| viewer.ui(ui), viewer);
    harness.run_steps(3);
    (harness, commands, painter)
}

fn sent(commands: &Receiver<Command>) -> Vec<Option<LightMix>> {
    let mixes = commands.try_iter().filter_map(|command| match command {
        Command::MixLights(mix) => Some(mix),
        _ => None,
    });
    mixes.collect()
}

fn mix(factors: &[(&str, [f32; 3])]) -> Option<LightMix> {
    let mut mix = LightMix::default();
    for (name, factor) in factors {
        mix.set(name, *factor);
    }
    Some(mix)
}

#[test]
fn faders_send_what_they_say() {
    let (mut harness, commands, painter) = idle(&["key", "day"]);
    // Nothing is kept apart before it is asked for.
    assert_eq!(sent(&commands), [None]);
    let click = |harness: &mut Harness<'_, Viewer>, label: &str| {
        harness.get_by_label(label).click();
        harness.run_steps(3);
        sent(&commands)
    };
    let (on, off) = ([1.0; 3], DARK);
    let neutral = mix(&[("key", on), ("day", on), ("rest", on)]);
    assert_eq!(
        click(&mut harness, "Light mix"),
        std::slice::from_ref(&neutral)
    );
    let expected = mix(&[("key", off), ("day", on), ("rest", on)]);
    assert_eq!(click(&mut harness, "key"), [expected]);
    let expected = mix(&[("key", off), ("day", on), ("rest", off)]);
    assert_eq!(click(&mut harness, "Solo day"), [expected]);
    harness.remove_cursor();
    harness.run_steps(4);
    check(&painter.paint(&harness), "mix");
    // Closed, it goes on.
    assert_eq!(click(&mut harness, "Close"), []);
    assert!(harness.query_by_label("Solo day").is_none());
    assert_eq!(click(&mut harness, "Light mix"), []);
    assert_eq!(click(&mut harness, "Reset"), [neutral]);
    press_l(&mut harness);
    assert!(harness.query_by_label("Reset").is_none());
}

#[test]
fn a_mix_becomes_what_the_lights_give() {
    let Some(mut stage) = Stage::new(&look(DAY, SCREEN)) else {
        return;
    };
    press_l(&mut stage.harness);
    stage.wait("groups that are kept apart", |stage| {
        stage.harness.state().status().keeps_groups && stage.is_done()
    });
    let both = stage.now();
    let is_grey = |stage: &Stage| {
        let button = stage.harness.get_by_label("To the lights");
        button.accesskit_node().is_disabled()
    };
    assert!(is_grey(&stage), "nothing is mixed");
    stage.click("day");
    let screen = stage.after(&both);
    assert!(!is_grey(&stage));
    stage.click("To the lights");
    let text = |stage: &mut Stage| {
        let document = stage.harness.state_mut().document_mut();
        document.expect("a look").text().to_owned()
    };
    let written = text(&mut stage);
    assert!(written.contains("intensity = 0.0"), "{written}");
    assert!(is_grey(&stage), "the faders are as they were");
    stage.wait("the same picture", |stage| {
        stage.is_done() && is_close(&stage.now(), &screen)
    });
    // One step back, and all is as it was.
    stage
        .harness
        .state_mut()
        .document_mut()
        .expect("a look")
        .undo();
    assert_eq!(text(&mut stage), look(DAY, SCREEN));
    stage.wait("the picture of before", |stage| {
        stage.is_done() && is_close(&stage.now(), &both)
    });
    stage.thread.finish();
}

#[test]
fn without_groups_it_is_said_how_to_make_them() {
    let (mut harness, commands, _) = idle(&[]);
    press_l(&mut harness);
    assert!(harness.query_by_label_contains("group = \"key\"").is_some());
    assert_eq!(sent(&commands), [None], "nothing is kept apart");
}

/// As the panels' snapshots: `UPDATE_SNAPSHOTS=1` writes it anew.
fn check(picture: &image::RgbImage, name: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/snapshots/{name}.png"));
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
        let file = fs::File::create(file).expect("a file");
        let small = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::NoFilter);
        return picture.write_with_encoder(small).expect("written");
    }
    let kept = image::open(&file).expect("a picture").to_rgb8();
    assert_eq!(picture.dimensions(), kept.dimensions());
    let differ = |(a, b): &(&image::Rgb<u8>, &image::Rgb<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 24)
    };
    let differing = picture.pixels().zip(kept.pixels()).filter(differ).count();
    let share = differing as f64 / picture.pixels().len() as f64;
    // Not all processors round alike.
    if share > 0.002 {
        let seen = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
        picture.save(&seen).expect("written");
        panic!("{:.2} % differ: see {}", 100.0 * share, seen.display());
    }
}
