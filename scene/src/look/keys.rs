//! Values that change with time: `{ keys = [[0.0, 0.1], [2.0, 0.9]] }` in place of a value.
//!
//! They are resolved in the tree of values, before anything asks what a key of a table means, so that all that a look says can be
//! keyed. The text keeps them as they are written.

use texgen::color_from_hex;

use super::value::{Field, Span, Spanned, Value};

/// The key of the list.
const KEYS: &str = "keys";
/// Keys that a look may have, all together.
const MOST: usize = 100_000;
const FORM: &str =
    "write pairs of a time in seconds and a value, as in { keys = [[0.0, 0.1], [2.0, 0.9]] }";

/// When values are wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum When {
    /// Seconds.
    At(f64),
    /// At the key of this number of each, or its last one: what is right at all keys is right between them, where it is a matter
    /// of ranges.
    Key(usize),
}

/// A keyed value, and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Keyed {
    /// Keys of the tables around it, and its own.
    pub(super) path: Vec<String>,
    pub(super) keys: Vec<(f64, Spanned<Value>)>,
}

/// What is wrong with keys, and where.
pub(super) type Problem = (Span, String);

/// The keyed values of a look's tables.
///
/// # Errors
/// All that make no sense.
pub(super) fn find(fields: &[Field]) -> Result<Vec<Keyed>, Vec<Problem>> {
    let (mut found, mut problems) = (Vec::new(), Vec::new());
    collect(fields, &mut Vec::new(), &mut found, &mut problems);
    let count: usize = found.iter().map(|keyed| keyed.keys.len()).sum();
    if count > MOST {
        problems.push((
            0..0,
            format!("a look may have {MOST} keys, this one has {count}"),
        ));
    }
    match problems.is_empty() {
        true => Ok(found),
        false => Err(problems),
    }
}

fn collect(
    fields: &[Field],
    path: &mut Vec<String>,
    found: &mut Vec<Keyed>,
    problems: &mut Vec<Problem>,
) {
    for Field { key, value } in fields {
        path.push(key.value.clone());
        match (list_of(&value.value), &value.value) {
            (Some(list), _) => match read(list, &value.span) {
                Ok(keys) => found.push(Keyed {
                    path: path.clone(),
                    keys,
                }),
                Err(problem) => problems.push(problem),
            },
            (None, Value::Table(fields)) => collect(fields, path, found, problems),
            (None, Value::List(items)) => {
                for item in items {
                    if let Value::Table(fields) = &item.value {
                        collect(fields, path, found, problems);
                    }
                }
            }
            _ => {}
        }
        path.pop();
    }
}

/// The fields with values in place of keys; those that make no sense stay as they are.
pub(super) fn resolve(fields: &mut [Field], when: When) {
    for Field { value, .. } in fields {
        resolve_value(value, when);
    }
}

fn resolve_value(value: &mut Spanned<Value>, when: When) {
    if let Some(list) = list_of(&value.value) {
        if let Ok(keys) = read(list, &value.span) {
            value.value = at(&keys, when);
        }
        return;
    }
    match &mut value.value {
        Value::Table(fields) => resolve(fields, when),
        Value::List(items) => items
            .iter_mut()
            .filter(|item| matches!(item.value, Value::Table(_)))
            .for_each(|item| resolve_value(item, when)),
        _ => {}
    }
}

