//! What has to be known of a program to run several invocations of it at once, in the lanes of vectors.
//!
//! Blocks run in the order of the text, each under the mask of the lanes that wait for it, and a loop runs until no lane
//! waits at its head. What all lanes have in common stays a scalar, and where all take the same way they need no masks.

mod flow;
mod groups;
mod guards;
mod homes;
mod kinds;

use std::collections::HashSet;

use crate::ir::{Function, Instruction, Invocations, Program, Type, Value, Variable};

pub use flow::{Flow, Loop, Sets};
pub use groups::{Groups, LoadGroup, StoreGroup};
pub use guards::Guard;
pub use homes::{Homes, ValueHome};
pub use kinds::{Kind, Passed, Pointer, pointer};

/// Most bits of sets of blocks, one set for each block and loop: what is known of ways between blocks takes as much memory, and about as
/// many steps. The renderer's kernels have some millions.
const MOST_SETS: usize = 1 << 28;

/// A function as lanes see it.
#[derive(Debug)]
pub struct Analysis {
    /// Its blocks.
    pub flow: Flow,
    /// Which blocks stand together, outer guards first.
    pub guards: Vec<Guard>,
    /// Of each block, the first of those under the same mask.
    pub roots: Vec<usize>,
    /// Of each value.
    pub kinds: Vec<Kind>,
    /// Of each variable, whether it is a scalar.
    pub uniform: Vec<bool>,
    /// Of each block, whether all lanes run it together.
    pub converged: Vec<bool>,
    /// Where what is declared.
    pub homes: Homes,
    free: Sets,
}

impl Analysis {
    /// Of a function with these parameters; `index` is the variable that says which invocation runs, if it is an entry point.
    /// None for what can't run in lanes: addresses that lanes know, jumps that don't nest, and so many blocks that finding out would
    /// take too long.
    pub fn new(function: &Function, index: Option<Variable>, passed: &[Passed]) -> Option<Self> {
        let flow = Flow::new(function)?;
        let blocks = flow.count();
        let bits = blocks
            .saturating_mul(blocks)
            .saturating_mul(1 + flow.loops.len());
        if bits > MOST_SETS {
            return None;
        }
        let (mut guards, roots) = guards::guards(function, &flow);
        let live = flow.live(function);
        let free = flow.free(function, &live);
        let (kinds, uniform, converged) = kinds::kinds(function, index, passed, &flow, &free)?;
        // All lanes run such a block together, or none. What it sets for all mustn't be set where they are elsewhere.
        for block in (0..flow.count()).filter(|&block| converged[block]) {
            let is_needed = |set: &Instruction| matches!(*set, Instruction::Set { variable, .. } if !free.has(block, variable.0 as usize));
            if function.instructions[flow.range(block)]
                .iter()
                .any(is_needed)
            {
                guards::always_look(&mut guards, roots[block]);
            }
        }
        let homes = homes::homes(function, &flow, &guards, &kinds, &live, &converged);
        // Where no lane has made an address, none may be followed: what is done with those of other guards is done for lanes alone.
        let mut made = vec![0; function.value_types.len()];
        for block in 0..flow.count() {
            let instructions = &function.instructions[flow.range(block)];
            for to in instructions.iter().filter_map(Instruction::result) {
                made[to.0 as usize] = block;
            }
        }
        for block in (0..flow.count()).filter(|&block| !converged[block]) {
            let is_of_others = |value: Value| {
                let home = homes.values[value.0 as usize];
                let shared = pointer(&kinds, value).is_some_and(|p| !p.varies);
                shared && !home.is_local && !converged[made[value.0 as usize]]
            };
            let follows = |instruction: &Instruction| {
                let mut instruction = instruction.clone();
                let mut values = instruction.operands().into_iter();
                values.any(|value| {
                    let base = pointer(&kinds, *value).map(|pointer| pointer.base);
                    is_of_others(*value) || base.is_some_and(is_of_others)
                })
            };
            if function.instructions[flow.range(block)].iter().any(follows) {
                guards::always_look(&mut guards, roots[block]);
            }
        }
        // A scalar can't be one thing for the lanes that have left a loop, and another for those in it.
        let mut values = homes.values.iter().zip(&kinds);
        let is_two = |(home, kind): (&ValueHome, &Kind)| {
            home.outlives && home.is_used && *kind != Kind::Lanes
        };
        if values.any(is_two) {
            return None;
        }
        Some(Self {
            flow,
            guards,
            roots,
            kinds,
            uniform,
            converged,
            homes,
            free,
        })
    }

    /// Whether a variable may be set for all lanes in a block, since none needs what it was.
    pub fn is_free(&self, block: usize, variable: Variable) -> bool {
        self.converged[block] || self.free.has(block, variable.0 as usize)
    }

    /// Which accesses of memory that lanes share are done together; of the function that this was made of.
    pub fn groups(&self, function: &Function) -> Groups {
        groups::groups(function, &self.flow, &self.kinds)
    }

