//! Files that are opened and saved, and edits that would be lost.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use engine::scene::look::Value;
use engine::session::Edit;
use patina_viewer::link::{Command, Files, LookFacts, Reply, Saving, SceneFacts};

use super::Stage;

#[test]
fn saving_has_keys_and_asks_for_a_file_where_there_is_none() {
    let mut stage = Stage::new();
    stage.press(Modifiers::COMMAND, Key::S);
    assert!(matches!(stage.sent()[..], [Command::Save(None, _)]));
    stage.press(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S);
    assert!(stage.harness.query_by_label("Save the look as").is_some());
    stage.press(Modifiers::NONE, Key::Enter);
    let sent = stage.sent();
    let [Command::Save(Some(path), _)] = &sent[..] else {
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
                assert!(matches!(sent[..], [Command::Save(None, _)]), "{sent:?}");
                stage.reply(Reply::NotWritten("no room".to_owned()));
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
        matches!(sent[..], [Command::Save(None, _), Command::Open(_)]),
        "{sent:?}"
    );
}

/// Keys are for the question, and what the picture has to say is no answer of the file system.
#[test]
fn questions_about_edits_wait_for_their_own_answers() {
    let mut stage = Stage::new();
    let edit = Edit::view("exposure", Value::number(1.0));
    let document = stage.harness.state_mut().document_mut();
    let document = document.expect("there is a look");
    document.apply("view", &[edit], None).expect("an edit");
    stage.harness.run_steps(2);
    stage.drop_files(&["/models/car.glb"]);
    stage.sent();
    stage.press(Modifiers::COMMAND, Key::Z);
    let sent = stage.sent();
    assert!(sent.is_empty(), "nothing is undone below it: {sent:?}");
    stage.click("Save and open");
    assert!(matches!(stage.sent()[..], [Command::Save(None, _)]));
    stage.reply(Reply::Failed("some samples were no numbers".to_owned()));
    let text = stage.harness.state_mut().document_mut();
    let text: Arc<str> = text.expect("there is a look").text().into();
    assert!(text.contains("exposure"), "{text}");
    stage.board.lock().unwrap().look = Some(LookFacts {
        text: Arc::clone(&text),
        saved: text,
        heard: 1,
        ..LookFacts::default()
    });
    stage.harness.run_steps(3);
    let sent = stage.sent();
    assert!(matches!(sent[..], [Command::Open(_)]), "{sent:?}");
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
            Command::Save(path, _) => path,
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
            // From whatever folder it is.
            assert_eq!(kept, Some(files.absolute()), "the next start opens it");
        } else {
            stage.reply(Reply::NotWritten("the disk is full".to_owned()));
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
fn what_was_done_names_the_same_files_from_another_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let [here, there] = ["a.look.toml", "looks/a.look.toml"].map(|name| folder.path().join(name));
    std::fs::create_dir(folder.path().join("looks")).expect("a folder");
    let look = |image: &str, exposure: f32| {
        format!("environment = {{ image = '{image}' }}\n\n[view]\nexposure = {exposure:?}\n")
    };
    // As a render would: the look has that file, with so many changes.
    let publish = |stage: &Stage, path: &Path, text: &str, heard: u64| {
        let mut board = stage.board.lock().unwrap();
        let mut scene = SceneFacts::clone(&board.scene);
        scene.files.look = Some(path.to_owned());
        let files = scene.files.clone();
        board.scene = Arc::new(scene);
        board.look = Some(LookFacts {
            text: text.into(),
            saved: text.into(),
            heard,
            ..LookFacts::default()
        });
        files
    };
    let text = |stage: &mut Stage| {
        let document = stage.harness.state_mut().document_mut();
        document.expect("a look").text().to_owned()
    };
    let expose = |stage: &mut Stage, exposure: f32| {
        let edit = Edit::view("exposure", Value::number(exposure));
        let document = stage.harness.state_mut().document_mut();
        let applied = document.expect("a look").apply("view", &[edit], None);
        applied.expect("an edit");
        stage.harness.run_steps(2);
    };
    // What the render was told last.
    let told = |stage: &Stage| {
        let mut sent = stage.sent().into_iter().rev();
        sent.find_map(|command| match command {
            Command::Change(change, number) => Some((change.text().to_owned(), number)),
            _ => None,
        })
    };
    let mut stage = Stage::new();
    let files = publish(&stage, &here, &look("sky.hdr", 0.5), 0);
    stage.reply(Reply::Opened(files));
    expose(&mut stage, 1.0);
    expose(&mut stage, 2.0);
    let (edited, heard) = told(&stage).expect("it is told");
    assert_eq!(edited, look("sky.hdr", 2.0));
    publish(&stage, &there, &look("../sky.hdr", 2.0), heard);
    stage.harness.run_steps(2);
    assert_eq!(text(&mut stage), look("../sky.hdr", 2.0));
    assert_eq!(told(&stage), None, "the render has it already");
    for exposure in [1.0, 0.5] {
        stage.press(Modifiers::COMMAND, Key::Z);
        assert_eq!(text(&mut stage), look("../sky.hdr", exposure));
    }
    let (undone, heard) = told(&stage).expect("it is told");
    assert_eq!(undone, look("../sky.hdr", 0.5));
    // Back again, while the render is yet to hear of an edit.
    expose(&mut stage, 3.0);
    publish(&stage, &here, &look("sky.hdr", 0.5), heard);
    stage.harness.run_steps(2);
    assert_eq!(text(&mut stage), look("sky.hdr", 3.0));
    let (edited, _) = told(&stage).expect("it is told once more");
    assert_eq!(edited, look("sky.hdr", 3.0));
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
fn closing_asks_about_a_picture_that_is_being_finished() {
    let mut stage = Stage::new();
    let saving = Some(Saving {
        path: "a.png".into(),
        spp: 1.0,
        target: 64,
    });
    stage.board.lock().unwrap().status.saving = saving;
    stage.harness.run_steps(2);
    // Whether the window closes in the next two frames, where that is asked for or not.
    let closes = |stage: &mut Stage, is_asked: bool| {
        let root = egui::ViewportId::ROOT;
        if is_asked {
            let viewport = stage.harness.input_mut().viewports.entry(root).or_default();
            viewport.events.push(egui::ViewportEvent::Close);
        }
        let mut closes = false;
        for _ in 0..2 {
            stage.harness.step();
            let commands = &stage.harness.output().viewport_output[&root].commands;
            let is_kept = commands.contains(&egui::ViewportCommand::CancelClose);
            assert!(!is_kept || is_asked);
            closes |= commands.contains(&egui::ViewportCommand::Close);
            stage
                .harness
                .input_mut()
                .viewports
                .entry(root)
                .or_default()
                .events
                .clear();
        }
        closes
    };
    let question = "A picture is being finished";
    assert!(!closes(&mut stage, true));
    stage.harness.run_steps(2);
    assert!(stage.harness.query_by_label(question).is_some());
    stage.click("Stay");
    assert!(stage.harness.query_by_label(question).is_none());
    assert!(!closes(&mut stage, true));
    stage.harness.run_steps(2);
    stage.click("Close once it is written");
    assert!(!closes(&mut stage, false));
    stage.board.lock().unwrap().status.saving = None;
    assert!(closes(&mut stage, false));
}

/// A choice that alone is no look is that side as a whole.
#[test]
fn what_another_program_has_saved_can_be_taken_in_any_case() {
    let spot = |inner: f32, outer: f32| {
        format!(
            "[light.s]\ntype = 'spot'\nposition = [0, 1, 0]\ninner_cone_angle = {inner:?}\nouter_cone_angle = {outer:?}\n"
        )
    };
    let text = |stage: &mut Stage| {
        let document = stage.harness.state_mut().document_mut();
        document.expect("a look").text().to_owned()
    };
    let (mine, theirs) = (spot(30.0, 50.0), spot(10.0, 20.0));
    for (choice, expected) in [
        ("Take the file's there", &theirs),
        ("Keep mine there", &mine),
    ] {
        let mut stage = Stage::new();
        let look = |text: &str, saved: &str, outside: u64, heard: u64| LookFacts {
            text: text.into(),
            saved: saved.into(),
            outside,
            heard,
            ..LookFacts::default()
        };
        let base = spot(10.0, 40.0);
        stage.board.lock().unwrap().look = Some(look(&base, &base, 1, 0));
        stage.harness.run_steps(3);
        let document = stage.harness.state_mut().document_mut();
        let document = document.expect("a look");
        document.replace("mine", &mine).expect("a look");
        stage.harness.run_steps(2);
        let is_first = |command: &Command| matches!(command, Command::Change(_, 1));
        assert!(stage.sent().iter().any(is_first));
        stage.board.lock().unwrap().look = Some(look(&mine, &theirs, 2, 1));
        stage.harness.run_steps(3);
        // For as long as nobody answers.
        for _ in 0..3 {
            let what = "[light.s] outer_cone_angle";
            assert!(stage.harness.query_by_label(what).is_some());
            stage.harness.run_steps(2);
        }
        stage.click(choice);
        assert_eq!(&text(&mut stage), expected);
        assert!(stage.harness.query_by_label(choice).is_none());
        // It has been decided, and is saved without another question.
        stage.sent();
        stage.press(Modifiers::COMMAND, Key::S);
        assert!(matches!(stage.sent()[..], [Command::Save(None, 2)]));
    }
}
