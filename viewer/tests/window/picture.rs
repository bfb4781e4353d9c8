//! How the picture is shown, and what of it is rendered.

use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton};
use egui_kittest::kittest::{NodeT, Queryable};
use engine::scene::look::Value;
use engine::scene::view::ViewTransform;
use engine::session::Edit;
use patina_viewer::link::{Command, Denoise, DenoiserState, LookFacts, NOISY, SceneFacts};

use super::Stage;

#[test]
fn the_exposure_slider_brightens_the_picture() {
    let mut stage = Stage::new();
    let slider = stage
        .harness
        .get_by_role_and_label(Role::Slider, "Exposure");
    let rect = slider.rect();
    let start = rect.center();
    stage.drag(
        start,
        start + egui::vec2(0.3 * rect.width(), 0.0),
        PointerButton::Primary,
    );
    let exposures: Vec<f32> = (stage.sent().iter())
        .filter_map(|command| match command {
            Command::Display(settings) => Some(settings.view.exposure),
            _ => None,
        })
        .collect();
    assert!(
        exposures.last().is_some_and(|stops| *stops > 1.0),
        "{exposures:?}"
    );
    let kept = stage.harness.state().preferences.exposure;
    assert_eq!(Some(&kept), exposures.last());
    // Keys change it in quarters of a stop, and back to nothing.
    stage.type_text("0");
    stage.type_text("]");
    assert_eq!(stage.harness.state().preferences.exposure, 0.25);
}

#[test]
fn what_the_look_says_of_the_view_is_shown_and_edited_there() {
    let mut stage = Stage::new();
    let shown = |stage: &Stage| {
        let sent = stage.sent();
        let mut shown = sent.iter().filter_map(|command| match command {
            Command::Display(settings) => Some(settings.view),
            _ => None,
        });
        shown.next_back()
    };
    let edit = Edit::view("transform", Value::Text("agx".to_owned()));
    let document = stage.harness.state_mut().document_mut();
    let document = document.expect("there is a look");
    document.apply("view", &[edit], None).expect("an edit");
    stage.harness.run_steps(2);
    let view = shown(&stage).expect("it is told");
    assert_eq!(view.transform, ViewTransform::Agx);
    // Chosen above the picture, it is written where it was read; what the look doesn't say is the window's own.
    stage.click("View transform");
    stage.click("ACES 2.0");
    stage.type_text("]");
    let view = shown(&stage).expect("it is told");
    assert_eq!(
        (view.transform, view.exposure),
        (ViewTransform::Aces2, 0.25)
    );
    let viewer = stage.harness.state_mut();
    let text = viewer.document_mut().expect("there is a look").text();
    assert!(
        text.contains("aces2") && !text.contains("exposure"),
        "{text}"
    );
    assert_eq!(viewer.preferences.view, ViewTransform::default().name());
}

#[test]
fn an_exposure_of_the_look_is_not_changed_by_being_shown() {
    let mut stage = Stage::new();
    let edit = |stage: &mut Stage, stops: f32| {
        let edit = Edit::view("exposure", Value::number(stops));
        let document = stage.harness.state_mut().document_mut();
        let applied = document.expect("a look").apply("view", &[edit], None);
        applied.expect("an edit");
        stage.harness.run_steps(4);
    };
    let text = |stage: &mut Stage| {
        let document = stage.harness.state_mut().document_mut();
        document.expect("a look").text().to_owned()
    };
    // Beside the slider, and between its steps.
    for stops in [-15.3, 0.125, 32.0] {
        edit(&mut stage, stops);
        let written = text(&mut stage);
        assert!(
            written.contains(&format!("exposure = {stops:?}")),
            "{written}"
        );
        let sent = stage.sent();
        let shown = sent.iter().rev().find_map(|command| match command {
            Command::Display(settings) => Some(settings.view.exposure),
            _ => None,
        });
        assert_eq!(shown, Some(stops));
    }
    // The brightest that there is.
    stage.type_text("]");
    assert!(text(&mut stage).contains("exposure = 32.0"));
    let document = stage.harness.state_mut().document_mut().expect("a look");
    assert!(document.undo() && document.undo());
    stage.harness.run_steps(4);
    let undone = text(&mut stage);
    assert!(undone.contains("exposure = -15.3"), "{undone}");
    // It is moved where it is meant to be.
    let slider = stage
        .harness
        .get_by_role_and_label(Role::Slider, "Exposure");
    let start = slider.rect().center();
    let end = start + egui::vec2(4.0, 0.0);
    stage.drag(start, end, PointerButton::Primary);
    let moved = text(&mut stage);
    assert!(!moved.contains("exposure = -15.3"), "{moved}");
}

