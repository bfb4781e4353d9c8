//! Programs and arguments of a look in words: the data that the kernel reads, decoded.

use std::fmt::Write;

use engine::procedural::{
    FLAG_BLEND, FLAG_CONSTANT_MASK, HEAD_BASE, HEAD_BUMP_PROGRAM, HEAD_FLAGS, HEAD_LINKS,
    HEAD_MASK, HEAD_MASK_VALUE, HEAD_OVER, HEAD_PROGRAM, HEAD_WORDS, Procedural,
};
use engine::scene::Scene;
use texgen::{Graph, Instruction, NodeId, ParameterType, Program, TextureType, Widget};

use super::{counted, written};

/// Longest constant shown inside an instruction; the arguments show it whole.
const LONGEST: usize = 24;

/// The programs of all materials that have one or are blends.
pub(super) fn of_materials(procedural: &Procedural, scene: &Scene) -> String {
    let mut text = String::new();
    for (index, material) in (0u32..).zip(&scene.materials) {
        if !procedural.is_procedural(index) {
            continue;
        }
        let head = |word: u32| procedural.programs()[(index * HEAD_WORDS + word) as usize];
        let flags = head(HEAD_FLAGS);
        let _ = writeln!(text, "material {}", material.name);
        for (word, title) in [
            (HEAD_PROGRAM, "program"),
            (HEAD_BUMP_PROGRAM, "program of the bump height"),
        ] {
            if head(word) != 0 {
                let words = procedural.programs()[head(word) as usize..].to_vec();
                let program = Program {
                    words,
                    ..Program::default()
                };
                text += &instructions(procedural.graph(), &program, title);
            }
        }
        for output in procedural.outputs(index).iter() {
            let from = link(head(HEAD_LINKS + output.number()));
            let _ = writeln!(text, "    {} = {from}", output.key());
        }
        if flags & FLAG_BLEND != 0 {
            let mask = match flags & FLAG_CONSTANT_MASK {
                0 => link(head(HEAD_MASK)),
                _ => written::number(f32::from_bits(head(HEAD_MASK_VALUE))),
            };
            let name = |word| {
                let side = scene.materials.get(head(word) as usize);
                side.map_or("?", |side| side.name.as_str())
            };
            let _ = writeln!(
                text,
                "    blend: {mask} of {} over {}",
                name(HEAD_OVER),
                name(HEAD_BASE)
            );
        }
        text.push('\n');
    }
    text
}

/// A program's instructions, one per line.
pub(super) fn instructions(graph: &Graph, program: &Program, title: &str) -> String {
    let library = graph.library();
    let Ok(decoded) = program.instructions(library) else {
        return format!("    {title}: can't be decoded\n");
    };
    let slots = (decoded.iter())
        .flat_map(|one| {
            one.further
                .iter()
                .map(|further| further.1)
                .chain([one.slot])
        })
        .max()
        .map_or(0, |last| last + 1);
    let mut text = format!(
        "    {title}: {}, {}\n",
        counted(decoded.len(), "instruction"),
        counted(slots as usize, "stack slot")
    );
    for instruction in &decoded {
        let texture = &library.textures()[instruction.texture];
        let node = node_of(graph, instruction);
        let mut arguments = Vec::new();
        for (place, parameter) in texture.parameters().iter().enumerate() {
            let linked = instruction.links.iter().find(|(p, _)| *p == place);
            let shown = match (linked, node) {
                (Some((_, word)), _) => link(*word),
                (None, Some(node)) => constant(graph, node, &parameter.name, parameter.widget),
                (None, None) => continue,
            };
            let short = match shown.chars().count() > LONGEST {
                true => "...".to_owned(),
                false => shown,
            };
            arguments.push(format!("{} = {short}", parameter.name));
        }
        if let Some([ao, ao1]) = instruction.occlusion {
            arguments.push(format!("AO slots {ao} and {ao1}"));
        }
        let _ = writeln!(
            text,
            "        {} = {}: {}({})  args at {}",
            slots_of(instruction, texture),
            node.map_or("?", |node| graph.name(node)),
            texture.name(),
            arguments.join(", "),
            instruction.args
        );
    }
    text
}

/// Where results go: `s2`, or of several outputs `s2, s3 (color)`.
fn slots_of(instruction: &Instruction, texture: &TextureType) -> String {
    let mut text = format!("s{}", instruction.slot);
    for (number, slot) in &instruction.further {
        let name = texture.outputs().get(*number).map_or("?", |o| &o.name);
        let _ = write!(text, ", s{slot} ({name})");
    }
    text
}

/// Where each node's arguments lie, with their values.
pub(super) fn arguments(graph: &Graph) -> String {
    let mut text = String::from("  word  parameter           type       value\n");
    for node in graph.ids() {
        let texture = graph.texture(node);
        let block = graph.block(node);
        let _ = writeln!(text, "node {} ({})", graph.name(node), texture.name());
        for (parameter, words) in texture.parameters().iter().zip(texture.argument_layout()) {
            let at = block.start + words.start;
            let mut value = constant(graph, node, &parameter.name, parameter.widget);
            if parameter.ty == ParameterType::Ramp {
                let stops = graph.args().get(at as usize).copied().unwrap_or(0);
                value = format!("stops at word {stops}: {value}");
            }
            if let Some(source) = graph.link(node, &parameter.name) {
                let swizzle = source.swizzle.map_or(String::new(), |s| s.to_string());
                value = format!("from node {}{swizzle}", graph.name(source.source));
            }
            let _ = writeln!(
                text,
                "{at:6}  {:18}  {:9}  {value}",
                parameter.name,
                parameter.ty.to_string()
            );
        }
    }
    let _ = writeln!(text, "{} words in all", graph.args().len());
    text
}

fn constant(graph: &Graph, node: NodeId, parameter: &str, widget: Widget) -> String {
    if let Some(attribute) = graph.attribute(node, parameter) {
        return format!("attribute {attribute}");
    }
    let value = graph.value(node, parameter);
    value.map_or_else(|| "not set".to_owned(), |v| written::value(v, widget))
}

/// The node whose instruction this is. Nodes without parameters have empty blocks, which may lie at one place.
fn node_of(graph: &Graph, instruction: &Instruction) -> Option<NodeId> {
    let texture = graph.library().textures().get(instruction.texture)?.name();
    graph.ids().find(|&node| {
        graph.block(node).start == instruction.args
            && graph.texture(node).name() == texture
            && instruction
                .occlusion
                .is_none_or(|slots| slots == graph.occlusion(node))
    })
}

/// A link word as text: the slot, and what is taken of it (`0` and `1` are constants).
fn link(word: u32) -> String {
    let slot = word & 0xffff;
    if word >> 31 == 0 {
        return format!("s{slot}");
    }
    let selector = |i: u32| match word >> (16 + 3 * i) & 7 {
        component @ 0..=3 => ["x", "y", "z", "w"][component as usize],
        4 => "0",
        _ => "1",
    };
    let selectors: String = (0..4).map(selector).collect();
    match selectors.strip_suffix(&selectors[..1].repeat(3)) {
        // One number for all components.
        Some(one) => format!("s{slot}.{one}"),
        None => format!("s{slot}.{selectors}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texgen::link_word;

    #[test]
    fn links_are_slots_with_components() {
        assert_eq!(link(link_word(3, None)), "s3");
        let swizzle = "yx".parse().expect("a swizzle");
        let text = link(link_word(2, Some(swizzle)));
        assert!(text.starts_with("s2.yx"), "{text}");
    }
}
