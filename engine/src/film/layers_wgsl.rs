//! The declarations of layers as WGSL: what a kernel calls to record them, and its constants.

use std::sync::LazyLock;

use super::layers::{CAUGHT, LAYERS, Layer, Layers, Rule};

/// Constants that tell `film_layers/record.wgsl` and `light.wgsl` where the values of these layers go.
pub(crate) fn record_constants(layers: &Layers) -> Vec<(&'static str, f64)> {
    let mut constants: Vec<(&'static str, f64)> = Vec::new();
    for sum in layers.sums() {
        constants.push((word_name(sum.layer.name), f64::from(sum.word)));
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

/// `generated/film_layers.wgsl`: a function that records all layers of surfaces that are asked for.
pub(crate) fn record_wgsl() -> String {
    let (mut words, mut body) = (String::new(), String::new());
    for (name, kind) in SHARED {
        let users = LAYERS.iter().filter(|layer| uses(layer, name));
        let wanted: Vec<_> = users
            .map(|layer| format!("{} != 0u", word_name(layer.name)))
            .collect();
        let wanted = wanted.join(" || ");
        body += &format!(
            "    var {name}: {kind};\n    if ({wanted}) {{\n        {name} = first_{name}(at);\n    }}\n"
        );
    }
    for layer in LAYERS.iter().filter(|layer| !layer.is_light()) {
        let Some(wgsl) = layer.wgsl() else { continue };
        let word = word_name(layer.name);
        words += &format!("override {word}: u32 = 0u;\n");
        let (kind, values) = match (&layer.rule, layer.channel_count()) {
            (Rule::Ids { .. }, _) => ("u32", &["bitcast<f32>(value)"][..]),
            (_, 1) => ("f32", &["value"][..]),
            (_, 2) => ("vec2f", &["value.x", "value.y"][..]),
            _ => ("vec3f", &["value.x", "value.y", "value.z"][..]),
        };
        body += &format!("    if ({word} != 0u) {{\n        let value: {kind} = {wgsl};\n");
        for (at, value) in values.iter().enumerate() {
            body += &format!("        layer_sample_set({word} + {at}u, at.slot, {value});\n");
        }
        body += "    }\n";
    }
    format!("{WORDS}{words}\nfn record_each(at: FirstSurface) {{\n{body}}}\n")
}

/// What several layers are made from: `NAME`, which the function `first_NAME` gives, and its type.
const SHARED: [(&str, &str); 2] = [("normal", "vec3f"), ("colors", "FirstColors")];

/// Whether a layer's expression names a value.
fn uses(layer: &Layer, name: &str) -> bool {
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut words = layer
        .wgsl()
        .into_iter()
        .flat_map(|wgsl| wgsl.split(|c| !is_of_name(c)));
    words.any(|word| word == name)
}

const WORDS: &str = "// Where the values of each layer lie in what is recorded of a path; 0: it is not asked for.\n";

/// `generated/film_light.wgsl`: functions that add a piece of light to all parts of the picture that are asked for, and that begin
/// anew with nothing.
pub(crate) fn light_wgsl() -> String {
    let (mut words, mut add, mut forget) = (String::new(), String::new(), String::new());
    for layer in LAYERS.iter().filter(|layer| layer.is_light()) {
        let Some(wgsl) = layer.wgsl() else { continue };
        let word = word_name(layer.name);
        words += &format!("override {word}: u32 = 0u;\n");
        add += &format!(
            "    if ({word} != 0u) {{\n        layer_add({word}, slot, {wgsl});\n    }}\n"
        );
        forget +=
            &format!("    if ({word} != 0u) {{\n        layer_clear({word}, slot);\n    }}\n");
    }
    // By it a path knows that its first surface is a catcher.
    words += &format!("override {}: u32 = 0u;\n", word_name(CAUGHT));
    format!(
        "{WORDS}{words}\nfn add_found(slot: u32, found: Found) {{\n{add}}}\n\nfn forget_found(slot: u32) {{\n{forget}}}\n"
    )
}
