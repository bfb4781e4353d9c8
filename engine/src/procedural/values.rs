//! From what a look writes to what a texture's parameter takes. The parameter's type decides what a string or a
//! list means.

use std::ops::RangeInclusive;

use texgen::{Interpolation, ParameterType, Ramp, Value};

use crate::scene::look::{self, Link, Span, Spanned, link_text, unquoted};
use crate::scene::{Filter, Sampler, Wrap};

type Written = Spanned<look::Value>;

/// What a parameter is set to.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Argument {
    Constant(Value),
    Link(Link),
    Image(ImageArgument),
}

/// An image of a `sam2D` parameter, not loaded yet.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ImageArgument {
    pub(super) file: Spanned<String>,
    pub(super) srgb: Option<bool>,
    pub(super) sampler: Sampler,
}

/// Something that a parameter doesn't take.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BadArgument {
    pub(super) span: Span,
    pub(super) message: String,
}

fn bad<T>(value: &Written, message: impl Into<String>) -> Result<T, BadArgument> {
    Err(BadArgument {
        span: value.span.clone(),
        message: message.into(),
    })
}

/// Reads `value` as an argument of type `ty`.
pub(super) fn argument(value: &Written, ty: ParameterType) -> Result<Argument, BadArgument> {
    match (&value.value, ty) {
        (_, ParameterType::Image) => image(value).map(Argument::Image),
        (look::Value::Text(text), _) if !text.starts_with('#') => {
            if !ty.is_linkable() && unquoted(text).is_none() {
                return bad(
                    value,
                    format!(
                        "a parameter of type {ty} can't be driven by a node: {}",
                        wanted(ty)
                    ),
                );
            }
            match link_text(text) {
                Ok(_) if !ty.is_linkable() => bad(value, unquoted(text).unwrap_or_default()),
                Ok(link) => Ok(Argument::Link(link)),
                Err(message) => bad(value, message),
            }
        }
        _ => constant(value, ty).map(Argument::Constant),
    }
}

fn constant(value: &Written, ty: ParameterType) -> Result<Value, BadArgument> {
    use ParameterType::*;
    Ok(match ty {
        F32 => Value::F32(number(value, ty)?),
        I32 => Value::I32(integer(value, ty, i32::MIN.into()..=i32::MAX.into())? as i32),
        U32 => Value::U32(integer(value, ty, 0..=u32::MAX.into())? as u32),
        Bool => match value.value {
            look::Value::Bool(b) => Value::Bool(b),
            _ => return mismatch(value, ty),
        },
        Vec2 => Value::Vec2(vector(value, ty)?),
        Vec3 => match hex(value, ty)? {
            Some([r, g, b, _]) => Value::Vec3([r, g, b]),
            None => Value::Vec3(vector(value, ty)?),
        },
        Vec4 => match hex(value, ty)? {
            Some(rgba) => Value::Vec4(rgba),
            None if list_len(value) == Some(3) => {
                let [x, y, z] = vector(value, ty)?;
                Value::Vec4([x, y, z, 1.0])
            }
            None => Value::Vec4(vector(value, ty)?),
        },
        Mat3 => Value::Mat3(matrix(value, ty)?),
        Mat4 => Value::Mat4(matrix(value, ty)?),
        Ramp => Value::Ramp(ramp(value)?),
        Array(element, count) => {
            let look::Value::List(items) = &value.value else {
                return mismatch(value, ty);
            };
            if items.len() != count as usize {
                return bad(
                    value,
                    format!("expected {count} values, found {}", items.len()),
                );
            }
            let ty = element.parameter_type();
            let items = items.iter().map(|item| constant(item, ty));
            Value::Array(items.collect::<Result<_, _>>()?)
        }
        Image => return mismatch(value, ty),
    })
}

