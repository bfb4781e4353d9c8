//! Writes what a window shows of a film to a texture. One thread per pixel.

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
        &Source::of("display/display.wgsl"),
        "display_film",
        Trust::Engine,
        &[],
    )
}
