//! One texture, or one node of a look, on its own: what is evaluated at points or shown in a preview.
//!
//! The materials of a look, its models, camera and light don't enter here.

use std::collections::HashSet;
use std::path::Path;

use texgen::{Diagnostic, Diagnostics, OutputType, SourceFile, did_you_mean};

use crate::procedural::{EditError, Procedural, TextureSources, expanded};
use crate::scene::Scene;
use crate::scene::look::{AoLook, AoSettings, CameraLook, Look, NodeLook, Spanned, Value};

/// What is looked at.
#[derive(Debug, Clone, Copy)]
pub enum Subject<'a> {
    /// A texture by name, with its default arguments.
    Texture(&'a str),
    /// A node of a look by name, with its arguments and links.
    Node(&'a str, &'a Look),
}

impl Subject<'_> {
    /// Nodes without materials, and the subject among them.
    pub(crate) fn part(&self, sources: &TextureSources) -> Result<Part, Diagnostics> {
        let (look, node, texture) = match *self {
            Self::Texture(name) => {
                let mut look = Look::empty(Path::new(""), SourceFile::new("look", "", ""));
                // A file may be called what no node can be.
                let plain = |c: char| {
                    if c.is_alphanumeric() || c == '-' {
                        c
                    } else {
                        '_'
                    }
                };
                let node_name: String = name.chars().map(plain).collect();
                look.nodes.push(node(&node_name, name));
                // Two tables, so that `AO` and `AO1` are not one.
                look.ao = ["ao", "ao1"].map(ao).into();
                (look, node_name, name.to_owned())
            }
            Self::Node(name, look) => {
                let (look, _) = expanded(look, &**sources.files())?;
                let Some(node) = look.nodes.iter().find(|node| node.name.value == name) else {
                    let names = || look.nodes.iter().map(|node| node.name.value.as_str());
                    let note = match did_you_mean(name, names()) {
                        Some(near) => format!("did you mean `{near}`?"),
                        None => format!("it has: {}", names().collect::<Vec<_>>().join(", ")),
                    };
                    let message = format!("the look has no node called `{name}`");
                    let error = Diagnostic::error(message).with_label(&look.file, 0..0, "");
                    return Err(error.with_note(note).into());
                };
                let alone = Look {
                    environment: None,
                    camera: CameraLook::default(),
                    materials: Vec::new(),
                    materialx: Vec::new(),
                    includes: Vec::new(),
                    nodes: with_sources(node, &look.nodes),
                    ..Look::clone(&look)
                };
                (alone, name.to_owned(), node.texture.value.clone())
            }
        };
        match sources.read(&texture) {
            Some(Ok(file)) => Ok(Part { look, node, file }),
            Some(Err(error)) => Err(Diagnostic::error(error.to_string()).into()),
            None => {
                let error = Diagnostic::error(format!("there is no texture called `{texture}`"));
                let near = did_you_mean(&texture, sources.names());
                Err(match near {
                    Some(near) => error.with_note(format!("did you mean `{near}`?")),
                    None => error.with_note("`patina texture list` shows those there are"),
                }
                .into())
            }
        }
    }
}

/// A subject in a look of its own.
pub(crate) struct Part {
    /// Has no materials, models or light.
    pub(crate) look: Look,
    /// The subject's node.
    pub(crate) node: String,
    /// Its texture.
    pub(crate) file: SourceFile,
}

/// A node and those below it, in the order of the look. What isn't needed is not built, and its mistakes don't matter.
fn with_sources(node: &NodeLook, all: &[NodeLook]) -> Vec<NodeLook> {
    let mut needed: HashSet<&str> = HashSet::new();
    let mut open = vec![node];
    while let Some(node) = open.pop() {
        if !needed.insert(&node.name.value) {
            continue;
        }
        for parameter in &node.params {
            if let Value::Text(text) = &parameter.value.value {
                // A path that reads like a link only takes a node too many along.
                let source = text.split('.').next().unwrap_or_default();
                open.extend(all.iter().filter(|other| other.name.value == source));
            }
        }
    }
    let is_needed = |node: &&NodeLook| needed.contains(node.name.value.as_str());
    all.iter().filter(is_needed).cloned().collect()
}

