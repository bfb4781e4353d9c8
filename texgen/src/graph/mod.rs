//! The texture graph: nodes, their values and links. Data only: compiling it to programs makes no shader.

mod links;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use crate::args::{self, FakeStack};
use crate::attribute::Attribute;
use crate::graph_error::GraphError;
use crate::library::Library;
use crate::suggest::did_you_mean;
use crate::texture::TextureType;
use crate::value::{OutputType, ParameterType, Value};

pub use links::Link;

/// A node of a [`Graph`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub(crate) u32);

impl NodeId {
    /// Its number: nodes are numbered from 0 in the order in which they were added.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// What an edit changed, so that the host writes only that.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Edit {
    /// Word ranges of [`Graph::args`] to be written again. They may lie beyond the former end.
    pub words: Vec<Range<usize>>,
    /// Whether links or AO slots changed, so that programs with this node must be compiled again.
    pub program: bool,
}

/// Most words of the fake stack, 64 MiB, after which no node is added. It lies in memory several times, here and on the
/// device; and a line of a look is enough for a node of 4 MiB.
const MAX_WORDS: usize = 16 << 20;

/// AO slots a node can choose from.
const OCCLUSION_SLOTS: u32 = 4;

/// A value that was lost because its parameter is of another type now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DroppedValue {
    /// The node.
    pub node: String,
    /// Its parameter.
    pub parameter: String,
    /// The parameter's type now.
    pub ty: ParameterType,
}

impl std::fmt::Display for DroppedValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "parameter `{}` of `{}` is of type {} now and has its default: its former value doesn't fit",
            self.parameter, self.node, self.ty
        )
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) name: String,
    /// Type number of its texture.
    pub(crate) texture: usize,
    pub(crate) occlusion: [u32; 2],
    /// Offset of its block in the fake stack.
    pub(crate) block: u32,
    pub(crate) inputs: Vec<Input>,
    /// Something has read it. What nothing reads closes no circle, whatever it reads itself: so chains are built in time in proportion
    /// to their length.
    was_read: bool,
}

/// What a node's parameter gets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Input {
    /// Set by the user; else the texture's default holds.
    value: Option<Value>,
    pub(crate) link: Option<Link>,
    /// Where a ramp's stops lie in the fake stack.
    piece: Range<usize>,
}

impl Input {
    /// Whether it has a constant of its own.
    pub(crate) fn is_set(&self) -> bool {
        self.value.is_some()
    }
}

/// Nodes, links, and the fake stack that holds all constants.
#[derive(Clone, Debug)]
pub struct Graph {
    library: Arc<Library>,
    stack: FakeStack,
    nodes: Vec<Node>,
    by_name: HashMap<String, NodeId>,
}

impl Graph {
    /// An empty graph over the textures of `library`.
    pub fn new(library: Arc<Library>) -> Self {
        Self {
            library,
            stack: FakeStack::default(),
            nodes: Vec::new(),
            by_name: HashMap::new(),
        }
    }

    /// The textures its nodes are of.
    pub fn library(&self) -> &Arc<Library> {
        &self.library
    }

    /// The same graph over other versions of its textures, as after a file was edited: values and links of
    /// parameters that are still there are kept, and so are all [`NodeId`]s. The fake stack is laid out anew.
    ///
    /// A parameter that is new, or of a type now that its value doesn't fit, has its default; the latter are told in
    /// the second result. What was given to parameters that are gone is forgotten.
    ///
    /// # Errors
    /// A texture in use is gone; a link that doesn't fit any more; constants that are too large together.
    pub fn with_library(
        &self,
        library: Arc<Library>,
    ) -> Result<(Self, Vec<DroppedValue>), GraphError> {
        let mut new = Self::new(library);
        let mut dropped = Vec::new();
        for node in &self.nodes {
            new.add_node(&node.name, self.texture_of(node).name(), node.occlusion)?;
        }
        for (id, node) in self.ids().zip(&self.nodes) {
            for (parameter, input) in self.texture_of(node).parameters().iter().zip(&node.inputs) {
                let Some((_, declared)) = new.texture(id).parameter(&parameter.name) else {
                    continue;
                };
                let ty = declared.ty;
                if let Some(value) = &input.value
                    && new.set_value(id, &parameter.name, value.clone()).is_err()
                {
                    dropped.push(DroppedValue {
                        node: node.name.clone(),
                        parameter: parameter.name.clone(),
                        ty,
                    });
                }
                if let Some(link) = input.link {
                    new.set_link(id, &parameter.name, link.source, link.swizzle)?;
                }
            }
        }
        Ok((new, dropped))
    }

