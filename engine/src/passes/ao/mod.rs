//! Traces ambient-occlusion rays.

use crate::gpu::{
    Gpu, GpuError,
    kernel::{Kernel, Trust},
    wgsl::Source,
};
use crate::gpu_scene::SceneFeatures;

/// The override constant that says whether a thread traces all rays of a hit, for this kernel and the one that sizes its
/// dispatch. A graphics card needs many threads, one for each ray. A processor has enough of them in the hits alone: there
/// one thread traces all rays of a hit, in packets of four (`packet.wgsl`).
pub(super) fn thread_per_hit(gpu: &Gpu) -> (&'static str, f64) {
    ("ao_thread_per_hit", f64::from(u8::from(gpu.is_cpu())))
}

/// Compiles the kernel for what the scene uses.
///
/// # Errors
/// If the driver refuses it.
pub fn kernel(gpu: &Gpu, features: &SceneFeatures) -> Result<Kernel, GpuError> {
    Kernel::new(
        gpu,
        &Source::of("ao/ao.wgsl"),
        "ao",
        Trust::Engine,
        &[&features.constants()[..], &[thread_per_hit(gpu)]].concat(),
    )
}
