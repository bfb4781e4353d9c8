//! Numbers that have more digits than are shown, and numbers that change with time.

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use engine::session::Document;
use patina_panels::{Form, surround_with};

use crate::support::{State, center, drag, harness_with, text};

/// Digits that no field shows.
const FINE: &str = "[node.paint]\ntexture = \"tint\"\ncolor = \"#180d09\"\nfactor = 0.00000012\n\
                    ramp = [[0.123456, [0.0004, 0.5, 0.25]], [1.0, \"#ffffff\"]]\n\n\
                    [node.rust]\ntexture = \"mask\"\nscale = 12.345679\n\n\
                    [material.Iron]\nbase_color = \"#180d09\" # dark\nroughness = 0.1234567\nemission = [0.0004, 0.5, 0.25]\n";

fn press(harness: &mut Harness<'_, State>, key: Key) {
    harness.key_press(key);
    harness.run();
    harness.run();
}

fn field(harness: &mut Harness<'_, State>, label: &str) {
    let field = harness.get_by_role_and_label(Role::SpinButton, label);
    field.click();
    harness.run();
}

fn enter(harness: &mut Harness<'_, State>, label: &str, typed: &str) {
    field(harness, label);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    // Letter by letter: what is half written is no value yet.
    for letter in typed.chars() {
        harness.event(Event::Text(letter.to_string()));
        harness.run();
    }
    press(harness, Key::Enter);
}

#[test]
fn numbers_that_are_entered_and_left_stay_as_they_are() {
    let mut harness = harness_with(Form::List, FINE);
    for _ in 0..250 {
        press(&mut harness, Key::Tab);
    }
    assert_eq!(text(&harness), FINE, "by Tab");
    let labels = [
        "Base colour of Iron red",
        "Roughness of Iron (number)",
        "factor of paint",
        "ramp of paint position",
    ];
    for label in labels {
        for key in [Key::Enter, Key::Escape] {
            field(&mut harness, label);
            press(&mut harness, key);
            assert_eq!(text(&harness), FINE, "{label} by {key:?}");
        }
        field(&mut harness, label);
    }
    field(&mut harness, labels[0]);
    assert_eq!(text(&harness), FINE, "by a click elsewhere");
    assert_eq!(harness.state().document.done(), 0);
}

#[test]
fn fine_numbers_can_be_written() {
    let mut harness = harness_with(Form::List, FINE);
    enter(&mut harness, "Base colour of Iron red", "0.0004");
    let written = text(&harness);
    assert!(written.contains("base_color = [0.0004, "), "{written}");
    assert_eq!(harness.state().document.done(), 1, "one step");
    enter(&mut harness, "factor of paint", "0.00000034");
    let written = text(&harness);
    let [plain, short] = ["factor = 0.00000034", "factor = 3.4e-7"];
    assert!(
        written.contains(plain) || written.contains(short),
        "{written}"
    );
    for typed in ["nan", "inf", "twelve"] {
        enter(&mut harness, "factor of paint", typed);
        assert_eq!(text(&harness), written, "{typed}");
    }
    // What is given up is not written.
    field(&mut harness, "factor of paint");
    harness.event(Event::Text("7".to_owned()));
    harness.run();
    press(&mut harness, Key::Escape);
    assert_eq!(text(&harness), written);
}

#[test]
fn what_has_keys_is_shown_as_it_is_at_the_beginning_and_keeps_them() {
    for (look, closed, label, number) in [
        (
            "environment = { color = [1, 1, 1], intensity = { keys = [[0, 2.0], [1, 4.0]] } }\n",
            Some("Environment"),
            "Intensity of the environment",
            2.0,
        ),
        (
            "[ao.near]\ndistance = { keys = [[0, 0.5], [1, 2.0]] }\n",
            Some("Ambient occlusion"),
            "Distance of near",
            0.5,
        ),
        (
            "[light.Sun]\nintensity = { keys = [[0, 5.0], [1, 1.0]] }\n",
            Some("Lights"),
            "Intensity of Sun",
            5.0,
        ),
        (
            "[view]\nexposure = { keys = [[0, 1.5], [1, 0.0]] }\n",
            Some("View"),
            "Exposure of the look",
            1.5,
        ),
        (
            "[node.rust]\ntexture = \"mask\"\namount = { keys = [[0, 0.125], [1, 0.5]] }\n",
            None,
            "amount of rust",
            0.125,
        ),
        (
            "[material.Iron]\nblend = { base = \"Iron\", over = \"Paint\", mask = { keys = [[0, 0.75], [1, 0.0]] } }\n",
            None,
            "Mask of Iron",
            0.75,
        ),
        (
            "[material.Iron]\nroughness = { keys = [[0, 0.375], [1, 1.0]] }\n",
            None,
            "Roughness of Iron",
            0.375,
        ),
    ] {
        let mut harness = harness_with(Form::List, look);
        if let Some(closed) = closed {
            harness.get_by_label(closed).click();
            harness.run();
        }
        let slider = harness.get_by_role_and_label(Role::Slider, label);
        let shown = slider.accesskit_node().numeric_value();
        assert_eq!(shown, Some(number), "{label}");
        assert!(harness.query_by_label("has keys").is_some(), "{label}");
        let start = center(&harness, Role::Slider, label);
        drag(&mut harness, start, vec2(30.0, 0.0));
        assert_eq!(text(&harness), look, "{label}");
    }
    let look = "environment = { color = { keys = [[0, [0.25, 0.5, 0.75]], [1, [1, 1, 1]]] } }\n";
    let mut harness = harness_with(Form::List, look);
    harness.get_by_label("Environment").click();
    harness.run();
    let red = "Environment colour red";
    let red = harness.get_by_role_and_label(Role::SpinButton, red);
    assert_eq!(red.accesskit_node().numeric_value(), Some(0.25));
}

#[test]
fn keys_are_taken_away_where_that_is_meant() {
    let look = "[material.Iron]\nmetallic = 1.0\nroughness = { keys = [[0, 0.375], [1, 1.0]] }\n";
    let mut harness = harness_with(Form::List, look);
    harness
        .get_by_role_and_label(Role::Slider, "Roughness of Iron")
        .click_secondary();
    harness.run();
    harness.get_by_label("Reset").click();
    harness.run();
    assert_eq!(text(&harness), "[material.Iron]\nmetallic = 1.0\n");
}

#[test]
fn a_picture_takes_the_place_of_a_colour_alone() {
    let look =
        "# A room.\nenvironment = { color = [2, 2, 3], group = \"day\", intensity = 2.0 } # keep\n";
    let mut document = Document::new("a.look.toml".as_ref(), look).expect("a look");
    let edits = surround_with(&document, "noon.hdr");
    document.apply("picture", &edits, None).expect("a look");
    let text = document.text();
    for kept in [
        "# A room.\n",
        "group = \"day\"",
        "intensity = 2.0",
        "# keep",
    ] {
        assert!(text.contains(kept), "{text}");
    }
    assert!(text.contains("image = \"noon.hdr\"") && !text.contains("color"));
}
