//! Devices by their drivers: Vulkan, Metal, DirectX 12, through wgpu.

mod adapter;
mod cache;
mod image;
mod memory;
mod pipeline;
mod play;
pub mod statistics;
mod structure;
mod timestamps;

use std::sync::{
    Arc, Mutex, OnceLock,
    atomic::{AtomicU64, Ordering},
};
use std::thread::ThreadId;

use crate::{
    Activity, Counts, DeviceDescription, DeviceError, DeviceOptions, Limits, Traits, WaveSizes,
};

pub use self::cache::fnv1a;
pub use self::structure::{MeshTriangles, Placed, Structure};
pub(crate) use self::{
    pipeline::{BoundPipeline, Pipeline},
    timestamps::Timestamps,
};

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
    description: DeviceDescription,
    /// The "GPU" is the processor, by a software driver.
    is_software: bool,
    shader_modules: AtomicU64,
    pipelines: AtomicU64,
    errors: Arc<Mutex<Errors>>,
    /// Why the device is gone, once it is.
    lost: Arc<OnceLock<String>>,
    cache: Option<cache::DiskCache>,
    activity: Activity,
}

/// What the driver refused where nobody asked. wgpu tells it on the thread that was refused.
#[derive(Debug, Default)]
struct Errors {
    /// The first one, until it is taken.
    first: Option<DeviceError>,
    guest: Option<Guest>,
}

/// A thread that draws with the device for itself, such as a window's.
struct Guest {
    thread: ThreadId,
    told: Box<dyn Fn(&str) + Send>,
}

impl std::fmt::Debug for Guest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Guest").finish_non_exhaustive()
    }
}

impl Errors {
    fn note(&mut self, thread: ThreadId, error: DeviceError) {
        match &self.guest {
            Some(guest) if guest.thread == thread => (guest.told)(&error.to_string()),
            _ => {
                self.first.get_or_insert(error);
            }
        }
    }
}

impl Gpu {
    /// All adapters of the machine, the usual choice first.
    pub(crate) fn all() -> Vec<DeviceDescription> {
        adapter::describe(&adapter::by_preference().1)
    }

