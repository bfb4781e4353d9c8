//! User textures in WGSL to one procedural-texture kernel. Knows naga; knows neither wgpu nor the engine.

mod args;
mod attribute;
mod diagnostic;
mod emit;
mod graph;
mod interface;
mod library;
mod literal;
mod metadata;
mod parse;
mod program;
mod reads;
mod refuse;
mod rewrite;
mod schedule;
mod scope;
mod signature;
mod source_map;
mod suggest;
mod swizzle;
mod texture;
mod tokens;
mod value;

pub use attribute::{Attribute, BUILTIN_ATTRIBUTES, BuiltinAttribute, GLOBALS, Global};
pub use diagnostic::{Diagnostic, Diagnostics, Label, Location, Severity, SourceFile};
pub use emit::{GeneratedKernel, HOST_STUB, LOOP_LIMIT};
pub use graph::{Edit, Graph, GraphError, Link, NodeId};
pub use interface::{Parameter, Widget};
pub use library::Library;
pub use parse::PRELUDE;
pub use program::{Program, link_word};
pub use source_map::SourceMap;
pub use suggest::did_you_mean;
pub use swizzle::{Swizzle, SwizzleError};
pub use texture::TextureType;
pub use value::{
    ElementType, Interpolation, OutputType, ParameterType, Ramp, Value, color_from_hex,
};
