//! Traces ambient-occlusion rays. One thread per ray.

use crate::gpu::{
    Gpu, GpuError,
    kernel::{Kernel, Trust},
    wgsl::Source,
};
use crate::gpu_scene::SceneFeatures;

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
        &features.constants(),
    )
}
