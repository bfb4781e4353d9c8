//! The list of steps, and states of the look that are kept aside.

use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use engine::scene::look::Value;
use engine::session::Edit;
use patina_panels::Form;

use crate::support::{LOOK, State, harness, text};

fn roughness(harness: &mut Harness<'_, State>, value: f32) {
    let edit = Edit::material("Iron", "roughness", Value::number(value));
    let document = &mut harness.state_mut().document;
    let label = format!("roughness {value}");
    document.apply(&label, &[edit], None).expect("a look");
    harness.run();
}

fn click(harness: &mut Harness<'_, State>, label: &str) {
    harness.get_by_label(label).click();
    harness.run();
}

#[test]
fn a_click_on_a_step_goes_there() {
    let mut harness = harness(Form::List);
    roughness(&mut harness, 0.1);
    let first = text(&harness);
    roughness(&mut harness, 0.2);
    let second = text(&harness);
    click(&mut harness, "History");
    click(&mut harness, "Step 1: roughness 0.1");
    assert_eq!(text(&harness), first);
    // The menu stays, and so does what was undone.
    click(&mut harness, "Step 2: roughness 0.2");
    assert_eq!(text(&harness), second);
    click(&mut harness, "Step 0: As it was opened");
    assert_eq!(text(&harness), LOOK);
}

#[test]
fn states_are_kept_and_switched_between() {
    let mut harness = harness(Form::List);
    click(&mut harness, "Snapshot A");
    assert_eq!(text(&harness), LOOK, "the first click keeps");
    roughness(&mut harness, 0.3);
    let rougher = text(&harness);
    click(&mut harness, "Snapshot B");
    click(&mut harness, "Snapshot A");
    assert_eq!(text(&harness), LOOK);
    click(&mut harness, "Snapshot B");
    assert_eq!(text(&harness), rougher);
    // To switch is a step as any other.
    click(&mut harness, "Undo");
    assert_eq!(text(&harness), LOOK);
    roughness(&mut harness, 0.4);
    let other = text(&harness);
    let button = harness.get_by_role_and_label(Role::Button, "Snapshot A");
    button.click_secondary();
    harness.run();
    click(&mut harness, "Keep the look of now as A");
    click(&mut harness, "Snapshot B");
    click(&mut harness, "Snapshot A");
    assert_eq!(text(&harness), other);
    harness.state_mut().panel.forget_snapshots();
    harness.run();
    roughness(&mut harness, 0.5);
    let last = text(&harness);
    click(&mut harness, "Snapshot B");
    assert_eq!(text(&harness), last, "nothing was kept as B");
}

#[test]
fn a_state_that_lacks_what_others_have_saved_leaves_it_out() {
    let mut harness = harness(Form::List);
    click(&mut harness, "Snapshot A");
    let theirs = format!("# Theirs.\n{LOOK}");
    let document = &mut harness.state_mut().document;
    document.replace_by_others("file", &theirs).expect("a look");
    harness.run();
    click(&mut harness, "Snapshot B");
    let leaves_out = |harness: &Harness<'_, State>| harness.state().document.leaves_out_others();
    assert!(!leaves_out(&harness));
    click(&mut harness, "Snapshot A");
    assert_eq!(text(&harness), LOOK);
    assert!(leaves_out(&harness), "to save would take it away");
    click(&mut harness, "Undo");
    assert_eq!(text(&harness), theirs);
    assert!(!leaves_out(&harness));
    click(&mut harness, "Snapshot A");
    click(&mut harness, "Snapshot B");
    assert!(!leaves_out(&harness), "that has it");
}
