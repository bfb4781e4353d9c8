//! Names of nodes and materials, links by components, and lights.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use engine::procedural::TextureSources;
use engine::scene::look::Value;
use engine::session::Edit;
use patina_panels::{Form, Placing, Textures};

use crate::support::{LOOK, assert_kept, center, drag, harness, harness_of, text, write};

#[test]
fn a_node_is_renamed_in_the_list() {
    let mut harness = harness(Form::List);
    write(&mut harness, "Name of paint", "old-paint");
    let renamed = LOOK
        .replace("[node.paint]", "[node.old-paint]")
        .replace("\"paint\" # driven", "\"old-paint\" # driven");
    assert_eq!(text(&harness), renamed);
    assert!(
        harness
            .query_by_role_and_label(Role::TextInput, "Name of old-paint")
            .is_some()
    );
    harness.get_by_label("Undo").click();
    harness.run();
    assert_eq!(text(&harness), LOOK);
}

#[test]
fn a_name_that_is_none_or_taken_is_refused_with_a_message() {
    let mut harness = harness(Form::List);
    for (name, why) in [
        ("rust", "already"),
        ("old paint", "letters"),
        ("", "letters"),
    ] {
        write(&mut harness, "Name of paint", name);
        assert_eq!(text(&harness), LOOK);
        let message = harness.state().panel.message().expect("it was refused");
        assert!(message.contains(why), "{message}");
    }
    assert_eq!(harness.state().document.undo_label(), None);
}

#[test]
fn a_card_keeps_its_place_when_it_is_renamed() {
    let mut harness = harness(Form::Graph);
    let card = center(&harness, Role::Button, "node rust");
    harness
        .get_by_role_and_label(Role::Button, "node rust")
        .click_secondary();
    harness.run();
    harness.get_by_label_contains("Rename").click();
    harness.run();
    write(&mut harness, "Name of rust", "moss");
    assert!(text(&harness).contains("[node.moss] # where it rusts"));
    assert_eq!(center(&harness, Role::Button, "node moss"), card);
    harness.state_mut().document.undo();
    harness.run();
    assert_eq!(center(&harness, Role::Button, "node rust"), card);
}

#[test]
fn an_added_material_comes_and_goes_with_its_blend() {
    let mut harness = harness(Form::List);
    harness
        .get_by_label("Blend Iron with another material")
        .click();
    harness.run();
    write(
        &mut harness,
        "New material to blend with Iron",
        "Moss green",
    );
    let added = "[material.\"Moss green\"]\nroughness = 0.5";
    assert!(text(&harness).contains(added), "{}", text(&harness));
    assert!(text(&harness).contains("over = \"Moss green\""));
    // The scene's materials are called what the scene calls them.
    assert!(
        harness
            .query_by_role_and_label(Role::TextInput, "Name of Material Iron")
            .is_none()
    );
    write(&mut harness, "Name of Material Moss green", "Paint");
    assert!(harness.state().panel.message().is_some(), "it is taken");
    write(&mut harness, "Name of Material Moss green", "Moss");
    assert_eq!(harness.state().panel.message(), None);
    assert!(text(&harness).contains("[material.Moss]\nroughness = 0.5"));
    assert!(text(&harness).contains("over = \"Moss\""));
    assert_kept(&harness, "no line");
    // Alone it would be a mistake.
    harness.get_by_label("Take blend of Iron away").click();
    harness.run();
    assert_eq!(text(&harness), LOOK);
    harness.state_mut().document.undo();
    assert!(text(&harness).contains("[material.Moss]"));
}

#[test]
fn a_link_leads_to_its_node() {
    let mut harness = harness(Form::Graph);
    harness
        .get_by_role_and_label(Role::Button, "node paint")
        .click();
    harness.run();
    let link = [Edit::link("paint", "factor", "rust")];
    let document = &mut harness.state_mut().document;
    document.apply("link", &link, None).expect("a look");
    harness.run();
    harness
        .get_by_role_and_label(Role::Link, "factor of paint")
        .click();
    harness.run();
    assert!(
        harness
            .query_by_role_and_label(Role::Slider, "amount of rust")
            .is_some()
    );
}

#[test]
fn components_of_a_link_are_chosen() {
    let mut sources = TextureSources::default();
    sources.insert("four", "fn userProc() -> vec4f { return vec4f(1.0); }");
    sources.insert("tint", "fn userProc(a: vec3f) -> vec3f { return a; }");
    let look = "[node.four]\ntexture = 'four'\n[node.tint]\ntexture = 'tint'\na = 'four.zyx' # turned\n\
                [material.Iron]\nbase_color = 'tint'\n";
    let textures = Textures::load(&sources);
    let mut harness = harness_of(Form::List, look, textures, &["Iron"]);
    // As it is written; showing it changes nothing.
    assert!(harness.query_by_label("a of tint").is_some());
    let open = |harness: &mut egui_kittest::Harness<'static, crate::support::State>| {
        harness
            .get_by_role_and_label(Role::Link, "a of tint")
            .click_secondary();
        harness.run();
        harness.get_by_label_contains("Components").click();
        harness.run();
    };
    assert_eq!(text(&harness), look);
    open(&mut harness);
    write(&mut harness, "Components of a of tint", "wzy");
    let other = look.replace("four.zyx", "four.wzy");
    assert_eq!(text(&harness), other);
    open(&mut harness);
    harness.get_by_role_and_label(Role::Button, ".x").click();
    harness.run();
    assert_eq!(text(&harness), look.replace("four.zyx", "four.x"));
    open(&mut harness);
    write(&mut harness, "Components of a of tint", "xy");
    assert!(harness.state().panel.message().is_some(), "two don't fit");
    assert_eq!(text(&harness), look.replace("four.zyx", "four.x"));

    // A link of several components is taken off and put back where it was.
    harness.state_mut().document.undo();
    harness.state_mut().panel.set_form(Form::Graph);
    harness.run();
    let end = center(&harness, Role::Button, "Input a of tint");
    drag(&mut harness, end, egui::vec2(-40.0, 20.0));
    assert!(!text(&harness).contains("four.wzy"));
    harness.state_mut().document.undo();
    harness.run();
    drag(&mut harness, end, egui::vec2(3.0, 3.0));
    assert_eq!(text(&harness), other);
}

