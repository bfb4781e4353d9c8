//! Edits as one writes them in a line: `node.strength=0.5`, `material.Steel.roughness=0.2`.

use std::path::Path;

use crate::procedural::Procedural;
use crate::scene::look::{LookDocument, Section, Spanned, Value};

use super::edit::{Edit, summary};

/// What a look calls its tables, where they have names.
const NAMED: [&str; 4] = ["node", "material", "ao", "light"];

impl Edit {
    /// Sets a key: `NODE.PARAMETER=VALUE`, `material.NAME.KEY=VALUE`, and so with `node`, `ao` and `light`; `environment.KEY=VALUE`,
    /// `camera.KEY=VALUE`, `view.KEY=VALUE`. Names may have dots. The value is as in a look; text needs no quotes.
    ///
    /// # Errors
    /// It has another form: says how it is written.
    pub fn parse(text: &str) -> Result<Self, String> {
        let form = "write NODE.PARAMETER=VALUE, material.NAME.KEY=VALUE, environment.KEY=VALUE, camera.KEY=VALUE or view.KEY=VALUE";
        let (place, value) = text.split_once('=').ok_or(form)?;
        let (table, rest) = place.trim().split_once('.').ok_or(form)?;
        let named = |rest: &str| {
            let (name, mut key) = rest.rsplit_once('.')?;
            let mut name = name;
            // `blend.mask` is a key of two words.
            if let Some((before, "blend")) = name.rsplit_once('.') {
                (name, key) = (before, &rest[before.len() + 1..]);
            }
            Some((name.to_owned(), key.to_owned()))
        };
        let (section, key) = match table {
            "environment" => (Section::Environment, rest.to_owned()),
            "camera" => (Section::Camera, rest.to_owned()),
            "view" => (Section::View, rest.to_owned()),
            table if NAMED.contains(&table) => {
                let (name, key) = named(rest).ok_or(form)?;
                let section = match table {
                    "node" => Section::Node(name),
                    "material" => Section::Material(name),
                    "ao" => Section::Ao(name),
                    _ => Section::Light(name),
                };
                (section, key)
            }
            _ => {
                let (node, key) =
                    named(place.trim()).unwrap_or((table.to_owned(), rest.to_owned()));
                (Section::Node(node), key)
            }
        };
        if key.is_empty() || matches!(section.place().1, Some("")) {
            return Err(form.to_owned());
        }
        Ok(Self::set(section, &key, value_of(value.trim())))
    }

    /// What is wrong with it where it sets a parameter of a node to a number outside of the range that its texture declares. A window's
    /// slider couldn't set it either.
    pub fn out_of_range(&self, procedural: &Procedural) -> Option<String> {
        let Self::Set {
            section: Section::Node(name),
            key,
            value,
        } = self
        else {
            return None;
        };
        let graph = procedural.graph();
        let node = graph.ids().find(|&id| graph.name(id) == name)?;
        let parameter = graph
            .texture(node)
            .parameters()
            .iter()
            .find(|p| p.name == *key)?;
        let (low, high) = parameter.range?;
        let mut numbers = Vec::new();
        numbers_in(value, &mut numbers);
        let outside = numbers
            .into_iter()
            .find(|x| !(f64::from(low)..=f64::from(high)).contains(x))?;
        Some(format!(
            "{name}.{key}: {outside} is outside of {low} to {high}, which the texture `{}` declares",
            graph.texture(node).name()
        ))
    }
}

/// A value as in a look; what is no value of TOML is a number that others would write so, as `.5`, a list with such, or a text, as `007`
/// is.
fn value_of(text: &str) -> Value {
    let bare = || match text.parse::<f64>() {
        Ok(number) if number.is_finite() && !is_padded(text) => Value::Float(number),
        _ => list_of(text).unwrap_or_else(|| Value::Text(text.to_owned())),
    };
    let line = format!("[camera]\nvalue = {text}\n");
    let Ok(document) = LookDocument::parse(Path::new(""), &line) else {
        return bare();
    };
    let mut fields = document.table(&Section::Camera).unwrap_or_default();
    match (fields.pop(), fields.is_empty()) {
        (Some(field), true) => field.value.value,
        _ => bare(),
    }
}

/// Whether digits stand behind a zero, as in codes: `007`, `-007`.
fn is_padded(text: &str) -> bool {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    let behind = digits.strip_prefix('0');
    behind.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
}

