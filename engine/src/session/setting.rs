//! Edits as one writes them in a line: `node.strength=0.5`, `material.Steel.roughness=0.2`.

use std::path::Path;

use crate::procedural::Procedural;
use crate::procedural::written::written;
use crate::scene::look::{LookDocument, Section, Value};

use super::edit::{Edit, summary};

/// What a look calls its tables, where they have names.
const NAMED: [&str; 4] = ["node", "material", "ao", "light"];

impl Edit {
    /// Sets a key: `NODE.PARAMETER=VALUE`, `material.NAME.KEY=VALUE`, and so with `node`, `ao` and `light`; `environment.KEY=VALUE`,
    /// `camera.KEY=VALUE`, `view.KEY=VALUE`. Names may have dots. The value is as in a look, as [`Procedural::set_written`]
    /// has it: text needs no quotes, a list of numbers no brackets.
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
        Ok(Self::set(section, &key, written(value.trim()).value))
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
        for text in ["[.2,.5,1]", "[ .2, +.5, 1., ]", ".2,.5,1", "[[.2],[.5,1]]"] {
            assert_eq!(numbers(text), [0.2, 0.5, 1.0], "{text}");
        }
        assert_eq!(numbers("[.2,,1]"), [0.0; 0]);
        for code in ["007", "-007", "+00.5", "[.2", "[,]"] {
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
