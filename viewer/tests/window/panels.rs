//! What lies around the picture, and over it.

use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use engine::renderer::{TextureCost, TextureCosts};
use engine::stats::PassStats;
use patina_viewer::link::{Command, PickPurpose, Reply};

use super::{Stage, brass};

#[test]
fn the_question_mark_lists_shortcuts() {
    let mut stage = Stage::new();
    let title = "Keyboard and mouse";
    assert!(stage.harness.query_by_label("save the look").is_none());
    stage.type_text("?");
    assert!(stage.harness.query_all_by_label(title).count() > 0);
    assert!(stage.harness.query_by_label("save the look").is_some());
    stage.press(Modifiers::NONE, Key::Escape);
    assert!(stage.harness.query_by_label("save the look").is_none());
    stage.click("?");
    assert!(stage.harness.query_by_label("save the look").is_some());
}

#[test]
fn problems_are_shown_with_their_place_until_they_are_mended() {
    let mut stage = Stage::new();
    let text = "error: no definition in scope for `colour`\n  rust.wgsl:3:12";
    stage.board.lock().unwrap().status.problems = text.to_owned();
    stage.harness.run_steps(2);
    assert!(stage.harness.query_by_label(text).is_some());
    stage.board.lock().unwrap().status.problems.clear();
    stage.harness.run_steps(2);
    assert!(stage.harness.query_by_label(text).is_none());
    stage.reply(Reply::Failed("cannot write the look".to_owned()));
    assert!(
        stage
            .harness
            .query_by_label("cannot write the look")
            .is_some()
    );
}

/// A message is as wide as it needs, whatever was told before it.
#[test]
fn messages_have_the_width_of_the_picture() {
    let mut stage = Stage::new();
    stage.reply(Reply::Done("saved".to_owned()));
    let short = stage.harness.get_by_label("saved").rect();
    let text = "a message that is much longer than the one before it, but not as long as the picture is wide";
    stage.reply(Reply::Failed(text.to_owned()));
    stage.harness.run_steps(2);
    let long = stage.harness.get_by_label(text).rect();
    assert_eq!(long.height(), short.height(), "it is one line: {long}");
    let picture = stage.harness.get_by_label("Viewport").rect();
    let long = text.repeat(6);
    stage.reply(Reply::Failed(long.clone()));
    stage.harness.run_steps(2);
    let long = stage.harness.get_by_label(&long).rect();
    assert!(picture.contains_rect(long), "{long} {picture}");
}

#[test]
fn all_lines_of_a_problem_are_seen() {
    let mut stage = Stage::new();
    let text = (0..12).map(|line| format!("line {line}\n"));
    let text: String = text.collect();
    stage.board.lock().unwrap().status.problems = text.clone();
    stage.harness.run_steps(4);
    let lines = stage.harness.get_by_label(text.trim_end()).rect();
    let picture = stage.harness.get_by_label("Viewport").rect();
    assert!(
        lines.height() > 100.0 && lines.bottom() <= picture.bottom(),
        "{lines}"
    );
    let head = stage.harness.get_by_label("Hide").rect();
    assert!(
        head.bottom() <= lines.top() + 1.0,
        "{head} lies over {lines}"
    );
}

#[test]
fn a_graph_has_more_room_than_a_list() {
    let mut stage = Stage::new();
    let width = |stage: &Stage| stage.harness.get_by_label("Viewport").rect().width();
    let list = width(&stage);
    assert!(
        list > 900.0,
        "the panel has its usual width from the start: {list}"
    );
    stage.click("Graph");
    let graph = width(&stage);
    assert!((500.0..list - 200.0).contains(&graph), "{graph} of {list}");
    stage.click("List");
    assert_eq!(width(&stage), list);
}

#[test]
fn what_is_typed_into_a_menu_is_no_shortcut() {
    let mut stage = Stage::new();
    stage.click("Add a node");
    stage.type_text("f");
    stage.type_text("p");
    assert!(stage.sent().is_empty());
    let field = stage.harness.get_by_label("Search textures");
    assert_eq!(field.value().as_deref(), Some("fp"));
    stage.click("View transform");
    stage.type_text("f");
    assert!(stage.sent().is_empty());
}

