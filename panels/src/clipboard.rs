//! Nodes as text, for the clipboard: tables of a look, so that they go from one look to another, and can be written by hand. The AO
//! tables that they name go with them, and where the look lies whose folder their images are named from.

use std::collections::BTreeMap;
use std::path::{Path, absolute};

use engine::scene::look::{AoLook, AoSettings, NodeLook, Section, Spanned, Value, link_text};
use engine::session::{Document, Edit, summary};

use crate::edits::{free_name, link, numbered};
use crate::model::assumed_link;
use crate::textures::Textures;

/// The keys by which a node names AO tables.
const OCCLUSION: [&str; 2] = ["occlusion", "occlusion1"];

/// Stands before the path of the look that tables were copied from, on the first line: a comment, so that the text is one of a look.
const ORIGIN: &str = "# from ";

/// What is in the clipboard then.
#[derive(Debug, Default)]
pub(crate) struct Copied {
    /// The tables.
    pub(crate) text: String,
    /// The nodes whose tables these are.
    pub(crate) nodes: Vec<String>,
    /// Why others are missing, if there are such.
    pub(crate) refused: Option<String>,
}

/// The tables of some nodes.
pub(crate) fn copied(document: &Document, nodes: &[String]) -> Copied {
    let mut copied = Copied::default();
    let mut copy = match Document::new(Path::new(""), "") {
        Ok(copy) => copy,
        Err(problems) => {
            copied.refused = Some(summary(&problems));
            return copied;
        }
    };
    let all = |section: Section| {
        let fields = document.table(&section).into_iter();
        fields.map(move |field| Edit::set(section.clone(), &field.key.value, field.value.value))
    };
    for node in nodes {
        let mut tables = document.look().nodes.iter();
        let table = tables.find(|table| table.name.value == *node);
        let ao = table.into_iter().flat_map(ao_of);
        let ao = ao.map(|name| Section::Ao(name.value.clone()));
        let tables = ao.chain([Section::Node(node.clone())]);
        let edits: Vec<Edit> = tables.flat_map(all).collect();
        match copy.apply("copy", &edits, None) {
            Ok(()) => copied.nodes.push(node.clone()),
            Err(why) => copied.refused = Some(format!("{node} can't be copied: {why}")),
        }
    }
    copied.text = copy.text().to_owned();
    if let Some(line) = origin_line(document.path(), &copied.text) {
        copied.text.insert_str(0, &line);
    }
    copied
}

/// Says where the look with these tables lies. None where they mean the same files in any folder.
fn origin_line(path: &Path, text: &str) -> Option<String> {
    let path = absolute(path).ok()?;
    let written = path
        .to_str()
        .filter(|path| !path.contains(char::is_control))?;
    let elsewhere = path.parent()?.join("elsewhere").join(path.file_name()?);
    let mut tables = Document::new(&path, text).ok()?;
    let names_files = tables.move_to(&elsewhere);
    names_files.then(|| format!("{ORIGIN}{written}\n"))
}

/// Where the look lies that a text was copied from, as far as it says so.
fn origin(text: &str) -> Option<&Path> {
    let path = Path::new(text.lines().next()?.strip_prefix(ORIGIN)?);
    path.is_absolute().then_some(path)
}

/// The AO tables that a node names.
fn ao_of(node: &NodeLook) -> impl Iterator<Item = &Spanned<String>> {
    [&node.occlusion, &node.occlusion1].into_iter().flatten()
}

/// How an AO table is traced, and what of that has keys.
fn traced(document: &Document, table: &AoLook) -> (AoSettings, Value) {
    let mut keyed = document.table(&Section::Ao(table.name.value.clone()));
    keyed.retain(|field| matches!(field.value.value, Value::Table(_)));
    (table.settings, Value::Table(keyed))
}

