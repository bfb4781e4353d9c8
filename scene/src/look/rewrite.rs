//! Values that are written in place of others: what means the same stays as it was written.

use toml_edit::{Array, InlineTable, Value as Toml};

use super::reader::color;
use super::value::{Field, Spanned, Value, find, from_value, to_toml};

/// As toml_edit writes it, with what stood there before wherever that means the same: a text in its quotes, items of a list and keys of
/// a table that are no others, colours as they were called.
pub(super) fn to_toml_like(value: &Value, before: &Toml) -> Toml {
    match (value, before) {
        (Value::Text(text), Toml::String(before)) => {
            let written = before.as_repr().and_then(|repr| repr.as_raw().as_str());
            let is_literal =
                written.is_some_and(|text| text.starts_with('\'') && !text.starts_with("'''"));
            let literal = is_literal.then(|| format!("'{text}'").parse::<Toml>());
            match literal {
                Some(Ok(literal)) if literal.as_str() == Some(text) => literal,
                _ => to_toml(value),
            }
        }
        (Value::List(items), Toml::Array(before)) => Toml::Array(list_like(items, before)),
        (Value::Table(fields), Toml::InlineTable(before)) => {
            Toml::InlineTable(table_like(fields, before))
        }
        _ => to_toml(value),
    }
}

/// An item of a list or a table.
fn item_like(value: &Value, before: &Toml) -> Toml {
    match means_same(value, before) {
        true => before.clone(),
        false => {
            let mut written = to_toml_like(value, before);
            *written.decor_mut() = before.decor().clone();
            written
        }
    }
}

/// What comes before the first item that is another one, and after the last, stays.
fn list_like(items: &[Spanned<Value>], before: &Array) -> Array {
    let old: Vec<&Toml> = before.iter().collect();
    let is_same = |(item, old): (&Spanned<Value>, &&Toml)| means_same(&item.value, old);
    let shorter = items.len().min(old.len());
    let start = items.iter().zip(&old).take_while(|pair| is_same(*pair));
    let start = start.count();
    let end = (items.iter().rev().zip(old.iter().rev())).take_while(|pair| is_same(*pair));
    let end = end.count().min(shorter - start);
    let changed = &items[start..items.len() - end];
    let mut list = before.clone();
    for at in (start + changed.len()..old.len() - end).rev() {
        list.remove(at);
    }
    for (at, item) in (start..).zip(changed) {
        match old.get(at).filter(|_| at < old.len() - end) {
            Some(old) => {
                list.replace_formatted(at, item_like(&item.value, old));
            }
            None => {
                let mut new = to_toml(&item.value);
                // As its neighbour, on a line of its own or not.
                match at.checked_sub(1).and_then(|at| list.get(at)) {
                    Some(neighbour) if at > 1 => *new.decor_mut() = neighbour.decor().clone(),
                    _ => new.decor_mut().set_prefix(if at == 0 { "" } else { " " }),
                }
                list.insert_formatted(at, new);
            }
        }
    }
    list
}

fn table_like(fields: &[Field], before: &InlineTable) -> InlineTable {
    let mut table = before.clone();
    for (key, _) in before {
        if find(fields, key).is_none() {
            table.remove(key);
        }
    }
    for Field { key, value } in fields {
        match table.get_mut(&key.value) {
            Some(old) => *old = item_like(&value.value, old),
            None => {
                table.insert(&key.value, to_toml(&value.value));
            }
        }
    }
    table
}

/// Whether what was written means this, in single precision, in which looks are used.
fn means_same(value: &Value, written: &Toml) -> bool {
    let before = from_value(written, 0).value;
    let number = |value: &Value| value.as_number().map(|number| number as f32);
    match (value, &before) {
        (Value::List(items), Value::Text(_) | Value::Integer(_) | Value::Float(_)) => {
            is_color(items, &before)
        }
        (Value::List(items), Value::List(old)) if items.len() == 4 && old.len() == 3 => {
            is_color(items, &before)
        }
        (Value::List(items), Value::List(_)) => {
            let old = written.as_array().into_iter().flatten();
            let same = |(item, old): (&Spanned<Value>, &Toml)| means_same(&item.value, old);
            let count = written.as_array().map_or(0, Array::len);
            items.len() == count && items.iter().zip(old).all(same)
        }
        _ => match (number(value), number(&before)) {
            (Some(a), Some(b)) => a == b,
            _ => value.is_same(&before),
        },
    }
}

