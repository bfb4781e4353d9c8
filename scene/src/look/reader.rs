//! Typed reading of look values: each function returns what was meant, or notes a problem at its place and goes on,
//! so that one run shows every mistake of a file.
//!
//! Nothing here knows which tables a look has.

use glam::Vec3;
use texgen::{Diagnostic, Diagnostics, SourceFile, Swizzle, did_you_mean};

use super::value::{Field, Span, Spanned, Value};
use super::{Input, Link};

/// Most problems that are kept, and most warnings: a text can have a million, of which nobody reads more than the first.
const MOST: usize = 1000;
/// Most problems that are told with the nearest right name, which takes long to find.
const MOST_SUGGESTED: usize = 100;

/// Collects the problems of one look file.
#[derive(Debug)]
pub(super) struct Reader {
    pub(super) file: SourceFile,
    pub(super) problems: Found,
    pub(super) warnings: Found,
}

/// Problems or warnings as they are found: the first ones, and how many there are beyond.
#[derive(Debug, Default)]
pub(super) struct Found {
    kept: Vec<Diagnostic>,
    more: usize,
}

impl Found {
    pub(super) fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    fn push(&mut self, diagnostic: impl FnOnce() -> Diagnostic) {
        match self.kept.len() < MOST {
            true => self.kept.push(diagnostic()),
            false => self.more += 1,
        }
    }

    /// All, in the order of the text.
    pub(super) fn in_order(mut self) -> Diagnostics {
        let start = |d: &Diagnostic| d.labels.first().map_or(0, |label| label.span.start);
        self.kept.sort_by_key(start);
        let severity = self.kept.first().map(|first| first.severity);
        let mut all: Diagnostics = self.kept.into_iter().collect();
        if let Some(severity) = severity {
            // Such a list is full: it only counts them.
            let uncounted = || Diagnostic {
                severity,
                ..Diagnostic::error("")
            };
            all.extend(std::iter::repeat_with(uncounted).take(self.more));
        }
        all
    }
}

impl Reader {
    pub(super) fn new(file: SourceFile) -> Self {
        Self {
            file,
            problems: Found::default(),
            warnings: Found::default(),
        }
    }

    /// Whether the next problem is told with the nearest right name.
    pub(super) fn suggests(&self) -> bool {
        self.problems.kept.len() < MOST_SUGGESTED
    }

    pub(super) fn problem(&mut self, span: &Span, message: impl Into<String>) {
        let file = &self.file;
        self.problems
            .push(|| Diagnostic::error(message).with_label(file, span.clone(), ""));
    }

    pub(super) fn problem_with_note(
        &mut self,
        span: &Span,
        message: impl Into<String>,
        note: impl Into<String>,
    ) {
        let file = &self.file;
        self.problems.push(|| {
            let problem = Diagnostic::error(message).with_label(file, span.clone(), "");
            problem.with_note(note)
        });
    }

    pub(super) fn wrong_kind(&mut self, value: &Spanned<Value>, wanted: &str) {
        if let Value::Text(text) = &value.value
            && let Some(remedy) = unquoted(text)
        {
            self.problem(&value.span, format!("expected {wanted}: {remedy}"));
            return;
        }
        self.problem(
            &value.span,
            format!("expected {wanted}, found {}", value.value.kind()),
        );
    }

