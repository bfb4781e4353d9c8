//! A node of MaterialX's library to a node of the look, by the texture of its name.

use std::rc::Rc;

use scene::look;
use texgen::{Attribute, BuiltinAttribute, Parameter, ParameterType, TextureType};

use crate::document::{Element, ElementId};
use crate::textures;
use crate::types::Type;
use crate::value::{Link, Value};

use super::Converter;
use super::graph::{Results, Scope};
use super::matrix;

/// Inputs that change nothing here, or are read with others.
const SILENT: [&str; 12] = [
    "uaddressmode",
    "vaddressmode",
    "wraps",
    "wrapt",
    "filtertype",
    "layer",
    "framerange",
    "frameoffset",
    "frameendaction",
    "note",
    "default",
    "fallback",
];

impl Converter<'_> {
    /// What a node of the library gives.
    pub(super) fn leaf(&mut self, scope: &Rc<Scope>, id: ElementId) -> Option<Results> {
        if let Some(results) = self.special(scope, id) {
            return results;
        }
        let Some(name) = self.texture(id) else {
            let kind = &self.document.element(id).kind;
            let message = format!(
                "nodes of the category `{kind}` are not known: what it feeds has its default"
            );
            self.warn(id, message);
            return None;
        };
        let texture = textures::interface(&name)?;
        if let Some(missing) = self.missing_image(scope, id, &texture) {
            return Some(missing);
        }
        let element = self.document.element(id);
        if matches!(&*element.kind, "flake2d" | "flake3d") {
            return self.flakes(scope, id, &texture);
        }
        self.warn_of_rest(id, &texture);
        if let Some(size) = element.attribute("type").and_then(matrix::size_of) {
            let rows = (0..size).map(|row| {
                Value::Link(self.use_of(scope, id, &texture, matrix::row_type(size), row))
            });
            return Some(Results::One(Value::Matrix(rows.collect())));
        }
        let link = self.use_of(scope, id, &texture, whole_type(element), 0);
        Some(outputs(&element.kind, &Value::Link(link)))
    }

    /// Two nodes of the look: one for what flakes are, one for their normals.
    fn flakes(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
        texture: &TextureType,
    ) -> Option<Results> {
        let normals = textures::interface(&format!("{}_normal", texture.name()))?;
        self.warn_of_rest(id, &normals);
        let facts = self.use_of(scope, id, texture, Type::Vector3, 0);
        let normal = self.use_of(scope, id, &normals, Type::Vector3, 0);
        let fact = |ty, component| Value::Link(facts.pick(ty, &[component]));
        let named = [
            ("id", fact(Type::Integer, 0)),
            ("rand", fact(Type::Float, 1)),
            ("presence", fact(Type::Float, 2)),
            ("flakenormal", Value::Link(normal)),
        ];
        let named = named.map(|(name, value)| (name.to_owned(), value));
        Some(Results::Named(named.into()))
    }

    /// A node of the look for a node of the document; of matrices it takes a row.
    fn use_of(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
        texture: &TextureType,
        ty: Type,
        row: usize,
    ) -> Link {
        let (arguments, is_place) = self.arguments(scope, id, texture, row);
        let look_name = self.look_name(scope, id);
        let link = self.add(&look_name, texture.name(), arguments, ty, texture.output());
        Link { is_place, ..link }
    }

    /// The texture of a node: of its category and type, of the type or size of what goes in, or of the category.
    fn texture(&self, id: ElementId) -> Option<String> {
        let element = self.document.element(id);
        let kind = element.kind.to_ascii_lowercase();
        let plain = |name: &str| match name {
            "color3" => "vector3".to_owned(),
            "color4" => "vector4".to_owned(),
            other => other.to_owned(),
        };
        let given = ["in", "in1"].iter().find_map(|name| {
            let input = self.document.input(id, name)?;
            self.document.element(input).attribute("type")
        });
        let given = given.unwrap_or("");
        let endings = [
            plain(element.attribute("type").unwrap_or("")),
            plain(given),
            Type::of(given).components().to_string(),
        ];
        let names = endings.iter().map(|ending| format!("mx_{kind}_{ending}"));
        let mut names = names.chain([format!("mx_{kind}")]);
        names.find(|name| textures::names().any(|known| known == name))
    }

    /// What a node gives whose image isn't there: its fallback where it has one.
    fn missing_image(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
        texture: &TextureType,
    ) -> Option<Results> {
        let parameters = texture.parameters().iter();
        let mut images = parameters.filter(|parameter| parameter.ty == ParameterType::Image);
        if images.all(|image| self.input(scope, id, &image.name).is_some()) {
            return None;
        }
        let fallback = ["default", "fallback"];
        let found = fallback.iter().find_map(|name| self.input(scope, id, name));
        let element = self.document.element(id);
        let nothing = Value::Numbers(whole_type(element), [0.0; 4]);
        let value = match (&*element.kind, found) {
            ("UsdUVTexture", None) => Value::Numbers(Type::Vector4, [0.0, 0.0, 0.0, 1.0]),
            ("gltf_anisotropy_image", Some(found)) => match found.known() {
                Some(pixel) => anisotropy(pixel),
                None => {
                    self.warn(
                        id,
                        "without its image the node gives 0: a node drives its default",
                    );
                    nothing
                }
            },
            (_, found) => found.unwrap_or(nothing),
        };
        Some(outputs(&element.kind, &value))
    }

    /// Arguments for a texture, of matrices their row of that number, and whether the fourth component of what it gives is the
    /// width of the pixel.
    fn arguments(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
        texture: &TextureType,
        row: usize,
    ) -> (Vec<(String, look::Value)>, bool) {
        let document = self.document;
        let mut values: Vec<(&Parameter, Value)> = Vec::new();
        for parameter in texture.parameters() {
            let given = match input_name(document, id, &parameter.name) {
                Some(name) => self.input(scope, id, &name),
                None => None,
            };
            let value = match given {
                None => self.default_place(parameter),
                Some(Value::Matrix(rows)) => rows.into_iter().nth(row),
                given => given,
            };
            values.extend(value.map(|value| (parameter, value)));
        }
        let kind = &*document.element(id).kind;
        let is_place = keep_width(kind, &mut values);
        let mut arguments: Vec<(String, look::Value)> = Vec::new();
        for (parameter, value) in values {
            match self.written_as(scope, id, parameter, &value) {
                Some(value) => arguments.push((parameter.name.clone(), value)),
                None => self.warn(
                    id,
                    format!("its input `{}` doesn't take this", parameter.name),
                ),
            }
        }
        // Of all types this one alone has the other order where none is given.
        let has_order = document.input(id, "operationorder").is_some();
        if kind == "gltf_image" && whole_type(document.element(id)) == Type::Color4 && !has_order {
            arguments.push(("operationorder".to_owned(), look::Value::Integer(1)));
        }
        if texture.parameter("bounds").is_some() {
            let bounds = self.bounds(scope, id);
            if bounds != 0 {
                arguments.push(("bounds".to_owned(), look::Value::Integer(bounds)));
            }
        }
        (arguments, is_place)
    }

    /// MaterialX's texture coordinates, whose v goes upwards.
    fn default_place(&mut self, parameter: &Parameter) -> Option<Value> {
        let attribute = parameter.attribute.as_ref()?;
        let is_texcoord = *attribute == Attribute::Builtin(BuiltinAttribute::TexCoord0);
        is_texcoord.then(|| self.place("mx_texcoord", Type::Vector2))
    }

    fn warn_of_rest(&mut self, id: ElementId, texture: &TextureType) {
        let document = self.document;
        let mut given = document.children(id).to_vec();
        given.extend(self.inputs_of(id));
        for child in given {
            let name = document.element(child).name().to_ascii_lowercase();
            let is_known = texture.parameters().iter().any(|p| is_name(&p.name, &name));
            if !is_known && !SILENT.contains(&&*name) {
                self.warn(child, format!("the input `{name}` has no effect here"));
            }
        }
    }

    /// Where an image has nothing outside: 1 along u, 2 along v.
    fn bounds(&mut self, scope: &Rc<Scope>, id: ElementId) -> i64 {
        let [u, v] = self.address_modes(scope, id);
        let is_constant = |mode: &str| matches!(mode, "constant" | "black");
        i64::from(is_constant(&u)) + 2 * i64::from(is_constant(&v))
    }

    fn address_modes(&mut self, scope: &Rc<Scope>, id: ElementId) -> [String; 2] {
        [["uaddressmode", "wrapS"], ["vaddressmode", "wrapT"]].map(|names| {
            let found = names.iter().find_map(|name| self.word(scope, id, name));
            found.unwrap_or_else(|| "periodic".to_owned())
        })
    }

    /// A word that an input has.
    pub(super) fn word(&mut self, scope: &Rc<Scope>, id: ElementId, name: &str) -> Option<String> {
        match self.input(scope, id, name) {
            Some(Value::Text(word)) => Some(word),
            _ => None,
        }
    }

    /// A value as a look writes it for a parameter.
    fn written_as(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
        parameter: &Parameter,
        value: &Value,
    ) -> Option<look::Value> {
        Some(match value {
            Value::Link(link) if parameter.ty.is_linkable() => {
                look::Value::Text(link.text(parameter.ty, parameter.is_coordinate()))
            }
            Value::Numbers(ty, numbers) => constant(parameter, *ty, *numbers)?,
            Value::File { path, is_srgb } if parameter.ty == ParameterType::Image => {
                let ty = Type::of(self.document.element(id).attribute("type").unwrap_or(""));
                let is_srgb = *is_srgb && (ty.is_color() || ty == Type::Other);
                self.image(scope, id, path, is_srgb)
            }
            Value::Text(word) => look::Value::Integer(number_of(word)?),
            _ => return None,
        })
    }

    /// The table of an image.
    fn image(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
        path: &str,
        is_srgb: bool,
    ) -> look::Value {
        let text = |text: &str| look::Value::Text(text.to_owned());
        let space = if is_srgb { "srgb" } else { "linear" };
        let mut fields = vec![("file", text(path)), ("color_space", text(space))];
        let wraps = self.address_modes(scope, id).map(|mode| match &*mode {
            "clamp" | "constant" | "black" => "clamp",
            "mirror" => "mirror",
            _ => "repeat",
        });
        match wraps {
            ["repeat", "repeat"] => {}
            [u, v] if u == v => fields.push(("wrap", text(u))),
            [u, v] => {
                let list = [u, v].map(|wrap| look::Spanned::new(text(wrap), 0..0));
                fields.push(("wrap", look::Value::List(list.into())));
            }
        }
        if self.word(scope, id, "filtertype").as_deref() == Some("closest") {
            fields.push(("filter", text("nearest")));
        }
        let field = |(key, value): (&str, look::Value)| look::Field {
            key: look::Spanned::new(key.to_owned(), 0..0),
            value: look::Spanned::new(value, 0..0),
        };
        look::Value::Table(fields.into_iter().map(field).collect())
    }
}

