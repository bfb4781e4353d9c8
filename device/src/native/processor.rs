//! The processor behind the interface of all devices.

use std::{
    collections::HashSet,
    sync::{
        Arc, OnceLock,
        atomic::{AtomicU64, Ordering},
    },
    time::Instant,
};

use rayon::{ThreadPool, ThreadPoolBuilder, prelude::*};

use crate::{
    Activity, Command, Counts, DeviceDescription, DeviceError, Extent, Format, KernelSource,
    Limits, Recording, Timer, Traits, Trust, WaveSizes,
    kernel::{Bound, Parsed},
    resources::Resource,
};

use super::{
    buffer::{Buffer, OutOfMemory},
    compile::{self, BoundKernel, Cache, ErrorKind, Options},
    image::{self, Image},
    later::Later,
};

/// What `--device` calls it.
pub(crate) const NAME: &str = "native";

/// The most bytes of a buffer.
pub(crate) const MAX_BUFFER: u64 = u32::MAX as u64;

/// Buffers that a kernel may use.
const STORAGE_BUFFERS: u32 = 64;

/// Times that a loop of text that isn't trusted runs, as wgpu bounds loops: never by chance, and not for ever.
const LOOP_LIMIT: u32 = u32::MAX;

/// The processor, opened. Clones share it.
#[derive(Debug, Clone)]
pub(crate) struct Processor {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    /// Made when it is asked for: its number depends on the drivers, and to look for these takes a tenth of a second.
    description: OnceLock<DeviceDescription>,
    shader_modules: AtomicU64,
    pipelines: AtomicU64,
    in_lanes: AtomicU64,
    later: Later,
    activity: Activity,
    /// Machine code by content, so that a changed texture compiles one function.
    functions: Cache,
    /// Threads of its own; without them it works on those of the program.
    threads: Option<ThreadPool>,
}

/// How it is driven, with so many threads.
fn driver(threads: usize) -> String {
    let threads = match threads {
        1 => "1 thread".to_owned(),
        threads => format!("{threads} threads"),
    };
    format!("{threads}, {}", super::accel::Kernel::best())
}

/// What it is, as the device of this number.
pub(crate) fn describe(index: usize) -> DeviceDescription {
    DeviceDescription {
        index,
        name: NAME.to_owned(),
        backend: "no driver".to_owned(),
        driver: driver(rayon::current_num_threads()),
        device_type: "CPU".to_owned(),
        is_processor: true,
        max_storage_binding: MAX_BUFFER,
        max_buffer: MAX_BUFFER,
        storage_buffers_per_stage: STORAGE_BUFFERS,
        workgroup_invocations: 1024,
        timestamps: true,
        ray_queries: false,
        usable: Ok(()),
    }
}

impl Processor {
    /// With so many threads of its own, or with those of the program.
    pub(crate) fn open(threads: Option<u32>) -> Result<Self, DeviceError> {
        let pool = |count: u32| {
            let pool = ThreadPoolBuilder::new().num_threads(count.max(1) as usize);
            pool.build().map_err(|error| DeviceError::Open {
                name: format!("{NAME}:{count}"),
                reason: error.to_string(),
            })
        };
        let threads = threads.map(pool).transpose()?;
        Ok(Self {
            shared: Arc::new(Shared {
                threads,
                description: OnceLock::new(),
                shader_modules: AtomicU64::new(0),
                pipelines: AtomicU64::new(0),
                in_lanes: AtomicU64::new(0),
                later: Later::default(),
                activity: Activity::default(),
                functions: Cache::new(),
            }),
        })
    }

    /// What it is; `number` tells which device of the machine.
    pub(crate) fn description(&self, number: impl FnOnce() -> usize) -> &DeviceDescription {
        (self.shared.description).get_or_init(|| DeviceDescription {
            driver: driver(self.threads()),
            ..describe(number())
        })
    }

    fn threads(&self) -> usize {
        match &self.shared.threads {
            Some(own) => own.current_num_threads(),
            None => rayon::current_num_threads(),
        }
    }

    pub(crate) fn activity(&self) -> &Activity {
        &self.shared.activity
    }

