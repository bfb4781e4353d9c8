//! Files that are dropped onto the window.

use std::path::Path;
use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Key, Modifiers, PointerButton};
use egui_kittest::kittest::Queryable;
use engine::scene::Material;
use patina_viewer::link::{Command, Hit, LookFacts, PickPurpose, Reply};

use super::{Stage, brass};

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
        ("/a/paint.tga", "/a/paint.tga: save it as PNG, JPEG or WebP"),
    ] {
        stage.drop_files(&[file]);
        assert!(stage.sent().is_empty(), "{file}");
        let message = stage.harness.query_by_label_contains(said);
        assert!(message.is_some(), "{file}");
    }
}

#[test]
fn an_environment_that_is_dropped_leaves_what_else_is_said_of_it() {
    let mut stage = Stage::new();
    let text = "# A room.\n# By me.\nenvironment = { color = [2, 2, 3], group = \"day\", intensity = 2.0 } # keep\n";
    stage.board.lock().unwrap().look = Some(LookFacts {
        text: text.into(),
        saved: text.into(),
        outside: 1,
        ..LookFacts::default()
    });
    stage.harness.run_steps(3);
    stage.sent();
    stage.drop_files(&["/skies/noon.hdr"]);
    let sent = stage.sent();
    let [Command::Change(change, _)] = &sent[..] else {
        panic!("{sent:?}");
    };
    let text = change.text();
    assert!(text.starts_with("# A room.\n# By me.\n"), "{text}");
    for kept in ["group = \"day\"", "intensity = 2.0", "# keep", "noon.hdr"] {
        assert!(text.contains(kept), "{kept}: {text}");
    }
    assert!(!text.contains("color"), "{text}");
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

#[test]
fn a_material_dropped_on_the_model_leaves_a_look_that_can_be_used() {
    // Rust is the look's own, and part of Iron; Steel is made of Brass.
    const LOOK: &str = "[material.Iron]\nblend = { base = 'Iron', over = 'Rust', mask = 0.5 }\n\n\
        [material.Rust]\nroughness = 1.0\n\n\
        [material.Steel]\nblend = { base = 'Steel', over = 'Brass', mask = 0.5 }\n";
    let mut stage = Stage::new();
    let material = |name: &str| Material {
        name: name.to_owned(),
        ..Material::default()
    };
    let own = ["Iron", "Steel", "Brass"];
    let all = own.iter().chain(&["Rust"]);
    stage.board.lock().unwrap().look = Some(LookFacts {
        text: LOOK.into(),
        saved: LOOK.into(),
        outside: 1,
        materials: Arc::new(all.map(|name| material(name)).collect()),
        own_materials: own.len(),
        ..LookFacts::default()
    });
    stage.harness.run_steps(3);
    stage.click("All materials");
    stage.harness.run_steps(12);
    stage.sent();
    let mut drop_on = |material: &str| {
        let start = stage
            .harness
            .get_by_role_and_label(Role::Button, "Show Steel");
        let (start, end) = (start.rect().center(), stage.center());
        stage.drag(start, end, PointerButton::Primary);
        let sent = stage.sent();
        let is_drop = |c: &Command| matches!(c, Command::Pick(_, PickPurpose::Drop));
        assert!(sent.iter().any(is_drop), "{sent:?}");
        stage.reply(Reply::Picked {
            purpose: PickPurpose::Drop,
            hit: Some(Hit {
                material: material.to_owned(),
                ..brass(1.0)
            }),
        });
        stage.sent()
    };
    // It would be made of itself.
    let sent = drop_on("Brass");
    assert!(sent.is_empty(), "{sent:?}");
    // What nothing is made of any more goes.
    let sent = drop_on("Iron");
    let [Command::Change(change, _)] = &sent[..] else {
        panic!("{sent:?}");
    };
    let text = change.text();
    assert!(text.contains("over = 'Steel'"), "{text}");
    assert!(!text.contains("Rust"), "{text}");
    let why = "`Steel` is made of `Brass` already";
    assert!(stage.harness.query_by_label(why).is_some());
}
