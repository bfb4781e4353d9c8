//! `[material.NAME]`: what a look says about a material.
//!
//! Values that a node may drive are listed in one table, [`INPUTS`]; the rest are keys of their own.

use glam::Vec3;

use super::reader::{Reader, choice, unit};
use super::value::{Field, Span, Spanned, Value};
use super::{AlphaLook, BlendLook, Input};

/// `[material.NAME]`: overrides of a glTF material, or a new one. What is absent stays as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialLook {
    /// The glTF material's name, or a new one.
    pub name: Spanned<String>,
    /// Values that a node may drive, by their keys; see [`Self::input`].
    inputs: Vec<(&'static str, Spanned<Input>)>,
    /// Metres per unit of `bump`.
    pub bump_scale: Option<Spanned<f32>>,
    /// Alpha of the base colour's factor.
    pub alpha: Option<Spanned<f32>>,
    /// `alpha_mode = "opaque" | "mask" | "blend"`.
    pub alpha_mode: Option<Spanned<AlphaLook>>,
    /// Threshold of `alpha_mode = "mask"`.
    pub alpha_cutoff: Option<Spanned<f32>>,
    /// The surface bounds a body and is no thin wall.
    pub solid: Option<Spanned<bool>>,
    /// Colour that white light has after `attenuation_distance` in the body.
    pub attenuation_color: Option<Spanned<Vec3>>,
    /// Metres.
    pub attenuation_distance: Option<Spanned<f32>>,
    /// 20 divided by the Abbe number of the body.
    pub dispersion: Option<Spanned<f32>>,
    /// Whose inside it is where bodies overlap: a whole number.
    pub priority: Option<Spanned<f32>>,
    /// Index of refraction of a thin film.
    pub iridescence_ior: Option<Spanned<f32>>,
    /// Both sides reflect and emit.
    pub double_sided: Option<Spanned<bool>>,
    /// The base colour is shown as it is.
    pub unlit: Option<Spanned<bool>>,
    /// This material is a blend of two others.
    pub blend: Option<Spanned<BlendLook>>,
}

/// What a constant of an input may be.
#[derive(Clone, Copy)]
enum Takes {
    /// A colour that isn't negative.
    Color,
    /// A colour that says how much of the light comes back: usually not beyond 1.
    ShareColor,
    /// 0 to 1.
    Share,
    /// Not negative; what it is.
    Positive(&'static str),
    /// An index of refraction.
    Ior,
    /// Any number.
    Number,
    /// Degrees; kept as radians.
    Angle,
    /// No constant: it must be driven.
    Nothing,
}

/// Everything that a node may drive, with the constants it takes instead.
const INPUTS: [(&str, Takes); 23] = [
    ("base_color", Takes::ShareColor),
    ("metallic", Takes::Share),
    ("roughness", Takes::Share),
    ("emission", Takes::Color),
    (
        "emission_strength",
        Takes::Positive("a number that isn't negative"),
    ),
    ("opacity", Takes::Share),
    ("normal", Takes::Nothing),
    ("bump", Takes::Nothing),
    ("specular", Takes::Share),
    ("specular_color", Takes::Color),
    ("ior", Takes::Ior),
    ("normal_scale", Takes::Number),
    ("transmission", Takes::Share),
    ("diffuse_transmission", Takes::Share),
    ("diffuse_transmission_color", Takes::ShareColor),
    ("coat", Takes::Share),
    ("coat_roughness", Takes::Share),
    ("sheen_color", Takes::ShareColor),
    ("sheen_roughness", Takes::Share),
    ("anisotropy", Takes::Share),
    ("anisotropy_rotation", Takes::Angle),
    ("iridescence", Takes::Share),
    (
        "iridescence_thickness",
        Takes::Positive("nanometres, not negative"),
    ),
];

/// The other keys.
const OTHERS: [&str; 13] = [
    "bump_scale",
    "alpha",
    "alpha_mode",
    "alpha_cutoff",
    "solid",
    "attenuation_color",
    "attenuation_distance",
    "dispersion",
    "priority",
    "iridescence_ior",
    "double_sided",
    "unlit",
    "blend",
];

impl MaterialLook {
    /// A table that overrides nothing yet.
    pub fn new(name: Spanned<String>) -> Self {
        Self {
            name,
            inputs: Vec::new(),
            bump_scale: None,
            alpha: None,
            alpha_mode: None,
            alpha_cutoff: None,
            solid: None,
            attenuation_color: None,
            attenuation_distance: None,
            dispersion: None,
            priority: None,
            iridescence_ior: None,
            double_sided: None,
            unlit: None,
            blend: None,
        }
    }

