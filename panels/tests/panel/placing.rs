//! Where cards of the graph stand that come new, and frames around them.

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use engine::scene::look::Value;
use engine::session::Edit;
use patina_panels::Form;

use crate::support::{LOOK, State, center, drag, harness, text, write};

/// All cards, as they are seen.
fn cards(harness: &mut Harness<'_, State>) -> Vec<(String, Rect)> {
    harness.get_by_label("Fit").click();
    harness.run();
    let nodes = &harness.state().document.look().nodes;
    let nodes = nodes.iter().map(|node| format!("node {}", node.name.value));
    let ids: Vec<String> = nodes.chain(["material Iron".to_owned()]).collect();
    let rect = |id: &String| harness.get_by_role_and_label(Role::Button, id).rect();
    let cards = ids.iter().map(|id| (id.clone(), rect(id)));
    cards.collect()
}

fn assert_apart(harness: &mut Harness<'_, State>) {
    let cards = cards(harness);
    for (i, (id, card)) in cards.iter().enumerate() {
        for (other, place) in &cards[..i] {
            let shared = card.intersect(*place);
            assert!(!shared.is_positive(), "{id} lies on {other}: {shared}");
        }
    }
}

fn frame_all(harness: &mut Harness<'_, State>) {
    let place = center(harness, Role::Button, "node rust");
    harness.hover_at(place);
    harness.run();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::G);
    harness.run();
}

#[test]
fn new_cards_lie_on_none_of_those_that_are_there() {
    let mut harness = harness(Form::Graph);
    assert_apart(&mut harness);
    // By the menu: all of them at the middle of what is seen.
    for _ in 0..3 {
        harness.get_by_label("Add a node").click();
        harness.run();
        harness.get_by_role_and_label(Role::Button, "tint").click();
        harness.run();
        assert_apart(&mut harness);
    }
    // As when a picture is dropped, or by another program.
    for name in ["poster", "poster_2"] {
        let edits = [
            Edit::add_node(name, "picture"),
            Edit::link("paint", "factor", &format!("{name}.x")),
        ];
        let document = &mut harness.state_mut().document;
        document.apply("add", &edits, None).expect("a look");
        harness.run();
        assert_apart(&mut harness);
    }
    let area = center(&harness, Role::Button, "node rust");
    harness.hover_at(area);
    harness.run();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run();
    harness
        .get_by_role_and_label(Role::Button, "Duplicate")
        .click();
    harness.run();
    assert_apart(&mut harness);
    let copied = "[node.rust]\ntexture = \"mask\"\n[node.more]\ntexture = \"tint\"\n";
    let area = center(&harness, Role::Button, "node rust");
    harness.hover_at(area);
    harness.event(Event::Paste(copied.to_owned()));
    harness.run();
    assert!(text(&harness).contains("[node.more]"), "{}", text(&harness));
    assert_apart(&mut harness);
    harness.get_by_label("Arrange").click();
    harness.run();
    assert_apart(&mut harness);
}

#[test]
fn a_frame_is_made_moved_renamed_coloured_and_removed() {
    let mut harness = harness(Form::Graph);
    frame_all(&mut harness);
    let framed = text(&harness);
    assert!(
        framed.contains("[graph.Frame]\nnodes = [\"paint\", \"rust\"]"),
        "{framed}"
    );
    // Its title takes its cards along.
    let before = center(&harness, Role::Button, "node rust");
    let others = center(&harness, Role::Button, "material Iron");
    let title = center(&harness, Role::Button, "Frame Frame");
    drag(&mut harness, title, vec2(-20.0, 30.0));
    let moved = center(&harness, Role::Button, "node rust") - before;
    assert!((moved - vec2(-20.0, 30.0)).length() < 8.0, "{moved}");
    assert_eq!(center(&harness, Role::Button, "material Iron"), others);
    assert_eq!(text(&harness), framed, "where they stand is not written");

    let menu = |harness: &mut Harness<'_, State>, title: &str, entry: &str| {
        harness
            .get_by_role_and_label(Role::Button, title)
            .click_secondary();
        harness.run();
        harness.get_by_label_contains(entry).click();
        harness.run();
    };
    menu(&mut harness, "Frame Frame", "Rename");
    write(&mut harness, "Title of Frame", "Old paint");
    assert!(
        text(&harness).contains("[graph.\"Old paint\"]\n"),
        "{}",
        text(&harness)
    );
    menu(&mut harness, "Frame Old paint", "Colour");
    harness.get_by_label("Violet").click();
    harness.run();
    assert!(text(&harness).contains("color = \"#8a5ac0\""));
    menu(&mut harness, "Frame Old paint", "Remove the frame");
    assert_eq!(text(&harness), LOOK);
    // Each of them was a step.
    for expected in ["color", "[graph.\"Old paint\"]", "[graph.Frame]"] {
        harness.state_mut().document.undo();
        assert!(text(&harness).contains(expected), "{}", text(&harness));
    }
    harness.state_mut().document.undo();
    assert_eq!(text(&harness), LOOK);
}

