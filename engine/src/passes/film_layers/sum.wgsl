// Which layer a kernel adds to: one kernel serves all layers of its kind, one after the other.

struct LayerSum {
    word: u32, // of its first number in what is recorded of a path
    words: u32, // how many there are
    of_surfaces: u32, // 1: only paths that have met a surface have a value
    lit: u32, // the layer's bit in `lit_layers`; 0: it is no part of the light
}

@group(0) @binding(47) var<uniform> layer_sum: LayerSum;
