//! Jumps as nested blocks: those forward leave a labelled block, those back continue a loop. Programs come from structured
//! text in its order, so both nest once blocks begin early enough, as they do for WebAssembly.

use crate::ir::{Function, Label};

/// A labelled block or loop, as a range of instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Scope {
    pub(super) start: usize,
    /// The first instruction behind it.
    pub(super) end: usize,
    pub(super) label: Label,
    pub(super) is_loop: bool,
}

/// All scopes, outer ones first. None if a loop is entered other than by its head.
pub(super) fn scopes(function: &Function, positions: &[usize]) -> Option<Vec<Scope>> {
    let labels = function.labels as usize;
    // Of each label, the first jump to it from before, and the instruction behind the last from below.
    let mut first = vec![usize::MAX; labels];
    let mut last = vec![0; labels];
    for (position, instruction) in function.instructions.iter().enumerate() {
        instruction.targets(|label| {
            let label = label.0 as usize;
            let target = positions[label];
            if target > position + 1 {
                first[label] = first[label].min(position);
            } else if target <= position {
                last[label] = position + 1;
            }
        });
    }
    let mut scopes = Vec::new();
    for label in 0..labels {
        let (at, name) = (positions[label], Label(label as u32));
        if last[label] > 0 {
            scopes.push(Scope {
                start: at,
                end: last[label],
                label: name,
                is_loop: true,
            });
        }
        if first[label] != usize::MAX {
            scopes.push(Scope {
                start: first[label],
                end: at,
                label: name,
                is_loop: false,
            });
        }
    }
    nest(&mut scopes).then(|| {
        scopes.sort_by_key(|scope| (scope.start, usize::MAX - scope.end, scope.is_loop));
        scopes
    })
}

/// Blocks that begin inside another scope and end behind it begin with that scope. False if that can't be done.
fn nest(scopes: &mut [Scope]) -> bool {
    loop {
        let mut changed = false;
        for inner in 0..scopes.len() {
            for outer in 0..scopes.len() {
                let (a, b) = (scopes[inner], scopes[outer]);
                if b.start < a.start && a.start < b.end && a.end > b.end {
                    if a.is_loop {
                        return false;
                    }
                    scopes[inner].start = b.start;
                    changed = true;
                }
            }
        }
        if !changed {
            return true;
        }
    }
}

/// Where a value is made and where it is needed, as places in the list of scopes; `None` is the function itself.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Home {
    /// The innermost scope that holds its making and all uses.
    pub(super) declared: Option<usize>,
    /// The innermost scope that holds its making.
    pub(super) made: Option<usize>,
    pub(super) is_used: bool,
}

/// The home of each value.
pub(super) fn homes(function: &Function, scopes: &[Scope]) -> Vec<Home> {
    let values = function.value_types.len();
    let mut homes = vec![Home::default(); values];
    // The scopes around a value's making that are still open at its last use so far.
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); values];
    let mut open: Vec<usize> = Vec::new();
    let mut next = 0;
    for (position, instruction) in function.instructions.iter().enumerate() {
        while open.last().is_some_and(|&s| scopes[s].end <= position) {
            open.pop();
        }
        while next < scopes.len() && scopes[next].start == position {
            open.push(next);
            next += 1;
        }
        // Loops' values are set by variables, so whatever is used was made before, in the order of the text.
        for used in instruction.clone().operands() {
            let used = used.0 as usize;
            let path = &mut around[used];
            while path.last().is_some_and(|&s| scopes[s].end <= position) {
                path.pop();
            }
            homes[used].declared = path.last().copied();
            homes[used].is_used = true;
        }
        if let Some(made) = instruction.result() {
            let made = made.0 as usize;
            around[made].clone_from(&open);
            homes[made].declared = open.last().copied();
            homes[made].made = open.last().copied();
        }
    }
    homes
}
