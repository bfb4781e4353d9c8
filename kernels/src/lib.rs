//! The engine's kernels as machine code that comes with the program.
//!
//! The build (`kernels/build.rs`) takes the passes' WGSL, the same files that are put into the program, and turns it into
//! Rust by way of the programs of the crate `kernel_ir`: once for each of the few sets of features that scenes have.
//! A device for processors looks a kernel up by what its text comes down to ([`Ahead`]), so nothing here has to be kept in
//! step: a text that was changed at run time, or a set of features that isn't here, is compiled when it is needed, and gives
//! the same bits, only slower.

use device::native::compile::{Ahead, AheadFunction};

#[cfg(all(target_arch = "x86_64", not(any(clippy, doc))))]
mod lanes;

#[cfg(not(any(clippy, doc)))]
mod compiled {
    use core::sync::atomic::{AtomicI32, AtomicU32, Ordering::Relaxed};

    use device::native::compile::{Ahead, AheadFunction, runtime};

    #[cfg(target_arch = "x86_64")]
    use super::lanes;

    include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
}

/// In place of it for lints and documentation, which have nothing to say of what the build wrote and would take minutes to read it.
#[cfg(any(clippy, doc))]
mod compiled {
    use device::native::compile::{Ahead, AheadFunction};

    pub(super) const OMISSIONS: &[&str] = &[];
    pub(super) const NAMES: &[&str] = &[];
    pub(super) static ALL: [Ahead; 0] = [];
    pub(super) static FUNCTIONS: [AheadFunction; 0] = [];
    pub(super) static FUNCTIONS_IN_LANES: [AheadFunction; 0] = [];
}

/// Override constants by which a kernel leaves out what a scene doesn't have, and does the same as with them set. What is
/// compiled with all of them stands for sets of features that aren't here.
pub const OMISSIONS: &[&str] = compiled::OMISSIONS;

/// All that this processor can run: none on one of x86-64 without AVX2.
pub fn all() -> &'static [Ahead] {
    match is_supported() {
        true => &compiled::ALL,
        false => &[],
    }
}

/// Standard functions of the texture language that this processor can run, for kernels that call them. What stands for one is
/// known by what the function comes down to, not by its name.
pub fn functions() -> &'static [AheadFunction] {
    match is_supported() {
        true => &compiled::FUNCTIONS,
        false => &[],
    }
}

/// The same for kernels in lanes: none on processors without AVX2.
pub fn functions_in_lanes() -> &'static [AheadFunction] {
    match is_supported() {
        true => &compiled::FUNCTIONS_IN_LANES,
        false => &[],
    }
}

/// Whether a standard function of this name is among [`functions`], and is to be called rather than inlined.
pub fn is_function(name: &str) -> bool {
    function_names().contains(&name)
}

/// The names of those that are to be called; what they call themselves may be among [`functions`], too.
pub fn function_names() -> &'static [&'static str] {
    match is_supported() {
        true => compiled::NAMES,
        false => &[],
    }
}

#[cfg(target_arch = "x86_64")]
fn is_supported() -> bool {
    // What `build.rs` asks for.
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt")
}

#[cfg(not(target_arch = "x86_64"))]
fn is_supported() -> bool {
    true
}
