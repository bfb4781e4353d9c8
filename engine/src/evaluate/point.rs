//! What a texture reads at a point: given values, and plain ones for the rest.

use texgen::{BUILTIN_ATTRIBUTES, BuiltinAttribute, GLOBALS, Global};

/// A hit that didn't happen: values of attributes and globals by name. What isn't given has a plain value: positions are
/// the origin, the normal is +Y, the tangent +X, colours and ambient occlusion are 1, the front is seen; `LocalPos` is
/// `WorldPos`, the other normals and `ViewDir` are `Normal`, `TexCoord1` is `TexCoord0`, `AO1` is `AO`; the picture has
/// 1280 x 720 pixels, the scene reaches from -1 to 1, and the rest is 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Point {
    values: Vec<(String, Vec<f32>)>,
}

impl Point {
    /// A point with plain values.
    pub fn new() -> Self {
        Self::default()
    }

    /// Gives an attribute (`WorldPos`, `_WETNESS`, ...) or a global (`CameraPos`, ...) one to four components; `Time` is
    /// both. Where an attribute has one number in every component, one is enough; else those that are left out keep their
    /// plain values.
    #[must_use]
    pub fn with(mut self, name: &str, components: &[f32]) -> Self {
        self.values.push((name.to_owned(), components.to_vec()));
        self
    }

    /// What is given.
    pub(super) fn values(&self) -> impl Iterator<Item = (&str, &[f32])> {
        let values = self.values.iter();
        values.map(|(name, components)| (name.as_str(), components.as_slice()))
    }

    /// The value of `name`: what was given last, on top of `plain`.
    fn value(&self, name: &str, plain: [f32; 4]) -> [f32; 4] {
        let given = self.values.iter().rev().find(|(known, _)| known == name);
        let Some((_, components)) = given else {
            return plain;
        };
        if let ([number], true) = (components.as_slice(), is_number(name)) {
            return [*number; 4];
        }
        let mut value = plain;
        for (slot, component) in value.iter_mut().zip(components) {
            *slot = *component;
        }
        value
    }
}

/// Whether an attribute or global has one number in every component.
fn is_number(name: &str) -> bool {
    BuiltinAttribute::from_name(name).is_some_and(BuiltinAttribute::is_number)
        || Global::from_name(name).is_some_and(Global::is_number)
}

/// Where the values of a point lie, one `vec4` each: attributes, globals, custom attributes.
#[derive(Debug, Clone, Default)]
pub(crate) struct Layout {
    custom: Vec<String>,
}

impl Layout {
    pub(crate) fn new(custom: Vec<String>) -> Self {
        Self { custom }
    }

    /// Names of the custom attributes, in the order in which they lie from [`Self::custom_start`] on.
    pub(crate) fn custom(&self) -> &[String] {
        &self.custom
    }

    /// Values of a point.
    pub(crate) fn stride(&self) -> usize {
        self.custom_start() + self.custom.len()
    }

    /// Place of a built-in attribute among them.
    pub(crate) fn attribute(&self, name: &str) -> Option<usize> {
        BUILTIN_ATTRIBUTES.iter().position(|a| a.name() == name)
    }

    /// Place of a global among them.
    pub(crate) fn global(&self, name: &str) -> Option<usize> {
        let place = GLOBALS.iter().position(|g| g.name() == name)?;
        Some(BUILTIN_ATTRIBUTES.len() + place)
    }

    /// Place of the first custom attribute.
    pub(crate) fn custom_start(&self) -> usize {
        BUILTIN_ATTRIBUTES.len() + GLOBALS.len()
    }

    /// The plain values of a point: what a place begins with where somebody else computes it.
    pub(crate) fn plain(&self) -> Vec<[f32; 4]> {
        let words = self.words([0; 4], &[Point::new()]);
        (words[1..].iter())
            .map(|word| word.map(f32::from_bits))
            .collect()
    }