/// Whether components are those of a colour that was written in fewer words: by its name, as a grey, without opacity.
fn is_color(items: &[Spanned<Value>], written: &Value) -> bool {
    let rgb = match written.as_number() {
        Some(grey) => [grey as f32; 3],
        None => match color(written) {
            Ok(rgb) => rgb.to_array(),
            Err(_) => return false,
        },
    };
    let wanted = rgb.into_iter().chain([1.0]);
    let number = |item: &Spanned<Value>| item.value.as_number().map(|number| number as f32);
    let is_same = |(item, x): (&Spanned<Value>, f32)| number(item) == Some(x);
    (3..=4).contains(&items.len()) && items.iter().zip(wanted).all(is_same)
}

#[cfg(test)]
mod tests {
    use super::super::value::parse_value;
    use super::*;

    fn rewritten(before: &str, value: &str) -> String {
        let before: Toml = before.parse().expect("a value");
        let value = parse_value(value).expect("a value");
        to_toml_like(&value.value, &before).to_string()
    }

    /// Of `#180d09`, as an editor of ramps gives it back.
    fn dark() -> String {
        let rgb = color(&Value::Text("#180d09".to_owned())).expect("a colour");
        format!("[{:?}, {:?}, {:?}, 1.0]", rgb.x, rgb.y, rgb.z)
    }

    #[test]
    fn stops_that_are_no_others_stay_as_they_are_written() {
        let before = "[[0, \"#180d09\"], # soot\n  [0.5, 0.25],\n  [1, [1, 0.5, 0]]]";
        let stops = |at: &str, last: &str| {
            format!(
                "[[0.0, {}], [{at}, [0.25, 0.25, 0.25, 1.0]], [1.0, {last}]]",
                dark()
            )
        };
        let orange = "[1.0, 0.5, 0.0, 1.0]";
        assert_eq!(rewritten(before, &stops("0.5", orange)), before);
        assert_eq!(
            rewritten(before, &stops("0.6", orange)),
            before.replace("0.5, 0.25", "0.6, 0.25")
        );
        let red = rewritten(before, &stops("0.5", "[1.0, 0.0, 0.0, 1.0]"));
        assert!(red.starts_with("[[0, \"#180d09\"], # soot\n  [0.5, 0.25],\n  [1, [1"));
        assert!(red.contains("[1, 0.0, 0, 1.0]"), "{red}");
        let fewer = format!("[[0.0, {}], [1.0, {orange}]]", dark());
        let expected = "[[0, \"#180d09\"],\n  [1, [1, 0.5, 0]]]";
        let bare = |text: &str| text.replace([' ', '\n'], "").replace("#soot", "");
        assert_eq!(bare(&rewritten(before, &fewer)), bare(expected));
        let more = format!(
            "[[0.0, {}], [0.2, {orange}], [0.5, [0.25, 0.25, 0.25, 1.0]], [1.0, {orange}]]",
            dark()
        );
        let more = rewritten(before, &more);
        assert!(more.contains("[0.5, 0.25]") && more.contains("[0.2, [1.0, 0.5, 0.0, 1.0]]"));
    }

    #[test]
    fn keys_and_texts_that_are_no_others_stay_as_they_are_written() {
        let before = "{ interpolation = 'smooth', stops = [[0, 0], [1, '#fff']] }";
        let after = "{ interpolation = \"smooth\", stops = [[0.0, [0.0, 0.0, 0.0, 1.0]], [0.5, [1.0, 1.0, 1.0, 1.0]]] }";
        assert_eq!(
            rewritten(before, after),
            before.replace("[1, '#fff'", "[0.5, '#fff'")
        );
        assert_eq!(rewritten("'a'", "\"b\""), "'b'");
        assert_eq!(rewritten("[1, 2]", "[1.0, 3.0]"), "[1, 3.0]");
        assert_eq!(rewritten("4", "4.0"), "4.0");
    }
}