/// What to write for a parameter of this type.
fn wanted(ty: ParameterType) -> String {
    use ParameterType::*;
    match ty {
        F32 => "a number, or the name of a node".into(),
        I32 => "a whole number, or the name of a node".into(),
        U32 => "a whole number that isn't negative, or the name of a node".into(),
        Bool => "true or false, or the name of a node".into(),
        Vec2 => "[x, y], or the name of a node".into(),
        Vec3 => "[x, y, z], a colour \"#rrggbb\", or the name of a node".into(),
        Vec4 => "[x, y, z, w], a colour \"#rrggbb\", or the name of a node".into(),
        Mat3 => "three columns of three numbers".into(),
        Mat4 => "four columns of four numbers".into(),
        Image => "the path of an image, or { file = \"a.png\", ... }".into(),
        Ramp => "stops, as in [[0.0, \"#20100a\"], [1.0, \"#c46a2a\"]]".into(),
        Array(element, count) => format!(
            "a list of {count} values of type {}",
            element.parameter_type()
        ),
    }
}

fn mismatch<T>(value: &Written, ty: ParameterType) -> Result<T, BadArgument> {
    bad(
        value,
        format!("expected {}, found {}", wanted(ty), value.value.kind()),
    )
}

fn number(value: &Written, ty: ParameterType) -> Result<f32, BadArgument> {
    match value.value.as_number().map(|n| n as f32) {
        Some(n) if n.is_finite() => Ok(n),
        Some(_) => bad(value, "expected a finite number"),
        None => mismatch(value, ty),
    }
}

fn integer(
    value: &Written,
    ty: ParameterType,
    range: RangeInclusive<i64>,
) -> Result<i64, BadArgument> {
    match value.value {
        look::Value::Integer(i) if range.contains(&i) => Ok(i),
        _ => mismatch(value, ty),
    }
}

fn list_len(value: &Written) -> Option<usize> {
    match &value.value {
        look::Value::List(items) => Some(items.len()),
        _ => None,
    }
}

/// `N` numbers, or one number for all.
fn vector<const N: usize>(value: &Written, ty: ParameterType) -> Result<[f32; N], BadArgument> {
    match &value.value {
        look::Value::List(items) if items.len() == N => {
            let mut out = [0.0; N];
            for (slot, item) in out.iter_mut().zip(items) {
                *slot = number(item, ParameterType::F32)?;
            }
            Ok(out)
        }
        look::Value::List(items) => bad(
            value,
            format!("expected {}, found {} values", wanted(ty), items.len()),
        ),
        _ => Ok([number(value, ty)?; N]),
    }
}

fn hex(value: &Written, ty: ParameterType) -> Result<Option<[f32; 4]>, BadArgument> {
    match &value.value {
        look::Value::Text(text) => match texgen::color_from_hex(text) {
            Some(rgba) => Ok(Some(rgba)),
            None => bad(
                value,
                format!("`{text}` is not a colour: expected {}", wanted(ty)),
            ),
        },
        _ => Ok(None),
    }
}

fn matrix<const N: usize>(
    value: &Written,
    ty: ParameterType,
) -> Result<[[f32; N]; N], BadArgument> {
    let look::Value::List(columns) = &value.value else {
        return mismatch(value, ty);
    };
    if columns.len() != N || columns.iter().any(|c| list_len(c) != Some(N)) {
        return bad(value, format!("expected {}", wanted(ty)));
    }
    let mut out = [[0.0; N]; N];
    for (slot, column) in out.iter_mut().zip(columns) {
        *slot = vector(column, ty)?;
    }
    Ok(out)
}

/// `[[t, value], ...]` or `{ interpolation = "smooth", stops = [[t, value], ...] }`.
fn ramp(value: &Written) -> Result<Ramp, BadArgument> {
    let (stops, interpolation) = match &value.value {
        look::Value::Table(fields) => {
            let (mut stops, mut interpolation) = (None, Interpolation::Linear);
            for field in fields {
                match field.key.value.as_str() {
                    "stops" => stops = Some(&field.value),
                    "interpolation" => {
                        interpolation = word(
                            &field.value,
                            &[
                                ("linear", Interpolation::Linear),
                                ("smooth", Interpolation::Smooth),
                                ("constant", Interpolation::Constant),
                            ],
                        )?;
                    }
                    _ => return unknown_key(&field.key, "a ramp", &["stops", "interpolation"]),
                }
            }
            match stops {
                Some(stops) => (stops, interpolation),
                None => {
                    return bad(
                        value,
                        "a ramp needs `stops`, as in stops = [[0.0, \"#000\"], [1.0, \"#fff\"]]",
                    );
                }
            }
        }
        _ => (value, Interpolation::Linear),
    };
    let look::Value::List(items) = &stops.value else {
        return mismatch(stops, ParameterType::Ramp);
    };
    if items.is_empty() {
        return bad(stops, "a ramp needs at least one stop");
    }
    let stops = items.iter().map(stop).collect::<Result<_, _>>()?;
    Ok(Ramp {
        stops,
        interpolation,
    })
}

