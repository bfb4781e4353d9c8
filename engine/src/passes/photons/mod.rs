//! A map of photons: light that mirrors and bodies of glass throw on other surfaces. See `records.wgsl`; what photons carry and how
//! their radii shrink, `renderer/photons.rs` says.

use bytemuck::{Pod, Zeroable};
use device::Device;
use glam::Vec4;

use crate::{gpu_scene::MOST_TARGETS, wave::Queue};

use super::pass::{Pass, Work};

/// What the passes are told; the twin of `settings.wgsl`, which says what the members are.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[expect(missing_docs, reason = "its twin has them")]
pub struct PhotonSettings {
    pub mode: u32,
    pub photons: u32,
    pub field: u32,
    pub seed: u32,
    pub radius: f32,
    pub nearest: f32,
    pub cell_mask: u32,
    pub references: u32,
    pub light_count: u32,
    pub directional_count: u32,
    pub environment: u32,
    pub target_count: u32,
    pub targets: [Vec4; MOST_TARGETS],
}

/// Bytes of so many photons: a header of four words, then eight words each.
pub const fn bytes_of_photons(count: u64) -> u64 {
    16 + 32 * count
}

/// Bytes of so many cells of the grid: a header as large as a cell, then two words each.
pub const fn bytes_of_grid(count: u64) -> u64 {
    8 + 8 * count
}

/// Bytes of so many cells of the octree: a header as large as a cell, then four words each.
pub const fn bytes_of_cells(count: u64) -> u64 {
    16 + 16 * count
}

/// Takes caustics from the map. One thread per path.
pub const GATHER: Pass = Pass {
    name: "gather_photons",
    file: "photons/gather.wgsl",
    work: Work::Queue(Queue::Active),
    reads: &[
        "frame",
        "photon_cells",
        "photon_grid",
        "photon_lights",
        "photon_references",
        "photon_settings",
        "photons",
        "queues",
    ],
    writes: &["paths"],
    exists: |features| features.photons,
};

/// In place of the camera's rays: photons at their lamps.
pub const START: Pass = Pass {
    name: "photon_start",
    file: "photons/emit.wgsl",
    work: Work::Paths,
    reads: &[
        "environment_image",
        "environment_table",
        "frame",
        "instances",
        "lights",
        "materials",
        "photon_lights",
        "photon_settings",
        "triangles",
    ],
    writes: &["paths", "queues", "rays"],
    ..GATHER
};

/// Sends them off, once it is known what their lamps emit.
pub const EMIT: Pass = Pass {
    name: "photon_emit",
    work: Work::Queue(Queue::Active),
    reads: &[
        "frame",
        "image_layers",
        "image_layers_srgb",
        "image_table",
        "instances",
        "materials",
        "photon_settings",
        "triangles",
        "vertices",
    ],
    ..START
};

/// Notes those that come from casters, where they arrive.
pub const ARRIVE: Pass = Pass {
    name: "photon_arrive",
    file: "photons/fly.wgsl",
    reads: &[
        "frame",
        "image_layers",
        "image_layers_srgb",
        "image_table",
        "instances",
        "materials",
        "photon_settings",
        "queues",
        "rays",
        "triangles",
        "vertices",
    ],
    writes: &["paths"],
    ..GATHER
};

/// Keeps them, and ends them at whatever isn't a caster.
pub const FOLLOW: Pass = Pass {
    name: "photon_follow",
    file: "photons/fly.wgsl",
    reads: &["frame", "materials", "photon_settings", "queues"],
    writes: &["paths", "photons_arrived", "rays"],
    ..GATHER
};

/// About how much light goes from each lamp to what throws caustics. One thread per light; this and the following are no passes of a
/// wave.
pub const WEIGH: Pass = Pass {
    name: "weigh_lights",
    file: "photons/lights.wgsl",
    work: Work::Paths,
    reads: &[
        "environment_image",
        "environment_table",
        "frame",
        "lights",
        "materials",
        "photon_settings",
        "triangles",
    ],
    writes: &["photon_lights"],
    ..GATHER
};

/// Adds that up. One thread.
pub const SUM: Pass = Pass {
    name: "sum_lights",
    work: Work::Single,
    reads: &["photon_settings"],
    ..WEIGH
};

/// How many photons are in each cell of the grid. One thread per photon.
pub const COUNT_PHOTONS: Pass = Pass {
    name: "count_photons",
    file: "photons/sort.wgsl",
    work: Work::Paths,
    reads: &["frame", "photon_settings", "photons_arrived"],
    writes: &["photon_grid"],
    ..GATHER
};

/// Gives each cell a place for its photons. One thread per cell.
pub const GIVE_PHOTONS: Pass = Pass {
    name: "give_photons",
    reads: &["photon_settings"],
    ..COUNT_PHOTONS
};

/// Puts them there. One thread per photon.
pub const SORT_PHOTONS: Pass = Pass {
    name: "sort_photons",
    writes: &["photon_grid", "photons"],
    ..COUNT_PHOTONS
};

/// Splits cells that had too many references, and empties all. One thread per cell.
pub const SPLIT: Pass = Pass {
    name: "split_cells",
    file: "photons/map.wgsl",
    work: Work::Paths,
    reads: &["photon_settings"],
    writes: &["photon_cells"],
    ..GATHER
};

/// References to the leaves that photons reach into. One thread per photon.
pub const COUNT: Pass = Pass {
    name: "count_leaves",
    reads: &["frame", "photon_settings", "photons"],
    writes: &["photon_cells", "photon_references"],
    ..SPLIT
};

/// Splits none where there is no room for so many. One thread per cell.
pub const JOIN: Pass = Pass {
    name: "join_cells",
    ..SPLIT
};

/// Counts anew then. One thread per photon.
pub const COUNT_AGAIN: Pass = Pass {
    name: "count_again",
    ..COUNT
};

/// Gives each leaf its place among the references. One thread per cell.
pub const PLACES: Pass = Pass {
    name: "give_places",
    ..SPLIT
};

/// Writes them down. One thread per photon.
pub const PUT_DOWN: Pass = Pass {
    name: "put_down",
    ..COUNT
};

/// Whether photons are looked up in the grid, and there is no octree: `records.wgsl` says why.
pub fn are_found_by_grid(device: &Device) -> bool {
    device.traits().runs_threads_in_turn
}

/// What a thread of the map's kernels is there for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Each {
    /// A photon.
    Photon,
    /// A cell of the grid, or of the octree: of either there are as many.
    Cell,
}

/// What sorts photons by the cells of a grid, which is empty, in this order.
pub const GRID: [(&Pass, Each); 3] = [
    (&COUNT_PHOTONS, Each::Photon),
    (&GIVE_PHOTONS, Each::Cell),
    (&SORT_PHOTONS, Each::Photon),
];

/// What makes the octree of photons that are sorted, in this order.
pub const OCTREE: [(&Pass, Each); 6] = [
    (&SPLIT, Each::Cell),
    (&COUNT, Each::Photon),
    (&JOIN, Each::Cell),
    (&COUNT_AGAIN, Each::Photon),
    (&PLACES, Each::Cell),
    (&PUT_DOWN, Each::Photon),
];

/// What is no pass of a wave.
pub static APART: [&Pass; 11] = [
    &WEIGH,
    &SUM,
    &COUNT_PHOTONS,
    &GIVE_PHOTONS,
    &SORT_PHOTONS,
    &SPLIT,
    &COUNT,
    &JOIN,
    &COUNT_AGAIN,
    &PLACES,
    &PUT_DOWN,
];
