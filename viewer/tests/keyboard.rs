//! The keyboard: the picture is turned by it, and all that `?` lists is there. The graph in a panel of its own.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};

use egui::accesskit::Role;
use egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, vec2,
};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use engine::procedural::TextureSources;
use engine::scene::look::{Section, Value};
use engine::scene::view::ViewChoice;
use engine::scene::{Camera, Material, Scene, default_camera};
use engine::session::Edit;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use patina_panels::Textures;
use patina_viewer::link::{
    Board, Command, DenoiserState, Extent, Files, Link, LookFacts, PickPurpose, SceneFacts,
};
use patina_viewer::viewer::{Preferences, SHORTCUTS, Viewer};

#[path = "../../panels/tests/panel/picture.rs"]
mod picture;

const LOOK: &str = "[node.rust]\ntexture = \"mask\"\namount = 0.25\n\n[node.paint]\ntexture = \"tint\"\n\n[material.Iron]\nbase_color = \"paint\"\nroughness = \"rust\"\n";
const MASK: &str = "/// Where it rusts.\n/// @param amount share of the surface [0 .. 1] = 0.5\nfn userProc(amount: f32) -> f32 { return amount; }";
const TINT: &str = "/// A colour.\n/// @param ramp from dark to bright = [(0, #000000), (1, #ffffff)]\n/// @param factor how much = 1\nfn userProc(ramp: ramp1D, factor: f32) -> vec3f { return factor * rampEval(ramp, 0.5).xyz; }";

/// A window whose render does nothing.
struct Stage {
    harness: Harness<'static, Viewer>,
    commands: Receiver<Command>,
    painter: picture::Painter,
}

impl Stage {
    fn new() -> Self {
        Self::of_height(900.0)
    }

    fn of_height(height: f32) -> Self {
        let mut sources = TextureSources::default();
        sources.insert("mask", MASK);
        sources.insert("tint", TINT);
        let material = |name: &str| Material {
            name: name.to_owned(),
            ..Material::default()
        };
        let camera = |name: &str| Camera {
            name: name.to_owned(),
            ..default_camera(&Scene::default())
        };
        let (sender, commands) = channel();
        let board = Board {
            scene: Arc::new(SceneFacts {
                files: Files {
                    scene: PathBuf::from("scenes/lamp.glb"),
                    look: Some(PathBuf::from("scenes/lamp.look.toml")),
                    camera: None,
                },
                cameras: vec![camera("Door")],
                look_camera: Some(camera("Door")),
                ..SceneFacts::default()
            }),
            look: Some(LookFacts {
                text: LOOK.into(),
                saved: LOOK.into(),
                materials: Arc::new(vec![material("Iron"), material("Wood")]),
                own_materials: 2,
                textures: Arc::new(Textures::load(&sources)),
                ..LookFacts::default()
            }),
            ..Board::default()
        };
        let link = Link::new(sender, Arc::new(Mutex::new(board)));
        link.board().status.denoiser = DenoiserState::Ready("Denoiser".to_owned());
        let viewer = Viewer::new(link, Preferences::default(), ViewChoice::default());
        let painter = picture::Painter::default();
        let mut harness = Harness::builder()
            .with_size([1280.0, height])
            .renderer(painter.clone())
            .build_ui_state(|ui, viewer: &mut Viewer| viewer.ui(ui), viewer);
        // The picker of colours has a sign that the small fonts of tests lack.
        harness
            .ctx
            .set_missing_glyph_policy(egui::MissingGlyphPolicy::Tofu);
        harness.run_steps(3);
        let stage = Self {
            harness,
            commands,
            painter,
        };
        stage.sent();
        stage
    }

    /// The same, with the graph.
    fn with(form: &str) -> Self {
        let mut stage = Self::new();
        stage.click(form);
        stage.harness.run_steps(3);
        if form != "List" {
            stage.click("Fit");
        }
        stage.sent();
        stage
    }

    fn sent(&self) -> Vec<Command> {
        self.commands.try_iter().collect()
    }

    fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(3);
    }

    fn type_text(&mut self, text: &str) {
        self.harness.event(Event::Text(text.to_owned()));
        self.harness.run_steps(2);
    }

    fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.harness.run_steps(4);
    }

    fn focus(&mut self, label: &str) {
        self.harness.get_by_label(label).focus();
        self.harness.run_steps(3);
    }

    fn is_there(&self, label: &str) -> bool {
        self.harness.query_all_by_label(label).next().is_some()
    }

    fn center(&self, label: &str) -> Pos2 {
        self.harness.get_by_label(label).rect().center()
    }

    fn button(&self, label: &str) -> Pos2 {
        let button = self.harness.get_by_role_and_label(Role::Button, label);
        button.rect().center()
    }

    fn drag(&mut self, start: Pos2, end: Pos2, button: PointerButton, modifiers: Modifiers) {
        let event = |pos, pressed| Event::PointerButton {
            pos,
            button,
            pressed,
            modifiers,
        };
        self.harness.event(Event::ModifiersChanged(modifiers));
        self.harness.event(Event::PointerMoved(start));
        self.harness.run_steps(1);
        self.harness.event(event(start, true));
        self.harness.run_steps(1);
        // What takes longer is no click.
        let steps = if start == end { 0 } else { 4u8 };
        for step in 1..=steps {
            let at = start.lerp(end, f32::from(step) / 4.0);
            self.harness.event(Event::PointerMoved(at));
            self.harness.run_steps(1);
        }
        self.harness.event(event(end, false));
        self.harness.run_steps(2);
        self.harness.event(Event::ModifiersChanged(Modifiers::NONE));
        self.harness.run_steps(1);
    }

    fn wheel(&mut self, at: Pos2) {
        self.harness.event(Event::PointerMoved(at));
        self.harness.event(Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta: vec2(0.0, 60.0),
            phase: TouchPhase::Move,
            source: MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        });
        self.harness.run_steps(4);
    }

    fn has_keyboard(&self, label: &str) -> bool {
        let mut called = self.harness.query_all_by_label(label);
        called.any(|node| node.accesskit_node().is_focused())
    }

    fn text(&mut self) -> String {
        let document = self.harness.state_mut().document_mut();
        document.expect("there is a look").text().to_owned()
    }

    /// What the render was told to look through last.
    fn view(&self) -> Option<Camera> {
        let mut views = self.sent().into_iter().rev();
        views.find_map(|command| match command {
            Command::View(view) => view,
            _ => None,
        })
    }

    fn has_moved(&self) -> bool {
        self.view().is_some()
    }
}

#[test]
fn the_picture_is_turned_by_keys_while_it_has_the_keyboard() {
    let mut stage = Stage::new();
    stage.press(Modifiers::NONE, Key::ArrowLeft);
    assert!(!stage.has_moved(), "it has not got the keyboard yet");
    stage.focus("Viewport");
    let mut former = default_camera(&Scene::default()).transform;
    for (modifiers, key) in [
        (Modifiers::NONE, Key::ArrowLeft),
        (Modifiers::NONE, Key::ArrowUp),
        (Modifiers::SHIFT, Key::ArrowRight),
        (Modifiers::SHIFT, Key::ArrowDown),
    ] {
        stage.press(modifiers, key);
        let now = stage.view().expect("it has moved").transform;
        let turns = now.matrix3 != former.matrix3;
        assert_eq!(turns, modifiers == Modifiers::NONE, "{key:?}");
        assert_ne!(now, former);
        former = now;
    }
    let mut places = Vec::new();
    for sign in ["+", "-"] {
        stage.type_text(sign);
        places.push(stage.view().expect("it has moved").transform.translation);
    }
    assert_ne!(places[0], places[1]);
    // Clicked, it has the keyboard until the pointer leaves it.
    let mut clicked = Stage::new();
    clicked.click("Viewport");
    clicked.sent();
    clicked.press(Modifiers::NONE, Key::ArrowLeft);
    assert!(clicked.has_moved());
    let aside = clicked.center("Undo");
    let mut clicked = Stage::new();
    clicked.click("Viewport");
    clicked.harness.event(Event::PointerMoved(aside));
    clicked.harness.run_steps(2);
    clicked.sent();
    clicked.press(Modifiers::NONE, Key::ArrowLeft);
    assert!(!clicked.has_moved());
    // Letters go on being shortcuts.
    stage.type_text("p");
    assert!(matches!(stage.sent()[..], [Command::Pause(true)]));
    // Tab leads on.
    stage.press(Modifiers::NONE, Key::Tab);
    stage.press(Modifiers::NONE, Key::ArrowLeft);
    assert!(!stage.has_moved());
}