fn ao(name: &str) -> AoLook {
    AoLook {
        name: Spanned::new(name.to_owned(), 0..0),
        settings: AoSettings::default(),
    }
}

/// A node without arguments.
pub(crate) fn node(name: &str, texture: &str) -> NodeLook {
    NodeLook {
        name: Spanned::new(name.to_owned(), 0..0),
        texture: Spanned::new(texture.to_owned(), 0..0),
        occlusion: None,
        occlusion1: None,
        params: Vec::new(),
        keyed: Vec::new(),
    }
}

/// A texture or node with its graph and images, whose arguments can still be set.
#[derive(Debug, Clone)]
pub struct Isolated {
    pub(crate) scene: Scene,
    pub(crate) procedural: Procedural,
    pub(crate) node: String,
}

impl Isolated {
    /// Brings a subject to its graph; textures are read from `sources`.
    ///
    /// # Errors
    /// There is no such texture or node; every mistake in the textures and nodes.
    pub fn new(subject: Subject<'_>, sources: &TextureSources) -> Result<Self, Diagnostics> {
        let Part { look, node, .. } = subject.part(sources)?;
        Self::build(Scene::default(), &look, sources, node)
    }

    pub(crate) fn build(
        mut scene: Scene,
        look: &Look,
        sources: &TextureSources,
        node: String,
    ) -> Result<Self, Diagnostics> {
        let procedural = Procedural::build(look, &mut scene, sources)?;
        Ok(Self {
            scene,
            procedural,
            node,
        })
    }

    /// Sets a parameter to what a text says; see [`Procedural::set_written`].
    ///
    /// # Errors
    /// Unknown names, a value of another type, an image that can't be read.
    pub fn set(&mut self, parameter: &str, text: &str) -> Result<(), EditError> {
        self.procedural
            .set_written(&mut self.scene, &self.node, parameter, text)
    }

    /// Sets a parameter to a constant.
    ///
    /// # Errors
    /// Unknown parameter; a value of another type, or not finite.
    pub fn set_value(&mut self, parameter: &str, value: texgen::Value) -> Result<(), EditError> {
        self.procedural.set_value(&self.node, parameter, value)
    }

    /// What it gives.
    pub fn output(&self) -> OutputType {
        let graph = self.procedural.graph();
        let node = graph.node(&self.node);
        graph.output(node.expect("the subject is a node of its own graph"))
    }

    /// Its graph and what is odd in it.
    pub fn procedural(&self) -> &Procedural {
        &self.procedural
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_a_node_needs_is_built() {
        let text = "[node.a]\ntexture = \"t\"\nx = \"b.x\"\n[node.b]\ntexture = \"t\"\nx = \"a\"\n\
                    [node.c]\ntexture = \"missing\"\n[node.d]\ntexture = \"t\"\nx = 1.0\n\
                    [material.M]\nbase_color = \"c\"\n";
        let look = Look::parse(Path::new("l.toml"), text).unwrap_or_else(|e| panic!("{e}"));
        let mut sources = TextureSources::default();
        sources.insert("t", "fn userProc(x: f32) -> f32 { return x; }");
        let names = |node: &str| {
            let part = Subject::Node(node, &look).part(&sources);
            let look = part.unwrap_or_else(|e| panic!("{e}")).look;
            let names = look.nodes.into_iter().map(|node| node.name.value);
            names.collect::<Vec<_>>()
        };
        assert_eq!(names("d"), ["d"]);
        assert_eq!(names("a"), ["a", "b"]);
        assert!(Isolated::new(Subject::Node("d", &look), &sources).is_ok());
        let cyclic = Isolated::new(Subject::Node("a", &look), &sources);
        assert!(cyclic.is_err_and(|e| e.to_string().contains("cyclic link")));
    }
}