    pub(crate) fn traits(&self) -> Traits {
        let lanes = u32::try_from(self.threads()).unwrap_or(u32::MAX);
        Traits {
            waves: WaveSizes {
                first: 1 << 14,
                most: lanes.clamp(2, 1 << 8) << 15,
            },
            lanes,
            runs_threads_in_turn: true,
            calls_functions: true,
            compiles_slowly: false,
            shares_the_processor: true,
        }
    }

    pub(crate) fn limits(&self) -> Limits {
        Limits {
            image_side: 1 << 15,
            image_layers: 2048,
            storage_buffers: STORAGE_BUFFERS,
        }
    }

    pub(crate) fn counts(&self) -> Counts {
        Counts {
            shader_modules: self.shared.shader_modules.load(Ordering::Relaxed),
            pipelines: self.shared.pipelines.load(Ordering::Relaxed),
            in_lanes: self.shared.in_lanes.load(Ordering::Relaxed),
        }
    }

    pub(crate) fn buffer(&self, label: &str, bytes: u64) -> Result<Buffer, DeviceError> {
        Buffer::new(bytes).map_err(|error| out_of_memory(label, error))
    }

    pub(crate) fn image(
        &self,
        label: &str,
        size: [u32; 3],
        format: Format,
    ) -> Result<Image, DeviceError> {
        let [width, height, layers] = size;
        let format = match format {
            Format::Rgba8Unorm => image::Format::Rgba8Unorm,
            Format::Rgba32Float => image::Format::Rgba32Float,
            Format::Rgba32Uint => image::Format::Rgba32Uint,
        };
        Image::new(format, width, height, layers).map_err(|error| out_of_memory(label, error))
    }

    /// Compiles an entry point.
    pub(crate) fn compile(
        &self,
        source: &KernelSource<'_>,
        parsed: Parsed,
    ) -> Result<compile::Kernel, DeviceError> {
        let _busy = (self.activity()).begin(|| format!("compiling the kernel {}", source.entry));
        let constants: Vec<(&str, f64)> = source.constants.to_vec();
        let options = Options {
            separate: &|name| source.text.is_separate(name),
            host: source.text.host_functions(),
            loop_limit: (source.trust == Trust::Nothing).then_some(LOOP_LIMIT),
            cache: Some(&self.shared.functions),
            ahead: source.text.ahead(),
            ahead_functions: source.text.ahead_functions(),
            omissions: source.text.omissions(),
            ..Options::default()
        };
        self.shared.shader_modules.fetch_add(1, Ordering::Relaxed);
        let (module, info) = (&parsed.module, &parsed.info);
        let kernel = compile::Kernel::new(module, info, source.entry, &constants, &options);
        self.shared.pipelines.fetch_add(1, Ordering::Relaxed);
        if let Ok(kernel) = &kernel
            && source.text.runs_in_lanes()
        {
            self.add_lanes(source, kernel, parsed);
        }
        kernel.map_err(|error| {
            let message = error.to_string();
            let place = error.span.to_range();
            let located = place.and_then(|range| source.text.locate(range, &message));
            match error.kind {
                // What a user's text may bring about is said of its place.
                ErrorKind::Stack { .. } | ErrorKind::TooLarge { .. } => DeviceError::Refused {
                    label: source.entry.to_owned(),
                    message: located.unwrap_or(message),
                },
                _ => source.failed(located.unwrap_or(message)),
            }
        })
    }