    /// A key that `table` doesn't have.
    pub(super) fn unknown_key(&mut self, key: &Spanned<String>, table: &str, known: &[&str]) {
        let message = format!("{table} has no key `{}`", key.value);
        let near = || did_you_mean(&key.value, known.iter().copied());
        let near = self.suggests().then(near).flatten();
        let note = match (misplaced_key(&key.value), near) {
            (Some(remedy), _) => remedy,
            (None, Some(near)) => format!("did you mean `{near}`?"),
            (None, None) => format!("it has: {}", known.join(", ")),
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

    /// A colour of which no component is usually more than 1: a share of light.
    pub(super) fn share_color(&mut self, value: &Spanned<Value>) -> Option<Spanned<Vec3>> {
        let color = self.color(value)?;
        if let Some(remedy) = color_remedy(&value.value) {
            let file = &self.file;
            self.warnings.push(|| {
                Diagnostic::warning("a surface would give back more light than it gets")
                    .with_label(file, value.span.clone(), "a colour beyond 1")
                    .with_note(remedy)
            });
        }
        Some(color)
    }

    /// A number of 0 to 1, or a link to a node.
    pub(super) fn unit_input(&mut self, value: &Spanned<Value>) -> Option<Spanned<Input>> {
        self.number_input(value, "a number from 0 to 1", unit)
    }

    /// A number for which `valid` holds, or a link to a node.
    pub(super) fn number_input(
        &mut self,
        value: &Spanned<Value>,
        wanted: &str,
        valid: impl Fn(f32) -> bool,
    ) -> Option<Spanned<Input>> {
        if let Value::Text(text) = &value.value {
            return self.link(value, text);
        }
        let wanted = format!("{wanted}, or the name of a node");
        let number = self.number(value, &wanted, valid)?;
        Some(number.with(Input::Constant(Vec3::splat(number.value))))
    }

    /// A link to a node.
    pub(super) fn link(&mut self, value: &Spanned<Value>, text: &str) -> Option<Spanned<Input>> {
        match link_text(text) {
            Ok(link) => Some(value.with(Input::Link(link))),
            Err(message) => {
                self.problem(&value.span, message);
                None
            }
        }
    }
}

/// One of a few words.
pub(super) fn choice<T: Copy>(
    reader: &mut Reader,
    value: &Spanned<Value>,
    words: &[(&str, T)],
) -> Option<Spanned<T>> {
    let text = reader.text(value)?;
    let found = words.iter().find(|(word, _)| *word == text.value);
    if found.is_none() {
        let list: Vec<_> = words
            .iter()
            .map(|(word, _)| format!("\"{word}\""))
            .collect();
        reader.problem(&value.span, format!("expected {}", list.join(", ")));
    }
    found.map(|&(_, meaning)| value.with(meaning))
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
        Value::Text(text) => texgen::color_from_hex(text)
            .map(|rgba| Vec3::from_slice(&rgba))
            .ok_or_else(|| WANTED.to_owned()),
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

/// What to write in place of a text that is a number, or something else that needs no quotes; `None` for other texts.
pub fn unquoted(text: &str) -> Option<String> {
    let value = super::parse_value(text.trim())?;
    let is_finite = value.value.as_number().is_none_or(f64::is_finite);
    let kind = match value.value {
        Value::Bool(_) | Value::Integer(_) | Value::Float(_) | Value::List(_) => value.value.kind(),
        Value::Text(_) | Value::Table(_) | Value::Date => return None,
    };
    let text = text.trim();
    is_finite.then(|| format!("\"{text}\" is a string, not {kind}; write {text} without quotes"))
}

/// What to do about a key of a whole look in one of its tables; `None` for other keys.
pub fn misplaced_key(key: &str) -> Option<String> {
    super::KEYS.contains(&key).then(|| {
        format!(
            "in TOML a key belongs to the last [table] above it: move `{key}` to the top of the file, before the first [table]"
        )
    })
}

/// What to write in place of a colour beyond 1; `None` where no component is.
pub fn color_remedy(value: &Value) -> Option<String> {
    let Value::List(list) = value else {
        return None;
    };
    let numbers: Vec<f64> = list.iter().filter_map(|n| n.value.as_number()).collect();
    let most = numbers.iter().copied().fold(0.0, f64::max);
    if most <= 1.0 || !(3..=4).contains(&numbers.len()) {
        return None;
    }
    let is_byte = |n: &f64| n.fract() == 0.0 && (0.0..=255.0).contains(n);
    Some(if numbers.iter().all(is_byte) {
        let hex: String = (numbers.iter().take(3))
            .map(|&n| format!("{:02x}", n as u8))
            .collect();
        format!(
            "components of a colour are 0 to 1 and linear; for sRGB values of 0 to 255 write \"#{hex}\", for linear ones \
             divide by 255"
        )
    } else {
        "components of a colour are 0 to 1 and linear; \"#rrggbb\" is sRGB".to_owned()
    })
}

/// Reads `"node"` or `"node.xyz"`. The error says what is wrong with it.
pub fn link_text(text: &str) -> Result<Link, String> {
    // A node may be called `5` or `true`, but neither `0.02` nor `[1]`.
    if !is_name(text)
        && let Some(remedy) = unquoted(text)
    {
        return Err(remedy);
    }
    let (node, swizzle) = match text.split_once('.') {
        Some((node, swizzle)) => (node, Some(swizzle)),
        None => (text, None),
    };
    if !is_name(node) {
        return Err(format!(
            "`{text}` is neither the name of a node, as in \"rust_mask\" or \"rust_mask.x\", nor a colour, as in \"#7a3b12\""
        ));
    }
    let swizzle = match swizzle.map(str::parse::<Swizzle>) {
        Some(Err(error)) => return Err(error.to_string()),
        Some(Ok(swizzle)) => Some(swizzle),
        None => None,
    };
    Ok(Link {
        node: node.to_owned(),
        swizzle,
    })
}

/// Longest name of what becomes part of the name of a layer, bytes: channels of OpenEXR files have names of 255 bytes at most, with that of
/// the layer, and readers give up on longer ones.
pub(super) const LONGEST_NAME: usize = 200;

/// Whether nodes and AO tables may be called this: letters, digits, `_` and `-`, as in a TOML key without quotes.
pub(super) fn is_name(text: &str) -> bool {
    !text.is_empty()
        && text
            .chars()
            .all(|c| c.is_alphanumeric() || c == '_' || c == '-')
}

#[cfg(test)]
mod tests {
    use super::*;
    use texgen::Severity;

    #[test]
    fn of_very_many_mistakes_some_are_kept_and_all_counted() {
        let mut reader = Reader::new(SourceFile::new("look", "a.look.toml", "ab = 1"));
        let key = Spanned::new("ab".to_owned(), 0..2);
        for _ in 0..5000 {
            reader.unknown_key(&key, "a look", &["ao"]);
        }
        let kept = &reader.problems.kept;
        assert_eq!(kept.len(), MOST);
        let suggests = |d: &&Diagnostic| d.notes[0].contains("did you mean");
        assert_eq!(kept.iter().filter(suggests).count(), MOST_SUGGESTED);
        let all = reader.problems.in_order();
        assert_eq!(all.count(Severity::Error), 5000);
        assert!(all.render().contains("more errors are not shown"));
    }
}
