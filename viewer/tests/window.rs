//! The window's contents, driven by labels as a user and a screen reader find them; no window and no GPU.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use engine::display::Channel;
use engine::renderer::{TextureCost, TextureCosts};
use engine::scene::look::Value;
use engine::scene::view::{ViewChoice, ViewTransform};
use engine::scene::{Camera, Projection, Scene, default_camera};
use engine::session::Edit;
use engine::stats::PassStats;
use patina_viewer::link::{
    Board, Command, Denoise, DenoiserState, Extent, Files, Hit, Link, LookFacts, NOISY,
    PickPurpose, Reply, SceneFacts,
};
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

#[test]
fn the_exposure_slider_brightens_the_picture() {
    let mut stage = Stage::new();
    let slider = stage
        .harness
        .get_by_role_and_label(Role::Slider, "Exposure");
    let rect = slider.rect();
    let start = rect.center();
    stage.drag(
        start,
        start + egui::vec2(0.3 * rect.width(), 0.0),
        PointerButton::Primary,
    );
    let exposures: Vec<f32> = (stage.sent().iter())
        .filter_map(|command| match command {
            Command::Display(settings) => Some(settings.view.exposure),
            _ => None,
        })
        .collect();
    assert!(
        exposures.last().is_some_and(|stops| *stops > 1.0),
        "{exposures:?}"
    );
    let kept = stage.harness.state().preferences.exposure;
    assert_eq!(Some(&kept), exposures.last());
    // Keys change it in quarters of a stop, and back to nothing.
    stage.type_text("0");
    stage.type_text("]");
    assert_eq!(stage.harness.state().preferences.exposure, 0.25);
}

#[test]
fn what_the_look_says_of_the_view_is_shown_and_edited_there() {
    let mut stage = Stage::new();
    let shown = |stage: &Stage| {
        let sent = stage.sent();
        let mut shown = sent.iter().filter_map(|command| match command {
            Command::Display(settings) => Some(settings.view),
            _ => None,
        });
        shown.next_back()
    };
    let edit = Edit::view("transform", Value::Text("agx".to_owned()));
    let document = stage.harness.state_mut().document_mut();
    let document = document.expect("there is a look");
    document.apply("view", &[edit], None).expect("an edit");
    stage.harness.run_steps(2);
    let view = shown(&stage).expect("it is told");
    assert_eq!(view.transform, ViewTransform::Agx);
    // Chosen above the picture, it is written where it was read; what the look doesn't say is the window's own.
    stage.click("View transform");
    stage.click("ACES 2.0");
    stage.type_text("]");
    let view = shown(&stage).expect("it is told");
    assert_eq!(
        (view.transform, view.exposure),
        (ViewTransform::Aces2, 0.25)
    );
    let viewer = stage.harness.state_mut();
    let text = viewer.document_mut().expect("there is a look").text();
    assert!(
        text.contains("aces2") && !text.contains("exposure"),
        "{text}"
    );
    assert_eq!(viewer.preferences.view, ViewTransform::default().name());
}

#[test]
fn noise_is_taken_out_where_there_is_something_that_does() {
    let mut stage = Stage::new();
    let state = |stage: &mut Stage, state: DenoiserState| {
        stage.board.lock().unwrap().status.denoiser = state;
        stage.harness.run_steps(3);
    };
    let is_disabled =
        |stage: &Stage| (stage.harness.get_by_label("Denoise").accesskit_node()).is_disabled();
    assert!(is_disabled(&stage), "it isn't known yet");
    state(&mut stage, DenoiserState::Absent("get it there".to_owned()));
    assert!(is_disabled(&stage));
    stage.type_text("n");
    stage.harness.get_by_label("Denoise").hover();
    stage.harness.run_steps(60);
    assert!(stage.harness.query_by_label("get it there").is_some());
    assert!(stage.sent().is_empty());
    state(&mut stage, DenoiserState::Ready("Denoiser 2".to_owned()));
    assert!(!is_disabled(&stage));
    stage.click("Denoise");
    assert!(matches!(
        stage.sent()[..],
        [Command::Denoise(Denoise::Never)]
    ));
    assert!(!stage.harness.state().preferences.denoises);
    stage.type_text("n");
    assert!(matches!(
        stage.sent()[..],
        [Command::Denoise(Denoise::Always)]
    ));
    assert!(stage.harness.state().preferences.denoises);
    // The levels between which it works by itself are told, and a right click has it do so again.
    stage.harness.get_by_label("Denoise").hover();
    stage.harness.run_steps(60);
    let levels = format!("{:.0} %", 100.0 * NOISY);
    assert!(stage.harness.query_by_label_contains(&levels).is_some());
    stage.harness.get_by_label("Denoise").click_secondary();
    stage.harness.run_steps(3);
    assert!(matches!(
        stage.sent()[..],
        [Command::Denoise(Denoise::ByItself)]
    ));
}

