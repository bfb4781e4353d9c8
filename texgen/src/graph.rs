//! The texture graph: nodes, their values and links. Data only: compiling it to programs makes no shader.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use crate::library::Library;
use crate::program::Program;
use crate::swizzle::Swizzle;
use crate::value::{OutputType, Value};

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

/// Why a graph can't be built or compiled as asked. The look file adds line and column.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GraphError {
    /// No texture of that name.
    #[error("there is no texture called `{name}`{}", hint(.suggestion))]
    UnknownTexture {
        /// As asked for.
        name: String,
        /// A name it may have meant.
        suggestion: Option<String>,
    },
    /// The texture has no such parameter.
    #[error("texture `{texture}` has no parameter `{name}`{}", hint(.suggestion))]
    UnknownParameter {
        /// The node's texture.
        texture: String,
        /// As asked for.
        name: String,
        /// A name it may have meant.
        suggestion: Option<String>,
    },
    /// Two nodes of one name.
    #[error("there are two nodes called `{name}`: rename one of them")]
    DuplicateNode {
        /// The name.
        name: String,
    },
    /// A value of another type than the parameter's.
    #[error(
        "parameter `{parameter}` of `{node}` is of type {expected}, but gets a value of type {found}"
    )]
    ValueType {
        /// The node.
        node: String,
        /// Its parameter.
        parameter: String,
        /// The parameter's type.
        expected: String,
        /// The value's type.
        found: String,
    },
    /// A value that is NaN, infinite, or a ramp without stops.
    #[error("the value of parameter `{parameter}` of `{node}` {problem}")]
    BadValue {
        /// The node.
        node: String,
        /// Its parameter.
        parameter: String,
        /// What is wrong and what to write.
        problem: String,
    },
    /// A link whose type doesn't fit.
    #[error(
        "`{source_node}` gives {found}, but parameter `{parameter}` of `{node}` is of type {expected}: {remedy}"
    )]
    LinkType {
        /// The node that gets the link.
        node: String,
        /// Its parameter.
        parameter: String,
        /// The parameter's type.
        expected: String,
        /// The node the link comes from.
        source_node: String,
        /// What the link gives.
        found: String,
        /// What to do.
        remedy: String,
    },
    /// A swizzle that names components which the source doesn't have.
    #[error("`{source_node}` gives {found}: it has no `{swizzle}`")]
    LinkSwizzle {
        /// The node the link comes from.
        source_node: String,
        /// What it gives.
        found: String,
        /// The swizzle.
        swizzle: String,
    },
    /// Nodes that need each other.
    #[error("these nodes need each other in a circle: {}; break one of the links", .nodes.join(" -> "))]
    Cycle {
        /// The names around the circle; the first is repeated at the end.
        nodes: Vec<String>,
    },
    /// An image parameter without an image.
    #[error(
        "parameter `{parameter}` of `{node}` is an image and has none: set `{parameter}` to an image file"
    )]
    MissingValue {
        /// The node.
        node: String,
        /// Its parameter.
        parameter: String,
    },
}

fn hint(suggestion: &Option<String>) -> String {
    suggestion
        .as_ref()
        .map_or(String::new(), |name| format!("; did you mean `{name}`?"))
}

/// Nodes, links, and the fake stack that holds all constants.
#[derive(Clone, Debug)]
pub struct Graph {
    library: Arc<Library>,
    args: Vec<u32>,
    by_name: HashMap<String, NodeId>,
}

impl Graph {
    /// An empty graph over the textures of `library`.
    pub fn new(library: Arc<Library>) -> Self {
        Self {
            library,
            args: Vec::new(),
            by_name: HashMap::new(),
        }
    }

    /// The textures its nodes are of.
    pub fn library(&self) -> &Arc<Library> {
        &self.library
    }

    /// Adds a node with its texture's default values. `occlusion` are the AO slots (0 to 3) that the texture
    /// reads as `AO` and `AO1`.
    ///
    /// # Errors
    /// Unknown texture; a node of that name exists.
    pub fn add_node(
        &mut self,
        name: &str,
        texture: &str,
        occlusion: [u32; 2],
    ) -> Result<NodeId, GraphError> {
        let _ = (name, occlusion);
        Err(GraphError::UnknownTexture {
            name: texture.to_owned(),
            suggestion: self.library.suggest(texture).map(str::to_owned),
        })
    }

    /// The node of that name.
    pub fn node(&self, name: &str) -> Option<NodeId> {
        self.by_name.get(name).copied()
    }

    /// What a node gives.
    pub fn output(&self, node: NodeId) -> OutputType {
        let _ = node;
        OutputType::F32
    }

    /// Sets a parameter to a constant, in place of any link. A `F32` is widened for vector parameters and a
    /// `Vec3` for `vec4f` (alpha 1).
    ///
    /// # Errors
    /// Unknown parameter; wrong type; a value that is not finite.
    pub fn set_value(
        &mut self,
        node: NodeId,
        parameter: &str,
        value: Value,
    ) -> Result<Edit, GraphError> {
        let _ = (node, parameter, value);
        Ok(Edit::default())
    }

    /// Links a parameter to another node's output.
    ///
    /// # Errors
    /// Unknown parameter; a type that doesn't fit; a circle. The graph is unchanged then.
    pub fn set_link(
        &mut self,
        node: NodeId,
        parameter: &str,
        source: NodeId,
        swizzle: Option<Swizzle>,
    ) -> Result<Edit, GraphError> {
        let _ = (node, parameter, source, swizzle);
        Ok(Edit::default())
    }

    /// Takes a link away: the parameter has its constant again.
    ///
    /// # Errors
    /// Unknown parameter.
    pub fn clear_link(&mut self, node: NodeId, parameter: &str) -> Result<Edit, GraphError> {
        let _ = (node, parameter);
        Ok(Edit::default())
    }

    /// Sets the AO slots (0 to 3) that the node's texture reads as `AO` and `AO1`.
    pub fn set_occlusion(&mut self, node: NodeId, occlusion: [u32; 2]) -> Edit {
        let _ = (node, occlusion);
        Edit::default()
    }

    /// The fake stack: constants of all nodes.
    pub fn args(&self) -> &[u32] {
        &self.args
    }

    /// Compiles the part of the graph below `roots`.
    ///
    /// # Errors
    /// An image parameter below the roots without an image.
    pub fn compile(&self, roots: &[NodeId]) -> Result<Program, GraphError> {
        let _ = roots;
        Ok(Program::default())
    }
}
