//! Queues the hits whose material has a texture program, and those whose program wants ambient occlusion. One thread per active path.

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
        &Source::of("classify/entry.wgsl"),
        "classify",
        Trust::Engine,
        &features.constants(),
    )
}
