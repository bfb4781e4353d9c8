//! Traces ambient-occlusion rays. One thread per ray.

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
    Kernel::new(gpu, &Source::of("ao/ao.wgsl"), "ao", Trust::Engine)
}
