//! The one table of what a material has: [`PARAMETERS`], a row per key of a look's `[material.NAME]`.
//!
//! Everything that must agree about a parameter reads its row: the look's reader (what a constant may be), the panels
//! (label, help, slider), the records and constants of the kernels (`engine::material_record`), what textures can drive
//! (`engine::procedural::Output`), and the table of `docs/look-file.md`, which a test compares. To add a scalar: a field of
//! [`Material`], a row, and what the kernel does with it.

mod table;

use glam::Vec3;

use crate::Material;

pub use table::PARAMETERS;

/// One key of `[material.NAME]`; all of them but `blend` have one.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// The key in a look, and the member's name in the kernels.
    pub key: &'static str,
    /// What panels call it.
    pub label: &'static str,
    /// What it means, as half a sentence.
    pub help: &'static str,
    /// What a constant of it may be, and how it is edited.
    pub takes: Takes,
    /// Shown before the others.
    pub is_common: bool,
    /// What a node has to give to drive it, and the number among everything that can be driven; `None` where it is
    /// always a constant.
    pub driven: Option<Driven>,
    /// Where it is kept in a [`Material`].
    pub field: Field,
    /// The record of the kernels has a member of this name.
    pub is_recorded: bool,
    /// What kernels must be able to do where it is driven or greater than 0.
    pub needs: Option<Feature>,
}

/// What a constant is, and how it is edited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Takes {
    /// Linear colour, not negative.
    Color {
        /// It says how much of the light comes back: there is a warning beyond 1.
        is_share: bool,
    },
    /// A number.
    Number(Number),
    /// A whole number.
    Whole {
        /// The largest, and less its sign the smallest.
        most: i32,
        /// Ends of the slider.
        slider: (i32, i32),
    },
    /// On or off.
    Flag,
    /// One of some words.
    Choice(&'static [&'static str]),
    /// No constant: a node drives it.
    Link,
}

/// What a number may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// Which ones are right.
    pub valid: Valid,
    /// Ends of the slider, which takes what lies beyond as text.
    pub slider: (f32, f32),
    /// The slider is logarithmic.
    pub is_log: bool,
    /// What it is counted in.
    pub unit: Unit,
}

/// Which numbers are right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Valid {
    /// All but those that are too large to reckon with: -1e6 to 1e6.
    Any,
    /// 0 to 1.
    Share,
    /// 0 and above.
    NotNegative,
    /// Above 0.
    Positive,
    /// 1 and above.
    AtLeastOne,
    /// The same, and 0 for an infinite index of refraction (KHR_materials_ior).
    Ior,
}

/// What a number is counted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Nothing.
    None,
    /// Metres.
    Metres,
    /// Nanometres.
    Nanometres,
    /// Degrees in a look and in panels, radians in [`Material`] and in the kernels.
    Degrees,
}

/// What a node has to give to drive a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One number.
    Scalar,
    /// One, three or four components.
    Color,
    /// Three or four components.
    Vector,
}

/// How a parameter is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Driven {
    /// What drives it.
    pub kind: Kind,
    /// Its number: results of a hit are stored in the order of these. Each of 0, 1, 2, ... occurs once, and the height
    /// of bump maps comes last, since it is known last.
    pub number: u32,
}

/// What kernels are able to do where a scene asks for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feature {
    /// Light goes through surfaces.
    Transmission,
    /// A surface has more than a metallic-roughness layer.
    Layers,
}

/// A constant, as a [`Material`] has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Constant {
    /// Linear colour.
    Color(Vec3),
    /// A number, or a whole one.
    Number(f32),
    /// On or off.
    Flag(bool),
    /// One of the words that the parameter takes.
    Word(&'static str),
}

/// Where a parameter is kept.
#[derive(Debug, Clone, Copy)]
pub enum Field {
    /// Nowhere: there is no constant.
    None,
    /// What it means is said together with others, see `MaterialLook::apply`; this is what holds without the key.
    Shown(fn(&Material) -> Constant),
    /// A number.
    Number(fn(&Material) -> f32, fn(&mut Material, f32)),
    /// A colour.
    Color(fn(&Material) -> Vec3, fn(&mut Material, Vec3)),
    /// On or off.
    Flag(fn(&Material) -> bool, fn(&mut Material, bool)),
}

