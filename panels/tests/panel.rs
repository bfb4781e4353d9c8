//! The panel as its user has it: widgets are found by their names, used, and the text of the look follows.

use std::path::Path;

use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use engine::procedural::TextureSources;
use engine::scene::Material;
use patina_panels::{Document, Form, SceneView, Textures, TexturesPanel};

const LOOK: &str = "# An old valve.\n\n[node.rust] # where it rusts\ntexture = \"mask\"\namount   = 0.25 # a quarter\n\n\
                    [node.paint]\ntexture = \"tint\"\ncolor = \"#7a3b12\"\n\n\
                    # What rusts.\n[material.Iron]\nbase_color = \"paint\" # driven\nroughness = 0.5\n";

const MASK: &str = "/// Where it rusts.\n/// @param amount share of the surface [0 .. 1] = 0.5\n/// @param scale size [0.1 .. 100] [log] [unit 1/m] = 4\n/// @param seed seed [seed] = 1\nfn userProc(amount: f32, scale: f32, seed: u32) -> f32 { return fract(scale * readAttr(WorldPos).x + f32(seed)) * amount; }";
const TINT: &str = "/// A colour.\n/// @param color the colour [color] = #808080\n/// @param ramp from dark to bright = [(0, #000000), (1, #ffffff)]\n/// @param factor how much = 1\nfn userProc(color: vec3f, ramp: ramp1D, factor: f32) -> vec3f { return color * factor * rampEval(ramp, 0.5).xyz; }";

struct State {
    panel: TexturesPanel,
    document: Document,
    textures: Textures,
    materials: Vec<Material>,
}

fn harness(form: Form) -> Harness<'static, State> {
    let mut sources = TextureSources::default();
    sources.insert("mask", MASK);
    sources.insert("tint", TINT);
    sources.insert("broken", "fn userProc() -> f32 { return nothing; }");
    let textures = Textures::load(&sources);
    let good: Vec<&str> = textures
        .library
        .textures()
        .iter()
        .map(|t| t.name())
        .collect();
    assert_eq!(good, ["mask", "tint"], "{:?}", textures.broken);
    let material = |name: &str| Material {
        name: name.to_owned(),
        ..Material::default()
    };
    let mut panel = TexturesPanel::default();
    panel.pick("Iron");
    panel.set_form(form);
    let state = State {
        panel,
        document: Document::new(Path::new("a.look.toml"), LOOK).expect("a look"),
        textures,
        materials: vec![material("Iron"), material("Paint")],
    };
    let mut harness = Harness::builder()
        .with_size(vec2(700.0, 1600.0))
        .build_ui_state(
            |ui, state: &mut State| {
                let scene = SceneView {
                    materials: &state.materials,
                };
                state
                    .panel
                    .show(ui, &mut state.document, &state.textures, scene);
            },
            state,
        );
    harness.run();
    harness
}

fn text(harness: &Harness<'_, State>) -> String {
    harness.state().document.text().to_owned()
}

/// All lines but some are as in the look at first.
fn assert_kept(harness: &Harness<'_, State>, but: &str) {
    let text = text(harness);
    for line in LOOK.lines().filter(|line| !line.starts_with(but)) {
        assert!(
            text.lines().any(|l| l == line),
            "{line} is missing:\n{text}"
        );
    }
}

fn center(harness: &Harness<'_, State>, role: Role, label: &str) -> Pos2 {
    harness.get_by_role_and_label(role, label).rect().center()
}

fn drag(harness: &mut Harness<'_, State>, start: Pos2, by: Vec2) {
    harness.hover_at(start);
    harness.run();
    harness.drag_at(start);
    harness.run();
    for step in 1..=4 {
        harness.hover_at(start + by * (step as f32 / 4.0));
        harness.run();
    }
    harness.drop_at(start + by);
    harness.run();
}

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
    harness.get_by_label("Search textures").focus();
    harness.run();
    harness.get_by_label("Search textures").type_text("mas");
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
    assert!(message.contains("circle"), "{message}");

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
    eprintln!(
        "{:?} {:?}",
        harness.ctx.input(|i| i.pointer.latest_pos()),
        harness.ctx.text_edit_focused()
    );
    harness.key_press(Key::Delete);
    harness.run();
    eprintln!("message {:?}", harness.state().panel.message());
    let text = text(&harness);
    assert!(
        !text.contains("paint") && !text.contains("base_color"),
        "{text}"
    );
    assert!(text.contains("# What rusts."));
    harness.state_mut().document.undo();
    assert_eq!(harness.state().document.text(), LOOK);
}
