//! The window's contents, driven by labels as a user and a screen reader find them; no window and no GPU.

mod camera;
mod dropped;
mod files;
mod panels;
mod picture;

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};

use egui::{Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use engine::scene::view::ViewChoice;
use engine::scene::{Camera, Scene, default_camera};
use patina_viewer::link::{Board, Command, Files, Hit, Link, LookFacts, Reply, SceneFacts};
use patina_viewer::viewer::{Preferences, Viewer};

/// A window whose render does nothing: commands are read, and the board is written, by the test.
struct Stage {
    harness: Harness<'static, Viewer>,
    commands: Receiver<Command>,
    board: Arc<Mutex<Board>>,
}

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("nobody asks".to_owned())
    }
}

fn camera(name: &str) -> Camera {
    Camera {
        name: name.to_owned(),
        ..default_camera(&Scene::default())
    }
}

impl Stage {
    fn new() -> Self {
        let (sender, commands) = channel();
        let board = Arc::new(Mutex::new(Board::default()));
        board.lock().unwrap().scene = Arc::new(SceneFacts {
            files: Files {
                scene: PathBuf::from("scenes/lamp.glb"),
                look: Some(PathBuf::from("scenes/lamp.look.toml")),
                camera: None,
            },
            cameras: vec![camera("Door"), camera("Window")],
            look_camera: Some(camera("Door")),
            end: None,
            light_groups: Vec::new(),
        });
        board.lock().unwrap().look = Some(LookFacts::default());
        let link = Link::new(sender, Arc::clone(&board));
        let viewer = Viewer::new(link, Preferences::default(), ViewChoice::default());
        let mut harness = Harness::builder()
            .with_size([1280.0, 720.0])
            .build_ui_state(|ui, viewer: &mut Viewer| viewer.ui(ui), viewer);
        harness.run_steps(3);
        let stage = Self {
            harness,
            commands,
            board,
        };
        stage.sent();
        stage
    }

    fn sent(&self) -> Vec<Command> {
        self.commands.try_iter().collect()
    }

    fn reply(&mut self, reply: Reply) {
        self.board.lock().unwrap().replies.push(reply);
        self.harness.run_steps(2);
    }

    fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(2);
    }

    fn type_text(&mut self, text: &str) {
        self.harness.event(Event::Text(text.to_owned()));
        self.harness.run_steps(2);
    }

    fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.harness.run_steps(3);
    }

    /// Presses, moves in steps and lets go.
    fn drag(&mut self, start: Pos2, end: Pos2, button: PointerButton) {
        let event = |pos, pressed| Event::PointerButton {
            pos,
            button,
            pressed,
            modifiers: Modifiers::NONE,
        };
        self.harness.event(Event::PointerMoved(start));
        self.harness.event(event(start, true));
        self.harness.run_steps(1);
        for step in 1..=4 {
            let at = start.lerp(end, step as f32 / 4.0);
            self.harness.event(Event::PointerMoved(at));
            self.harness.run_steps(1);
        }
        self.harness.event(event(end, false));
        self.harness.run_steps(2);
    }

    /// Lets go of files over the picture.
    fn drop_files(&mut self, paths: &[&str]) {
        let center = self.center();
        self.harness.event(Event::PointerMoved(center));
        let files = paths
            .iter()
            .map(|path| Arc::new(Dropped(path.into())) as egui::DroppedFileHandle);
        self.harness.input_mut().dropped_files = files.collect();
        self.harness.run_steps(2);
    }

    fn center(&self) -> Pos2 {
        self.harness.get_by_label("Viewport").rect().center()
    }
}

/// A surface that is clicked, so far from the camera's plane.
fn brass(depth: f32) -> Hit {
    Hit {
        material: "Brass".to_owned(),
        depth,
        position: glam::Vec3::new(1.0, 0.0, 2.0),
        normal: glam::Vec3::Y,
    }
}