impl Parameter {
    /// The row of a key.
    pub fn of(key: &str) -> Option<&'static Self> {
        PARAMETERS.iter().find(|parameter| parameter.key == key)
    }

    /// What a material has without the look's key; angles are radians. `None` where only a node can say it.
    pub fn constant(&self, material: &Material) -> Option<Constant> {
        Some(match self.field {
            Field::None => return None,
            Field::Shown(get) => get(material),
            Field::Number(get, _) => Constant::Number(get(material)),
            Field::Color(get, _) => Constant::Color(get(material)),
            Field::Flag(get, _) => Constant::Flag(get(material)),
        })
    }

    /// What glTF's default material has.
    pub fn default(&self) -> Option<Constant> {
        self.constant(&Material::default())
    }

    /// Whether a material has more of it than nothing.
    pub fn is_there(&self, material: &Material) -> bool {
        match self.constant(material) {
            Some(Constant::Color(color)) => color.max_element() > 0.0,
            Some(Constant::Number(number)) => number > 0.0,
            Some(Constant::Flag(flag)) => flag,
            Some(Constant::Word(_)) | None => false,
        }
    }

    /// What a look may write, as the documentation puts it: `0 to 1, or link`.
    pub fn takes_text(&self) -> String {
        let constant = match self.takes {
            Takes::Color { .. } => "colour".to_owned(),
            Takes::Number(number) => match (number.valid, number.unit) {
                (Valid::Share, _) => "0 to 1",
                (Valid::AtLeastOne, _) => "1 or more",
                (Valid::Ior, _) => "1 or more, 0",
                (_, Unit::None) => "number",
                (_, Unit::Metres) => "metres",
                (_, Unit::Nanometres) => "nanometres",
                (_, Unit::Degrees) => "degrees",
            }
            .to_owned(),
            Takes::Whole { .. } => "whole number".to_owned(),
            Takes::Flag => "`true`, `false`".to_owned(),
            Takes::Choice(words) => {
                let words: Vec<_> = words.iter().map(|word| format!("`\"{word}\"`")).collect();
                words.join(", ")
            }
            Takes::Link => return "link".to_owned(),
        };
        match self.driven {
            Some(_) => constant + ", or link",
            None => constant,
        }
    }
}

impl Number {
    /// Whether a number is right.
    pub fn is_valid(&self, x: f32) -> bool {
        match self.valid {
            // Squares of larger ones, and products with them, may be none.
            Valid::Any => x.abs() <= 1e6,
            Valid::Share => (0.0..=1.0).contains(&x),
            Valid::NotNegative => x >= 0.0,
            Valid::Positive => x > 0.0,
            Valid::AtLeastOne => x >= 1.0,
            Valid::Ior => x == 0.0 || x >= 1.0,
        }
    }

    /// What messages ask for.
    pub fn wanted(&self) -> &'static str {
        match (self.valid, self.unit) {
            (Valid::Share, _) => "a number from 0 to 1",
            (Valid::AtLeastOne, _) => "a number of at least 1",
            (Valid::Ior, _) => "0, or a number of at least 1",
            (Valid::Any, Unit::None) => "a number from -1e6 to 1e6",
            (Valid::Any, Unit::Metres) => "metres from -1e6 to 1e6",
            (Valid::Any, Unit::Nanometres) => "nanometres from -1e6 to 1e6",
            (Valid::Any, Unit::Degrees) => "degrees from -1e6 to 1e6",
            (Valid::NotNegative, Unit::None) => "a number that isn't negative",
            (Valid::NotNegative, Unit::Metres) => "metres, not negative",
            (Valid::NotNegative, Unit::Nanometres) => "nanometres, not negative",
            (Valid::NotNegative, Unit::Degrees) => "degrees, not negative",
            (Valid::Positive, Unit::None) => "a number greater than 0",
            (Valid::Positive, Unit::Metres) => "metres greater than 0",
            (Valid::Positive, Unit::Nanometres) => "nanometres greater than 0",
            (Valid::Positive, Unit::Degrees) => "degrees greater than 0",
        }
    }
}

impl Unit {
    /// As it stands behind a number.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::None => "",
            Self::Metres => "m",
            Self::Nanometres => "nm",
            Self::Degrees => "°",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_keep_what_they_are_given() {
        for parameter in &PARAMETERS {
            let mut material = Material::default();
            match parameter.field {
                Field::Number(get, set) if parameter.is_recorded => {
                    set(&mut material, 0.0);
                    assert_eq!(get(&material), 0.0, "{}", parameter.key);
                    set(&mut material, 1.0);
                    assert_eq!(get(&material), 1.0, "{}", parameter.key);
                }
                Field::Color(get, set) => {
                    set(&mut material, Vec3::new(0.1, 0.2, 0.3));
                    assert_eq!(
                        get(&material),
                        Vec3::new(0.1, 0.2, 0.3),
                        "{}",
                        parameter.key
                    );
                }
                Field::Flag(get, set) => {
                    set(&mut material, true);
                    assert!(get(&material), "{}", parameter.key);
                }
                _ => {}
            }
        }
    }

    #[test]
    fn kinds_of_constants_and_of_fields_agree() {
        for parameter in &PARAMETERS {
            let agrees = match (parameter.takes, parameter.default()) {
                (Takes::Color { .. }, Some(Constant::Color(_)))
                | (Takes::Whole { .. }, Some(Constant::Number(_)))
                | (Takes::Flag, Some(Constant::Flag(_)))
                | (Takes::Link, None) => true,
                (Takes::Number(number), Some(Constant::Number(default))) => {
                    number.is_valid(default)
                        && number.is_valid(number.slider.1)
                        && (number.is_log || number.is_valid(number.slider.0))
                }
                (Takes::Choice(words), Some(Constant::Word(word))) => words.contains(&word),
                _ => false,
            };
            assert!(agrees, "{}", parameter.key);
        }
    }

    #[test]
    fn keys_are_unique() {
        let mut keys: Vec<_> = PARAMETERS.iter().map(|parameter| parameter.key).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), PARAMETERS.len());
    }
}
