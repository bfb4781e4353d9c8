//! A Vulkan device of our own that is opened for one thing: to compile kernels and be asked about them.

use std::ffi::{CStr, CString};

use ash::{ext, khr, vk};
use naga::back::spv;

use super::KernelStatistics;
use crate::{KernelText, Trust, kernel::Parsed};

/// An open device. Fields are dropped by hand: see [`Drop`].
pub(super) struct Device {
    name: String,
    /// Holds the loader, which the rest lives in.
    _loader: ash::Entry,
    instance: ash::Instance,
    device: ash::Device,
    /// None where a driver is only used to compile, in tests.
    properties: Option<khr::pipeline_executable_properties::Device>,
    /// The driver checks the bounds of buffers itself, so that kernels need not.
    is_robust: bool,
}

impl std::fmt::Debug for Device {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Device").finish_non_exhaustive()
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: all that was made of them has been destroyed, and they are used no more.
        unsafe {
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}

/// A pipeline with what it is made of, destroyed together.
struct Pipeline<'a> {
    device: &'a ash::Device,
    module: vk::ShaderModule,
    set_layout: vk::DescriptorSetLayout,
    layout: vk::PipelineLayout,
    pipeline: vk::Pipeline,
}

impl Drop for Pipeline<'_> {
    fn drop(&mut self) {
        // SAFETY: they belong to the device and nothing has used them; what isn't there is null, which is fine.
        unsafe {
            self.device.destroy_pipeline(self.pipeline, None);
            self.device.destroy_pipeline_layout(self.layout, None);
            self.device
                .destroy_descriptor_set_layout(self.set_layout, None);
            self.device.destroy_shader_module(self.module, None);
        }
    }
}

impl Device {
    /// Opens the device of this name if its driver can be asked.
    pub(super) fn open(name: &str) -> Result<Self, String> {
        Self::open_with(name, true)
    }

    fn open_with(name: &str, asks: bool) -> Result<Self, String> {
        // SAFETY: the loader is the system's Vulkan library, which wgpu has loaded as well.
        let loader = unsafe { ash::Entry::load() }.map_err(|error| error.to_string())?;
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_2);
        let info = vk::InstanceCreateInfo::default().application_info(&application);
        // SAFETY: the description is complete, and the instance is destroyed before the loader is unloaded.
        let instance = unsafe { loader.create_instance(&info, None) }.map_err(in_words)?;
        match open_device(&instance, name, asks) {
            Ok(opened) => Ok(Self {
                name: opened.name,
                _loader: loader,
                instance,
                device: opened.device,
                properties: opened.properties,
                is_robust: opened.is_robust,
            }),
            Err(reason) => {
                // SAFETY: nothing was made of it.
                unsafe { instance.destroy_instance(None) };
                Err(reason)
            }
        }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Compiles a kernel and asks for its statistics.
    pub(super) fn inspect(&self, kernel: &KernelText) -> Result<KernelStatistics, String> {
        let pipeline = self.pipeline(kernel)?;
        let Some(properties) = &self.properties else {
            return Ok(KernelStatistics::default());
        };
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline.pipeline);
        // SAFETY: the pipeline was made by this device with CAPTURE_STATISTICS, and the feature is on.
        let executables = unsafe { properties.get_pipeline_executable_properties(&info) };
        let executables = executables.map_err(in_words)?;
        let subgroup = executables.first().map_or(1, |first| first.subgroup_size);
        let mut all = Vec::new();
        for index in 0..executables.len() as u32 {
            let info = vk::PipelineExecutableInfoKHR::default()
                .pipeline(pipeline.pipeline)
                .executable_index(index);
            // SAFETY: as above.
            let said = unsafe { properties.get_pipeline_executable_statistics(&info) };
            all.extend(said.map_err(in_words)?.iter().map(figure));
        }
        Ok(KernelStatistics::new(all, subgroup))
    }

    fn pipeline(&self, kernel: &KernelText) -> Result<Pipeline<'_>, String> {
        let (words, bindings) = spirv(kernel, self.is_robust)?;
        let device = &self.device;
        let mut made = Pipeline {
            device,
            module: vk::ShaderModule::null(),
            set_layout: vk::DescriptorSetLayout::null(),
            layout: vk::PipelineLayout::null(),
            pipeline: vk::Pipeline::null(),
        };
        let entry = CString::new(kernel.entry).map_err(|error| error.to_string())?;
        let flags = match self.properties {
            Some(_) => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
            None => vk::PipelineCreateFlags::empty(),
        };
        // SAFETY: naga has validated the module and written it for this device; the layout has each binding that it
        // uses, with its type; all pointers live until the calls return.
        unsafe {
            let info = vk::ShaderModuleCreateInfo::default().code(&words);
            made.module = device.create_shader_module(&info, None).map_err(in_words)?;
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            let set_layout = device.create_descriptor_set_layout(&info, None);
            made.set_layout = set_layout.map_err(in_words)?;
            let set_layouts = [made.set_layout];
            let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts);
            made.layout = device
                .create_pipeline_layout(&info, None)
                .map_err(in_words)?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(made.module)
                .name(&entry);
            let info = vk::ComputePipelineCreateInfo::default()
                .flags(flags)
                .stage(stage)
                .layout(made.layout);
            let created = device.create_compute_pipelines(vk::PipelineCache::null(), &[info], None);
            let (mut created, error) = match created {
                Ok(pipelines) => (pipelines, None),
                Err((pipelines, error)) => (pipelines, Some(error)),
            };
            made.pipeline = created.pop().unwrap_or_default();
            match error {
                Some(error) => Err(in_words(error)),
                None => Ok(made),
            }
        }
    }
}

