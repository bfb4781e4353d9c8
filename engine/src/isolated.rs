//! One texture, or one node of a look, on its own: what is evaluated at points or shown in a preview.
//!
//! The materials of a look, its models, camera and light don't enter here.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use texgen::{
    Diagnostic, Diagnostics, Graph, Library, OutputType, SourceFile, Swizzle, TextureType,
    did_you_mean,
};

use crate::procedural::{EditError, Procedural, TextureSources, expanded};
use crate::scene::look::{
    AoLook, AoSettings, CameraLook, Look, MODEL_IMAGE, NodeLook, Spanned, Value, find,
};
use crate::scene::{Image, Scene};

/// What is looked at.
#[derive(Debug, Clone, Copy)]
pub enum Subject<'a> {
    /// A texture by name, with its default arguments; an output or components may stand behind the name, as in `voronoi.color`.
    Texture(&'a str),
    /// A node of a look by name, with its arguments and links; an output or components may stand behind the name.
    Node(&'a str, &'a Look),
}

impl Subject<'_> {
    /// Nodes without materials, and the subject among them.
    pub(crate) fn part(&self, sources: &TextureSources) -> Result<Part, Diagnostics> {
        let (look, node, texture, take) = match *self {
            Self::Texture(name) => {
                let (name, take) = match sources.names().any(|known| known == name) {
                    true => (name, None),
                    false => output_of(name),
                };
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
                (look, node_name, name.to_owned(), take)
            }
            Self::Node(name, look) => {
                let (name, take) = output_of(name);
                let (look, _) = expanded(look, &**sources.files(), None)?;
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
                (alone, name.to_owned(), node.texture.value.clone(), take)
            }
        };
        match sources.read(&texture) {
            Some(Ok(file)) => {
                let output = given(file, take)?;
                Ok(Part {
                    look,
                    node,
                    take,
                    output,
                })
            }
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
    /// What is taken of it.
    pub(crate) take: Option<Swizzle>,
    /// What that is.
    pub(crate) output: OutputType,
}

/// The name of a node or texture, and the output or the components behind it, as in `voronoi.color`.
fn output_of(text: &str) -> (&str, Option<Swizzle>) {
    let parts = text.split_once('.');
    let parts = parts.and_then(|(name, take)| Some((name, take.parse().ok()?)));
    parts.map_or((text, None), |(name, take)| (name, Some(take)))
}

/// What a texture gives by an output or components.
fn given(file: SourceFile, take: Option<Swizzle>) -> Result<OutputType, Diagnostics> {
    let texture = TextureType::parse(file)?;
    let name = texture.name().to_owned();
    let library = Library::new(vec![texture]).map_err(Diagnostics::from)?;
    let mut graph = Graph::new(Arc::new(library));
    let given = graph
        .add_node(&name, &name, [0, 0])
        .and_then(|node| graph.link_output(node, take));
    given.map_err(|error| Diagnostic::error(error.to_string()).into())
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

/// Names of the model's images that nodes read.
fn model_images(look: &Look) -> HashSet<&str> {
    let parameters = look.nodes.iter().flat_map(|node| &node.params);
    let files = parameters.filter_map(|parameter| match &parameter.value.value {
        Value::Table(fields) => find(fields, "file").map(|file| &file.value),
        value => Some(value),
    });
    let names = files.filter_map(|file| match file {
        Value::Text(file) => file.strip_prefix(MODEL_IMAGE),
        _ => None,
    });
    names.collect()
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
    /// What is taken of the node.
    pub(crate) take: Option<Swizzle>,
    output: OutputType,
}

impl Isolated {
    /// Brings a subject to its graph; textures are read from `sources`.
    ///
    /// # Errors
    /// There is no such texture or node; every mistake in the textures and nodes.
    pub fn new(subject: Subject<'_>, sources: &TextureSources) -> Result<Self, Diagnostics> {
        Self::with_images(subject, sources, &[])
    }

    /// As [`Self::new`], with the images of a model that nodes may name, as in `file = "model:wood.png"`. It keeps those that are named; their
    /// pixels are shared.
    ///
    /// # Errors
    /// As of [`Self::new`]; without its images a node that names one of them is such a mistake.
    pub fn with_images(
        subject: Subject<'_>,
        sources: &TextureSources,
        images: &[Image],
    ) -> Result<Self, Diagnostics> {
        let part = subject.part(sources)?;
        // All that a scene has goes to the device.
        let named = model_images(&part.look);
        let images = images.iter();
        let images = images.filter(|image| named.contains(image.short_name()));
        let scene = Scene {
            images: images.cloned().collect(),
            ..Scene::default()
        };
        Self::build(scene, part, sources)
    }

    pub(crate) fn build(
        mut scene: Scene,
        part: Part,
        sources: &TextureSources,
    ) -> Result<Self, Diagnostics> {
        let procedural = Procedural::build(&part.look, &mut scene, sources)?;
        Ok(Self {
            scene,
            procedural,
            node: part.node,
            take: part.take,
            output: part.output,
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
        self.output
    }

    /// As a look names it: its node, and what is taken of it.
    pub(crate) fn link(&self) -> String {
        let take = self.take.map_or(String::new(), |take| take.to_string());
        format!("{}{take}", self.node)
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
        let isolated = |subject| Isolated::new(subject, &sources).map_err(|e| e.to_string());
        let taken = isolated(Subject::Node("d.x", &look)).map(|d| d.link());
        assert_eq!(taken.as_deref(), Ok("d.x"));
        let error = isolated(Subject::Texture("t.cell"))
            .map(|_| ())
            .unwrap_err();
        assert!(error.contains("no output `cell`"), "{error}");
        assert_eq!(names("d"), ["d"]);
        assert_eq!(names("a"), ["a", "b"]);
        assert!(Isolated::new(Subject::Node("d", &look), &sources).is_ok());
        let cyclic = Isolated::new(Subject::Node("a", &look), &sources);
        assert!(cyclic.is_err_and(|e| e.to_string().contains("cyclic link")));
    }

    #[test]
    fn images_of_the_model_are_read_where_they_are_handed_in() {
        let text = "[node.plain]\ntexture = \"t\"\nmap = \"model:t.png\"\n\
                    [node.both]\ntexture = \"t\"\nmap = { file = \"model:u.png\", filter = \"nearest\" }\n";
        let look = Look::parse(Path::new("l.toml"), text).unwrap_or_else(|e| panic!("{e}"));
        let mut sources = TextureSources::default();
        sources.insert(
            "t",
            "fn userProc(map: sam2D) -> vec4f { return tex2D(map, readAttr(TexCoord0).xy); }",
        );
        let image = |name: &str| Image {
            name: format!("image \"{name}\""),
            width: 1,
            height: 1,
            rgba8: Arc::new(vec![255; 4]),
            srgb: true,
        };
        let images = ["other.png", "t.png", "u.png"].map(image);
        for (node, name) in [("plain", "t.png"), ("both", "u.png")] {
            let subject = Subject::Node(node, &look);
            let made = Isolated::with_images(subject, &sources, &images);
            let kept = made.unwrap_or_else(|e| panic!("{e}")).scene.images;
            let names: Vec<&str> = kept.iter().map(Image::short_name).collect();
            assert_eq!(names, [name]);
            let without = Isolated::new(subject, &sources).map(|_| ());
            let error = without.unwrap_err().to_string();
            assert!(error.contains("no image of that name"), "{error}");
        }
    }
}
