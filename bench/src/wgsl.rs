//! This crate's WGSL: roots of kernels, and what stands in them in the place of files of the engine's.

use engine::passes::wgsl::{ComposedWgsl, File};

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!($name))),*]
    };
}

/// The WGSL files of this crate, by their paths here; they include the engine's.
const FILES: &[File] = files![
    "gather/compare.wgsl",
    "inlined/inlined.wgsl",
    "inlined/traced_ao.wgsl",
    "rayquery/kernel.wgsl",
    "rayquery/path_memory.wgsl",
    "rayquery/plain.wgsl",
    "rayquery/queries.wgsl",
    "rayquery/textured.wgsl",
];

/// Composes a kernel whose root is one of this crate's files.
pub(crate) fn compose(file: &str) -> ComposedWgsl {
    ComposedWgsl::with_files(file, FILES)
}