/// What the AO tables that nodes of `source` name are called here, by their names there; and edits that add those that are missing.
fn pasted_ao(document: &Document, source: &Document) -> (BTreeMap<String, String>, Vec<Edit>) {
    let mut names: BTreeMap<String, String> = BTreeMap::new();
    let mut edits = Vec::new();
    let here = &document.look().ao;
    let there = source.look();
    for table in &there.ao {
        let name = &table.name.value;
        let mut named = there.nodes.iter().flat_map(ao_of);
        if !named.any(|other| other.value == *name) {
            continue;
        }
        let (settings, keyed) = traced(source, table);
        let is_same = |other: &&AoLook| {
            let (others, others_keyed) = traced(document, other);
            others == settings && others_keyed.is_same(&keyed)
        };
        let namesake = here.iter().find(|other| other.name.value == *name);
        let same = match namesake {
            None => None,
            Some(namesake) if is_same(&namesake) => Some(namesake),
            Some(_) => here.iter().find(is_same),
        };
        let called = match same {
            Some(same) => same.name.value.clone(),
            None => {
                let is_taken = |wanted: &str| {
                    let is_here = here.iter().any(|other| other.name.value == wanted);
                    is_here || names.values().any(|taken| taken == wanted)
                };
                let new = numbered(name, is_taken);
                for field in source.table(&Section::Ao(name.clone())) {
                    let section = Section::Ao(new.clone());
                    edits.push(Edit::set(section, &field.key.value, field.value.value));
                }
                new
            }
        };
        names.insert(name.clone(), called);
    }
    (names, edits)
}

