//! Images that are chosen in a dialog of the system: the test is the system.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use egui_kittest::kittest::Queryable;
use engine::session::Edit;
use patina_panels::{Answer, Choice, FileDialogs, FileRequest, Form};

use crate::support::{assert_kept, harness, text};

/// Answers at once.
#[derive(Debug)]
struct System {
    asked: Mutex<Vec<FileRequest>>,
    answer: Mutex<Choice>,
}

impl FileDialogs for System {
    fn ask(&self, request: FileRequest, answer: Answer) {
        self.asked.lock().unwrap().push(request);
        answer(self.answer.lock().unwrap().clone());
    }
}

#[test]
fn an_image_is_chosen_and_named_from_the_look() {
    let folder = tempfile::tempdir().expect("a folder");
    let maps = folder.path().join("maps");
    std::fs::create_dir(&maps).expect("a folder");
    std::fs::write(maps.join("wood.png"), "").expect("a file");
    let mut harness = harness(Form::List);
    let document = &mut harness.state_mut().document;
    document.set_path(&folder.path().join("a.look.toml"));
    let edit = [Edit::add_node("poster", "picture")];
    document.apply("add", &edit, None).expect("a look");
    harness.run_steps(8);
    let label = "Browse for image of poster";
    assert!(
        harness.query_by_label(label).is_none(),
        "nobody to be asked"
    );

    let system = Arc::new(System {
        asked: Mutex::default(),
        answer: Mutex::new(Choice::File(maps.join("wood.png"))),
    });
    let panel = &mut harness.state_mut().panel;
    panel.set_file_dialogs(Arc::clone(&system) as Arc<dyn FileDialogs>);
    harness.run_steps(8);
    harness.get_by_label(label).click();
    harness.run_steps(8);
    assert!(
        text(&harness).contains("image = \"maps/wood.png\""),
        "{}",
        text(&harness)
    );
    assert_kept(&harness, "no line");

    // The next one is looked for where this one is, and has a path of its own elsewhere.
    *system.answer.lock().unwrap() = Choice::File(PathBuf::from("/pictures/oak.jpg"));
    harness.get_by_label(label).click();
    harness.run_steps(8);
    let asked = system.asked.lock().unwrap().clone();
    assert_eq!(asked[1].start, maps.join("wood.png"));
    assert_eq!(asked[1].endings, ["png", "jpg", "jpeg", "webp"]);
    assert!(text(&harness).contains("image = \"/pictures/oak.jpg\""));

    let before = text(&harness);
    for choice in [
        Choice::Nothing,
        Choice::Unavailable("there is none".to_owned()),
    ] {
        *system.answer.lock().unwrap() = choice;
        harness.get_by_label(label).click();
        harness.run_steps(8);
    }
    assert_eq!(text(&harness), before);
    assert_eq!(harness.state().panel.message(), Some("there is none"));
    assert!(
        asked[0].start.starts_with(folder.path()),
        "{:?}",
        Path::new(&asked[0].start)
    );
}