    /// All names that a point can give.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        let attributes = BUILTIN_ATTRIBUTES.iter().map(|attribute| attribute.name());
        let globals = GLOBALS.iter().map(|global| global.name());
        let custom = self.custom.iter().map(String::as_str);
        attributes.chain(globals).chain(custom)
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.names().any(|known| known == name)
    }

    /// A header and the values of some points, as bits.
    pub(super) fn words(&self, header: [u32; 4], points: &[Point]) -> Vec<[u32; 4]> {
        let mut words = Vec::with_capacity(1 + points.len() * self.stride());
        words.push(header);
        for point in points {
            let attributes = BUILTIN_ATTRIBUTES.iter().map(|&a| attribute(point, a));
            let globals = GLOBALS
                .iter()
                .map(|g| point.value(g.name(), plain_global(*g)));
            let custom = self.custom.iter().map(|name| custom(point, name));
            let values = attributes.chain(globals).chain(custom);
            words.extend(values.map(|value| value.map(f32::to_bits)));
        }
        words
    }
}

/// The value of a built-in attribute at a point.
fn attribute(point: &Point, attribute: BuiltinAttribute) -> [f32; 4] {
    use BuiltinAttribute as A;
    let same_as = |other: A| self::attribute(point, other);
    let plain = match attribute {
        A::WorldPos | A::TexCoord0 => [0.0, 0.0, 0.0, 1.0],
        A::LocalPos => same_as(A::WorldPos),
        A::Normal => [0.0, 1.0, 0.0, 0.0],
        A::GeomNormal | A::LocalNormal | A::ViewDir => same_as(A::Normal),
        A::Tangent => [1.0, 0.0, 0.0, 1.0],
        A::Bitangent => {
            let ([a, b, c, _], [x, y, z, sign]) = (same_as(A::Normal), same_as(A::Tangent));
            let cross = [b * z - c * y, c * x - a * z, a * y - b * x];
            [cross[0] * sign, cross[1] * sign, cross[2] * sign, 0.0]
        }
        A::TexCoord1 => same_as(A::TexCoord0),
        A::Color0 | A::AO | A::FrontFacing => [1.0; 4],
        A::AO1 => same_as(A::AO),
        _ => [0.0; 4],
    };
    point.value(attribute.name(), plain)
}

/// The value of a custom attribute: what a mesh's attribute of so many components gives, or 0 where there is none.
fn custom(point: &Point, name: &str) -> [f32; 4] {
    match point.values().any(|(known, _)| known == name) {
        true => point.value(name, [0.0, 0.0, 0.0, 1.0]),
        false => [0.0; 4],
    }
}

fn plain_global(global: Global) -> [f32; 4] {
    match global {
        Global::Resolution => [1280.0, 720.0, 1.0 / 1280.0, 1.0 / 720.0],
        Global::CameraPos => [0.0, 0.0, 0.0, 1.0],
        Global::SceneMin => [-1.0, -1.0, -1.0, 1.0],
        Global::SceneMax => [1.0; 4],
        _ => [0.0; 4],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_given_follows_from_what_is() {
        let point = Point::new()
            .with("WorldPos", &[1.0, 2.0])
            .with("Normal", &[0.0, 0.0, 1.0])
            .with("AO", &[0.25]);
        let value = |a| attribute(&point, a);
        assert_eq!(value(BuiltinAttribute::WorldPos), [1.0, 2.0, 0.0, 1.0]);
        assert_eq!(value(BuiltinAttribute::LocalPos), [1.0, 2.0, 0.0, 1.0]);
        assert_eq!(value(BuiltinAttribute::GeomNormal), [0.0, 0.0, 1.0, 0.0]);
        assert_eq!(value(BuiltinAttribute::Bitangent), [0.0, 1.0, 0.0, 0.0]);
        assert_eq!(value(BuiltinAttribute::AO1), [0.25; 4]);
    }

    #[test]
    fn every_value_has_a_place_of_its_own() {
        let layout = Layout::new(vec!["_A".into(), "_B".into()]);
        let point = Point::new().with("_B", &[7.0]).with("Time", &[3.0]);
        let words = layout.words([1, 2, 3, 4], &[Point::new(), point]);
        assert_eq!(words.len(), 1 + 2 * layout.stride());
        let second = &words[1 + layout.stride()..];
        let time = [layout.attribute("Time"), layout.global("Time")];
        for place in time.into_iter().flatten() {
            assert_eq!(second[place], [3.0f32.to_bits(); 4]);
        }
        let custom = &second[layout.custom_start()..];
        assert_eq!(custom[0], [0; 4], "a mesh without it");
        assert_eq!(custom[1], [7.0, 0.0, 0.0, 1.0].map(f32::to_bits));
    }
}
