//! Traces ambient-occlusion rays.

use crate::gpu::{
    Gpu, GpuError,
    kernel::{Kernel, Trust},
    wgsl::Source,
};
use crate::gpu_scene::SceneFeatures;

/// The override constant that says how many of a hit's rays a thread traces, for this kernel and the one that sizes its
/// dispatch. A graphics card needs many threads. A processor has enough of them in the hits alone: there one thread
/// traces all rays of a hit, so that the hit is looked up once and its rays' lengths even out over the lanes of a
/// vector.
pub(super) fn rays_per_thread(gpu: &Gpu) -> (&'static str, f64) {
    let rays = if gpu.is_cpu() { 256 } else { 1 };
    ("ao_rays_per_thread", f64::from(rays))
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
        &[&features.constants()[..], &[rays_per_thread(gpu)]].concat(),
    )
}