#[test]
fn the_question_mark_lists_shortcuts() {
    let mut stage = Stage::new();
    let title = "Keyboard and mouse";
    assert!(stage.harness.query_by_label("save the look").is_none());
    stage.type_text("?");
    assert!(stage.harness.query_all_by_label(title).count() > 0);
    assert!(stage.harness.query_by_label("save the look").is_some());
    stage.press(Modifiers::NONE, Key::Escape);
    assert!(stage.harness.query_by_label("save the look").is_none());
    stage.click("?");
    assert!(stage.harness.query_by_label("save the look").is_some());
}

#[test]
fn saving_has_keys_and_asks_for_a_file_where_there_is_none() {
    let mut stage = Stage::new();
    stage.press(Modifiers::COMMAND, Key::S);
    assert!(matches!(stage.sent()[..], [Command::Save(None)]));
    stage.press(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S);
    assert!(stage.harness.query_by_label("Save the look as").is_some());
    stage.press(Modifiers::NONE, Key::Enter);
    let sent = stage.sent();
    let [Command::Save(Some(path))] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert_eq!(path, &PathBuf::from("scenes/lamp.look.toml"));
    // A scene without a look.
    let mut facts = SceneFacts::clone(&stage.board.lock().unwrap().scene);
    facts.files.look = None;
    stage.board.lock().unwrap().scene = Arc::new(facts);
    stage.harness.run_steps(2);
    stage.press(Modifiers::COMMAND, Key::S);
    assert!(stage.harness.query_by_label("Save the look as").is_some());
    stage.click("Cancel");
    assert!(stage.sent().is_empty());
    stage.press(Modifiers::COMMAND, Key::E);
    stage.click("Save");
    assert!(
        matches!(&stage.sent()[..], [Command::SavePicture(order)] if order.path.as_os_str() == "lamp.png" && order.spp == 1)
    );
}

