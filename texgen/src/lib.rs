//! User textures in WGSL to one procedural-texture kernel. Knows naga; knows neither wgpu nor the engine.

mod attribute;
mod diagnostic;
mod emit;
mod graph;
mod interface;
mod library;
mod program;
mod source_map;
mod suggest;
mod swizzle;
mod texture;
mod value;

pub use attribute::{Attribute, BUILTIN_ATTRIBUTES, BuiltinAttribute, GLOBALS, Global};
pub use diagnostic::{Diagnostic, Diagnostics, Label, Location, Severity, SourceFile};
pub use emit::{GeneratedKernel, HOST_STUB};
pub use graph::{Edit, Graph, GraphError, NodeId};
pub use interface::{Parameter, Widget};
pub use library::Library;
pub use program::{Program, link_word};
pub use source_map::SourceMap;
pub use suggest::did_you_mean;
pub use swizzle::{Swizzle, SwizzleError};
pub use texture::TextureType;
pub use value::{
    ElementType, Interpolation, OutputType, ParameterType, Ramp, Value, color_from_hex,
};
