//! Nodes as text, for the clipboard: tables of a look, so that they go from one look to another, and can be written by hand.

use std::collections::BTreeMap;
use std::path::Path;

use engine::scene::look::{Section, Value, link_text};
use engine::session::{Document, Edit};

use crate::edits::{free_name, link};
use crate::textures::Textures;

/// The tables of some nodes.
pub(crate) fn copied(document: &Document, nodes: &[String]) -> String {
    let mut copy = match Document::new(Path::new(""), "") {
        Ok(copy) => copy,
        // Nothing is a look.
        Err(_) => return String::new(),
    };
    for node in nodes {
        let section = || Section::Node(node.clone());
        let fields = document.table(&section()).into_iter();
        let edits: Vec<Edit> = fields
            .map(|field| Edit::set(section(), &field.key.value, field.value.value))
            .collect();
        // As it stood in a look, it can stand in another one.
        let _ = copy.apply("copy", &edits, None);
    }
    copy.text().to_owned()
}

/// The nodes of a text, under names that are free here, with links among them, and to nodes of their names that there are here.
///
/// # Errors
/// It is none of a look, or has no nodes: says so.
pub(crate) fn pasted(
    document: &Document,
    textures: &Textures,
    text: &str,
) -> Result<(Vec<String>, Vec<Edit>), String> {
    let source = Document::new(Path::new("the clipboard"), text)
        .map_err(|_| "what was copied are no nodes of a look".to_owned())?;
    let nodes = &source.look().nodes;
    if nodes.is_empty() {
        return Err("what was copied has no nodes".to_owned());
    }
    let mut names: BTreeMap<&str, String> = BTreeMap::new();
    let mut taken = Vec::new();
    for node in nodes {
        let name = free_name(document, &node.name.value, &taken);
        taken.push(name.clone());
        names.insert(&node.name.value, name);
    }
    let is_here = |name: &str| document.look().nodes.iter().any(|n| n.name.value == name);
    let mut edits = Vec::new();
    for node in nodes {
        let texture = textures.library.get(&node.texture.value);
        let texture = texture
            .ok_or_else(|| format!("there is no texture called `{}` here", node.texture.value))?;
        let section = || Section::Node(names[&*node.name.value].clone());
        for field in source.table(&Section::Node(node.name.value.clone())) {
            let key = &field.key.value;
            let parameter = texture.parameters().iter().find(|p| p.name == *key);
            let can_link = parameter.is_some_and(|p| p.ty.is_linkable());
            let value = match (&field.value.value, can_link) {
                (Value::Text(text), true) => match link_text(text) {
                    Ok(wire) => match names.get(&*wire.node) {
                        Some(name) => Value::Text(link(name, wire.swizzle)),
                        None if is_here(&wire.node) => field.value.value.clone(),
                        // It was driven by what has stayed behind.
                        None => continue,
                    },
                    // A colour.
                    Err(_) => field.value.value.clone(),
                },
                (value, _) => value.clone(),
            };
            edits.push(Edit::set(section(), key, value));
        }
    }
    Ok((taken, edits))
}

#[cfg(test)]
mod tests {
    use engine::procedural::TextureSources;

    use super::*;

    const LOOK: &str = "[node.noise]\ntexture = \"fbm\"\nscale = 3.0\n\n[node.mix]\ntexture = \"mix_color\"\na = \"#102030\"\nb = \"other\"\nfactor = \"noise.x\"\n\n[node.other]\ntexture = \"mix_color\"\n";

    fn look(text: &str) -> Document {
        Document::new(Path::new("a.look.toml"), text).expect("a look")
    }

    fn textures() -> Textures {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../user_textures");
        Textures::load(&TextureSources::scan(&[folder]).expect("they are there"))
    }

    #[test]
    fn nodes_go_from_look_to_look() {
        let from = look(LOOK);
        let text = copied(&from, &["noise".to_owned(), "mix".to_owned()]);
        assert!(text.contains("a = \"#102030\""), "{text}");
        let mut to = look("[node.noise]\ntexture = \"fbm\"\n");
        let (names, edits) = pasted(&to, &textures(), &text).expect("they are nodes");
        assert_eq!(names, ["noise_2", "mix"]);
        to.apply("paste", &edits, None).expect("they fit");
        let pasted = to.text();
        assert!(pasted.contains("factor = \"noise_2.x\""), "{pasted}");
        assert!(!pasted.contains("other"), "{pasted}");
        // Where the other node is, the link stays.
        let mut back = look(LOOK);
        let (names, edits) = super::pasted(&back, &textures(), &text).expect("they are nodes");
        back.apply("paste", &edits, None).expect("they fit");
        assert_eq!(names, ["noise_2", "mix_2"]);
        assert_eq!(back.text().matches("b = \"other\"").count(), 2);
    }

    #[test]
    fn other_texts_are_refused() {
        for text in [
            "",
            "hello",
            "[camera]\ny_fov = 30",
            "[node.a]\ntexture = \"nowhere\"",
        ] {
            assert!(pasted(&look(""), &textures(), text).is_err(), "{text}");
        }
    }
}
