//! Edits of several keys that belong together: each is one step of the history.

use engine::procedural::Output;
use engine::scene::look::{Section, Value};
use engine::session::{Document, Edit};
use texgen::Swizzle;

use crate::Textures;
use crate::framing::unframe;
use crate::model::{Model, Target};

/// `node` or `node.xyz`, as a look writes a link.
pub(crate) fn link(node: &str, swizzle: Option<Swizzle>) -> String {
    swizzle.map_or_else(|| node.to_owned(), |swizzle| format!("{node}{swizzle}"))
}

/// Connects a node's result to a target.
///
/// # Errors
/// It doesn't fit: says what to do.
pub(crate) fn connect(
    model: &Model,
    source: &str,
    swizzle: Option<Swizzle>,
    target: &Target,
) -> Result<Vec<Edit>, String> {
    model.check(source, swizzle, target)?;
    let (section, key) = target.place();
    Ok(vec![Edit::set(
        section,
        key,
        Value::Text(link(source, swizzle)),
    )])
}

/// Takes away what drives a target: it has its constant again.
pub(crate) fn disconnect(document: &Document, target: &Target) -> Vec<Edit> {
    let (section, key) = target.place();
    let clear = |key: &str| Edit::Clear {
        section: section.clone(),
        key: key.to_owned(),
    };
    match target {
        // A blend needs a mask: nothing of `over` is shown.
        Target::Mask { .. } => vec![Edit::set(section, key, Value::number(0.0))],
        Target::Input {
            output: Output::BUMP,
            ..
        } => {
            let has_scale = document.value(&section, "bump_scale").is_some();
            let scale = has_scale.then(|| clear("bump_scale"));
            [clear(key)].into_iter().chain(scale).collect()
        }
        _ => vec![clear(key)],
    }
}

/// A new node of a texture, and its name.
pub(crate) fn add_node(document: &Document, texture: &str) -> (String, Vec<Edit>) {
    let name = free_name(document, texture, &[]);
    let edit = Edit::add_node(&name, texture);
    (name, vec![edit])
}

/// Takes nodes away, and all links to them.
pub(crate) fn remove_nodes(document: &Document, model: &Model, nodes: &[String]) -> Vec<Edit> {
    let mut edits = Vec::new();
    for wire in &model.wires {
        let stays = match &wire.target {
            Target::Parameter { node, .. } => !nodes.contains(node),
            Target::Input { .. } | Target::Mask { .. } => true,
        };
        if stays && nodes.contains(&wire.source) {
            edits.extend(disconnect(document, &wire.target));
        }
    }
    edits.extend(nodes.iter().map(|node| Edit::remove_node(node)));
    edits.extend(unframe(document, nodes, &[]));
    edits
}

/// A new node of a texture that drives something, and its name.
///
/// # Errors
/// It doesn't fit: says why.
pub(crate) fn add_linked(
    document: &Document,
    textures: &Textures,
    texture: &str,
    target: &Target,
) -> Result<(String, Vec<Edit>), String> {
    let (node, mut edits) = add_node(document, texture);
    // What fits is known once the node is there.
    let mut with_node =
        Document::new(document.path(), document.text()).map_err(|problems| problems.to_string())?;
    with_node.apply("", &edits, None)?;
    let model = Model::new(&with_node, &textures.library);
    let fits = |swizzle| connect(&model, &node, swizzle, target);
    let parts = ["xyz", "xy", "x"].map(|part| part.parse().ok());
    let mut parts = parts.into_iter().filter_map(|part| fits(part).ok());
    let link = match fits(None) {
        Ok(link) => link,
        Err(why) => parts.next().ok_or(why)?,
    };
    edits.extend(link);
    Ok((node, edits))
}

