//! Files that are chosen in the system's dialog: the test is the system.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use engine::scene::view::ViewChoice;
use patina_panels::{Answer, Choice, FileDialogs, FileRequest, Purpose};
use patina_viewer::link::{Board, Command, Files, Link, LookFacts, SceneFacts};
use patina_viewer::viewer::{Preferences, Viewer};

/// Dialogs that are open, with what they are to find.
#[derive(Default)]
struct System {
    open: Mutex<Vec<(FileRequest, Answer)>>,
}

impl std::fmt::Debug for System {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("System").finish_non_exhaustive()
    }
}

impl FileDialogs for System {
    fn ask(&self, request: FileRequest, answer: Answer) {
        self.open.lock().unwrap().push((request, answer));
    }
}

struct Stage {
    harness: Harness<'static, Viewer>,
    commands: Receiver<Command>,
    system: Arc<System>,
}

const SCENE: &str = "Browse for the scene";
const LOOK: &str = "Browse for the look of the scene";

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
            ..SceneFacts::default()
        });
        board.lock().unwrap().look = Some(LookFacts::default());
        let link = Link::new(sender, board);
        let mut viewer = Viewer::new(link, Preferences::default(), ViewChoice::default());
        let system = Arc::new(System::default());
        viewer.set_file_dialogs(Arc::clone(&system) as Arc<dyn FileDialogs>);
        let mut harness = Harness::builder()
            .with_size([1280.0, 720.0])
            .build_ui_state(|ui, viewer: &mut Viewer| viewer.ui(ui), viewer);
        harness.run_steps(3);
        let stage = Self {
            harness,
            commands,
            system,
        };
        stage.sent();
        stage
    }

    fn sent(&self) -> Vec<Command> {
        self.commands.try_iter().collect()
    }

    fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(3);
    }

    fn click(&mut self, label: &str) {
        self.harness
            .get_by_role_and_label(Role::Button, label)
            .click();
        self.harness.run_steps(3);
    }

    /// Presses a button that opens a dialog: what it asks for.
    fn browse(&mut self, label: &str) -> FileRequest {
        self.click(label);
        let open = self.system.open.lock().unwrap();
        open.last().expect("a dialog is open").0.clone()
    }

    fn answer(&mut self, choice: Choice) {
        let (_, answer) = self.system.open.lock().unwrap().pop().expect("a dialog");
        answer(choice);
        self.harness.run_steps(3);
    }

    /// What stands in a field.
    fn text(&self, label: &str) -> String {
        let fields = self.harness.query_all_by_label(label);
        let mut texts = fields.filter_map(|field| field.accesskit_node().value());
        texts.next().unwrap_or_default()
    }

    fn is_waiting(&self, label: &str) -> bool {
        let button = self.harness.get_by_label(label);
        button.accesskit_node().is_disabled()
    }
}

fn file(path: impl Into<PathBuf>) -> Choice {
    Choice::File(path.into())
}

#[test]
fn a_chosen_scene_is_opened_with_the_look_beside_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let [vase, own] = ["vase.glb", "vase.look.toml"].map(|name| folder.path().join(name));
    std::fs::write(&own, "").expect("a file");
    let mut stage = Stage::new();
    stage.press(Modifiers::COMMAND, Key::O);
    let asked = stage.browse(SCENE);
    assert_eq!(asked.purpose, Purpose::Open);
    assert_eq!(asked.endings, ["gltf", "glb"]);
    assert_eq!(asked.start, PathBuf::from("scenes/lamp.glb"));
    assert!(stage.is_waiting(SCENE) && !stage.is_waiting(LOOK));
    stage.answer(file(&vase));
    assert!(!stage.is_waiting(SCENE));
    assert_eq!(stage.text("File"), vase.display().to_string());
    assert_eq!(
        stage.text("Look (may be empty)"),
        own.display().to_string(),
        "that of the former scene isn't this one's"
    );
    assert!(stage.sent().is_empty(), "nothing is opened unasked");
    // One that has no look of its own, with another that is chosen.
    stage.browse(SCENE);
    stage.answer(file("/scenes/bowl.glb"));
    let asked = stage.browse(LOOK);
    assert_eq!(asked.endings, ["toml"]);
    stage.answer(file("/looks/blue.toml"));
    stage.click("Open");
    let sent = stage.sent();
    let [Command::Open(files)] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert_eq!(files.scene, PathBuf::from("/scenes/bowl.glb"));
    assert_eq!(files.look, Some(PathBuf::from("/looks/blue.toml")));
}

