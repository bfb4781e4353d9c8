//! WGSL compute kernels as linear code over scalars.
//!
//! [`lower`] makes a [`Program`](ir::Program) of one entry point of naga's module, after [`with_constants`] has replaced its
//! override constants. Composites are taken apart into scalars, variables become values wherever their elements aren't
//! chosen at run time, conditions that override constants decide leave no code, and functions are inlined, but for those
//! that [`Options::separate`] names and those that are large and called often. Every index is restricted to its array, as
//! implementations of WebGPU do it.
//!
//! What comes of a program is decided elsewhere: the crate `device` makes machine code of it when it runs, and [`rust`]
//! writes it as Rust when Patina is built. Programs with the same [`ir::Program::key`] compute the same, so either can stand
//! for the other.

mod binding;
mod error;
mod image;
pub mod ir;
mod key;
pub mod lanes;
mod lower;
pub mod rust;

pub use binding::{Access, Binding, BindingKind};
pub use error::{CompileError, ErrorKind};
pub use image::{Format, ImageHeader, TILE, texel_place};
pub use lower::{lower, with_constants};

/// How a kernel becomes a program.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Functions that stay functions, by name; the rest is inlined as far as that pays.
    pub separate: &'a dyn Fn(&str) -> bool,
    /// Functions that are left out, by name: what is bound to this name is called instead.
    pub host: &'a [&'static str],
    /// The most times that a loop's body runs, each time that the loop is entered; then it ends. For texts whose loops
    /// may not end.
    pub loop_limit: Option<u32>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            separate: &|_| false,
            host: &[],
            loop_limit: None,
        }
    }
}
