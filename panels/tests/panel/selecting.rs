//! What is selected on a graph: by a rectangle, by a search, and what the clipboard does with it.

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, vec2};
use egui_kittest::kittest::Queryable;
use engine::scene::look::AoSettings;
use engine::session::Edit;
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
fn what_is_cut_comes_back_with_its_occlusion() {
    let mut harness = harness(Form::Graph);
    let occlusion = Edit::link("rust", "occlusion", "near");
    let near = Edit::ao("near", &AoSettings::default());
    let edits: Vec<Edit> = near.into_iter().chain([occlusion]).collect();
    let document = &mut harness.state_mut().document;
    document.apply("occlusion", &edits, None).expect("a look");
    harness.run();
    let rust = center(&harness, Role::Button, "node rust");
    harness.hover_at(rust);
    harness.run();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run();
    harness.event(Event::Cut);
    harness.step();
    let mut commands = harness.output().platform_output.commands.iter();
    let copied = commands.find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    });
    let copied = copied.expect("it is in the clipboard");
    for table in ["[ao.near]", "[node.rust]", "[node.paint]"] {
        assert!(copied.contains(table), "{copied}");
    }
    harness.run();
    let cut = text(&harness);
    assert!(!cut.contains("[node."), "{cut}");
    harness.event(Event::Paste(copied));
    harness.run();
    let pasted = text(&harness);
    assert!(pasted.contains("[node.rust]"), "{pasted}");
    assert!(pasted.contains("occlusion = \"near\""), "{pasted}");
    assert_eq!(pasted.matches("[ao.").count(), 1, "{pasted}");
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
