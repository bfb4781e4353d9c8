//! The camera, and what is clicked in the picture.

use std::path::PathBuf;
use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton};
use egui_kittest::kittest::Queryable;
use engine::display::Channel;
use engine::scene::Projection;
use engine::scene::view::ViewTransform;
use patina_viewer::link::{Command, Extent, Files, PickPurpose, Reply, SceneFacts};

use super::{Stage, brass, camera};

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
fn numbers_of_the_lens_are_written_in_its_menu() {
    let mut stage = Stage::new();
    stage.click("Camera");
    for (label, typed, wanted) in [
        ("Field of view", "35.5", 35.5),
        ("Aperture radius", "2.5", 2.5),
        // A look takes nothing nearer.
        ("Focus", "0", 1e-6),
    ] {
        let field = stage.harness.get_by_role_and_label(Role::SpinButton, label);
        field.click();
        stage.harness.run_steps(3);
        assert!(stage.sent().is_empty(), "{label} is only entered");
        stage.press(Modifiers::COMMAND, Key::A);
        stage.type_text(typed);
        assert!(stage.sent().is_empty(), "{label} is not all written yet");
        stage.press(Modifiers::NONE, Key::Enter);
        let sent = stage.sent();
        let [Command::View(Some(camera))] = &sent[..] else {
            panic!("{label}: {sent:?}");
        };
        let is = match label {
            "Focus" => camera.focus_distance,
            "Aperture radius" => camera.aperture_radius * 1e3,
            _ => match camera.projection {
                Projection::Perspective { y_fov } => y_fov.to_degrees(),
                Projection::Orthographic { .. } => panic!("{camera:?}"),
            },
        };
        assert!((is / wanted - 1.0).abs() < 1e-5, "{label}: {is}");
    }
}

#[test]
fn a_view_that_the_look_does_not_take_goes_on_being_looked_through() {
    let mut stage = Stage::new();
    // Other files, of which the look has not been read yet.
    let files = Files {
        scene: PathBuf::from("scenes/car.glb"),
        look: None,
        camera: None,
    };
    stage.board.lock().unwrap().look = None;
    stage.reply(Reply::Opened(files.clone()));
    let facts = SceneFacts {
        files,
        ..SceneFacts::clone(&stage.board.lock().unwrap().scene)
    };
    stage.board.lock().unwrap().scene = Arc::new(facts);
    stage.harness.run_steps(2);
    stage.click("Camera");
    stage.click("Window");
    stage.sent();
    stage.click("Camera");
    stage.click("Put into the look");
    let sent = stage.sent();
    assert!(sent.is_empty(), "{sent:?}");
    let why = "there is no look yet";
    assert!(stage.harness.query_by_label_contains(why).is_some());
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