#[test]
fn a_line_goes_around_what_has_the_keyboard() {
    let mut stage = Stage::new();
    let has_line = |stage: &Stage| {
        let place = stage.harness.get_by_label("Snapshot B").rect();
        let picture = stage.painter.paint(&stage.harness);
        let (x, y) = (place.left() - 1.0, place.center().y);
        let color = stage.harness.ctx.global_style().visuals.hyperlink_color;
        let [r, g, b, _] = color.to_array();
        picture.get_pixel(x as u32, y as u32).0 == [r, g, b]
    };
    stage.focus("Snapshot A");
    assert!(!has_line(&stage));
    stage.press(Modifiers::NONE, Key::Tab);
    assert!(stage.has_keyboard("Snapshot B"));
    assert!(has_line(&stage));
    // Who goes on by the pointer doesn't see it.
    stage.click("Viewport");
    assert!(!has_line(&stage));
}

#[test]
fn the_graph_has_a_panel_of_its_own_below_the_picture() {
    let mut stage = Stage::new();
    let before = stage.harness.get_by_label("Viewport").rect();
    stage.click("Both");
    stage.harness.run_steps(4);
    let picture = stage.harness.get_by_label("Viewport").rect();
    assert_eq!(picture.width(), before.width(), "the list stays as wide");
    assert!(picture.height() < before.height() - 140.0);
    let card = stage.button("node paint");
    assert!(card.y > picture.bottom() && card.x < picture.right());
    // A click on a card brings its values into sight in the list.
    assert!(stage.is_there("Node rust"));
    stage.click("node rust");
    stage.harness.run_steps(8);
    assert!(stage.is_there("amount of rust"));
    // Its border is dragged.
    let border = Pos2::new(picture.center().x, picture.bottom() + 1.0);
    stage.drag(
        border,
        border - vec2(0.0, 120.0),
        PointerButton::Primary,
        Modifiers::NONE,
    );
    stage.harness.run_steps(3);
    let smaller = stage.harness.get_by_label("Viewport").rect();
    assert!(
        smaller.height() < picture.height() - 80.0,
        "{smaller} {picture}"
    );
    assert!(stage.harness.state_mut().kept().graph_is_below);
    stage.click("Fit");
    stage.click("node paint");
    stage.harness.remove_cursor();
    stage.harness.run_steps(4);
    check(&stage.painter.paint(&stage.harness), "graph_below");
    stage.click("List");
    stage.harness.run_steps(4);
    let again = stage.harness.get_by_label("Viewport").rect();
    assert_eq!(again, before);
}

