//! Two looks that were made from the same one, brought together: what one side has changed is changed, key by key of each table.
//! What both sides have changed is named, so that somebody can be asked.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use texgen::Diagnostics;

use crate::scene::look::{Field, Look, LookDocument, Section, Value, find};

use super::edit::summary;

type Named = fn(String) -> Section;

/// Where a look's tables have names.
const NAMED: [(&str, Named); 5] = [
    ("light", Section::Light),
    ("ao", Section::Ao),
    ("node", Section::Node),
    ("material", Section::Material),
    ("graph", Section::Frame),
];

/// Two looks in one. Where both sides together would be no look, it is one of them as a whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Merged {
    /// With the own value where both sides have changed one.
    pub text: String,
    /// With the other side's value there.
    pub theirs_first: String,
    /// What both sides have changed, each to something else: `[node.rust] scale`.
    pub conflicts: Vec<String>,
}

/// Whose value counts where both have changed it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum First {
    Mine,
    Theirs,
}

/// What was made of `base` here and elsewhere, as one text: that of elsewhere, comments and order included, with what was
/// changed here. All three lie at `path`.
///
/// # Errors
/// One of them is no look.
pub fn merge(path: &Path, base: &str, mine: &str, theirs: &str) -> Result<Merged, Diagnostics> {
    if mine == theirs || base == mine {
        return Ok(Merged::of(theirs));
    }
    if base == theirs {
        return Ok(Merged::of(mine));
    }
    let fields = |text| LookDocument::parse(path, text).map(|document| document.fields());
    let (old, own) = (fields(base)?, fields(mine)?);
    let document = LookDocument::parse(path, theirs)?;
    let brought = |first| {
        let mut into = document.clone();
        let conflicts = bring(&old, &own, &mut into, first);
        (into.text(), conflicts)
    };
    let (theirs_first, _) = brought(First::Theirs);
    let (text, mut conflicts) = brought(First::Mine);
    // Each for itself is a look.
    let mut checked = |both: String, whose: &str, alone: &str| match Look::parse(path, &both) {
        Ok(_) => both,
        Err(problems) => {
            conflicts.push(format!(
                "{whose} as a whole, since both together would be no look: {}",
                summary(&problems)
            ));
            alone.to_owned()
        }
    };
    let text = checked(text, "mine", mine);
    let theirs_first = checked(theirs_first, "the file's", theirs);
    Ok(Merged {
        text,
        theirs_first,
        conflicts,
    })
}

impl Merged {
    fn of(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            theirs_first: text.to_owned(),
            conflicts: Vec::new(),
        }
    }
}

/// Changes `theirs` as `base` was changed to `mine`: what both have changed.
fn bring(base: &[Field], mine: &[Field], theirs: &mut LookDocument, first: First) -> Vec<String> {
    let mut conflicts = Vec::new();
    let (of_base, of_mine) = (Tables::of(base), Tables::of(mine));
    for section in sections(base, mine) {
        let (old, new) = (of_base.get(&section), of_mine.get(&section));
        if is_same_table(old, new) {
            continue;
        }
        let now = theirs.table(&section);
        if is_same_table(new, now.as_deref()) {
            continue;
        }
        // A whole table that is gone here, or gone there.
        let (is_gone, was_gone) = (new.is_none(), now.is_none() && old.is_some());
        if is_gone || was_gone {
            let is_conflict = !is_same_table(old, now.as_deref());
            if is_conflict {
                conflicts.push(section.to_string());
            }
            if is_gone && (!is_conflict || first == First::Mine) {
                theirs.remove_table(&section);
            }
            if is_gone || first == First::Theirs {
                continue;
            }
        }
        let now = now.unwrap_or_default();
        let keys = bring_keys(
            if was_gone {
                &[]
            } else {
                old.unwrap_or_default()
            },
            new.unwrap_or_default(),
            (&now, theirs),
            &section,
            first,
        );
        conflicts.extend(keys);
    }
    // Edits don't reach these, but a former text may have others.
    for key in ["include", "materialx"] {
        let list = |fields| find(fields, key).map(|value| value.value.clone());
        if !is_same_value(&list(base), &list(mine)) {
            conflicts.push(format!("[[{key}]]"));
        }
    }
    conflicts
}

