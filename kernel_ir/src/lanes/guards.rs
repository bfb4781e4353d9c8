//! Which blocks stand together: those through which the same lanes go need one mask and one test.

use crate::ir::{Binary, Function, Instruction, Unary};

use super::flow::Flow;

/// What is less work than this is done without looking for lanes that need it.
const CHEAP: u32 = 8;

/// Blocks that are nested in braces: a loop, or blocks under one mask.
#[derive(Debug, Clone, Copy)]
pub struct Guard {
    /// Blocks: the first, and the one behind the last.
    pub start: usize,
    #[expect(missing_docs, reason = "with the one before")]
    pub end: usize,
    /// Whether it runs again until no lane waits at its head.
    pub is_loop: bool,
    /// Whether it is worth looking if there are lanes, or has to be done.
    pub is_tested: bool,
}

impl Guard {
    pub(super) fn holds(&self, block: usize) -> bool {
        (self.start..self.end).contains(&block)
    }
}

/// Guards, outer ones first, and of each block the first of those under the same mask: zero is all lanes.
pub(super) fn guards(function: &Function, flow: &Flow) -> (Vec<Guard>, Vec<usize>) {
    let count = flow.count();
    let dominators = flow.dominators();
    let postdominators: Vec<_> = (0..flow.loops.len())
        .map(Some)
        .chain([None])
        .map(|of| flow.postdominators(of))
        .collect();
    let loop_guards = flow.loops.iter().map(|l| Guard {
        start: l.head,
        end: l.end,
        is_loop: true,
        is_tested: true,
    });
    // Blocks before which a guard has to end, so that guards nest.
    let mut limits = vec![usize::MAX; count];
    'again: loop {
        let mut roots: Vec<Option<usize>> = vec![None; count];
        let mut guards: Vec<Guard> = loop_guards.clone().collect();
        for first in 0..count {
            if roots[first].is_some() {
                continue;
            }
            roots[first] = Some(first);
            let innermost = flow.innermost(first);
            let behind = &postdominators[innermost.unwrap_or(flow.loops.len())];
            let mut last = first;
            // A block that others reach mustn't be skipped with this one.
            let alike = (first + 1..count)
                .filter(|&block| !flow.before[block].is_empty())
                .take_while(|&block| dominators.has(block, first))
                .filter(|&block| {
                    block < limits[first]
                        && behind.has(first, block)
                        && flow.innermost(block) == innermost
                });
            for block in alike {
                if roots[block].is_none() {
                    roots[block] = Some(first);
                    last = block;
                }
            }
            if first == 0 {
                continue;
            }
            let (start, end) = (first, last + 1);
            let holds_loop = flow.loops.iter().any(|l| start < l.head && l.head < end);
            guards.push(Guard {
                start,
                end,
                is_loop: false,
                is_tested: holds_loop || cost(function, flow, start..end) > CHEAP,
            });
        }
        guards.sort_by_key(|guard| (guard.start, usize::MAX - guard.end, !guard.is_loop));
        for (index, outer) in guards.iter().enumerate() {
            for inner in &guards[index + 1..] {
                if inner.start < outer.end && inner.end > outer.end {
                    limits[outer.start] = inner.start;
                    continue 'again;
                }
            }
        }
        let roots = roots.into_iter().map(|root| root.unwrap_or(0)).collect();
        return (guards, roots);
    }
}

/// Has the guard that begins with a block look for lanes, however little work it is. There is none where all lanes go.
pub(super) fn always_look(guards: &mut [Guard], start: usize) {
    let mut of_block = guards.iter_mut().filter(|guard| guard.start == start);
    if let Some(guard) = of_block.find(|guard| !guard.is_loop) {
        guard.is_tested = true;
    }
}

/// About how long some blocks take.
fn cost(function: &Function, flow: &Flow, blocks: std::ops::Range<usize>) -> u32 {
    let instructions = flow.starts[blocks.start]..flow.range(blocks.end - 1).end;
    let of = |instruction: &Instruction| match instruction {
        Instruction::Constant { .. }
        | Instruction::Words { .. }
        | Instruction::Label(_)
        | Instruction::Get { .. }
        | Instruction::Jump(_)
        | Instruction::Offset { .. } => 0,
        Instruction::Load { .. } => 4,
        Instruction::Binary {
            op:
                Binary::FloatDivide
                | Binary::UnsignedDivide
                | Binary::UnsignedRemainder
                | Binary::SignedDivide
                | Binary::SignedRemainder,
            ..
        }
        | Instruction::Unary {
            op: Unary::Sqrt, ..
        } => 5,
        Instruction::Branch { .. } | Instruction::Switch { .. } => 3,
        Instruction::Store { .. }
        | Instruction::Atomic { .. }
        | Instruction::CompareExchange { .. }
        | Instruction::Call { .. }
        | Instruction::CallRuntime { .. } => 100,
        _ => 1,
    };
    function.instructions[instructions].iter().map(of).sum()
}
