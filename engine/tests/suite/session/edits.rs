//! Single edits: each gives the picture of its look, by buffer writes alone.

use engine::scene::look::{AoDirection, AoSettings, Section, Value};
use engine::session::{Edit, Session, SessionError};
use texgen::{Interpolation, Ramp};

use super::look::{LOOK, RINGS, TEXTURES, TINT};
use super::stage::{Stage, film, is_same, read, settle};
use crate::support::device;

fn made(session: &Session) -> (u64, u64) {
    let device = session.device();
    (device.counts().pipelines, device.counts().shader_modules)
}

fn number(n: f32) -> Value {
    Value::number(n)
}

fn text(t: &str) -> Value {
    Value::Text(t.to_owned())
}

fn blend() -> Value {
    engine::scene::look::parse_value("{ base = 'Floor', over = 'Worn', mask = 0.25 }")
        .expect("TOML")
        .value
}

fn ramp() -> Ramp {
    Ramp {
        stops: vec![(0.1, [0.9, 0.1, 0.2, 1.0]), (0.7, [0.1, 0.3, 0.7, 1.0])],
        interpolation: Interpolation::Smooth,
    }
}

/// Every kind of edit that is to cost no pipeline.
fn kinds() -> Vec<(&'static str, Vec<Edit>)> {
    let ao = AoSettings {
        distance: 1.5,
        direction: AoDirection::Outside,
        samples: 6,
        same_object: false,
    };
    let one = |edit| vec![edit];
    vec![
        (
            "an argument",
            one(Edit::argument("rings", "count", &texgen::Value::F32(7.25))),
        ),
        (
            "a colour",
            one(Edit::argument(
                "paint",
                "color",
                &texgen::Value::Vec3([0.1, 0.7, 0.3]),
            )),
        ),
        (
            "a ramp",
            one(Edit::argument("worn", "ramp", &texgen::Value::Ramp(ramp()))),
        ),
        ("a link", one(Edit::link("paint", "amount", "other"))),
        (
            "a constant for a link",
            one(Edit::argument("paint", "amount", &texgen::Value::F32(0.8))),
        ),
        ("a default", one(Edit::reset("rings", "count"))),
        ("AO", Edit::ao("crevices", &ao).to_vec()),
        (
            "a slot",
            one(Edit::material("Floor", "roughness", text("other"))),
        ),
        (
            "a slot let go",
            one(Edit::reset_material("Floor", "base_color")),
        ),
        (
            "a constant for a slot",
            one(Edit::material("Floor", "roughness", number(0.3))),
        ),
        (
            "a blend's mask",
            one(Edit::material("Wall", "blend.mask", text("other"))),
        ),
        (
            "a constant mask",
            one(Edit::material("Wall", "blend.mask", number(0.5))),
        ),
        (
            "a material constant",
            one(Edit::material("Wall", "metallic", number(0.75))),
        ),
        (
            "a layer's constant",
            one(Edit::material("Wall", "coat_roughness", number(0.4))),
        ),
        (
            "a layer that is gone",
            one(Edit::material("Wall", "coat", number(0.0))),
        ),
        (
            "a layer that is back",
            one(Edit::material("Wall", "coat", number(0.9))),
        ),
        (
            "a new material's constant",
            one(Edit::material("Worn", "roughness", number(0.25))),
        ),
        ("the sky", one(Edit::environment("intensity", number(0.6)))),
        (
            "the camera",
            vec![
                Edit::camera("position", Value::numbers(&[0.7, 1.1, 2.7])),
                Edit::camera("y_fov", number(38.0)),
            ],
        ),
        (
            "a new node",
            vec![
                Edit::add_node("third", "rings"),
                Edit::argument("third", "count", &texgen::Value::F32(1.5)),
                Edit::material("Worn", "metallic", text("third")),
            ],
        ),
    ]
}

