//! Rays against the scene: the seam behind which other implementations may stand. One thread per ray.

use crate::gpu::{
    Gpu, GpuError,
    kernel::{Kernel, Trust},
    wgsl::Source,
};
use crate::gpu_scene::SceneFeatures;

/// Which rays are traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rays {
    /// The paths' rays, to their closest hit.
    Closest,
    /// The shadow rays, to any hit.
    Occlusion,
}

/// Compiles the kernel for what the scene uses.
///
/// # Errors
/// If the driver refuses it.
pub fn kernel(gpu: &Gpu, rays: Rays, features: &SceneFeatures) -> Result<Kernel, GpuError> {
    let entry = match rays {
        Rays::Closest => "traverse_closest",
        Rays::Occlusion => "traverse_occlusion",
    };
    Kernel::new(
        gpu,
        &Source::of("traverse/entry.wgsl"),
        entry,
        Trust::Engine,
        &features.constants(),
    )
}
