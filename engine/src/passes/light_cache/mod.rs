//! A cache of the light that surfaces scatter, which paths end in. See `cells.wgsl`; where it is used and what it costs in truth,
//! `renderer/light_cache.rs` says.

use crate::wave::Queue;

use super::pass::{Pass, Work};

/// Ends paths, or notes where they go on. One thread per path.
pub const LOOK_UP: Pass = Pass {
    name: "look_up_light",
    file: "light_cache/look_up.wgsl",
    work: Work::Queue(Queue::Active),
    reads: &[
        "frame",
        "instances",
        "light_cache_settings",
        "materials",
        "queues",
        "rays",
        "triangles",
        "vertices",
    ],
    writes: &["light_cache", "paths"],
    exists: |features| features.light_cache,
};

/// Notes what paths have found before a cell, after their vertex in it.
pub const NOTE: Pass = Pass {
    name: "note_light",
    file: "light_cache/learn.wgsl",
    reads: &["frame", "light_cache_settings", "queues"],
    writes: &["light_cache", "paths"],
    ..LOOK_UP
};

/// Adds to the cells what paths have found since.
pub const LEARN: Pass = Pass {
    name: "learn_light",
    work: Work::Paths,
    reads: &["frame", "light_cache_settings", "rays"],
    writes: &["light_cache", "paths"],
    ..NOTE
};