#[test]
fn every_kind_of_edit_is_a_buffer_write() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let mut last = film(&mut session);
    let before = made(&session);
    for (what, edits) in kinds() {
        let generation = session.generation();
        session
            .edit_all(&edits)
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(
            session.is_up_to_date() && session.problems().is_empty(),
            "{what}"
        );
        assert!(session.generation() > generation, "{what}");
        let now = film(&mut session);
        assert_eq!(
            made(&session),
            before,
            "{what}: pipelines and shader modules"
        );
        assert!(!is_same(&now, &last), "{what} is seen");
        let fresh = stage.fresh(&session.look_text());
        assert!(
            is_same(&now, &fresh),
            "{what}: not the look's picture\n{}",
            session.look_text()
        );
        last = now;
    }
}

#[test]
fn a_whole_text_is_followed_by_buffer_writes() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let first = film(&mut session);
    let before = made(&session);
    let other = LOOK.replace("count = 5.0 #", "count = 6.5 #");
    assert_ne!(other, LOOK);
    session.replace_look(&other).expect("a look");
    assert_eq!(session.look_text(), other);
    assert!(session.is_up_to_date() && session.has_unsaved_edits());
    assert!(is_same(&film(&mut session), &stage.fresh(&other)));
    // Another way to write the same is no change.
    let generation = session.generation();
    let written = format!("# Written anew.\n{other}");
    session.replace_look(&written).expect("a look");
    assert_eq!(session.look_text(), written);
    assert_eq!(session.generation(), generation);
    // What is no look is refused, what can't be shown is told.
    assert!(session.replace_look("node = 3").is_err());
    assert_eq!(session.look_text(), written);
    let wrong = LOOK.replace("count = 5.0 #", "cuont = 5.0 #");
    session.replace_look(&wrong).expect("a look by its form");
    settle(&mut session);
    assert!(!session.problems().is_empty());
    // As an undo does.
    session.replace_look(LOOK).expect("a look");
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert!(is_same(&film(&mut session), &first));
    assert_eq!(made(&session), before, "pipelines and shader modules");
}

#[test]
fn a_film_never_mixes_two_looks() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let old = film(&mut session);
    session.restart();
    session.step(1).unwrap_or_else(|error| panic!("{error}"));
    // In the middle of the picture.
    let edit = Edit::argument("rings", "count", &texgen::Value::F32(9.0));
    session
        .edit(&edit)
        .unwrap_or_else(|error| panic!("{error}"));
    let snapshot = session.snapshot().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(snapshot.film.sample_bounds(), (0, 0), "begun anew");
    assert_eq!(snapshot.generation, session.generation());
    let new = film(&mut session);
    assert!(!is_same(&old, &new));
    assert!(is_same(&new, &stage.fresh(&session.look_text())));
}

#[test]
fn refused_edits_change_neither_look_nor_picture() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let before = film(&mut session);
    for (edit, says) in [
        (
            Edit::argument("ring", "count", &texgen::Value::F32(1.0)),
            "texture",
        ),
        (
            Edit::argument("rings", "cuont", &texgen::Value::F32(1.0)),
            "did you mean `count`?",
        ),
        (
            Edit::argument("rings", "count", &texgen::Value::Vec3([1.0; 3])),
            "count",
        ),
        (Edit::link("rings", "count", "rings"), "cyclic link"),
        (Edit::link("paint", "amount", "nothing"), "nothing"),
        (Edit::material("Floor", "roughness", number(1.5)), "0 to 1"),
        (
            Edit::material("Floor", "roughness", text("paint")),
            "one number",
        ),
        (Edit::material("Floor", "rougness", number(0.5)), "rougness"),
        (
            Edit::camera("look_at", Value::numbers(&[0.1, 0.9, 3.0])),
            "direction",
        ),
        (Edit::environment("intensity", number(-1.0)), "negative"),
        (Edit::remove_node("rings"), "in use"),
        (
            Edit::set(Section::Ao("crevices".into()), "samples", Value::Integer(0)),
            "1 to 255",
        ),
    ] {
        match session.edit(&edit) {
            Err(SessionError::Refused(message)) => {
                assert!(message.contains(says), "{edit:?}: {message}");
            }
            other => panic!("{edit:?}: {other:?}"),
        }
        assert_eq!(session.look_text(), LOOK, "{edit:?}");
        assert!(
            session.is_up_to_date() && session.problems().is_empty(),
            "{edit:?}"
        );
    }
    assert!(is_same(&before, &film(&mut session)), "not begun anew");
    session.restart();
    assert!(is_same(&before, &film(&mut session)), "begun anew");
}

