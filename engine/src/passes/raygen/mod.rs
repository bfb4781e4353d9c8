//! Starts every path of a wave with a ray of the camera. One thread per path.

use super::pass::{Pass, Work};

/// The pass.
pub const PASS: Pass = Pass {
    name: "raygen",
    file: "raygen/entry.wgsl",
    work: Work::Paths,
    reads: &["filter_table", "frame"],
    writes: &["paths", "queues", "rays"],
    ..Pass::COMMON
};