#[test]
fn a_sun_has_a_size() {
    let mut harness = harness(Form::List);
    harness.get_by_label("Lights").click();
    harness.run();
    harness.run();
    let at = center(&harness, Role::Slider, "Size of Sun");
    drag(&mut harness, at, egui::vec2(10.0, 0.0));
    assert!(text(&harness).contains("[light.Sun]\nangular_diameter = "));
    assert_kept(&harness, "no line");
    harness
        .get_by_role_and_label(Role::Slider, "Size of Sun")
        .click_secondary();
    harness.run();
    harness.get_by_label("Reset").click();
    harness.run();
    assert_eq!(text(&harness), LOOK);
}

#[test]
fn lights_are_added_changed_and_taken_away() {
    let mut harness = harness(Form::List);
    harness.get_by_label("Lights").click();
    harness.run();
    harness.get_by_label("Add a light").click();
    harness.run();
    harness.get_by_label("Spot: a cone").click();
    harness.run();
    harness.run();
    assert!(
        text(&harness).contains("[light.light_1]\ntype = \"spot\"\nposition = ["),
        "{}",
        text(&harness)
    );
    let at = center(&harness, Role::Slider, "Outer angle of light_1");
    drag(&mut harness, at, egui::vec2(-20.0, 0.0));
    assert!(text(&harness).contains("outer_cone_angle = "));
    harness.get_by_label("light_1 is on").click();
    harness.run();
    assert!(text(&harness).contains("\non = false"));
    harness.get_by_label("light_1 is on").click();
    harness.run();
    assert!(!text(&harness).contains("\non = "));
    harness.get_by_label("Aim by a click: light_1").click();
    harness.run();
    let panel = &mut harness.state_mut().panel;
    let placing = panel.take_placing();
    assert_eq!(placing, Some(("light_1".to_owned(), Placing::Aim)));
    assert_eq!(panel.take_placing(), None);
    harness.get_by_label("Delete light light_1").click();
    harness.run();
    assert_eq!(text(&harness), LOOK);
}

#[test]
fn a_node_that_many_use_is_deleted_at_once() {
    let mut harness = harness(Form::List);
    let text_of = |text: &str| Value::Text(text.to_owned());
    let edits = [
        Edit::link("paint", "factor", "rust"),
        Edit::material("Iron", "roughness", text_of("rust")),
        Edit::material("Iron", "metallic", text_of("rust")),
    ];
    let document = &mut harness.state_mut().document;
    document.apply("links", &edits, None).expect("a look");
    let linked = text(&harness);
    harness.run();
    harness.get_by_label("Delete rust").click();
    harness.run();
    assert!(!text(&harness).contains("rust\""), "{}", text(&harness));
    assert_eq!(harness.state().panel.message(), None);
    harness.state_mut().document.undo();
    assert_eq!(text(&harness), linked);
}

#[test]
fn a_text_that_is_no_look_changes_nothing() {
    let mut harness = harness(Form::List);
    for broken in ["[node.rust\n", "[node.rust]\nscale = 3\n", "node = 1"] {
        let document = &mut harness.state_mut().document;
        let problems = document.replace("file", broken).expect_err("no look");
        assert!(!problems.is_empty());
        assert_eq!(document.text(), LOOK);
        harness.run();
    }
    // What the panel does goes on from the last look that was one.
    write(&mut harness, "Name of paint", "dye");
    assert!(text(&harness).contains("[node.dye]"));
}

#[test]
fn the_material_of_an_undone_rename_is_shown_no_more() {
    let mut harness = harness(Form::List);
    let over = Value::Text("New".to_owned());
    let edits = [
        Edit::material("New", "roughness", Value::number(0.5)),
        Edit::material("Paint", "blend.base", Value::Text("Paint".to_owned())),
        Edit::material("Paint", "blend.over", over),
        Edit::material("Paint", "blend.mask", Value::number(0.0)),
    ];
    let document = &mut harness.state_mut().document;
    document.apply("new", &edits, None).expect("a look");
    harness.state_mut().panel.pick("New");
    harness.run();
    write(&mut harness, "Name of Material New", "Other");
    assert_eq!(harness.state().panel.material(), Some("Other"));
    harness.get_by_label("Undo").click();
    harness.run();
    assert_eq!(harness.state().panel.material(), Some("Iron"));
}

#[test]
fn copies_are_linked_among_themselves() {
    let mut harness = harness(Form::Graph);
    let link = [Edit::link("paint", "factor", "rust")];
    let document = &mut harness.state_mut().document;
    document.apply("link", &link, None).expect("a look");
    harness.run();
    harness
        .get_by_role_and_label(Role::Button, "node paint")
        .click();
    harness.run();
    harness
        .get_by_role_and_label(Role::Button, "node rust")
        .click_modifiers(egui::Modifiers::SHIFT);
    harness.run();
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::D);
    harness.run();
    let text = text(&harness);
    assert!(text.contains("[node.paint_2]"), "{text}");
    assert!(text.contains("factor = \"rust_2\""), "{text}");
    assert!(text.contains("factor = \"rust\"\n"), "{text}");
    harness.state_mut().document.undo();
    assert_eq!(harness.state().document.undo_label(), Some("link"));
}
