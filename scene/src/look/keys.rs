//! Values that change with time: `{ keys = [[0.0, 0.1], [2.0, 0.9]] }` in place of a value.
//!
//! They are resolved in the tree of values, before anything asks what a key of a table means, so that all that a look says can be
//! keyed. The text keeps them as they are written.

use texgen::color_from_hex;

use super::reader::Reader;
use super::value::{Field, Span, Spanned, Value};

/// The key of the list.
const KEYS: &str = "keys";
/// Keys that a look may have, all together.
const MOST: usize = 100_000;
/// Values that may have to be read, of tables with keys once for each key.
const MOST_READ: usize = 4_000_000;
/// Where a look's tables have names.
const NAMED: [&str; 5] = ["node", "material", "light", "ao", "graph"];
const FORM: &str =
    "write pairs of a time in seconds and a value, as in { keys = [[0.0, 0.1], [2.0, 0.9]] }";

/// What is wrong with keys, and where.
pub(super) type Problem = (Span, String);

/// The times of all keys of a look's tables, seconds, as they are written; none where some make no sense, which the reader is told.
pub(super) fn find(fields: &[Field], reader: &mut Reader) -> Option<Vec<f64>> {
    let mut times = Vec::new();
    for field in fields {
        collect(&field.value, &mut times, reader);
    }
    if times.len() > MOST {
        let count = times.len();
        reader.problem(
            &(0..0),
            format!("a look may have {MOST} keys, this one has {count}"),
        );
    }
    reader.problems.is_empty().then_some(times)
}

fn collect(value: &Spanned<Value>, times: &mut Vec<f64>, reader: &mut Reader) {
    if let Some(list) = list_of(&value.value) {
        match read(list, &value.span) {
            Ok(keys) => times.extend(keys.iter().map(|(time, _)| time)),
            Err((span, message)) => reader.problem(&span, message),
        }
        return;
    }
    match &value.value {
        Value::Table(fields) => {
            (fields.iter()).for_each(|field| collect(&field.value, times, reader));
        }
        Value::List(items) => items.iter().for_each(|item| collect(item, times, reader)),
        _ => {}
    }
}

/// The values of a parameter at each of its keys, as fields of their own; none where it has no keys.
pub(super) fn values(parameter: &Field) -> Vec<Field> {
    let Field { key, value } = parameter;
    let field = |value: Spanned<Value>| Field {
        key: value.with(key.value.clone()),
        value,
    };
    match list_of(&value.value) {
        // Each where it is written.
        Some(list) => (read(list, &value.span).into_iter().flatten())
            .map(|(_, value)| field(value))
            .collect(),
        None => (times_of(&value.value).into_iter())
            .map(|time| field(steady(value, time)))
            .collect(),
    }
}

/// The fields with the values of a time in place of keys, seconds; those that make no sense stay as they are.
pub(super) fn resolve(fields: &mut [Field], seconds: f64) {
    for Field { value, .. } in fields {
        resolve_value(value, seconds);
    }
}

impl Value {
    /// Whether it, or something in it, changes with time.
    pub fn has_keys(&self) -> bool {
        match (list_of(self), self) {
            (Some(_), _) => true,
            (None, Self::Table(fields)) => fields.iter().any(|f| f.value.value.has_keys()),
            (None, Self::List(items)) => items.iter().any(|item| item.value.has_keys()),
            _ => false,
        }
    }

    /// As it is after so many seconds; keys that make no sense stay as they are.
    pub fn at(&self, seconds: f64) -> Self {
        let mut value = Spanned::new(self.clone(), 0..0);
        resolve_value(&mut value, seconds);
        value.value
    }
}

fn resolve_value(value: &mut Spanned<Value>, seconds: f64) {
    if let Some(list) = list_of(&value.value) {
        if read(list, &value.span).is_ok()
            && let Some(now) = at(list, seconds, false)
        {
            value.value = now;
        }
        return;
    }
    match &mut value.value {
        Value::Table(fields) => resolve(fields, seconds),
        Value::List(items) => {
            (items.iter_mut()).for_each(|item| resolve_value(item, seconds));
        }
        _ => {}
    }
}

