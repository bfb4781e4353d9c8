//! Where kernels find the values of layers; what they call to record them is made of the declarations by the tests in `generated`, which
//! keep the files of `passes/generated`.

#[cfg(test)]
mod generated;

use super::layers::{LAYERS, Layers};

/// What tells `film_layers/record.wgsl` and `light.wgsl` where the values of these layers go: for each layer of [`LAYERS`] the first word in
/// what is recorded of a path, 0 where it isn't asked for.
pub(crate) fn record_words(layers: &Layers) -> Vec<u32> {
    let mut words = vec![0; LAYERS.len().next_multiple_of(4)];
    for sum in layers.sums() {
        words[place(sum.layer.name)] = sum.word;
    }
    words
}

/// The number of a layer.
fn place(layer: &str) -> usize {
    let place = LAYERS.iter().position(|other| other.name == layer);
    place.expect("one of the table")
}
