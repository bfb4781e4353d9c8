//! What is the same in all lanes, and what each has of its own.

use super::flow::{Flow, Sets};
use crate::ir::{Function, Instruction, Type, Value, Variable};

/// What a value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A scalar.
    Uniform,
    /// A vector.
    Lanes,
    /// An address.
    Pointer(Pointer),
}

/// What is known of an address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pointer {
    /// The address that is the same in all lanes from which this one counts: itself, if it doesn't vary.
    pub base: Value,
    /// Whether it leads to memory that each lane has of its own.
    pub is_own: bool,
    /// Whether it is an address and a vector of bytes, which is what is written for it.
    pub varies: bool,
    /// Bytes of the element that it leads into, and where in it, if that is known.
    pub element: Option<(u32, i32)>,
}

/// How a function gets a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Passed {
    /// A scalar for all lanes.
    Uniform,
    /// A scalar for each.
    Lanes,
    /// The address of memory that all share.
    Shared,
    /// The address of memory of which each lane has its own.
    Own,
}

/// The kind of each value, whether each variable is a scalar, and which blocks all lanes run together; `index` is the variable that
/// says which invocation runs, if it is an entry point. None where addresses come from what lanes know, or from variables.
///
/// A variable is the same in all lanes that read it if only such values are set, and never while a lane waits elsewhere for
/// what it was.
pub(super) fn kinds(
    function: &Function,
    index: Option<Variable>,
    passed: &[Passed],
    flow: &Flow,
    free: &Sets,
) -> Option<(Vec<Kind>, Vec<bool>, Vec<bool>)> {
    let mut uniform = vec![true; function.variable_types.len()];
    if let Some(index) = index {
        uniform[index.0 as usize] = false;
    }
    let mut sets = Vec::new();
    for block in 0..flow.count() {
        for instruction in &function.instructions[flow.range(block)] {
            if let Instruction::Set { variable, value } = *instruction {
                sets.push((block, variable, value));
            }
        }
    }
    loop {
        let kinds = of_values(function, index, passed, &uniform)?;
        let is_uniform = |value: Value| kinds[value.0 as usize] == Kind::Uniform;
        let converged = flow.converged(function, &is_uniform);
        let mut changed = false;
        for &(block, variable, value) in &sets {
            let is_for_all = converged[block] || free.has(block, variable.0 as usize);
            let stays = is_for_all && is_uniform(value);
            let uniform = &mut uniform[variable.0 as usize];
            changed |= *uniform && !stays;
            *uniform &= stays;
        }
        if !changed {
            return Some((kinds, uniform, converged));
        }
    }
}

fn of_values(
    function: &Function,
    index: Option<Variable>,
    passed: &[Passed],
    uniform: &[bool],
) -> Option<Vec<Kind>> {
    let mut kinds = vec![Kind::Lanes; function.value_types.len()];
    for instruction in &function.instructions {
        let Some(to) = instruction.result() else {
            continue;
        };
        let ty = function.value_types[to.0 as usize];
        let is_uniform = |value: Value| kinds[value.0 as usize] == Kind::Uniform;
        let pointer = |value: Value| match kinds[value.0 as usize] {
            Kind::Pointer(pointer) => Some(pointer),
            _ => None,
        };
        let start = |is_own| {
            Kind::Pointer(Pointer {
                base: to,
                is_own,
                varies: false,
                element: None,
            })
        };
        kinds[to.0 as usize] = match *instruction {
            Instruction::Constant { .. } => Kind::Uniform,
            Instruction::Words { .. } => start(false),
            Instruction::Parameter { index, .. } => match passed[index as usize] {
                Passed::Uniform => Kind::Uniform,
                Passed::Lanes => Kind::Lanes,
                Passed::Shared => start(false),
                Passed::Own => start(true),
            },
            Instruction::StackAddress { .. } => start(true),
            Instruction::Offset { base, bytes, .. } => {
                let from = pointer(base)?;
                Kind::Pointer(Pointer {
                    base: if from.varies { from.base } else { to },
                    element: from.element.map(|(stride, at)| (stride, at + bytes)),
                    ..from
                })
            }
            Instruction::Element {
                base,
                index,
                stride,
                ..
            } => {
                let from = pointer(base)?;
                let varies = from.varies || !is_uniform(index);
                Kind::Pointer(Pointer {
                    base: if varies { from.base } else { to },
                    is_own: from.is_own,
                    varies,
                    element: Some((stride, 0)),
                })
            }
            Instruction::Load { base, .. } => {
                let from = pointer(base)?;
                let is_same = !from.is_own && !from.varies;
                match ty {
                    Type::Pointer => is_same.then(|| start(false))?,
                    _ if is_same => Kind::Uniform,
                    _ => Kind::Lanes,
                }
            }
            Instruction::Get { variable, .. } => {
                let is_pointer = function.variable_types[variable.0 as usize] == Type::Pointer;
                match uniform[variable.0 as usize] {
                    _ if is_pointer && Some(variable) != index => return None,
                    true => Kind::Uniform,
                    false => Kind::Lanes,
                }
            }
            Instruction::Select { .. } if ty == Type::Pointer => return None,
            Instruction::Unary { .. }
            | Instruction::Binary { .. }
            | Instruction::Compare { .. }
            | Instruction::Select { .. } => {
                let mut taken = instruction.clone();
                match taken.operands().iter().all(|value| is_uniform(**value)) {
                    true => Kind::Uniform,
                    false => Kind::Lanes,
                }
            }
            Instruction::CallRuntime { ref arguments, .. } => {
                match arguments.iter().all(|&value| is_uniform(value)) {
                    true => Kind::Uniform,
                    false => Kind::Lanes,
                }
            }
            _ => Kind::Lanes,
        };
    }
    Some(kinds)
}

/// What is known of an address.
pub fn pointer(kinds: &[Kind], value: Value) -> Option<Pointer> {
    match kinds[value.0 as usize] {
        Kind::Pointer(pointer) => Some(pointer),
        _ => None,
    }
}