#[test]
fn frames_follow_their_nodes() {
    let mut harness = harness(Form::Graph);
    frame_all(&mut harness);
    harness
        .get_by_role_and_label(Role::Button, "node rust")
        .click_secondary();
    harness.run();
    harness.get_by_label_contains("Rename").click();
    harness.run();
    write(&mut harness, "Name of rust", "moss");
    let nodes = |harness: &Harness<'_, State>| {
        let frames = &harness.state().document.look().frames;
        let nodes = frames.iter().flat_map(|frame| &frame.nodes);
        nodes.map(|node| node.value.clone()).collect::<Vec<_>>()
    };
    assert_eq!(nodes(&harness), ["paint", "moss"]);
    // A card that is taken out stands alone; one that is deleted leaves its frame; one around nothing goes.
    harness
        .get_by_role_and_label(Role::Button, "node moss")
        .click_secondary();
    harness.run();
    harness.get_by_label("Take out of the frame").click();
    harness.run();
    assert_eq!(nodes(&harness), ["paint"]);
    harness
        .get_by_role_and_label(Role::Button, "node paint")
        .click();
    harness.run();
    harness.key_press(Key::Delete);
    harness.run();
    assert_eq!(harness.state().panel.message(), None);
    assert!(!text(&harness).contains("graph"), "{}", text(&harness));
}

#[test]
fn a_material_is_put_into_a_frame_and_taken_out() {
    let mut harness = harness(Form::Graph);
    frame_all(&mut harness);
    let framed = text(&harness);
    let menu = |harness: &mut Harness<'_, State>, entries: &[&str]| {
        harness
            .get_by_role_and_label(Role::Button, "material Iron")
            .click_secondary();
        harness.run();
        for entry in entries {
            harness.get_by_label_contains(entry).click();
            harness.run();
        }
        harness.state().document.text().to_owned()
    };
    let put = menu(&mut harness, &["Put into a frame", "Into frame Frame"]);
    assert!(put.contains("materials = [\"Iron\"]"), "{put}");
    // It goes with the others.
    let before = center(&harness, Role::Button, "material Iron");
    let title = center(&harness, Role::Button, "Frame Frame");
    drag(&mut harness, title, vec2(-20.0, 30.0));
    let moved = center(&harness, Role::Button, "material Iron") - before;
    assert!((moved - vec2(-20.0, 30.0)).length() < 8.0, "{moved}");
    let taken = menu(&mut harness, &["Take out of the frame"]);
    assert_eq!(taken, framed);
    let alone = menu(&mut harness, &["Put into a frame", "A new frame"]);
    assert!(
        alone.contains("[graph.\"Frame 2\"]\nmaterials = [\"Iron\"]"),
        "{alone}"
    );
    assert_eq!(harness.state().panel.message(), None);
}

#[test]
fn what_comes_new_is_in_no_frame() {
    let mut harness = harness(Form::Graph);
    frame_all(&mut harness);
    let value = Value::Text("added.x".to_owned());
    let edits = [
        Edit::add_node("added", "tint"),
        Edit::material("Iron", "roughness", value),
    ];
    let document = &mut harness.state_mut().document;
    document.apply("add", &edits, None).expect("a look");
    harness.run();
    let cards = cards(&mut harness);
    let of = |name: &str| {
        let found = cards.iter().find(|(id, _)| id == name);
        found.expect("it is shown").1
    };
    let frame = of("node rust").union(of("node paint"));
    assert!(!frame.intersect(of("node added")).is_positive());
}
