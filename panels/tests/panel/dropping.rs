//! Materials and textures that are dropped on the panel.

use egui::accesskit::Role;
use egui::{Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use patina_panels::Form;

use crate::support::{LOOK, State, assert_kept, center, drag, harness, text};

/// Takes a texture out of the list of them, and lets it go elsewhere.
fn drop_texture(
    harness: &mut Harness<'_, State>,
    texture: &str,
    at: impl Fn(&Harness<'_, State>) -> Pos2,
) {
    harness.get_by_label("Add a node").click();
    harness.run();
    let start = center(harness, Role::Button, texture);
    harness.hover_at(start);
    harness.run();
    harness.drag_at(start);
    harness.run();
    harness.hover_at(start + vec2(10.0, 10.0));
    harness.run();
    let end = at(harness);
    harness.hover_at(end);
    harness.run();
    harness.run();
    harness.drop_at(end);
    harness.run();
}

#[test]
fn a_texture_dropped_on_a_value_drives_it() {
    let mut harness = harness(Form::List);
    drop_texture(&mut harness, "mask", |harness| {
        center(harness, Role::Slider, "Roughness of Iron")
    });
    let now = text(&harness);
    assert!(now.contains("[node.mask]\ntexture = \"mask\""), "{now}");
    assert!(now.contains("roughness = \"mask\""), "{now}");
    harness.state_mut().document.undo();
    assert_eq!(text(&harness), LOOK, "it was one step");
    harness.run();
    // A colour for a number: its first component.
    drop_texture(&mut harness, "tint", |harness| {
        center(harness, Role::Slider, "Roughness of Iron")
    });
    let now = text(&harness);
    assert!(now.contains("roughness = \"tint.x\""), "{now}");
}

#[test]
fn a_texture_dropped_on_the_graph_is_linked_or_added() {
    let mut harness = harness(Form::Graph);
    drop_texture(&mut harness, "mask", |harness| {
        center(harness, Role::Button, "Input factor of paint") + vec2(20.0, 0.0)
    });
    let now = text(&harness);
    assert!(now.contains("factor = \"mask\""), "{now}");
    assert_kept(&harness, "no line");
    harness.state_mut().document.undo();
    harness.run();
    drop_texture(&mut harness, "mask", |harness| {
        let fit = harness.get_by_label("Fit").rect();
        fit.center() + vec2(0.0, 60.0)
    });
    let now = text(&harness);
    assert!(now.contains("[node.mask]"), "{now}");
    assert!(
        !now.contains("= \"mask.") && !now.contains("factor"),
        "{now}"
    );
}

#[test]
fn a_material_is_dropped_on_another_one() {
    let mut harness = harness(Form::List);
    harness.get_by_label("All materials").click();
    harness.run_steps(12);
    let start = center(&harness, Role::Button, "Show Paint");
    let header = harness.get_by_label("Material Iron").rect().center();
    drag(&mut harness, start, header - start);
    let blend = "blend = { base = \"Iron\", over = \"Paint\", mask = 1.0 }";
    assert!(text(&harness).contains(blend), "{}", text(&harness));
    harness.state_mut().document.undo();
    harness.run();
    // Within the list, and not on itself.
    let start = center(&harness, Role::Button, "Show Iron");
    let end = center(&harness, Role::Button, "Show Paint");
    drag(&mut harness, start, vec2(12.0, 0.0));
    assert_eq!(text(&harness), LOOK);
    drag(&mut harness, start, end - start);
    let blend = "blend = { base = \"Paint\", over = \"Iron\", mask = 1.0 }";
    assert!(text(&harness).contains(blend), "{}", text(&harness));
    // The other way round would be a circle.
    drag(&mut harness, end, start - end);
    assert!(harness.state().panel.message().is_some());
    harness
        .get_by_role_and_label(Role::Button, "Show Paint")
        .click();
    harness.run();
    assert_eq!(harness.state().panel.material(), Some("Paint"));
}
