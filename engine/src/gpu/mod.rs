//! The device: which adapters there are, one opened, and the errors that drivers report.
//!
//! Nothing here knows what is rendered.

pub mod cache;
pub mod kernel;
pub mod statistics;
pub mod timing;
pub mod wgsl;

use std::sync::{
    Arc, Mutex, OnceLock,
    atomic::{AtomicU64, Ordering},
};

/// Storage buffers per stage that the passes need.
const REQUIRED_STORAGE_BUFFERS: u32 = 8;
/// Invocations per workgroup that the passes need.
const REQUIRED_INVOCATIONS: u32 = 64;
/// Bytes of one storage binding that the passes need at least.
const REQUIRED_STORAGE_BINDING: u64 = 1 << 27;

/// What the device or its driver refused.
#[derive(Debug, Clone, thiserror::Error)]
pub enum GpuError {
    /// No adapter at all.
    #[error(
        "no graphics adapter was found; install a Vulkan driver (Debian/Ubuntu: `apt install mesa-vulkan-drivers libvulkan1`)"
    )]
    NoAdapter,
    /// The choice matches no usable device.
    #[error("no usable device matches `{wanted}`; there are:\n{available}")]
    NotFound {
        /// What was asked for.
        wanted: String,
        /// One adapter per line.
        available: String,
    },
    /// The driver would not open the device.
    #[error("the device `{name}` could not be opened: {reason}")]
    Open {
        /// Adapter.
        name: String,
        /// The driver's words.
        reason: String,
    },
    /// A kernel failed to build.
    #[error("kernel `{label}` failed to build:\n{message}")]
    Kernel {
        /// Kernel.
        label: String,
        /// Errors with file and line.
        message: String,
    },
    /// The driver refused a kernel that is valid WGSL.
    #[error("the graphics driver refused the kernel `{label}`:\n{message}")]
    Refused {
        /// Kernel.
        label: String,
        /// The driver's words, and what is known about the cause.
        message: String,
    },
    /// A buffer or texture is larger than the device allows.
    #[error("{what} needs {needed} bytes, but this device binds at most {limit}; {remedy}")]
    TooLarge {
        /// What does not fit.
        what: String,
        /// Bytes.
        needed: u64,
        /// Bytes.
        limit: u64,
        /// What to do.
        remedy: &'static str,
    },
    /// The device is gone, and all that was on it: open another one.
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// An error that the driver reported while working.
    #[error("the graphics driver reported an error: {0}")]
    Driver(String),
}

/// One adapter of the machine.
#[derive(Debug, Clone)]
pub struct AdapterDescription {
    /// Number to choose it by.
    pub index: usize,
    /// The driver's name for it.
    pub name: String,
    /// Vulkan, Metal or DX12.
    pub backend: String,
    /// Driver and its version.
    pub driver: String,
    /// `discrete GPU`, `integrated GPU`, `virtual GPU`, `CPU` or `other`.
    pub device_type: String,
    /// Bytes of the largest storage binding.
    pub max_storage_binding: u64,
    /// Bytes of the largest buffer.
    pub max_buffer: u64,
    /// Storage buffers that one kernel can bind.
    pub storage_buffers_per_stage: u32,
    /// Threads of the largest workgroup.
    pub workgroup_invocations: u32,
    /// Whether passes can be timed on the device.
    pub timestamps: bool,
    /// Whether kernels can trace rays in acceleration structures of the driver's.
    pub ray_queries: bool,
    /// Why it can't be used, if it can't.
    pub usable: Result<(), String>,
}

