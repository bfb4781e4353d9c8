//! Hands queues from producers to consumers and sizes the dispatches that follow. One thread.

use crate::gpu::{
    Gpu, GpuError,
    kernel::{Kernel, Trust},
    wgsl::Source,
};

use super::ao;

/// Which kernel ran before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum After {
    /// `raygen`
    Raygen,
    /// `classify`
    Classify,
    /// `brdf`
    Brdf,
}

/// Compiles the kernel.
///
/// # Errors
/// If the driver refuses it.
pub fn kernel(gpu: &Gpu, after: After) -> Result<Kernel, GpuError> {
    let entry = match after {
        After::Raygen => "advance_start",
        After::Classify => "advance_texture",
        After::Brdf => "advance_bounce",
    };
    Kernel::new(
        gpu,
        &Source::of("advance/advance.wgsl"),
        entry,
        Trust::Engine,
        &[ao::thread_per_hit(gpu)],
    )
}