#[test]
fn borders_are_moved_by_keys() {
    let mut stage = Stage::with("Both");
    let height = |stage: &Stage| stage.harness.get_by_label("Viewport").rect().height();
    let before = height(&stage);
    stage.focus("Border of the graph");
    stage.press(Modifiers::NONE, Key::ArrowUp);
    assert_eq!(before - height(&stage), 20.0);
    stage.press(Modifiers::NONE, Key::Home);
    assert_eq!(height(&stage), 120.0);
    stage.press(Modifiers::NONE, Key::End);
    assert!(height(&stage) > before);
    assert!(!stage.has_moved(), "Home is not for the camera");
    // What belongs to another direction does nothing, and keeps the keyboard.
    let highest = height(&stage);
    stage.press(Modifiers::NONE, Key::ArrowLeft);
    assert!(stage.has_keyboard("Border of the graph"));
    assert_eq!(height(&stage), highest);
    // That of Compare; the region's, which say each time what is rendered.
    let mut stage = Stage::new();
    stage.type_text("c");
    stage.harness.run_steps(2);
    let middle = stage.center("Border of Compare").x;
    stage.focus("Border of Compare");
    stage.press(Modifiers::SHIFT, Key::ArrowLeft);
    assert!((middle - stage.center("Border of Compare").x - 2.0).abs() < 0.1);
    stage.press(Modifiers::NONE, Key::End);
    let picture = stage.harness.get_by_label("Viewport").rect();
    assert!((stage.center("Border of Compare").x - picture.right()).abs() < 7.0);
    stage.type_text("c");
    stage.focus("Viewport");
    stage.type_text("r");
    stage.press(Modifiers::NONE, Key::Enter);
    stage.sent();
    let region = |stage: &Stage| {
        let sent = stage.sent();
        let [Command::Region(Some(region))] = sent[..] else {
            panic!("{sent:?}");
        };
        region
    };
    stage.press(Modifiers::NONE, Key::ArrowLeft);
    let [left, top, right, bottom] = region(&stage);
    assert!((left - (0.25 - 20.0 / picture.width())).abs() < 1e-4);
    assert_eq!([top, right, bottom], [0.25, 0.75, 0.75]);
    for (name, key, side, expected) in [
        ("Upper border of the region", Key::Home, 1, 0.0),
        ("Lower border of the region", Key::Home, 3, 0.02),
        ("Right border of the region", Key::End, 2, 1.0),
    ] {
        stage.press(Modifiers::NONE, Key::Tab);
        stage.focus(name);
        stage.press(Modifiers::NONE, key);
        let now = region(&stage)[side];
        assert!((now - expected).abs() < 1e-4, "{name}: {now}");
    }
}

