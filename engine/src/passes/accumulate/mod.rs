//! Adds the paths of a wave to the film. One thread per pixel.

use crate::gpu::{
    Gpu, GpuError,
    kernel::{Kernel, Trust},
    wgsl::Source,
};
use crate::gpu_scene::SceneFeatures;

/// Compiles the kernel.
///
/// # Errors
/// If the driver refuses it.
pub fn kernel(gpu: &Gpu, features: &SceneFeatures) -> Result<Kernel, GpuError> {
    Kernel::new(
        gpu,
        &Source::of("accumulate/entry.wgsl"),
        "accumulate",
        Trust::Engine,
        &features.constants(),
    )
}
