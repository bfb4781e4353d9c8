//! Typed reading of look values: each function returns what was meant, or notes a problem at its place and goes on,
//! so that one run shows every mistake of a file.
//!
//! Nothing here knows which tables a look has.

use glam::Vec3;

use super::value::{Field, Span, Spanned, Value};
use super::{Input, Link, Problem};

/// Collects the problems of one look file.
#[derive(Debug, Default)]
pub(super) struct Reader {
    pub(super) problems: Vec<Problem>,
}

impl Reader {
    pub(super) fn problem(&mut self, span: &Span, message: impl Into<String>) {
        self.problems.push(Problem {
            span: span.clone(),
            message: message.into(),
            note: None,
        });
    }

    pub(super) fn problem_with_note(
        &mut self,
        span: &Span,
        message: impl Into<String>,
        note: impl Into<String>,
    ) {
        self.problems.push(Problem {
            span: span.clone(),
            message: message.into(),
            note: Some(note.into()),
        });
    }

    fn wrong_kind(&mut self, value: &Spanned<Value>, wanted: &str) {
        self.problem(
            &value.span,
            format!("expected {wanted}, found {}", value.value.kind()),
        );
    }

    /// A key that `table` doesn't have.
    pub(super) fn unknown_key(&mut self, key: &Spanned<String>, table: &str, known: &[&str]) {
        let message = format!("{table} has no key `{}`", key.value);
        let note = match closest(&key.value, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("it has: {}", known.join(", ")),
        };
        self.problem_with_note(&key.span, message, note);
    }

    pub(super) fn table<'v>(
        &mut self,
        value: &'v Spanned<Value>,
        wanted: &str,
    ) -> Option<&'v [Field]> {
        match &value.value {
            Value::Table(fields) => Some(fields),
            _ => {
                self.wrong_kind(value, wanted);
                None
            }
        }
    }

    pub(super) fn text(&mut self, value: &Spanned<Value>) -> Option<Spanned<String>> {
        match &value.value {
            Value::Text(text) => Some(value.with(text.clone())),
            _ => {
                self.wrong_kind(value, "a string");
                None
            }
        }
    }

    pub(super) fn bool(&mut self, value: &Spanned<Value>) -> Option<Spanned<bool>> {
        match value.value {
            Value::Bool(b) => Some(value.with(b)),
            _ => {
                self.wrong_kind(value, "true or false");
                None
            }
        }
    }

    /// A finite number for which `valid` holds; `wanted` says which ones those are.
    pub(super) fn number(
        &mut self,
        value: &Spanned<Value>,
        wanted: &str,
        valid: impl Fn(f32) -> bool,
    ) -> Option<Spanned<f32>> {
        let Some(number) = value.value.as_number() else {
            self.wrong_kind(value, wanted);
            return None;
        };
        let number = number as f32;
        if number.is_finite() && valid(number) {
            Some(value.with(number))
        } else {
            self.problem(&value.span, format!("expected {wanted}"));
            None
        }
    }

    /// Exactly `N` finite numbers.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        value: &Spanned<Value>,
        wanted: &str,
    ) -> Option<Spanned<[f32; N]>> {
        let Value::List(list) = &value.value else {
            self.wrong_kind(value, wanted);
            return None;
        };
        if list.len() != N {
            self.problem(
                &value.span,
                format!("expected {wanted}, found {} values", list.len()),
            );
            return None;
        }
        let mut out = [0.0; N];
        for (slot, item) in out.iter_mut().zip(list) {
            *slot = self.number(item, "a finite number", |_| true)?.value;
        }
        Some(value.with(out))
    }

    pub(super) fn vec3(&mut self, value: &Spanned<Value>) -> Option<Spanned<Vec3>> {
        let numbers = self.numbers::<3>(value, "three numbers, as in [0.0, 1.0, 0.0]")?;
        Some(numbers.with(Vec3::from(numbers.value)))
    }

    /// A linear colour whose components are not negative.
    pub(super) fn color(&mut self, value: &Spanned<Value>) -> Option<Spanned<Vec3>> {
        match color(&value.value) {
            Ok(color) if color.min_element() >= 0.0 => Some(value.with(color)),
            Ok(_) => {
                self.problem(&value.span, "a colour can't be negative");
                None
            }
            Err(message) => {
                self.problem(&value.span, message);
                None
            }
        }
    }

    /// A colour, or a link to a node.
    pub(super) fn color_input(&mut self, value: &Spanned<Value>) -> Option<Spanned<Input>> {
        match &value.value {
            Value::Text(text) if !text.starts_with('#') => self.link(value, text),
            _ => self.color(value).map(|c| c.with(Input::Constant(c.value))),
        }
    }

    /// A number of 0 to 1, or a link to a node.
    pub(super) fn unit_input(&mut self, value: &Spanned<Value>) -> Option<Spanned<Input>> {
        if let Value::Text(text) = &value.value {
            return self.link(value, text);
        }
        let number = self.number(value, "a number from 0 to 1, or the name of a node", unit)?;
        Some(number.with(Input::Constant(Vec3::splat(number.value))))
    }

    fn link(&mut self, value: &Spanned<Value>, text: &str) -> Option<Spanned<Input>> {
        match link_text(text) {
            Ok(link) => Some(value.with(Input::Link(link))),
            Err(message) => {
                self.problem(&value.span, message);
                None
            }
        }
    }
}

