//! Adds the paths of a wave to the film. One thread per pixel.

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
        &Source::of("accumulate/accumulate.wgsl"),
        "accumulate",
        Trust::Engine,
        &[],
    )
}