/// What MaterialX calls an input that WGSL has to call otherwise; in small letters.
fn written_name(parameter: &str) -> String {
    match parameter {
        "default_value" => "default".to_owned(),
        "kind" => "type".to_owned(),
        other => other.to_ascii_lowercase(),
    }
}

/// Whether an input, in small letters, is a parameter's, by its name now or in version 1.38.
fn is_name(parameter: &str, name: &str) -> bool {
    let former = match parameter {
        "iny" => Some("in1"),
        "inx" => Some("in2"),
        _ => None,
    };
    written_name(parameter) == name || former == Some(name)
}

/// The input of a node that a parameter has, as it is written there.
fn input_name(document: &crate::Document, id: ElementId, parameter: &str) -> Option<String> {
    let inside = document.lineage(id).flat_map(|at| document.children(at));
    let names = inside.map(|&child| document.element(child).name());
    let mut same = names.filter(|name| is_name(parameter, &name.to_ascii_lowercase()));
    same.next().map(str::to_owned)
}

/// Numbers as a look writes them for a parameter.
fn constant(parameter: &Parameter, ty: Type, numbers: [f32; 4]) -> Option<look::Value> {
    Some(match parameter.ty {
        ParameterType::F32 => look::Value::number(numbers[0]),
        ParameterType::I32 => look::Value::Integer(numbers[0] as i64),
        ParameterType::U32 => look::Value::Integer(numbers[0].max(0.0) as i64),
        ParameterType::Bool => look::Value::Bool(numbers[0] > 0.5),
        ParameterType::Vec2 => look::Value::numbers(&numbers[..2]),
        ParameterType::Vec3 => look::Value::numbers(&numbers[..3]),
        ParameterType::Vec4 if parameter.is_coordinate() => {
            look::Value::numbers(&[numbers[0], numbers[1], numbers[2], 0.0])
        }
        ParameterType::Vec4 if ty.components() == 1 && numbers == [numbers[0]; 4] => {
            look::Value::number(numbers[0])
        }
        ParameterType::Vec4 => look::Value::numbers(&numbers),
        _ => return None,
    })
}

