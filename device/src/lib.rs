//! Compute devices: kernels written in WGSL, the buffers and images that they work on, and recordings of what is to be
//! run. Nothing here knows what is rendered.
//!
//! The way through the crate:
//!
//! 1. [`Device::open`] opens one of [`Device::all`]: a GPU by its driver ([`gpu`]), or the processor itself ([`native`]).
//! 2. [`Buffer`]s and [`Image`]s are made on it and put among the named [`Resources`].
//! 3. [`Kernel::new`] compiles an entry point; [`Kernel::bind`] finds the resources that it names.
//! 4. A [`Recording`] lists dispatches of bound kernels, copies and clears. It is plain data: [`Device::play`] runs it, on
//!    whatever device it is.
//!
//! What a schedule may want to know of a device, it reads from its [`Traits`]; no code above asks what kind it is.
//!
//! ```no_run
//! use device::{Device, DeviceChoice, Extent, Kernel, KernelSource, Recording, Resources, Trust, Usage};
//!
//! let device = Device::open(&DeviceChoice::Best)?;
//! let text = "@group(0) @binding(0) var<storage, read_write> numbers: array<u32>;
//!     @compute @workgroup_size(64)
//!     fn double(@builtin(global_invocation_id) id: vec3u) {
//!         if (id.x < arrayLength(&numbers)) { numbers[id.x] *= 2u; }
//!     }";
//! let kernel = Kernel::new(&device, &KernelSource::new(&text, "double", Trust::Loops))?;
//! let mut resources = Resources::default();
//! resources.set_buffer("numbers", device.filled_buffer("numbers", Usage::Storage, &[1, 0, 0, 0, 21, 0, 0, 0])?);
//! let mut recording = Recording::new("doubling");
//! recording.dispatch(&kernel.bind(&device, &resources), Extent::Threads(2));
//! device.play(&recording)?;
//! let bytes = device.read(resources.buffer("numbers"), 0, 8)?;
//! assert_eq!(bytes, [2, 0, 0, 0, 42, 0, 0, 0]);
//! # Ok::<(), device::DeviceError>(())
//! ```

mod activity;
mod buffer;
mod description;
mod device;
mod error;
pub mod gpu;
mod host;
mod image;
mod kernel;
pub mod native;
mod recording;
mod resources;
mod timing;
mod traits;

pub use self::{
    activity::{Activity, Busy},
    buffer::{Buffer, Usage},
    description::{DeviceChoice, DeviceDescription},
    device::{Counts, Device, DeviceOptions},
    error::DeviceError,
    host::HostFunction,
    image::{Format, Image, ImageUse},
    kernel::{BoundKernel, Kernel, KernelCost, KernelSource, KernelText, Text, Trust},
    recording::{Command, Extent, Recording},
    resources::Resources,
    timing::Timer,
    traits::{Limits, Traits, WaveSizes},
};
