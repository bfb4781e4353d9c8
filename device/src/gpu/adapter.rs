//! Which adapters there are, and which of them is meant.

use crate::{Device, DeviceChoice, DeviceDescription, DeviceError};

/// Storage buffers per stage that kernels need.
const REQUIRED_STORAGE_BUFFERS: u32 = 8;
/// Invocations per workgroup that kernels need.
const REQUIRED_INVOCATIONS: u32 = 64;
/// Bytes of one storage binding that kernels need at least.
const REQUIRED_STORAGE_BINDING: u64 = 1 << 27;

/// All adapters, the usual choice first, and the instance that knows them.
pub(super) fn by_preference() -> (wgpu::Instance, Vec<wgpu::Adapter>) {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    // wgpu's own checks of indirect dispatches cost a hidden pass each; our sizes are written by our own kernel.
    descriptor.flags = wgpu::InstanceFlags::empty();
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    adapters.sort_by_key(|a| match a.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    (instance, adapters)
}

/// By their numbers: the processor itself comes before the drivers that use it.
pub(super) fn describe(adapters: &[wgpu::Adapter]) -> Vec<DeviceDescription> {
    (adapters.iter().enumerate())
        .map(|(place, adapter)| {
            let is_processor = adapter.get_info().device_type == wgpu::DeviceType::Cpu;
            description(place + usize::from(is_processor), adapter)
        })
        .collect()
}

/// The adapter that is meant.
pub(super) fn choose(
    choice: &DeviceChoice,
) -> Result<(wgpu::Instance, wgpu::Adapter, DeviceDescription), DeviceError> {
    let (instance, adapters) = by_preference();
    let descriptions = describe(&adapters);
    let Some(place) = (descriptions.iter()).position(|device| choice.admits(device)) else {
        if descriptions.is_empty() && *choice == DeviceChoice::Driver {
            return Err(DeviceError::NoAdapter);
        }
        let available = Device::all()
            .iter()
            .map(|d| match &d.usable {
                Ok(()) => format!("  {}: {} ({}, {})", d.index, d.name, d.backend, d.driver),
                Err(why) => format!("  {}: {} (not usable: {why})", d.index, d.name),
            })
            .collect::<Vec<_>>()
            .join("\n");
        let wanted = choice.to_string();
        return Err(DeviceError::NotFound { wanted, available });
    };
    Ok((
        instance,
        adapters[place].clone(),
        descriptions[place].clone(),
    ))
}

fn description(index: usize, adapter: &wgpu::Adapter) -> DeviceDescription {
    let info = adapter.get_info();
    let limits = adapter.limits();
    let driver = format!("{} {}", info.driver, info.driver_info);
    DeviceDescription {
        index,
        name: info.name,
        backend: info.backend.to_string(),
        driver: driver.trim().to_owned(),
        device_type: device_type_name(info.device_type).to_owned(),
        is_processor: info.device_type == wgpu::DeviceType::Cpu,
        max_storage_binding: limits.max_storage_buffer_binding_size,
        max_buffer: limits.max_buffer_size,
        storage_buffers_per_stage: limits.max_storage_buffers_per_shader_stage,
        workgroup_invocations: limits.max_compute_invocations_per_workgroup,
        timestamps: adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY),
        ray_queries: (adapter.features()).contains(wgpu::Features::EXPERIMENTAL_RAY_QUERY),
        usable: usable(adapter, &limits),
    }
}

fn usable(adapter: &wgpu::Adapter, limits: &wgpu::Limits) -> Result<(), String> {
    let needs = wgpu::DownlevelFlags::COMPUTE_SHADERS
        | wgpu::DownlevelFlags::INDIRECT_EXECUTION
        | wgpu::DownlevelFlags::VIEW_FORMATS;
    if !adapter.get_downlevel_capabilities().flags.contains(needs) {
        return Err(
            "it lacks compute shaders, indirect dispatch or texture view formats".to_owned(),
        );
    }
    if limits.max_storage_buffers_per_shader_stage < REQUIRED_STORAGE_BUFFERS {
        return Err(format!(
            "a kernel can bind {} storage buffers, {REQUIRED_STORAGE_BUFFERS} are needed",
            limits.max_storage_buffers_per_shader_stage
        ));
    }
    if limits.max_compute_invocations_per_workgroup < REQUIRED_INVOCATIONS {
        return Err(format!(
            "workgroups hold {} threads, {REQUIRED_INVOCATIONS} are needed",
            limits.max_compute_invocations_per_workgroup
        ));
    }
    if limits.max_storage_buffer_binding_size < REQUIRED_STORAGE_BINDING {
        return Err(format!(
            "storage bindings hold {} bytes, {REQUIRED_STORAGE_BINDING} are needed",
            limits.max_storage_buffer_binding_size
        ));
    }
    Ok(())
}

fn device_type_name(kind: wgpu::DeviceType) -> &'static str {
    match kind {
        wgpu::DeviceType::DiscreteGpu => "discrete GPU",
        wgpu::DeviceType::IntegratedGpu => "integrated GPU",
        wgpu::DeviceType::VirtualGpu => "virtual GPU",
        wgpu::DeviceType::Cpu => "CPU",
        wgpu::DeviceType::Other => "other",
    }
}
