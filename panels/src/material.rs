//! The keys of a material that the panel shows: the table of parameters, with constants as they stand in a look.

use engine::procedural::Output;
use engine::scene::Material;
use engine::scene::look::{Value, color};
use engine::scene::material_parameters::{Constant, Unit};

pub(crate) use engine::scene::material_parameters::{PARAMETERS, Parameter as Key, Takes};

/// A parameter in a look.
pub(crate) trait InLook {
    /// What a node drives with it.
    fn output(&self) -> Option<Output>;

    /// What it is without the look's key: that of the material as it is shown.
    fn written(&self, material: &Material) -> Option<Value>;

    /// A constant as the widget of this key takes it; `None` where `written` is something else, such as a link.
    fn shown(&self, written: &Value) -> Option<texgen::Value>;
}

impl InLook for Key {
    fn output(&self) -> Option<Output> {
        let number = self.driven?.number;
        Output::ALL.get(number as usize).copied()
    }

    fn written(&self, material: &Material) -> Option<Value> {
        Some(match (self.constant(material)?, self.takes) {
            (Constant::Number(x), Takes::Whole { .. }) => Value::Integer(x as i64),
            (Constant::Number(x), Takes::Number(number)) if number.unit == Unit::Degrees => {
                Value::number(x.to_degrees())
            }
            (Constant::Number(x), _) => Value::number(x),
            (Constant::Color(color), _) => Value::numbers(&color.to_array()),
            (Constant::Flag(flag), _) => Value::Bool(flag),
            (Constant::Word(word), _) => Value::Text(word.to_owned()),
        })
    }

    fn shown(&self, written: &Value) -> Option<texgen::Value> {
        use texgen::Value as V;
        Some(match self.takes {
            Takes::Color { .. } => match written.as_number() {
                Some(x) => V::Vec3([x as f32; 3]),
                None => V::Vec3(color(written).ok()?.to_array()),
            },
            Takes::Number(_) => V::F32(written.as_number()? as f32),
            Takes::Whole { .. } => V::I32(written.as_number()? as i32),
            Takes::Flag => match written {
                Value::Bool(b) => V::Bool(*b),
                _ => return None,
            },
            Takes::Choice(_) | Takes::Link => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use engine::session::{Document, Edit, written};

    use super::*;

    #[test]
    fn a_key_drives_what_is_called_so() {
        let driven = PARAMETERS
            .iter()
            .filter_map(|key| Some((key, key.output()?)));
        let mut count = 0;
        for (key, output) in driven {
            assert_eq!(key.key, output.key());
            count += 1;
        }
        assert_eq!(count, Output::ALL.len());
    }

    #[test]
    fn looks_take_what_the_widgets_give() {
        use texgen::Value as V;
        for key in &PARAMETERS {
            let values = match key.takes {
                Takes::Color { .. } => vec![V::Vec3([0.0; 3]), V::Vec3([0.2, 1.0, 3.0])],
                Takes::Number(number) => vec![V::F32(number.slider.0), V::F32(number.slider.1)],
                Takes::Whole { slider, .. } => vec![V::I32(slider.0), V::I32(slider.1)],
                Takes::Flag => vec![V::Bool(true), V::Bool(false)],
                Takes::Choice(_) | Takes::Link => vec![],
            };
            let words = match key.takes {
                Takes::Choice(words) => words.iter().map(|&w| Value::Text(w.into())).collect(),
                Takes::Link => vec![Value::Text("n".into())],
                _ => vec![],
            };
            for value in values.iter().map(written).chain(words) {
                let head = "[node.n]\ntexture = 't'\n[material.M]\nattenuation_distance = 1\n";
                let bump = if key.key == "bump_scale" {
                    "bump = 'n'\n"
                } else {
                    ""
                };
                let text = format!("{head}{bump}");
                let mut document = Document::new(Path::new("a"), &text).expect("a look");
                let edit = Edit::material("M", key.key, value.clone());
                let applied = document.apply(key.label, &[edit], None);
                applied.unwrap_or_else(|why| panic!("{} = {value:?}: {why}", key.key));
            }
        }
    }

    #[test]
    fn every_constant_has_a_widget() {
        let material = Material::default();
        for key in &PARAMETERS {
            let constant = key.written(&material);
            match key.takes {
                Takes::Link => assert!(constant.is_none()),
                Takes::Choice(words) => {
                    let is_known = |v: &Value| words.iter().any(|&w| *v == Value::Text(w.into()));
                    assert!(constant.is_some_and(|v| is_known(&v)), "{}", key.key);
                }
                _ => assert!(
                    constant.and_then(|v| key.shown(&v)).is_some(),
                    "{}",
                    key.key
                ),
            }
        }
    }
}
