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
    /// colours and paths, and brackets around plain numbers. A name is a link to another node. An image is read from its
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

/// What a text means: TOML, numbers with commas between, or else a string.
fn written(text: &str) -> Spanned<look::Value> {
    if let Some(value) = look::parse_value(text) {
        return value;
    }
    let spanned = |value| Spanned::new(value, 0..0);
    // Whole numbers stay whole, and lists may hold lists.
    if text.contains(',')
        && let Some(list) = look::parse_value(&format!("[{text}]"))
        && is_of_numbers(&list.value)
    {
        return spanned(list.value);
    }
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    spanned(match numbers.as_deref() {
        Some(&[number]) => look::Value::Float(number),
        Some(numbers) => {
            let numbers = numbers.iter().map(|&n| spanned(look::Value::Float(n)));
            look::Value::List(numbers.collect())
        }
        None => look::Value::Text(text.to_owned()),
    })
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
        for (text, expected) in [
            ("true", look::Value::Bool(true)),
            ("3", look::Value::Integer(3)),
            (".5", look::Value::Float(0.5)),
            ("1, -2.5", look::Value::List(vec![whole(1), number(-2.5)])),
            (".5, 1", look::Value::List(vec![number(0.5), number(1.0)])),
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
