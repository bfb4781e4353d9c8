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
    let source = Source::of("raygen/entry.wgsl");
    // Sampler, filter and lens are branches on uniforms: lavapipe of Mesa 22 compiled this kernel again for each dispatch,
    // specialised to the uniforms of the moment. It leaves storage buffers alone.
    let source = match gpu.is_cpu() {
        true => source.with_storage("frame"),
        false => source,
    };
    Kernel::new(gpu, &source, "raygen", Trust::Engine, &[])
}
