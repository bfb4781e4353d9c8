//! Textures.
#![no_main]

use fuzzing::WGSL;
use fuzzing::memory::Counting;
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fuzz_target!(init: fuzzing::catch_panics(), |data: &[u8]| {
    (WGSL.run)(data);
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    match seed % 2 {
        0 if size > 1 => fuzzer_mutate(data, size, max_size),
        _ => WGSL
            .change_in_place(&mut data[..max_size.max(size)], size, seed)
            .min(max_size),
    }
});
