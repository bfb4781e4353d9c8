//! What is selected on a graph: by a rectangle, by a search, and what the clipboard does with it.

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, vec2};
use egui_kittest::kittest::Queryable;
use patina_panels::Form;

use crate::support::{LOOK, center, harness, text};

#[test]
fn a_rectangle_selects_and_the_clipboard_copies() {
    let mut harness = harness(Form::Graph);
    let start = center(&harness, Role::Button, "node rust") - vec2(150.0, 150.0);
    let end = center(&harness, Role::Button, "node paint") + vec2(10.0, 10.0);
    let far = start.max(end);
    let start = start.min(end - vec2(150.0, 150.0));
    let modifiers = Modifiers::SHIFT;
    harness.event(Event::ModifiersChanged(modifiers));
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers,
    };
    harness.event(Event::PointerMoved(start));
    harness.run();
    harness.event(button(start, true));
    harness.run();
    for step in 1..=4u8 {
        let at = start + (far - start) * (f32::from(step) / 4.0);
        harness.event(Event::PointerMoved(at));
        harness.run();
    }
    harness.event(button(far, false));
    harness.run();
    harness.event(Event::ModifiersChanged(Modifiers::NONE));
    harness.run();
    harness.event(Event::Copy);
    harness.step();
    let copied = harness.output().platform_output.commands.iter();
    let copied = copied.filter_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    });
    let copied: Vec<String> = copied.collect();
    let [copied] = &copied[..] else {
        panic!("{copied:?}");
    };
    assert!(copied.contains("[node.paint]"), "{copied}");
    harness.run();
    harness.event(Event::Paste(copied.clone()));
    harness.run();
    assert!(
        text(&harness).contains("[node.paint_2]"),
        "{}",
        text(&harness)
    );
    harness.key_press(Key::Delete);
    harness.run();
    assert_eq!(text(&harness), LOOK, "what was pasted is selected");
    harness.event(Event::Paste("no look".to_owned()));
    harness.run();
    assert!(harness.state().panel.message().is_some());
    assert_eq!(text(&harness), LOOK);
}

#[test]
fn a_node_is_found() {
    let mut harness = harness(Form::Graph);
    harness.get_by_label("Find a node").click();
    harness.run();
    harness.event(Event::Text("tint".to_owned()));
    harness.run();
    // By its texture: its values are shown below.
    assert!(harness.query_by_label("Node paint").is_some());
}
