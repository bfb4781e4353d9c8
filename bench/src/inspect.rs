//! What the kernels that are compared ask for, and what a driver says of them.

use device::gpu::statistics::{Inspector, KernelStatistics};
use device::{Device, KernelText};
use engine::renderer::Renderer;

/// Asks a driver about the kernels of renderers.
#[derive(Debug)]
pub struct Inspection {
    inspector: Result<Inspector, String>,
}

impl Inspection {
    /// For kernels of this device. `other`: of another Vulkan device, by a part of its name. Its driver compiles the same
    /// kernels; some drivers do so for hardware that isn't there.
    pub fn new(device: &Device, other: Option<&str>) -> Self {
        let own = device.description();
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
    pub fn of(&self, renderer: &Renderer) -> KernelStatistics {
        let said = self.inspector.as_ref().ok().and_then(|inspector| {
            let text = renderer.texture_kernel_text().ok()??;
            inspector.inspect(&text).ok()
        });
        said.unwrap_or_default()
    }
}

/// Bytes of private memory that a thread of the kernel with the textures asks for, by the kernel's types: see
/// [`texgen::kernel_private_bytes`]. 0 where no kernel has textures in it, as for gray where they have a pass of their own.
pub fn private_bytes(renderer: &Renderer) -> u32 {
    let text = renderer.texture_kernel_text().ok().flatten();
    text.and_then(|text| bytes_of(&text)).unwrap_or(0)
}

/// None for a text that is not valid.
fn bytes_of(kernel: &KernelText) -> Option<u32> {
    let mut module = naga::front::wgsl::parse_str(kernel.text.wgsl()).ok()?;
    kernel.text.adapt(&mut module);
    let flags = naga::valid::ValidationFlags::all();
    let capabilities = kernel.text.capabilities() | naga::valid::Capabilities::RAY_QUERY;
    let validated = naga::valid::Validator::new(flags, capabilities).validate(&module);
    let mut entries = module.entry_points.iter();
    let index = entries.position(|entry| entry.name == kernel.entry)?;
    let info = validated.ok()?;
    let uses = info.get_entry_point(index);
    let entry = &module.entry_points[index];
    Some(texgen::kernel_private_bytes(&module, uses, entry))
}
