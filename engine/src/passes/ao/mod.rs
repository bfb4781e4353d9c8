//! Traces ambient-occlusion rays.

use device::Device;

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
    ..Pass::COMMON
};

/// The override constants that say whether a thread traces all rays of a hit, for this kernel and the one that sizes its
/// dispatch, and whether in packets of four (`packet.wgsl`). A graphics card needs many threads, one for each ray. A
/// processor has enough of them in the hits alone.
pub(super) fn constants(device: &Device) -> [(&'static str, f64); 2] {
    let traits = device.traits();
    let per_hit = traits.traces_packets || traits.runs_threads_in_turn;
    let value = |is: bool| f64::from(u8::from(is));
    [
        ("ao_thread_per_hit", value(per_hit)),
        ("ao_packets", value(traits.traces_packets)),
    ]
}
