//! Arguments as people write them on a command line or in a test: `3`, `[1, 0.5, 0]`, `#c46a2a`, `wood.png`.

use std::path::Path;

use texgen::{GraphError, Value, did_you_mean};

use crate::scene::Scene;
use crate::scene::look::{self, Link, Spanned};

use super::images::Images;
use super::values::{Argument, argument};
use super::{EditError, Procedural};

impl Procedural {
    /// Sets a parameter to what `text` says: a value as in a look file, where quotes may be left out around names,
    /// colours and paths, and brackets around numbers or lists. A name is a link to another node. An image is read from its
    /// path (relative to the current folder) and added to `scene`, which has to be the one this was built for, before
    /// it is uploaded.
    ///
    /// # Errors
    /// Unknown names, a value of another type, an image that can't be read. Nothing has changed then.
    pub fn set_written(
        &mut self,
        scene: &mut Scene,
        node: &str,
        parameter: &str,
        text: &str,
    ) -> Result<(), EditError> {
        let texture = self.graph.texture(self.node(node)?);
        let Some((_, declared)) = texture.parameter(parameter) else {
            let names = texture.parameters().iter().map(|p| p.name.as_str());
            return Err(EditError::from(GraphError::UnknownParameter {
                texture: texture.name().to_owned(),
                name: parameter.to_owned(),
                suggestion: did_you_mean(parameter, names).map(str::to_owned),
            }));
        };
        let (is_data, reads_levels) = (declared.is_data, texture.reads_levels());
        let refused = |message: String| EditError::Argument {
            parameter: parameter.to_owned(),
            text: text.to_owned(),
            message,
        };
        match argument(&written(text), declared.ty).map_err(|bad| refused(bad.message))? {
            Argument::Constant(value) => self.set_value(node, parameter, value),
            Argument::Link(Link {
                node: source,
                swizzle,
            }) => {
                let swizzle = swizzle.map_or(String::new(), |s| s.to_string());
                self.set_link(node, parameter, &format!("{source}{swizzle}"))
            }
            Argument::Image(image) => {
                let mut images = Images::default();
                std::mem::swap(&mut images.textures, &mut self.textures);
                let path = Path::new(&image.file.value);
                let srgb = image.srgb.unwrap_or(!is_data);
                let handle = images.handle(&*self.files, scene, path, srgb, image.sampler);
                std::mem::swap(&mut images.textures, &mut self.textures);
                let handle = handle.map_err(refused)?;
                let image = self.textures[handle as usize].image;
                if reads_levels && !self.images_with_levels.contains(&image) {
                    self.images_with_levels.push(image);
                    self.images_with_levels.sort_unstable();
                }
                self.set_value(node, parameter, Value::Image(handle))
            }
        }
    }
}

/// What a text means, wherever a line gives a value: TOML, where numbers may lack the digits on one side of their point
/// (`.5`, `3.`), a list of numbers or of lists its brackets, and texts their quotes, also in a list. `007` is a text.
pub(crate) fn written(text: &str) -> Spanned<look::Value> {
    let completed = with_digits(text);
    let without_brackets = || {
        let list = look::parse_value(&format!("[{completed}]"))?;
        is_of_numbers(&list.value).then_some(list)
    };
    look::parse_value(text)
        .or_else(|| look::parse_value(&completed))
        .or_else(|| text.contains(',').then(without_brackets).flatten())
        .or_else(|| list_of(text))
        .unwrap_or_else(|| Spanned::new(look::Value::Text(text.to_owned()), 0..0))
}

/// The text with zeros in the place of digits that TOML wants and that people leave out: `.5`, `3.`.
fn with_digits(text: &str) -> String {
    let is_digit = |c: char| c.is_ascii_digit();
    let mut completed = String::with_capacity(text.len());
    let mut quote = None;
    let mut before = None;
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let had_digit = before.replace(c).is_some_and(is_digit);
        let has_digit = rest.peek().copied().is_some_and(is_digit);
        match (quote, c) {
            (None, '.') if has_digit && !had_digit => completed.push_str("0."),
            (None, '.') if had_digit && !has_digit => completed.push_str(".0"),
            (Some('"'), '\\') => {
                completed.push(c);
                // Ends nothing, whatever it is.
                completed.extend(rest.next());
            }
            _ => completed.push(c),
        }
        match quote {
            None if matches!(c, '"' | '\'') => quote = Some(c),
            Some(open) if open == c => quote = None,
            _ => {}
        }
    }
    completed
}

