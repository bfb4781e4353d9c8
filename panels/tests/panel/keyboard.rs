//! What the pointer does, by the keyboard.

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use patina_panels::Form;

use crate::support::{LOOK, State, center, drag, harness, text};

fn focus(harness: &mut Harness<'_, State>, role: Role, label: &str) {
    harness.get_by_role_and_label(role, label).focus();
    harness.run();
    harness.run();
}

/// What has the keyboard.
fn focused(harness: &Harness<'_, State>) -> String {
    fn find(node: &egui_kittest::Node<'_>) -> Option<String> {
        let own = node.accesskit_node();
        if own.is_focused() {
            return own.label();
        }
        node.children().find_map(|child| find(&child))
    }
    find(&harness.root()).unwrap_or_default()
}

fn press(harness: &mut Harness<'_, State>, modifiers: Modifiers, key: Key) {
    harness.key_press_modifiers(modifiers, key);
    harness.run();
    harness.run();
}

#[test]
fn menus_open_by_keys_and_give_the_keyboard_back() {
    for (modifiers, key) in [(Modifiers::SHIFT, Key::F10), (Modifiers::NONE, Key::Menu)] {
        let mut harness = harness(Form::List);
        focus(&mut harness, Role::Slider, "amount of rust");
        press(&mut harness, modifiers, key);
        assert_eq!(focused(&harness), "Reset");
        press(&mut harness, Modifiers::NONE, Key::Escape);
        assert!(harness.query_by_label("Reset").is_none());
        assert_eq!(focused(&harness), "amount of rust");
        press(&mut harness, modifiers, key);
        press(&mut harness, Modifiers::NONE, Key::Enter);
        assert!(!text(&harness).contains("amount"), "{}", text(&harness));
    }
    // On the graph, too: a link is made without the pointer.
    let mut harness = harness(Form::Graph);
    focus(&mut harness, Role::Button, "Input factor of paint");
    press(&mut harness, Modifiers::SHIFT, Key::F10);
    assert!(harness.query_by_label_contains("Connect").is_some());
}

#[test]
fn tab_reaches_what_there_is() {
    for (form, wanted) in [
        (
            Form::Graph,
            &["node rust", "Output rust", "Input factor of paint", "Fit"][..],
        ),
        (
            Form::List,
            &[
                "Material",
                "amount of rust",
                "ramp of paint",
                "ramp of paint stop 1",
                "Disconnect Base colour of Iron",
                "Add a node",
            ],
        ),
    ] {
        let mut harness = harness(form);
        let mut seen: Vec<String> = Vec::new();
        for _ in 0..200 {
            press(&mut harness, Modifiers::NONE, Key::Tab);
            let now = focused(&harness);
            if wanted.iter().all(|label| seen.iter().any(|s| s == label)) {
                break;
            }
            seen.push(now);
        }
        for label in wanted {
            let is_reached = seen.iter().any(|seen| seen == label);
            assert!(is_reached, "{label} is not reached: {seen:?}");
        }
    }
}

#[test]
fn arrows_go_from_card_to_card_and_move_them() {
    let mut harness = harness(Form::Graph);
    harness.get_by_label("Fit").click();
    harness.run();
    focus(&mut harness, Role::Button, "material Iron");
    press(&mut harness, Modifiers::NONE, Key::ArrowLeft);
    assert_eq!(focused(&harness), "node paint");
    let before = center(&harness, Role::Button, "node paint");
    let other = center(&harness, Role::Button, "material Iron");
    press(&mut harness, Modifiers::SHIFT, Key::ArrowDown);
    press(&mut harness, Modifiers::SHIFT, Key::ArrowDown);
    let moved = center(&harness, Role::Button, "node paint") - before;
    let others = center(&harness, Role::Button, "material Iron") - other;
    assert!((moved - others).y > 10.0, "{moved} {others}");
    assert_eq!(focused(&harness), "node paint");
    press(&mut harness, Modifiers::NONE, Key::Enter);
    assert!(harness.query_by_label("Node paint").is_some());
    // Elsewhere the graph leaves the keys alone.
    focus(&mut harness, Role::Button, "ramp of paint stop 0");
    let before = text(&harness);
    press(&mut harness, Modifiers::NONE, Key::Delete);
    assert!(text(&harness).contains("[node.paint]"));
    assert_ne!(text(&harness), before, "the stop is gone");
    focus(&mut harness, Role::Button, "node paint");
    press(&mut harness, Modifiers::NONE, Key::Enter);
    press(&mut harness, Modifiers::NONE, Key::Delete);
    assert!(!text(&harness).contains("[node.paint]"));
}

