//! The order in which programs use textures.

use texgen::{Graph, NodeId};

use super::Output;
use super::wiring::{CompileError, Wiring};

/// Numbers of all textures, each where the programs use it on average: at the beginning or at the end.
pub(super) fn order<'a>(
    graph: &Graph,
    materials: impl Iterator<Item = &'a Wiring>,
) -> Result<Vec<usize>, CompileError> {
    // Sum of the places, 0 to 1, and their number.
    let mut places = vec![(0.0, 0_u32); graph.library().textures().len()];
    for wiring in materials {
        let bump: Vec<NodeId> = wiring.output(Output::BUMP).iter().map(|s| s.node).collect();
        for roots in [wiring.roots(), bump] {
            let program = graph.compile(&roots)?;
            // The words were just made from this library.
            let instructions = program.instructions(graph.library()).unwrap_or_default();
            let last = instructions.len().max(2) - 1;
            for (at, instruction) in instructions.iter().enumerate() {
                let (sum, count) = &mut places[instruction.texture];
                *sum += at as f64 / last as f64;
                *count += 1;
            }
        }
    }
    // Those that nothing uses yet come last.
    let mean = |&(sum, count): &(f64, u32)| match count {
        0 => 2.0,
        _ => sum / f64::from(count),
    };
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| mean(&places[a]).total_cmp(&mean(&places[b])));
    Ok(order)
}
