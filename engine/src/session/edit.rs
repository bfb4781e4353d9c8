//! What can be changed while rendering: keys of the look's tables, written as a look file would have them.

use texgen::{Diagnostics, Interpolation, Ramp};

use crate::scene::look::{AoDirection, AoSettings, Field, LookDocument, Section, Spanned, Value};

/// One change of the look. It can be sent as JSON: see [`json`](super::json).
#[derive(Debug, Clone, PartialEq)]
pub enum Edit {
    /// Sets a key of a table; both are made where they are missing.
    Set {
        /// The table.
        section: Section,
        /// The key; `blend.mask` is a key of the table `blend`.
        key: String,
        /// As in a look file.
        value: Value,
    },
    /// Takes a key away: what it says is as without it.
    Clear {
        /// The table.
        section: Section,
        /// The key.
        key: String,
    },
    /// Takes a table away: a node that nothing reads any more, the overrides of a material.
    Remove {
        /// The table.
        section: Section,
    },
}

impl Edit {
    /// A parameter of a node gets a constant. Images have no value that a look could name: [`Edit::Set`] them by path.
    pub fn argument(node: &str, parameter: &str, value: &texgen::Value) -> Self {
        Self::set(Section::Node(node.to_owned()), parameter, written(value))
    }

    /// A parameter of a node is linked to another one: `"rust_mask"`, `"rust_mask.x"`.
    pub fn link(node: &str, parameter: &str, link: &str) -> Self {
        let value = Value::Text(link.to_owned());
        Self::set(Section::Node(node.to_owned()), parameter, value)
    }

    /// A parameter has its default again.
    pub fn reset(node: &str, parameter: &str) -> Self {
        Self::Clear {
            section: Section::Node(node.to_owned()),
            key: parameter.to_owned(),
        }
    }

    /// A new node of a texture.
    pub fn add_node(node: &str, texture: &str) -> Self {
        let value = Value::Text(texture.to_owned());
        Self::set(Section::Node(node.to_owned()), "texture", value)
    }

    /// A node that nothing reads is taken away.
    pub fn remove_node(node: &str) -> Self {
        Self::Remove {
            section: Section::Node(node.to_owned()),
        }
    }

    /// A key of a material: a constant, or the name of a node that drives it.
    pub fn material(material: &str, key: &str, value: Value) -> Self {
        Self::set(Section::Material(material.to_owned()), key, value)
    }

    /// A material has for a key what the scene says.
    pub fn reset_material(material: &str, key: &str) -> Self {
        Self::Clear {
            section: Section::Material(material.to_owned()),
            key: key.to_owned(),
        }
    }

    /// How an AO table is traced: one edit for each setting.
    pub fn ao(table: &str, settings: &AoSettings) -> [Self; 4] {
        let set = |key, value| Self::set(Section::Ao(table.to_owned()), key, value);
        let direction = match settings.direction {
            AoDirection::Outside => "outside",
            AoDirection::Inside => "inside",
            AoDirection::Both => "both",
        };
        [
            set("distance", Value::number(settings.distance)),
            set("direction", Value::Text(direction.to_owned())),
            set("samples", Value::Integer(settings.samples.into())),
            set("same_object", Value::Bool(settings.same_object)),
        ]
    }

    /// A key of `environment`, such as `rotation` (degrees) or `intensity`.
    pub fn environment(key: &str, value: Value) -> Self {
        Self::set(Section::Environment, key, value)
    }

    /// A key of `[camera]`, such as `position`.
    pub fn camera(key: &str, value: Value) -> Self {
        Self::set(Section::Camera, key, value)
    }

    /// A key of `[view]`, such as `exposure` (stops).
    pub fn view(key: &str, value: Value) -> Self {
        Self::set(Section::View, key, value)
    }

    /// Any key of any table.
    pub fn set(section: Section, key: &str, value: Value) -> Self {
        Self::Set {
            section,
            key: key.to_owned(),
            value,
        }
    }

    /// Makes the change in a text.
    ///
    /// # Errors
    /// Something that is no table is in the way: says what.
    pub fn write(&self, document: &mut LookDocument) -> Result<(), String> {
        match self {
            Self::Set {
                section,
                key,
                value,
            } => return document.set(section, key, value),
            Self::Clear { section, key } => document.remove(section, key),
            Self::Remove { section } => document.remove_table(section),
        }
        Ok(())
    }

    /// The table that is changed.
    pub fn section(&self) -> &Section {
        match self {
            Self::Set { section, .. } | Self::Clear { section, .. } | Self::Remove { section } => {
                section
            }
        }
    }
}

/// A constant as a look writes it, exact to the last bit.
pub fn written(value: &texgen::Value) -> Value {
    use texgen::Value as V;
    let list = |items: Vec<Value>| {
        let items = items.into_iter().map(|item| Spanned::new(item, 0..0));
        Value::List(items.collect())
    };
    match value {
        V::F32(x) => Value::number(*x),
        V::I32(x) => Value::Integer((*x).into()),
        V::U32(x) => Value::Integer((*x).into()),
        V::Bool(x) => Value::Bool(*x),
        V::Vec2(x) => Value::numbers(x),
        V::Vec3(x) => Value::numbers(x),
        V::Vec4(x) => Value::numbers(x),
        V::Mat3(columns) => list(columns.iter().map(|c| Value::numbers(c)).collect()),
        V::Mat4(columns) => list(columns.iter().map(|c| Value::numbers(c)).collect()),
        V::Image(handle) => Value::Text(format!("image {handle}")),
        V::Ramp(ramp) => written_ramp(ramp),
        V::Array(items) => list(items.iter().map(written).collect()),
    }
}

fn written_ramp(ramp: &Ramp) -> Value {
    let unplaced = |value| Spanned::new(value, 0..0);
    let stop = |(at, rgba): &(f32, [f32; 4])| {
        let (at, color) = (Value::number(*at), Value::numbers(rgba));
        unplaced(Value::List(vec![unplaced(at), unplaced(color)]))
    };
    let stops = Value::List(ramp.stops.iter().map(stop).collect());
    let name = match ramp.interpolation {
        Interpolation::Linear => return stops,
        Interpolation::Smooth => "smooth",
        Interpolation::Constant => "constant",
    };
    let field = |key: &str, value| Field {
        key: unplaced_key(key),
        value: unplaced(value),
    };
    Value::Table(vec![
        field("interpolation", Value::Text(name.to_owned())),
        field("stops", stops),
    ])
}

fn unplaced_key(key: &str) -> Spanned<String> {
    Spanned::new(key.to_owned(), 0..0)
}

/// What diagnostics say, on one line.
pub fn summary(problems: &Diagnostics) -> String {
    let said: Vec<&str> = problems.iter().map(|p| p.message.as_str()).collect();
    said.join("; ")
}
