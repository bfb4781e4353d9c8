//! Nodes that need no texture, because a link says as much, or that name what they read by a word.

use std::rc::Rc;

use scene::look;
use texgen::{OutputType, ParameterType};

use crate::document::ElementId;
use crate::types::Type;
use crate::value::Value;

use super::Converter;
use super::graph::{Results, Scope};

impl Converter<'_> {
    /// What such a node gives; `None` for all other nodes.
    pub(super) fn special(&mut self, scope: &Rc<Scope>, id: ElementId) -> Option<Option<Results>> {
        if let Some(value) = self.matrix_node(scope, id) {
            return Some(value.map(Results::One));
        }
        let element = self.document.element(id);
        let ty = Type::of(element.attribute("type").unwrap_or(""));
        self.warn_of_strangers(id);
        let value = match &*element.kind {
            "constant" => self
                .input(scope, id, "value")
                .or(Some(Value::Numbers(ty, [0.0; 4]))),
            "dot" => self.input(scope, id, "in"),
            "separate2" | "separate3" | "separate4" => {
                return Some(self.separated(scope, id));
            }
            "extract" => {
                let index = self.input(scope, id, "index");
                let index = match index {
                    None => 0.0,
                    Some(index) => index.known()?[0],
                };
                let given = self.given(scope, id, "in");
                Some(given.component(index.max(0.0) as usize))
            }
            "swizzle" => {
                let value = self.given(scope, id, "in");
                let channels = self.word(scope, id, "channels")?;
                self.swizzled(id, value, ty, &channels)
            }
            "convert" => {
                let value = self.given(scope, id, "in");
                Some(self.converted(scope, id, &value, ty))
            }
            "normalmap" if self.word(scope, id, "space").as_deref() == Some("object") => {
                self.object_normal(scope, id)
            }
            "combine2" | "combine3" | "combine4" => Some(self.combined(scope, id, ty)),
            "texcoord" => Some(self.texcoord(scope, id, ty)),
            "position" => Some(self.spaced(scope, id, "mx_position", "mx_position_world")),
            "normal" => Some(self.spaced(scope, id, "mx_normal", "mx_normal_world")),
            "tangent" => Some(self.spaced(scope, id, "mx_tangent_world", "mx_tangent_world")),
            "bitangent" => Some(self.spaced(scope, id, "mx_bitangent_world", "mx_bitangent_world")),
            "viewdirection" => Some(self.spaced(
                scope,
                id,
                "mx_viewdirection_world",
                "mx_viewdirection_world",
            )),
            "transformpoint" | "transformvector" | "transformnormal" => {
                let spaces = ["fromspace", "tospace"].map(|name| self.word(scope, id, name));
                if spaces[0] != spaces[1] {
                    self.warn(id, "changes of space are not made: what goes in comes out");
                }
                self.input(scope, id, "in")
            }
            "UsdPrimvarReader" | "geompropvalue" => self.primvar(scope, id, ty),
            _ => return None,
        };
        Some(value.map(Results::One))
    }

    /// Warns of what is given to inputs that such a node hasn't.
    fn warn_of_strangers(&mut self, id: ElementId) {
        let document = self.document;
        let known: &[&str] = match &*document.element(id).kind {
            "constant" => &["value"],
            "convert" | "separate2" | "separate3" | "separate4" => &["in"],
            "combine2" => &["in1", "in2"],
            "combine3" => &["in1", "in2", "in3"],
            "combine4" => &["in1", "in2", "in3", "in4"],
            "extract" => &["in", "index"],
            "swizzle" => &["in", "channels"],
            _ => return,
        };
        for child in self.inputs_of(id) {
            if !known.contains(&document.element(child).name()) {
                self.stranger(id, child, known);
            }
        }
    }

    /// What a normal map of version 1.38 in the object's space holds, as MaterialX's own upgrade to 1.39 takes it.
    fn object_normal(&mut self, scope: &Rc<Scope>, id: ElementId) -> Option<Value> {
        let given = self.input(scope, id, "in")?;
        let name = self.look_name(scope, id);
        let doubled = self.product(&format!("{name}_doubled"), &given, &Value::number(2.0));
        let vector = self.sum(&format!("{name}_vector"), &doubled, &Value::number(-1.0));
        let ty = Type::Vector3;
        match vector {
            Value::Numbers(_, [x, y, z, _]) => {
                let length = (x * x + y * y + z * z).sqrt().max(1e-30);
                Some(Value::Numbers(ty, [x, y, z, 0.0].map(|part| part / length)))
            }
            Value::Link(link) => {
                let text = link.text(ParameterType::Vec3, false);
                let arguments = vec![("in".to_owned(), look::Value::Text(text))];
                let texture = "mx_normalize_3";
                Some(Value::Link(self.add(
                    &name,
                    texture,
                    arguments,
                    ty,
                    OutputType::Vec3,
                )))
            }
            _ => None,
        }
    }

    /// What an input has; 0 where it has nothing.
    pub(super) fn given(&mut self, scope: &Rc<Scope>, id: ElementId, name: &str) -> Value {
        let given = self.input(scope, id, name);
        given.unwrap_or_else(|| {
            let input = self.document.input(id, name);
            let ty = input.and_then(|input| self.document.element(input).attribute("type"));
            Value::Numbers(Type::of(ty.unwrap_or("float")), [0.0; 4])
        })
    }

    fn separated(&mut self, scope: &Rc<Scope>, id: ElementId) -> Option<Results> {
        let value = self.given(scope, id, "in");
        let letters = [
            ["outx", "outr"],
            ["outy", "outg"],
            ["outz", "outb"],
            ["outw", "outa"],
        ];
        let named = letters.iter().enumerate().flat_map(|(i, names)| {
            let part = value.component(i);
            names.map(|name| (name.to_owned(), part.clone()))
        });
        Some(Results::Named(named.collect()))
    }

    /// Components by their letters, with 0 and 1 as MaterialX allows them.
    pub(super) fn swizzled(
        &mut self,
        id: ElementId,
        value: Value,
        ty: Type,
        channels: &str,
    ) -> Option<Value> {
        let mut parts = Vec::new();
        for letter in channels.chars() {
            parts.push(match letter {
                'x' | 'r' => value.component(0),
                'y' | 'g' => value.component(1),
                'z' | 'b' => value.component(2),
                'w' | 'a' => value.component(3),
                '0' => Value::number(0.0),
                '1' => Value::number(1.0),
                _ => {
                    self.warn(id, format!("`{channels}` are no channels"));
                    return None;
                }
            });
        }
        Some(self.joined("channels", ty, &parts))
    }

    /// Numbers as one value: of one node its components, else by a node that puts them together.
    pub(crate) fn joined(&mut self, name: &str, ty: Type, parts: &[Value]) -> Value {
        let count = ty.components().max(1);
        let zero = Value::number(0.0);
        let part = |i: usize| match parts.len() {
            1 => &parts[0],
            _ => parts.get(i).unwrap_or(&zero),
        };
        if (0..count).all(|i| part(i).known().is_some()) {
            let mut numbers = [0.0; 4];
            for (i, number) in numbers.iter_mut().enumerate().take(count) {
                *number = part(i).known().map_or(0.0, |known| known[0]);
            }
            if ty == Type::Color3 {
                numbers[3] = 1.0;
            }
            return Value::Numbers(ty, if count == 1 { [numbers[0]; 4] } else { numbers });
        }
        if let Some(link) = one_source(ty, &(0..count).map(part).collect::<Vec<_>>()) {
            return link;
        }
        let arguments = (0..count).map(|i| (format!("in{}", i + 1), self.argument(part(i))));
        let arguments = arguments.collect();
        Value::Link(self.add(name, "mx_combine", arguments, ty, OutputType::Vec4))
    }

    /// As MaterialX's `convert`: numbers to every component; where components are added, they are 0, opacity is 1.
    fn converted(&mut self, scope: &Rc<Scope>, id: ElementId, value: &Value, ty: Type) -> Value {
        if ty == Type::Boolean && value.ty() != Type::Boolean {
            if let Some([number, ..]) = value.known() {
                return Value::Numbers(ty, [if number == 0.0 { 0.0 } else { 1.0 }; 4]);
            }
            let name = self.look_name(scope, id);
            let arguments = vec![("in".to_owned(), self.argument(value))];
            return Value::Link(self.add(&name, "mx_toboolean", arguments, ty, OutputType::F32));
        }
        let (from, to) = (value.ty().components(), ty.components());
        if from == to || from == 0 || to == 0 {
            return value.called(ty);
        }
        if from == 1 {
            return value.pick(ty, &vec![0; to]);
        }
        if to < from {
            return value.pick(ty, &(0..to).collect::<Vec<_>>());
        }
        let last = if to == 4 { 1.0 } else { 0.0 };
        let mut parts: Vec<Value> = (0..from).map(|i| value.component(i)).collect();
        parts.resize(to - 1, Value::number(0.0));
        if parts.len() < to {
            parts.push(Value::number(last));
        }
        let name = self.look_name(scope, id);
        self.joined(&name, ty, &parts)
    }

    fn combined(&mut self, scope: &Rc<Scope>, id: ElementId, ty: Type) -> Value {
        let mut parts = Vec::new();
        for name in ["in1", "in2", "in3", "in4"] {
            if self.document.input(id, name).is_some() || parts.len() < ty.components() {
                let value = self.given(scope, id, name);
                let count = value.ty().components().max(1);
                parts.extend((0..count).map(|i| value.component(i)));
            }
        }
        let name = self.look_name(scope, id);
        self.joined(&name, ty, &parts)
    }

    fn texcoord(&mut self, scope: &Rc<Scope>, id: ElementId, ty: Type) -> Value {
        let index = self.input(scope, id, "index");
        let texture = match index.and_then(|index| index.known()) {
            Some([1.0, ..]) => "mx_texcoord1",
            Some([index, ..]) if index != 0.0 => {
                self.warn(
                    id,
                    "there are two sets of texture coordinates, 0 and 1: the first is taken",
                );
                "mx_texcoord"
            }
            _ => "mx_texcoord",
        };
        self.place(texture, ty)
    }

    /// Geometry in the object's own space or in the world.
    fn spaced(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
        object: &'static str,
        world: &'static str,
    ) -> Value {
        let space = self.word(scope, id, "space");
        let texture = match space.as_deref() {
            Some("world") => world,
            _ => object,
        };
        if texture == world && space.as_deref() != Some("world") && object == world {
            self.warn(
                id,
                "it is given in the world, not in the object's own space",
            );
        }
        self.vector(texture)
    }

    /// A vector of the surface; only positions have the width of the pixel.
    pub(super) fn vector(&mut self, texture: &'static str) -> Value {
        let is_place = texture.starts_with("mx_position");
        let value = self.place(texture, Type::Vector3);
        match value {
            Value::Link(link) => Value::Link(crate::value::Link { is_place, ..link }),
            other => other,
        }
    }

    /// Values by name that a mesh may carry: those whose names are known.
    fn primvar(&mut self, scope: &Rc<Scope>, id: ElementId, ty: Type) -> Option<Value> {
        let names = ["varname", "geomprop"];
        let name = names.iter().find_map(|name| self.word(scope, id, name));
        match name.as_deref() {
            Some("st" | "st0" | "UV0" | "uv" | "map1" | "UVMap") if ty.components() > 1 => {
                return Some(self.place("mx_texcoord", ty));
            }
            Some("st1" | "UV1") if ty.components() > 1 => {
                return Some(self.place("mx_texcoord1", ty));
            }
            Some("displayColor" | "Cd" | "color") if ty.components() > 2 => {
                let link = self.add(
                    "vertex_color",
                    "mx_geomcolor",
                    Vec::new(),
                    ty,
                    OutputType::Vec4,
                );
                return Some(Value::Link(link));
            }
            _ => {}
        }
        let name = name.unwrap_or_default();
        self.warn(
            id,
            format!("`{name}` is not read from the mesh: its default stands for it"),
        );
        let defaults = ["fallback", "default"];
        let found = defaults.iter().find_map(|name| self.input(scope, id, name));
        found.or(Some(Value::Numbers(ty, [0.0; 4])))
    }
}

/// All parts as components of one node, where they are.
fn one_source(ty: Type, parts: &[&Value]) -> Option<Value> {
    let Value::Link(first) = parts.first()? else {
        return None;
    };
    let mut picked = Vec::new();
    for part in parts {
        match part {
            Value::Link(link) if link.node == first.node => {
                picked.push(link.picked.as_ref().map_or(0, |picked| picked[0]));
            }
            _ => return None,
        }
    }
    let is_number = first.output == OutputType::F32;
    Some(Value::Link(crate::value::Link {
        ty,
        picked: (!is_number).then_some(picked),
        is_place: false,
        ..first.clone()
    }))
}