    /// Whether a value is the same in all lanes, and no address.
    pub fn is_uniform(&self, value: Value) -> bool {
        self.kinds[value.0 as usize] == Kind::Uniform
    }
}

/// How an entry point gets its parameters.
pub const ENTRY: [Passed; 5] = [
    Passed::Shared,
    Passed::Shared,
    Passed::Uniform,
    Passed::Uniform,
    Passed::Uniform,
];

/// An entry point without its loop: what one invocation does.
pub fn one_invocation(function: &Function, invocations: &Invocations) -> Option<Function> {
    let label = |label| {
        let mut instructions = function.instructions.iter();
        instructions.position(|instruction| *instruction == Instruction::Label(label))
    };
    let (head, next) = (label(invocations.head)?, label(invocations.next)?);
    let (before, rest) = function.instructions.split_at(head);
    let sets_index = |instruction: &&Instruction| !matches!(instruction, Instruction::Set { variable, .. } if *variable == invocations.index);
    let mut instructions: Vec<Instruction> = before.iter().filter(sets_index).cloned().collect();
    instructions.extend_from_slice(&rest[..=next - head]);
    instructions.push(Instruction::Return);
    Some(Function {
        instructions,
        ..function.clone()
    })
}

/// A function of a program, ready to be written in lanes.
#[derive(Debug)]
pub struct Planned {
    /// What it does; of the entry point, what one invocation does.
    pub function: Function,
    /// What is known of it.
    pub analysis: Analysis,
}

/// A program in lanes.
#[derive(Debug)]
pub struct Plan {
    /// Of each function; none for those that are there already, and what only they call.
    pub functions: Vec<Option<Planned>>,
    /// How each gets its parameters.
    pub passed: Vec<Vec<Passed>>,
}

impl Plan {
    /// `is_there` tells of functions by number whether they needn't be written: these get scalars for each lane. `once` tells of functions by name whether
    /// they are to be called once for each set of different arguments that lanes have, as scalars.
    ///
    /// None for programs that don't run in lanes.
    pub fn new(
        program: &Program,
        is_there: &dyn Fn(usize) -> bool,
        once: &dyn Fn(&str) -> bool,
    ) -> Option<Self> {
        let invocations = program.invocations?;
        let mut order = Vec::new();
        after(program, 0, &mut HashSet::new(), &mut order);
        let mut passed: Vec<Option<Vec<Passed>>> = vec![None; program.functions.len()];
        passed[0] = Some(ENTRY.to_vec());
        let mut functions: Vec<Option<Planned>> = Vec::new();
        functions.resize_with(program.functions.len(), || None);
        for &index in order.iter().rev() {
            let Some(own) = passed[index].clone() else {
                continue;
            };
            if is_there(index) {
                continue;
            }
            let (function, variable) = match index {
                0 => (
                    one_invocation(&program.functions[0], &invocations)?,
                    Some(invocations.index),
                ),
                _ => (program.functions[index].clone(), None),
            };
            let analysis = Analysis::new(&function, variable, &own)?;
            for instruction in &function.instructions {
                let Instruction::Call { callee, arguments } = instruction else {
                    continue;
                };
                let callee = function.callees[*callee as usize];
                let called = &program.functions[callee];
                let known = &mut passed[callee];
                for (at, (&argument, &ty)) in arguments.iter().zip(&called.parameters).enumerate() {
                    let kind = match (ty, analysis.kinds[argument.0 as usize]) {
                        (_, Kind::Pointer(pointer)) if pointer.varies => return None,
                        (_, Kind::Pointer(pointer)) if pointer.is_own => Passed::Own,
                        (_, Kind::Pointer(_)) => Passed::Shared,
                        (Type::Pointer, _) => return None,
                        _ if is_there(callee) => Passed::Lanes,
                        _ if once(&called.name) => Passed::Uniform,
                        (_, Kind::Uniform) => Passed::Uniform,
                        (_, Kind::Lanes) => Passed::Lanes,
                    };
                    let known = known.get_or_insert_with(Vec::new);
                    match known.get(at).copied() {
                        None => known.push(kind),
                        Some(Passed::Uniform) if kind == Passed::Lanes => known[at] = kind,
                        Some(Passed::Lanes) if kind == Passed::Uniform => {}
                        Some(known) if known == kind => {}
                        Some(_) => return None,
                    }
                }
            }
            functions[index] = Some(Planned { function, analysis });
        }
        let passed = passed.into_iter().map(Option::unwrap_or_default).collect();
        Some(Self { functions, passed })
    }
}

/// Functions that one calls, and itself behind them.
fn after(program: &Program, index: usize, seen: &mut HashSet<usize>, order: &mut Vec<usize>) {
    if seen.insert(index) {
        for &callee in &program.functions[index].callees {
            after(program, callee, seen, order);
        }
        order.push(index);
    }
}
