//! The generated kernel's text.

use crate::library::Library;
use crate::source_map::SourceMap;

/// WGSL text without bindings, to be put into one module with the host's functions (see [`HOST_STUB`]).
#[derive(Clone, Debug)]
pub struct GeneratedKernel {
    /// The text.
    pub wgsl: String,
    /// From places in the text to places in the users' files.
    pub source_map: SourceMap,
}

/// What the host must supply in the same module, with bodies that do nothing: tests put it beside a generated
/// kernel to validate the whole.
pub const HOST_STUB: &str = include_str!("host_stub.wgsl");

pub(crate) fn emit(_library: &Library, stack_slots: u32) -> GeneratedKernel {
    let wgsl = format!(
        "var<private> patina_stack: array<vec4f, {}>;\n",
        stack_slots.max(1)
    );
    GeneratedKernel {
        wgsl,
        source_map: SourceMap::default(),
    }
}
