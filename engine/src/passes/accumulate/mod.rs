//! Adds the paths of a wave to the film. One thread per pixel.

use super::pass::{Pass, Work};

/// The pass.
pub const PASS: Pass = Pass {
    name: "accumulate",
    file: "accumulate/entry.wgsl",
    work: Work::Paths,
    reads: &["frame", "paths", "rays"],
    writes: &["film0", "film1", "film2", "film3", "film4", "queues"],
    ..Pass::COMMON
};