/// Copies nodes with all that is set on them; links among them lead to the copies. Also gives the copies' names.
pub(crate) fn duplicate(
    document: &Document,
    model: &Model,
    nodes: &[String],
) -> (Vec<String>, Vec<Edit>) {
    let mut copies: Vec<String> = Vec::new();
    for node in nodes {
        copies.push(free_name(document, node, &copies));
    }
    let mut edits = Vec::new();
    for (node, copy) in nodes.iter().zip(&copies) {
        for field in document.table(&Section::Node(node.clone())) {
            let target = Target::Parameter {
                node: node.clone(),
                parameter: field.key.value.clone(),
            };
            let inner = model.source(&target).and_then(|wire| {
                let place = nodes.iter().position(|node| *node == wire.source)?;
                Some(Value::Text(link(&copies[place], wire.swizzle)))
            });
            let value = inner.unwrap_or(field.value.value);
            let section = Section::Node(copy.clone());
            edits.push(Edit::set(section, &field.key.value, value));
        }
    }
    (copies, edits)
}

/// Makes a material a blend with another one, without anything of that yet.
pub(crate) fn make_blend(material: &str, over: &str) -> Vec<Edit> {
    let section = || Section::Material(material.to_owned());
    let text = |text: &str| Value::Text(text.to_owned());
    vec![
        Edit::set(section(), "blend.base", text(material)),
        Edit::set(section(), "blend.over", text(over)),
        Edit::set(section(), "blend.mask", Value::number(0.0)),
    ]
}

/// Takes away the materials that only the look has and that nothing uses any more once `material` is a blend of
/// `sides`: the look may not have them then. `is_own` tells those of the scene's files.
pub(crate) fn remove_unused(
    document: &Document,
    model: &Model,
    is_own: impl Fn(&str) -> bool,
    material: &str,
    sides: &[&str],
) -> Vec<Edit> {
    let names = document.look().materials.iter();
    let names: Vec<&str> = names.map(|table| table.name.value.as_str()).collect();
    let used = |sides_of: &dyn Fn(&str) -> Vec<String>| {
        let own = names.iter().filter(|name| is_own(name));
        let mut used: Vec<String> = own.map(|&name| name.to_owned()).collect();
        let mut next = 0;
        while let Some(name) = used.get(next).cloned() {
            for side in sides_of(&name) {
                if !used.contains(&side) {
                    used.push(side);
                }
            }
            next += 1;
        }
        used
    };
    let written = |name: &str| -> Vec<String> {
        let sides = model.sides(name).into_iter().flatten();
        sides.map(str::to_owned).collect()
    };
    let before = used(&written);
    let after = used(&|name| match name == material {
        true => sides.iter().map(|&side| side.to_owned()).collect(),
        false => written(name),
    });
    let gone = names.iter().filter(|&&name| {
        let has = |used: &[String]| used.iter().any(|other| other == name);
        !is_own(name) && has(&before) && !has(&after)
    });
    let gone: Vec<String> = gone.map(|name| (*name).to_owned()).collect();
    let removed = gone.iter().map(|name| Edit::Remove {
        section: Section::Material(name.clone()),
    });
    removed.chain(unframe(document, &[], &gone)).collect()
}

/// A name that no node has: `wanted`, or with a number behind it. Other characters than names may have become `_`.
pub(crate) fn free_name(document: &Document, wanted: &str, taken: &[String]) -> String {
    let plain = |c: char| match c.is_alphanumeric() || c == '-' {
        true => c,
        false => '_',
    };
    let wanted: String = wanted.chars().map(plain).collect();
    let is_taken = |name: &str| {
        let nodes = &document.look().nodes;
        nodes.iter().any(|node| node.name.value == name) || taken.iter().any(|t| t == name)
    };
    numbered(&wanted, is_taken)
}

/// A name that isn't taken: `wanted`, or with a number behind it.
pub(crate) fn numbered(wanted: &str, is_taken: impl Fn(&str) -> bool) -> String {
    if !is_taken(wanted) && !wanted.is_empty() {
        return wanted.to_owned();
    }
    // `rust_2` is followed by `rust_3`, not by `rust_2_2`.
    let stem = match wanted.rsplit_once('_') {
        Some((stem, number)) if number.parse::<u32>().is_ok() && !stem.is_empty() => stem,
        _ => wanted,
    };
    let numbered = (2..).map(|number| format!("{stem}_{number}"));
    let free = numbered.into_iter().find(|name| !is_taken(name));
    free.expect("there are more numbers than names")
}
