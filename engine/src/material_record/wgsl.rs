//! The tables as WGSL: the files of `passes/generated`, which a test below keeps.

use std::fmt::Write as _;

use crate::scene::{SURFACE_TEXTURES, TEXTURES};

use super::{HEAD_LINKS, HEAD_WORDS, Kind, MEMBERS, Output, Outputs, flag};

/// `Material`, its flags and the numbers of its textures: what `shared/materials.wgsl` includes.
pub fn material_wgsl() -> String {
    let mut text = "struct Material {\n".to_owned();
    let mut members = MEMBERS;
    members.sort_by_key(|member| member.offset);
    for member in members {
        let _ = writeln!(text, "    {}: {},", member.name, member.ty.name());
    }
    let _ = writeln!(
        text,
        "    textures: array<TextureSlot, {}>,\n}}",
        TEXTURES.len()
    );
    for (name, bit) in flag::ALL {
        let _ = writeln!(text, "const MATERIAL_{name} = {bit}u;");
    }
    let shift = flag::LIGHT_GROUP_SHIFT;
    let _ = writeln!(text, "const MATERIAL_LIGHT_GROUP_SHIFT = {shift}u;");
    let (surface, layers) = TEXTURES.split_at(SURFACE_TEXTURES);
    for (number, name) in surface.iter().enumerate() {
        let _ = writeln!(text, "const TEXTURE_{} = {number}u;", name.to_uppercase());
    }
    text += "// The textures of layers begin here; their numbers are relative to it.\n";
    let _ = writeln!(text, "const FIRST_LAYER_TEXTURE = {SURFACE_TEXTURES}u;");
    let _ = writeln!(text, "const LAYER_TEXTURES = {}u;", layers.len());
    for (number, name) in layers.iter().enumerate() {
        let _ = writeln!(text, "const LAYER_{} = {number}u;", name.to_uppercase());
    }
    text
}

/// Numbers and masks of the outputs: what `shared/outputs.wgsl` includes. `outputs` are the keys with what drives them, in
/// the order of their numbers; `None` stands for those that there are.
pub fn output_wgsl(outputs: Option<&[(&str, Kind)]>) -> String {
    let own: Vec<_> = (Output::ALL.iter())
        .map(|output| (output.key(), output.kind()))
        .collect();
    let outputs = outputs.unwrap_or(&own);
    let mut text = String::new();
    let (mut stored, mut vectors) = (0u64, 0u64);
    for (number, &(key, kind)) in outputs.iter().enumerate() {
        let _ = writeln!(text, "const OUTPUT_{} = {number}u;", key.to_uppercase());
        let is_bump = key == Output::BUMP.key();
        stored |= u64::from(!is_bump) << number;
        vectors |= u64::from(is_bump || kind != Kind::Scalar) << number;
    }
    let low = |bits: u64| bits as u32 & (Outputs::MORE - 1);
    let more = |bits: u64| (bits >> Outputs::LOW) as u32;
    let has_more = outputs.len() > Outputs::LOW as usize;
    let rows = [
        (
            "OUTPUTS_LOW",
            Outputs::LOW,
            "so many have their bits in the first word",
        ),
        (
            "OUTPUTS_MORE",
            Outputs::MORE,
            "in the first word: there is a second one",
        ),
        (
            "OUTPUTS",
            Outputs::MORE | (Outputs::MORE - 1),
            "what a path keeps of a head's flags",
        ),
        (
            "OUTPUTS_STORED",
            low(stored),
            "results of the program; a bump is computed from several",
        ),
        (
            "OUTPUTS_STORED_MORE",
            more(stored),
            "the same in the second word",
        ),
        (
            "OUTPUT_VECTORS",
            low(vectors),
            "results of three components; those of the others have one",
        ),
        (
            "OUTPUT_VECTORS_MORE",
            more(vectors),
            "the same in the second word",
        ),
        ("HEAD_WORDS", HEAD_WORDS, "of a material's head"),
        ("HEAD_OUTPUTS", HEAD_LINKS, "link word of each output"),
    ];
    for (name, value, meaning) in rows {
        let _ = writeln!(text, "const {name} = {value:#x}u; // {meaning}");
    }
    let _ = writeln!(text, "const HAS_MORE_OUTPUTS = {has_more};");
    text
}

/// Where the values of nodes lie that the film keeps, from the first field of results on.
#[cfg(test)]
fn node_field_wgsl() -> String {
    format!("const FIRST_NODE_FIELD = {}u;\n", super::MOST_RESULT_FIELDS)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file that doesn't fit the tables is written anew; the test has to be run again then.
    #[test]
    fn generated_files_are_what_the_tables_say() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/passes/generated");
        let files = [
            ("material.wgsl", material_wgsl()),
            ("outputs.wgsl", output_wgsl(None)),
            ("node_fields.wgsl", node_field_wgsl()),
        ];
        let mut changed = Vec::new();
        for (name, text) in files {
            let text = format!(
                "// From the tables of `material_record`; `cargo test -p engine generated` writes it.\n{text}"
            );
            let path = std::path::Path::new(folder).join(name);
            // Git may have changed the ends of lines.
            let is_same = std::fs::read_to_string(&path)
                .is_ok_and(|found| found.replace("\r\n", "\n") == text);
            if !is_same {
                std::fs::write(&path, text).expect("the file can be written");
                changed.push(name);
            }
        }
        assert!(changed.is_empty(), "written anew: {}", changed.join(", "));
    }
}
