//! Writes what a window shows of a film to a texture. One thread per pixel.

use device::{Device, DeviceError, Kernel, Trust};

use crate::passes::wgsl::ComposedWgsl;

/// Compiles the kernel.
///
/// # Errors
/// If the driver refuses it.
pub fn kernel(device: &Device) -> Result<Kernel, DeviceError> {
    ComposedWgsl::of("display/display.wgsl").compile(device, "display_film", Trust::All, &[])
}