/// A table of a look with keyed values.
pub(super) struct Part<'f> {
    key: &'f Spanned<String>,
    /// What of the key's value it is, where that has others beside it.
    whole: &'f Spanned<Value>,
    own: Own<'f>,
    /// Of all its keys, seconds, in order.
    pub(super) times: Vec<f64>,
}

enum Own<'f> {
    Whole,
    Named(&'f Field),
    Item(&'f Spanned<Value>),
}

/// The tables that have keyed values. What they say is right at all times where it is at those of their keys, as far as it is a matter of
/// ranges.
///
/// # Errors
/// There are so many keys, and so much beside them, that reading all would take too long.
pub(super) fn parts(fields: &[Field]) -> Result<Vec<Part<'_>>, Problem> {
    let (mut parts, mut read) = (Vec::new(), 0_usize);
    for Field { key, value } in fields {
        let found: Vec<_> = match &value.value {
            Value::Table(named) if NAMED.contains(&key.value.as_str()) => (named.iter())
                .map(|field| (Own::Named(field), &field.value))
                .collect(),
            Value::List(items) => items.iter().map(|item| (Own::Item(item), item)).collect(),
            _ => vec![(Own::Whole, value)],
        };
        for (own, of) in found {
            let times = times_of(&of.value);
            if !times.is_empty() {
                read = (times.len().saturating_mul(size(&of.value))).saturating_add(read);
                parts.push(Part {
                    key,
                    whole: value,
                    own,
                    times,
                });
            }
        }
    }
    match read > MOST_READ {
        true => Err((
            0..0,
            format!(
                "tables with keys may have {MOST_READ} values, at all keys together, these have {read}"
            ),
        )),
        false => Ok(parts),
    }
}

impl Part<'_> {
    /// As it is at a time, seconds. Where whole numbers would be none between their keys, as they are at the key before: it may be that
    /// nobody looks at that moment.
    pub(super) fn at(&self, seconds: f64) -> Field {
        let value = match self.own {
            Own::Whole => steady(self.whole, seconds),
            Own::Named(Field { key, value }) => self.whole.with(Value::Table(vec![Field {
                key: key.clone(),
                value: steady(value, seconds),
            }])),
            Own::Item(item) => self.whole.with(Value::List(vec![steady(item, seconds)])),
        };
        Field {
            key: self.key.clone(),
            value,
        }
    }
}

fn steady(value: &Spanned<Value>, seconds: f64) -> Spanned<Value> {
    if let Some(list) = list_of(&value.value) {
        return value.with(at(list, seconds, true).unwrap_or_else(|| value.value.clone()));
    }
    match &value.value {
        Value::Table(fields) => {
            let field = |Field { key, value }: &Field| Field {
                key: key.clone(),
                value: steady(value, seconds),
            };
            value.with(Value::Table(fields.iter().map(field).collect()))
        }
        Value::List(items) => {
            let item = |item: &Spanned<Value>| steady(item, seconds);
            value.with(Value::List(items.iter().map(item).collect()))
        }
        _ => value.clone(),
    }
}

