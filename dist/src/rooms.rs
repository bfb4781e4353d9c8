//! Which modules of a crate may know which others: of every crate none that knows it, and of `engine`, whose rooms the map in
//! `docs/architecture.md` describes, those of a table.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context, Result};

use crate::metadata::Metadata;

/// The modules of `engine` with those that they know, which stand above them.
const ENGINE: &[(&str, &[&str])] = &[
    ("alias", &[]),
    ("filter", &[]),
    ("material_record", &[]),
    ("morton", &[]),
    ("pick", &[]),
    ("sobol", &[]),
    ("stats", &[]),
    ("system", &[]),
    ("texturing", &[]),
    ("view", &[]),
    ("wave", &[]),
    ("bvh", &["morton"]),
    ("film", &["view"]),
    ("denoise", &["film"]),
    ("settings", &["film", "filter"]),
    (
        "gpu_scene",
        &[
            "alias",
            "bvh",
            "material_record",
            "pick",
            "texturing",
            "wave",
        ],
    ),
    ("frame", &["filter", "gpu_scene", "settings", "sobol"]),
    ("passes", &["film", "gpu_scene", "wave"]),
    ("display", &["film", "passes", "view"]),
    ("procedural", &["material_record", "texturing"]),
    ("fingerprint", &["film", "procedural", "settings"]),
    ("schedule", &["gpu_scene", "passes", "procedural", "wave"]),
    ("load", &["procedural", "system"]),
    (
        "renderer",
        &[
            "display",
            "film",
            "filter",
            "frame",
            "gpu_scene",
            "morton",
            "passes",
            "procedural",
            "schedule",
            "settings",
            "stats",
            "system",
            "wave",
        ],
    ),
    (
        "fleet",
        &[
            "film",
            "frame",
            "procedural",
            "renderer",
            "settings",
            "stats",
            "system",
        ],
    ),
    ("adaptive", &["film", "frame", "renderer"]),
    ("audit", &["film", "frame"]),
    ("isolated", &["procedural"]),
    (
        "evaluate",
        &["gpu_scene", "isolated", "passes", "procedural", "renderer"],
    ),
    ("bake", &["evaluate", "procedural"]),
    ("preview", &["isolated", "procedural", "renderer"]),
    (
        "session",
        &[
            "display",
            "film",
            "fingerprint",
            "load",
            "pick",
            "procedural",
            "renderer",
            "stats",
            "system",
        ],
    ),
];

/// Crates whose modules may know each other. What `device` offers are enums of what its players have, and the players take
/// and give what it offers.
const ONE_ROOM: &[&str] = &["device"];

/// The modules of a crate, each with those that it names.
type Modules = BTreeMap<String, BTreeSet<String>>;

/// What is wrong between the modules of the workspace's crates, a line each.
///
/// # Errors
/// Their files can't be read.
pub(crate) fn wrong_rooms(metadata: &Metadata) -> Result<Vec<String>> {
    let mut wrong = Vec::new();
    for package in metadata.packages.iter().filter(|p| metadata.is_member(p)) {
        let folder = package.manifest_path.parent().unwrap_or(Path::new(""));
        wrong.extend(wrong_modules(&package.name, &folder.join("src"))?);
    }
    Ok(wrong)
}

fn wrong_modules(name: &str, sources: &Path) -> Result<Vec<String>> {
    let modules = modules(sources)?;
    let mut wrong = Vec::new();
    if !ONE_ROOM.contains(&name) {
        wrong.extend(circle(&modules).map(|circle| format!("{name}: {}", circle.join(" -> "))));
    }
    if name == "engine" {
        wrong.extend(unlike(&modules, ENGINE));
    }
    Ok(wrong)
}

/// What differs from a table.
fn unlike(modules: &Modules, table: &[(&str, &[&str])]) -> Vec<String> {
    let mut wrong = Vec::new();
    for (name, known) in modules {
        let Some((_, allowed)) = table.iter().find(|(row, _)| row == name) else {
            wrong.push(format!("`{name}` has no row in dist/src/rooms.rs"));
            continue;
        };
        let others = known
            .iter()
            .filter(|other| !allowed.contains(&other.as_str()));
        wrong.extend(others.map(|other| format!("`{name}` must not know `{other}`")));
        let others = allowed.iter().filter(|other| !known.contains(**other));
        wrong.extend(others.map(|other| format!("`{name}` no longer knows `{other}`")));
    }
    wrong
}

/// Modules that know each other in a circle, where there are such.
fn circle(modules: &Modules) -> Option<Vec<String>> {
    // What knows nothing that is left is in no circle.
    let mut left = modules.clone();
    loop {
        let names: BTreeSet<String> = left.keys().cloned().collect();
        let before = left.len();
        left.retain(|_, known| known.intersection(&names).next().is_some());
        if left.len() == before {
            break;
        }
    }
    // From any that is left one always comes to another one, and so back to one that has been.
    let mut way: Vec<String> = vec![left.keys().next()?.clone()];
    loop {
        let last = way.last().expect("it begins with one");
        let next = left[last].iter().find(|next| left.contains_key(*next))?;
        let been = way.iter().position(|name| name == next);
        way.push(next.clone());
        if let Some(been) = been {
            return Some(way.split_off(been));
        }
    }
}

