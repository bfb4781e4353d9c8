//! A material on its way: inputs of a shader in, keys of a look's material out.

use std::rc::Rc;

use scene::look;
use texgen::{OutputType, ParameterType};

use crate::convert::{Converter, Scope};
use crate::document::ElementId;
use crate::types::Type;
use crate::value::{Link, Value};

/// What a plain material has of that which a scene's own may have otherwise.
const NEUTRAL: [(&str, &[f32]); 13] = [
    ("emission", &[0.0, 0.0, 0.0]),
    ("opacity", &[1.0]),
    ("specular", &[1.0]),
    ("specular_color", &[1.0, 1.0, 1.0]),
    ("transmission", &[0.0]),
    ("attenuation_color", &[1.0, 1.0, 1.0]),
    ("dispersion", &[0.0]),
    ("diffuse_transmission", &[0.0]),
    ("coat", &[0.0]),
    ("sheen_color", &[0.0, 0.0, 0.0]),
    ("anisotropy", &[0.0]),
    ("anisotropy_rotation", &[0.0]),
    ("iridescence", &[0.0]),
];

/// Bumps don't lie on more others than these, which ends circles, too.
const MAX_BUMPS: usize = 64;

/// A shader that is being turned into a material.
pub(super) struct Surface<'c, 'd> {
    pub(super) converter: &'c mut Converter<'d>,
    scope: Rc<Scope>,
    id: ElementId,
    name: String,
    parameters: Vec<(&'static str, look::Value)>,
}

impl<'c, 'd> Surface<'c, 'd> {
    pub(super) fn new(
        converter: &'c mut Converter<'d>,
        scope: Rc<Scope>,
        id: ElementId,
        name: &str,
    ) -> Self {
        Self {
            converter,
            scope,
            id,
            name: name.to_owned(),
            parameters: Vec::new(),
        }
    }

    /// All keys. Those that the model leaves as they are in a plain material are written, too, or else those of a material
    /// of the scene would be seen; but where the document is of a model whose own materials say the rest.
    pub(super) fn finish(mut self) -> Vec<(&'static str, look::Value)> {
        if self.converter.document.is_of_model {
            return self.parameters;
        }
        let is_body = self.has("transmission");
        for (key, neutral) in NEUTRAL {
            if !self.has(key) && (is_body || key != "attenuation_color") {
                let value = match neutral {
                    [number] => look::Value::number(*number),
                    color => look::Value::numbers(color),
                };
                self.parameters.push((key, value));
            }
        }
        self.set_flag("unlit", false);
        self.parameters
    }

    /// Whether a key is set already.
    fn has(&self, key: &str) -> bool {
        self.parameters.iter().any(|(known, _)| *known == key)
    }

    /// What an input has, or its default.
    pub(super) fn number(&mut self, input: &str, default: f32) -> Value {
        let given = self.given(input);
        given.unwrap_or(Value::number(default))
    }

    /// As [`Self::number`], of a colour.
    pub(super) fn color(&mut self, input: &str, default: f32) -> Value {
        let given = self.given(input);
        given.unwrap_or(Value::color([default; 3]))
    }

    /// What an input has, if it has anything.
    pub(super) fn given(&mut self, input: &str) -> Option<Value> {
        let given = self.converter.input(&self.scope, self.id, input);
        if matches!(&given, Some(value) if value.ty() == Type::Other) {
            self.warn(
                input,
                &format!("`{input}` doesn't take this: it has its default"),
            );
            return None;
        }
        given
    }

