//! The keys of a material that the panel shows, with what a constant of each may be.
//!
//! The engine's reader of looks decides what is right; the tests here keep both in step.

use engine::procedural::Output;
use engine::scene::look::{Value, color};
use engine::scene::{AlphaMode, Material};
use glam::Vec3;

/// What a constant is, and how it is edited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Takes {
    /// Linear colour.
    Color,
    /// A number on a slider.
    Number {
        range: (f32, f32),
        is_log: bool,
        unit: &'static str,
    },
    /// A whole number.
    Whole { range: (i32, i32) },
    /// On or off.
    Bool,
    /// One of some words.
    Choice(&'static [&'static str]),
    /// No constant: a node drives it.
    Link,
}

/// One key of `[material.NAME]`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Key {
    pub(crate) name: &'static str,
    pub(crate) label: &'static str,
    pub(crate) help: &'static str,
    pub(crate) takes: Takes,
    /// Shown before the others.
    pub(crate) is_common: bool,
}

const fn number(from: f32, to: f32, unit: &'static str) -> Takes {
    Takes::Number {
        range: (from, to),
        is_log: false,
        unit,
    }
}

const fn log(from: f32, to: f32, unit: &'static str) -> Takes {
    Takes::Number {
        range: (from, to),
        is_log: true,
        unit,
    }
}

const SHARE: Takes = number(0.0, 1.0, "");

const fn common(name: &'static str, label: &'static str, takes: Takes, help: &'static str) -> Key {
    Key {
        name,
        label,
        help,
        takes,
        is_common: true,
    }
}

const fn rare(name: &'static str, label: &'static str, takes: Takes, help: &'static str) -> Key {
    Key {
        is_common: false,
        ..common(name, label, takes, help)
    }
}