/// The list of a value that is keyed.
fn list_of(value: &Value) -> Option<&[Spanned<Value>]> {
    match value {
        // A table may well have a table below it that is called so.
        Value::Table(fields) => match fields.as_slice() {
            [Field { key, value }] if key.value == KEYS => match &value.value {
                Value::List(list) => Some(list),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    }
}

fn read(list: &[Spanned<Value>], span: &Span) -> Result<Vec<(f64, Spanned<Value>)>, Problem> {
    let wrong = |span: &Span, message: &str| (span.clone(), message.to_owned());
    let mut keys: Vec<(f64, Spanned<Value>)> = Vec::with_capacity(list.len());
    for item in list {
        let pair = match &item.value {
            Value::List(pair) => pair.as_slice(),
            _ => &[],
        };
        let [time, value] = pair else {
            return Err(wrong(&item.span, FORM));
        };
        let time = (time.value.as_number().filter(|time| time.is_finite()))
            .ok_or_else(|| wrong(&time.span, "a time is a finite number of seconds"))?;
        if keys.last().is_some_and(|(before, _)| *before >= time) {
            return Err(wrong(
                &item.span,
                "each key must be later than the one before it",
            ));
        }
        if numbers(&value.value).is_none() {
            let message = "only numbers, lists of numbers and colours (\"#rrggbb\") have values in between: nothing else can be keyed";
            return Err(wrong(&value.span, message));
        }
        keys.push((time, value.clone()));
    }
    let shape = |value: &Value| numbers(value).map(|value| shape(&value));
    let mut others = keys.iter();
    let Some((_, first)) = others.next() else {
        return Err(wrong(span, FORM));
    };
    match others.find(|(_, value)| shape(&value.value) != shape(&first.value)) {
        Some((_, other)) => Err(wrong(&other.span, "all keys must have values of one form")),
        None => Ok(keys),
    }
}

/// The value at some time: linear between two keys, that of the first or the last one outside of them.
fn at(keys: &[(f64, Spanned<Value>)], when: When) -> Value {
    let last = keys.len() - 1;
    let seconds = match when {
        When::Key(number) => return keys[number.min(last)].1.value.clone(),
        When::At(seconds) => seconds,
    };
    let next = keys.partition_point(|(time, _)| *time <= seconds);
    if next == 0 {
        return keys[0].1.value.clone();
    }
    let (from, before) = &keys[next - 1];
    if next > last || *from == seconds {
        return before.value.clone();
    }
    let (to, after) = &keys[next];
    let share = (seconds - from) / (to - from);
    match (numbers(&before.value), numbers(&after.value)) {
        (Some(before), Some(after)) => mixed(&before, &after, share),
        // They were looked at when they were read.
        _ => before.value.clone(),
    }
}

/// A number, or lists of numbers; colours as linear ones.
fn numbers(value: &Value) -> Option<Value> {
    match value {
        Value::Integer(_) | Value::Float(_) => {
            let number = value.as_number().filter(|number| number.is_finite())?;
            Some(Value::Float(number))
        }
        Value::Text(text) => {
            let rgba = color_from_hex(text)?;
            // Without an alpha that nobody wrote.
            let written = if text.len() == 9 || text.len() == 5 {
                4
            } else {
                3
            };
            Some(Value::numbers(&rgba[..written]))
        }
        Value::List(items) => {
            let item = |item: &Spanned<Value>| {
                let is_number = matches!(
                    item.value,
                    Value::Integer(_) | Value::Float(_) | Value::List(_)
                );
                Some(item.with(numbers(&item.value).filter(|_| is_number)?))
            };
            items
                .iter()
                .map(item)
                .collect::<Option<_>>()
                .map(Value::List)
        }
        Value::Bool(_) | Value::Table(_) | Value::Date => None,
    }
}

/// How many numbers there are, and in which lists.
fn shape(value: &Value) -> Value {
    match value {
        Value::List(items) => Value::List(
            (items.iter())
                .map(|item| Spanned::new(shape(&item.value), 0..0))
                .collect(),
        ),
        _ => Value::Integer(0),
    }
}

fn mixed(from: &Value, to: &Value, share: f64) -> Value {
    match (from, to) {
        (Value::List(from), Value::List(to)) => {
            let pairs = from.iter().zip(to);
            let mixed = pairs.map(|(a, b)| a.with(mixed(&a.value, &b.value, share)));
            Value::List(mixed.collect())
        }
        _ => match (from.as_number(), to.as_number()) {
            (Some(from), Some(to)) => Value::Float(from + (to - from) * share),
            _ => from.clone(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::look::{Look, parse_value};
    use glam::Vec3;
    use std::path::Path;

    fn value(text: &str, when: When) -> Value {
        let mut value = parse_value(text).expect("it is TOML");
        resolve_value(&mut value, when);
        value.value
    }

    #[test]
    fn values_lie_between_keys_and_stay_outside_of_them() {
        let text = "{ keys = [[1, 0.5], [3.0, 1.5], [4, 0]] }";
        for (seconds, wanted) in [(0.0, 0.5), (1.0, 0.5), (2.0, 1.0), (3.5, 0.75), (9.0, 0.0)] {
            assert_eq!(
                value(text, When::At(seconds)).as_number(),
                Some(wanted),
                "{seconds}"
            );
        }
        assert_eq!(value(text, When::Key(1)).as_number(), Some(1.5));
        assert_eq!(value(text, When::Key(7)).as_number(), Some(0.0));
        let lists = value("{ keys = [[0, [0, 2]], [2, [4, 0]]] }", When::At(0.5));
        assert!(lists.is_same(&Value::numbers(&[1.0, 1.5])), "{lists:?}");
        // In linear light.
        let colours = value("{ keys = [[0, '#000'], [1, [0, 1, 0.5]]] }", When::At(0.5));
        assert!(
            colours.is_same(&Value::numbers(&[0.0, 0.5, 0.25])),
            "{colours:?}"
        );
        assert_eq!(
            value("{ keys = [[0, '#123']] }", When::At(3.0)),
            Value::Text("#123".to_owned())
        );
    }

    fn look(text: &str, seconds: f64) -> Result<Look, String> {
        Look::parse_at(Path::new("a.look.toml"), text, seconds)
            .map_err(|problems| problems.render())
    }

    #[test]
    fn every_table_of_a_look_can_be_keyed() {
        let text = "environment = { color = [1, 1, 1], intensity = { keys = [[0, 0], [1, 4]] } }\n\
            [camera]\nposition = { keys = [[0, [0, 0, 0]], [2, [2, 4, 6]]] }\n\
            [node.keys]\ntexture = 'fbm'\nscale = { keys = [[0, 1], [1, 2]] }\n\
            [material.keys]\nroughness.keys = [[0, 0.25], [1, 0.75]]\n\
            [[include]]\nfile = 'a.glb'\ntranslation = { keys = [[0, [0, 0, 0]], [1, [0, 0, 8]]] }";
        let at = |seconds| look(text, seconds).unwrap_or_else(|error| panic!("{error}"));
        let half = at(0.5);
        assert_eq!(
            half.camera.position.clone().expect("it is said").value,
            Vec3::new(0.5, 1.0, 1.5)
        );
        assert_eq!(half.nodes[0].params[0].value.value, Value::Float(1.5));
        assert_eq!(half.nodes[0].keyed.len(), 2);
        assert_eq!(
            half.materials[0].constant("roughness"),
            Some(Vec3::splat(0.5))
        );
        assert_eq!(half.includes[0].transform.translation.z, 4.0);
        assert_eq!(half.key_times, Some([0.0, 2.0]));
        assert_eq!(
            look("[camera]\ny_fov = 30", 1.0).expect("a look").key_times,
            None
        );
    }

    #[test]
    fn mistakes_are_found_at_every_key() {
        for (text, says) in [
            ("roughness = { keys = [[0, 0.5], [1, 2.5]] }", "from 0 to 1"),
            ("roughness = { keys = [] }", "pairs of a time"),
            ("roughness = { keys = [[0, 1, 2]] }", "pairs of a time"),
            ("roughness = { keys = [[1, 1], [1, 0]] }", "later than"),
            (
                "roughness = { keys = [[inf, 1]] }",
                "finite number of seconds",
            ),
            ("roughness = { keys = [[0, 1], [1, [1, 1]]] }", "one form"),
            (
                "roughness = { keys = [[0, 'mask']] }",
                "nothing else can be keyed",
            ),
            (
                "unlit = { keys = [[0, true]] }",
                "nothing else can be keyed",
            ),
            (
                "base_color = { keys = [[0, '#fff'], [1, [1, -1, 0]]] }",
                "negative",
            ),
        ] {
            let error = look(&format!("[material.A]\n{text}"), 0.0).expect_err(text);
            assert!(
                error.contains(says) && error.contains("a.look.toml:2"),
                "{text}: {error}"
            );
        }
    }
}
