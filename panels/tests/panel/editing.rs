//! The panel as its user has it: widgets are found by their names, used, and the text of the look follows.

use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use engine::session::Edit;
use patina_panels::Form;

use crate::support::{LOOK, State, assert_kept, center, drag, harness, text};

#[test]
fn a_slider_is_dragged_undone_and_done_again() {
    let mut harness = harness(Form::List);
    let start = center(&harness, Role::Slider, "amount of rust");
    drag(&mut harness, start, vec2(20.0, 0.0));
    let dragged = text(&harness);
    assert_ne!(dragged, LOOK);
    assert!(dragged.contains(" # a quarter"), "{dragged}");
    assert_kept(&harness, "amount");
    assert!(!harness.state_mut().document.take_changes().is_empty());

    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run();
    assert_eq!(text(&harness), LOOK, "a drag is one step");
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run();
    assert_eq!(text(&harness), dragged);
    harness.get_by_label("Undo").click();
    harness.run();
    assert_eq!(text(&harness), LOOK);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    harness.run();
    assert_eq!(text(&harness), dragged);
}

#[test]
fn a_right_click_resets() {
    let mut harness = harness(Form::List);
    let slider = harness.get_by_role_and_label(Role::Slider, "amount of rust");
    slider.click_secondary();
    harness.run();
    harness.get_by_label("Reset").click();
    harness.run();
    assert!(!text(&harness).contains("amount"), "{}", text(&harness));
    assert_kept(&harness, "amount");
    // What is at its default can't be reset.
    let slider = harness.get_by_role_and_label(Role::Slider, "scale of rust");
    slider.click_secondary();
    harness.run();
    let reset = harness.get_by_label("Reset");
    assert!(reset.accesskit_node().is_disabled());
}

#[test]
fn numbers_and_seeds_are_written() {
    let mut harness = harness(Form::List);
    harness.get_by_label("New seed of rust").click();
    harness.run();
    assert!(text(&harness).contains("seed = "), "{}", text(&harness));
    let field = harness.get_by_role_and_label(Role::SpinButton, "amount of rust (number)");
    field.click();
    harness.run();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text("0.75".to_owned()));
    harness.key_press(Key::Enter);
    harness.run();
    assert!(
        text(&harness).contains("amount   = 0.75 # a quarter"),
        "{}",
        text(&harness)
    );
    let undone = harness.state_mut().document.undo() && harness.state_mut().document.undo();
    assert!(undone);
    assert_eq!(text(&harness), LOOK);
}

#[test]
fn a_link_is_taken_away_and_a_constant_set() {
    let mut harness = harness(Form::List);
    harness
        .get_by_label("Disconnect Base colour of Iron")
        .click();
    harness.run();
    assert!(!text(&harness).contains("base_color"));
    assert_kept(&harness, "base_color");
    // Of the scene's material as it is.
    assert!(harness.query_by_label("Base colour of Iron red").is_some());
    let start = center(&harness, Role::Slider, "Roughness of Iron");
    drag(&mut harness, start, vec2(40.0, 0.0));
    assert!(!text(&harness).contains("roughness = 0.5\n"));
}

#[test]
fn stops_of_a_ramp_come_and_go() {
    let mut harness = harness(Form::List);
    let bar = harness.get_by_label("ramp of paint").rect();
    let at = Pos2::new(bar.center().x, bar.top() + 12.0);
    harness.hover_at(at);
    harness.run();
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run();
    let count = |harness: &Harness<'_, State>| text(harness).matches("0.5").count();
    assert!(text(&harness).contains("ramp = ["), "{}", text(&harness));
    let with_stop = count(&harness);
    harness.get_by_label("ramp of paint delete stop").click();
    harness.run();
    assert!(count(&harness) < with_stop, "{}", text(&harness));
}

#[test]
fn a_node_is_added_by_search() {
    let mut harness = harness(Form::List);
    harness.get_by_label("Add a node").click();
    harness.run();
    // A click into the field doesn't close the menu.
    harness.get_by_label("Search textures").click();
    harness.run();
    harness.event(egui::Event::Text("mas".to_owned()));
    harness.run();
    assert!(harness.query_by_label("tint").is_none());
    harness.get_by_label("mask").click();
    harness.run();
    assert!(
        text(&harness).contains("[node.mask]\ntexture = \"mask\""),
        "{}",
        text(&harness)
    );
    assert_kept(&harness, "no line");
    // It stands among those that nobody needs, and can be changed at once.
    assert!(
        harness
            .query_by_role_and_label(Role::Slider, "amount of mask")
            .is_some()
    );
}