#[test]
fn noise_is_taken_out_where_there_is_something_that_does() {
    let mut stage = Stage::new();
    let state = |stage: &mut Stage, state: DenoiserState| {
        stage.board.lock().unwrap().status.denoiser = state;
        stage.harness.run_steps(3);
    };
    let is_disabled =
        |stage: &Stage| (stage.harness.get_by_label("Denoise").accesskit_node()).is_disabled();
    assert!(is_disabled(&stage), "it isn't known yet");
    state(&mut stage, DenoiserState::Absent("get it there".to_owned()));
    assert!(is_disabled(&stage));
    stage.type_text("n");
    stage.harness.get_by_label("Denoise").hover();
    stage.harness.run_steps(60);
    assert!(stage.harness.query_by_label("get it there").is_some());
    assert!(stage.sent().is_empty());
    state(&mut stage, DenoiserState::Ready("Denoiser 2".to_owned()));
    assert!(!is_disabled(&stage));
    stage.click("Denoise");
    assert!(matches!(
        stage.sent()[..],
        [Command::Denoise(Denoise::Never)]
    ));
    assert!(!stage.harness.state().preferences.denoises);
    stage.type_text("n");
    assert!(matches!(
        stage.sent()[..],
        [Command::Denoise(Denoise::Always)]
    ));
    assert!(stage.harness.state().preferences.denoises);
    // The levels between which it works by itself are told, and a right click has it do so again.
    stage.harness.get_by_label("Denoise").hover();
    stage.harness.run_steps(60);
    let levels = format!("{:.0} %", 100.0 * NOISY);
    assert!(stage.harness.query_by_label_contains(&levels).is_some());
    stage.harness.get_by_label("Denoise").click_secondary();
    stage.harness.run_steps(3);
    assert!(matches!(
        stage.sent()[..],
        [Command::Denoise(Denoise::ByItself)]
    ));
}

#[test]
fn regions_are_dragged_and_given_up() {
    let mut stage = Stage::new();
    stage.click("Region");
    let rect = stage.harness.get_by_label("Viewport").rect();
    let at = |x: f32, y: f32| rect.min + egui::vec2(x * rect.width(), y * rect.height());
    stage.drag(at(0.75, 0.5), at(0.25, 0.25), PointerButton::Primary);
    let sent = stage.sent();
    let [Command::Region(Some(region))] = &sent[..] else {
        panic!("{sent:?}");
    };
    for (is, expected) in region.iter().zip([0.25, 0.25, 0.75, 0.5]) {
        assert!((is - expected).abs() < 0.01, "{region:?}");
    }
    stage.type_text("r");
    assert!(matches!(stage.sent()[..], [Command::Region(None)]));
    stage.click("Compare");
    stage.type_text("c");
    assert!(matches!(
        stage.sent()[..],
        [Command::KeepBefore(true), Command::KeepBefore(false)]
    ));
}

