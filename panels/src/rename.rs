//! Renaming nodes and materials: whatever refers to them follows, in one step.

use engine::scene::look::{Section, Value, link_text};
use engine::session::{Document, Edit};

use crate::edits::link;
use crate::framing::renamed;
use crate::model::{Model, Target, assumed_link};

/// A table that gets another name, and those that refer to it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Renaming {
    /// The table as it was called.
    pub(crate) section: Section,
    /// What it is called now.
    pub(crate) name: String,
    /// What refers to it, told the new name.
    followers: Vec<Edit>,
}

impl Renaming {
    /// A node is called `name`; all links lead to it as before.
    ///
    /// # Errors
    /// Another node has that name. Whether it may be a name at all is found when it is made.
    pub(crate) fn of_node(
        document: &Document,
        model: &Model,
        node: &str,
        name: &str,
    ) -> Result<Self, String> {
        let mut nodes = document.look().nodes.iter();
        if nodes.any(|other| other.name.value == name) {
            return Err(format!("there is a node called `{name}` already"));
        }
        let to_name = |text: &str| {
            let link_to = link_text(text).ok().filter(|link| link.node == node)?;
            Some(Value::Text(link(name, link_to.swizzle)))
        };
        let mut followers = Vec::new();
        for reader in &document.look().nodes {
            let texture = model.texture(&reader.name.value);
            for field in &reader.params {
                let key = &field.key.value;
                // The path of an image is no link. What a parameter that the texture lacks is, nobody knows.
                let may_link = match texture {
                    Some(texture) => (texture.parameter(key))
                        .is_none_or(|(_, declared)| declared.ty.is_linkable()),
                    None => assumed_link(&field.value.value).is_some(),
                };
                if let (Value::Text(text), true) = (&field.value.value, may_link) {
                    let section = Section::Node(reader.name.value.clone());
                    followers.extend(to_name(text).map(|value| Edit::set(section, key, value)));
                }
            }
        }
        for wire in &model.wires {
            let is_of_material = !matches!(wire.target, Target::Parameter { .. });
            if is_of_material && wire.source == node {
                let (section, key) = wire.target.place();
                let value = Value::Text(link(name, wire.swizzle));
                followers.push(Edit::set(section, key, value));
            }
        }
        for frame in &document.look().frames {
            if let Some(members) = renamed(&frame.nodes, node, name) {
                let section = Section::Frame(frame.name.value.clone());
                followers.push(Edit::set(section, "nodes", members));
            }
        }
        Ok(Self {
            section: Section::Node(node.to_owned()),
            name: name.to_owned(),
            followers,
        })
    }

    /// A frame of the graph has another title.
    ///
    /// # Errors
    /// It can't be called so: says why.
    pub(crate) fn of_frame(document: &Document, frame: &str, name: &str) -> Result<Self, String> {
        if name.is_empty() {
            return Err("a frame needs a title".to_owned());
        }
        let mut frames = document.look().frames.iter();
        if frames.any(|other| other.name.value == name) {
            return Err(format!("there is a frame called `{name}` already"));
        }
        Ok(Self {
            section: Section::Frame(frame.to_owned()),
            name: name.to_owned(),
            followers: Vec::new(),
        })
    }

    /// A material that only the look has is called `name`; blends are of it as before. `taken` are names of the
    /// scene.
    ///
    /// # Errors
    /// It can't be called so: says why.
    pub(crate) fn of_material<'s>(
        document: &Document,
        model: &Model,
        material: &str,
        name: &str,
        mut taken: impl Iterator<Item = &'s str>,
    ) -> Result<Self, String> {
        if name.trim().is_empty() {
            return Err("a material needs a name".to_owned());
        }
        let mut tables = document.look().materials.iter();
        if tables.any(|table| table.name.value == name) || taken.any(|other| other == name) {
            return Err(format!("there is a material called `{name}` already"));
        }
        let mut followers = Vec::new();
        for table in &document.look().materials {
            let blend = &table.name.value;
            for (side, key) in [(0, "blend.base"), (1, "blend.over")] {
                if model
                    .sides(blend)
                    .is_some_and(|sides| sides[side] == material)
                {
                    let value = Value::Text(name.to_owned());
                    followers.push(Edit::material(blend, key, value));
                }
            }
        }
        for frame in &document.look().frames {
            if let Some(members) = renamed(&frame.materials, material, name) {
                let section = Section::Frame(frame.name.value.clone());
                followers.push(Edit::set(section, "materials", members));
            }
        }
        Ok(Self {
            section: Section::Material(material.to_owned()),
            name: name.to_owned(),
            followers,
        })
    }

    /// What it was called.
    pub(crate) fn old_name(&self) -> &str {
        self.section.place().1.unwrap_or_default()
    }
}

