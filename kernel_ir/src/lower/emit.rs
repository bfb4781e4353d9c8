//! Writes instructions of one function. Operations on constants, and those that change nothing, leave no code.

use std::{collections::HashMap, sync::Arc};

use super::{fold, types::Part};
use crate::ir::{
    Binary, Comparison, Function, Instruction, Label, Memory, Runtime, Type, Unary, Value, Variable,
};

/// A scalar that an instruction takes: known now, or only when the code runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Operand {
    Constant(Type, u32),
    Value(Value),
}

/// A float.
pub(super) fn float(x: f32) -> Operand {
    Operand::Constant(Type::F32, x.to_bits())
}

/// An integer of either sign.
pub(super) fn int(x: u32) -> Operand {
    Operand::Constant(Type::I32, x)
}

/// A truth value.
pub(super) fn boolean(x: bool) -> Operand {
    Operand::Constant(Type::Bool, u32::from(x))
}

/// A place in memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Address {
    pub(super) base: Value,
    pub(super) offset: i32,
    pub(super) memory: Memory,
    /// The binding, if this is all of a buffer, or a member of it that isn't in an array.
    pub(super) binding: Option<usize>,
}

impl Address {
    /// So many bytes behind.
    pub(super) fn plus(self, bytes: u32) -> Self {
        Self {
            offset: self.offset.wrapping_add(bytes as i32),
            ..self
        }
    }
}

/// What is known of variables at a place in the code.
pub(super) type Known = HashMap<Variable, Operand>;

#[derive(Default)]
pub(super) struct Emitter {
    pub(super) function: Function,
    /// Variables that hold a constant here.
    pub(super) known: Known,
    /// Bytes of the function's memory that are in use here.
    stack_top: u32,
}

impl Emitter {
    /// Begins a function, whose parameters are the values that come back.
    pub(super) fn begin(name: &str, parameters: &[Type]) -> (Self, Vec<Value>) {
        let mut code = Self::default();
        code.function.name = name.to_owned();
        code.function.parameters = parameters.to_vec();
        let values = (0..)
            .zip(parameters)
            .map(|(index, &ty)| {
                let to = code.value(ty);
                code.push(Instruction::Parameter { to, index });
                to
            })
            .collect();
        (code, values)
    }

    pub(super) fn push(&mut self, instruction: Instruction) {
        self.function.instructions.push(instruction);
    }

    pub(super) fn value(&mut self, ty: Type) -> Value {
        self.function.value_types.push(ty);
        Value(self.function.value_types.len() as u32 - 1)
    }

    pub(super) fn variable(&mut self, ty: Type) -> Variable {
        self.function.variable_types.push(ty);
        Variable(self.function.variable_types.len() as u32 - 1)
    }

    /// One variable for each part, behind each other: the first.
    pub(super) fn variables(&mut self, parts: &[Part]) -> Variable {
        let first = Variable(self.function.variable_types.len() as u32);
        for part in parts {
            self.variable(part.ty);
        }
        first
    }

    pub(super) fn new_label(&mut self) -> Label {
        self.function.labels += 1;
        Label(self.function.labels - 1)
    }

    pub(super) fn label(&mut self, label: Label) {
        self.push(Instruction::Label(label));
    }

    pub(super) fn jump(&mut self, label: Label) {
        self.push(Instruction::Jump(label));
    }

    pub(super) fn branch(&mut self, condition: Operand, accept: Label, reject: Label) {
        let condition = self.materialize(condition);
        self.push(Instruction::Branch {
            condition,
            accept,
            reject,
        });
    }

    /// Memory of the function's own; it is free again at [`Emitter::release`].
    pub(super) fn allocate(&mut self, bytes: u64) -> Address {
        let offset = self.stack_top;
        // What is too much is found when all of it is summed up.
        let end = (u64::from(offset) + bytes).next_multiple_of(16);
        self.stack_top = u32::try_from(end).unwrap_or(u32::MAX);
        self.function.stack_bytes = self.function.stack_bytes.max(self.stack_top);
        let base = self.value(Type::Pointer);
        self.push(Instruction::StackAddress { to: base, offset });
        Address {
            base,
            offset: 0,
            memory: Memory::Plain,
            binding: None,
        }
    }

    pub(super) fn mark(&self) -> u32 {
        self.stack_top
    }

    pub(super) fn release(&mut self, mark: u32) {
        self.stack_top = mark;
    }

    /// The value of an operand.
    pub(super) fn materialize(&mut self, operand: Operand) -> Value {
        match operand {
            Operand::Value(value) => value,
            Operand::Constant(ty, bits) => {
                let to = self.value(ty);
                self.push(Instruction::Constant { to, ty, bits });
                to
            }
        }
    }

    pub(super) fn type_of(&self, operand: Operand) -> Type {
        match operand {
            Operand::Constant(ty, _) => ty,
            Operand::Value(value) => self.function.value_types[value.0 as usize],
        }
    }

    pub(super) fn set(&mut self, variable: Variable, operand: Operand) {
        match operand {
            Operand::Constant(..) => self.known.insert(variable, operand),
            Operand::Value(_) => self.known.remove(&variable),
        };
        let value = self.materialize(operand);
        self.push(Instruction::Set { variable, value });
    }

    pub(super) fn get(&mut self, variable: Variable) -> Operand {
        if let Some(&constant) = self.known.get(&variable) {
            return constant;
        }
        let to = self.value(self.function.variable_types[variable.0 as usize]);
        self.push(Instruction::Get { to, variable });
        Operand::Value(to)
    }

