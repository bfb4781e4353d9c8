//! The layers of a film beside the picture: what the first surface of each path gives to them is recorded in each round,
//! and added to their planes at the end of a wave, plane by plane. One thread per path.
//!
//! What a layer is, its declaration says ([`crate::film::layers`]): `layers_wgsl` makes WGSL of all of them, and constants tell a
//! kernel which are asked for.

use std::sync::LazyLock;

use device::{Device, DeviceError, Kernel, Trust};

use crate::{
    film::{
        LAYERS, Layers,
        layers::{Plane, Rule},
    },
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
        "materials",
        "paths",
        "queues",
        "rays",
        "triangles",
        "vertices",
    ],
    writes: &["layer_samples"],
    exists: |features| features.film_layers,
    ..Pass::COMMON
};

/// Adds them to a plane that holds sums.
pub const MEAN: Pass = Pass {
    name: "accumulate_mean",
    file: "film_layers/accumulate.wgsl",
    work: Work::Paths,
    reads: &["frame", "layer_samples"],
    writes: &["layer_film"],
    exists: |features| features.film_layers,
    ..Pass::COMMON
};

/// Keeps those of the first sample.
pub const FIRST: Pass = Pass {
    name: "accumulate_first",
    ..MEAN
};

/// Name of the plane that [`MEAN`] and [`FIRST`] write: each is bound to several planes, one after the other.
pub const PLANE: &str = "layer_film";

/// The pass that adds to a plane.
pub(crate) fn pass_of(plane: &Plane) -> &'static Pass {
    match plane.layer.rule {
        Rule::First { .. } => &FIRST,
        Rule::Mean(_) | Rule::Derived(_) => &MEAN,
    }
}

/// Compiles the kernel that adds to a plane.
///
/// # Errors
/// If the driver refuses it.
pub(crate) fn plane_kernel(device: &Device, plane: &Plane) -> Result<Kernel, DeviceError> {
    let pass = pass_of(plane);
    let constants = [
        ("plane_word", f64::from(plane.word)),
        ("plane_channels", f64::from(plane.channels)),
    ];
    let source = pass.source(device);
    source.compile(device, pass.name, Trust::All, &constants)
}

/// Constants that tell [`RECORD`] where the values of these layers go.
pub(crate) fn constants(layers: &Layers) -> Vec<(&'static str, f64)> {
    let mut constants: Vec<(&'static str, f64)> = Vec::new();
    for plane in layers.planes() {
        let name = word_name(plane.layer.name);
        // The first plane of a layer is where it begins.
        if constants.last().is_none_or(|&(last, _)| last != name) {
            constants.push((name, f64::from(plane.word)));
        }
    }
    constants
}

/// The constant with the first word of a layer.
fn word_name(layer: &str) -> &'static str {
    static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
        let names = LAYERS.iter().map(|layer| format!("word_{}", layer.name));
        names.collect()
    });
    let at = LAYERS.iter().position(|other| other.name == layer);
    &NAMES[at.expect("one of the table")]
}

/// `generated/film_layers.wgsl`: a function that records all layers that are asked for.
pub(super) fn layers_wgsl() -> String {
    let (mut words, mut body) = (String::new(), String::new());
    for layer in &LAYERS {
        let Some(wgsl) = layer.wgsl() else { continue };
        let word = word_name(layer.name);
        words += &format!("override {word}: u32 = 0u;\n");
        let (kind, parts) = match layer.channel_count() {
            1 => ("f32", &[""][..]),
            2 => ("vec2f", &[".x", ".y"][..]),
            _ => ("vec3f", &[".x", ".y", ".z"][..]),
        };
        body += &format!("    if ({word} != 0u) {{\n        let value: {kind} = {wgsl};\n");
        for (at, part) in parts.iter().enumerate() {
            body += &format!("        layer_sample_set({word} + {at}u, at.slot, value{part});\n");
        }
        body += "    }\n";
    }
    format!(
        "// Where the values of each layer lie in what is recorded of a path; 0: it is not asked for.\n{words}\n\
         fn record_each(at: FirstSurface) {{\n{body}}}\n"
    )
}
