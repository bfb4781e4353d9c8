//! The layers of a film beside the picture: what the first surface of each path gives to them is recorded in each round,
//! and added to their planes at the end of a wave, sum by sum. One thread per path.
//!
//! What a layer is, its declaration says ([`crate::film::layers`]): the film makes WGSL of all of them, and uniforms tell the kernels
//! which are asked for, so that they come compiled with the program, for whatever layers.

use crate::{
    film::layers::{self, Rule, Sum},
    wave::Queue,
};

use super::pass::{Pass, Work};

/// Records what first surfaces give.
pub const RECORD: Pass = Pass {
    name: "record_layers",
    file: "film_layers/record.wgsl",
    work: Work::Queue(Queue::Active),
    reads: &[
        "frame",
        "image_layers",
        "image_layers_srgb",
        "image_table",
        "instances",
        "layer_words",
        "materials",
        "paths",
        "queues",
        "rays",
        "triangles",
        "vertices",
    ],
    writes: &["layer_samples"],
    exists: |features| features.film_layers,
};

/// Adds up the light that paths have found, before each vertex.
pub const LIGHT: Pass = Pass {
    name: "record_light",
    file: "film_layers/light.wgsl",
    work: Work::Queue(Queue::Active),
    reads: &["frame", "layer_words", "queues", "rays", "triangles"],
    writes: &["layer_samples", "paths"],
    exists: |features| features.splits_light,
};

/// Adds what is left of it at the end.
pub const LAST_LIGHT: Pass = Pass {
    name: "record_last_light",
    work: Work::Paths,
    reads: &["frame", "layer_words", "rays"],
    ..LIGHT
};

/// Adds them to a plane that holds sums.
pub const MEAN: Pass = Pass {
    name: "accumulate_mean",
    file: "film_layers/accumulate.wgsl",
    work: Work::Paths,
    reads: &["frame", "layer_samples", "layer_sum"],
    writes: &["layer_film"],
    exists: |features| features.film_layers,
};

/// The same of three channels.
pub const MEANS: Pass = Pass {
    name: "accumulate_means",
    writes: &["layer_film", "layer_film1", "layer_film2"],
    ..MEAN
};

/// Keeps those of the first sample.
pub const FIRST: Pass = Pass {
    name: "accumulate_first",
    ..MEAN
};

/// Counts them by ids, in all planes of a layer.
pub const IDS: Pass = Pass {
    name: "accumulate_ids",
    file: "film_layers/accumulate_ids.wgsl",
    writes: &PLANES,
    ..MEAN
};

/// Names by which these passes know the planes that they write, as many as they need: each is bound to several layers, one after
/// the other.
pub const PLANES: [&str; 4] = ["layer_film", "layer_film1", "layer_film2", "layer_film3"];

/// The pass that adds to a layer's planes.
pub(crate) fn pass_of(sum: &Sum) -> &'static Pass {
    match sum.layer.rule {
        Rule::Ids { .. } => &IDS,
        Rule::First { .. } => &FIRST,
        _ if sum.words == 3 => &MEANS,
        _ => &MEAN,
    }
}

/// `LayerSum` in `film_layers/sum.wgsl`.
pub(crate) fn sum_words(sum: &Sum) -> [u32; 4] {
    [
        sum.word,
        sum.words,
        u32::from(sum.is_of_surfaces),
        layers::lit_bit(sum.layer),
    ]
}
