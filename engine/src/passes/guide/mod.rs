//! Keeps what the camera's rays hit first: distance, material, instance and normal of each pixel. One thread per path.

use crate::gpu::{
    Gpu, GpuError,
    kernel::{Kernel, Trust},
    wgsl::Source,
};

/// Compiles the kernel.
///
/// # Errors
/// If the driver refuses it.
pub fn kernel(gpu: &Gpu) -> Result<Kernel, GpuError> {
    Kernel::new(
        gpu,
        &Source::of("guide/guide.wgsl"),
        "guide",
        Trust::Engine,
        &[],
    )
}
