//! Rays against the scene: the seam behind which other implementations may stand, as
//! [`host_traversal`](crate::gpu_scene::host_traversal) does. One thread per ray.

use crate::wave::Queue;

use super::pass::{Pass, Work};

/// Which rays are traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rays {
    /// The paths' rays, to their closest hit.
    Closest,
    /// The shadow rays, to any hit.
    Occlusion,
}

/// The paths' rays.
pub const CLOSEST: Pass = Pass {
    name: "traverse_closest",
    file: "traverse/entry.wgsl",
    work: Work::Queue(Queue::Active),
    reads: &[
        "frame",
        "image_layers",
        "image_layers_srgb",
        "image_table",
        "instances",
        "materials",
        "nodes",
        "paths",
        "queues",
        "triangles",
        "vertices",
    ],
    writes: &["rays"],
    ..Pass::COMMON
};

/// The shadow rays.
pub const OCCLUSION: Pass = Pass {
    name: "traverse_occlusion",
    work: Work::Queue(Queue::Shadow),
    reads: GEOMETRY,
    writes: &["paths", "rays"],
    ..CLOSEST
};

const GEOMETRY: &[&str] = &[
    "frame",
    "image_layers",
    "image_layers_srgb",
    "image_table",
    "instances",
    "materials",
    "nodes",
    "queues",
    "triangles",
    "vertices",
];

impl Rays {
    /// The pass that traces them.
    pub fn pass(self) -> &'static Pass {
        match self {
            Self::Closest => &CLOSEST,
            Self::Occlusion => &OCCLUSION,
        }
    }
}
