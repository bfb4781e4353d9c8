//! A panel with a small look, and what its user does with it.

use std::path::Path;

use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use engine::procedural::TextureSources;
use engine::scene::{LightKind, Material, PunctualLight};
use engine::session::Document;
use glam::Vec3;
use patina_panels::{Form, ModelImage, SceneView, Textures, TexturesPanel};

use crate::picture::Painter;

pub(crate) const LOOK: &str = "# An old valve.\n\n[node.rust] # where it rusts\ntexture = \"mask\"\namount   = 0.25 # a quarter\n\n\
                    [node.paint]\ntexture = \"tint\"\ncolor = \"#7a3b12\"\n\n\
                    # What rusts.\n[material.Iron]\nbase_color = \"paint\" # driven\nroughness = 0.5\n";

const MASK: &str = "/// Where it rusts.\n/// @param amount share of the surface [0 .. 1] = 0.5\n/// @param scale size [0.1 .. 100] [log] [unit 1/m] = 4\n/// @param seed seed [seed] = 1\nfn userProc(amount: f32, scale: f32, seed: u32) -> f32 { return fract(scale * readAttr(WorldPos).x + f32(seed)) * amount; }";
const TINT: &str = "/// A colour.\n/// @param color the colour [color] = #808080\n/// @param ramp from dark to bright = [(0, #000000), (1, #ffffff)]\n/// @param factor how much = 1\nfn userProc(color: vec3f, ramp: ramp1D, factor: f32) -> vec3f { return color * factor * rampEval(ramp, 0.5).xyz; }";

const PICTURE: &str =
    "fn userProc(image: sam2D) -> vec4f { return tex2D(image, readAttr(TexCoord0).xy); }";

pub(crate) struct State {
    pub(crate) panel: TexturesPanel,
    pub(crate) document: Document,
    pub(crate) textures: Textures,
    pub(crate) materials: Vec<Material>,
    /// Of the model.
    pub(crate) images: Vec<ModelImage>,
    pub(crate) lights: Vec<PunctualLight>,
    /// Has the textures that the panel shows.
    pub(crate) painter: Painter,
    /// Something is asked over the panel.
    pub(crate) has_question: bool,
}

pub(crate) fn harness(form: Form) -> Harness<'static, State> {
    harness_of(form, LOOK, textures(), &["Iron", "Paint"])
}

/// A panel with another look that uses the same textures.
pub(crate) fn harness_with(form: Form, look: &str) -> Harness<'static, State> {
    harness_of(form, look, textures(), &["Iron", "Paint"])
}

fn textures() -> Textures {
    let mut sources = TextureSources::default();
    sources.insert("mask", MASK);
    sources.insert("tint", TINT);
    sources.insert("picture", PICTURE);
    sources.insert("broken", "fn userProc() -> f32 { return nothing; }");
    let textures = Textures::load(&sources);
    let good: Vec<&str> = textures
        .library
        .textures()
        .iter()
        .map(|t| t.name())
        .collect();
    assert_eq!(good, ["mask", "picture", "tint"], "{:?}", textures.broken);
    textures
}

/// A panel with any look, for a scene with some materials, the first of which is shown.
pub(crate) fn harness_of(
    form: Form,
    look: &str,
    textures: Textures,
    materials: &[&str],
) -> Harness<'static, State> {
    let material = |name: &&str| Material {
        name: (*name).to_owned(),
        ..Material::default()
    };
    let mut panel = TexturesPanel::default();
    panel.pick(materials[0]);
    panel.set_form(form);
    let state = State {
        panel,
        document: Document::new(Path::new("a.look.toml"), look).expect("a look"),
        textures,
        materials: materials.iter().map(material).collect(),
        images: Vec::new(),
        lights: vec![sun()],
        painter: Painter::default(),
        has_question: false,
    };
    let mut harness = Harness::builder()
        .with_size(vec2(700.0, 1600.0))
        .renderer(state.painter.clone())
        .build_ui_state(
            |ui, state: &mut State| {
                let scene = SceneView {
                    materials: &state.materials,
                    own: state.materials.len(),
                    images: &state.images,
                    lights: &state.lights,
                    camera: None,
                };
                state
                    .panel
                    .show(ui, &mut state.document, &state.textures, scene);
                if state.has_question {
                    let question = egui::Modal::new(egui::Id::unique("question"));
                    question.show(ui.ctx(), |ui| ui.label("Really?"));
                }
            },
            state,
        );
    harness.run();
    harness
}

pub(crate) fn text(harness: &Harness<'_, State>) -> String {
    harness.state().document.text().to_owned()
}

/// All lines but some are as in the look at first.
pub(crate) fn assert_kept(harness: &Harness<'_, State>, but: &str) {
    let text = text(harness);
    for line in LOOK.lines().filter(|line| !line.starts_with(but)) {
        assert!(
            text.lines().any(|l| l == line),
            "{line} is missing:\n{text}"
        );
    }
}

pub(crate) fn center(harness: &Harness<'_, State>, role: Role, label: &str) -> Pos2 {
    harness.get_by_role_and_label(role, label).rect().center()
}

pub(crate) fn drag(harness: &mut Harness<'_, State>, start: Pos2, by: Vec2) {
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

/// Writes into a field that stands alone, and leaves it by `Enter`.
pub(crate) fn write(harness: &mut Harness<'_, State>, label: &str, text: &str) {
    harness
        .get_by_role_and_label(Role::TextInput, label)
        .click();
    harness.run();
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text(text.to_owned()));
    harness.key_press(Key::Enter);
    harness.run();
}

fn sun() -> PunctualLight {
    PunctualLight {
        name: "Sun".to_owned(),
        intensity: Vec3::new(2.0, 1.0, 1.0),
        position: Vec3::ZERO,
        direction: Vec3::NEG_Y,
        range: f32::INFINITY,
        kind: LightKind::Directional,
    }
}
