//! One vertex of every active path: emission, light sample, next direction. One thread per path.

use crate::wave::Queue;

use super::pass::{Pass, Work};

/// The pass.
pub const PASS: Pass = Pass {
    name: "brdf",
    file: "brdf/entry.wgsl",
    work: Work::Queue(Queue::Active),
    reads: &[
        "albedo_table",
        "environment_image",
        "environment_table",
        "facing_sky",
        "frame",
        "image_layers",
        "image_layers_srgb",
        "image_table",
        "instances",
        "known_sky",
        "lights",
        "materials",
        "triangles",
        "vertices",
    ],
    writes: &["paths", "queues", "rays"],
    ..Pass::COMMON
};
