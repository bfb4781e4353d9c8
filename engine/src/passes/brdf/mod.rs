//! One vertex of every active path: emission, light sample, next direction. One thread per path.

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
    Kernel::new(gpu, &Source::of("brdf/brdf.wgsl"), "brdf", Trust::Engine)
}
