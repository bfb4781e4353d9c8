//! Arithmetic with values: on numbers at once, on what nodes give by further nodes.

use scene::look;
use texgen::{OutputType, ParameterType};

use crate::types::Type;
use crate::value::Value;

use super::Converter;

impl Converter<'_> {
    /// A number, or a link to one, as an argument of a texture that takes numbers.
    pub(crate) fn argument(&self, value: &Value) -> look::Value {
        match value {
            Value::Link(link) => look::Value::Text(link.text(ParameterType::F32, false)),
            Value::Numbers(_, numbers) => look::Value::number(numbers[0]),
            Value::Text(_) | Value::File { .. } | Value::Matrix(_) => look::Value::number(0.0),
        }
    }

    /// A value as an argument of a texture that takes four numbers.
    fn wide_argument(&self, value: &Value) -> look::Value {
        match value {
            Value::Link(link) => look::Value::Text(link.text(ParameterType::Vec4, false)),
            Value::Numbers(ty, numbers) if ty.components() == 1 => look::Value::number(numbers[0]),
            Value::Numbers(_, numbers) => look::Value::numbers(numbers),
            Value::Text(_) | Value::File { .. } | Value::Matrix(_) => look::Value::number(0.0),
        }
    }

    fn binary(
        &mut self,
        name: &str,
        texture: &str,
        a: &Value,
        b: &Value,
        compute: impl Fn(f32, f32) -> f32,
    ) -> Value {
        let ty = match a.ty().components() >= b.ty().components() {
            true => a.ty(),
            false => b.ty(),
        };
        if let (Some(x), Some(y)) = (a.known(), b.known()) {
            return Value::Numbers(ty, std::array::from_fn(|i| compute(x[i], y[i])));
        }
        let arguments = vec![
            ("in1".to_owned(), self.wide_argument(a)),
            ("in2".to_owned(), self.wide_argument(b)),
        ];
        Value::Link(self.add(name, texture, arguments, ty, OutputType::Vec4))
    }

    /// The product; factors of 1 need no node.
    pub(crate) fn product(&mut self, name: &str, a: &Value, b: &Value) -> Value {
        let wide = |value: &Value, other: &Value| match other.ty().components() {
            3 if value.ty().components() == 1 => value.pick(other.ty(), &[0, 0, 0]),
            _ => value.clone(),
        };
        if a.is(1.0) {
            return wide(b, a);
        }
        if b.is(1.0) {
            return wide(a, b);
        }
        self.binary(name, "mx_multiply", a, b, |x, y| x * y)
    }

    /// The sum; 0 needs no node.
    pub(crate) fn sum(&mut self, name: &str, a: &Value, b: &Value) -> Value {
        if a.is(0.0) {
            return b.clone();
        }
        if b.is(0.0) {
            return a.clone();
        }
        self.binary(name, "mx_add", a, b, |x, y| x + y)
    }

    /// From `a`, where the share is 0, to `b`, where it is 1.
    pub(crate) fn mixed(&mut self, name: &str, a: &Value, b: &Value, share: &Value) -> Value {
        if share.is(0.0) || a == b {
            return a.clone();
        }
        if share.is(1.0) {
            return b.clone();
        }
        let ty = match a.ty().components() >= b.ty().components() {
            true => a.ty(),
            false => b.ty(),
        };
        if let (Some(x), Some(y), Some(t)) = (a.known(), b.known(), share.known()) {
            let mix = |i: usize| x[i] + (y[i] - x[i]) * t[i];
            return Value::Numbers(ty, std::array::from_fn(mix));
        }
        let arguments = vec![
            ("fg".to_owned(), self.wide_argument(b)),
            ("bg".to_owned(), self.wide_argument(a)),
            ("mix".to_owned(), self.wide_argument(share)),
        ];
        Value::Link(self.add(name, "mx_mix", arguments, ty, OutputType::Vec4))
    }

    /// The brightness of a colour as a number, by the weights of Rec.709.
    pub(crate) fn brightness(&mut self, name: &str, color: &Value) -> Value {
        const WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];
        if color.ty().components() == 1 {
            return color.clone();
        }
        if let Some([r, g, b, _]) = color.known() {
            return Value::number(r * WEIGHTS[0] + g * WEIGHTS[1] + b * WEIGHTS[2]);
        }
        let arguments = vec![
            ("in".to_owned(), self.wide_argument(color)),
            ("lumacoeffs".to_owned(), look::Value::numbers(&WEIGHTS)),
        ];
        let link = self.add(
            name,
            "mx_luminance",
            arguments,
            Type::Color3,
            OutputType::Vec4,
        );
        Value::Link(link.pick(Type::Float, &[0]))
    }
}