/// The same for the keys of one table.
fn bring_keys(
    old: &[Field],
    new: &[Field],
    (now, theirs): (&[Field], &mut LookDocument),
    section: &Section,
    first: First,
) -> Vec<String> {
    let value = |fields, key: &str| find(fields, key).map(|value| value.value.clone());
    let mut conflicts = Vec::new();
    let mut seen = HashSet::new();
    for Field { key, .. } in old.iter().chain(new) {
        let key = key.value.as_str();
        if !seen.insert(key) {
            continue;
        }
        let [before, wanted, there] = [value(old, key), value(new, key), value(now, key)];
        if is_same_value(&before, &wanted) || is_same_value(&wanted, &there) {
            continue;
        }
        if !is_same_value(&before, &there) {
            conflicts.push(format!("{section} {key}"));
            if first == First::Theirs {
                continue;
            }
        }
        match wanted {
            Some(value) => {
                if let Err(why) = theirs.set(section, key, &value) {
                    conflicts.push(format!("{section} {key}: {why}"));
                }
            }
            None => theirs.remove(section, key),
        }
    }
    conflicts
}

fn is_same_value(a: &Option<Value>, b: &Option<Value>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.is_same(b),
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// Whether two tables mean the same, or there are none.
fn is_same_table(a: Option<&[Field]>, b: Option<&[Field]>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => {
            let is_in_b = |Field { key, value }: &Field| {
                find(b, &key.value).is_some_and(|other| other.value.is_same(&value.value))
            };
            a.len() == b.len() && a.iter().all(is_in_b)
        }
        (a, b) => a.is_none() && b.is_none(),
    }
}

/// All tables of both.
fn sections(a: &[Field], b: &[Field]) -> Vec<Section> {
    let mut all = vec![Section::Environment, Section::Camera, Section::View];
    for (key, section) in NAMED {
        for fields in [a, b] {
            let names = tables(fields, key).iter();
            all.extend(names.map(|table| section(table.key.value.clone())));
        }
    }
    let mut seen = HashSet::new();
    all.retain(|section| seen.insert(section.clone()));
    all
}

/// The tables below a key.
fn tables<'f>(fields: &'f [Field], key: &str) -> &'f [Field] {
    match find(fields, key).map(|value| &value.value) {
        Some(Value::Table(tables)) => tables,
        _ => &[],
    }
}

/// The tables of a look, found by their names: a look may have ten thousand.
struct Tables<'f> {
    fields: &'f [Field],
    named: HashMap<&'static str, HashMap<&'f str, &'f Value>>,
}

