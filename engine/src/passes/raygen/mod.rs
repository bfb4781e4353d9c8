//! Starts every path of a wave with a ray of the camera. One thread per path.

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
        &Source::of("raygen/entry.wgsl"),
        "raygen",
        Trust::Engine,
        &[],
    )
}
