//! The declarations of layers as WGSL: what kernels call to record them.

use super::place;
use crate::film::layers::{CAUGHT, LAYERS, Layer, Rule, lit_bit};

/// The function that gives the first word of a layer.
fn word(layer: &str) -> String {
    format!("word_{layer}()")
}

/// The same as WGSL.
fn word_wgsl(layer: &str) -> String {
    let place = place(layer);
    let (row, column) = (place / 4, ["x", "y", "z", "w"][place % 4]);
    format!(
        "\nfn {} -> u32 {{\n    return layer_words[{row}].{column};\n}}\n",
        word(layer)
    )
}

/// `generated/film_layers.wgsl`: a function that records all layers of surfaces that are asked for.
fn record_wgsl() -> String {
    let (mut words, mut wants, mut textures, mut body) =
        (String::new(), String::new(), Vec::new(), String::new());
    for (name, kind) in SHARED {
        let users = LAYERS.iter().filter(|layer| uses(layer, name));
        let wanted: Vec<_> = users
            .map(|layer| format!("{} != 0u", word(layer.name)))
            .collect();
        wants += &format!("    let wants_{name} = {};\n", wanted.join(" || "));
        let constant = name.to_uppercase();
        textures.push(format!(
            "select(0u, FIRST_{constant}_TEXTURES, wants_{name})"
        ));
        body += &format!(
            "    var {name}: {kind};\n    if (wants_{name}) {{\n        {name} = first_{name}(at, texels);\n    }}\n"
        );
    }
    let textures = textures.join("\n        | ");
    wants += &format!("    let texels = first_texels(at, {textures});\n");
    for layer in LAYERS.iter().filter(|layer| !layer.is_light()) {
        let Some(wgsl) = layer.wgsl() else { continue };
        words += &word_wgsl(layer.name);
        let (kind, values) = match (&layer.rule, layer.channel_count()) {
            (Rule::Ids { .. }, _) => ("u32", &["bitcast<f32>(value)"][..]),
            (_, 1) => ("f32", &["value"][..]),
            (_, 2) => ("vec2f", &["value.x", "value.y"][..]),
            _ => ("vec3f", &["value.x", "value.y", "value.z"][..]),
        };
        let word = word(layer.name);
        body += &format!("    if ({word} != 0u) {{\n        let value: {kind} = {wgsl};\n");
        for (at, value) in values.iter().enumerate() {
            body += &format!("        layer_sample_set({word} + {at}u, at.slot, {value});\n");
        }
        body += "    }\n";
    }
    format!("{words}\nfn record_each(at: FirstSurface) {{\n{wants}{body}}}\n")
}

/// What several layers are made from: `NAME`, which the function `first_NAME` gives, and its type. The textures that it is made
/// from, the constant `FIRST_NAME_TEXTURES` says.
const SHARED: [(&str, &str); 3] = [
    ("base", "vec3f"),
    ("normal", "vec3f"),
    ("colors", "FirstColors"),
];

/// Whether a layer's expression names a value.
fn uses(layer: &Layer, name: &str) -> bool {
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut words = layer
        .wgsl()
        .into_iter()
        .flat_map(|wgsl| wgsl.split(|c| !is_of_name(c)));
    words.any(|word| word == name)
}

/// `generated/film_light.wgsl`: functions that add a piece of light to all parts of the picture that are asked for.
fn light_wgsl() -> String {
    // By the first one a path knows that its first surface is a catcher.
    let (mut words, mut add) = (word_wgsl(CAUGHT), String::new());
    for layer in LAYERS.iter().filter(|layer| layer.is_light()) {
        let Some(wgsl) = layer.wgsl() else { continue };
        let bit = format!("{:#x}u", lit_bit(layer));
        let (word, bit) = match layer.light_group() {
            None => (word(layer.name), bit),
            // One look-up instead of a question for each group.
            Some(0) => (
                "group_word(found.group)".to_owned(),
                format!("{bit} << found.group"),
            ),
            Some(_) => continue,
        };
        if layer.light_group().is_none() {
            words += &word_wgsl(layer.name);
        }
        add += &format!(
            "    if ({word} != 0u) {{\n        layer_add({word}, {bit}, slot, {wgsl});\n    }}\n"
        );
    }
    words += &group_wgsl();
    format!("{words}\nfn add_found(slot: u32, found: Found) {{\n{add}}}\n")
}

/// A function that gives the first word of the layer of a group of lights; 0 for groups that have none.
fn group_wgsl() -> String {
    let groups: Vec<usize> = (LAYERS.iter().enumerate())
        .filter(|(_, layer)| layer.light_group().is_some())
        .map(|(place, _)| place)
        .collect();
    let (first, count) = (groups[0], groups.len());
    format!(
        "\nfn group_word(group: u32) -> u32 {{\n    if (group >= {count}u) {{\n        return 0u;\n    }}\n    let place = {first}u + group;\n    return layer_words[place / 4u][place % 4u];\n}}\n"
    )
}

/// `film_layers/words.wgsl` reads so many of [`record_words`] at once.
const ROWS: usize = LAYERS.len().div_ceil(4);

#[test]
fn parts_of_the_light_have_bits_of_their_own() {
    let bits = LAYERS.iter().map(lit_bit).filter(|&bit| bit != 0);
    let all = bits.fold(0, |all, bit| {
        assert_eq!(all & bit, 0, "one after the other");
        all | bit
    });
    // Those of `LIT_NUMBER`, and of an exponent that stands for no number.
    assert!(all < 1 << 29, "{all:#x}");
    let groups = LAYERS.iter().filter(|layer| layer.light_group().is_some());
    let first = groups.clone().next().map_or(0, lit_bit);
    for (number, group) in groups.enumerate() {
        assert_eq!(lit_bit(group), first << number, "{}", group.name);
    }
}

/// A file that doesn't fit the table is written anew; the test has to be run again then.
#[test]
fn generated_files_are_what_the_table_of_layers_says() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/passes/generated");
    let rows = format!("const LAYER_ROWS = {ROWS}u;\n");
    let files = [
        ("film_words.wgsl", rows),
        ("film_layers.wgsl", record_wgsl()),
        ("film_light.wgsl", light_wgsl()),
    ];
    let mut changed = Vec::new();
    for (name, text) in files {
        let text = format!(
            "// From the table of layers; `cargo test -p engine generated` writes it.\n{text}"
        );
        let path = std::path::Path::new(folder).join(name);
        // Git may have changed the ends of lines.
        let is_same =
            std::fs::read_to_string(&path).is_ok_and(|found| found.replace("\r\n", "\n") == text);
        if !is_same {
            std::fs::write(&path, text).expect("the file can be written");
            changed.push(name);
        }
    }
    assert!(changed.is_empty(), "written anew: {}", changed.join(", "));
}