    pub(crate) fn open(options: &DeviceOptions) -> Result<Self, DeviceError> {
        let (instance, adapter, description) = adapter::choose(&options.choice)?;
        let ray_queries = options.ray_queries && description.ray_queries;
        let mut features = wgpu::Features::TIMESTAMP_QUERY;
        features.set(wgpu::Features::PIPELINE_CACHE, options.cache.is_some());
        features.set(wgpu::Features::EXPERIMENTAL_RAY_QUERY, ray_queries);
        let experimental_features = match ray_queries {
            // SAFETY: wgpu asks to be told that its ray queries may have faults. Nothing but a comparison with them
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
        .map_err(|e| DeviceError::Open {
            name: description.name.clone(),
            reason: e.to_string(),
        })?;
        let errors = Arc::new(Mutex::new(Errors::default()));
        let slot = Arc::clone(&errors);
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| {
            if let Ok(mut errors) = slot.lock() {
                let error = match &e {
                    wgpu::Error::OutOfMemory { .. } => DeviceError::OutOfMemory,
                    _ => DeviceError::Driver(e.to_string()),
                };
                errors.note(std::thread::current().id(), error);
            }
        }));
        let lost = Arc::new(OnceLock::new());
        let slot = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            // Called once, and also when the last clone of the device is dropped.
            let _ = slot.set(match message.is_empty() {
                true => format!("{reason:?}"),
                false => message,
            });
        });
        let info = adapter.get_info();
        let folder = options.cache.as_deref();
        let cache = folder.and_then(|folder| cache::DiskCache::open(&device, &info, folder));
        Ok(Self {
            shared: Arc::new(Shared {
                instance,
                is_software: info.device_type == wgpu::DeviceType::Cpu,
                adapter,
                device,
                queue,
                description,
                shader_modules: AtomicU64::new(0),
                pipelines: AtomicU64::new(0),
                errors,
                lost,
                cache,
                activity: Activity::default(),
            }),
        })
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

    pub(crate) fn description(&self) -> &DeviceDescription {
        &self.shared.description
    }

    pub(crate) fn traits(&self) -> Traits {
        let is_software = self.shared.is_software;
        Traits {
            lanes: 0,
            waves: match self.shared.adapter.get_info().device_type {
                // Their caches are those of processors.
                wgpu::DeviceType::Cpu => WaveSizes {
                    first: 1 << 14,
                    most: 1 << 16,
                },
                // Few of a wave's paths scatter often, and each time there have to be enough of them for a hundred thousand threads and more.
                wgpu::DeviceType::DiscreteGpu | wgpu::DeviceType::VirtualGpu => WaveSizes {
                    first: 1 << 18,
                    most: 1 << 22,
                },
                _ => WaveSizes {
                    first: 1 << 18,
                    most: 1 << 20,
                },
            },
            runs_threads_in_turn: false,
            calls_functions: false,
            compiles_slowly: is_software,
            shares_the_processor: is_software,
        }
    }

    pub(crate) fn limits(&self) -> Limits {
        let limits = self.device().limits();
        Limits {
            image_side: limits.max_texture_dimension_2d,
            image_layers: limits.max_texture_array_layers,
            storage_buffers: limits.max_storage_buffers_per_shader_stage,
        }
    }

    pub(crate) fn has_ray_queries(&self) -> bool {
        let features = self.device().features();
        features.contains(wgpu::Features::EXPERIMENTAL_RAY_QUERY)
    }

    pub(crate) fn activity(&self) -> &Activity {
        &self.shared.activity
    }

    /// What naga may let kernels do.
    pub(crate) fn capabilities(&self) -> naga::valid::Capabilities {
        match self.has_ray_queries() {
            true => naga::valid::Capabilities::RAY_QUERY,
            false => naga::valid::Capabilities::empty(),
        }
    }

    pub(crate) fn counts(&self) -> Counts {
        Counts {
            shader_modules: self.shared.shader_modules.load(Ordering::Relaxed),
            pipelines: self.shared.pipelines.load(Ordering::Relaxed),
            in_lanes: 0,
        }
    }

    pub(crate) fn has_cache(&self) -> bool {
        self.shared.cache.is_some()
    }

    pub(crate) fn save_cache(&self) -> std::io::Result<()> {
        let cache = self.shared.cache.as_ref();
        cache.map_or(Ok(()), cache::DiskCache::save)
    }

    pub(crate) fn check(&self) -> Result<(), DeviceError> {
        if let Some(message) = self.shared.lost.get() {
            return Err(DeviceError::Lost(message.clone()));
        }
        match self.shared.errors.lock() {
            Ok(mut errors) => errors.first.take().map_or(Ok(()), Err),
            Err(_) => Ok(()),
        }
    }

    /// The thread that calls this draws with the device for itself, as a window does: what it is refused from now on is no failure of
    /// what runs on the device otherwise, but told to it. `told` is called on that thread; wgpu may not be called there.
    pub fn draw_here(&self, told: impl Fn(&str) + Send + 'static) {
        if let Ok(mut errors) = self.shared.errors.lock() {
            errors.guest = Some(Guest {
                thread: std::thread::current().id(),
                told: Box::new(told),
            });
        }
    }

    pub(crate) fn wait(&self) -> Result<(), DeviceError> {
        self.wait_until(wgpu::PollType::wait_indefinitely())
    }

    /// Waits until the device has done one submission; what others have submitted after it isn't waited for.
    pub(crate) fn wait_for(&self, submission: wgpu::SubmissionIndex) -> Result<(), DeviceError> {
        self.wait_until(wgpu::PollType::Wait {
            submission_index: Some(submission),
            timeout: None,
        })
    }

    fn wait_until(&self, what: wgpu::PollType) -> Result<(), DeviceError> {
        self.device()
            .poll(what)
            .map_err(|e| match self.shared.lost.get() {
                Some(message) => DeviceError::Lost(message.clone()),
                None => DeviceError::Driver(e.to_string()),
            })?;
        self.check()
    }

    pub(crate) fn is_lost(&self) -> bool {
        // The driver tells while it is polled.
        let _ = self.device().poll(wgpu::PollType::Poll);
        self.shared.lost.get().is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_window_is_refused_is_no_failure_of_others() {
        let here = std::thread::current().id();
        let elsewhere = std::thread::spawn(|| std::thread::current().id());
        let elsewhere = elsewhere.join().expect("a thread");
        let mut errors = Errors::default();
        let error = |text: &str| DeviceError::Driver(text.to_owned());
        errors.note(here, error("before there was a window"));
        let first = errors.first.take().map(|error| error.to_string());
        assert!(first.is_some_and(|text| text.ends_with(": before there was a window")));
        let (sender, heard) = std::sync::mpsc::channel();
        errors.guest = Some(Guest {
            thread: here,
            told: Box::new(move |text| sender.send(text.to_owned()).expect("it is heard")),
        });
        errors.note(here, error("a surface of another size"));
        assert!(errors.first.is_none());
        assert!(
            heard
                .try_recv()
                .is_ok_and(|text| text.ends_with(": a surface of another size"))
        );
        errors.note(elsewhere, error("first"));
        errors.note(elsewhere, DeviceError::OutOfMemory);
        assert!(matches!(errors.first, Some(DeviceError::Driver(text)) if text == "first"));
        assert!(heard.try_recv().is_err());
    }
}
