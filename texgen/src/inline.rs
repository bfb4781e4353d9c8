//! The inlined form of the kernel, for comparison: what renderers without a graph in data do.
//!
//! Every constant and every link of the graph is pasted into the text, one function per program, so every edit needs the
//! kernel to be built again. It gives the same results from the same host functions; a host that wants ambient occlusion
//! traced inside, as such renderers do, traces it in its `patina_attr_AO`. Nothing but benchmarks and tests needs this.

use std::collections::HashMap;
use std::fmt::Write;

use crate::args;
use crate::emit::{self, Emitter, GeneratedKernel};
use crate::graph::{Graph, Link, NodeId};
use crate::graph_error::GraphError;
use crate::program::{Instruction, compile};
use crate::rewrite::attribute_read;
use crate::value::{ParameterType, Value};

/// A kernel whose `patina_run_program(k)` evaluates the roots `programs[k]`, with the graph pasted in. The result of
/// the i-th root is in slot i. Ramps and arrays are read from the fake stack as ever.
///
/// # Errors
/// As [`Graph::compile`].
pub fn emit_inlined(graph: &Graph, programs: &[Vec<Link>]) -> Result<GeneratedKernel, GraphError> {
    let library = graph.library();
    let slots = programs.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let mut emitter = Emitter::new(library, slots);
    let names = emit::section_names(library);
    for (texture, name) in library.textures().iter().zip(&names) {
        emitter.section(texture, name);
    }
    let by_block: HashMap<u32, NodeId> = graph
        .ids()
        .map(|id| (graph.nodes()[id.index()].block, id))
        .collect();
    for (number, roots) in programs.iter().enumerate() {
        let program = compile(graph, roots)?;
        // The words were just made from this library.
        let instructions = program.instructions(library).unwrap_or_default();
        emitter.line("");
        emitter.line(&format!("fn patina_program_{number}() {{"));
        // The variable that holds what is in each slot now.
        let mut holder: HashMap<u32, String> = HashMap::new();
        for (place, instruction) in instructions.iter().enumerate() {
            let texture = &library.textures()[instruction.texture];
            if let Some([ao, ao1]) = instruction.occlusion {
                emitter.line(&format!("    patina_occlusion = vec2u({ao}u, {ao1}u);"));
            }
            if texture.rewrite().guards_loops {
                emitter.line("    patina_loops = 0u;");
            }
            let arguments = arguments(
                graph,
                by_block.get(&instruction.args).copied(),
                instruction,
                &holder,
            );
            let call = format!("{}__userProc({arguments})", names[instruction.texture]);
            emitter.line(&format!("    let r{place} = {call};"));
            let first = emit::first_result(&format!("r{place}"), texture);
            emitter.line(&format!("    let n{place} = {first};"));
            if texture.rewrite().guards_loops {
                let number = instruction.texture + 1;
                emitter.line(&format!(
                    "    if patina_loops > patina_loop_limit {{ patina_overrun = {number}u; }}"
                ));
            }
            emitter.line(&format!(
                "    patina_check(n{place}, {}u);",
                instruction.args
            ));
            holder.insert(instruction.slot, format!("n{place}"));
            for &(number, slot) in &instruction.further {
                let output = &texture.outputs()[number];
                let value = emit::stored(&format!("r{place}.{}", output.name), output.ty);
                emitter.line(&format!("    let n{place}_{number} = {value};"));
                emitter.line(&format!(
                    "    patina_check(n{place}_{number}, {}u);",
                    instruction.args
                ));
                holder.insert(slot, format!("n{place}_{number}"));
            }
        }
        for (root, slot) in program.results.iter().enumerate() {
            emitter.line(&format!("    patina_stack[{root}] = {};", holder[slot]));
        }
        emitter.line("}");
    }
    emitter.line("");
    emitter.line("fn patina_run_program(number: u32) {");
    emitter.line("    switch number {");
    for number in 0..programs.len() {
        emitter.line(&format!(
            "        case {number}u: {{ patina_program_{number}(); }}"
        ));
    }
    emitter.line("        default: {}");
    emitter.line("    }");
    emitter.line("}");
    Ok(emitter.finish())
}

/// The arguments of a node's call.
fn arguments(
    graph: &Graph,
    node: Option<NodeId>,
    instruction: &Instruction,
    holder: &HashMap<u32, String>,
) -> String {
    let Some(node) = node else {
        return String::new();
    };
    let texture = graph.texture(node);
    let offsets = args::offsets(texture.parameters());
    let arguments: Vec<String> = texture
        .parameters()
        .iter()
        .enumerate()
        .map(|(place, parameter)| {
            if let Some(&(_, word)) = instruction
                .links
                .iter()
                .find(|(linked, _)| *linked == place)
            {
                let value = emit::linked(&swizzled(word, holder), parameter.ty);
                return match parameter.is_coordinate() {
                    true => format!("patina_place({value}, {})", emit::own_pixel(parameter)),
                    false => value,
                };
            }
            if let Some(attribute) = graph.attribute(node, &parameter.name) {
                let value = emit::linked(&attribute_read(attribute), parameter.ty);
                return match parameter.is_coordinate() {
                    true => format!("vec4f({value}.xyz, {})", emit::own_pixel(parameter)),
                    false => value,
                };
            }
            let at = instruction.args + offsets[place];
            match parameter.ty {
                ParameterType::Ramp => format!("ramp1D({}u)", graph.args()[at as usize]),
                ParameterType::Array(..) => format!("{at}u"),
                ty => {
                    let value = graph.value(node, &parameter.name);
                    let value = value.map_or(String::new(), |value| literal(value, ty));
                    match parameter.is_coordinate() {
                        true => format!("vec4f({value}.xyz, {})", emit::own_pixel(parameter)),
                        false => value,
                    }
                }
            }
        })
        .collect();
    arguments.join(", ")
}

/// A link's `vec4f` from the variable that holds its source (see [`link_word`](crate::link_word)).
fn swizzled(word: u32, holder: &HashMap<u32, String>) -> String {
    let source = holder[&(word & 0xffff)].clone();
    if word >> 31 == 0 {
        return source;
    }
    let component = |i: u32| match word >> (16 + 3 * i) & 7 {
        4 => "0.0".to_owned(),
        5 => "1.0".to_owned(),
        selector => format!("{source}.{}", ["x", "y", "z", "w"][selector as usize & 3]),
    };
    format!(
        "vec4f({}, {}, {}, {})",
        component(0),
        component(1),
        component(2),
        component(3)
    )
}

/// A constant as WGSL.
fn literal(value: &Value, ty: ParameterType) -> String {
    let floats = |values: &[f32]| {
        let mut text = format!("{ty}(");
        for value in values {
            let _ = write!(text, "{value:?}f, ");
        }
        text + ")"
    };
    match value {
        Value::F32(value) => format!("{value:?}f"),
        // The least i32 can't be written as a literal.
        Value::I32(value) => format!("bitcast<i32>({}u)", *value as u32),
        Value::U32(value) => format!("{value}u"),
        Value::Bool(value) => value.to_string(),
        Value::Vec2(value) => floats(value),
        Value::Vec3(value) => floats(value),
        Value::Vec4(value) => floats(value),
        Value::Mat3(columns) => floats(columns.as_flattened()),
        Value::Mat4(columns) => floats(columns.as_flattened()),
        Value::Image(handle) => format!("sam2D({handle}u)"),
        Value::Ramp(_) | Value::Array(_) => String::new(), // read from the fake stack
    }
}