/// The times of all keys in it, in order.
fn times_of(value: &Value) -> Vec<f64> {
    let mut times = Vec::new();
    add_times(value, &mut times);
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

fn add_times(value: &Value, times: &mut Vec<f64>) {
    if let Some(list) = list_of(value) {
        times.extend(list.iter().filter_map(|item| Some(pair(item)?.0)));
        return;
    }
    match value {
        Value::Table(fields) => {
            (fields.iter()).for_each(|field| add_times(&field.value.value, times));
        }
        Value::List(items) => items.iter().for_each(|item| add_times(&item.value, times)),
        _ => {}
    }
}

/// How many values there are where each keyed one has one of its keys.
fn size(value: &Value) -> usize {
    match (list_of(value), value) {
        (Some(list), _) => list.first().map_or(1, |pair| size(&pair.value)),
        (None, Value::Table(fields)) => {
            1 + fields.iter().map(|f| size(&f.value.value)).sum::<usize>()
        }
        (None, Value::List(items)) => 1 + items.iter().map(|i| size(&i.value)).sum::<usize>(),
        _ => 1,
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

/// A key: its time, and its value.
fn pair(item: &Spanned<Value>) -> Option<(f64, &Value)> {
    match &item.value {
        Value::List(pair) => match pair.as_slice() {
            [time, value] => Some((time.value.as_number()?, &value.value)),
            _ => None,
        },
        _ => None,
    }
}

/// The value at some time: linear between two keys, that of the first or the last one outside of them. A value of whole numbers that is
/// none then is as at the key before, where it `stays`. None for keys that make no sense.
fn at(list: &[Spanned<Value>], seconds: f64, stays: bool) -> Option<Value> {
    let next = list.partition_point(|item| pair(item).is_some_and(|(time, _)| time <= seconds));
    let key = |number: usize| pair(list.get(number)?);
    if next == 0 {
        return Some(key(0)?.1.clone());
    }
    let (from, before) = key(next - 1)?;
    let Some((to, after)) = key(next).filter(|_| from < seconds) else {
        return Some(before.clone());
    };
    let share = (seconds - from) / (to - from);
    let (first, last) = (numbers(before)?, numbers(after)?);
    let mixed = mixed(&first, &last, share);
    Some(match stays && is_whole(&first) && !is_whole(&mixed) {
        true => before.clone(),
        false => mixed,
    })
}

fn is_whole(value: &Value) -> bool {
    match value {
        Value::List(items) => items.iter().all(|item| is_whole(&item.value)),
        value => matches!(value, Value::Integer(_)),
    }
}

/// A number, or lists of numbers; colours as linear ones.
fn numbers(value: &Value) -> Option<Value> {
    match value {
        Value::Integer(_) => Some(value.clone()),
        Value::Float(number) => number.is_finite().then(|| value.clone()),
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
            (Some(a), Some(b)) => {
                let between = a + (b - a) * share;
                // Whole numbers stay such where they are.
                match is_whole(from) && is_whole(to) && between.fract() == 0.0 {
                    true => Value::Integer(between as i64),
                    false => Value::Float(between),
                }
            }
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

    fn value(text: &str, seconds: f64) -> Value {
        let mut value = parse_value(text).expect("it is TOML");
        resolve_value(&mut value, seconds);
        value.value
    }

    #[test]
    fn values_lie_between_keys_and_stay_outside_of_them() {
        let text = "{ keys = [[1, 0.5], [3.0, 1.5], [4, 0]] }";
        for (seconds, wanted) in [(0.0, 0.5), (1.0, 0.5), (2.0, 1.0), (3.5, 0.75), (9.0, 0.0)] {
            assert_eq!(value(text, seconds).as_number(), Some(wanted), "{seconds}");
        }
        // Whole where whole numbers are so, and as before where they would be none.
        let whole = "{ keys = [[0, 3], [2, 3], [4, 5]] }";
        assert_eq!(value(whole, 1.0), Value::Integer(3));
        assert_eq!(value(whole, 3.0), Value::Integer(4));
        assert_eq!(value(whole, 3.5), Value::Float(4.5));
        let keyed = parse_value(whole).expect("it is TOML");
        assert_eq!(steady(&keyed, 3.5).value, Value::Integer(3));
        assert!(keyed.value.has_keys() && !keyed.value.at(1.0).has_keys());
        assert_eq!(keyed.value.at(1.0), Value::Integer(3));
        let partly = parse_value("[0, { keys = [[0, 1.0]] }]").expect("it is TOML");
        assert!(partly.value.has_keys());
        let lists = value("{ keys = [[0, [0, 2]], [2, [4, 0]]] }", 0.5);
        let wanted = parse_value("[1, 1.5]").expect("it is TOML").value;
        assert!(lists.is_same(&wanted), "{lists:?}");
        // In linear light.
        let colours = value("{ keys = [[0, '#000'], [1, [0, 1, 0.5]]] }", 0.5);
        assert!(
            colours.is_same(&Value::numbers(&[0.0, 0.5, 0.25])),
            "{colours:?}"
        );
        assert_eq!(
            value("{ keys = [[0, '#123']] }", 3.0),
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
    fn numbers_within_lists_can_be_keyed() {
        let text = "[material.A]\nbase_color = [{ keys = [[0, 0.0], [1, 1.0]] }, 0.25, 0]\n\
            [camera]\nposition = [0, 0, { keys = [[0, 3.0], [2, 6.0]] }]\n\
            [node.A]\ntexture = 'rust_color'\n\
            ramp = [[0.0, { keys = [[0, '#000'], [1, '#fff']] }], [{ keys = [[0, 0.5], [1, 1.0]] }, '#fff']]";
        let half = look(text, 0.5).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(
            half.materials[0].constant("base_color"),
            Some(Vec3::new(0.5, 0.25, 0.0))
        );
        let position = half.camera.position.clone().expect("it is said");
        assert_eq!(position.value, Vec3::new(0.0, 0.0, 3.75));
        assert_eq!(half.key_times, Some([0.0, 2.0]));
        let ramp = parse_value("[[0.0, [0.5, 0.5, 0.5]], [0.75, '#fff']]").expect("it is TOML");
        assert!(half.nodes[0].params[0].value.value.is_same(&ramp.value));
        // The whole ramp at each of its keys.
        let keyed = &half.nodes[0].keyed;
        let last = parse_value("[[0.0, '#fff'], [1.0, '#fff']]").expect("it is TOML");
        assert_eq!(keyed.len(), 2);
        assert!(keyed[1].value.value.is_same(&last.value), "{:?}", keyed[1]);
        for (text, says) in [
            (
                "base_color = [{ keys = [[0, 'x']] }, 0, 0]",
                "nothing else can be keyed",
            ),
            (
                "base_color = [{ keys = [[0, 0.5], [1, -1]] }, 0, 0]",
                "negative",
            ),
        ] {
            let error = look(&format!("[material.A]\n{text}"), 0.0).expect_err(text);
            assert!(error.contains(says), "{text}: {error}");
        }
    }

    /// Each key is read once, whatever else there is.
    #[test]
    fn many_keys_are_read_in_no_time() {
        let keys = |count: usize| {
            let list: Vec<String> = (0..count).map(|i| format!("[{i},30]")).collect();
            format!("{{ keys = [{}] }}", list.join(","))
        };
        let read = look(&format!("[camera]\ny_fov = {}", keys(MOST)), 0.5);
        assert_eq!(
            read.expect("it is right").key_times,
            Some([0.0, (MOST - 1) as f64])
        );
        let beside: String = (0..1000).map(|i| format!("a{i} = {i}\n")).collect();
        let text = format!(
            "[node.A]\ntexture = 'fbm'\nscale = {}\n{beside}",
            keys(5000)
        );
        let error = look(&text, 0.5).expect_err("too many");
        assert!(error.contains("at all keys together"), "{error}");
        // What other tables have is read once.
        let others = text.replace(&beside, &format!("[node.B]\ntexture = 'fbm'\n{beside}"));
        look(&others, 0.5).expect("few values beside the keys");
    }

    #[test]
    fn what_belongs_together_is_looked_at_at_the_same_time() {
        let text = "[light.A]\ntype = 'spot'\nposition = [0, 0, 0]\n\
            inner_cone_angle = { keys = [[0, 10], [1, 80]] }\n\
            outer_cone_angle = { keys = [[0, 20], [0.5, 50], [1, 90]] }";
        look(text, 0.0).unwrap_or_else(|error| panic!("{error}"));
        look(&text.replace("50]", "40]"), 0.0).expect_err("half way they cross");
        // Whole numbers only have to be so at moments that are looked at.
        let text = "[camera]\nblades = { keys = [[0, 5], [2, 7]] }\n\
            focus_distance = { keys = [[0, 1], [0.5, 2], [2, 3]] }\naperture_radius = 0.1";
        look(text, 1.0).unwrap_or_else(|error| panic!("{error}"));
        look(text, 0.5).expect_err("five and a half blades");
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