/// Renames a table as one step.
///
/// # Errors
/// The name is none: says what one is. Nothing has changed then.
pub(crate) fn rename(document: &mut Document, renaming: &Renaming) -> Result<(), String> {
    let label = format!("rename {} to {}", renaming.old_name(), renaming.name);
    document.change(&label, None, &[], |text| {
        let followers = &mut renaming.followers.iter();
        followers.try_for_each(|edit| edit.write(text))?;
        text.rename(&renaming.section, &renaming.name)
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use engine::procedural::TextureSources;

    use super::*;
    use crate::Textures;

    const LOOK: &str = "# Head.\n[node.rust] # it rusts\ntexture = 'mask' # mine\n\n[node.paint]\ntexture = 'tint'\n\
                        a = 'rust' # below\nb = \"rust.x\"\nimage = 'rust'\n\n[node.odd]\ntexture = 'missing'\nx = 'rust.xx'\nfile = 'rust.png'\n\n\
                        [material.Iron]\nroughness = 'rust'\nblend = { base = 'Iron', over = 'New', mask = 'rust' } # all\n\n\
                        [material.New] # added\nmetallic = 1\n";

    fn textures() -> Textures {
        let mut sources = TextureSources::default();
        let tint = "fn userProc(a: f32, b: f32, image: sam2D) -> vec3f { return vec3f(a, b, 0.0) + tex2D(image, vec2f()).xyz; }";
        sources.insert("mask", "fn userProc(x: f32) -> f32 { return x; }");
        sources.insert("tint", tint);
        let textures = Textures::load(&sources);
        assert!(textures.broken.is_empty(), "{:?}", textures.broken);
        textures
    }

    fn document() -> Document {
        Document::new(Path::new("a.look.toml"), LOOK).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn all_links_to_a_node_follow() {
        let mut document = document();
        let model = Model::new(&document, &textures().library);
        let renaming =
            Renaming::of_node(&document, &model, "rust", "old_rust").expect("it is free");
        rename(&mut document, &renaming).expect("it is a name");
        let expected = LOOK
            .replace("[node.rust]", "[node.old_rust]")
            .replace("'rust'", "'old_rust'")
            .replace("'rust.xx'", "'old_rust.xx'")
            .replace("\"rust.x\"", "\"old_rust.x\"")
            .replace("image = 'old_rust'", "image = 'rust'");
        assert_eq!(document.text(), expected);
        assert!(document.undo());
        assert_eq!(document.text(), LOOK);
        assert!(!document.undo(), "it was one step");
        assert!(document.redo());
        assert_eq!(document.text(), expected);
    }

    #[test]
    fn names_that_are_none_or_taken_are_refused() {
        let mut document = document();
        let model = Model::new(&document, &textures().library);
        let taken = Renaming::of_node(&document, &model, "rust", "paint").expect_err("taken");
        assert!(taken.contains("already"), "{taken}");
        for name in ["", "a b", "a.x", "#fff", "\u{0}", "a\nb"] {
            let renaming = Renaming::of_node(&document, &model, "rust", name).expect("it is free");
            let why = rename(&mut document, &renaming).expect_err(name);
            assert!(why.contains("letters"), "{why}");
            assert_eq!(document.text(), LOOK);
        }
        assert!(document.take_changes().is_empty());
        let of_material = |name| {
            Renaming::of_material(&document, &model, "New", name, ["Iron", "Wood"].into_iter())
        };
        for name in ["", " ", "Iron", "Wood", "New"] {
            assert!(of_material(name).is_err(), "{name}");
        }
    }

    #[test]
    fn blends_follow_a_material() {
        let mut document = document();
        let model = Model::new(&document, &textures().library);
        let renaming =
            Renaming::of_material(&document, &model, "New", "Old Rust", std::iter::empty())
                .expect("it is free");
        rename(&mut document, &renaming).expect("it is a name");
        let expected = LOOK
            .replace("[material.New]", "[material.\"Old Rust\"]")
            .replace("over = 'New'", "over = 'Old Rust'");
        assert_eq!(document.text(), expected);
    }
}
