//! The window's contents with a render behind them: what is done by labels ends up in pictures and files. Skipped where
//! there is no device.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use device::{Device, DeviceChoice};
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use engine::film::{Film, Origin};
use engine::scene::look::Value;
use engine::scene::view::ViewChoice;
use engine::session::Edit;
use patina_viewer::host::{Changes, Host};
use patina_viewer::link::{Command, Files, PickPurpose};
use patina_viewer::thread::{RenderOptions, RenderThread};
use patina_viewer::viewer::{Preferences, Viewer};
use tempfile::TempDir;

/// A triangle and a camera in front of it.
const SCENE: &str = r#"{
  "asset": { "version": "2.0" },
  "scene": 0,
  "scenes": [{ "nodes": [0, 1] }],
  "nodes": [{ "mesh": 0 }, { "name": "View", "camera": 0, "translation": [0, 0, 3] }],
  "cameras": [{ "name": "View", "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }],
  "materials": [{ "name": "Brass" }],
  "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
  "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0] }],
  "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
  "buffers": [{ "byteLength": 36, "uri": "triangle.bin" }]
}"#;
const LOOK: &str = "# Light from everywhere.\nenvironment = { color = [1, 1, 1], intensity = 1.0 } # white\n\n[material.Brass] # of a lamp\nroughness = 0.5   # worn\n";

/// A host whose files change when the test says so, and that writes names instead of pictures.
struct TestHost {
    changes: std::sync::mpsc::Receiver<Changes>,
    textures: PathBuf,
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

    fn write_film(&self, path: &Path, film: &Film, _: &Origin) -> Result<(), String> {
        let text = format!("film of {} x {}", film.width, film.height);
        fs::write(path, text).map_err(|error| error.to_string())
    }

    fn write_shown(
        &self,
        path: &Path,
        [width, height]: [u32; 2],
        rgba: &[u8],
    ) -> Result<(), String> {
        assert_eq!(rgba.len(), (width * height * 4) as usize);
        let bright = rgba.iter().any(|byte| (1..255).contains(byte));
        assert!(bright, "a picture has some colour in it");
        fs::write(path, format!("picture of {width} x {height}")).map_err(|error| error.to_string())
    }
}

struct Stage {
    device: Device,
    folder: TempDir,
    harness: Harness<'static, Viewer>,
    thread: RenderThread,
    changes: std::sync::mpsc::Sender<Changes>,
}

impl Stage {
    fn new() -> Option<Self> {
        let device = match Device::open(&DeviceChoice::Driver) {
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
        fs::write(path("scene.look.toml"), LOOK).expect("written");
        let files = Files {
            scene: path("scene.gltf"),
            look: Some(path("scene.look.toml")),
            camera: None,
        };
        let options = RenderOptions {
            target_spp: 4,
            max_depth: 2,
            seed: 0,
            size: [32, 18],
        };
        let (sender, changes) = std::sync::mpsc::channel();
        let textures = folder.path().to_owned();
        let host = Box::new(TestHost { changes, textures });
        let thread =
            RenderThread::start(device.clone(), Some(files), options, host, Box::new(|| {}));
        let thread = thread.expect("a thread");
        let preferences = Preferences {
            // Small pictures are enough.
            coarseness: 8,
            ..Preferences::default()
        };
        let viewer = Viewer::new(thread.link.clone(), preferences, ViewChoice::default());
        let harness = Harness::builder()
            .with_size([900.0, 400.0])
            .build_ui_state(|ui, viewer: &mut Viewer| viewer.ui(ui), viewer);
        let mut stage = Self {
            device,
            folder,
            harness,
            thread,
            changes: sender,
        };
        stage.wait("a picture", |stage| {
            stage.harness.state().status().spp >= 4.0
        });
        Some(stage)
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
    let size = status.size;

    for (name, expected) in [("a.png", "picture"), ("a.exr", "film")] {
        let path = stage.path(name);
        stage.thread.link.send(Command::SavePicture(path));
        let name = name.to_owned();
        stage.wait("written picture", move |stage| {
            !stage.read(&name).is_empty()
        });
        let text = stage.read(if expected == "film" { "a.exr" } else { "a.png" });
        assert_eq!(text, format!("{expected} of {} x {}", size[0], size[1]));
    }
    stage.thread.finish();
}

#[test]
fn mistakes_in_files_are_shown_until_they_are_mended() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let change = Changes {
        look: true,
        ..Changes::default()
    };
    let wrong = LOOK.replace("roughness", "rouhgness");
    fs::write(stage.path("scene.look.toml"), wrong).expect("written");
    stage.changes.send(change.clone()).expect("heard");
    stage.wait("problem", |stage| {
        !stage.harness.state().status().problems.is_empty()
    });
    let problems = stage.harness.state().status().problems.clone();
    assert!(problems.contains("scene.look.toml:5:"), "{problems}");
    assert!(stage.harness.query_by_label(problems.trim_end()).is_some());
    fs::write(stage.path("scene.look.toml"), LOOK).expect("written");
    stage.changes.send(change).expect("heard");
    stage.wait("mended look", |stage| {
        stage.harness.state().status().problems.is_empty()
    });

    // Saving under another name leaves the first file alone.
    stage.edit(Edit::material("Brass", "metallic", Value::number(0.0)));
    stage
        .thread
        .link
        .send(Command::Save(Some(stage.path("other.look.toml"))));
    stage.wait("other look", |stage| {
        stage.read("other.look.toml").contains("metallic")
    });
    assert_eq!(stage.read("scene.look.toml"), LOOK);
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
fn a_lost_device_ends_the_render_and_keeps_the_edits() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
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
        Command::Save(None),
        Command::SavePicture(picture),
    ] {
        stage.thread.link.send(command);
    }
    stage.harness.key_press(Key::F);
    stage.harness.run_steps(3);
    let Stage { thread, .. } = stage;
    thread.finish();
}