/// All keys but `blend`, in the order in which they are shown.
pub(crate) const KEYS: [Key; 35] = [
    common(
        "base_color",
        "Base colour",
        Takes::Color,
        "colour of a dielectric's body, or of a metal's reflection",
    ),
    common(
        "metallic",
        "Metallic",
        SHARE,
        "0 is a dielectric, 1 a metal",
    ),
    common("roughness", "Roughness", SHARE, "perceptual roughness"),
    common(
        "emission",
        "Emission",
        Takes::Color,
        "emitted radiance, W/m²/sr",
    ),
    common(
        "emission_strength",
        "Emission strength",
        log(0.0, 1000.0, ""),
        "factor on the emission",
    ),
    common(
        "normal",
        "Normal",
        Takes::Link,
        "shading normal in the world",
    ),
    common("bump", "Bump", Takes::Link, "height above the surface"),
    rare(
        "bump_scale",
        "Bump scale",
        log(0.0, 1.0, "m"),
        "metres per unit of the bump",
    ),
    rare(
        "normal_scale",
        "Normal map scale",
        number(0.0, 2.0, ""),
        "factor on the normal map of the scene",
    ),
    rare(
        "opacity",
        "Opacity",
        SHARE,
        "how much of the surface is there, in place of alpha",
    ),
    rare("alpha", "Alpha", SHARE, "alpha of the base colour"),
    rare(
        "alpha_mode",
        "Alpha mode",
        Takes::Choice(&["opaque", "mask", "blend"]),
        "what alpha means",
    ),
    rare(
        "alpha_cutoff",
        "Alpha cutoff",
        SHARE,
        "threshold of the alpha mode \"mask\"",
    ),
    rare(
        "specular",
        "Specular",
        SHARE,
        "weight of a dielectric's reflection",
    ),
    rare(
        "specular_color",
        "Specular colour",
        Takes::Color,
        "tint of it at normal incidence",
    ),
    rare(
        "ior",
        "Index of refraction",
        number(1.0, 3.0, ""),
        "of the dielectric",
    ),
    rare(
        "transmission",
        "Transmission",
        SHARE,
        "share of the light below the reflection that goes through",
    ),
    rare(
        "solid",
        "Solid",
        Takes::Bool,
        "the surface bounds a body, which refracts",
    ),
    rare(
        "attenuation_color",
        "Attenuation colour",
        Takes::Color,
        "white light has this colour after the attenuation distance",
    ),
    rare(
        "attenuation_distance",
        "Attenuation distance",
        log(0.0001, 10.0, "m"),
        "way through the body",
    ),
    rare(
        "dispersion",
        "Dispersion",
        number(0.0, 2.0, ""),
        "20 divided by the Abbe number of the body",
    ),
    rare(
        "priority",
        "Priority",
        Takes::Whole { range: (-10, 10) },
        "whose inside it is where bodies overlap",
    ),
    rare(
        "diffuse_transmission",
        "Diffuse transmission",
        SHARE,
        "share of the diffuse light that comes out on the other side",
    ),
    rare(
        "diffuse_transmission_color",
        "Diffuse transmission colour",
        Takes::Color,
        "its colour",
    ),
    rare("coat", "Coat", SHARE, "weight of a clear coat"),
    rare(
        "coat_roughness",
        "Coat roughness",
        SHARE,
        "perceptual roughness of the coat",
    ),
    rare(
        "sheen_color",
        "Sheen colour",
        Takes::Color,
        "sheen of cloth; black is none",
    ),
    rare(
        "sheen_roughness",
        "Sheen roughness",
        SHARE,
        "perceptual roughness of the sheen",
    ),
    rare(
        "anisotropy",
        "Anisotropy",
        SHARE,
        "how far reflections are stretched",
    ),
    rare(
        "anisotropy_rotation",
        "Anisotropy rotation",
        number(-180.0, 180.0, "°"),
        "where to, counter-clockwise from the tangent",
    ),
    rare("iridescence", "Iridescence", SHARE, "weight of a thin film"),
    rare(
        "iridescence_thickness",
        "Film thickness",
        number(0.0, 1200.0, "nm"),
        "of the thin film",
    ),
    rare(
        "iridescence_ior",
        "Film index of refraction",
        number(1.0, 3.0, ""),
        "of the thin film",
    ),
    rare(
        "double_sided",
        "Double sided",
        Takes::Bool,
        "both sides reflect and emit",
    ),
    rare(
        "unlit",
        "Unlit",
        Takes::Bool,
        "the base colour is shown as it is",
    ),
];

impl Key {
    /// What a node drives with it.
    pub(crate) fn output(&self) -> Option<Output> {
        let mut all = Output::ALL.into_iter();
        all.find(|output| output.key() == self.name)
    }

    /// What it is without the look's key: that of the material as it is shown.
    pub(crate) fn constant(&self, material: &Material) -> Option<Value> {
        let m = material;
        let rgb = |color: Vec3| Value::numbers(&color.to_array());
        let number = Value::number;
        Some(match self.name {
            "base_color" => rgb(m.base_color.truncate()),
            "metallic" => number(m.metallic),
            "roughness" => number(m.roughness),
            "emission" => rgb(m.emission),
            "emission_strength" => number(1.0),
            "normal_scale" => number(m.normal_scale),
            "bump_scale" | "opacity" => number(1.0),
            "alpha" => number(m.base_color.w),
            "alpha_mode" => Value::Text(
                match m.alpha_mode {
                    AlphaMode::Opaque => "opaque",
                    AlphaMode::Mask { .. } => "mask",
                    AlphaMode::Blend => "blend",
                }
                .to_owned(),
            ),
            "alpha_cutoff" => number(match m.alpha_mode {
                AlphaMode::Mask { cutoff } => cutoff,
                _ => 0.5,
            }),
            "specular" => number(m.specular),
            "specular_color" => rgb(m.specular_color),
            "ior" => number(m.ior),
            "transmission" => number(m.transmission),
            "solid" => Value::Bool(m.is_solid),
            "attenuation_color" => rgb(Vec3::ONE),
            "attenuation_distance" => number(1.0),
            "dispersion" => number(m.dispersion),
            "priority" => Value::Integer(m.priority.into()),
            "diffuse_transmission" => number(m.diffuse_transmission),
            "diffuse_transmission_color" => rgb(m.diffuse_transmission_color),
            "coat" => number(m.coat),
            "coat_roughness" => number(m.coat_roughness),
            "sheen_color" => rgb(m.sheen_color),
            "sheen_roughness" => number(m.sheen_roughness),
            "anisotropy" => number(m.anisotropy),
            "anisotropy_rotation" => number(m.anisotropy_rotation.to_degrees()),
            "iridescence" => number(m.iridescence),
            "iridescence_thickness" => number(m.iridescence_thickness[1]),
            "iridescence_ior" => number(m.iridescence_ior),
            "double_sided" => Value::Bool(m.double_sided),
            "unlit" => Value::Bool(m.unlit),
            _ => return None,
        })
    }