#[test]
fn times_of_passes_and_textures_are_listed() {
    let mut stage = Stage::new();
    stage.click("Times");
    assert!(matches!(stage.sent()[..], [Command::TimePasses(true), ..]));
    assert!(
        stage
            .harness
            .query_by_label("no times of textures yet")
            .is_some()
    );
    let cost = |name: &str, texture: Option<&str>, nanoseconds, runs_per_pixel| TextureCost {
        name: name.to_owned(),
        texture: texture.map(str::to_owned),
        nanoseconds,
        runs_per_pixel,
    };
    {
        let status = &mut stage.board.lock().unwrap().status;
        status.size = [1000, 500];
        status.passes = vec![PassStats {
            name: "brdf".to_owned(),
            milliseconds: 30.0,
            share: 0.25,
            dispatches: 4,
        }];
        status.textures = TextureCosts {
            list: vec![
                cost("crevices", None, 400.0, 0.5),
                cost("flakes", Some("rust"), 90.0, 0.25),
            ],
            is_done: true,
        };
    }
    stage.harness.run_steps(2);
    assert!(stage.sent().is_empty(), "the picture keeps its size");
    for label in [
        "brdf",
        "25.0 %",
        "7.500", // of four
        "crevices",
        "ambient occlusion",
        "100.00",
        "400",
        "flakes",
        "rust",
        "11.25",
        "90",
    ] {
        assert!(stage.harness.query_by_label(label).is_some(), "{label}");
    }
    stage.click("Times");
    assert!(matches!(stage.sent()[..], [Command::TimePasses(false), ..]));
    assert!(stage.harness.query_by_label("flakes").is_none());
}

/// A narrow window breaks the line of figures, here or there as numbers change: the picture must not begin anew for that.
#[test]
fn figures_that_change_leave_the_picture_its_size() {
    let mut stage = Stage::new();
    stage.harness.set_size(egui::Vec2::new(640.0, 480.0));
    let mut sizes = Vec::new();
    for round in 0..4 {
        let mut board = stage.board.lock().unwrap();
        let status = &mut board.status;
        let is_long = round % 2 == 0;
        (status.spp, status.target) = if is_long { (12345.0, 99999) } else { (1.0, 4) };
        status.samples_per_second = if is_long { 123_456_789.0 } else { 1.0 };
        status.latency = is_long.then_some(1.234);
        status.size = [640, 360];
        drop(board);
        stage.harness.run_steps(4);
        sizes.push(
            stage
                .sent()
                .into_iter()
                .filter_map(|command| match command {
                    Command::Size(size) => Some(size),
                    _ => None,
                })
                .next_back(),
        );
    }
    assert!(sizes[0].is_some(), "{sizes:?}");
    assert_eq!(
        sizes[1..],
        [None; 3],
        "the first round had the longest line"
    );
}

#[test]
fn a_light_is_added_and_placed_by_clicks() {
    let mut stage = Stage::new();
    stage.click("Lights");
    stage.click("Add a light");
    stage.click("Area: a rectangle with soft shadows");
    stage.sent();
    stage.click("Light by a click: light_1");
    stage.click("Viewport");
    assert!(matches!(
        stage.sent()[..],
        [Command::Pick(_, PickPurpose::Light)]
    ));
    stage.reply(Reply::Picked {
        purpose: PickPurpose::Light,
        hit: Some(brass(1.0)),
    });
    let sent = stage.sent();
    let [Command::Change(change, _)] = &sent[..] else {
        panic!("{sent:?}");
    };
    assert!(
        change.text().contains("look_at = [1.0, 0.0, 2.0]"),
        "{}",
        change.text()
    );
    assert!(
        change.text().contains("position = [1.0, "),
        "above it: {}",
        change.text()
    );
    // Only that one click was for the light.
    stage.click("Viewport");
    assert!(matches!(
        stage.sent()[..],
        [Command::Pick(_, PickPurpose::Material)]
    ));
    stage.click("Aim by a click: light_1");
    stage.press(Modifiers::NONE, Key::Escape);
    stage.click("Viewport");
    assert!(matches!(
        stage.sent()[..],
        [Command::Pick(_, PickPurpose::Material)]
    ));
}
