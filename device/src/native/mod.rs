//! The processor as a device: the kernels' WGSL compiled to machine code ([`compile`]), rays traced by SIMD code
//! ([`accel`]).
//!
//! A dispatch is made of a [`Kernel`](compile::Kernel), compiled once from naga's module; [`Buffer`](buffer::Buffer)s and
//! [`Image`](image::Image)s, bound by the names of the text; and a number of workgroups:
//!
//! ```
//! use device::native::{buffer::Buffer, compile::{Kernel, Options, Resource}};
//!
//! let module = naga::front::wgsl::parse_str(
//!     "override step = 1u;
//!      @group(0) @binding(0) var<storage, read_write> numbers: array<u32>;
//!      @compute @workgroup_size(64) fn count(@builtin(global_invocation_id) id: vec3u) {
//!          if (id.x < arrayLength(&numbers)) { numbers[id.x] = id.x * step; }
//!      }",
//! )?;
//! let capabilities = naga::valid::Capabilities::empty();
//! let info = naga::valid::Validator::new(Default::default(), capabilities).validate(&module)?;
//! let kernel = Kernel::new(&module, &info, "count", &[("step", 3.0)], &Options::default())?;
//!
//! let numbers = Buffer::new(400)?;
//! let bound = kernel.bind(|binding| match binding.name.as_str() {
//!     "numbers" => Some(Resource::from(numbers.clone())),
//!     _ => None,
//! })?;
//! bound.dispatch([2, 1, 1]);
//! assert_eq!(numbers.read::<u32>(4 * 99, 1), [297]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod accel;
pub mod buffer;
pub mod compile;
pub mod image;
mod later;
mod memory;
mod processor;

pub(crate) use self::processor::{MAX_BUFFER, NAME, Processor, describe, resource};