/// Whether a number lies in 0 to 1.
pub(super) fn unit(x: f32) -> bool {
    (0.0..=1.0).contains(&x)
}

/// Reads `"#rrggbb"` or `"#rgb"` (sRGB, converted to linear) or `[r, g, b]` (linear). The components of a list are
/// finite but otherwise free. The error says what was expected.
pub fn color(value: &Value) -> Result<Vec3, String> {
    const WANTED: &str = "expected a colour: \"#rrggbb\" (sRGB) or [r, g, b] (linear)";
    match value {
        Value::Text(text) => hex_color(text).ok_or_else(|| WANTED.to_owned()),
        Value::List(list) if list.len() == 3 => {
            let mut rgb = [0.0; 3];
            for (slot, item) in rgb.iter_mut().zip(list) {
                let number = item.value.as_number().map(|n| n as f32);
                *slot = number.filter(|n| n.is_finite()).ok_or(WANTED)?;
            }
            Ok(Vec3::from(rgb))
        }
        _ => Err(format!("{WANTED}, found {}", value.kind())),
    }
}

fn hex_color(text: &str) -> Option<Vec3> {
    let digits = text.strip_prefix('#')?;
    if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let channel = |at: usize, len: usize| u8::from_str_radix(&digits[at..at + len], 16).ok();
    let [r, g, b] = match digits.len() {
        3 => [
            channel(0, 1)? * 17,
            channel(1, 1)? * 17,
            channel(2, 1)? * 17,
        ],
        6 => [channel(0, 2)?, channel(2, 2)?, channel(4, 2)?],
        _ => return None,
    };
    Some(Vec3::new(
        srgb_to_linear(r),
        srgb_to_linear(g),
        srgb_to_linear(b),
    ))
}

/// The electro-optical transfer function of IEC 61966-2-1.
fn srgb_to_linear(encoded: u8) -> f32 {
    let c = f32::from(encoded) / 255.0;
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

/// Reads `"node"` or `"node.xyz"`. The error says what is wrong with it.
pub fn link_text(text: &str) -> Result<Link, String> {
    let (node, swizzle) = match text.split_once('.') {
        Some((node, swizzle)) => (node, Some(swizzle)),
        None => (text, None),
    };
    if !is_name(node) {
        return Err(format!(
            "`{text}` is neither the name of a node, as in \"rust_mask\" or \"rust_mask.x\", nor a colour, as in \"#7a3b12\""
        ));
    }
    if let Some(swizzle) = swizzle {
        let of = |set: &str| swizzle.chars().all(|c| set.contains(c));
        if swizzle.is_empty() || swizzle.len() > 4 || !(of("xyzw") || of("rgba")) {
            return Err(format!(
                "`.{swizzle}` is not a swizzle: one to four of x y z w, or of r g b a"
            ));
        }
    }
    Ok(Link {
        node: node.to_owned(),
        swizzle: swizzle.map(str::to_owned),
    })
}

/// Whether nodes and AO tables may be called this: letters, digits, `_` and `-`, as in a TOML key without quotes.
pub(super) fn is_name(text: &str) -> bool {
    !text.is_empty()
        && text
            .chars()
            .all(|c| c.is_alphanumeric() || c == '_' || c == '-')
}

/// Whether a string looks like an image file rather than a link, for messages.
pub fn image_path(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    [
        ".png", ".jpg", ".jpeg", ".hdr", ".exr", ".webp", ".bmp", ".tga",
    ]
    .iter()
    .any(|ending| lower.ends_with(ending))
}

/// The name nearest to a mistyped one, if any is near: at most a third of its letters differ.
pub fn closest<'n>(wrong: &str, names: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    let limit = (wrong.chars().count() / 3).max(1);
    names
        .map(|name| (edit_distance(wrong, name, limit), name))
        .filter(|&(distance, _)| distance <= limit)
        .min()
        .map(|(_, name)| name)
}

/// Levenshtein's distance without regard to case; `limit + 1` stands for anything above `limit`.
fn edit_distance(a: &str, b: &str, limit: usize) -> usize {
    let a: Vec<char> = a.chars().flat_map(char::to_lowercase).collect();
    let b: Vec<char> = b.chars().flat_map(char::to_lowercase).collect();
    if a.len().abs_diff(b.len()) > limit {
        return limit + 1;
    }
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