impl AdapterDescription {
    fn new(index: usize, adapter: &wgpu::Adapter) -> Self {
        let info = adapter.get_info();
        let limits = adapter.limits();
        let flags = adapter.get_downlevel_capabilities().flags;
        let needs = wgpu::DownlevelFlags::COMPUTE_SHADERS
            | wgpu::DownlevelFlags::INDIRECT_EXECUTION
            | wgpu::DownlevelFlags::VIEW_FORMATS;
        let usable = if !flags.contains(needs) {
            Err("it lacks compute shaders, indirect dispatch or texture view formats".to_owned())
        } else if limits.max_storage_buffers_per_shader_stage < REQUIRED_STORAGE_BUFFERS {
            Err(format!(
                "a kernel can bind {} storage buffers, {REQUIRED_STORAGE_BUFFERS} are needed",
                limits.max_storage_buffers_per_shader_stage
            ))
        } else if limits.max_compute_invocations_per_workgroup < REQUIRED_INVOCATIONS {
            Err(format!(
                "workgroups hold {} threads, {REQUIRED_INVOCATIONS} are needed",
                limits.max_compute_invocations_per_workgroup
            ))
        } else if limits.max_storage_buffer_binding_size < REQUIRED_STORAGE_BINDING {
            Err(format!(
                "storage bindings hold {} bytes, {REQUIRED_STORAGE_BINDING} are needed",
                limits.max_storage_buffer_binding_size
            ))
        } else {
            Ok(())
        };
        Self {
            index,
            name: info.name.clone(),
            backend: info.backend.to_string(),
            driver: format!("{} {}", info.driver, info.driver_info)
                .trim()
                .to_owned(),
            device_type: device_type_name(info.device_type).to_owned(),
            max_storage_binding: limits.max_storage_buffer_binding_size,
            max_buffer: limits.max_buffer_size,
            storage_buffers_per_stage: limits.max_storage_buffers_per_shader_stage,
            workgroup_invocations: limits.max_compute_invocations_per_workgroup,
            timestamps: adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY),
            ray_queries: adapter
                .features()
                .contains(wgpu::Features::EXPERIMENTAL_RAY_QUERY),
            usable,
        }
    }
}

/// Which adapter to open.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum DeviceChoice {
    /// Discrete before integrated before virtual before CPU.
    #[default]
    Best,
    /// By [`AdapterDescription::index`].
    Index(usize),
    /// The best whose name contains this, letter case ignored.
    Name(String),
}

/// An open device. Clones share it.
#[derive(Debug, Clone)]
pub struct Gpu {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    instance: wgpu::Instance,
    adapter: wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    description: AdapterDescription,
    is_cpu: bool,
    shader_modules_created: AtomicU64,
    pipelines_created: AtomicU64,
    first_error: Arc<Mutex<Option<String>>>,
    /// Why the device is gone, once it is.
    lost: Arc<OnceLock<String>>,
    cache: Option<cache::DiskCache>,
}

impl Gpu {
    /// All adapters of the machine, the usual choice first.
    pub fn adapters() -> Vec<AdapterDescription> {
        (adapters_by_preference().1)
            .iter()
            .enumerate()
            .map(|(i, a)| AdapterDescription::new(i, a))
            .collect()
    }

    /// Opens an adapter with everything that it offers.
    ///
    /// # Errors
    /// If there is none, none that fits the choice and the passes' needs, or the driver refuses.
    pub fn new(choice: &DeviceChoice) -> Result<Self, GpuError> {
        Self::with_cache(choice, None)
    }

    /// As [`Self::new`], with compiled pipelines read from a file in a folder, where the device offers that and a file is
    /// there; [`Self::save_cache`] writes it.
    ///
    /// # Errors
    /// As [`Self::new`]: a cache that can't be used is none.
    pub fn with_cache(
        choice: &DeviceChoice,
        folder: Option<&std::path::Path>,
    ) -> Result<Self, GpuError> {
        let (instance, adapter, description) = choose(choice)?;
        Self::open(instance, &adapter, description, folder, false)
    }

