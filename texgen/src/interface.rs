//! What a texture shows to the outside: its parameters, their types, ranges and defaults, and its output.
//! Plain data; `parse` fills it from naga's module and `metadata` from the `@param` lines.

use crate::attribute::{Attribute, BuiltinAttribute};
use crate::value::{OutputType, ParameterType, Value};

/// One of several values that `userProc` returns: a member of its struct.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedOutput {
    /// The name of the member; what a link takes it by.
    pub name: String,
    /// Its type.
    pub ty: OutputType,
    /// What its `@output` line says; empty where there is none.
    pub label: String,
}

/// One parameter of `userProc`.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// The name in `userProc`'s signature and in a look file.
    pub name: String,
    /// Its type.
    pub ty: ParameterType,
    /// What a user interface shows; the name where the file gives none.
    pub label: String,
    /// The value of a node that sets none. `None` for images only: they must be set.
    pub default: Option<Value>,
    /// The values that make sense, for sliders; nothing enforces it.
    pub range: Option<(f32, f32)>,
    /// The values one usually wants, for sliders: inside `range`.
    pub soft_range: Option<(f32, f32)>,
    /// Unit as shown to people (`m`, `1/m`, ...).
    pub unit: Option<String>,
    /// How a user interface edits it.
    pub widget: Widget,
    /// For images: the pixels are numbers such as heights or normals, not colours, and are not converted from sRGB
    /// unless the look says so.
    pub is_data: bool,
    /// What it takes at the hit where it has neither a link nor a constant of its own.
    pub attribute: Option<Attribute>,
}

impl Parameter {
    /// Whether it is a position or texture coordinates that come with the width of the pixel there in `w`, in the same units.
    pub fn is_coordinate(&self) -> bool {
        self.ty == ParameterType::Vec4 && self.pixel_component().is_some()
    }

    /// The component of `Footprint` that goes with its attribute, if that is a place.
    pub(crate) fn pixel_component(&self) -> Option<&'static str> {
        use BuiltinAttribute::{LocalPos, TexCoord0, TexCoord1, WorldPos};
        match &self.attribute {
            Some(Attribute::Builtin(WorldPos)) => Some("x"),
            Some(Attribute::Builtin(TexCoord0 | TexCoord1)) => Some("y"),
            Some(Attribute::Builtin(LocalPos)) => Some("z"),
            _ => None,
        }
    }
}

/// How a user interface edits a parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Widget {
    /// A number field or slider, as the type demands.
    #[default]
    Plain,
    /// A colour picker; components are linear Rec.709.
    Color,
    /// Shown in degrees, kept in radians.
    Angle,
    /// A logarithmic slider.
    Log,
    /// Shown in percent, kept as a fraction.
    Percent,
    /// A whole number without meaning: a button that draws another one.
    Seed,
}
