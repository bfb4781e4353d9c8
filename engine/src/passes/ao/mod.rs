//! Traces ambient-occlusion rays.

use crate::wave::Queue;

use super::pass::{Pass, Work};

/// The pass.
pub const PASS: Pass = Pass {
    name: "ao",
    file: "ao/ao.wgsl",
    work: Work::Queue(Queue::Ao),
    reads: &[
        "ao_tables",
        "frame",
        "image_layers",
        "image_layers_srgb",
        "image_table",
        "instances",
        "materials",
        "nodes",
        "paths",
        "rays",
        "triangles",
        "vertices",
    ],
    writes: &["queues"],
    exists: |features| features.programs,
};
