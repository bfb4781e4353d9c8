//! Why a graph can't be built or compiled: each error names the nodes and parameters and says what to do.

use crate::swizzle::Swizzle;
use crate::value::{OutputType, ParameterType};

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
        expected: ParameterType,
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
        "`{link}` gives {found}, but parameter `{parameter}` of `{node}` is of type {expected}: {remedy}"
    )]
    LinkType {
        /// The node that gets the link.
        node: String,
        /// Its parameter.
        parameter: String,
        /// The parameter's type.
        expected: ParameterType,
        /// The node the link comes from.
        source_node: String,
        /// The link, with the output and the components that it takes.
        link: Box<str>,
        /// What the link gives.
        found: OutputType,
        /// What to do.
        remedy: Box<str>,
    },
    /// A swizzle that names components which the source doesn't have.
    #[error("`{source_node}` gives {found}: it has no `{swizzle}`")]
    LinkSwizzle {
        /// The node the link comes from.
        source_node: String,
        /// What it gives.
        found: OutputType,
        /// The swizzle.
        swizzle: Swizzle,
    },
    /// An output that the source doesn't have.
    #[error("`{source_node}` has no output `{name}`{}: {remedy}", hint(.suggestion))]
    UnknownOutput {
        /// The node the link comes from.
        source_node: String,
        /// As asked for.
        name: String,
        /// A name it may have meant.
        suggestion: Option<String>,
        /// What there is.
        remedy: String,
    },
    /// Nodes that need each other: a cyclic link.
    #[error("cyclic link: {}; take one of these links away", .nodes.join(" -> "))]
    Cycle {
        /// The names along it; the first is repeated at the end.
        nodes: Vec<String>,
    },
    /// A program that no kernel's stack can hold.
    #[error("the graph needs {slots} results at once: at most 65535 are possible; simplify it")]
    TooManySlots {
        /// Slots it needs.
        slots: u32,
    },
    /// Constants that take too much memory together.
    #[error(
        "the constants of all nodes up to `{node}` take more than {bytes} bytes: at most these are possible; use fewer nodes of `{texture}`, or put its large tables into images"
    )]
    TooManyConstants {
        /// The node.
        node: String,
        /// Its texture.
        texture: String,
        /// What is possible.
        bytes: usize,
    },
    /// A number that is no AO slot.
    #[error("`{node}` asks for AO slot {slot}: there are the slots 0 to 3")]
    OcclusionSlot {
        /// The node.
        node: String,
        /// The number.
        slot: u32,
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
