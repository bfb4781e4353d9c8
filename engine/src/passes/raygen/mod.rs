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
    // Where more than half of this kernel hangs on uniforms (it does: sampler, filter, lens), lavapipe of Mesa 22 compiles it
    // again for each dispatch, for the uniforms of the moment.
    let source = match gpu.is_cpu() {
        true => source.with_storage("frame"),
        false => source,
    };
    Kernel::new(gpu, &source, "raygen", Trust::Engine, &[])
}
