//! Keeps what the camera's rays hit first: where it is, what it is and what it looks like. One thread per path.

use super::pass::{Pass, Work};

/// The pass.
pub const PASS: Pass = Pass {
    name: "guide",
    file: "guide/guide.wgsl",
    work: Work::Paths,
    reads: &[
        "frame",
        "image_layers",
        "image_layers_srgb",
        "image_table",
        "instances",
        "materials",
        "paths",
        "rays",
        "triangles",
        "vertices",
    ],
    writes: &["guides"],
    ..Pass::COMMON
};