#[test]
fn a_dialog_that_is_closed_changes_nothing() {
    let mut stage = Stage::new();
    stage.press(Modifiers::COMMAND, Key::O);
    for label in [SCENE, LOOK] {
        stage.browse(label);
        stage.answer(Choice::Nothing);
        // The same where the answer is lost, as on a thread that ends.
        stage.browse(label);
        drop(stage.system.open.lock().unwrap().pop());
        stage.harness.run_steps(3);
        assert!(!stage.is_waiting(label));
    }
    assert_eq!(stage.text("File"), "scenes/lamp.glb");
    assert_eq!(stage.text("Look (may be empty)"), "scenes/lamp.look.toml");
    // An answer that comes too late is for a dialog that isn't there any more.
    stage.browse(SCENE);
    stage.click("Cancel");
    stage.answer(file("/scenes/vase.glb"));
    stage.press(Modifiers::COMMAND, Key::O);
    assert_eq!(stage.text("File"), "scenes/lamp.glb");
    assert!(stage.sent().is_empty());
}

#[test]
fn where_the_system_has_none_the_path_is_typed() {
    const WHY: &str = "there is none here: type the path";
    let mut stage = Stage::new();
    stage.press(Modifiers::COMMAND, Key::O);
    stage.browse(SCENE);
    stage.answer(Choice::Unavailable(WHY.to_owned()));
    stage.browse(LOOK);
    stage.answer(Choice::Unavailable(WHY.to_owned()));
    assert_eq!(
        stage.harness.query_all_by_label(WHY).count(),
        1,
        "told once"
    );
    assert_eq!(stage.text("File"), "scenes/lamp.glb");
    stage.harness.get_by_label("Look (may be empty)").focus();
    stage.press(Modifiers::COMMAND, Key::A);
    let typed = egui::Event::Text("typed.toml".to_owned());
    stage.harness.event(typed);
    stage.harness.run_steps(2);
    stage.click("Open");
    let sent = stage.sent();
    let [Command::Open(files)] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert_eq!(files.look, Some(PathBuf::from("typed.toml")));
    // Another dialog doesn't know of that.
    stage.press(Modifiers::COMMAND, Key::E);
    assert!(stage.harness.query_by_label(WHY).is_none());
}

#[test]
fn looks_and_pictures_are_saved_where_the_system_says() {
    let mut stage = Stage::new();
    stage.press(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S);
    let asked = stage.browse("Browse for the file of the look");
    assert_eq!(asked.purpose, Purpose::Save);
    assert_eq!(asked.start, PathBuf::from("scenes/lamp.look.toml"));
    // Without an ending it gets the usual one.
    stage.answer(file("/looks/blue"));
    assert_eq!(stage.text("File"), "/looks/blue.look.toml");
    stage.click("Save");
    let sent = stage.sent();
    assert!(
        matches!(&sent[..], [Command::Save(Some(path), _)] if path.as_os_str() == "/looks/blue.look.toml"),
        "{sent:?}"
    );
    stage.press(Modifiers::COMMAND, Key::E);
    let asked = stage.browse("Browse for the file of the picture");
    assert_eq!(asked.endings, ["png", "jpg", "jpeg", "exr"]);
    stage.answer(file("/pictures/lamp.exr"));
    stage.click("Save");
    let sent = stage.sent();
    assert!(
        matches!(&sent[..], [Command::SavePicture(order)] if order.path.as_os_str() == "/pictures/lamp.exr"),
        "{sent:?}"
    );
}

#[test]
fn surroundings_are_chosen_too() {
    let mut stage = Stage::new();
    stage.harness.get_by_label("Environment").click();
    stage.harness.run_steps(30);
    let asked = stage.browse("Browse for a picture of the surroundings");
    assert_eq!(asked.endings, ["hdr", "exr"]);
    stage.answer(file("/skies/noon.hdr"));
    let viewer = stage.harness.state_mut();
    let text = viewer.document_mut().expect("there is a look").text();
    assert!(text.contains("\"/skies/noon.hdr\""), "{text}");
    assert_eq!(stage.text("Environment image"), "/skies/noon.hdr");
    // Where there is no dialog, the panel says so.
    stage.browse("Browse for a picture of the surroundings");
    stage.answer(Choice::Unavailable("there is none".to_owned()));
    assert!(stage.harness.query_by_label("there is none").is_some());
}