fn stop(item: &Written) -> Result<(f32, [f32; 4]), BadArgument> {
    const STOP: &str = "expected a stop: [t, \"#rrggbb\"], [t, [r, g, b]] or [t, number]";
    let look::Value::List(pair) = &item.value else {
        return bad(item, STOP);
    };
    let [t, color] = pair.as_slice() else {
        return bad(item, STOP);
    };
    let t = number(t, ParameterType::F32)?;
    Ok((
        t,
        match &color.value {
            look::Value::Text(_) => hex(color, ParameterType::Vec4)?.unwrap_or([0.0; 4]),
            look::Value::List(list) if list.len() == 4 => vector(color, ParameterType::Vec4)?,
            look::Value::List(_) => {
                let [r, g, b] = vector(color, ParameterType::Vec3)?;
                [r, g, b, 1.0]
            }
            look::Value::Integer(_) | look::Value::Float(_) => {
                let v = number(color, ParameterType::F32)?;
                [v, v, v, 1.0]
            }
            _ => return bad(item, STOP),
        },
    ))
}

/// `"a.png"` or `{ file = "a.png", color_space = "srgb", wrap = "repeat", filter = "linear" }`.
fn image(value: &Written) -> Result<ImageArgument, BadArgument> {
    let mut argument = ImageArgument {
        file: value.with(String::new()),
        srgb: None,
        sampler: Sampler::default(),
    };
    match &value.value {
        look::Value::Text(path) => argument.file.value.clone_from(path),
        look::Value::Table(fields) => {
            const WRAPS: [(&str, Wrap); 3] = [
                ("repeat", Wrap::Repeat),
                ("mirror", Wrap::Mirror),
                ("clamp", Wrap::Clamp),
            ];
            for field in fields {
                let v = &field.value;
                match (field.key.value.as_str(), &v.value) {
                    ("file", look::Value::Text(path)) => argument.file = v.with(path.clone()),
                    ("file", _) => return bad(v, "expected the path of an image"),
                    ("color_space", _) => {
                        argument.srgb = Some(word(v, &[("srgb", true), ("linear", false)])?)
                    }
                    ("wrap", _) => {
                        let [u, v] = match &v.value {
                            look::Value::List(both) if both.len() == 2 => [&both[0], &both[1]],
                            _ => [v, v],
                        };
                        argument.sampler.wrap_u = word(u, &WRAPS)?;
                        argument.sampler.wrap_v = word(v, &WRAPS)?;
                    }
                    ("filter", _) => {
                        argument.sampler.filter = word(
                            v,
                            &[("linear", Filter::Linear), ("nearest", Filter::Nearest)],
                        )?;
                    }
                    _ => {
                        return unknown_key(
                            &field.key,
                            "an image",
                            &["file", "color_space", "wrap", "filter"],
                        );
                    }
                }
            }
        }
        _ => return mismatch(value, ParameterType::Image),
    }
    if argument.file.value.is_empty() {
        return bad(value, "an image needs `file`, the path of a picture");
    }
    Ok(argument)
}

fn word<T: Copy>(value: &Written, words: &[(&str, T)]) -> Result<T, BadArgument> {
    let found = match &value.value {
        look::Value::Text(text) => words.iter().find(|(word, _)| word == text),
        _ => None,
    };
    match found {
        Some(&(_, meaning)) => Ok(meaning),
        None => {
            let list: Vec<_> = words
                .iter()
                .map(|(word, _)| format!("\"{word}\""))
                .collect();
            bad(value, format!("expected {}", list.join(" or ")))
        }
    }
}

fn unknown_key<T>(key: &Spanned<String>, what: &str, known: &[&str]) -> Result<T, BadArgument> {
    Err(BadArgument {
        span: key.span.clone(),
        message: format!(
            "{what} has no key `{}`: it has {}",
            key.value,
            known.join(", ")
        ),
    })
}
