//! One vertex of every active path: emission, light sample, next direction. One thread per path.

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
        &Source::of("brdf/entry.wgsl"),
        "brdf",
        Trust::Engine,
        &features.constants(),
    )
}