fn modules(sources: &Path) -> Result<Modules> {
    let mut files = Vec::new();
    let mut folders = vec![sources.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries =
            std::fs::read_dir(&folder).with_context(|| format!("reading {}", folder.display()))?;
        for entry in entries {
            let path = entry?.path();
            match path.is_dir() {
                true => folders.push(path),
                false if path.extension().is_some_and(|ending| ending == "rs") => files.push(path),
                false => {}
            }
        }
    }
    let mut modules = Modules::new();
    let mut texts = Vec::new();
    for file in &files {
        let inner = file.strip_prefix(sources).unwrap_or(file);
        let first = inner.iter().next().unwrap_or_default();
        let name = Path::new(first).file_stem().unwrap_or_default();
        let name = name.to_string_lossy().into_owned();
        if ["lib", "main"].contains(&name.as_str()) || inner.ends_with("tests.rs") {
            continue;
        }
        // A module's own file may say `super` instead of `crate`.
        let is_own =
            inner.iter().count() == 1 || inner.iter().nth(1).is_some_and(|f| f == "mod.rs");
        let text =
            std::fs::read_to_string(file).with_context(|| format!("reading {}", file.display()))?;
        modules.entry(name.clone()).or_default();
        texts.push((name, is_own, text));
    }
    for (name, is_own, text) in texts {
        let named = named(&text, is_own);
        let known: Vec<String> = (named.into_iter())
            .filter(|other| *other != name && modules.contains_key(other))
            .collect();
        modules.entry(name).or_default().extend(known);
    }
    Ok(modules)
}

/// What a text names at the root of its crate; tests, which may know everything, are left out.
fn named(text: &str, is_own: bool) -> Vec<String> {
    let code = text
        .split("#[cfg(test)]\nmod tests {")
        .next()
        .unwrap_or_default();
    let lines = code.lines().map(|line| {
        let line = line.split("//").next().unwrap_or_default();
        match is_own && line.starts_with("use super::") {
            true => line.replacen("super", "crate", 1),
            false => line.to_owned(),
        }
    });
    let code = lines.collect::<Vec<_>>().join(" ");
    let mut names = Vec::new();
    for rest in code.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            Some(group) => names.extend(firsts(group)),
            None => names.push(first(rest)),
        }
    }
    names
}

/// The identifier that a text begins with.
fn first(text: &str) -> String {
    let is_part = |c: &char| c.is_alphanumeric() || *c == '_';
    text.trim_start().chars().take_while(is_part).collect()
}

/// The identifiers that the items of a group begin with, whose brace is open already.
fn firsts(group: &str) -> Vec<String> {
    let (mut depth, mut begins) = (0, true);
    let mut names = Vec::new();
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => begins = true,
            c if begins && !c.is_whitespace() => {
                names.push(first(&group[at..]));
                begins = false;
            }
            _ => {}
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::root;

    #[test]
    fn modules_know_only_those_that_they_may() {
        let metadata = Metadata::read(root(), None).expect("Cargo knows its packages");
        let wrong = wrong_rooms(&metadata).expect("their sources can be read");
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    #[test]
    fn no_row_allows_what_stands_below_it() {
        for (place, (name, allowed)) in ENGINE.iter().enumerate() {
            for other in *allowed {
                let is_above = ENGINE[..place].iter().any(|(known, _)| known == other);
                assert!(is_above, "{name} -> {other}");
            }
        }
    }

    #[test]
    fn what_is_named_is_found() {
        let text = "use crate::a::B;\nuse crate::{\n    b::{self, c},\n    d, // e\n};\nuse super::f::G;\n\
                    fn x() { crate::h::i(); }\n#[cfg(test)]\nmod tests { use crate::j; }\n";
        assert_eq!(named(text, true), ["a", "b", "d", "f", "h"]);
        assert_eq!(named(text, false), ["a", "b", "d", "h"]);
    }

    #[test]
    fn a_circle_and_what_the_table_forbids_are_found() {
        let modules = |rows: &[(&str, &[&str])]| -> Modules {
            let row = |(name, known): &(&str, &[&str])| {
                let known = known.iter().map(|other| (*other).to_owned());
                ((*name).to_owned(), known.collect())
            };
            rows.iter().map(row).collect()
        };
        let straight = modules(&[("a", &[]), ("b", &["a"]), ("c", &["a", "b"])]);
        assert_eq!(circle(&straight), None);
        let round = modules(&[("a", &["c"]), ("b", &["a"]), ("c", &["b"]), ("d", &["a"])]);
        let found = circle(&round).expect("there is one");
        assert_eq!(found, ["a", "c", "b", "a"]);
        let table: &[(&str, &[&str])] = &[("a", &[]), ("b", &["a"])];
        assert_eq!(
            unlike(&modules(&[("a", &["b"]), ("b", &[]), ("c", &[])]), table),
            [
                "`a` must not know `b`",
                "`b` no longer knows `a`",
                "`c` has no row in dist/src/rooms.rs",
            ]
        );
    }
}