    /// Whether all that nodes were given fits into other versions of their textures as it is: no parameter with a value
    /// or a link of its own is gone, or of another type. Otherwise whoever knows where it came from has to give it again.
    pub fn keeps_given(&self, library: &Library) -> bool {
        self.nodes.iter().all(|node| {
            let former = self.texture_of(node);
            let Some(now) = library.get(former.name()) else {
                return true;
            };
            let inputs = former.parameters().iter().zip(&node.inputs);
            let mut given = inputs.filter(|(_, input)| input.is_set() || input.link.is_some());
            given.all(|(parameter, _)| {
                let now = now.parameter(&parameter.name);
                now.is_some_and(|(_, declared)| declared.ty == parameter.ty)
            })
        })
    }

    /// Adds a node with its texture's default values. `occlusion` are the AO slots (0 to 3) that the texture
    /// reads as `AO` and `AO1`.
    ///
    /// # Errors
    /// Unknown texture; a node of that name exists; no such AO slot; constants of all nodes that are too large together.
    /// The graph is unchanged then.
    pub fn add_node(
        &mut self,
        name: &str,
        texture: &str,
        occlusion: [u32; 2],
    ) -> Result<NodeId, GraphError> {
        let Some(texture) = self.library.index_of(texture) else {
            return Err(GraphError::UnknownTexture {
                name: texture.to_owned(),
                suggestion: self.library.suggest(texture).map(str::to_owned),
            });
        };
        if self.by_name.contains_key(name) {
            return Err(GraphError::DuplicateNode {
                name: name.to_owned(),
            });
        }
        check_occlusion(name, occlusion)?;
        let id = NodeId(self.nodes.len() as u32);
        let library = self.library.clone();
        let texture_type = &library.textures()[texture];
        if self.args().len() + words_of_new(texture_type) > MAX_WORDS {
            return Err(GraphError::TooManyConstants {
                node: name.to_owned(),
                texture: texture_type.name().to_owned(),
                bytes: 4 * MAX_WORDS,
            });
        }
        self.nodes.push(Node {
            name: name.to_owned(),
            texture,
            occlusion,
            // Never empty, so that its place tells the node.
            block: self
                .stack
                .push_block(args::block_words(texture_type.parameters()).max(1)),
            inputs: vec![Input::default(); texture_type.parameters().len()],
            was_read: false,
        });
        self.by_name.insert(name.to_owned(), id);
        for (place, parameter) in texture_type.parameters().iter().enumerate() {
            self.store(id, place, parameter.default.as_ref());
        }
        Ok(id)
    }

    /// The node of that name.
    pub fn node(&self, name: &str) -> Option<NodeId> {
        self.by_name.get(name).copied()
    }

    /// All nodes in the order in which they were added.
    pub fn ids(&self) -> impl ExactSizeIterator<Item = NodeId> + use<> {
        (0..self.nodes.len() as u32).map(NodeId)
    }

    /// A node's name.
    pub fn name(&self, node: NodeId) -> &str {
        &self.nodes[node.index()].name
    }

    /// A node's texture.
    pub fn texture(&self, node: NodeId) -> &TextureType {
        self.texture_of(&self.nodes[node.index()])
    }

    /// Where a node's constants lie in [`Self::args`], in words; see [`TextureType::argument_layout`]. The stops of
    /// its ramps lie elsewhere.
    pub fn block(&self, node: NodeId) -> Range<u32> {
        let start = self.nodes[node.index()].block;
        start..start + args::block_words(self.texture(node).parameters())
    }

    /// What a node gives.
    pub fn output(&self, node: NodeId) -> OutputType {
        self.texture(node).output()
    }