    /// Warns of what is given to inputs that the model hasn't.
    pub(super) fn name_strangers(&mut self, inputs: &[&'static str]) {
        let document = self.converter.document;
        for child in self.converter.inputs_of(self.id) {
            if !inputs.contains(&document.element(child).name()) {
                self.converter.stranger(self.id, child, inputs);
            }
        }
    }

    /// Whether an input is known to be on.
    pub(super) fn is_on(&mut self, input: &str) -> bool {
        let given = self.given(input).and_then(|value| value.known());
        given.is_some_and(|numbers| numbers[0] > 0.5)
    }

    /// Whether the node says that it is of that version; zeros at its end don't matter.
    pub(super) fn is_of_version(&self, wanted: &str) -> bool {
        let element = self.converter.document.element(self.id);
        let version = element.attribute("version").unwrap_or("");
        version.trim_end_matches(".0") == wanted
    }

    /// The name of a node that computes `what`.
    pub(super) fn node(&self, what: &str) -> String {
        format!("{}_{what}", self.name)
    }

    /// The product of two values, in a node called after `what` where one is needed.
    pub(super) fn product(&mut self, what: &str, a: &Value, b: &Value) -> Value {
        let name = self.node(what);
        self.converter.product(&name, a, b)
    }

    /// From `a` to `b`.
    pub(super) fn mixed(&mut self, what: &str, a: &Value, b: &Value, share: &Value) -> Value {
        let name = self.node(what);
        self.converter.mixed(&name, a, b, share)
    }

    /// Sets a key that takes a number, held between two.
    pub(super) fn set(&mut self, key: &'static str, value: &Value, low: f32, high: f32) {
        let value = match value {
            Value::Link(link) => look::Value::Text(link.text(ParameterType::F32, false)),
            Value::Numbers(_, numbers) => {
                // Without the sign that 0 may have.
                look::Value::number(numbers[0].clamp(low, high) + 0.0)
            }
            Value::Text(_) | Value::File { .. } | Value::Matrix(_) => return,
        };
        self.parameters.push((key, value));
    }

    /// As [`Self::set`], where the value isn't `neutral`.
    pub(super) fn set_unless(&mut self, key: &'static str, value: &Value, neutral: f32, high: f32) {
        if !value.is(neutral) {
            self.set(key, value, 0.0, high);
        }
    }

    /// Sets a key that takes a colour, none of whose components is negative, or above `high`.
    pub(super) fn set_color(&mut self, key: &'static str, value: &Value, high: f32) {
        let value = match value {
            Value::Link(link) => look::Value::Text(link.text(ParameterType::Vec4, false)),
            Value::Numbers(ty, n) => {
                let one = ty.components() == 1;
                let rgb: [f32; 3] =
                    std::array::from_fn(|i| n[if one { 0 } else { i }].clamp(0.0, high));
                look::Value::numbers(&rgb)
            }
            Value::Text(_) | Value::File { .. } | Value::Matrix(_) => return,
        };
        self.parameters.push((key, value));
    }

    /// Sets a key that is on or off.
    pub(super) fn set_flag(&mut self, key: &'static str, on: bool) {
        self.parameters.push((key, look::Value::Bool(on)));
    }

    /// What makes the surface a thin wall: both sides of it are seen, and it bounds no body, also where the scene's own material
    /// does.
    pub(super) fn thin_wall(&mut self) {
        self.set_flag("double_sided", true);
        if !self.has("solid") {
            self.set_flag("solid", false);
        }
    }

    /// Warns where an input is given and isn't what it would be without it.
    pub(super) fn ignores(&mut self, input: &str, neutral: f32, why: &str) {
        let Some(place) = self.converter.document.input(self.id, input) else {
            return;
        };
        if self.given(input).is_some_and(|value| !value.is(neutral)) {
            self.converter
                .warn(place, format!("`{input}` has no counterpart: {why}"));
        }
    }

    /// Warns about the place of an input, or of the shader.
    pub(super) fn warn(&mut self, input: &str, message: &str) {
        let place = self.converter.document.input(self.id, input);
        self.converter.warn(place.unwrap_or(self.id), message);
    }

    /// The emission: its weight, where it is a number, is a strength by which lights are chosen.
    pub(super) fn emission(&mut self, weight: &Value, color: &Value) {
        if weight.is(0.0) || color.is(0.0) {
            return;
        }
        match (weight, color) {
            (Value::Numbers(_, numbers), Value::Link(_)) => {
                self.set_color("emission", color, f32::MAX);
                if numbers[0] != 1.0 {
                    self.set("emission_strength", weight, 0.0, f32::MAX);
                }
            }
            _ => {
                let product = self.product("emission", color, weight);
                self.set_color("emission", &product, f32::MAX);
            }
        }
    }

    /// Transmission with the colour that light has after a way through the body, or at once where there is no such way.
    pub(super) fn transmission(
        &mut self,
        weight: &Value,
        color: &Value,
        depth: &Value,
        is_thin: bool,
        base_color: Value,
    ) -> Value {
        if weight.is(0.0) {
            return base_color;
        }
        self.set("transmission", weight, 0.0, 1.0);
        self.set_flag("solid", !is_thin);
        // What a node drives may be any depth.
        let is_deep = !is_thin && depth.known().is_none_or(|depth| depth[0] > 0.0);
        match (color.known(), depth.known()) {
            (Some([r, g, b, _]), Some(_)) if is_deep => {
                let held = Value::color([r, g, b].map(|c| c.clamp(1e-4, 1.0)));
                self.set_color("attenuation_color", &held, 1.0);
                self.set("attenuation_distance", depth, 1e-6, f32::MAX);
                self.mixed("body_color", &base_color, &Value::color([1.0; 3]), weight)
            }
            _ => {
                if is_deep && !color.is(1.0) {
                    for input in ["transmission_color", "transmission_depth"] {
                        self.ignores_node(input, "the colour is that of the surface");
                    }
                }
                self.mixed("body_color", &base_color, color, weight)
            }
        }
    }

    /// Roughness with its anisotropy. `widths` are the model's widths of reflections along the tangent and across it, for both
    /// numbers; where they are known ours are made the same, else the anisotropy is taken for glTF's.
    pub(super) fn roughness(
        &mut self,
        roughness: &Value,
        anisotropy: &Value,
        widths: fn(f32, f32) -> [f32; 2],
    ) {
        let (Some([r, ..]), Some([a, ..])) = (roughness.known(), anisotropy.known()) else {
            self.set("roughness", roughness, 0.0, 1.0);
            self.set_unless("anisotropy", anisotropy, 0.0, 1.0);
            return;
        };
        let [along, across] = widths(r, a.clamp(0.0, 1.0)).map(|width| width.clamp(0.0, 1.0));
        self.set("roughness", &Value::number(across.sqrt()), 0.0, 1.0);
        if along > across {
            // glTF's width along the tangent goes from that across it to 1 with the square of the strength.
            let strength = ((along - across) / (1.0 - across)).sqrt();
            self.set("anisotropy", &Value::number(strength), 0.0, 1.0);
        }
    }

    /// A colour as it is seen through a coat.
    pub(super) fn below_coat(
        &mut self,
        what: &str,
        color: &Value,
        coat: &Value,
        coat_color: &Value,
    ) -> Value {
        if coat.is(0.0) || coat_color.is(1.0) {
            return color.clone();
        }
        let white = Value::color([1.0; 3]);
        let name = format!("{what}_below");
        let tint = self.mixed(&name, &white, coat_color, coat);
        self.product(what, color, &tint)
    }

    /// The opacity, of a number or a colour.
    pub(super) fn opacity(&mut self, value: &Value) {
        if value.is(1.0) {
            return;
        }
        let name = self.node("opacity");
        let number = self.converter.brightness(&name, value);
        self.set("opacity", &number, 0.0, 1.0);
    }

    /// Opacity that is there or not, by a threshold.
    pub(super) fn cut(&mut self, alpha: &Value, threshold: &Value) {
        if let (Some(alpha), Some(threshold)) = (alpha.known(), threshold.known()) {
            let is_there = alpha[0] >= threshold[0];
            return self.opacity(&Value::number(if is_there { 1.0 } else { 0.0 }));
        }
        let argument = |value: &Value| self.converter.argument(value);
        let arguments = vec![
            ("value1".to_owned(), argument(alpha)),
            ("value2".to_owned(), argument(threshold)),
            ("in1".to_owned(), look::Value::number(1.0)),
            ("in2".to_owned(), look::Value::number(0.0)),
        ];
        let (name, ty) = (self.node("opacity"), Type::Float);
        let texture = "mx_ifgreatereq";
        let link = self
            .converter
            .add(&name, texture, arguments, ty, OutputType::Vec4);
        self.opacity(&Value::Link(link));
    }

    /// Warns where a node drives an input that is a constant here.
    pub(super) fn ignores_node(&mut self, input: &str, why: &str) {
        if matches!(self.given(input), Some(Value::Link(_))) {
            let message = format!("`{input}` has no counterpart where a node drives it: {why}");
            self.warn(input, &message);
        }
    }

    /// Warns where an input that is the surface's own by default is driven by another node than the surface's own.
    pub(super) fn ignores_link(&mut self, input: &str, why: &str) {
        let is_own = |link: &Link| link.node.starts_with("tangent_world");
        if matches!(self.given(input), Some(Value::Link(link)) if !is_own(&link)) {
            self.warn(input, &format!("`{input}` has no counterpart: {why}"));
        }
    }

    /// Warns where the coat has a normal of its own.
    pub(super) fn warn_of_coat_normal(&mut self, input: &str) {
        if self.given(input).is_some() {
            self.warn(
                input,
                &format!("`{input}` has no counterpart: the coat is smooth"),
            );
        }
    }

    /// The normal; a `bump` node is the look's own bump.
    pub(super) fn normal(&mut self, input: &str) {
        let document = self.converter.document;
        let Some(place) = document.input(self.id, input) else {
            return;
        };
        if let Some((mut scope, mut source)) = self.converter.source(&self.scope, place)
            && document.element(source).kind == "bump"
        {
            let height = self.converter.input(&scope, source, "height");
            let scale = self.converter.input(&scope, source, "scale");
            let scale = scale.unwrap_or(Value::number(1.0));
            if let Some(height @ Value::Link(_)) = height {
                self.bump(place, &height, &scale);
            }
            // The bumps are on a surface that may lean already, or have bumps itself.
            for _ in 0..MAX_BUMPS {
                let on = document.input(source, "normal");
                let Some((outer, below)) = on.and_then(|on| self.converter.source(&scope, on))
                else {
                    break;
                };
                if document.element(below).kind != "bump" {
                    break;
                }
                let message = "of bumps on bumps the last one is shown";
                self.converter.warn(below, message);
                (scope, source) = (outer, below);
            }
            let below = self.converter.input(&scope, source, "normal");
            self.driven_normal(source, "normal", below);
            return;
        }
        let normal = self.given(input);
        self.driven_normal(place, input, normal);
    }

    fn driven_normal(&mut self, place: ElementId, input: &str, normal: Option<Value>) {
        match normal {
            Some(Value::Link(link)) => {
                let text = link.text(ParameterType::Vec3, false);
                self.parameters.push(("normal", look::Value::Text(text)));
            }
            Some(_) => self.converter.warn(
                place,
                format!(
                    "`{input}` has no counterpart where it is a constant: the surface has its own"
                ),
            ),
            None => {}
        }
    }

    fn bump(&mut self, place: ElementId, height: &Value, scale: &Value) {
        if self.parameters.iter().any(|(key, _)| *key == "bump") {
            self.converter
                .warn(place, "a material has one bump: this one is left out");
            return;
        }
        self.set("bump", height, 0.0, 0.0);
        match scale.known() {
            Some([scale, ..]) => self
                .parameters
                .push(("bump_scale", look::Value::number(scale))),
            None => self.converter.warn(
                place,
                "the scale of a bump is a constant here: 1 stands for it",
            ),
        }
    }

    /// A displacement, shown as bumps.
    pub(super) fn displacement(&mut self, scope: &Rc<Scope>, place: ElementId) {
        let document = self.converter.document;
        let Some((scope, source)) = self.converter.source(scope, place) else {
            return;
        };
        if document.element(source).kind != "displacement" {
            self.converter
                .warn(source, "this displacement has no counterpart");
            return;
        }
        let height = self.converter.input(&scope, source, "displacement");
        // Of vectors, which are along the tangent, the bitangent and the normal, the last is the height.
        let is_vector = matches!(&height, Some(height) if height.ty() == Type::Vector3);
        let height = match height {
            Some(vector) if is_vector => Some(vector.component(2)),
            height => height,
        };
        if is_vector {
            let message =
                "of a displacement what is along the normal is shown, not what is sideways";
            self.converter.warn(source, message);
        }
        let scale = self.converter.input(&scope, source, "scale");
        if let Some(height @ Value::Link(_)) = height {
            self.converter.warn(
                source,
                "displacement is shown as bumps: the surface stays where it is",
            );
            let scale = scale.unwrap_or(Value::number(1.0));
            self.bump(source, &height, &scale);
        }
    }

    /// A normal of the world from one in tangent space, from -1 to 1.
    pub(super) fn tangent_space_normal(&mut self, input: &str) {
        let link = match self.given(input) {
            Some(Value::Link(link)) => link,
            // As where nothing is given.
            Some(Value::Numbers(_, [0.0, 0.0, 1.0, _])) => return,
            Some(_) => {
                let message = "has no counterpart where it is a constant: the surface has its own";
                return self.warn(input, &format!("`{input}` {message}"));
            }
            None => return,
        };
        let half = Value::number(0.5);
        let halved = self.product("normal_half", &Value::Link(link), &half);
        let name = self.node("normal_color");
        let Value::Link(color) = self.converter.sum(&name, &halved, &half) else {
            return;
        };
        let text = look::Value::Text(color.text(ParameterType::Vec3, false));
        let arguments = vec![("in".to_owned(), text)];
        let name = self.node("normal");
        let ty = Type::Vector3;
        let node = self
            .converter
            .add(&name, "mx_normalmap", arguments, ty, OutputType::Vec3);
        self.parameters
            .push(("normal", look::Value::Text(node.node)));
    }
}