/// A list of values each of which is told for itself; `None` for other texts, and where commas may be part of a value.
fn list_of(text: &str) -> Option<Value> {
    let inside = text.strip_prefix('[')?.strip_suffix(']')?.trim();
    if inside.contains(['[', ']', '{', '}', '"', '\'', '\n']) {
        return None;
    }
    let inside = inside.strip_suffix(',').unwrap_or(inside);
    let items = inside.split(',').map(str::trim);
    let items = items.map(|item| (!item.is_empty()).then(|| Spanned::new(value_of(item), 0..0)));
    items.collect::<Option<Vec<_>>>().map(Value::List)
}

fn numbers_in(value: &Value, found: &mut Vec<f64>) {
    match value {
        Value::Integer(x) => found.push(*x as f64),
        Value::Float(x) => found.push(*x),
        Value::List(items) => items.iter().for_each(|item| numbers_in(&item.value, found)),
        _ => {}
    }
}

/// A look's text with edits.
pub(super) fn edited(path: &Path, text: &str, edits: &[Edit]) -> Result<String, String> {
    if edits.is_empty() {
        return Ok(text.to_owned());
    }
    let mut document = LookDocument::parse(path, text).map_err(|problems| summary(&problems))?;
    for edit in edits {
        edit.write(&mut document)?;
    }
    Ok(document.text())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_sets_a_key() {
        let parsed = |text: &str| Edit::parse(text).expect("well-formed");
        let node = Section::Node("rust".to_owned());
        assert_eq!(
            parsed("rust.scale=2"),
            Edit::set(node.clone(), "scale", Value::Integer(2))
        );
        assert_eq!(
            parsed("node.rust.scale = 2.5"),
            Edit::set(node.clone(), "scale", Value::Float(2.5))
        );
        let link = Value::Text("mask.x".to_owned());
        assert_eq!(
            parsed("rust.amount=mask.x"),
            Edit::set(node.clone(), "amount", link)
        );
        let quoted = Value::Text("a b".to_owned());
        assert_eq!(
            parsed("rust.image=\"a b\""),
            Edit::set(node, "image", quoted)
        );
        let material = Section::Material("Steel v1.2".to_owned());
        let edit = parsed("material.Steel v1.2.roughness=0.25");
        assert_eq!(
            edit,
            Edit::set(material.clone(), "roughness", Value::Float(0.25))
        );
        let edit = parsed("material.Steel v1.2.blend.mask=mask");
        assert_eq!(
            edit,
            Edit::set(material, "blend.mask", Value::Text("mask".to_owned()))
        );
        let Edit::Set { section, value, .. } = parsed("environment.color=[1, 0.5, 0]") else {
            panic!("it sets a key");
        };
        assert_eq!(section, Section::Environment);
        assert!(matches!(value, Value::List(items) if items.len() == 3));
        for (text, number) in [(".2", 0.2), ("+.5", 0.5), ("-.25", -0.25), ("3.", 3.0)] {
            let edit = parsed(&format!("view.exposure={text}"));
            assert_eq!(
                edit,
                Edit::set(Section::View, "exposure", Value::Float(number))
            );
        }
        let numbers = |text: &str| {
            let Edit::Set { value, .. } = parsed(&format!("environment.color={text}")) else {
                panic!("it sets a key");
            };
            let mut numbers = Vec::new();
            numbers_in(&value, &mut numbers);
            numbers
        };
        for text in ["[.2,.5,1]", "[ .2, +.5, 1., ]"] {
            assert_eq!(numbers(text), [0.2, 0.5, 1.0], "{text}");
        }
        assert_eq!(numbers("[.2,,1]"), [0.0; 0]);
        for code in ["007", "-007", "+00.5", "[.2", "[[.2]]", "[,]"] {
            let edit = parsed(&format!("camera.name={code}"));
            assert_eq!(edit, Edit::camera("name", Value::Text(code.to_owned())));
        }
        // More than a value is a text.
        let text = parsed("camera.name=1\nz=2");
        assert_eq!(text, Edit::camera("name", Value::Text("1\nz=2".to_owned())));
    }

    #[test]
    fn other_forms_are_refused() {
        for text in [
            "",
            "=",
            "rust",
            "rust=1",
            "rust.=1",
            "material.Steel=1",
            ".x=1",
            "node..x=1",
        ] {
            let error = Edit::parse(text).expect_err(text);
            assert!(error.contains("NODE.PARAMETER"), "{text}: {error}");
        }
    }
}