/// All that is listed is done, and something comes of it.
#[test]
fn all_that_the_list_of_keys_says_is_there() {
    let tried = SHORTCUTS.iter().map(|(keys, what)| match does(keys) {
        None => format!("{keys}: nothing here tries that"),
        Some(false) => format!("{keys}: it does not {what}"),
        Some(true) => String::new(),
    });
    let wrong: Vec<String> = tried.filter(|why| !why.is_empty()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Whether a line of the list is true; nothing where it isn't known.
fn does(keys: &str) -> Option<bool> {
    if let Some(keys) = keys.strip_prefix("graph: ") {
        return does_on_the_graph(keys);
    }
    // All of the list is in sight.
    let mut stage = Stage::of_height(2000.0);
    let middle = stage.center("Viewport");
    let aside = middle + vec2(60.0, 30.0);
    let (none, shift, ctrl) = (Modifiers::NONE, Modifiers::SHIFT, Modifiers::COMMAND);
    let is_told = |stage: &Stage, what: fn(&Command) -> bool| stage.sent().iter().any(what);
    Some(match keys {
        "drag" | "right drag" => {
            let button = match keys {
                "drag" => PointerButton::Primary,
                _ => PointerButton::Secondary,
            };
            stage.drag(middle, aside, button, none);
            stage.has_moved()
        }
        "middle drag, Shift drag" => {
            stage.drag(middle, aside, PointerButton::Middle, none);
            let by_middle = stage.has_moved();
            stage.drag(middle, aside, PointerButton::Primary, shift);
            by_middle && stage.has_moved()
        }
        "wheel" => {
            stage.wheel(middle);
            stage.has_moved()
        }
        "W A S D, Q E" => {
            let keys = [Key::W, Key::A, Key::S, Key::D, Key::Q, Key::E];
            stage.harness.event(Event::PointerMoved(middle));
            keys.into_iter().all(|key| {
                stage.harness.key_down(key);
                stage.harness.run_steps(2);
                stage.harness.key_up(key);
                stage.harness.run_steps(2);
                stage.has_moved()
            })
        }
        "G" => {
            stage.type_text("g");
            is_told(&stage, |c| matches!(c, Command::Ground(_)))
        }
        "click" => {
            stage.drag(middle, middle, PointerButton::Primary, none);
            is_told(&stage, |c| {
                matches!(c, Command::Pick(_, PickPurpose::Material))
            })
        }
        "Ctrl click" => {
            stage.drag(middle, middle, PointerButton::Primary, ctrl);
            is_told(&stage, |c| {
                matches!(c, Command::Pick(_, PickPurpose::Focus))
            })
        }
        "F" => {
            stage.type_text("f");
            is_told(&stage, |c| matches!(c, Command::Bounds(Extent::Picked)))
        }
        "Shift F" => {
            stage.type_text("F");
            is_told(&stage, |c| matches!(c, Command::Bounds(Extent::Scene)))
        }
        "arrows" | "Shift arrows" => {
            stage.focus("Viewport");
            let modifiers = if keys == "arrows" { none } else { shift };
            stage.press(modifiers, Key::ArrowUp);
            stage.has_moved()
        }
        "+  -" => {
            stage.focus("Viewport");
            stage.type_text("+");
            let nearer = stage.has_moved();
            stage.type_text("-");
            nearer && stage.has_moved()
        }
        "Enter" => {
            stage.focus("Viewport");
            stage.press(none, Key::Enter);
            is_told(
                &stage,
                |c| matches!(c, Command::Pick(at, PickPurpose::Material) if (at.x - 0.5).abs() < 0.01),
            )
        }
        "Home" => {
            stage.press(none, Key::Home);
            is_told(&stage, |c| matches!(c, Command::View(None)))
        }
        "1 ... 9" => {
            stage.type_text("1");
            stage.has_moved()
        }
        "R" => {
            stage.type_text("r");
            stage.drag(middle, aside, PointerButton::Primary, none);
            is_told(&stage, |c| matches!(c, Command::Region(Some(_))))
        }
        "C" => {
            stage.type_text("c");
            is_told(&stage, |c| matches!(c, Command::KeepBefore(true)))
        }
        "L" => {
            stage.type_text("l");
            stage.harness.run_steps(2);
            stage.is_there("Close")
        }
        "N" => {
            stage.type_text("n");
            is_told(&stage, |c| matches!(c, Command::Denoise(_)))
        }
        "P" => {
            stage.type_text("p");
            is_told(&stage, |c| matches!(c, Command::Pause(true)))
        }
        "[  ]" | "0" => {
            stage.type_text("]");
            stage.type_text("]");
            stage.type_text("[");
            let brighter = stage.harness.state().preferences.exposure == 0.25;
            stage.type_text("0");
            brighter && stage.harness.state().preferences.exposure == 0.0
        }
        _ => return does_to_the_look(keys, stage),
    })
}

fn does_to_the_look(keys: &str, mut stage: Stage) -> Option<bool> {
    let (none, shift, ctrl) = (Modifiers::NONE, Modifiers::SHIFT, Modifiers::COMMAND);
    let both = ctrl.plus(shift);
    Some(match keys {
        "Ctrl S" => {
            stage.press(ctrl, Key::S);
            matches!(stage.sent()[..], [Command::Save(None, _)])
        }
        "Ctrl Shift S" => {
            stage.press(both, Key::S);
            stage.is_there("Save the look as")
        }
        "Ctrl E" => {
            stage.press(ctrl, Key::E);
            stage.is_there("Save")
        }
        "Ctrl O" => {
            stage.press(ctrl, Key::O);
            stage.is_there("Cancel")
        }
        "right-click a value" => {
            let slider = stage
                .harness
                .get_by_role_and_label(Role::Slider, "amount of rust");
            slider.click_secondary();
            stage.harness.run_steps(4);
            stage.click("Reset");
            !stage.text().contains("amount")
        }
        "right-click A, B, C" => {
            stage.harness.get_by_label("Snapshot A").click_secondary();
            stage.harness.run_steps(4);
            stage.is_there("Forget A")
        }
        "Ctrl Z" | "Ctrl Shift Z, Ctrl Y" => {
            let section = Section::Node("rust".to_owned());
            let edit = Edit::set(section, "amount", Value::number(0.75));
            let document = stage.harness.state_mut().document_mut();
            let document = document.expect("there is a look");
            document.apply("more", &[edit], None).expect("an edit");
            stage.press(ctrl, Key::Z);
            let is_undone = stage.text() == LOOK;
            let mut again = |modifiers, key| {
                stage.press(modifiers, key);
                let is_done = stage.text() != LOOK;
                stage.press(ctrl, Key::Z);
                is_done
            };
            is_undone && again(both, Key::Z) && again(ctrl, Key::Y)
        }
        "Tab, Shift Tab" => {
            stage.focus("Snapshot A");
            stage.press(none, Key::Tab);
            let is_next = stage.has_keyboard("Snapshot B");
            stage.press(shift, Key::Tab);
            is_next && stage.has_keyboard("Snapshot A")
        }
        "border: arrows, Shift arrows" => {
            let left = |stage: &Stage| stage.harness.get_by_label("Undo").rect().left();
            stage.focus("Border of the panel");
            let before = left(&stage);
            stage.press(none, Key::ArrowLeft);
            let far = before - left(&stage);
            stage.press(shift, Key::ArrowRight);
            let near = far - (before - left(&stage));
            (far, near) == (20.0, 2.0)
        }
        "border: Home, End" => {
            let width = |stage: &Stage| stage.harness.get_by_label("Viewport").rect().width();
            stage.focus("Border of the panel");
            stage.press(none, Key::Home);
            let narrow = width(&stage);
            stage.press(none, Key::End);
            let wide = width(&stage);
            // Its widgets are as wide as they are.
            stage.press(none, Key::ArrowRight);
            narrow == 120.0 && wide > 900.0 && width(&stage) == wide && !stage.has_moved()
        }
        "region: Enter" => {
            stage.focus("Viewport");
            stage.type_text("r");
            stage.press(none, Key::Enter);
            let sent = stage.sent();
            matches!(sent[..], [Command::Region(Some([0.25, 0.25, 0.75, 0.75]))])
                && stage.has_keyboard("Left border of the region")
        }
        "ramp: click, Delete" => {
            let bar = stage.harness.get_by_label("ramp of paint").rect();
            let at = Pos2::new(bar.center().x, bar.top() + 12.0);
            stage.drag(at, at, PointerButton::Primary, none);
            let is_added = stage.is_there("ramp of paint stop 2");
            stage.press(none, Key::Delete);
            is_added && !stage.is_there("ramp of paint stop 2")
        }
        "ramp: arrows, Insert, Enter" => {
            stage.focus("ramp of paint stop 0");
            stage.press(none, Key::ArrowRight);
            let is_moved = stage.text().contains("ramp = [[0.01, ");
            stage.press(none, Key::Insert);
            let is_added = stage.is_there("ramp of paint stop 2");
            stage.press(none, Key::Enter);
            is_moved && is_added && stage.has_keyboard("ramp of paint colour")
        }
        "drag a texture" => {
            stage.click("Add a node");
            let start = stage.button("mask");
            let end = stage.center("factor of paint");
            stage.drag(start, end, PointerButton::Primary, none);
            stage.text().contains("factor = \"mask\"")
        }
        "drag a material" => {
            stage.click("All materials");
            stage.harness.run_steps(12);
            let start = stage.button("Show Wood");
            let header = stage.center("Material Iron");
            stage.drag(start, header, PointerButton::Primary, none);
            let on_another = stage.text().contains("over = \"Wood\"");
            let start = stage.button("Show Wood");
            let picture = stage.center("Viewport");
            stage.sent();
            stage.drag(start, picture, PointerButton::Primary, none);
            let is_drop = |c: &Command| matches!(c, Command::Pick(_, PickPurpose::Drop));
            on_another && stage.sent().iter().any(is_drop)
        }
        "Menu, Shift F10" => {
            stage.focus("Snapshot A");
            stage.press(shift, Key::F10);
            let by_one = stage.is_there("Forget A");
            stage.press(none, Key::Escape);
            let is_closed = !stage.is_there("Forget A");
            stage.press(none, Key::Menu);
            by_one && is_closed && stage.is_there("Forget A")
        }
        "?" => {
            stage.type_text("?");
            stage.is_there("save the look")
        }
        "Esc" => {
            stage.type_text("?");
            stage.press(none, Key::Escape);
            !stage.is_there("save the look")
        }
        _ => return None,
    })
}

fn does_on_the_graph(keys: &str) -> Option<bool> {
    let (none, shift, ctrl) = (Modifiers::NONE, Modifiers::SHIFT, Modifiers::COMMAND);
    let mut stage = Stage::with("Graph");
    let (rust, paint) = (stage.button("node rust"), stage.button("node paint"));
    let is_copied = |stage: &mut Stage| {
        stage.harness.event(Event::Copy);
        stage.harness.step();
        let commands = stage.harness.output().platform_output.commands.iter();
        let mut copied = commands.filter_map(|command| match command {
            egui::OutputCommand::CopyText(text) => Some(text.clone()),
            _ => None,
        });
        copied.next().unwrap_or_default()
    };
    let select_all = |stage: &mut Stage| {
        stage.harness.event(Event::PointerMoved(rust));
        stage.harness.run_steps(2);
        stage.press(ctrl, Key::A);
    };
    Some(match keys {
        "drag, wheel" => {
            let aside = paint + vec2(0.0, 160.0);
            stage.drag(aside, aside + vec2(30.0, 0.0), PointerButton::Middle, none);
            stage.button("node rust") != rust
        }
        "Shift click" => {
            stage.drag(rust, rust, PointerButton::Primary, none);
            stage.drag(paint, paint, PointerButton::Primary, shift);
            let copied = is_copied(&mut stage);
            copied.contains("[node.rust]") && copied.contains("[node.paint]")
        }
        "Shift drag" => {
            let cards = ["node rust", "node paint"].map(|label| {
                let card = stage.harness.get_by_role_and_label(Role::Button, label);
                card.rect()
            });
            let all = cards[0].union(cards[1]).expand(12.0);
            stage.drag(all.min, all.max, PointerButton::Primary, shift);
            let copied = is_copied(&mut stage);
            copied.contains("[node.rust]") && copied.contains("[node.paint]")
        }
        "Ctrl A" => {
            select_all(&mut stage);
            is_copied(&mut stage).contains("[node.rust]")
        }
        "Ctrl C, X, V" => {
            select_all(&mut stage);
            let copied = is_copied(&mut stage);
            stage.harness.event(Event::Paste(copied));
            stage.harness.run_steps(3);
            let is_pasted = stage.text().contains("[node.rust_2]");
            stage.harness.event(Event::Cut);
            stage.harness.run_steps(3);
            is_pasted && !stage.text().contains("[node.rust_2]")
        }
        "Ctrl D" => {
            select_all(&mut stage);
            stage.press(ctrl, Key::D);
            stage.text().contains("[node.rust_2]")
        }
        "Ctrl G" => {
            select_all(&mut stage);
            stage.press(ctrl, Key::G);
            stage.text().contains("[graph.Frame]")
        }
        "Delete" => {
            select_all(&mut stage);
            stage.press(none, Key::Delete);
            !stage.text().contains("[node.rust]")
        }
        "arrows" => {
            stage
                .harness
                .get_by_role_and_label(Role::Button, "material Iron")
                .focus();
            stage.harness.run_steps(3);
            stage.press(none, Key::ArrowLeft);
            let is_at = ["node rust", "node paint"].map(|card| stage.has_keyboard(card));
            stage.press(none, Key::Enter);
            let is_shown = ["Node rust", "Node paint"].map(|node| stage.is_there(node));
            is_at == is_shown && is_at.contains(&true)
        }
        "Shift arrows" => {
            stage
                .harness
                .get_by_role_and_label(Role::Button, "node rust")
                .focus();
            stage.harness.run_steps(3);
            stage.press(shift, Key::ArrowRight);
            stage.button("node rust") != rust
        }
        _ => return None,
    })
}

/// As the panels' snapshots: `UPDATE_SNAPSHOTS=1` writes it anew.
fn check(picture: &image::RgbImage, name: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/snapshots/{name}.png"));
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        let file = std::fs::File::create(file).expect("a file");
        let small = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::NoFilter);
        return picture.write_with_encoder(small).expect("written");
    }
    let kept = image::open(&file).expect("a picture").to_rgb8();
    assert_eq!(picture.dimensions(), kept.dimensions());
    let differ = |(a, b): &(&image::Rgb<u8>, &image::Rgb<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 24)
    };
    let differing = picture.pixels().zip(kept.pixels()).filter(differ).count();
    let share = differing as f64 / picture.pixels().len() as f64;
    // Not all processors round alike.
    if share > 0.002 {
        let seen = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
        picture.save(&seen).expect("written");
        panic!("{:.2} % differ: see {}", 100.0 * share, seen.display());
    }
}
