// What is recorded of each path of a wave for the layers of the film, word by word, so that neighbouring threads touch
// neighbouring words. Word 0 is 1 where the path met a surface and 0 where it met none.
//!include shared/frame.wgsl

@group(0) @binding(42) var<storage, read_write> layer_samples: array<f32>;

fn layer_sample(word: u32, slot: u32) -> f32 {
    return layer_samples[word * frame.capacity + slot];
}

fn layer_sample_set(word: u32, slot: u32, value: f32) {
    layer_samples[word * frame.capacity + slot] = value;
}