impl<'f> Tables<'f> {
    fn of(fields: &'f [Field]) -> Self {
        let by_name = |key: &'static str| {
            let named = tables(fields, key).iter();
            let named: HashMap<&str, &Value> = named
                .map(|table| (table.key.value.as_str(), &table.value.value))
                .collect();
            (key, named)
        };
        Self {
            fields,
            named: NAMED.into_iter().map(|(key, _)| by_name(key)).collect(),
        }
    }

    /// The keys of a table.
    fn get(&self, section: &Section) -> Option<&'f [Field]> {
        let value: &'f Value = match section.place() {
            (key, Some(name)) => self.named.get(key)?.get(name).copied()?,
            (key, None) => &find(self.fields, key)?.value,
        };
        match value {
            Value::Table(fields) => Some(fields),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: &str = "# Rust.\n[node.a] # first\ntexture = 't'\nscale = 4 # patches\namount = 1\n\n[material.M]\nroughness = 0.5\n";

    fn merged(mine: &str, theirs: &str) -> Merged {
        merge(Path::new("a.look.toml"), BASE, mine, theirs).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn what_each_side_has_changed_is_changed() {
        let mine = BASE.replace("scale = 4", "scale = 7");
        let theirs = BASE
            .replace("# Rust.", "# More rust.")
            .replace("amount = 1", "amount = 2");
        let both = merged(&mine, &theirs);
        assert_eq!(both.conflicts, [""; 0]);
        assert_eq!(both.text, theirs.replace("scale = 4", "scale = 7"));
        assert_eq!(merged(BASE, &theirs).text, theirs);
        assert_eq!(merged(&mine, BASE).text, mine);
        assert_eq!(merged(&mine, &mine), Merged::of(&mine));
    }

    #[test]
    fn tables_come_and_go() {
        let new = format!("{BASE}\n[node.b]\ntexture = 't'\n");
        let theirs = BASE.replace("0.5", "0.25");
        let both = merged(&new, &theirs);
        assert_eq!(both.conflicts, [""; 0]);
        assert!(both.text.contains("[node.b]") && both.text.contains("0.25"));
        let without = BASE.split("[material").next().expect("a head");
        assert_eq!(merged(without, &theirs).conflicts, ["[material.M]"]);
        assert!(!merged(without, &theirs).text.contains("material"));
        assert!(merged(without, &theirs).theirs_first.contains("0.25"));
        let both = merged(&theirs, without);
        assert_eq!(both.conflicts, ["[material.M]"]);
        assert!(both.text.contains("roughness = 0.25"), "{}", both.text);
        assert!(!both.theirs_first.contains("material"));
        let scale = BASE.replace("scale = 4", "scale = 7");
        let both = merged(without, &scale);
        assert_eq!(both.conflicts, [""; 0]);
        let expected = without.replace("scale = 4", "scale = 7");
        assert_eq!(both.text.trim_end(), expected.trim_end());
    }

    #[test]
    fn what_both_have_changed_is_named() {
        let mine = BASE.replace("scale = 4", "scale = 7");
        let theirs = BASE.replace("scale = 4", "scale = 9");
        let both = merged(&mine, &theirs);
        assert_eq!(both.conflicts, ["[node.a] scale"]);
        assert_eq!((both.text, both.theirs_first), (mine, theirs.clone()));
        let include = format!("[[include]]\nfile = 'a.glb'\n\n{BASE}");
        assert_eq!(merged(&include, &theirs).conflicts, ["[[include]]"]);
        let document = format!("[[materialx]]\nfile = 'a.mtlx'\nname = 'M'\n\n{BASE}");
        assert_eq!(merged(&document, &theirs).conflicts, ["[[materialx]]"]);
        assert!(merge(Path::new(""), BASE, "a =", &theirs).is_err());
    }

    /// Each of the own keys may go with one of the other side's, and not with the other one.
    #[test]
    fn what_is_no_look_together_is_one_of_both() {
        let spot = |inner: f32, outer: f32| {
            format!(
                "[light.s]\ntype = 'spot'\nposition = [0, 1, 0]\ninner_cone_angle = {inner:?}\nouter_cone_angle = {outer:?}\n"
            )
        };
        let merged = |mine: &str, theirs: &str| {
            let base = spot(10.0, 40.0);
            merge(Path::new("a.look.toml"), &base, mine, theirs).unwrap_or_else(|e| panic!("{e}"))
        };
        let (wide, narrow) = (spot(30.0, 50.0), spot(10.0, 20.0));
        let both = merged(&wide, &narrow);
        assert_eq!((&both.text, &both.theirs_first), (&wide, &narrow));
        let [key, why] = &both.conflicts[..] else {
            panic!("{:?}", both.conflicts);
        };
        assert_eq!(key, "[light.s] outer_cone_angle");
        assert!(why.starts_with("the file's as a whole"), "{why}");
        assert!(why.contains("has to be less than"), "{why}");
        let both = merged(&narrow, &wide);
        assert_eq!((&both.text, &both.theirs_first), (&narrow, &wide));
        assert!(both.conflicts[1].starts_with("mine as a whole"));
        // Without a key that both have changed there is a choice all the same.
        let (inner, outer) = (spot(30.0, 40.0), spot(10.0, 20.0));
        let both = merged(&inner, &outer);
        assert_eq!((&both.text, &both.theirs_first), (&inner, &outer));
        assert_eq!(both.conflicts.len(), 2, "{:?}", both.conflicts);
    }

    /// Where each table was searched among all others, this took minutes.
    #[test]
    fn very_many_tables_are_brought_together() {
        let table = |i: usize| format!("[node.n{i}]\ntexture = 't'\nscale = 1\n");
        let base: String = (0..80_000).map(table).collect();
        let mine = base.replacen("scale = 1", "scale = 2", 1);
        let theirs = format!("{base}[node.last]\ntexture = 't'\n");
        let both = merge(Path::new("a.look.toml"), &base, &mine, &theirs).expect("looks");
        assert!(both.conflicts.is_empty(), "{:?}", both.conflicts);
        assert_eq!(both.text, theirs.replacen("scale = 1", "scale = 2", 1));
    }
}