/// A list of values each of which is told for itself; `None` for other texts, and where commas may be part of a value.
fn list_of(text: &str) -> Option<Spanned<look::Value>> {
    let inside = text.strip_prefix('[')?.strip_suffix(']')?.trim();
    if inside.contains(['[', ']', '{', '}', '"', '\'', '\n']) {
        return None;
    }
    let inside = inside.strip_suffix(',').unwrap_or(inside);
    let items = inside.split(',').map(str::trim);
    let items = items.map(|item| (!item.is_empty()).then(|| written(item)));
    let items = items.collect::<Option<Vec<_>>>()?;
    Some(Spanned::new(look::Value::List(items), 0..0))
}

/// Whether it is a list of numbers, or of lists.
fn is_of_numbers(value: &look::Value) -> bool {
    let look::Value::List(items) = value else {
        return false;
    };
    let is_number = |item: &look::Value| item.as_number().is_some();
    let is_list = |item: &look::Value| matches!(item, look::Value::List(_));
    (items.iter()).all(|item| is_number(&item.value))
        || items.iter().all(|item| is_list(&item.value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_and_brackets_may_be_left_out() {
        let number = |n| Spanned::new(look::Value::Float(n), 0..0);
        let whole = |n| Spanned::new(look::Value::Integer(n), 0..0);
        let text_of = |text: &str| Spanned::new(look::Value::Text(text.to_owned()), 0..0);
        let list =
            |numbers: &[f64]| look::Value::List(numbers.iter().map(|&n| number(n)).collect());
        for (text, expected) in [
            ("true", look::Value::Bool(true)),
            ("3", look::Value::Integer(3)),
            (".5", look::Value::Float(0.5)),
            ("1, -2.5", look::Value::List(vec![whole(1), number(-2.5)])),
            (".5, 1", look::Value::List(vec![number(0.5), whole(1)])),
            ("[.2,+.5,1.]", list(&[0.2, 0.5, 1.0])),
            ("-.5e1", look::Value::Float(-5.0)),
            ("3.", look::Value::Float(3.0)),
            (
                "['.5', .5]",
                look::Value::List(vec![text_of(".5"), number(0.5)]),
            ),
            (
                r#"["\".5", .5]"#,
                look::Value::List(vec![text_of("\".5"), number(0.5)]),
            ),
            (
                "[mask.x, .5]",
                look::Value::List(vec![text_of("mask.x"), number(0.5)]),
            ),
            ("007", look::Value::Text("007".into())),
            ("mask.x", look::Value::Text("mask.x".into())),
            ("1.2.3", look::Value::Text("1.2.3".into())),
            ("[.2,,1]", look::Value::Text("[.2,,1]".into())),
            ("rock,moss", look::Value::Text("rock,moss".into())),
            ("#ff8000", look::Value::Text("#ff8000".into())),
            ("\"#ff8000\"", look::Value::Text("#ff8000".into())),
            ("maps/a b.png", look::Value::Text("maps/a b.png".into())),
            ("", look::Value::Text(String::new())),
            ("1\nx = 2", look::Value::Text("1\nx = 2".into())),
        ] {
            assert_eq!(without_places(written(text).value), expected, "{text}");
        }
    }

    /// The value with all that lies in lists at no place.
    fn without_places(value: look::Value) -> look::Value {
        match value {
            look::Value::List(items) => {
                let items = items.into_iter();
                let items = items.map(|item| Spanned::new(without_places(item.value), 0..0));
                look::Value::List(items.collect())
            }
            value => value,
        }
    }

    #[test]
    fn lists_without_brackets_suit_parameters_of_whole_numbers_and_matrices() {
        use texgen::{ElementType, ParameterType};
        for (text, ty) in [
            ("1,2", ParameterType::Array(ElementType::I32, 2)),
            ("1, -2.5", ParameterType::Vec2),
            (".5,5.", ParameterType::Vec2),
            ("[1,2,3],[4,5,6],[7,8,9]", ParameterType::Mat3),
            ("[.1,0,0],[0,.1,0],[0,0,.1]", ParameterType::Mat3),
            ("[[.1,0,0],[0,.1,0],[0,0,1.]]", ParameterType::Mat3),
            ("[.2,.5,1]", ParameterType::Vec3),
            ("[0.,'#000'],[.5,'#fff']", ParameterType::Ramp),
            (
                "[1,2,3],[4,5,6]",
                ParameterType::Array(ElementType::Vec3, 2),
            ),
            ("[0,'#000'],[1,'#fff']", ParameterType::Ramp),
        ] {
            let given = argument(&written(text), ty);
            assert!(
                matches!(given, Ok(Argument::Constant(_))),
                "{text}: {given:?}"
            );
        }
    }
}