    /// As [`Self::new`], with ray queries where the adapter offers them: see [`Self::has_ray_queries`]. wgpu calls them
    /// experimental, so that only comparisons with them ask for this.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_ray_queries(choice: &DeviceChoice) -> Result<Self, GpuError> {
        let (instance, adapter, description) = choose(choice)?;
        let offers_them = description.ray_queries;
        Self::open(instance, &adapter, description, None, offers_them)
    }

    fn open(
        instance: wgpu::Instance,
        adapter: &wgpu::Adapter,
        description: AdapterDescription,
        cache_folder: Option<&std::path::Path>,
        ray_queries: bool,
    ) -> Result<Self, GpuError> {
        let mut features = wgpu::Features::TIMESTAMP_QUERY;
        features.set(wgpu::Features::PIPELINE_CACHE, cache_folder.is_some());
        features.set(wgpu::Features::EXPERIMENTAL_RAY_QUERY, ray_queries);
        let experimental_features = match ray_queries {
            // SAFETY: wgpu asks to be told that its ray queries may have faults. Nothing but the comparison with them
            // opens such a device; its kernel is our own, and wgpu checks the state of each query.
            true => unsafe { wgpu::ExperimentalFeatures::enabled() },
            false => wgpu::ExperimentalFeatures::disabled(),
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("patina"),
            required_features: adapter.features() & features,
            required_limits: adapter.limits(),
            experimental_features,
            ..Default::default()
        }))
        .map_err(|e| GpuError::Open {
            name: description.name.clone(),
            reason: e.to_string(),
        })?;
        let first_error = Arc::new(Mutex::new(None));
        let keep = |slot: &Arc<Mutex<Option<String>>>, message: String| {
            if let Ok(mut first) = slot.lock() {
                first.get_or_insert(message);
            }
        };
        let slot = Arc::clone(&first_error);
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| keep(&slot, e.to_string())));
        let lost = Arc::new(OnceLock::new());
        let slot = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            // Called once, and also when the last clone of the device is dropped.
            let _ = slot.set(match message.is_empty() {
                true => format!("{reason:?}"),
                false => message,
            });
        });
        let cache = cache_folder
            .and_then(|folder| cache::DiskCache::open(&device, &adapter.get_info(), folder));
        Ok(Self {
            shared: Arc::new(Shared {
                instance,
                adapter: adapter.clone(),
                cache,
                device,
                queue,
                is_cpu: adapter.get_info().device_type == wgpu::DeviceType::Cpu,
                description,
                shader_modules_created: AtomicU64::new(0),
                pipelines_created: AtomicU64::new(0),
                first_error,
                lost,
            }),
        })
    }

    /// Writes the pipelines compiled so far to the cache's file; nothing where there is no cache.
    ///
    /// # Errors
    /// The file can't be written. Nothing depends on it but the time of the next start.
    pub fn save_cache(&self) -> std::io::Result<()> {
        self.shared
            .cache
            .as_ref()
            .map_or(Ok(()), |cache| cache.save())
    }

    /// Whether compiled pipelines are kept in a file.
    pub fn has_cache(&self) -> bool {
        self.shared.cache.is_some()
    }

    /// Whether kernels can trace rays in acceleration structures, because that was asked for and is there.
    pub fn has_ray_queries(&self) -> bool {
        let features = self.device().features();
        features.contains(wgpu::Features::EXPERIMENTAL_RAY_QUERY)
    }

    /// What was opened.
    pub fn description(&self) -> &AdapterDescription {
        &self.shared.description
    }

    /// The instance that the device was opened by: a window makes its surface with it.
    pub fn instance(&self) -> &wgpu::Instance {
        &self.shared.instance
    }

    /// The adapter that was opened.
    pub fn adapter(&self) -> &wgpu::Adapter {
        &self.shared.adapter
    }

    /// The wgpu device.
    pub fn device(&self) -> &wgpu::Device {
        &self.shared.device
    }

    /// The wgpu queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.shared.queue
    }

    /// Whether the "GPU" is a software driver.
    pub fn is_cpu(&self) -> bool {
        self.shared.is_cpu
    }

    /// Shader modules created since the device was opened.
    pub fn shader_modules_created(&self) -> u64 {
        self.shared.shader_modules_created.load(Ordering::Relaxed)
    }

    /// Pipelines created since the device was opened.
    pub fn pipelines_created(&self) -> u64 {
        self.shared.pipelines_created.load(Ordering::Relaxed)
    }

    /// The first error that the driver has reported since the last call.
    ///
    /// # Errors
    /// That error.
    pub fn check(&self) -> Result<(), GpuError> {
        if let Some(message) = self.shared.lost.get() {
            return Err(GpuError::Lost(message.clone()));
        }
        match self.shared.first_error.lock() {
            Ok(mut first) => first
                .take()
                .map_or(Ok(()), |message| Err(GpuError::Driver(message))),
            Err(_) => Ok(()),
        }
    }

    /// Waits until the device has done all that was submitted.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.wait_until(wgpu::PollType::wait_indefinitely())
    }

    /// Waits until the device has done one submission; what others have submitted after it isn't waited for.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn wait_for(&self, submission: wgpu::SubmissionIndex) -> Result<(), GpuError> {
        self.wait_until(wgpu::PollType::Wait {
            submission_index: Some(submission),
            timeout: None,
        })
    }

    fn wait_until(&self, what: wgpu::PollType) -> Result<(), GpuError> {
        self.device()
            .poll(what)
            .map_err(|e| match self.shared.lost.get() {
                Some(message) => GpuError::Lost(message.clone()),
                None => GpuError::Driver(e.to_string()),
            })?;
        self.check()
    }

    /// Whether the device is gone.
    pub fn is_lost(&self) -> bool {
        // The driver tells while it is polled.
        let _ = self.device().poll(wgpu::PollType::Poll);
        self.shared.lost.get().is_some()
    }

    /// A buffer holding `contents`, or one spare word where it is empty (bindings can't be empty).
    ///
    /// # Errors
    /// If it is larger than one binding of this device.
    pub fn storage_buffer(&self, label: &str, contents: &[u8]) -> Result<wgpu::Buffer, GpuError> {
        let buffer =
            self.empty_buffer(label, contents.len() as u64, wgpu::BufferUsages::STORAGE)?;
        if !contents.is_empty() {
            self.queue().write_buffer(&buffer, 0, contents);
        }
        Ok(buffer)
    }

    /// A zeroed buffer of at least 16 bytes with COPY_SRC and COPY_DST beside `usage`.
    ///
    /// # Errors
    /// If it is larger than one binding of this device.
    pub fn empty_buffer(
        &self,
        label: &str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let size = bytes.next_multiple_of(16).max(16);
        let limit = self
            .description()
            .max_storage_binding
            .min(self.description().max_buffer);
        if size > limit {
            return Err(GpuError::TooLarge {
                what: label.to_owned(),
                needed: size,
                limit,
                remedy: "use a smaller scene or picture, or a device with larger limits (see `patina devices`)",
            });
        }
        Ok(self.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage: usage | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        }))
    }

    /// Copies a range of a buffer back to the CPU and waits for it.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn read_buffer(
        &self,
        buffer: &wgpu::Buffer,
        offset: u64,
        bytes: u64,
    ) -> Result<Vec<u8>, GpuError> {
        let staging = self.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some("read-back"),
            size: bytes,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self
            .device()
            .create_command_encoder(&wgpu::CommandEncoderDescriptor {
                label: Some("read-back"),
            });
        encoder.copy_buffer_to_buffer(buffer, offset, &staging, 0, bytes);
        self.queue().submit([encoder.finish()]);
        let outcome = Arc::new(OnceLock::new());
        let slot = Arc::clone(&outcome);
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // Called once; a second value could only be the same.
            let _ = slot.set(result);
        });
        self.wait()?;
        match outcome.get() {
            Some(Ok(())) => {}
            Some(Err(e)) => return Err(GpuError::Driver(e.to_string())),
            None => return Err(GpuError::Driver("a read-back did not finish".to_owned())),
        }
        let view = staging
            .get_mapped_range(..)
            .map_err(|e| GpuError::Driver(e.to_string()))?;
        let data = view.to_vec();
        drop(view);
        staging.unmap();
        Ok(data)
    }
}

