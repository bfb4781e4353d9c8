//! User textures in WGSL to one procedural-texture kernel.
//!
//! A user of the renderer writes the value of a texture at a hit as a WGSL function. This crate turns a set of such
//! files into the text of *one* kernel, and the way they are used into *data* for it:
//!
//! ```text
//! file ──> TextureType ──> Library ──────────────────> GeneratedKernel   changes when a file changes
//!                             └──> Graph ─┬─> Program                    changes when links change
//!                                         └─> fake stack (args)          changes when values change
//! ```
//!
//! - [`TextureType::parse`] checks a file and reads its interface: parameters, what they mean, what it returns, which
//!   attributes of the hit it reads. Everything that is wrong comes back as [`Diagnostics`] in the user's terms.
//! - A [`Library`] is the set of textures of one kernel; [`Library::emit`] writes the kernel's text. It has no bindings: the
//!   host puts it into one module with the functions listed in [`HOST_STUB`].
//! - A [`Graph`] has nodes, each a use of a texture with arguments: constants, which lie in a buffer called the *fake
//!   stack*, or links to other nodes. [`Graph::compile`] makes the [`Program`] that evaluates some nodes: words that the
//!   kernel interprets.
//!
//! So neither an edit of a value nor one of the wiring needs a shader to be built. The crate knows naga; it knows neither
//! wgpu nor the engine, and does no input or output.
//!
//! ```
//! use std::sync::Arc;
//! use texgen::{Graph, Library, SourceFile, TextureType, Value};
//!
//! let source = "fn userProc(scale: f32) -> vec4f { return readAttr(WorldPos) * scale; }";
//! let texture = TextureType::parse(SourceFile::new("stripes", "stripes.wgsl", source))?;
//! let library = Arc::new(Library::new(vec![texture])?);
//!
//! let mut graph = Graph::new(library.clone());
//! let a = graph.add_node("a", "stripes", [0, 0])?;
//! let b = graph.add_node("b", "stripes", [0, 0])?;
//! graph.set_value(a, "scale", Value::F32(3.0))?;
//! graph.set_link(b, "scale", a, Some("y".parse()?))?;
//!
//! let program = graph.compile(&[b])?;
//! let kernel = library.emit(program.slots_needed);
//! assert!(kernel.wgsl.contains("fn stripes__userProc(scale: f32)"));
//!
//! // An edit says which words of the fake stack to write again.
//! let edit = graph.set_value(a, "scale", Value::F32(4.0))?;
//! assert_eq!(graph.args()[edit.words[0].clone()], [4f32.to_bits()]);
//! assert!(!edit.program);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod args;
mod attribute;
pub mod diagnostic;
mod diagnostic_json;
mod emit;
mod graph;
mod graph_error;
mod guard;
mod habits;
mod inline;
mod interface;
mod libraries;
mod library;
mod literal;
mod memory_limit;
mod metadata;
mod nesting;
mod parse;
mod pointer_arguments;
mod prelude;
mod private_memory;
mod problem;
mod program;
mod reads;
mod recover;
mod refuse;
mod rewrite;
mod schedule;
mod scope;
mod signature;
mod source_map;
mod standard;
mod suggest;
mod swizzle;
mod texture;
mod texture_memory;
mod tokens;
mod try_out;
mod validation;
mod value;
mod verdict;
mod wording;

pub use attribute::{Attribute, BUILTIN_ATTRIBUTES, BuiltinAttribute, GLOBALS, Global, HOST_STUB};
pub use diagnostic::{Diagnostic, Diagnostics, Label, Location, Severity, SourceFile};
pub use emit::{GeneratedKernel, LOOP_LIMIT, RUN, is_call};
pub use graph::{DroppedValue, Edit, Graph, Link, NodeId};
pub use graph_error::GraphError;
pub use guard::guarded;
pub use inline::emit_inlined;
pub use interface::{NamedOutput, Parameter, Widget};
pub use libraries::used_libraries;
pub use library::Library;
pub use pointer_arguments::copy_pointer_arguments;
pub use prelude::PRELUDE;
pub use private_memory::kernel_private_bytes;
pub use program::{Instruction, Program, link_word};
pub use source_map::SourceMap;
pub use standard::standard_function;
pub use suggest::did_you_mean;
pub use swizzle::{Swizzle, SwizzleError};
pub use texture::TextureType;
pub use texture_memory::{FunctionMemory, PrivateMemory};
pub use value::{
    ElementType, Interpolation, OutputType, ParameterType, Ramp, Value, color_from_hex,
};
pub use verdict::CAPABILITIES;