    /// A constant as the widget of this key takes it; `None` where `written` is something else, such as a link.
    pub(crate) fn shown(&self, written: &Value) -> Option<texgen::Value> {
        use texgen::Value as V;
        Some(match self.takes {
            Takes::Color => match written.as_number() {
                Some(x) => V::Vec3([x as f32; 3]),
                None => V::Vec3(color(written).ok()?.to_array()),
            },
            Takes::Number { .. } => V::F32(written.as_number()? as f32),
            Takes::Whole { .. } => V::I32(written.as_number()? as i32),
            Takes::Bool => match written {
                Value::Bool(b) => V::Bool(*b),
                _ => return None,
            },
            Takes::Choice(_) | Takes::Link => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use engine::session::{Document, Edit, written};

    use super::*;

    #[test]
    fn everything_a_node_can_drive_is_there() {
        for output in Output::ALL {
            assert!(
                KEYS.iter().any(|key| key.name == output.key()),
                "{output:?}"
            );
        }
    }

    #[test]
    fn looks_take_what_the_widgets_give() {
        use texgen::Value as V;
        for key in &KEYS {
            let values = match key.takes {
                Takes::Color => vec![V::Vec3([0.0; 3]), V::Vec3([0.2, 1.0, 3.0])],
                Takes::Number { range, .. } => vec![V::F32(range.0), V::F32(range.1)],
                Takes::Whole { range } => vec![V::I32(range.0), V::I32(range.1)],
                Takes::Bool => vec![V::Bool(true), V::Bool(false)],
                Takes::Choice(_) | Takes::Link => vec![],
            };
            let words = match key.takes {
                Takes::Choice(words) => words.iter().map(|&w| Value::Text(w.into())).collect(),
                Takes::Link => vec![Value::Text("n".into())],
                _ => vec![],
            };
            for value in values.iter().map(written).chain(words) {
                let head = "[node.n]\ntexture = 't'\n[material.M]\nattenuation_distance = 1\n";
                let bump = if key.name == "bump_scale" {
                    "bump = 'n'\n"
                } else {
                    ""
                };
                let text = format!("{head}{bump}");
                let mut document = Document::new(Path::new("a"), &text).expect("a look");
                let edit = Edit::material("M", key.name, value.clone());
                let applied = document.apply(key.label, &[edit], None);
                applied.unwrap_or_else(|why| panic!("{} = {value:?}: {why}", key.name));
            }
        }
    }

    #[test]
    fn every_constant_has_a_widget() {
        let material = Material::default();
        for key in &KEYS {
            let constant = key.constant(&material);
            match key.takes {
                Takes::Link => assert!(constant.is_none()),
                Takes::Choice(words) => {
                    let is_known = |v: &Value| words.iter().any(|&w| *v == Value::Text(w.into()));
                    assert!(constant.is_some_and(|v| is_known(&v)), "{}", key.name);
                }
                _ => assert!(
                    constant.and_then(|v| key.shown(&v)).is_some(),
                    "{}",
                    key.name
                ),
            }
        }
    }
}
