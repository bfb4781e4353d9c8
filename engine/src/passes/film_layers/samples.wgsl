// What is recorded of each path of a wave for the layers of the film, word by word, so that neighbouring threads touch
// neighbouring words. Word 0 is 1 where the path met a surface and 0 where it met none,
// word 1 has a bit for each part of the light that the path has brought any of; the others' words mean nothing.
//!include shared/frame.wgsl

@group(0) @binding(42) var<storage, read_write> layer_samples: array<f32>;

fn layer_sample(word: u32, slot: u32) -> f32 {
    return layer_samples[word * frame.capacity + slot];
}

fn layer_sample_set(word: u32, slot: u32, value: f32) {
    layer_samples[word * frame.capacity + slot] = value;
}

// Makes whatever bits are set those of a number that no device takes for zero or for none.
const LIT_NUMBER = 0x40000000u;

fn lit_layers(slot: u32) -> u32 {
    return bitcast<u32>(layer_sample(1u, slot));
}

fn set_lit_layers(slot: u32, bits: u32) {
    layer_sample_set(1u, slot, bitcast<f32>(bits | LIT_NUMBER));
}
