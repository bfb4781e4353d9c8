//! Writes what a window shows of a film to a texture. One thread per pixel.

use device::{Device, DeviceError, Kernel, Trust};

use crate::passes::wgsl::ComposedWgsl;

/// The file below `passes/` that its text begins with.
pub const FILE: &str = "display/display.wgsl";

/// Compiles the kernel.
///
/// # Errors
/// If the driver refuses it.
pub fn kernel(device: &Device) -> Result<Kernel, DeviceError> {
    ComposedWgsl::of(FILE).compile(device, "display_film", Trust::All, &[])
}