    /// The AO slots that a node's texture reads as `AO` and `AO1`.
    pub fn occlusion(&self, node: NodeId) -> [u32; 2] {
        self.nodes[node.index()].occlusion
    }

    /// A parameter's constant, set or by default; `None` for an image without one and where the texture has no
    /// such parameter.
    pub fn value(&self, node: NodeId, parameter: &str) -> Option<&Value> {
        let (place, declared) = self.texture(node).parameter(parameter)?;
        self.nodes[node.index()].inputs[place]
            .value
            .as_ref()
            .or(declared.default.as_ref())
    }

    /// The attribute that a parameter takes: that of its texture, where it has neither a constant of its own nor a link.
    pub fn attribute(&self, node: NodeId, parameter: &str) -> Option<&Attribute> {
        let (place, declared) = self.texture(node).parameter(parameter)?;
        let input = &self.nodes[node.index()].inputs[place];
        let is_free = input.link.is_none() && !input.is_set();
        declared.attribute.as_ref().filter(|_| is_free)
    }

    /// A parameter's link, if it has one.
    pub fn link(&self, node: NodeId, parameter: &str) -> Option<Link> {
        let (place, _) = self.texture(node).parameter(parameter)?;
        self.nodes[node.index()].inputs[place].link
    }

    /// Sets a parameter to a constant, in place of any link. Whole numbers, numbers and vectors are widened: a
    /// number for a vector is every component, a `Vec3` for `vec4f` gets a 1.
    ///
    /// # Errors
    /// Unknown parameter; wrong type; a value that is not finite. The graph is unchanged then.
    pub fn set_value(
        &mut self,
        node: NodeId,
        parameter: &str,
        value: Value,
    ) -> Result<Edit, GraphError> {
        let place = self.place(node, parameter)?;
        let ty = self.texture(node).parameters()[place].ty;
        let found = value.type_name();
        let Some(value) = widened(value, ty) else {
            return Err(GraphError::ValueType {
                node: self.name(node).to_owned(),
                parameter: parameter.to_owned(),
                expected: ty,
                found,
            });
        };
        if let Some(problem) = args::problem(&value) {
            return Err(GraphError::BadValue {
                node: self.name(node).to_owned(),
                parameter: parameter.to_owned(),
                problem,
            });
        }
        let words = self.store(node, place, Some(&value));
        let takes_attribute = self.texture(node).parameters()[place].attribute.is_some();
        let input = &mut self.nodes[node.index()].inputs[place];
        let program = input.link.take().is_some() || (takes_attribute && !input.is_set());
        input.value = Some(value);
        Ok(Edit { words, program })
    }

    /// Takes back what was given to a parameter, constant and link: it has its default, in this and in later versions of
    /// the texture.
    ///
    /// # Errors
    /// Unknown parameter.
    pub fn reset(&mut self, node: NodeId, parameter: &str) -> Result<Edit, GraphError> {
        let place = self.place(node, parameter)?;
        let default = self.texture(node).parameters()[place].default.clone();
        let words = self.store(node, place, default.as_ref());
        let takes_attribute = self.texture(node).parameters()[place].attribute.is_some();
        let input = &mut self.nodes[node.index()].inputs[place];
        let was_set = input.value.take().is_some();
        let program = input.link.take().is_some() || (takes_attribute && was_set);
        Ok(Edit { words, program })
    }

    /// Sets the AO slots (0 to 3) that the node's texture reads as `AO` and `AO1`.
    ///
    /// # Errors
    /// No such AO slot.
    pub fn set_occlusion(&mut self, node: NodeId, occlusion: [u32; 2]) -> Result<Edit, GraphError> {
        check_occlusion(self.name(node), occlusion)?;
        let old = std::mem::replace(&mut self.nodes[node.index()].occlusion, occlusion);
        let program = old != occlusion && self.texture(node).reads_occlusion();
        Ok(Edit {
            words: Vec::new(),
            program,
        })
    }

    /// The fake stack: constants of all nodes.
    pub fn args(&self) -> &[u32] {
        self.stack.words()
    }

    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    pub(crate) fn texture_of(&self, node: &Node) -> &TextureType {
        &self.library.textures()[node.texture]
    }