#[test]
fn a_path_counts_when_it_is_complete() {
    let mut harness = harness(Form::List);
    let edit = [Edit::add_node("poster", "picture")];
    let document = &mut harness.state_mut().document;
    document.apply("add", &edit, None).expect("a look");
    harness.run();
    harness.get_by_label("image of poster").click();
    harness.run();
    for part in ["a", ".png"] {
        harness.event(egui::Event::Text(part.to_owned()));
        harness.run();
        assert!(!text(&harness).contains("image"), "half a path");
    }
    harness.key_press(Key::Enter);
    harness.run();
    assert!(text(&harness).contains("image = \"a.png\""));
}

#[test]
fn materials_are_blended() {
    let mut harness = harness(Form::List);
    harness
        .get_by_label("Blend Iron with another material")
        .click();
    harness.run();
    harness.get_by_role_and_label(Role::Button, "Paint").click();
    harness.run();
    let blend = "blend = { base = \"Iron\", over = \"Paint\", mask = 0.0 }";
    assert!(text(&harness).contains(blend), "{}", text(&harness));
    let start = center(&harness, Role::Slider, "Mask of Iron");
    drag(&mut harness, start, vec2(10.0, 0.0));
    assert!(!text(&harness).contains("mask = 0.0"));
    assert_kept(&harness, "no line");
    harness.get_by_label("Take blend of Iron away").click();
    harness.run();
    assert_eq!(text(&harness), LOOK);
}

#[test]
fn sockets_are_connected_by_dragging() {
    let mut harness = harness(Form::Graph);
    let from = center(&harness, Role::Button, "Output rust");
    let to = center(&harness, Role::Button, "Input factor of paint");
    drag(&mut harness, from, to - from);
    assert!(
        text(&harness).contains("factor = \"rust\""),
        "{}",
        text(&harness)
    );
    assert_kept(&harness, "no line");

    // It would close a circle.
    let from = center(&harness, Role::Button, "Output paint.x");
    let to = center(&harness, Role::Button, "Input amount of rust");
    drag(&mut harness, from, to - from);
    assert!(text(&harness).contains("amount   = 0.25"));
    let message = harness.state().panel.message().expect("it was refused");
    assert!(message.contains("cyclic link"), "{message}");

    // A colour is no number.
    let from = center(&harness, Role::Button, "Output paint");
    let to = center(&harness, Role::Button, "Input Roughness of Iron");
    drag(&mut harness, from, to - from);
    let message = harness.state().panel.message().expect("it was refused");
    assert!(message.contains("paint.x"), "{message}");

    // Taken off and let go beside everything.
    let at = center(&harness, Role::Button, "Input factor of paint");
    drag(&mut harness, at, vec2(-30.0, 300.0));
    assert_eq!(text(&harness), LOOK);
}

#[test]
fn nodes_are_duplicated_and_deleted() {
    let mut harness = harness(Form::Graph);
    harness
        .get_by_role_and_label(Role::Button, "node paint")
        .click();
    harness.run();
    harness
        .get_by_role_and_label(Role::Button, "Duplicate")
        .click();
    harness.run();
    assert!(text(&harness).contains("[node.paint_2]\ntexture = \"tint\"\ncolor = \"#7a3b12\""));
    harness.state_mut().document.undo();
    harness.run();
    harness
        .get_by_role_and_label(Role::Button, "node paint")
        .click();
    harness.run();
    harness.key_press(Key::Delete);
    harness.run();
    assert_eq!(harness.state().panel.message(), None);
    let text = text(&harness);
    assert!(
        !text.contains("paint") && !text.contains("base_color"),
        "{text}"
    );
    assert!(text.contains("# What rusts."));
    harness.state_mut().document.undo();
    assert_eq!(harness.state().document.text(), LOOK);
}

#[test]
fn a_link_is_let_go_though_its_socket_is_gone() {
    let mut harness = harness(Form::Graph);
    let from = center(&harness, Role::Button, "Output rust");
    harness.hover_at(from);
    harness.run();
    harness.drag_at(from);
    harness.run();
    harness.hover_at(from + vec2(30.0, 40.0));
    harness.run();
    // As when the file is saved by another editor meanwhile.
    let document = &mut harness.state_mut().document;
    let gone = [Edit::remove_node("rust")];
    document.apply("gone", &gone, None).expect("a look");
    harness.run();
    harness.drop_at(from + vec2(30.0, 40.0));
    harness.run();
    harness.state_mut().document.undo();
    harness.run();
    // Nothing hangs on the pointer that could be connected by another drag.
    let other = center(&harness, Role::Button, "Input factor of paint");
    drag(&mut harness, other, vec2(2.0, 2.0));
    assert_eq!(text(&harness), LOOK);
}
