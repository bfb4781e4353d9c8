//! What is the same in all lanes, and what each has of its own.

use super::flow::{Flow, Sets};
use crate::ir::{Function, Instruction, Type, Value, Variable};

/// What a value is in the text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A scalar.
    Uniform,
    /// A vector.
    Lanes,
    /// An address.
    Pointer(Pointer),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Pointer {
    /// The address that is the same in all lanes from which this one counts: itself, if it doesn't vary.
    pub(super) base: Value,
    /// Whether it leads to memory that each lane has of its own.
    pub(super) is_own: bool,
    /// Whether it is an address and a vector of bytes, which is what is written for it.
    pub(super) varies: bool,
    /// Bytes of the element that it leads into, and where in it, if that is known.
    pub(super) element: Option<(u32, i32)>,
}

/// The kind of each value, and whether each variable is a scalar; `index` is the variable that says which invocation runs.
/// None where addresses come from what lanes know, or from variables.
///
/// A variable is the same in all lanes that read it if only such values are set, and never while a lane waits elsewhere for
/// what it was.
pub(super) fn kinds(
    function: &Function,
    index: Variable,
    flow: &Flow,
    free: &Sets,
) -> Option<(Vec<Kind>, Vec<bool>)> {
    let mut uniform = vec![true; function.variable_types.len()];
    uniform[index.0 as usize] = false;
    let mut sets = Vec::new();
    for block in 0..flow.count() {
        for instruction in &function.instructions[flow.range(block)] {
            if let Instruction::Set { variable, value } = *instruction {
                uniform[variable.0 as usize] &= free.has(block, variable.0 as usize);
                sets.push((variable, value));
            }
        }
    }
    loop {
        let kinds = of_values(function, index, &uniform)?;
        let mut changed = false;
        for &(variable, value) in &sets {
            let uniform = &mut uniform[variable.0 as usize];
            changed |= *uniform && kinds[value.0 as usize] != Kind::Uniform;
            *uniform &= kinds[value.0 as usize] == Kind::Uniform;
        }
        if !changed {
            return Some((kinds, uniform));
        }
    }
}

fn of_values(function: &Function, index: Variable, uniform: &[bool]) -> Option<Vec<Kind>> {
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
            Instruction::Parameter { .. } if ty == Type::Pointer => start(false),
            Instruction::Parameter { .. } => Kind::Uniform,
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
                    _ if is_pointer && variable != index => return None,
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
pub(super) fn pointer(kinds: &[Kind], value: Value) -> Option<Pointer> {
    match kinds[value.0 as usize] {
        Kind::Pointer(pointer) => Some(pointer),
        _ => None,
    }
}