fn in_words(error: vk::Result) -> String {
    format!("Vulkan: {error}")
}

/// Name and value of a statistic.
fn figure(said: &vk::PipelineExecutableStatisticKHR<'_>) -> (String, f64) {
    let name = said.name_as_c_str().unwrap_or_default();
    let name = name.to_string_lossy().into_owned();
    // SAFETY: the format says which member has been written.
    let value = unsafe {
        match said.format {
            vk::PipelineExecutableStatisticFormatKHR::BOOL32 => f64::from(said.value.b32),
            vk::PipelineExecutableStatisticFormatKHR::INT64 => said.value.i64 as f64,
            vk::PipelineExecutableStatisticFormatKHR::UINT64 => said.value.u64 as f64,
            _ => said.value.f64,
        }
    };
    (name, value)
}

/// What [`open_device`] opens.
struct Opened {
    name: String,
    device: ash::Device,
    properties: Option<khr::pipeline_executable_properties::Device>,
    is_robust: bool,
}

/// Opens the device with all that kernels may need.
fn open_device(instance: &ash::Instance, name: &str, asks: bool) -> Result<Opened, String> {
    // SAFETY: the instance is alive; the handles that it gives are used with it alone.
    let devices = unsafe { instance.enumerate_physical_devices() }.map_err(in_words)?;
    let named = devices.into_iter().find_map(|physical| {
        // SAFETY: as above.
        let properties = unsafe { instance.get_physical_device_properties(physical) };
        let own = properties.device_name_as_c_str().unwrap_or_default();
        let own = own.to_string_lossy().into_owned();
        let fits = own.to_lowercase().contains(&name.to_lowercase())
            && properties.api_version >= vk::API_VERSION_1_2;
        fits.then_some((physical, own))
    });
    let Some((physical, name)) = named else {
        return Err(format!("Vulkan has no device `{name}`"));
    };
    // SAFETY: as above.
    let offered = unsafe { instance.enumerate_device_extension_properties(physical) };
    let offered = offered.map_err(in_words)?;
    let offers = |extension: &CStr| {
        let mut names = offered.iter().map(|e| e.extension_name_as_c_str());
        names.any(|name| name == Ok(extension))
    };
    let ask = khr::pipeline_executable_properties::NAME;
    if asks && !offers(ask) {
        return Err("this driver says nothing about its kernels".to_owned());
    }
    // As wgpu opens it, as far as that changes the kernels' code.
    let is_robust = offers(ext::robustness2::NAME);
    let traces_rays = offers(khr::ray_query::NAME) && offers(khr::acceleration_structure::NAME);
    let mut extensions = Vec::new();
    if asks {
        extensions.push(ask.as_ptr());
    }
    if is_robust {
        extensions.push(ext::robustness2::NAME.as_ptr());
    }
    if traces_rays {
        extensions.extend([
            khr::ray_query::NAME.as_ptr(),
            khr::acceleration_structure::NAME.as_ptr(),
            khr::deferred_host_operations::NAME.as_ptr(),
        ]);
    }
    let mut statistics = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
        .pipeline_executable_info(true);
    let mut robustness = vk::PhysicalDeviceRobustness2FeaturesEXT::default()
        .robust_buffer_access2(true)
        .robust_image_access2(true);
    let mut addresses =
        vk::PhysicalDeviceBufferDeviceAddressFeatures::default().buffer_device_address(true);
    let mut structures =
        vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default().acceleration_structure(true);
    let mut queries = vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true);
    let features = vk::PhysicalDeviceFeatures::default().robust_buffer_access(true);
    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(0)
        .queue_priorities(&priorities)];
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .enabled_features(&features);
    if asks {
        info = info.push_next(&mut statistics);
    }
    if is_robust {
        info = info.push_next(&mut robustness);
    }
    if traces_rays {
        info = info
            .push_next(&mut addresses)
            .push_next(&mut structures)
            .push_next(&mut queries);
    }
    // SAFETY: extensions and features are those that the device offers; all pointers live until the call returns.
    let device = unsafe { instance.create_device(physical, &info, None) }.map_err(in_words)?;
    let properties = asks.then(|| {
        let device = &device;
        khr::pipeline_executable_properties::Device::new(instance, device)
    });
    Ok(Opened {
        name,
        device,
        properties,
        is_robust,
    })
}