    pub(super) fn unary(&mut self, op: Unary, a: Operand) -> Operand {
        if let Operand::Constant(_, bits) = a
            && let Some(bits) = fold::unary(op, bits)
        {
            return Operand::Constant(op.result(), bits);
        }
        let a = self.materialize(a);
        let to = self.value(op.result());
        self.push(Instruction::Unary { to, op, a });
        Operand::Value(to)
    }

    pub(super) fn binary(&mut self, op: Binary, a: Operand, b: Operand) -> Operand {
        if let (Operand::Constant(_, x), Operand::Constant(_, y)) = (a, b)
            && let Some(bits) = fold::binary(op, x, y)
        {
            return Operand::Constant(op.result(), bits);
        }
        if let Some(same) = fold::identity(op, a, b) {
            return same;
        }
        if let Some((op, b)) = fold::simpler(op, b) {
            return self.binary(op, a, b);
        }
        // Of a constant and what isn't a number, the constant is taken: it stands second.
        let (a, b) = match (op, a) {
            (Binary::FloatMin | Binary::FloatMax, Operand::Constant(..)) => (b, a),
            _ => (a, b),
        };
        let (a, b) = (self.materialize(a), self.materialize(b));
        let to = self.value(op.result());
        self.push(Instruction::Binary { to, op, a, b });
        Operand::Value(to)
    }

    pub(super) fn compare(&mut self, op: Comparison, a: Operand, b: Operand) -> Operand {
        if let (Operand::Constant(_, x), Operand::Constant(_, y)) = (a, b) {
            return boolean(fold::compare(op, x, y));
        }
        let (a, b) = (self.materialize(a), self.materialize(b));
        let to = self.value(Type::Bool);
        self.push(Instruction::Compare { to, op, a, b });
        Operand::Value(to)
    }

    pub(super) fn select(
        &mut self,
        condition: Operand,
        accept: Operand,
        reject: Operand,
    ) -> Operand {
        if let Operand::Constant(_, bits) = condition {
            return if bits != 0 { accept } else { reject };
        }
        if accept == reject {
            return accept;
        }
        let ty = self.type_of(accept);
        match (ty, accept, reject) {
            (Type::Bool, Operand::Constant(_, 1), Operand::Constant(_, 0)) => return condition,
            (Type::Bool, Operand::Constant(_, 0), Operand::Constant(_, 1)) => {
                return self.unary(Unary::BoolNot, condition);
            }
            _ => {}
        }
        let condition = self.materialize(condition);
        let (accept, reject) = (self.materialize(accept), self.materialize(reject));
        let to = self.value(ty);
        self.push(Instruction::Select {
            to,
            condition,
            accept,
            reject,
        });
        Operand::Value(to)
    }

    /// A function of floats that gives a number.
    pub(super) fn runtime(
        &mut self,
        function: Runtime,
        ty: Type,
        arguments: &[Operand],
    ) -> Operand {
        let arguments = arguments.iter().map(|&a| self.materialize(a)).collect();
        let to = self.value(ty);
        self.push(Instruction::CallRuntime {
            to: Some(to),
            function,
            arguments,
        });
        Operand::Value(to)
    }

    /// A function that works on memory.
    pub(super) fn runtime_memory(&mut self, function: Runtime, arguments: Vec<Value>) {
        self.push(Instruction::CallRuntime {
            to: None,
            function,
            arguments,
        });
    }

    pub(super) fn load(&mut self, address: Address, ty: Type) -> Operand {
        let to = self.value(ty);
        self.push(Instruction::Load {
            to,
            ty,
            base: address.base,
            offset: address.offset,
            memory: address.memory,
        });
        Operand::Value(to)
    }

    pub(super) fn store(&mut self, address: Address, operand: Operand) {
        let ty = self.type_of(operand);
        let value = self.materialize(operand);
        self.push(Instruction::Store {
            base: address.base,
            offset: address.offset,
            value,
            ty,
            memory: address.memory,
        });
    }

    /// The address as one value.
    pub(super) fn pointer(&mut self, address: Address) -> Value {
        if address.offset == 0 {
            return address.base;
        }
        let to = self.value(Type::Pointer);
        self.push(Instruction::Offset {
            to,
            base: address.base,
            bytes: address.offset,
        });
        to
    }

    /// An element of an array; the index is within it.
    pub(super) fn element(&mut self, array: Address, index: Operand, stride: u32) -> Address {
        let array = Address {
            binding: None,
            ..array
        };
        if let Operand::Constant(_, index) = index
            && let Some(bytes) = index.checked_mul(stride)
            && i32::try_from(i64::from(array.offset) + i64::from(bytes)).is_ok()
        {
            return array.plus(bytes);
        }
        let index = self.materialize(index);
        let to = self.value(Type::Pointer);
        self.push(Instruction::Element {
            to,
            base: array.base,
            index,
            stride,
        });
        Address { base: to, ..array }
    }

    /// Constants in memory.
    pub(super) fn words(&mut self, words: Vec<u32>) -> Address {
        let to = self.value(Type::Pointer);
        self.push(Instruction::Words {
            to,
            words: Arc::from(words),
        });
        Address {
            base: to,
            offset: 0,
            memory: Memory::Constant,
            binding: None,
        }
    }

    /// Zeros memory of the function's own.
    pub(super) fn zero(&mut self, address: Address, bytes: u64) {
        if bytes <= 64 {
            for offset in (0..bytes as u32).step_by(4) {
                self.store(address.plus(offset), int(0));
            }
            return;
        }
        let target = self.pointer(address);
        let bytes = self.materialize(int(u32::try_from(bytes).unwrap_or(u32::MAX)));
        self.runtime_memory(Runtime::Zero, vec![target, bytes]);
    }
}
