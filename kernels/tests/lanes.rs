//! Kernels in lanes do what the same kernels do that a device compiles, one invocation after the other.

#![cfg(target_arch = "x86_64")]

use core::sync::atomic::{AtomicI32, AtomicU32, Ordering::Relaxed};

use device::native::buffer::Buffer;
use device::native::compile::{Ahead, Kernel, Options, Resource, runtime};

// What the build wrote for `lanes.wgsl` uses it, and only some of it.
#[allow(dead_code, unused_imports, reason = "the kernels use more")]
#[path = "../src/lanes.rs"]
mod lanes;

include!(concat!(env!("OUT_DIR"), "/tests.rs"));

const WORKGROUPS: u32 = 4;
const WORDS: usize = 1 << 13;

fn kernel(entry: &str, ahead: &'static [Ahead]) -> Kernel {
    compiled(entry, ahead, false, |_| false)
}

/// Compiled by the device, to run in lanes.
fn kernel_in_lanes(entry: &str, is_separate: fn(&str) -> bool) -> Kernel {
    compiled(entry, &[], true, is_separate)
}

fn compiled(
    entry: &str,
    ahead: &'static [Ahead],
    in_lanes: bool,
    is_separate: fn(&str) -> bool,
) -> Kernel {
    let text = include_str!("lanes.wgsl");
    let module = naga::front::wgsl::parse_str(text).expect("it is valid");
    let flags = naga::valid::ValidationFlags::all();
    let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::all());
    let info = validator.validate(&module).expect("it is valid");
    let options = Options {
        ahead,
        separate: &is_separate,
        ..Options::default()
    };
    let kernel = Kernel::new(&module, &info, entry, &[], &options).expect("it can be compiled");
    if in_lanes {
        let added = kernel.add_lanes(&module, &info, entry, &[], &options, &|_| false);
        added.expect("it runs in lanes");
        assert!(kernel.is_in_lanes(), "{entry}");
    }
    kernel
}

/// What is in its buffers afterwards.
fn run(kernel: &Kernel) -> Vec<Vec<u32>> {
    let mut buffers = Vec::new();
    let bound = kernel.bind(|binding| {
        let buffer = Buffer::new(4 * WORDS as u64).expect("there is memory");
        let words: Vec<u32> = (0..WORDS as u32)
            .map(|word| {
                let bits = (word + 1).wrapping_mul(2_654_435_761);
                let bits = bits ^ bits >> 15;
                match (binding.name.as_str(), word / 4 % 8) {
                    ("counters" | "signed_counters", _) => word,
                    // Not a number, infinite, just out of range, and plain floats.
                    (_, 0) => [f32::NAN, f32::INFINITY, 4_294_967_296.0, -2_147_483_648.0]
                        [word as usize % 4]
                        .to_bits(),
                    (_, 1..4) => ((bits >> 8) as f32 / 65536.0 - 100.0).to_bits(),
                    _ => bits,
                }
            })
            .collect();
        buffer.write(0, &words);
        buffers.push(buffer.clone());
        Some(Resource::from(buffer))
    });
    bound
        .expect("all of it is bound")
        .dispatch_alone([WORKGROUPS, 1, 1]);
    // What isn't a number has many bits; it counts as one.
    let canonical = |word: u32| match f32::from_bits(word).is_nan() {
        true => f32::NAN.to_bits(),
        false => word,
    };
    let words = |buffer: &Buffer| buffer.read::<u32>(0, WORDS).into_iter().map(canonical);
    buffers
        .iter()
        .map(|buffer| words(buffer).collect())
        .collect()
}

#[test]
fn lanes_compute_what_one_invocation_after_the_other_does() {
    if kernels::all().is_empty() {
        eprintln!("skipped: this processor has no such vectors");
        return;
    }
    for entry in TESTS {
        let (in_lanes, alone) = (kernel(entry, &IN_LANES), kernel(entry, &[]));
        assert!(in_lanes.is_ahead(), "{entry}");
        let expected = run(&alone);
        let made_now = [|_: &str| false, |_: &str| true]
            .map(|is_separate| kernel_in_lanes(entry, is_separate));
        for (number, kernel) in [in_lanes].into_iter().chain(made_now).enumerate() {
            let found = run(&kernel);
            for (buffer, (found, expected)) in found.iter().zip(&expected).enumerate() {
                let different = (0..WORDS).find(|&word| found[word] != expected[word]);
                assert_eq!(different, None, "{entry}: kernel {number}, buffer {buffer}");
            }
        }
    }
}