/// The number of a word where MaterialX has both.
fn number_of(word: &str) -> Option<i64> {
    const WORDS: [&[&str]; 5] = [
        &["Perlin", "standard", "linear", "SRT", "Distance"],
        &["Cell", "radial", "smooth", "TRS", "Solid"],
        &["Worley", "circular", "step"],
        &["Fractal", "box"],
        &[],
    ];
    let at = WORDS.iter().position(|words| words.contains(&word))?;
    Some(at as i64)
}

/// Keeps the width of the pixel in the fourth component of a place that is moved and scaled by constants, and tells whether it
/// is there.
fn keep_width(kind: &str, values: &mut [(&Parameter, Value)]) -> bool {
    let is_place = |value: Option<&(&Parameter, Value)>| match value {
        Some((_, Value::Link(link))) => link.is_place,
        _ => false,
    };
    match kind {
        "place2d" | "UsdTransform2d" => true,
        "rotate2d" | "rotate3d" => is_place(values.first()),
        "add" | "subtract" | "multiply" | "divide" if is_place(values.first()) => {
            let Some((_, Value::Numbers(ty, numbers))) = values.get_mut(1) else {
                return false;
            };
            let count = ty.components().clamp(2, 3);
            let most = numbers[..count]
                .iter()
                .fold(0.0, |most: f32, x| most.max(x.abs()));
            let least = numbers[..count]
                .iter()
                .fold(most, |least, x| least.min(x.abs()));
            let scale = match kind {
                "multiply" => most,
                "divide" => least,
                _ => 0.0,
            };
            numbers[3] = scale;
            *ty = Type::Vector4;
            true
        }
        _ => false,
    }
}

