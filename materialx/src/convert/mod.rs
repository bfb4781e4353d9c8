//! A document to nodes and materials of a look. Which node becomes which texture says [`leaf`]; how inputs find what they are
//! connected to, [`graph`].

mod arithmetic;
mod graph;
mod image;
mod leaf;
mod matrix;
mod special;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use scene::input::Files;
use scene::look;
use texgen::{Diagnostics, OutputType};

use crate::document::{Document, ElementId};
use crate::types::Type;
use crate::value::{Link, Value};

pub(crate) use graph::Scope;

/// A node of the look.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Its name, which no other node has.
    pub name: String,
    /// The texture.
    pub texture: String,
    /// Arguments: constants, and links as texts.
    pub arguments: Vec<(String, look::Value)>,
}

/// A material of the look.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Its name.
    pub name: String,
    /// Keys of the material: constants, and links as texts.
    pub parameters: Vec<(&'static str, look::Value)>,
}

/// What a document has become.
#[derive(Debug, Clone, Default)]
pub struct Converted {
    /// Nodes, each behind those that it links to.
    pub nodes: Vec<Node>,
    /// Materials in the order of the file.
    pub materials: Vec<Material>,
    /// What can't be expressed, each with its line.
    pub warnings: Diagnostics,
}

/// What is wanted of a document.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Only the material of that name.
    pub material: Option<String>,
    /// What it is called in the look, where one is wanted.
    pub name: Option<String>,
    /// Folder of the look, which paths of images are relative to.
    pub folder: PathBuf,
    /// Names that other documents' nodes have.
    pub taken: HashSet<String>,
    /// Where they are known, the names of materials that are of use: others are left out with a warning, if there are any of
    /// these.
    pub known: Option<HashSet<String>>,
}

/// More nodes a document doesn't become: graphs in graphs could multiply without end.
const MAX_NODES: usize = 20_000;

/// More nodes of the document are not looked at, counting each use of a graph.
const MAX_STEPS: usize = 200_000;

/// What is under way.
pub(crate) struct Converter<'d> {
    pub(crate) document: &'d Document,
    files: &'d dyn Files,
    /// Folder of the look.
    folder: &'d Path,
    pub(crate) out: Converted,
    names: HashSet<String>,
    /// What nodes of the document have become, by their scope and number.
    done: HashMap<(String, ElementId), Option<graph::Results>>,
    /// Nodes whose inputs are being found, to end circles.
    open: Vec<(String, ElementId)>,
    /// How many connections are being followed, each from the one before.
    pub(crate) depth: usize,
    /// How many nodes, and definitions for them, have been looked at.
    steps: usize,
    /// Definitions by all that chooses one, and the types of what each gives.
    definitions: HashMap<String, Option<ElementId>>,
    output_types: HashMap<ElementId, Vec<&'d str>>,
    /// Nodes whose inputs have been held against their definitions.
    checked: HashSet<ElementId>,
    /// The number that the next node of a name has behind it.
    next_numbers: HashMap<String, usize>,
    /// Places that all share, by their textures.
    places: HashMap<&'static str, String>,
    /// What has been warned of once.
    warned: HashSet<(ElementId, String)>,
}

impl<'d> Converter<'d> {
    pub(crate) fn new(document: &'d Document, files: &'d dyn Files, wanted: &'d Wanted) -> Self {
        Self {
            document,
            files,
            folder: &wanted.folder,
            out: Converted::default(),
            names: wanted.taken.clone(),
            done: HashMap::new(),
            open: Vec::new(),
            depth: 0,
            steps: 0,
            definitions: HashMap::new(),
            output_types: HashMap::new(),
            checked: HashSet::new(),
            next_numbers: HashMap::new(),
            places: HashMap::new(),
            warned: HashSet::new(),
        }
    }

    /// Tells what can't be expressed; each once.
    pub(crate) fn warn(&mut self, id: ElementId, message: impl Into<String>) {
        let message = message.into();
        if self.warned.insert((id, message.clone())) {
            self.out.warnings.push(self.document.warning(id, message));
        }
    }

    /// Adds a node of the look under a name like `name`.
    pub(crate) fn add(
        &mut self,
        name: &str,
        texture: &str,
        arguments: Vec<(String, look::Value)>,
        ty: Type,
        output: OutputType,
    ) -> Link {
        let node = self.free_name(name);
        self.out.nodes.push(Node {
            name: node.clone(),
            texture: texture.to_owned(),
            arguments,
        });
        Link {
            node,
            ty,
            output,
            picked: None,
            is_place: false,
        }
    }

    /// A name of letters, digits, `_` and `-` that no node has yet.
    fn free_name(&mut self, wanted: &str) -> String {
        let is_fine = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let plain: String = (wanted.chars().take(100))
            .map(|c| if is_fine(c) { c } else { '_' })
            .collect();
        let plain = if plain.is_empty() {
            "node".to_owned()
        } else {
            plain
        };
        let mut name = plain.clone();
        while !self.names.insert(name.clone()) {
            let number = self.next_numbers.entry(plain.clone()).or_insert(2);
            name = format!("{plain}_{number}");
            *number += 1;
        }
        name
    }

    /// Looks at one more: whether there are more nodes than a look should have, or too much has been looked at.
    pub(crate) fn is_full(&mut self, id: ElementId) -> bool {
        self.steps += 1;
        self.has_ended(id)
    }

    /// As [`Self::is_full`], without looking at one more.
    fn has_ended(&mut self, id: ElementId) -> bool {
        let message = if self.steps > MAX_STEPS {
            "too many definitions and nodes to look at: the rest is left out".to_owned()
        } else if self.out.nodes.len() >= MAX_NODES {
            format!("more than {MAX_NODES} nodes: the rest is left out")
        } else {
            return false;
        };
        // The first place says it all, whichever the reason: no other warning is empty.
        if self.warned.insert((Document::ROOT, String::new())) {
            self.out.warnings.push(self.document.warning(id, message));
        }
        true
    }

    /// Texture coordinates, or the position, that nodes take where nothing is connected.
    pub(crate) fn place(&mut self, texture: &'static str, ty: Type) -> Value {
        let node = match self.places.get(texture) {
            Some(node) => node.clone(),
            None => {
                let name = texture.trim_start_matches("mx_");
                let link = self.add(name, texture, Vec::new(), ty, OutputType::Vec4);
                self.places.insert(texture, link.node.clone());
                link.node
            }
        };
        Value::Link(Link {
            node,
            ty,
            output: OutputType::Vec4,
            picked: None,
            is_place: true,
        })
    }
}
