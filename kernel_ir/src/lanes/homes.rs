//! Where in the text values, variables and masks are declared: in the innermost braces around all that names them.

use super::{
    flow::{Flow, Sets, comes_in},
    guards::Guard,
    kinds::{Kind, pointer},
};
use crate::ir::{Function, Instruction, Variable};

/// Guards from the outermost in.
type Path = Vec<usize>;

/// Where what is declared: guards by their numbers, or none for all of the function.
#[derive(Debug)]
pub struct Homes {
    /// Of each value.
    pub values: Vec<ValueHome>,
    /// Of each variable; none for what is never touched.
    pub variables: Vec<Option<Option<usize>>>,
    /// Of the masks of blocks.
    pub masks: Vec<Option<usize>>,
}

/// Where a value is declared.
#[derive(Debug, Clone, Copy, Default)]
pub struct ValueHome {
    /// In which guard.
    pub at: Option<usize>,
    /// Whether anything takes it.
    pub is_used: bool,
    /// Where it is made, too.
    pub is_local: bool,
    /// Made in a loop and used behind it: lanes that have left keep what they had.
    pub outlives: bool,
}

fn meet(home: &mut Option<Path>, path: &[usize]) {
    match home {
        None => *home = Some(path.to_vec()),
        Some(home) => {
            let same = home.iter().zip(path).take_while(|(a, b)| a == b).count();
            home.truncate(same);
        }
    }
}

pub(super) fn homes(
    function: &Function,
    flow: &Flow,
    guards: &[Guard],
    kinds: &[Kind],
    live: &Sets,
    converged: &[bool],
) -> Homes {
    let values = function.value_types.len();
    let mut made: Vec<Path> = vec![Vec::new(); values];
    let mut used: Vec<Option<Path>> = vec![None; values];
    let mut touched: Vec<Option<Path>> = vec![None; function.variable_types.len()];
    let mut masked: Vec<Option<Path>> = vec![None; flow.count()];
    for block in 0..flow.count() {
        let path: Path = (0..guards.len())
            .filter(|&g| guards[g].holds(block))
            .collect();
        // A loop's head is waited at from outside of the loop, and of the guard that takes its mask.
        let own = |&&g: &&usize| guards[g].start == block;
        let outside = path.len() - path.iter().rev().take_while(own).count();
        meet(&mut masked[block], &path[..outside]);
        for &next in &flow.next[block] {
            meet(&mut masked[next], &path);
        }
        for instruction in &function.instructions[flow.range(block)] {
            for value in instruction.clone().operands() {
                meet(&mut used[value.0 as usize], &path);
                if let Some(pointer) = pointer(kinds, *value) {
                    meet(&mut used[pointer.base.0 as usize], &path);
                }
            }
            if let Some(to) = instruction.result() {
                made[to.0 as usize].clone_from(&path);
            }
            if let Instruction::Get { variable, .. } | Instruction::Set { variable, .. } =
                *instruction
            {
                meet(&mut touched[variable.0 as usize], &path);
            }
        }
    }
    let values = (made.iter().zip(used))
        .map(|(made, used)| {
            let is_used = used.is_some();
            let mut home = Some(made.clone());
            meet(&mut home, &used.unwrap_or_else(|| made.clone()));
            let home = home.unwrap_or_default();
            ValueHome {
                at: home.last().copied(),
                is_used,
                is_local: home.len() == made.len(),
                // From a loop that all leave together, nobody has gone before.
                outlives: (made[home.len()..].iter())
                    .any(|&g| guards[g].is_loop && !converged[guards[g].start]),
            }
        })
        .collect();
    let variables = (0..).zip(touched).map(|(variable, touched)| {
        let mut path = touched?;
        // What comes in from before was set before, if only in an earlier round.
        let is_outside = |&guard: &usize| {
            let start = guards[guard].start;
            comes_in(live, start, Variable(variable))
        };
        if let Some(first) = path.iter().position(is_outside) {
            path.truncate(first);
        }
        Some(path.last().copied())
    });
    Homes {
        values,
        variables: variables.collect(),
        masks: (masked.iter())
            .map(|path| path.as_ref().and_then(|path| path.last().copied()))
            .collect(),
    }
}