    fn place(&self, node: NodeId, parameter: &str) -> Result<usize, GraphError> {
        let texture = self.texture(node);
        texture
            .parameter(parameter)
            .map(|(place, _)| place)
            .ok_or_else(|| {
                let names = texture
                    .parameters()
                    .iter()
                    .map(|parameter| parameter.name.as_str());
                GraphError::UnknownParameter {
                    texture: texture.name().to_owned(),
                    name: parameter.to_owned(),
                    suggestion: did_you_mean(parameter, names).map(str::to_owned),
                }
            })
    }

    /// Writes a value into the fake stack; returns the words that changed.
    fn store(&mut self, node: NodeId, place: usize, value: Option<&Value>) -> Vec<Range<usize>> {
        let offset =
            self.nodes[node.index()].block + args::offsets(self.texture(node).parameters())[place];
        let mut changed = Vec::new();
        match value {
            Some(Value::Ramp(ramp)) => {
                let words = args::encode_ramp(ramp);
                let input = &mut self.nodes[node.index()].inputs[place];
                if input.piece.len() < words.len() {
                    self.stack.release(std::mem::take(&mut input.piece));
                    input.piece = self.stack.allocate(words.len());
                    changed.extend(self.stack.write(offset, &[input.piece.start as u32]));
                }
                changed.extend(self.stack.write(input.piece.start as u32, &words));
            }
            Some(value) => {
                let mut words = Vec::new();
                args::encode(value, &mut words);
                changed.extend(self.stack.write(offset, &words));
            }
            None => changed.extend(self.stack.write(offset, &[args::NO_IMAGE])),
        }
        changed
    }
}

/// Words of the fake stack that a new node of a texture takes, with the stops of its ramps.
fn words_of_new(texture: &TextureType) -> usize {
    let parameters = texture.parameters().iter();
    let ramps = parameters.map(|parameter| match &parameter.default {
        Some(Value::Ramp(ramp)) => args::ramp_words(ramp.stops.len()),
        _ => 0,
    });
    args::block_words(texture.parameters()) as usize + ramps.sum::<usize>()
}

fn check_occlusion(node: &str, occlusion: [u32; 2]) -> Result<(), GraphError> {
    match occlusion.into_iter().find(|&slot| slot >= OCCLUSION_SLOTS) {
        Some(slot) => Err(GraphError::OcclusionSlot {
            node: node.to_owned(),
            slot,
        }),
        None => Ok(()),
    }
}

/// `value` as one of type `ty`, if that loses nothing.
fn widened(value: Value, ty: ParameterType) -> Option<Value> {
    let value = match (value, ty) {
        (Value::F32(v), ParameterType::Vec2) => Value::Vec2([v; 2]),
        (Value::F32(v), ParameterType::Vec3) => Value::Vec3([v; 3]),
        (Value::F32(v), ParameterType::Vec4) => Value::Vec4([v; 4]),
        (Value::F32(v), ParameterType::I32) if v.fract() == 0.0 && v.abs() < 1e9 => {
            Value::I32(v as i32)
        }
        (Value::F32(v), ParameterType::U32) if v.fract() == 0.0 && (0.0..1e9).contains(&v) => {
            Value::U32(v as u32)
        }
        (Value::I32(v), ParameterType::F32) => Value::F32(v as f32),
        (Value::I32(v), ParameterType::U32) => Value::U32(u32::try_from(v).ok()?),
        (Value::U32(v), ParameterType::F32) => Value::F32(v as f32),
        (Value::U32(v), ParameterType::I32) => Value::I32(i32::try_from(v).ok()?),
        (Value::Vec3([x, y, z]), ParameterType::Vec4) => Value::Vec4([x, y, z, 1.0]),
        (Value::Array(values), ParameterType::Array(element, _)) => Value::Array(
            values
                .into_iter()
                .map(|value| widened(value, element.parameter_type()))
                .collect::<Option<_>>()?,
        ),
        (value, _) => value,
    };
    value.fits(ty).then_some(value)
}