    /// What the look gives for a key such as `roughness`.
    pub fn input(&self, key: &str) -> Option<&Spanned<Input>> {
        self.inputs.iter().find(|(k, _)| *k == key).map(|(_, i)| i)
    }

    /// A constant for a key: linear colour, or a scalar in all three components.
    pub fn constant(&self, key: &str) -> Option<Vec3> {
        match self.input(key)?.value {
            Input::Constant(value) => Some(value),
            Input::Link(_) => None,
        }
    }

    /// Whether a node drives what the key means.
    pub fn is_driven(&self, key: &str) -> bool {
        self.input(key)
            .is_some_and(|input| matches!(input.value, Input::Link(_)))
    }

    /// All inputs that are given.
    pub fn inputs(&self) -> impl Iterator<Item = &Spanned<Input>> {
        self.inputs.iter().map(|(_, input)| input)
    }

    /// Where the first key that describes a surface is written, if there is one.
    fn first_surface_key(&self) -> Option<&Span> {
        fn at<T>(key: &Option<Spanned<T>>) -> Option<&Span> {
            key.as_ref().map(|k| &k.span)
        }
        let others = [
            at(&self.bump_scale),
            at(&self.alpha),
            at(&self.alpha_mode),
            at(&self.alpha_cutoff),
            at(&self.solid),
            at(&self.attenuation_color),
            at(&self.attenuation_distance),
            at(&self.dispersion),
            at(&self.priority),
            at(&self.iridescence_ior),
            at(&self.double_sided),
            at(&self.unlit),
        ];
        (others.into_iter().flatten())
            .chain(self.inputs().map(|input| &input.span))
            .min_by_key(|span| span.start)
    }
}

fn input(reader: &mut Reader, value: &Spanned<Value>, takes: Takes) -> Option<Spanned<Input>> {
    match takes {
        Takes::Color => reader.color_input(value),
        Takes::ShareColor => reader.share_color_input(value),
        Takes::Share => reader.unit_input(value),
        Takes::Positive(what) => reader.number_input(value, what, |x| x >= 0.0),
        Takes::Ior => reader.number_input(value, "0, or a number of at least 1", |x| {
            x == 0.0 || x >= 1.0
        }),
        Takes::Number => reader.number_input(value, "a number", |_| true),
        Takes::Angle => {
            let mut angle = reader.number_input(value, "degrees", |_| true)?;
            if let Input::Constant(degrees) = &mut angle.value {
                *degrees = degrees.map(f32::to_radians);
            }
            Some(angle)
        }
        Takes::Nothing => reader.link_input(value),
    }
}

/// Reads a table.
pub(super) fn material(
    reader: &mut Reader,
    name: &Spanned<String>,
    table: &[Field],
    _: &Span,
) -> Option<MaterialLook> {
    const MODES: [(&str, AlphaLook); 3] = [
        ("opaque", AlphaLook::Opaque),
        ("mask", AlphaLook::Mask),
        ("blend", AlphaLook::Blend),
    ];
    const POSITIVE: &str = "a number that isn't negative";
    let mut m = MaterialLook::new(name.clone());
    for Field { key, value } in table {
        if let Some(&(known, takes)) = INPUTS.iter().find(|(known, _)| *known == key.value) {
            m.inputs
                .extend(input(reader, value, takes).map(|i| (known, i)));
            continue;
        }
        match key.value.as_str() {
            "bump_scale" => m.bump_scale = reader.number(value, "metres per unit", |_| true),
            "alpha" => m.alpha = reader.number(value, "a number from 0 to 1", unit),
            "alpha_mode" => m.alpha_mode = choice(reader, value, &MODES),
            "alpha_cutoff" => m.alpha_cutoff = reader.number(value, POSITIVE, |x| x >= 0.0),
            "solid" => m.solid = reader.bool(value),
            "attenuation_color" => m.attenuation_color = reader.share_color(value),
            "attenuation_distance" => {
                m.attenuation_distance = reader.number(value, "metres greater than 0", |x| x > 0.0);
            }
            "dispersion" => m.dispersion = reader.number(value, POSITIVE, |x| x >= 0.0),
            "priority" => {
                m.priority = reader.number(value, "a whole number from -1000 to 1000", |x| {
                    x.fract() == 0.0 && x.abs() <= 1000.0
                });
            }
            "iridescence_ior" => {
                m.iridescence_ior = reader.number(value, "a number of at least 1", |x| x >= 1.0);
            }
            "double_sided" => m.double_sided = reader.bool(value),
            "unlit" => m.unlit = reader.bool(value),
            "blend" => m.blend = blend(reader, value),
            _ => {
                let keys: Vec<&str> = INPUTS.iter().map(|(k, _)| *k).chain(OTHERS).collect();
                reader.unknown_key(key, "[material.NAME]", &keys);
            }
        }
    }
    check(reader, &m);
    Some(m)
}

/// Reads `{ base, over, mask }`.
fn blend(reader: &mut Reader, value: &Spanned<Value>) -> Option<Spanned<BlendLook>> {
    const KEYS: [&str; 3] = ["base", "over", "mask"];
    const SHAPE: &str = "{ base = \"MATERIAL\", over = \"MATERIAL\", mask = \"NODE\" }";
    let table = reader.table(value, SHAPE)?;
    let (mut base, mut over, mut mask) = (None, None, None);
    for Field { key, value } in table {
        match key.value.as_str() {
            "base" => base = reader.text(value),
            "over" => over = reader.text(value),
            "mask" => mask = reader.unit_input(value),
            _ => reader.unknown_key(key, "`blend`", &KEYS),
        }
    }
    for required in KEYS {
        if !table.iter().any(|f| f.key.value == required) {
            reader.problem_with_note(
                &value.span,
                format!("`blend` needs `{required}`"),
                format!("as in {SHAPE}"),
            );
        }
    }
    Some(value.with(BlendLook {
        base: base?,
        over: over?,
        mask: mask?,
    }))
}

/// Points out keys that contradict each other, or have no effect.
fn check(reader: &mut Reader, m: &MaterialLook) {
    if let (Some(scale), None) = (&m.bump_scale, m.input("bump")) {
        reader.problem_with_note(
            &scale.span,
            "`bump_scale` has no effect without `bump`",
            "name the node that gives the height, as in bump = \"dents\"",
        );
    }
    if let (Some(color), None) = (&m.attenuation_color, &m.attenuation_distance) {
        reader.problem_with_note(
            &color.span,
            "`attenuation_color` needs `attenuation_distance`",
            "after how many metres light has that colour, as in attenuation_distance = 0.1",
        );
    }
    let has_alpha = m.alpha.is_some() || m.alpha_mode.is_some() || m.alpha_cutoff.is_some();
    if let (Some(opacity), true) = (m.input("opacity"), has_alpha) {
        reader.problem_with_note(
            &opacity.span,
            "`opacity` stands in place of alpha: give one of them",
            "leave out `alpha`, `alpha_mode` and `alpha_cutoff`, or `opacity`",
        );
    }
    if let (Some(blend), Some(key)) = (&m.blend, m.first_surface_key())
        && blend.value.base.value != m.name.value
    {
        reader.problem_with_note(
            key,
            format!(
                "[material.{}] is a blend of other materials and has no surface of its own",
                m.name.value
            ),
            format!(
                "set this on [material.{}] or [material.{}]",
                blend.value.base.value, blend.value.over.value
            ),
        );
    }
}