/// The nodes of a text, under names that are free here, with links among them, and to nodes of their names that there are here. Their AO
/// tables are those of here that say the same, or come along. Images are named from the folder of this look.
///
/// # Errors
/// It is none of a look, or has no nodes: says so.
pub(crate) fn pasted(
    document: &Document,
    textures: &Textures,
    text: &str,
) -> Result<(Vec<String>, Vec<Edit>), String> {
    let read = |path: &Path| {
        Document::new(path, text).map_err(|_| "what was copied are no nodes of a look".to_owned())
    };
    let source = read(Path::new("the clipboard"))?;
    let mut moved = origin(text).map(read).transpose()?;
    if let Some(moved) = &mut moved {
        moved.move_to(document.path());
    }
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
    let (ao, mut edits) = pasted_ao(document, &source);
    for node in nodes {
        let texture = textures.library.get(&node.texture.value);
        let has_mistakes = || {
            let mut broken = textures.broken.iter();
            broken.any(|(name, _)| *name == node.texture.value)
        };
        if texture.is_none() && !has_mistakes() {
            return Err(format!(
                "there is no texture called `{}` here",
                node.texture.value
            ));
        }
        let section = || Section::Node(names[&*node.name.value].clone());
        let there = Section::Node(node.name.value.clone());
        for field in source.table(&there) {
            let key = &field.key.value;
            // Of a texture with mistakes nobody knows what is a link: what has the name of a node that comes along counts.
            let can_link = match texture {
                Some(texture) => {
                    let mut parameters = texture.parameters().iter();
                    parameters.any(|p| p.name == *key && p.ty.is_linkable())
                }
                None => assumed_link(&field.value.value)
                    .is_some_and(|wire| names.contains_key(&*wire.node)),
            };
            let value = match (&field.value.value, can_link) {
                (Value::Text(table), _) if OCCLUSION.contains(&key.as_str()) => {
                    Value::Text(ao.get(table).unwrap_or(table).clone())
                }
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
                (value, _) => {
                    let from_here = moved.as_ref().and_then(|moved| moved.value(&there, key));
                    from_here.unwrap_or_else(|| value.clone())
                }
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
        let text = copied(&from, &["noise".to_owned(), "mix".to_owned()]).text;
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
    fn ambient_occlusion_goes_along() {
        const AO: &str = "[ao.near]\ndistance = 0.5\n\n[ao.far]\ndistance = 4.0\n\n[node.rust]\ntexture = \"rust_mask\"\nocclusion = \"near\"\n\n[node.noise]\ntexture = \"fbm\"\n";
        let (from, textures) = (look(AO), textures());
        let nodes = ["noise".to_owned(), "rust".to_owned()];
        let copied = copied(&from, &nodes);
        assert_eq!((&copied.nodes[..], copied.refused), (&nodes[..], None));
        assert!(!copied.text.contains("far"), "{}", copied.text);
        let paste = |to: &mut Document| {
            let (_, edits) = pasted(to, &textures, &copied.text).expect("they are nodes");
            to.apply("paste", &edits, None).expect("they fit");
            to.text().to_owned()
        };
        // It is missing, then it is there already.
        let mut to = look("");
        let first = paste(&mut to);
        assert!(first.contains("[ao.near]\ndistance = 0.5"), "{first}");
        assert!(first.contains("occlusion = \"near\""), "{first}");
        let second = paste(&mut to);
        assert_eq!(second.matches("[ao.").count(), 1, "{second}");
        assert_eq!(second.matches("occlusion = \"near\"").count(), 2);
        // Another one is called so.
        let mut to = look("[ao.near]\ndistance = 2.0\n");
        let first = paste(&mut to);
        assert!(first.contains("[ao.near_2]\ndistance = 0.5"), "{first}");
        assert!(first.contains("occlusion = \"near_2\""), "{first}");
        let second = paste(&mut to);
        assert_eq!(second.matches("[ao.").count(), 2, "{second}");
        // What has other keys is another one.
        let mut to = look("[ao.near]\ndistance = { keys = [[0.0, 0.5], [1.0, 2.0]] }\n");
        let text = paste(&mut to);
        assert!(text.contains("[ao.near_2]"), "{text}");
    }

    /// What its parameters are, nobody knows until the mistakes are mended.
    #[test]
    fn links_of_a_texture_with_mistakes_are_links() {
        const ODD: &str = "[node.noise]\ntexture = \"fbm\"\n\n[node.odd]\ntexture = \"odd\"\nx = \"noise.x\"\ncolor = \"#102030\"\nfile = \"noise.png\"\n\n[material.Iron]\nbase_color = \"odd\"\n";
        let mut textures = textures();
        let mistake = texgen::Diagnostic::error("a brace is missing");
        textures.broken.push(("odd".to_owned(), mistake.into()));
        let nodes = ["noise", "odd"].map(str::to_owned);
        let from = look(ODD);
        let model = crate::model::Model::new(&from, &textures.library);
        let after = |edits: &[Edit]| {
            let mut document = look(ODD);
            document.apply("edit", edits, None).expect("they fit");
            document.text().to_owned()
        };
        let without = after(&crate::edits::remove_nodes(&from, &model, &nodes[..1]));
        assert!(!without.contains("[node.noise]"), "{without}");
        assert!(!without.contains("noise.x"), "{without}");
        assert!(without.contains("#102030"), "{without}");
        // An image is no link.
        assert!(without.contains("file = \"noise.png\""), "{without}");
        assert!(model.loose_nodes(from.look()).is_empty());
        let (_, edits) = crate::edits::duplicate(&from, &model, &nodes);
        let doubled = after(&edits);
        assert!(doubled.contains("x = \"noise_2.x\""), "{doubled}");
        assert_eq!(doubled.matches("file = \"noise.png\"").count(), 2);
        let copied = copied(&from, &nodes).text;
        let (names, edits) = pasted(&from, &textures, &copied).expect("it is there");
        assert_eq!(names, ["noise_2", "odd_2"]);
        let pasted = after(&edits);
        assert!(pasted.contains("x = \"noise_2.x\""), "{pasted}");
        assert_eq!(pasted.matches("file = \"noise.png\"").count(), 2);
    }

    #[test]
    fn images_are_the_same_files_in_another_folder() {
        const IMAGES: &str = "[node.wood]\ntexture = \"image\"\nfile = \"tex/wood.png\"\n\n[node.noise]\ntexture = \"fbm\"\n";
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["tex", "looks"] {
            std::fs::create_dir(folder.path().join(name)).expect("a folder");
        }
        let at = |path: &str, text: &str| {
            Document::new(&folder.path().join(path), text).expect("a look")
        };
        let from = at("a.look.toml", IMAGES);
        let text = copied(&from, &["wood".to_owned()]).text;
        let textures = textures();
        let paste = |path: &str, text: &str| {
            let mut to = at(path, "");
            let (_, edits) = pasted(&to, &textures, text).expect("they are nodes");
            to.apply("paste", &edits, None).expect("they fit");
            to.text().to_owned()
        };
        let near = paste("b.look.toml", &text);
        assert!(near.contains("file = \"tex/wood.png\""), "{near}");
        let away = paste("looks/b.look.toml", &text);
        assert!(away.contains("file = \"../tex/wood.png\""), "{away}");
        // A comment of another kind says nothing.
        let (_, tables) = text.split_once('\n').expect("it has lines");
        let by_hand = paste("looks/b.look.toml", &format!("# from home\n{tables}"));
        assert!(by_hand.contains("file = \"tex/wood.png\""), "{by_hand}");
        // Nor does the text say where what names no files is from.
        let plain = copied(&from, &["noise".to_owned()]).text;
        assert!(!plain.contains('#'), "{plain}");
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