    /// Sees to it that a kernel has code that runs in lanes before long. It may run before it has: what it computes is the same.
    fn add_lanes(&self, source: &KernelSource<'_>, kernel: &compile::Kernel, parsed: Parsed) {
        let named = |is: &dyn Fn(&str) -> bool| -> HashSet<String> {
            let functions = parsed.module.functions.iter();
            let names = functions.filter_map(|(_, function)| function.name.clone());
            names.filter(|name| is(name)).collect()
        };
        let separate = named(&|name| source.text.is_separate(name));
        let once = named(&|name| source.text.runs_once(name));
        let (entry, constants) = (source.entry.to_owned(), source.constants.to_vec());
        let (host, ahead_lanes) = (
            source.text.host_functions().to_vec(),
            source.text.ahead_lanes(),
        );
        let loop_limit = (source.trust == Trust::Nothing).then_some(LOOP_LIMIT);
        let (kernel, shared) = (kernel.clone(), Arc::downgrade(&self.shared));
        let constants: Vec<(&str, f64)> = constants;
        self.shared.later.run(move || {
            // Nobody has it any more, or the device.
            let (true, Some(shared)) = (kernel.is_shared(), shared.upgrade()) else {
                return;
            };
            let options = Options {
                separate: &|name| separate.contains(name),
                host: &host,
                loop_limit,
                cache: Some(&shared.functions),
                ahead_lanes,
                ..Options::default()
            };
            let (module, info) = (&parsed.module, &parsed.info);
            let once = |name: &str| once.contains(name);
            let added = kernel.add_lanes(module, info, &entry, &constants, &options, &once);
            // Else the other code goes on: it does the same.
            if added.is_ok() {
                shared.in_lanes.fetch_add(1, Ordering::Relaxed);
            }
        });
    }

    /// Waits for all code that is being made of kernels beside their use.
    pub(crate) fn finish_compiling(&self) {
        self.shared.later.finish();
    }

    /// Does what is recorded, one after the other, and returns when it is done.
    pub(crate) fn play(&self, recording: &Recording, timer: Option<&mut Timer>) {
        self.on_threads(|| run(recording, timer, BoundKernel::dispatch));
    }

    /// As [`Self::play`], on the calling thread.
    pub(crate) fn play_alone(&self, recording: &Recording, timer: &mut Timer) {
        run(recording, Some(timer), BoundKernel::dispatch_alone);
    }

    /// Does something for each of some items, on as many threads as there are.
    pub(crate) fn side_by_side<T: Send, E: Send>(
        &self,
        items: &mut [T],
        work: impl Fn(&mut T) -> Result<(), E> + Send + Sync,
    ) -> Result<(), E> {
        let items = items.par_iter_mut().with_max_len(1);
        self.on_threads(|| items.try_for_each(work))
    }

    fn on_threads<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.shared.threads {
            Some(own) => own.install(work),
            None => work(),
        }
    }
}

/// Does what is recorded by a way to run a kernel over its workgroups.
fn run(
    recording: &Recording,
    mut timer: Option<&mut Timer>,
    dispatch: impl Fn(&BoundKernel, [u32; 3]),
) {
    for command in recording.commands() {
        match command {
            Command::Dispatch(kernel, extent) => {
                let Bound::Native(bound) = &kernel.bound else {
                    unreachable!("kernels are bound to the device that plays them");
                };
                let start = Instant::now();
                dispatch(bound, workgroups(extent));
                if let Some(timer) = &mut timer {
                    timer.add(kernel.label(), start.elapsed());
                }
            }
            Command::Clear(buffer) => {
                let buffer = buffer.native();
                buffer.clear(0, buffer.size());
            }
            Command::Copy { from, to, bytes } => {
                from.native().copy_to(0, to.native(), 0, *bytes);
            }
        }
    }
}

fn workgroups(extent: &Extent) -> [u32; 3] {
    match extent {
        Extent::Threads(threads) => {
            let [x, y] = Extent::groups(*threads);
            [x, y, 1]
        }
        Extent::One => [1; 3],
        Extent::Indirect(sizes, offset) => {
            let words = sizes.native().read::<u32>(*offset, 3);
            [words[0], words[1], words[2]]
        }
    }
}

/// A resource as machine code takes it.
pub(crate) fn resource(resource: &Resource<'_>) -> Option<compile::Resource> {
    match resource {
        Resource::Buffer(buffer) => Some(buffer.native().clone().into()),
        Resource::Image(image) => Some(image.native()?.clone().into()),
        Resource::Function(function) => Some(Arc::clone(function).into()),
        Resource::Structure(_) => None,
    }
}

fn out_of_memory(label: &str, error: OutOfMemory) -> DeviceError {
    DeviceError::NoRoom {
        what: label.to_owned(),
        bytes: error.bytes,
    }
}