/// The adapter that is meant.
fn choose(
    choice: &DeviceChoice,
) -> Result<(wgpu::Instance, wgpu::Adapter, AdapterDescription), GpuError> {
    let (instance, adapters) = adapters_by_preference();
    let descriptions: Vec<_> = adapters
        .iter()
        .enumerate()
        .map(|(i, a)| AdapterDescription::new(i, a))
        .collect();
    let chosen = descriptions.iter().find(|d| match choice {
        DeviceChoice::Best => d.usable.is_ok(),
        DeviceChoice::Index(index) => d.index == *index && d.usable.is_ok(),
        DeviceChoice::Name(name) => {
            d.name.to_lowercase().contains(&name.to_lowercase()) && d.usable.is_ok()
        }
    });
    let Some(description) = chosen else {
        if descriptions.is_empty() {
            return Err(GpuError::NoAdapter);
        }
        let available = descriptions
            .iter()
            .map(|d| match &d.usable {
                Ok(()) => format!("  {}: {} ({}, {})", d.index, d.name, d.backend, d.driver),
                Err(why) => format!("  {}: {} (not usable: {why})", d.index, d.name),
            })
            .collect::<Vec<_>>()
            .join("\n");
        let wanted = match choice {
            DeviceChoice::Best => "any".to_owned(),
            DeviceChoice::Index(index) => index.to_string(),
            DeviceChoice::Name(name) => name.clone(),
        };
        return Err(GpuError::NotFound { wanted, available });
    };
    let description = description.clone();
    Ok((instance, adapters[description.index].clone(), description))
}

fn adapters_by_preference() -> (wgpu::Instance, Vec<wgpu::Adapter>) {
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

fn device_type_name(kind: wgpu::DeviceType) -> &'static str {
    match kind {
        wgpu::DeviceType::DiscreteGpu => "discrete GPU",
        wgpu::DeviceType::IntegratedGpu => "integrated GPU",
        wgpu::DeviceType::VirtualGpu => "virtual GPU",
        wgpu::DeviceType::Cpu => "CPU",
        wgpu::DeviceType::Other => "other",
    }
}