/// The type of all that a node gives: of several values at once four numbers.
fn whole_type(element: &Element) -> Type {
    match element.attribute("type") {
        Some("multioutput") | None => Type::Vector4,
        Some(name) => Type::of(name),
    }
}

/// Strength and turn of an anisotropy from a pixel, as `mx_gltf_anisotropy_image` has it.
fn anisotropy([x, y, strength, _]: [f32; 4]) -> Value {
    let turn = (2.0 * y - 1.0).atan2(2.0 * x - 1.0);
    Value::Numbers(Type::Vector4, [strength, turn, 0.0, 0.0])
}

/// Names of what a node gives where it gives several values.
fn outputs(kind: &str, value: &Value) -> Results {
    let parts: &[(&str, Type, &[usize])] = match kind {
        "gltf_colorimage" => &[
            ("outcolor", Type::Color3, &[0, 1, 2]),
            ("outa", Type::Float, &[3]),
        ],
        "gltf_anisotropy_image" => &[
            ("anisotropy_strength_out", Type::Float, &[0]),
            ("anisotropy_rotation_out", Type::Float, &[1]),
        ],
        "UsdUVTexture" => &[
            ("rgb", Type::Color3, &[0, 1, 2]),
            ("rgba", Type::Color4, &[0, 1, 2, 3]),
            ("r", Type::Float, &[0]),
            ("g", Type::Float, &[1]),
            ("b", Type::Float, &[2]),
            ("a", Type::Float, &[3]),
        ],
        _ => return Results::One(value.clone()),
    };
    let part = |(name, ty, components): &(&str, Type, &[usize])| {
        ((*name).to_owned(), value.pick(*ty, components))
    };
    Results::Named(parts.iter().map(part).collect())
}
