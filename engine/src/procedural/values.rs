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

/// What a value is to be.
#[derive(Debug, Clone, Copy)]
struct Wanted {
    ty: ParameterType,
    /// The name of a node may stand there instead: for a parameter as a whole, not within a list.
    or_node: bool,
}

impl Wanted {
    fn only(ty: ParameterType) -> Self {
        Self { ty, or_node: false }
    }
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
                        Wanted::only(ty)
                    ),
                );
            }
            match link_text(text) {
                Ok(_) if !ty.is_linkable() => bad(value, unquoted(text).unwrap_or_default()),
                Ok(link) => Ok(Argument::Link(link)),
                Err(message) => bad(value, message),
            }
        }
        _ => {
            let or_node = ty.is_linkable();
            constant(value, Wanted { ty, or_node }).map(Argument::Constant)
        }
    }
}

fn constant(value: &Written, wanted: Wanted) -> Result<Value, BadArgument> {
    use ParameterType::*;
    Ok(match wanted.ty {
        F32 => Value::F32(number(value, wanted)?),
        I32 => Value::I32(integer(value, wanted, i32::MIN.into()..=i32::MAX.into())? as i32),
        U32 => Value::U32(integer(value, wanted, 0..=u32::MAX.into())? as u32),
        Bool => match value.value {
            look::Value::Bool(b) => Value::Bool(b),
            _ => return mismatch(value, wanted),
        },
        Vec2 => Value::Vec2(vector(value, wanted)?),
        Vec3 => match hex(value, wanted)? {
            Some([r, g, b, _]) => Value::Vec3([r, g, b]),
            None => Value::Vec3(vector(value, wanted)?),
        },
        Vec4 => match hex(value, wanted)? {
            Some(rgba) => Value::Vec4(rgba),
            None if list_len(value) == Some(3) => {
                let [x, y, z] = vector(value, wanted)?;
                Value::Vec4([x, y, z, 1.0])
            }
            None => Value::Vec4(vector(value, wanted)?),
        },
        Mat3 => Value::Mat3(matrix(value, wanted)?),
        Mat4 => Value::Mat4(matrix(value, wanted)?),
        Ramp => Value::Ramp(ramp(value)?),
        Array(element, count) => {
            let look::Value::List(items) = &value.value else {
                return mismatch(value, wanted);
            };
            if items.len() != count as usize {
                return bad(
                    value,
                    format!("expected {count} values, found {}", items.len()),
                );
            }
            let wanted = Wanted::only(element.parameter_type());
            let items = items.iter().map(|item| constant(item, wanted));
            Value::Array(items.collect::<Result<_, _>>()?)
        }
        Image => return mismatch(value, wanted),
    })
}

/// What to write.
impl std::fmt::Display for Wanted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        use ParameterType::*;
        let color = match self.or_node {
            true => ", a colour \"#rrggbb\"",
            false => " or a colour \"#rrggbb\"",
        };
        let written = match self.ty {
            F32 => f.write_str("a number"),
            I32 => f.write_str("a whole number"),
            U32 => f.write_str("a whole number that isn't negative"),
            Bool => f.write_str("true or false"),
            Vec2 => f.write_str("[x, y]"),
            Vec3 => write!(f, "[x, y, z]{color}"),
            Vec4 => write!(f, "[x, y, z, w]{color}"),
            Mat3 => f.write_str("three columns of three numbers"),
            Mat4 => f.write_str("four columns of four numbers"),
            Image => f.write_str("the path of an image, or { file = \"a.png\", ... }"),
            Ramp => f.write_str("stops, as in [[0.0, \"#20100a\"], [1.0, \"#c46a2a\"]]"),
            Array(element, count) => {
                let ty = element.parameter_type();
                write!(f, "a list of {count} values of type {ty}")
            }
        };
        written?;
        match self.or_node {
            true => f.write_str(", or the name of a node"),
            false => Ok(()),
        }
    }
}

fn mismatch<T>(value: &Written, wanted: Wanted) -> Result<T, BadArgument> {
    bad(
        value,
        format!("expected {wanted}, found {}", value.value.kind()),
    )
}

fn number(value: &Written, wanted: Wanted) -> Result<f32, BadArgument> {
    match value.value.as_number().map(|n| n as f32) {
        Some(n) if n.is_finite() => Ok(n),
        Some(_) => bad(value, "expected a finite number"),
        None => mismatch(value, wanted),
    }
}

