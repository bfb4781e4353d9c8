//! Edits of the graph's frames: which cards they are around.

use engine::scene::look::{FrameLook, Section, Spanned, Value};
use engine::session::{Document, Edit};

/// The frame that a node is in.
pub(crate) fn frame_of<'d>(document: &'d Document, node: &str) -> Option<&'d FrameLook> {
    let mut frames = document.look().frames.iter();
    frames.find(|frame| frame.nodes.iter().any(|member| member.value == node))
}

/// The frame that a material is in.
pub(crate) fn frame_of_material<'d>(
    document: &'d Document,
    material: &str,
) -> Option<&'d FrameLook> {
    let mut frames = document.look().frames.iter();
    frames.find(|frame| frame.materials.iter().any(|m| m.value == material))
}

/// Puts a frame around nodes, which leave those that they are in. Also gives its title.
pub(crate) fn frame(document: &Document, nodes: &[String]) -> (String, Vec<Edit>) {
    let title = free_title(document);
    let mut edits = unframe(document, nodes, &[]);
    let section = Section::Frame(title.clone());
    edits.push(Edit::set(section, "nodes", names(nodes.iter())));
    (title, edits)
}

/// Puts a material into a frame, which may be a new one; it leaves the one that it is in.
pub(crate) fn frame_material(document: &Document, material: &str, title: &str) -> Vec<Edit> {
    let material = material.to_owned();
    let mut edits = unframe(document, &[], std::slice::from_ref(&material));
    let mut frames = document.look().frames.iter();
    let frame = frames.find(|frame| frame.name.value == title);
    let members = frame.into_iter().flat_map(|frame| &frame.materials);
    let members = members.map(|member| &member.value);
    let others = members.filter(|member| **member != material);
    let members = names(others.chain([&material]));
    let section = Section::Frame(title.to_owned());
    edits.push(Edit::set(section, "materials", members));
    edits
}

/// Takes nodes and materials out of the frames that they are in. One around nothing is taken away.
pub(crate) fn unframe(document: &Document, nodes: &[String], materials: &[String]) -> Vec<Edit> {
    let changed = document.look().frames.iter().flat_map(|frame| {
        let section = || Section::Frame(frame.name.value.clone());
        let parts = [
            ("nodes", &frame.nodes, nodes),
            ("materials", &frame.materials, materials),
        ];
        let stay = parts.map(|(_, members, gone)| {
            let members = members.iter().map(|member| &member.value);
            members.filter(|member| !gone.contains(member)).collect()
        });
        let stay: [Vec<&String>; 2] = stay;
        let has_changed = [0, 1].map(|part| parts[part].1.len() != stay[part].len());
        if has_changed != [false; 2] && stay.iter().all(Vec::is_empty) {
            return vec![Edit::Remove { section: section() }];
        }
        let changed = [0, 1].into_iter().filter(|&part| has_changed[part]);
        let edits = changed.map(|part| {
            let (key, members) = (parts[part].0, &stay[part]);
            match members.is_empty() {
                true => Edit::Clear {
                    section: section(),
                    key: key.to_owned(),
                },
                false => Edit::set(section(), key, names(members.iter().copied())),
            }
        });
        edits.collect()
    });
    changed.collect()
}

/// A title that no frame has.
pub(crate) fn free_title(document: &Document) -> String {
    let frames = &document.look().frames;
    let is_taken = |title: &str| frames.iter().any(|frame| frame.name.value == title);
    let numbered = (2..).map(|number| format!("Frame {number}"));
    let mut titles = std::iter::once("Frame".to_owned()).chain(numbered);
    let title = titles.find(|title| !is_taken(title));
    title.expect("there are more numbers than frames")
}

/// Members of a frame by other names.
pub(crate) fn renamed(members: &[Spanned<String>], old: &str, new: &str) -> Option<Value> {
    if !members.iter().any(|member| member.value == old) {
        return None;
    }
    let called = members.iter().map(|member| match member.value == old {
        true => new.to_owned(),
        false => member.value.clone(),
    });
    let called: Vec<String> = called.collect();
    Some(names(called.iter()))
}

/// A list of names.
fn names<'n>(names: impl Iterator<Item = &'n String>) -> Value {
    let texts = names.map(|name| Spanned::new(Value::Text(name.clone()), 0..0));
    Value::List(texts.collect())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const LOOK: &str = "[node.a]\ntexture = 't'\n[material.New]\nroughness = 0.5\n[graph.Rust]\nnodes = ['a'] # mine\n";

    #[test]
    fn a_material_is_in_one_frame_at_most() {
        let mut document = Document::new(Path::new("a.look.toml"), LOOK).expect("a look");
        let mut put = |title: &str| {
            let edits = frame_material(&document, "New", title);
            document.apply("frame", &edits, None).expect("it fits");
            document.text().to_owned()
        };
        let in_rust = put("Rust");
        assert!(in_rust.contains("nodes = ['a'] # mine\nmaterials = [\"New\"]\n"));
        assert_eq!(put("Rust"), in_rust);
        let alone = put("Frame");
        assert!(
            alone.contains("[graph.Frame]\nmaterials = [\"New\"]"),
            "{alone}"
        );
        assert!(alone.starts_with(LOOK), "{alone}");
        // A frame around nothing goes; one that has nodes stays.
        assert!(!put("Rust").contains("[graph.Frame]"));
        assert_eq!(
            frame_of_material(&document, "New"),
            frame_of(&document, "a")
        );
        let edits = unframe(&document, &["a".to_owned()], &[]);
        document.apply("unframe", &edits, None).expect("it fits");
        assert!(
            document.text().contains("[graph.Rust]"),
            "{}",
            document.text()
        );
        let edits = unframe(&document, &[], &["New".to_owned()]);
        document.apply("unframe", &edits, None).expect("it fits");
        assert!(!document.text().contains("graph"), "{}", document.text());
    }
}
