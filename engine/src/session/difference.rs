//! What differs between two looks, table by table.

use std::collections::HashMap;

use crate::scene::look::{Field, Section, Span, Spanned, Value, find};

/// One table that is not what it was.
#[derive(Debug, Clone)]
pub(super) struct TableChange {
    pub(super) section: Section,
    /// Its keys before; `None` where it was missing.
    pub(super) before: Option<Vec<Field>>,
    /// Its keys now; `None` where it is gone.
    pub(super) after: Option<Vec<Field>>,
    /// Where it is written.
    pub(super) span: Span,
}

impl TableChange {
    /// The change back.
    pub(super) fn reversed(self) -> Self {
        Self {
            before: self.after,
            after: self.before,
            ..self
        }
    }
}

/// The tables that differ, nodes first, those that are gone last; `None` where the difference is not one of tables
/// that can be followed one by one.
pub(super) fn difference(before: &[Field], after: &[Field]) -> Option<Vec<TableChange>> {
    let is_same = |key| match (find(before, key), find(after, key)) {
        (None, None) => true,
        (Some(a), Some(b)) => a.value.is_same(&b.value),
        _ => false,
    };
    let names = |fields| -> Vec<&String> { tables(fields, "ao").map(|f| &f.key.value).collect() };
    // Includes, documents and lights are read with the scene. The place of an AO table among the others is part of what is
    // random about it.
    if !is_same("include")
        || !is_same("materialx")
        || !is_same("light")
        || names(before) != names(after)
    {
        return None;
    }
    let mut changes = Vec::new();
    type Named = fn(String) -> Section;
    let named: [(&str, Named); 4] = [
        ("ao", Section::Ao),
        ("node", Section::Node),
        ("material", Section::Material),
        ("graph", Section::Frame),
    ];
    let mut gone = Vec::new();
    for (key, section) in named {
        let (old_tables, new_tables) = (by_name(before, key), by_name(after, key));
        for Field { key: name, value } in tables(after, key) {
            let old = old_tables.get(name.value.as_str());
            if !old.is_some_and(|old| old.value.value.is_same(&value.value)) {
                changes.push(TableChange {
                    section: section(name.value.clone()),
                    before: old.and_then(|old| keys(&old.value)),
                    after: Some(keys(value)?),
                    span: name.span.clone(),
                });
            }
        }
        for Field { key: name, value } in tables(before, key) {
            if !new_tables.contains_key(name.value.as_str()) {
                gone.push(TableChange {
                    section: section(name.value.clone()),
                    before: keys(value),
                    after: None,
                    span: 0..0,
                });
            }
        }
    }
    for (key, section) in [
        ("environment", Section::Environment),
        ("camera", Section::Camera),
        ("view", Section::View),
    ] {
        if !is_same(key) {
            let now = find(after, key);
            changes.push(TableChange {
                section,
                before: find(before, key).and_then(keys),
                after: now.and_then(keys),
                span: now.map_or(0..0, |value| value.span.clone()),
            });
        }
    }
    // What is gone may be read until materials and links have changed; materials before nodes.
    changes.extend(gone.into_iter().rev());
    Some(changes)
}

fn tables<'f>(fields: &'f [Field], key: &str) -> impl Iterator<Item = &'f Field> + use<'f> {
    let table = match find(fields, key).map(|value| &value.value) {
        Some(Value::Table(tables)) => &tables[..],
        _ => &[],
    };
    table.iter()
}

fn by_name<'f>(fields: &'f [Field], key: &str) -> HashMap<&'f str, &'f Field> {
    tables(fields, key)
        .map(|f| (f.key.value.as_str(), f))
        .collect()
}

fn keys(value: &Spanned<Value>) -> Option<Vec<Field>> {
    match &value.value {
        Value::Table(fields) => Some(fields.clone()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::look::LookDocument;

    fn fields(text: &str) -> Vec<Field> {
        LookDocument::parse(Path::new("a.look.toml"), text)
            .expect("TOML")
            .fields()
    }

    fn sections(before: &str, after: &str) -> Option<Vec<String>> {
        let changes = difference(&fields(before), &fields(after))?;
        Some(changes.iter().map(|c| c.section.to_string()).collect())
    }

    #[test]
    fn only_tables_whose_meaning_changed_differ() {
        let before = "[node.a]\ntexture = 't'\nx = 1\n[node.b]\ntexture = 't'\n[material.M]\nroughness = 'b'\n[camera]\ny_fov = 30";
        let none: Option<Vec<String>> = Some(Vec::new());
        assert_eq!(sections(before, before), none);
        // Comments, order and the shape of a table mean nothing.
        let same = "camera = { y_fov = 30 } # wide\n[material.M]\nroughness = 'b'\n[node]\nb = { texture = 't' }\na = { x = 1, texture = 't' }";
        assert_eq!(sections(before, same), none);
        let after = before.replace("x = 1", "x = 2").replace("30", "40");
        let expected = ["[node.a]", "[camera]"].map(str::to_owned).to_vec();
        assert_eq!(sections(before, &after), Some(expected));
        let after = format!("{before}\n[view]\nexposure = 1");
        let expected = vec!["[view]".to_owned()];
        assert_eq!(sections(before, &after), Some(expected.clone()));
        assert_eq!(sections(&after, before), Some(expected));
        let after = format!("{before}\n[graph.F]\nnodes = ['a']");
        let expected = vec!["[graph.F]".to_owned()];
        assert_eq!(sections(before, &after), Some(expected.clone()));
        assert_eq!(sections(&after, before), Some(expected));
        let after = "[node.a]\ntexture = 't'\nx = 1\n[node.c]\ntexture = 't'\n[camera]\ny_fov = 30";
        let expected = ["[node.c]", "[material.M]", "[node.b]"].map(str::to_owned);
        assert_eq!(sections(before, after), Some(expected.to_vec()));
    }

    #[test]
    fn includes_lights_and_the_order_of_ao_tables_are_no_matter_of_tables() {
        assert!(sections("", "[light.Sun]\nangular_diameter = 1").is_none());
        assert!(sections("", "[[include]]\nfile = 'a.glb'").is_none());
        let (a, b) = ("[ao.a]\ndistance = 1\n", "[ao.b]\ndistance = 1\n");
        assert!(sections(&format!("{a}{b}"), &format!("{b}{a}")).is_none());
        assert_eq!(
            sections(a, "[ao.a]\ndistance = 2"),
            Some(vec!["[ao.a]".to_owned()])
        );
    }
}