fn integer(
    value: &Written,
    wanted: Wanted,
    range: RangeInclusive<i64>,
) -> Result<i64, BadArgument> {
    match value.value {
        look::Value::Integer(i) if range.contains(&i) => Ok(i),
        look::Value::Integer(i) => {
            let (least, most) = (range.start(), range.end());
            bad(
                value,
                format!("expected a whole number from {least} to {most}, found {i}"),
            )
        }
        _ => mismatch(value, wanted),
    }
}

fn list_len(value: &Written) -> Option<usize> {
    match &value.value {
        look::Value::List(items) => Some(items.len()),
        _ => None,
    }
}

/// `N` numbers, or one number for all.
fn vector<const N: usize>(value: &Written, wanted: Wanted) -> Result<[f32; N], BadArgument> {
    match &value.value {
        look::Value::List(items) if items.len() == N => {
            let mut out = [0.0; N];
            for (slot, item) in out.iter_mut().zip(items) {
                *slot = number(item, Wanted::only(ParameterType::F32))?;
            }
            Ok(out)
        }
        look::Value::List(items) => bad(
            value,
            format!("expected {wanted}, found {} values", items.len()),
        ),
        _ => Ok([number(value, wanted)?; N]),
    }
}

fn hex(value: &Written, wanted: Wanted) -> Result<Option<[f32; 4]>, BadArgument> {
    match &value.value {
        look::Value::Text(text) => match texgen::color_from_hex(text) {
            Some(rgba) => Ok(Some(rgba)),
            None => bad(
                value,
                format!("`{text}` is not a colour: expected {wanted}"),
            ),
        },
        _ => Ok(None),
    }
}

fn matrix<const N: usize>(value: &Written, wanted: Wanted) -> Result<[[f32; N]; N], BadArgument> {
    let look::Value::List(columns) = &value.value else {
        return mismatch(value, wanted);
    };
    if columns.len() != N || columns.iter().any(|c| list_len(c) != Some(N)) {
        return bad(value, format!("expected {wanted}"));
    }
    let mut out = [[0.0; N]; N];
    for (slot, column) in out.iter_mut().zip(columns) {
        *slot = vector(column, wanted)?;
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
        return mismatch(stops, Wanted::only(ParameterType::Ramp));
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
    let t = number(t, Wanted::only(ParameterType::F32))?;
    Ok((
        t,
        match &color.value {
            look::Value::Text(_) => {
                hex(color, Wanted::only(ParameterType::Vec4))?.unwrap_or([0.0; 4])
            }
            look::Value::List(list) if list.len() == 4 => {
                vector(color, Wanted::only(ParameterType::Vec4))?
            }
            look::Value::List(_) => {
                let [r, g, b] = vector(color, Wanted::only(ParameterType::Vec3))?;
                [r, g, b, 1.0]
            }
            look::Value::Integer(_) | look::Value::Float(_) => {
                let v = number(color, Wanted::only(ParameterType::F32))?;
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
        _ => return mismatch(value, Wanted::only(ParameterType::Image)),
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

#[cfg(test)]
mod tests {
    use texgen::ElementType;

    use super::*;

    #[test]
    fn nodes_are_offered_for_whole_parameters_only() {
        use ParameterType::*;
        for (ty, text, is_offered) in [
            (F32, "true", true),
            (Vec3, "true", true),
            (Vec3, "'#12'", true),
            (Vec3, "[1, 2, 'a']", false),
            (Array(ElementType::F32, 2), "[1, 'a']", false),
            (Array(ElementType::Vec3, 1), "['a']", false),
            (Mat3, "[[1, 0, 0], [0, 1, 0], [0, 0, 'a']]", false),
            (Ramp, "[['a', 1]]", false),
            (Ramp, "[[0, 'a']]", false),
        ] {
            let value = look::parse_value(text).expect("TOML");
            let refused = argument(&value, ty).expect_err(text).message;
            assert_eq!(refused.contains("name of a node"), is_offered, "{refused}");
        }
    }

    #[test]
    fn of_whole_numbers_out_of_range_the_range_is_told() {
        use ParameterType::*;
        for (ty, text, expected) in [
            (U32, "4294967296", "from 0 to 4294967295, found 4294967296"),
            (U32, "-1", "from 0 to 4294967295, found -1"),
            (I32, "2147483648", "from -2147483648 to 2147483647"),
            (Array(ElementType::U32, 1), "[-1]", "from 0 to 4294967295"),
            (U32, "1.5", "a whole number that isn't negative"),
        ] {
            let value = look::parse_value(text).expect("TOML");
            let refused = argument(&value, ty).expect_err(text).message;
            assert!(refused.contains(expected), "{refused}");
        }
    }
}