#[test]
fn dragging_moves_the_camera_and_home_brings_it_back() {
    let mut stage = Stage::new();
    let center = stage.center();
    let home = camera("Door").transform;
    for button in [
        PointerButton::Primary,
        PointerButton::Secondary,
        PointerButton::Middle,
    ] {
        stage.drag(center, center + egui::vec2(80.0, 40.0), button);
        let sent = stage.sent();
        let last = sent.iter().rev().find_map(|command| match command {
            Command::View(view) => Some(view.clone()),
            _ => None,
        });
        let Some(Some(moved)) = last else {
            panic!("{button:?}: {sent:?}");
        };
        assert_ne!(moved.transform, home);
        stage.press(Modifiers::NONE, Key::Home);
        assert!(matches!(stage.sent()[..], [Command::View(None)]));
    }
    // Flying, while a key is held.
    stage.harness.event(Event::PointerMoved(center));
    stage.harness.key_down(Key::W);
    stage.harness.run_steps(3);
    stage.harness.key_up(Key::W);
    stage.harness.run_steps(2);
    let views = stage.sent().len();
    assert!(views > 0);
    stage.harness.run_steps(2);
    assert!(stage.sent().is_empty(), "it stands still again");
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

#[test]
fn a_click_picks_and_with_command_focuses() {
    let mut stage = Stage::new();
    stage.harness.get_by_label("Viewport").click();
    stage.harness.run_steps(3);
    let sent = stage.sent();
    let [Command::Pick(place, PickPurpose::Material)] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert!((*place - glam::Vec2::splat(0.5)).length() < 0.01);
    let hit = Some(brass(3.0));
    stage.reply(Reply::Picked {
        purpose: PickPurpose::Material,
        hit: hit.clone(),
    });
    assert_eq!(stage.harness.state().material(), Some("Brass"));
    assert!(stage.harness.query_by_label("material: Brass").is_some());
    stage
        .harness
        .get_by_label("Viewport")
        .click_modifiers(Modifiers::COMMAND);
    stage.harness.run_steps(3);
    assert!(matches!(
        stage.sent()[..],
        [Command::Pick(_, PickPurpose::Focus)]
    ));
    stage.reply(Reply::Picked {
        purpose: PickPurpose::Focus,
        hit,
    });
    let sent = stage.sent();
    let [Command::View(Some(view))] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert_eq!(view.focus_distance, 3.0);
}

#[test]
fn regions_are_dragged_and_given_up() {
    let mut stage = Stage::new();
    stage.click("Region");
    let rect = stage.harness.get_by_label("Viewport").rect();
    let at = |x: f32, y: f32| rect.min + egui::vec2(x * rect.width(), y * rect.height());
    stage.drag(at(0.75, 0.5), at(0.25, 0.25), PointerButton::Primary);
    let sent = stage.sent();
    let [Command::Region(Some(region))] = &sent[..] else {
        panic!("{sent:?}");
    };
    for (is, expected) in region.iter().zip([0.25, 0.25, 0.75, 0.5]) {
        assert!((is - expected).abs() < 0.01, "{region:?}");
    }
    stage.type_text("r");
    assert!(matches!(stage.sent()[..], [Command::Region(None)]));
    stage.click("Compare");
    stage.type_text("c");
    assert!(matches!(
        stage.sent()[..],
        [Command::KeepBefore(true), Command::KeepBefore(false)]
    ));
}

#[test]
fn channels_and_cameras_are_chosen_from_lists() {
    let mut stage = Stage::new();
    stage.click("Channel");
    stage.click("Error");
    let chosen = stage.sent();
    assert!(
        matches!(&chosen[..], [Command::Display(d)] if d.channel == Channel::Error),
        "{chosen:?}"
    );
    stage.click("View transform");
    stage.click("Filmic");
    let chosen = stage.sent();
    assert!(
        matches!(&chosen[..], [Command::Display(d)] if d.view.transform == ViewTransform::Filmic),
        "{chosen:?}"
    );
    stage.click("Camera");
    stage.click("Window");
    let chosen = stage.sent();
    assert!(
        matches!(&chosen[..], [Command::View(Some(camera))] if camera.name == "Window"),
        "{chosen:?}"
    );
    stage.click("Camera");
    stage.click("Put into the look");
    let sent = stage.sent();
    let [Command::View(None), Command::Change(change, 1)] = &sent[..] else {
        panic!("{sent:?}");
    };
    for key in [
        "position",
        "look_at",
        "up",
        "focus_distance",
        "aperture_radius",
        "y_fov",
    ] {
        let line = format!("\n{key} = ");
        assert!(change.text().contains(&line), "{}", change.text());
    }
    assert!(change.text().starts_with("[camera]"));
    stage.press(Modifiers::COMMAND, Key::Z);
    let undone = stage.sent();
    assert!(
        matches!(&undone[..], [Command::Change(change, 2)] if change.text().is_empty()),
        "{undone:?}"
    );
}

#[test]
fn problems_are_shown_with_their_place_until_they_are_mended() {
    let mut stage = Stage::new();
    let text = "error: no definition in scope for `colour`\n  rust.wgsl:3:12";
    stage.board.lock().unwrap().status.problems = text.to_owned();
    stage.harness.run_steps(2);
    assert!(stage.harness.query_by_label(text).is_some());
    stage.board.lock().unwrap().status.problems.clear();
    stage.harness.run_steps(2);
    assert!(stage.harness.query_by_label(text).is_none());
    stage.reply(Reply::Failed("cannot write the look".to_owned()));
    assert!(
        stage
            .harness
            .query_by_label("cannot write the look")
            .is_some()
    );
}

#[test]
fn all_lines_of_a_problem_are_seen() {
    let mut stage = Stage::new();
    let text = (0..12).map(|line| format!("line {line}\n"));
    let text: String = text.collect();
    stage.board.lock().unwrap().status.problems = text.clone();
    stage.harness.run_steps(4);
    let lines = stage.harness.get_by_label(text.trim_end()).rect();
    let picture = stage.harness.get_by_label("Viewport").rect();
    assert!(
        lines.height() > 100.0 && lines.bottom() <= picture.bottom(),
        "{lines}"
    );
    let head = stage.harness.get_by_label("Hide").rect();
    assert!(
        head.bottom() <= lines.top() + 1.0,
        "{head} lies over {lines}"
    );
}

#[test]
fn a_graph_has_more_room_than_a_list() {
    let mut stage = Stage::new();
    let width = |stage: &Stage| stage.harness.get_by_label("Viewport").rect().width();
    let list = width(&stage);
    assert!(
        list > 900.0,
        "the panel has its usual width from the start: {list}"
    );
    stage.click("Graph");
    let graph = width(&stage);
    assert!((500.0..list - 200.0).contains(&graph), "{graph} of {list}");
    stage.click("List");
    assert_eq!(width(&stage), list);
}

#[test]
fn time_goes_on_once_a_moment_has_been_seen() {
    let mut stage = Stage::new();
    assert!(stage.harness.query_by_label("Play").is_none());
    let facts = SceneFacts {
        end: Some(2.0),
        ..(*stage.board.lock().unwrap().scene).clone()
    };
    stage.board.lock().unwrap().scene = Arc::new(facts);
    stage.harness.run_steps(2);
    stage.sent();
    let moments = |stage: &Stage| -> Vec<Option<f64>> {
        let sent = stage.sent().into_iter();
        sent.filter_map(|command| match command {
            Command::Moment(seconds) => Some(seconds),
            _ => None,
        })
        .collect()
    };
    stage.click("Play");
    assert_eq!(moments(&stage), [Some(0.0)], "no more until that is seen");
    stage.board.lock().unwrap().status.moment = Some(0.0);
    stage.harness.run_steps(3);
    let next = moments(&stage);
    assert!(
        matches!(next[..], [Some(seconds)] if seconds > 0.0 && seconds < 2.0),
        "{next:?}"
    );
    stage.click("At rest");
    assert_eq!(moments(&stage), [None]);
    stage.harness.run_steps(3);
    assert!(moments(&stage).is_empty(), "it plays no more");
}

#[test]
fn a_state_that_was_kept_is_compared_with_at_once() {
    let mut stage = Stage::new();
    stage.click("Snapshot A");
    let edit = Edit::material("Brass", "roughness", Value::number(0.25));
    let document = stage.harness.state_mut().document_mut().expect("read");
    document.apply("test", &[edit], None).expect("a look");
    stage.harness.run_steps(2);
    stage.sent();
    stage.harness.get_by_label("Snapshot A").click_secondary();
    stage.harness.run_steps(3);
    stage.click("Compare with A");
    let sent = stage.sent();
    let at = |is_it: &dyn Fn(&Command) -> bool| sent.iter().position(is_it);
    let kept = at(&|command| matches!(command, Command::KeepBefore(true)));
    let changed = at(&|command| matches!(command, Command::Change(..)));
    assert!(kept.is_some() && kept < changed, "{sent:?}");
}

#[test]
fn dropped_files_are_opened_used_or_refused() {
    let mut stage = Stage::new();
    stage.drop_files(&["/models/car.GLB", "/models/red.look.toml"]);
    let sent = stage.sent();
    let [Command::Open(files)] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert_eq!(files.scene, Path::new("/models/car.GLB"));
    assert_eq!(
        files.look.as_deref(),
        Some(Path::new("/models/red.look.toml"))
    );

    // A look alone is one for the scene that is there.
    stage.drop_files(&["/models/blue.look.toml"]);
    let sent = stage.sent();
    let [Command::Open(files)] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert_eq!(files.scene, Path::new("scenes/lamp.glb"));
    assert_eq!(
        files.look.as_deref(),
        Some(Path::new("/models/blue.look.toml"))
    );

    stage.drop_files(&["/textures/moss.wgsl"]);
    let sent = stage.sent();
    assert!(
        matches!(&sent[..], [Command::TextureFolder(folder)] if folder == Path::new("/textures")),
        "{sent:?}"
    );
    assert!(
        stage
            .harness
            .query_by_label_contains("textures of /textures")
            .is_some()
    );

    stage.drop_files(&["/skies/noon.hdr"]);
    let sent = stage.sent();
    let [Command::Change(change, _)] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert!(
        change.text().contains("/skies/noon.hdr"),
        "{}",
        change.text()
    );
    stage.press(Modifiers::COMMAND, Key::Z);
    let undone = stage.sent();
    assert!(
        matches!(&undone[..], [Command::Change(change, _)] if !change.text().contains("noon")),
        "{undone:?}"
    );

    for (file, said) in [
        (
            "/a/notes.txt",
            "nothing is known to be done with /a/notes.txt",
        ),
        (
            "/a/nameless",
            "nothing is known to be done with /a/nameless",
        ),
    ] {
        stage.drop_files(&[file]);
        assert!(stage.sent().is_empty(), "{file}");
        let message = stage.harness.query_by_label_contains(said);
        assert!(message.is_some(), "{file}");
    }
}

#[test]
fn edits_are_not_lost_by_opening_something_else() {
    let mut stage = Stage::new();
    let edit = Edit::view("exposure", Value::number(1.0));
    let document = stage.harness.state_mut().document_mut();
    let document = document.expect("there is a look");
    document.apply("view", &[edit], None).expect("an edit");
    stage.harness.run_steps(2);
    stage.sent();
    for answer in ["Stay", "Save and open", "Open without saving"] {
        stage.drop_files(&["/models/car.glb"]);
        assert!(stage.sent().is_empty(), "it is asked first");
        stage.click(answer);
        let sent = stage.sent();
        match answer {
            "Stay" => assert!(sent.is_empty()),
            // It is opened once that has been done, which the render says, or fails to do.
            "Save and open" => {
                assert!(matches!(sent[..], [Command::Save(None)]), "{sent:?}");
                stage.reply(Reply::Failed("no room".to_owned()));
                assert!(stage.sent().is_empty());
            }
            _ => assert!(matches!(sent[..], [Command::Open(_)]), "{sent:?}"),
        }
    }
    stage.drop_files(&["/models/car.glb"]);
    stage.click("Save and open");
    let text = stage.harness.state_mut().document_mut();
    let text: Arc<str> = text.expect("there is a look").text().into();
    stage.board.lock().unwrap().look = Some(LookFacts {
        text: Arc::clone(&text),
        saved: text,
        heard: 1,
        ..LookFacts::default()
    });
    stage.harness.run_steps(3);
    let sent = stage.sent();
    assert!(
        matches!(sent[..], [Command::Save(None), Command::Open(_)]),
        "{sent:?}"
    );
}

#[test]
fn opening_the_same_files_again_keeps_what_was_done() {
    const TEXT: &str = "[view]\nexposure = 0.5\n";
    let mut stage = Stage::new();
    let files = stage.board.lock().unwrap().scene.files.clone();
    let open = |stage: &mut Stage, files: &Files| {
        let text: Arc<str> = TEXT.into();
        stage.board.lock().unwrap().look = Some(LookFacts {
            text: Arc::clone(&text),
            saved: text,
            ..LookFacts::default()
        });
        stage.reply(Reply::Opened(files.clone()));
    };
    let text = |stage: &mut Stage| {
        let document = stage.harness.state_mut().document_mut();
        document.expect("a look").text().to_owned()
    };
    open(&mut stage, &files);
    stage.click("Snapshot A");
    let edit = Edit::view("exposure", Value::number(1.0));
    let document = stage.harness.state_mut().document_mut();
    let applied = document.expect("a look").apply("view", &[edit], None);
    applied.expect("an edit");
    stage.harness.run_steps(2);
    let edited = text(&mut stage);
    // Named in another way, they are the same.
    let again = Files {
        scene: std::path::absolute(&files.scene).expect("a path"),
        ..files.clone()
    };
    stage.sent();
    open(&mut stage, &again);
    assert_eq!(text(&mut stage), TEXT, "it is as the file has it");
    let is_told = |sent: &[Command]| sent.iter().any(|c| matches!(c, Command::Change(..)));
    assert!(!is_told(&stage.sent()), "the render has it already");
    stage.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(text(&mut stage), edited, "what was not saved comes back");
    assert!(is_told(&stage.sent()));
    stage.click("Snapshot A");
    assert_eq!(text(&mut stage), TEXT, "it was kept");
    // Others begin anew.
    let others = Files {
        scene: PathBuf::from("scenes/car.glb"),
        ..files
    };
    open(&mut stage, &others);
    let document = stage.harness.state_mut().document_mut();
    assert_eq!(document.expect("a look").done(), 0);
}

#[test]
fn what_was_done_counts_for_the_file_that_the_look_is_saved_as() {
    const TEXT: &str = "[view]\nexposure = 0.5\n";
    let look = |text: &str| LookFacts {
        text: text.into(),
        saved: text.into(),
        ..LookFacts::default()
    };
    let save_as = |stage: &mut Stage| {
        stage.press(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S);
        stage.press(Modifiers::COMMAND, Key::A);
        stage.type_text("scenes/night.look.toml");
        stage.press(Modifiers::NONE, Key::Enter);
        let sent = stage.sent();
        let path = sent.into_iter().find_map(|command| match command {
            Command::Save(path) => path,
            _ => None,
        });
        path.expect("it is saved")
    };
    // As a render would: the look has another file, or it could not be written.
    for is_saved in [true, false] {
        let mut stage = Stage::new();
        let mut files = stage.board.lock().unwrap().scene.files.clone();
        stage.board.lock().unwrap().look = Some(look(TEXT));
        stage.reply(Reply::Opened(files.clone()));
        stage.click("Snapshot A");
        let edit = Edit::view("exposure", Value::number(1.0));
        let document = stage.harness.state_mut().document_mut();
        let applied = document.expect("a look").apply("view", &[edit], None);
        applied.expect("an edit");
        stage.harness.run_steps(2);
        let path = save_as(&mut stage);
        assert_eq!(path, PathBuf::from("scenes/night.look.toml"));
        let document = stage.harness.state_mut().document_mut();
        let edited = document.expect("a look").text().to_owned();
        files.look = Some(path.clone());
        if is_saved {
            let mut board = stage.board.lock().unwrap();
            let mut scene = SceneFacts::clone(&board.scene);
            scene.files = files.clone();
            board.scene = Arc::new(scene);
            board.look = Some(LookFacts {
                heard: 1,
                ..look(&edited)
            });
            drop(board);
            stage.reply(Reply::Done("saved".to_owned()));
            let kept = stage.harness.state_mut().kept().files.clone();
            assert_eq!(kept, Some(files.clone()), "the next start opens it");
        } else {
            stage.reply(Reply::Failed("the disk is full".to_owned()));
        }
        // It is opened, as if it were another one.
        let mut board = stage.board.lock().unwrap();
        let mut scene = SceneFacts::clone(&board.scene);
        scene.files = files.clone();
        board.scene = Arc::new(scene);
        board.look = Some(look(&edited));
        drop(board);
        stage.reply(Reply::Opened(files));
        stage.harness.run_steps(2);
        let document = stage.harness.state_mut().document_mut();
        assert_eq!(document.expect("a look").done() > 0, is_saved);
        if is_saved {
            stage.press(Modifiers::COMMAND, Key::Z);
            let document = stage.harness.state_mut().document_mut();
            assert_eq!(document.expect("a look").text(), TEXT);
            stage.press(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
            stage.click("Snapshot A");
            let document = stage.harness.state_mut().document_mut();
            assert_eq!(document.expect("a look").text(), TEXT, "A was kept");
        }
    }
}

#[test]
fn what_was_picked_is_framed() {
    let mut stage = Stage::new();
    stage.type_text("f");
    assert!(matches!(
        stage.sent()[..],
        [Command::Bounds(Extent::Picked)]
    ));
    let (low, high) = (glam::Vec3::splat(4.0), glam::Vec3::new(6.0, 5.0, 8.0));
    stage.reply(Reply::Bounds([low, high]));
    let sent = stage.sent();
    let [Command::View(Some(view))] = &sent[..] else {
        panic!("{sent:?}");
    };
    // It is in the midst of the picture, and as a whole within it.
    let to = view
        .transform
        .inverse()
        .transform_point3(0.5 * (low + high));
    assert!(to.z < 0.0 && to.truncate().length() < 1e-3, "{to}");
    let Projection::Perspective { y_fov } = view.projection else {
        panic!("{:?}", view.projection);
    };
    let radius = 0.5 * low.distance(high);
    let sine = (0.5 * y_fov).sin();
    assert!(-to.z * sine > 0.99 * radius, "{to}, {radius}");
    assert!(-to.z * sine < 3.0 * radius, "{to}, {radius}");
}

#[test]
fn the_title_marks_edits_that_are_not_saved() {
    let mut stage = Stage::new();
    let titles = |stage: &mut Stage| {
        let mut titles = Vec::new();
        for _ in 0..3 {
            stage.harness.run_steps(1);
            let viewports = stage.harness.output().viewport_output.values();
            let commands = viewports.flat_map(|viewport| viewport.commands.clone());
            titles.extend(commands.filter_map(|command| match command {
                egui::ViewportCommand::Title(title) => Some(title),
                _ => None,
            }));
        }
        titles
    };
    assert!(titles(&mut stage).is_empty(), "it is set once");
    let edit = Edit::view("exposure", Value::number(1.0));
    let document = stage.harness.state_mut().document_mut();
    let applied = document.expect("a look").apply("view", &[edit], None);
    applied.expect("an edit");
    let edited = ["lamp.glb with lamp.look.toml * - Patina"];
    assert_eq!(titles(&mut stage), edited);
    stage
        .harness
        .state_mut()
        .document_mut()
        .expect("a look")
        .undo();
    let saved = ["lamp.glb with lamp.look.toml - Patina"];
    assert_eq!(titles(&mut stage), saved);
}

#[test]
fn what_is_typed_into_a_menu_is_no_shortcut() {
    let mut stage = Stage::new();
    stage.click("Add a node");
    stage.type_text("f");
    stage.type_text("p");
    assert!(stage.sent().is_empty());
    let field = stage.harness.get_by_label("Search textures");
    assert_eq!(field.value().as_deref(), Some("fp"));
    stage.click("View transform");
    stage.type_text("f");
    assert!(stage.sent().is_empty());
}

#[test]
fn what_was_shown_can_be_opened_again() {
    let mut stage = Stage::new();
    let folder = tempfile::tempdir().expect("a folder");
    let there = Files {
        scene: folder.path().join("vase.glb"),
        look: None,
        camera: None,
    };
    std::fs::write(&there.scene, "").expect("written");
    let gone = Files {
        scene: folder.path().join("gone.glb"),
        look: Some(folder.path().join("gone.look.toml")),
        camera: None,
    };
    stage.board.lock().unwrap().recent = vec![gone, there.clone()].into();
    stage.click("File");
    stage.click("Open recent");
    let gone = stage.harness.get_by_label("gone.glb with gone.look.toml");
    assert!(gone.accesskit_node().is_disabled());
    stage.click("vase.glb");
    let sent = stage.sent();
    assert!(
        matches!(&sent[..], [Command::Open(files)] if *files == there),
        "{sent:?}"
    );
}

#[test]
fn escape_ends_the_line_around_what_was_picked() {
    let mut stage = Stage::new();
    stage.press(Modifiers::NONE, Key::Escape);
    assert!(stage.sent().is_empty(), "nothing is picked");
    stage.reply(Reply::Picked {
        purpose: PickPurpose::Material,
        hit: Some(brass(1.0)),
    });
    assert_eq!(stage.harness.state().material(), Some("Brass"));
    stage.press(Modifiers::NONE, Key::Escape);
    assert!(matches!(stage.sent()[..], [Command::Unpick]));
    assert_eq!(stage.harness.state().material(), None);
}

#[test]
fn a_light_that_nobody_asked_for_is_marked_and_turned_off() {
    let mut stage = Stage::new();
    let said = "No light in the files";
    assert!(stage.harness.query_by_label(said).is_none());
    stage.board.lock().unwrap().look = Some(LookFacts {
        has_stand_in_light: true,
        ..LookFacts::default()
    });
    stage.harness.run_steps(3);
    assert!(stage.harness.query_by_label(said).is_some());
    for is_on in [false, true] {
        stage.click("Studio light");
        let sent = stage.sent();
        assert!(
            matches!(sent[..], [Command::StudioLight(now)] if now == is_on),
            "nothing is written into the look: {sent:?}"
        );
        assert!(stage.harness.query_by_label(said).is_some());
    }
    // An environment of the look's own takes its place.
    let white = Edit::environment("color", Value::numbers(&[1.0; 3]));
    let document = stage.harness.state_mut().document_mut().expect("a look");
    document.apply("a sky", &[white], None).expect("a look");
    stage.harness.run_steps(3);
    assert!(stage.harness.query_by_label(said).is_none());
}

#[test]
fn times_of_passes_and_textures_are_listed() {
    let mut stage = Stage::new();
    stage.click("Times");
    assert!(matches!(stage.sent()[..], [Command::TimePasses(true), ..]));
    assert!(
        stage
            .harness
            .query_by_label("no times of textures yet")
            .is_some()
    );
    let cost = |name: &str, texture: Option<&str>, nanoseconds, runs_per_pixel| TextureCost {
        name: name.to_owned(),
        texture: texture.map(str::to_owned),
        nanoseconds,
        runs_per_pixel,
    };
    {
        let status = &mut stage.board.lock().unwrap().status;
        status.size = [1000, 500];
        status.passes = vec![PassStats {
            name: "brdf".to_owned(),
            milliseconds: 30.0,
            share: 0.25,
            dispatches: 4,
        }];
        status.textures = TextureCosts {
            list: vec![
                cost("crevices", None, 400.0, 0.5),
                cost("flakes", Some("rust"), 90.0, 0.25),
            ],
            is_done: true,
        };
    }
    stage.harness.run_steps(2);
    assert!(stage.sent().is_empty(), "the picture keeps its size");
    for label in [
        "brdf",
        "25.0 %",
        "7.500", // of four
        "crevices",
        "ambient occlusion",
        "100.00",
        "400",
        "flakes",
        "rust",
        "11.25",
        "90",
    ] {
        assert!(stage.harness.query_by_label(label).is_some(), "{label}");
    }
    stage.click("Times");
    assert!(matches!(stage.sent()[..], [Command::TimePasses(false), ..]));
    assert!(stage.harness.query_by_label("flakes").is_none());
}

/// A narrow window breaks the line of figures, here or there as numbers change: the picture must not begin anew for that.
#[test]
fn figures_that_change_leave_the_picture_its_size() {
    let mut stage = Stage::new();
    stage.harness.set_size(egui::Vec2::new(640.0, 480.0));
    let mut sizes = Vec::new();
    for round in 0..4 {
        let mut board = stage.board.lock().unwrap();
        let status = &mut board.status;
        let is_long = round % 2 == 0;
        (status.spp, status.target) = if is_long { (12345.0, 99999) } else { (1.0, 4) };
        status.samples_per_second = if is_long { 123_456_789.0 } else { 1.0 };
        status.latency = is_long.then_some(1.234);
        status.size = [640, 360];
        drop(board);
        stage.harness.run_steps(4);
        sizes.push(
            stage
                .sent()
                .into_iter()
                .filter_map(|command| match command {
                    Command::Size(size) => Some(size),
                    _ => None,
                })
                .next_back(),
        );
    }
    assert!(sizes[0].is_some(), "{sizes:?}");
    assert_eq!(
        sizes[1..],
        [None; 3],
        "the first round had the longest line"
    );
}

#[test]
fn a_light_is_added_and_placed_by_clicks() {
    let mut stage = Stage::new();
    stage.click("Lights");
    stage.click("Add a light");
    stage.click("Area: a rectangle with soft shadows");
    stage.sent();
    stage.click("Light by a click: light_1");
    stage.click("Viewport");
    assert!(matches!(
        stage.sent()[..],
        [Command::Pick(_, PickPurpose::Light)]
    ));
    stage.reply(Reply::Picked {
        purpose: PickPurpose::Light,
        hit: Some(brass(1.0)),
    });
    let sent = stage.sent();
    let [Command::Change(change, _)] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert!(
        change.text().contains("look_at = [1.0, 0.0, 2.0]"),
        "{}",
        change.text()
    );
    assert!(
        change.text().contains("position = [1.0, "),
        "above it: {}",
        change.text()
    );
    // Only that one click was for the light.
    stage.click("Viewport");
    assert!(matches!(
        stage.sent()[..],
        [Command::Pick(_, PickPurpose::Material)]
    ));
    stage.click("Aim by a click: light_1");
    stage.press(Modifiers::NONE, Key::Escape);
    stage.click("Viewport");
    assert!(matches!(
        stage.sent()[..],
        [Command::Pick(_, PickPurpose::Material)]
    ));
}

#[test]
fn who_walks_keeps_the_height_above_the_ground() {
    let mut stage = Stage::new();
    stage.type_text("g");
    let sent = stage.sent();
    let [Command::Ground(from)] = sent[..] else {
        panic!("{sent:?}");
    };
    let below = Some(1.6);
    stage.reply(Reply::Ground { from, below });
    assert!(stage.sent().is_empty(), "it stands as it stood");
    // A step: the ground is higher there.
    stage.type_text("g");
    stage.type_text("g");
    stage.sent();
    stage.reply(Reply::Ground { from, below });
    let below = Some(1.4);
    stage.reply(Reply::Ground { from, below });
    let sent = stage.sent();
    let [Command::View(Some(view))] = &sent[..] else {
        panic!("{sent:?}");
    };
    let eye = glam::Vec3::from(view.transform.translation);
    assert!((eye - from - glam::Vec3::Y * 0.2).length() < 1e-5);
    let below = None;
    stage.reply(Reply::Ground { from, below });
    assert!(stage.sent().is_empty(), "over an abyss nobody falls");
}

#[test]
fn a_picture_that_is_dropped_becomes_what_one_says() {
    let mut stage = Stage::new();
    stage.harness.state_mut().document_mut().expect("a look");
    stage.drop_files(&["/maps/oak.png"]);
    assert!(stage.harness.query_by_label("oak.png").is_some());
    stage.type_text("p");
    assert!(stage.sent().is_empty(), "keys are not for what lies below");
    stage.click("Cancel");
    assert!(stage.harness.query_by_label("oak.png").is_none());

    let text = "[material.Wood]\nroughness = 0.5\n";
    stage.board.lock().unwrap().look = Some(LookFacts {
        text: text.into(),
        saved: text.into(),
        outside: 1,
        ..LookFacts::default()
    });
    stage.harness.run_steps(3);
    stage.sent();
    stage.drop_files(&["/maps/oak.png"]);
    stage.click("Use as Roughness");
    let sent = stage.sent();
    let [Command::Change(change, _)] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert!(
        change.text().contains("roughness = \"oak.x\""),
        "{}",
        change.text()
    );
    assert!(
        change.text().contains("file = \"/maps/oak.png\""),
        "{}",
        change.text()
    );
}
