//! Queues the hits whose material has a texture program, and those whose program wants ambient occlusion. One thread per active path.

use crate::wave::Queue;

use super::pass::{Pass, Work};

/// The pass.
pub const PASS: Pass = Pass {
    name: "classify",
    file: "classify/entry.wgsl",
    work: Work::Queue(Queue::Active),
    reads: &["frame", "materials", "programs", "triangles"],
    writes: &["paths", "queues", "rays"],
    exists: |features| features.programs,
};