#[test]
fn what_is_made_once_is_built_in_the_background() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    film(&mut session);
    for (what, edit) in [
        (
            "light through a wall",
            Edit::material("Floor", "transmission", number(0.5)),
        ),
        (
            "a lamp",
            Edit::material("Wall", "emission", Value::numbers(&[2.0, 1.0, 0.5])),
        ),
        ("another blend", Edit::material("Floor", "blend", blend())),
        (
            "no sky of its own",
            Edit::Remove {
                section: Section::Environment,
            },
        ),
        (
            "opacity by a node",
            Edit::material("Floor", "opacity", text("rings")),
        ),
    ] {
        session
            .edit(&edit)
            .unwrap_or_else(|error| panic!("{what}: {error}"));
        settle(&mut session);
        assert!(
            session.problems().is_empty(),
            "{what}: {}",
            session.problems()
        );
        let fresh = stage.fresh(&session.look_text());
        assert!(is_same(&film(&mut session), &fresh), "{what}");
    }
}

#[test]
fn a_saved_look_keeps_what_was_not_edited() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    session
        .edit(&Edit::argument("rings", "count", &texgen::Value::F32(6.5)))
        .expect("known");
    assert!(session.has_unsaved_edits());
    session.save(None).unwrap_or_else(|error| panic!("{error}"));
    assert!(!session.has_unsaved_edits());
    let saved = read(&stage.path("scene.look.toml"));
    assert_eq!(saved, LOOK.replace("count = 5.0 #", "count = 6.5 #"));
    let generation = session.generation();
    session.look_changed();
    assert_eq!(
        session.generation(),
        generation,
        "one's own saving is no change"
    );
}

#[test]
fn warnings_of_a_texture_outlive_an_edit_of_another() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let odd = RINGS.replace("rings = 3", "rings [5 .. 1] = 3");
    stage.write("textures/rings.wgsl", &odd);
    let mut session = stage.open("scene.look.toml");
    let mut warned = |name: &str, text: &str| {
        stage.write(name, text);
        session.sources_changed();
        settle(&mut session);
        assert!(session.problems().is_empty(), "{}", session.problems());
        let warnings = session.warnings().render();
        warnings.matches("not a range").count()
    };
    let tint = TINT.replace("amount * amount", "amount");
    assert_eq!(warned("textures/tint.wgsl", &tint), 1);
    let still = odd.replace("0.5 + 0.5", "0.4 + 0.6");
    assert_eq!(warned("textures/rings.wgsl", &still), 1);
    assert_eq!(warned("textures/rings.wgsl", RINGS), 0);
}

#[test]
fn numbers_of_materials_build_nothing_where_a_texture_does_not_fit() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    stage.write("textures/rings.wgsl", &RINGS.replace("count", "number"));
    session.sources_changed();
    settle(&mut session);
    assert!(!session.problems().is_empty());
    let mut builds = |edit: &Edit| {
        session.edit(edit).expect("an edit");
        session.poll().unwrap_or_else(|error| panic!("{error}"));
        let is_building = session.is_building();
        settle(&mut session);
        assert!(!session.problems().is_empty());
        is_building
    };
    assert!(!builds(&Edit::material("Wall", "coat", number(0.4))));
    let count = texgen::Value::F32(7.0);
    assert!(builds(&Edit::argument("rings", "count", &count)));
}
