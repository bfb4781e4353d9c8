//! Layers that come and go while a session is watched.

use engine::film::{Film, Layer, Layers};
use engine::scene::look::Value;
use engine::session::{Edit, Session};

use super::stage::{Stage, film, settle};
use crate::support::device;

const LOOK: &str = "environment = { color = [0.5, 0.6, 0.7], group = \"day\" }\n\n[material.Wall]\nemission = [0.4, 0.2, 0.1]\n";

fn names(session: &Session) -> Vec<String> {
    let layers = session.settings().layers.asked();
    layers.into_iter().map(Into::into).collect()
}

fn light(film: &Film, name: &str) -> f32 {
    let layer = Layer::named(name).expect("known");
    let values = film.values(layer).expect("gathered");
    values.iter().map(|value| value[0]).sum()
}

#[test]
fn groups_of_lights_are_kept_from_a_moment_on() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &[]);
    let mut session = stage.open("scene.look.toml");
    let before = film(&mut session);
    let mut view = session.look_camera().clone();
    session.set_view(Some(view.clone()));
    let groups = Layers::named(["light_groups"]).expect("known");
    let generation = session.generation();
    // Nothing is read for them.
    stage.write("scene.gltf", "broken");
    session.set_layers(Some(groups.clone()));
    assert!(session.is_building());
    settle(&mut session);
    assert_eq!(session.generation(), generation + 1);
    assert!(
        session.problems().is_empty(),
        "{}",
        session.problems().render()
    );
    assert_eq!(
        names(&session),
        ["combined", "light_group_0", "light_group_1"]
    );
    session.set_layers(Some(groups.clone()));
    assert!(!session.is_building(), "they are there");
    let kept = film(&mut session);
    assert!(kept.picture() == before, "the picture is the same");
    assert!(light(&kept, "light_group_1") > 0.0);
    // Edits are followed as ever.
    let emission = |red: f32| {
        let rgb = Value::numbers(&[red, 0.2, 0.1]);
        Edit::material("Wall", "emission", rgb)
    };
    session.edit(&emission(4.0)).expect("an edit");
    assert!(!session.is_building());
    let brighter = film(&mut session);
    let rest = light(&brighter, "light_group_0");
    assert!(rest > 2.0 * light(&kept, "light_group_0"));
    view.transform.translation.x += 0.3;
    session.set_view(Some(view));
    let moved = film(&mut session);
    session.set_layers(None);
    settle(&mut session);
    assert_eq!(names(&session), ["combined"]);
    assert!(film(&mut session) == moved.picture(), "the view stays");
}

#[test]
fn a_light_changes_its_group_by_an_edit() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &[]);
    let mut session = stage.open("scene.look.toml");
    let groups = Layers::named(["light_groups"]).expect("known");
    session.set_layers(Some(groups));
    settle(&mut session);
    let name = |name: &str| Value::Text(name.to_owned());
    for (edit, names, emitting) in [
        (
            Edit::material("Wall", "group", name("wall")),
            &["day", "wall"][..],
            "light_group_2",
        ),
        (
            Edit::environment("group", name("wall")),
            &["wall"],
            "light_group_1",
        ),
    ] {
        session.edit(&edit).expect("an edit");
        settle(&mut session);
        assert_eq!(session.scene().light_groups.names(), names);
        let film = film(&mut session);
        assert!(light(&film, emitting) > 0.0);
        assert_eq!(light(&film, "light_group_0"), 0.0);
    }
}
