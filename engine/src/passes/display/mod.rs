//! Writes what a window shows of a film to a texture, and mixes a film's lights before. One thread per pixel.

use device::{Device, DeviceError, Kernel, Trust};

use crate::passes::wgsl::ComposedWgsl;

/// The file below `passes/` that its text begins with.
pub const FILE: &str = "display/display.wgsl";

/// The same of the kernel that mixes lights.
pub const MIX: &str = "display/mix.wgsl";

/// Compiles the kernel.
///
/// # Errors
/// If the driver refuses it.
pub fn kernel(device: &Device) -> Result<Kernel, DeviceError> {
    ComposedWgsl::of(FILE).compile(device, "display_film", Trust::All, &[])
}

/// Compiles the kernel that mixes lights.
///
/// # Errors
/// If the driver refuses it.
pub fn mixing_kernel(device: &Device) -> Result<Kernel, DeviceError> {
    ComposedWgsl::of(MIX).compile(device, "mix_group", Trust::All, &[])
}
