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

/// The override constant that says whether a thread traces all rays of a hit, for this kernel and the one that sizes its
/// dispatch. A graphics card needs many threads, one for each ray. A processor has enough of them in the hits alone: there
/// one thread traces all rays of a hit, in packets of four (`packet.wgsl`).
pub(super) fn thread_per_hit(device: &Device) -> (&'static str, f64) {
    let is_packet = device.traits().traces_packets;
    ("ao_thread_per_hit", f64::from(u8::from(is_packet)))
}
