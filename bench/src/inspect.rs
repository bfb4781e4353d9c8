//! What a driver says about the kernels that are compared.

use device::Device;
use device::gpu::statistics::Inspector;
use device::gpu::statistics::KernelStatistics;

use super::forms::FormRenderer;

/// Asks a driver about the kernels of renderers.
#[derive(Debug)]
pub struct Inspection {
    inspector: Result<Inspector, String>,
}

impl Inspection {
    /// For kernels of this device. `other`: of another Vulkan device, by a part of its name. Its driver compiles the same
    /// kernels; some drivers do so for hardware that isn't there.
    pub fn new(gpu: &Device, other: Option<&str>) -> Self {
        let own = gpu.description();
        let is_vulkan = own.backend.eq_ignore_ascii_case("vulkan");
        Self {
            inspector: match other {
                Some(name) => Inspector::open(name),
                None if is_vulkan => Inspector::open(&own.name),
                None => Err(format!("{} tells nothing", own.backend)),
            },
        }
    }

    /// The device whose driver is asked.
    pub fn device(&self) -> Option<&str> {
        self.inspector.as_ref().ok().map(Inspector::device_name)
    }

    /// Why nothing is known, if that is so.
    pub fn absent(&self) -> Option<&str> {
        self.inspector.as_ref().err().map(String::as_str)
    }

    /// Of the kernel with the textures in it; nothing where there is none, or where the driver says nothing. What goes
    /// wrong here must not spoil a measurement, so it counts as nothing too.
    pub fn of(&self, renderer: &FormRenderer) -> KernelStatistics {
        let said = self.inspector.as_ref().ok().and_then(|inspector| {
            let text = renderer.kernel_text().ok()??;
            inspector.inspect(&text).ok()
        });
        said.unwrap_or_default()
    }
}