#[test]
fn stops_of_a_ramp_are_edited_by_keys() {
    let mut harness = harness(Form::List);
    focus(&mut harness, Role::Button, "ramp of paint stop 0");
    press(&mut harness, Modifiers::NONE, Key::ArrowRight);
    press(&mut harness, Modifiers::NONE, Key::ArrowRight);
    assert_eq!(focused(&harness), "ramp of paint stop 0");
    let at = |harness: &Harness<'_, State>, part: &str| {
        let text = text(harness);
        assert!(text.contains(part), "{text}");
    };
    at(&harness, "ramp = [[0.02, ");
    press(&mut harness, Modifiers::SHIFT, Key::ArrowRight);
    at(&harness, "ramp = [[0.021, ");
    press(&mut harness, Modifiers::NONE, Key::ArrowUp);
    at(&harness, "ramp = [[0.021, [0.01, ");
    press(&mut harness, Modifiers::NONE, Key::Insert);
    assert_eq!(focused(&harness), "ramp of paint stop 1");
    let third = "ramp of paint stop 2";
    assert!(harness.query_by_label(third).is_some());
    press(&mut harness, Modifiers::NONE, Key::Delete);
    assert!(harness.query_by_label(third).is_none());
    // Its colour: the picker is open, and has the keyboard. It has a sign that the small fonts of tests lack.
    harness
        .ctx
        .set_missing_glyph_policy(egui::MissingGlyphPolicy::Tofu);
    press(&mut harness, Modifiers::NONE, Key::Enter);
    assert_eq!(focused(&harness), "ramp of paint colour");
    while harness.state_mut().document.undo() {}
    assert_eq!(text(&harness), LOOK);
}

/// What a key does that is held is one step, and what it does later is another one.
#[test]
fn keys_that_are_pressed_again_are_steps_of_their_own() {
    let mut harness = harness(Form::List);
    let done = |harness: &Harness<'_, State>| harness.state().document.done();
    focus(&mut harness, Role::Slider, "amount of rust");
    press(&mut harness, Modifiers::NONE, Key::ArrowRight);
    let once = text(&harness);
    assert_ne!(once, LOOK);
    press(&mut harness, Modifiers::NONE, Key::ArrowRight);
    assert_ne!(text(&harness), once);
    assert_eq!(done(&harness), 2);
    let key = |pressed, repeat| Event::Key {
        key: Key::ArrowRight,
        physical_key: None,
        pressed,
        repeat,
        modifiers: Modifiers::NONE,
    };
    let mut texts = vec![text(&harness)];
    for event in [key(true, false), key(true, true), key(true, true)] {
        harness.event(event);
        harness.run();
        texts.push(text(&harness));
    }
    harness.event(key(false, false));
    harness.run();
    assert!(texts.windows(2).all(|pair| pair[0] != pair[1]), "{texts:?}");
    assert_eq!(done(&harness), 3);
    harness.state_mut().document.undo();
    assert_eq!(text(&harness), texts[0]);
    harness.state_mut().document.undo();
    assert_eq!(text(&harness), once);
}

/// What lies below a question hears no keys.
#[test]
fn keys_below_a_question_are_not_for_the_graph() {
    let mut harness = harness(Form::Graph);
    let card = center(&harness, Role::Button, "node paint");
    drag(&mut harness, card, egui::Vec2::ZERO);
    harness.hover_at(card);
    harness.run();
    for modal in [true, false] {
        harness.state_mut().has_question = modal;
        harness.run();
        harness.run();
        press(&mut harness, Modifiers::NONE, Key::Delete);
        assert_eq!(text(&harness).contains("[node.paint]"), modal);
    }
}
