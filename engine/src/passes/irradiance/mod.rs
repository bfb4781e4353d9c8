//! A cache of irradiance: records of the light that surfaces scatter to a place, between which it is interpolated. See `records.wgsl`;
//! how records are found and made, `renderer/irradiance.rs` says.

use crate::wave::Queue;

use super::pass::{Pass, Work};

/// Takes what surfaces scatter diffusely from the records, or finds where there are none. One thread per path.
pub const LOOK_UP: Pass = Pass {
    name: "look_up_irradiance",
    file: "irradiance/look_up.wgsl",
    work: Work::Queue(Queue::Active),
    reads: &[
        "frame",
        "irradiance_grid",
        "irradiance_records",
        "irradiance_references",
        "irradiance_settings",
    ],
    writes: &["irradiance_candidates", "paths", "queues", "rays"],
    exists: |features| features.irradiance_cache,
};

/// Counts light samples of the sky, and those that arrive. One thread per shadow ray.
pub const LOOK: Pass = Pass {
    name: "look_for_sky",
    file: "irradiance/look.wgsl",
    work: Work::Queue(Queue::Shadow),
    reads: &[
        "environment_table",
        "facing_sky",
        "frame",
        "known_sky",
        "lights",
        "paths",
        "queues",
        "rays",
    ],
    writes: &["sky_seen"],
    exists: |features| features.light_cache,
};

/// In place of the camera's rays: those of records.
pub const START: Pass = Pass {
    name: "gather_start",
    file: "irradiance/gather.wgsl",
    work: Work::Paths,
    reads: &["frame", "irradiance_records", "irradiance_settings"],
    writes: &["paths", "queues", "rays"],
    ..LOOK_UP
};

/// Ends them where a cache knows what they have met, or where that is nothing.
pub const FIRST_HIT: Pass = Pass {
    name: "gather_first_hit",
    file: "irradiance/first_hit.wgsl",
    reads: &[
        "frame",
        "instances",
        "irradiance_settings",
        "light_cache_settings",
        "materials",
        "rays",
        "triangles",
        "vertices",
    ],
    writes: &["light_cache", "paths", "queues"],
    ..LOOK_UP
};

/// Forgets what the first surface emits.
pub const NOTE: Pass = Pass {
    name: "gather_note",
    file: "irradiance/gather.wgsl",
    reads: &["frame", "irradiance_settings", "queues"],
    writes: &["paths"],
    ..LOOK_UP
};

/// In place of the film: a list of what they have found.
pub const END: Pass = Pass {
    name: "gather_end",
    file: "irradiance/gather.wgsl",
    work: Work::Paths,
    reads: &["frame", "irradiance_settings", "rays"],
    writes: &["irradiance_gathered", "paths"],
    ..LOOK_UP
};

/// Makes records of it. One thread per record; no pass of a wave.
pub const SOLVE: Pass = Pass {
    name: "solve_irradiance",
    file: "irradiance/solve.wgsl",
    work: Work::Paths,
    reads: &["irradiance_gathered", "irradiance_settings"],
    writes: &["irradiance_records"],
    ..LOOK_UP
};
