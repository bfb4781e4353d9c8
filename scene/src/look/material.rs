//! `[material.NAME]`: what a look says about a material. Which keys there are, and what each takes, says
//! [`PARAMETERS`]; only `blend` and `group` are no parameters.

use glam::Vec3;

use crate::material_parameters::{Field as Kept, PARAMETERS, Parameter, Takes, Unit};
use crate::{AlphaMode, Material};

use super::light;
use super::reader::{Reader, choice};
use super::value::{Field, Span, Spanned, Value};
use super::{BlendLook, Input};

/// `[material.NAME]`: overrides of a glTF material, or a new one. What is absent stays as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialLook {
    /// The glTF material's name, or a new one.
    pub name: Spanned<String>,
    /// Numbers, colours and links, by their keys; see [`Self::input`].
    inputs: Vec<(&'static str, Spanned<Input>)>,
    flags: Vec<(&'static str, Spanned<bool>)>,
    words: Vec<(&'static str, Spanned<&'static str>)>,
    /// This material is a blend of two others.
    pub blend: Option<Spanned<BlendLook>>,
    /// The group of lights that what it emits belongs to.
    pub group: Option<Spanned<String>>,
}

fn find<'l, T>(list: &'l [(&'static str, T)], key: &str) -> Option<&'l T> {
    list.iter().find(|(k, _)| *k == key).map(|(_, value)| value)
}

impl MaterialLook {
    /// A table that overrides nothing yet.
    pub fn new(name: Spanned<String>) -> Self {
        Self {
            name,
            inputs: Vec::new(),
            flags: Vec::new(),
            words: Vec::new(),
            blend: None,
            group: None,
        }
    }

    /// What the look gives for a key that takes a number, a colour or a link, such as `roughness`.
    pub fn input(&self, key: &str) -> Option<&Spanned<Input>> {
        find(&self.inputs, key)
    }

    /// A constant for such a key: linear colour, or a scalar in all three components; angles are radians.
    pub fn constant(&self, key: &str) -> Option<Vec3> {
        match self.input(key)?.value {
            Input::Constant(value) => Some(value),
            Input::Link(_) => None,
        }
    }

    /// What the look gives for a key that is on or off.
    pub fn flag(&self, key: &str) -> Option<&Spanned<bool>> {
        find(&self.flags, key)
    }

    /// What the look gives for a key that takes one of some words.
    pub fn word(&self, key: &str) -> Option<&Spanned<&'static str>> {
        find(&self.words, key)
    }

    /// Whether a node drives what the key means.
    pub fn is_driven(&self, key: &str) -> bool {
        self.input(key)
            .is_some_and(|input| matches!(input.value, Input::Link(_)))
    }

    /// All numbers, colours and links that are given.
    pub fn inputs(&self) -> impl Iterator<Item = &Spanned<Input>> {
        self.inputs.iter().map(|(_, input)| input)
    }

    /// Takes from another table what this one doesn't say.
    pub fn stand_over(&mut self, other: Self) {
        let inputs = other.inputs.into_iter();
        let missing = inputs.filter(|(key, _)| find(&self.inputs, key).is_none());
        let missing: Vec<_> = missing.collect();
        self.inputs.extend(missing);
        let flags = other.flags.into_iter();
        let missing = flags.filter(|(key, _)| find(&self.flags, key).is_none());
        let missing: Vec<_> = missing.collect();
        self.flags.extend(missing);
        let words = other.words.into_iter();
        let missing = words.filter(|(key, _)| find(&self.words, key).is_none());
        let missing: Vec<_> = missing.collect();
        self.words.extend(missing);
        self.blend = self.blend.take().or(other.blend);
        self.group = self.group.take().or(other.group);
    }

    /// Gives a material the constants of the table.
    pub fn apply(&self, material: &mut Material) {
        for parameter in &PARAMETERS {
            let key = parameter.key;
            match parameter.field {
                Kept::Number(_, set) => {
                    if let Some(value) = self.constant(key) {
                        set(material, value.x);
                    }
                }
                Kept::Color(_, set) => {
                    if let Some(value) = self.constant(key) {
                        set(material, value);
                    }
                }
                Kept::Flag(_, set) => {
                    if let Some(flag) = self.flag(key) {
                        set(material, flag.value);
                    }
                }
                Kept::None | Kept::Shown(_) => {}
            }
        }
        let cutoff = match (self.constant("alpha_cutoff"), material.alpha_mode) {
            (Some(cutoff), _) => cutoff.x,
            (None, AlphaMode::Mask { cutoff }) => cutoff,
            (None, _) => 0.5,
        };
        material.alpha_mode = match (
            self.word("alpha_mode").map(|w| w.value),
            material.alpha_mode,
        ) {
            (Some("opaque"), _) => AlphaMode::Opaque,
            (Some("blend"), _) => AlphaMode::Blend,
            (Some("mask"), _) | (None, AlphaMode::Mask { .. }) => AlphaMode::Mask { cutoff },
            (_, mode) => mode,
        };
    }

    /// Where the first key that describes a surface is written, if there is one.
    fn first_surface_key(&self) -> Option<&Span> {
        let inputs = self.inputs.iter().map(|(_, value)| &value.span);
        let flags = self.flags.iter().map(|(_, value)| &value.span);
        let words = self.words.iter().map(|(_, value)| &value.span);
        inputs
            .chain(flags)
            .chain(words)
            .min_by_key(|span| span.start)
    }

    /// Reads the key of a parameter.
    fn read(&mut self, reader: &mut Reader, parameter: &'static Parameter, value: &Spanned<Value>) {
        let key = parameter.key;
        match parameter.takes {
            Takes::Flag => self
                .flags
                .extend(reader.bool(value).map(|flag| (key, flag))),
            Takes::Choice(words) => {
                let words: Vec<_> = words.iter().map(|&word| (word, word)).collect();
                let word = choice(reader, value, &words);
                self.words.extend(word.map(|word| (key, word)));
            }
            _ => self
                .inputs
                .extend(input(reader, parameter, value).map(|input| (key, input))),
        }
    }
}

/// A number, a colour or a link.
fn input(
    reader: &mut Reader,
    parameter: &Parameter,
    value: &Spanned<Value>,
) -> Option<Spanned<Input>> {
    if let (Some(_), Value::Text(text)) = (parameter.driven, &value.value)
        && !(matches!(parameter.takes, Takes::Color { .. }) && text.starts_with('#'))
    {
        return reader.link(value, text);
    }
    let constant = match parameter.takes {
        Takes::Color { is_share: true } => reader.share_color(value)?,
        Takes::Color { is_share: false } => reader.color(value)?,
        Takes::Number(number) => {
            let wanted = match parameter.driven {
                Some(_) => &format!("{}, or the name of a node", number.wanted()),
                None => number.wanted(),
            };
            let given = reader.number(value, wanted, |x| number.is_valid(x))?;
            let kept = match number.unit {
                Unit::Degrees => given.value.to_radians(),
                _ => given.value,
            };
            value.with(Vec3::splat(kept))
        }
        Takes::Whole { most, .. } => {
            let wanted = format!("a whole number from {} to {most}", -most);
            let is_valid = |x: f32| x.fract() == 0.0 && x.abs() <= most as f32;
            let given = reader.number(value, &wanted, is_valid)?;
            value.with(Vec3::splat(given.value))
        }
        Takes::Flag | Takes::Choice(_) | Takes::Link => {
            reader.wrong_kind(value, "the name of a node");
            return None;
        }
    };
    Some(value.with(Input::Constant(constant.value)))
}

/// Reads a table.
pub(super) fn material(
    reader: &mut Reader,
    name: &Spanned<String>,
    table: &[Field],
    _: &Span,
) -> Option<MaterialLook> {
    let mut m = MaterialLook::new(name.clone());
    for Field { key, value } in table {
        match (Parameter::of(&key.value), key.value.as_str()) {
            (Some(parameter), _) => m.read(reader, parameter, value),
            (None, "blend") => m.blend = blend(reader, value),
            (None, "group") => m.group = light::group(reader, value),
            (None, _) => {
                let parameters = PARAMETERS.iter().map(|parameter| parameter.key);
                let keys: Vec<&str> = parameters.chain(["blend", "group"]).collect();
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
    if let (Some(scale), None) = (m.input("bump_scale"), m.input("bump")) {
        reader.problem_with_note(
            &scale.span,
            "`bump_scale` has no effect without `bump`",
            "name the node that gives the height, as in bump = \"dents\"",
        );
    }
    let has_alpha = ["alpha", "alpha_cutoff"]
        .iter()
        .any(|key| m.input(key).is_some())
        || m.word("alpha_mode").is_some();
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