type Bindings = Vec<vk::DescriptorSetLayoutBinding<'static>>;

/// The kernel for Vulkan 1.2, with the checks that wgpu would put into it, and what it binds.
fn spirv(kernel: &KernelText, is_robust: bool) -> Result<(Vec<u32>, Bindings), String> {
    let source = kernel.source();
    let capabilities = naga::valid::Capabilities::RAY_QUERY;
    let parsed = Parsed::new(&source, capabilities).map_err(|error| error.to_string())?;
    let constants = parsed.declared(source.constants);
    let constants = constants.map(|(name, value)| (name.to_owned(), value));
    let stage = naga::ShaderStage::Compute;
    let (module, info) = naga::back::pipeline_constants::process_overrides(
        &parsed.module,
        &parsed.info,
        Some((stage, kernel.entry)),
        &constants.collect(),
    )
    .map_err(|error| error.to_string())?;

    let checks = kernel.trust != Trust::All;
    let restrict = |is_on| match is_on {
        true => naga::proc::BoundsCheckPolicy::Restrict,
        false => naga::proc::BoundsCheckPolicy::Unchecked,
    };
    let options = spv::Options {
        lang_version: (1, 5),
        flags: spv::WriterFlags::empty(),
        bounds_check_policies: naga::proc::BoundsCheckPolicies {
            index: restrict(checks),
            buffer: restrict(checks && !is_robust),
            image_load: restrict(checks && !is_robust),
            binding_array: naga::proc::BoundsCheckPolicy::Unchecked,
        },
        force_loop_bounding: kernel.trust == Trust::Nothing,
        ray_query_initialization_tracking: checks,
        emit_int_div_checks: checks,
        ..spv::Options::default()
    };
    let entry = spv::PipelineOptions {
        shader_stage: stage,
        entry_point: kernel.entry.to_owned(),
    };
    let words = spv::write_vec(&module, &info, &options, Some(&entry));
    let words = words.map_err(|error| error.to_string())?;

    let index = (module.entry_points.iter()).position(|e| e.name == kernel.entry);
    let uses = info.get_entry_point(index.unwrap_or(0));
    let globals = module.global_variables.iter();
    let bindings = globals.filter(|(handle, _)| !uses[*handle].is_empty());
    let bindings = bindings.filter_map(|(_, global)| {
        let binding = global.binding.as_ref()?.binding;
        let kind = match (global.space, &module.types[global.ty].inner) {
            (naga::AddressSpace::Uniform, _) => vk::DescriptorType::UNIFORM_BUFFER,
            (naga::AddressSpace::Storage { .. }, _) => vk::DescriptorType::STORAGE_BUFFER,
            (_, naga::TypeInner::AccelerationStructure { .. }) => {
                vk::DescriptorType::ACCELERATION_STRUCTURE_KHR
            }
            _ => vk::DescriptorType::SAMPLED_IMAGE,
        };
        let layout = vk::DescriptorSetLayoutBinding::default()
            .binding(binding)
            .descriptor_type(kind)
            .descriptor_count(1)
            .stage_flags(vk::ShaderStageFlags::COMPUTE);
        Some(layout)
    });
    Ok((words, bindings.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    const KERNEL: &str = "
        override factor: u32 = 1;
        @group(0) @binding(0) var<storage, read_write> numbers: array<u32>;
        @compute @workgroup_size(64)
        fn scale(@builtin(global_invocation_id) id: vec3u) {
            numbers[id.x] *= factor;
        }";

    /// Whatever the driver tells, it compiles a kernel of ours from our SPIR-V.
    #[test]
    fn the_driver_takes_a_kernel() {
        let adapters = crate::Device::all();
        let Some(adapter) = adapters
            .iter()
            .find(|a| a.backend.eq_ignore_ascii_case("vulkan"))
        else {
            eprintln!("skipped: there is no Vulkan device");
            return;
        };
        let kernel = KernelText {
            text: Arc::new(KERNEL),
            entry: "scale",
            trust: Trust::Nothing,
            constants: vec![("factor", 3.0), ("not_there", 1.0)],
        };
        let compiles = Device::open_with(&adapter.name, false)
            .and_then(|device| device.inspect(&kernel))
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(compiles, KernelStatistics::default(), "nobody has asked");
        match Device::open(&adapter.name) {
            Ok(device) => {
                let said = device.inspect(&kernel);
                let said = said.unwrap_or_else(|error| panic!("{error}"));
                assert!(!said.all.is_empty());
            }
            Err(reason) => eprintln!("skipped: {reason}"),
        }
    }
}
