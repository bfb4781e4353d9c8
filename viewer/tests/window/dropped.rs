//! Files that are dropped onto the window.

use std::path::Path;

use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use patina_viewer::link::{Command, LookFacts};

use super::Stage;

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