/// What was being drawn is no region.
#[test]
fn a_region_that_is_being_drawn_is_given_up() {
    let mut stage = Stage::new();
    let start = stage.center();
    let end = start + egui::vec2(90.0, 60.0);
    for gives_up in ["Esc", "r"] {
        stage.type_text("r");
        let button = |pos, pressed| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        stage.harness.event(Event::PointerMoved(start));
        stage.harness.event(button(start, true));
        stage.harness.event(Event::PointerMoved(end));
        stage.harness.run_steps(2);
        match gives_up {
            "Esc" => stage.press(Modifiers::NONE, Key::Escape),
            key => stage.type_text(key),
        }
        stage.harness.event(button(end, false));
        stage.harness.run_steps(2);
        stage.sent();
        // There is none to be taken away, and another one can be drawn.
        stage.type_text("r");
        let is_region = |command: &Command| matches!(command, Command::Region(_));
        assert!(!stage.sent().iter().any(is_region), "{gives_up}");
        stage.drag(start, end, PointerButton::Primary);
        let sent = stage.sent();
        let is_drawn = |command: &Command| matches!(command, Command::Region(Some(_)));
        assert!(sent.iter().any(is_drawn), "{gives_up}: {sent:?}");
        stage.type_text("r");
    }
}

#[test]
fn time_goes_on_once_a_moment_has_been_seen() {
    let mut stage = Stage::new();
    assert!(stage.harness.query_by_label("Play").is_none());
    let facts = SceneFacts {
        end: Some(2.0),
        ..(*stage.board.lock().unwrap().scene).clone()
    };
    stage.board.lock().unwrap().scene = Arc::new(facts);
    stage.harness.run_steps(2);
    stage.sent();
    let moments = |stage: &Stage| -> Vec<Option<f64>> {
        let sent = stage.sent().into_iter();
        sent.filter_map(|command| match command {
            Command::Moment(seconds) => Some(seconds),
            _ => None,
        })
        .collect()
    };
    stage.click("Play");
    assert_eq!(moments(&stage), [Some(0.0)], "no more until that is seen");
    stage.board.lock().unwrap().status.moment = Some(0.0);
    stage.harness.run_steps(3);
    let next = moments(&stage);
    assert!(
        matches!(next[..], [Some(seconds)] if seconds > 0.0 && seconds < 2.0),
        "{next:?}"
    );
    stage.click("At rest");
    assert_eq!(moments(&stage), [None]);
    stage.harness.run_steps(3);
    assert!(moments(&stage).is_empty(), "it plays no more");
}

#[test]
fn a_state_that_was_kept_is_compared_with_at_once() {
    let mut stage = Stage::new();
    stage.click("Snapshot A");
    let edit = Edit::material("Brass", "roughness", Value::number(0.25));
    let document = stage.harness.state_mut().document_mut().expect("read");
    document.apply("test", &[edit], None).expect("a look");
    stage.harness.run_steps(2);
    stage.sent();
    stage.harness.get_by_label("Snapshot A").click_secondary();
    stage.harness.run_steps(3);
    stage.click("Compare with A");
    let sent = stage.sent();
    let at = |is_it: &dyn Fn(&Command) -> bool| sent.iter().position(is_it);
    let kept = at(&|command| matches!(command, Command::KeepBefore(true)));
    let changed = at(&|command| matches!(command, Command::Change(..)));
    assert!(kept.is_some() && kept < changed, "{sent:?}");
}

#[test]
fn a_light_that_nobody_asked_for_is_marked_and_turned_off() {
    let mut stage = Stage::new();
    let said = "No light in the files";
    assert!(stage.harness.query_by_label(said).is_none());
    stage.board.lock().unwrap().look = Some(LookFacts {
        has_stand_in_light: true,
        ..LookFacts::default()
    });
    stage.harness.run_steps(3);
    assert!(stage.harness.query_by_label(said).is_some());
    for is_on in [false, true] {
        stage.click("Studio light");
        let sent = stage.sent();
        assert!(
            matches!(sent[..], [Command::StudioLight(now)] if now == is_on),
            "nothing is written into the look: {sent:?}"
        );
        assert!(stage.harness.query_by_label(said).is_some());
    }
    // An environment of the look's own takes its place.
    let white = Edit::environment("color", Value::numbers(&[1.0; 3]));
    let document = stage.harness.state_mut().document_mut().expect("a look");
    document.apply("a sky", &[white], None).expect("a look");
    stage.harness.run_steps(3);
    assert!(stage.harness.query_by_label(said).is_none());
}
