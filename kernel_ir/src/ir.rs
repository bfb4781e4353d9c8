//! What lies between naga and the code generator: linear code over scalars. It knows neither of them.
//!
//! A [`Function`] is a list of [`Instruction`]s. A [`Value`] is made once and never changes; a [`Variable`] may be set
//! again; a [`Label`] starts a block, which ends with a jump, branch, switch or return. Nothing falls into a label.

use std::sync::Arc;

use crate::Binding;

/// The type of a scalar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Type {
    /// 32 bits.
    F32,
    /// 32 bits, with or without sign: the operations know.
    I32,
    /// 0 or 1; in memory it takes four bytes.
    Bool,
    /// An address.
    Pointer,
}

/// A number that is computed once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Value(pub u32);

/// A number that may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Variable(pub u32);

/// A place that is jumped to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Label(pub u32);

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Unary {
    FloatNegate,
    FloatAbs,
    Sqrt,
    Floor,
    Ceil,
    Truncate,
    /// To the nearest whole number, ties to even.
    Nearest,
    /// Saturates; what isn't a number becomes zero.
    FloatToSigned,
    /// Likewise.
    FloatToUnsigned,
    SignedToFloat,
    UnsignedToFloat,
    FloatBits,
    BitsToFloat,
    IntNegate,
    IntNot,
    BoolNot,
    BoolToInt,
    LeadingZeros,
    TrailingZeros,
    CountOnes,
    ReverseBits,
}

impl Unary {
    /// The type of the result.
    pub fn result(self) -> Type {
        match self {
            Self::FloatNegate
            | Self::FloatAbs
            | Self::Sqrt
            | Self::Floor
            | Self::Ceil
            | Self::Truncate
            | Self::Nearest
            | Self::SignedToFloat
            | Self::UnsignedToFloat
            | Self::BitsToFloat => Type::F32,
            Self::BoolNot => Type::Bool,
            _ => Type::I32,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Binary {
    FloatAdd,
    FloatSubtract,
    FloatMultiply,
    FloatDivide,
    /// The second operand unless the first is less.
    FloatMin,
    /// The second operand unless the first is greater.
    FloatMax,
    Add,
    Subtract,
    Multiply,
    /// Of integers, the divisor isn't zero.
    UnsignedDivide,
    /// Likewise, and the quotient fits.
    SignedDivide,
    UnsignedRemainder,
    SignedRemainder,
    And,
    Or,
    Xor,
    /// By the low five bits.
    ShiftLeft,
    UnsignedShiftRight,
    SignedShiftRight,
    UnsignedMin,
    UnsignedMax,
    SignedMin,
    SignedMax,
    BoolAnd,
    BoolOr,
    BoolXor,
}

impl Binary {
    /// The type of the result.
    pub fn result(self) -> Type {
        match self {
            Self::FloatAdd
            | Self::FloatSubtract
            | Self::FloatMultiply
            | Self::FloatDivide
            | Self::FloatMin
            | Self::FloatMax => Type::F32,
            Self::BoolAnd | Self::BoolOr | Self::BoolXor => Type::Bool,
            _ => Type::I32,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Comparison {
    FloatEqual,
    FloatNotEqual,
    FloatLess,
    FloatLessEqual,
    FloatGreater,
    FloatGreaterEqual,
    Equal,
    NotEqual,
    UnsignedLess,
    UnsignedLessEqual,
    UnsignedGreater,
    UnsignedGreaterEqual,
    SignedLess,
    SignedLessEqual,
    SignedGreater,
    SignedGreaterEqual,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say it")]
pub enum AtomicOperation {
    Add,
    Subtract,
    And,
    Or,
    Xor,
    UnsignedMin,
    UnsignedMax,
    SignedMin,
    SignedMax,
    Exchange,
}

/// A function of the program's own that kernels call.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Runtime {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    Exp,
    Exp2,
    Log,
    Log2,
    Pow,
    /// (fraction in [0.5, 1), the exponent) of a float: the fraction.
    FrexpFraction,
    /// And the exponent.
    FrexpExponent,
    Ldexp,
    /// The bits of a half, from a float.
    FloatToHalf,
    /// A float, from the bits of a half.
    HalfToFloat,
    /// (address, bytes): fills with zeros.
    Zero,
    /// (target, source, bytes): copies.
    Copy,
    /// (header, texel, target): four words of a texel to memory.
    LoadTexel,
    /// (header, texel, source): from memory.
    StoreTexel,
    /// (function, arguments, words of these, result, words of it): a function that was bound.
    Host,
}

/// How memory is accessed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Memory {
    /// Words that don't change during a dispatch.
    Constant,
    /// Anything else.
    Plain,
    /// In one piece, and not merged with other accesses.
    Atomic,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Instruction {
    Constant {
        to: Value,
        ty: Type,
        bits: u32,
    },
    /// The address of words that are part of the code.
    Words {
        to: Value,
        words: Arc<[u32]>,
    },
    /// A parameter of the function.
    Parameter {
        to: Value,
        index: u32,
    },
    /// The address of a place in the function's own memory.
    StackAddress {
        to: Value,
        offset: u32,
    },
    Unary {
        to: Value,
        op: Unary,
        a: Value,
    },
    Binary {
        to: Value,
        op: Binary,
        a: Value,
        b: Value,
    },
    Compare {
        to: Value,
        op: Comparison,
        a: Value,
        b: Value,
    },
    Select {
        to: Value,
        condition: Value,
        accept: Value,
        reject: Value,
    },
    Load {
        to: Value,
        ty: Type,
        base: Value,
        offset: i32,
        memory: Memory,
    },
    Store {
        base: Value,
        offset: i32,
        value: Value,
        ty: Type,
        memory: Memory,
    },
    Atomic {
        to: Value,
        op: AtomicOperation,
        base: Value,
        offset: i32,
        value: Value,
    },
    /// Exchanges if the word is as expected; gives what it was.
    CompareExchange {
        to: Value,
        base: Value,
        offset: i32,
        expected: Value,
        value: Value,
    },
    /// `base + index * stride`
    Element {
        to: Value,
        base: Value,
        index: Value,
        stride: u32,
    },
    /// `base + bytes`
    Offset {
        to: Value,
        base: Value,
        bytes: i32,
    },
    Get {
        to: Value,
        variable: Variable,
    },
    Set {
        variable: Variable,
        value: Value,
    },
    CallRuntime {
        to: Option<Value>,
        function: Runtime,
        arguments: Vec<Value>,
    },
    /// Calls one of [`Function::callees`]. Results come back through memory.
    Call {
        callee: u32,
        arguments: Vec<Value>,
    },
    /// All invocations of the workgroup wait for one another. Only in entry points, and gone before code is generated.
    Barrier,
    Label(Label),
    Jump(Label),
    Branch {
        condition: Value,
        accept: Label,
        reject: Label,
    },
    Switch {
        selector: Value,
        cases: Vec<(u32, Label)>,
        default: Label,
    },
    Return,
}

impl Instruction {
    /// The value that it makes.
    pub fn result(&self) -> Option<Value> {
        match *self {
            Self::Constant { to, .. }
            | Self::Words { to, .. }
            | Self::Parameter { to, .. }
            | Self::StackAddress { to, .. }
            | Self::Unary { to, .. }
            | Self::Binary { to, .. }
            | Self::Compare { to, .. }
            | Self::Select { to, .. }
            | Self::Load { to, .. }
            | Self::Atomic { to, .. }
            | Self::CompareExchange { to, .. }
            | Self::Element { to, .. }
            | Self::Offset { to, .. }
            | Self::Get { to, .. } => Some(to),
            Self::CallRuntime { to, .. } => to,
            Self::Store { .. }
            | Self::Set { .. }
            | Self::Call { .. }
            | Self::Barrier
            | Self::Label(_)
            | Self::Jump(_)
            | Self::Branch { .. }
            | Self::Switch { .. }
            | Self::Return => None,
        }
    }

    /// The values that it takes.
    pub fn operands(&mut self) -> Vec<&mut Value> {
        match self {
            Self::Unary { a, .. } => vec![a],
            Self::Binary { a, b, .. } | Self::Compare { a, b, .. } => vec![a, b],
            Self::Select {
                condition,
                accept,
                reject,
                ..
            } => vec![condition, accept, reject],
            Self::Load { base, .. } | Self::Offset { base, .. } => vec![base],
            Self::Store { base, value, .. } | Self::Atomic { base, value, .. } => {
                vec![base, value]
            }
            Self::CompareExchange {
                base,
                expected,
                value,
                ..
            } => vec![base, expected, value],
            Self::Element { base, index, .. } => vec![base, index],
            Self::Set { value, .. } => vec![value],
            Self::CallRuntime { arguments, .. } | Self::Call { arguments, .. } => {
                arguments.iter_mut().collect()
            }
            Self::Branch { condition, .. } => vec![condition],
            Self::Switch { selector, .. } => vec![selector],
            Self::Constant { .. }
            | Self::Words { .. }
            | Self::Parameter { .. }
            | Self::StackAddress { .. }
            | Self::Get { .. }
            | Self::Barrier
            | Self::Label(_)
            | Self::Jump(_)
            | Self::Return => Vec::new(),
        }
    }

    /// Shows where control may go from it.
    pub fn targets(&self, mut see: impl FnMut(Label)) {
        match self {
            Self::Jump(label) => see(*label),
            Self::Branch { accept, reject, .. } => {
                see(*accept);
                see(*reject);
            }
            Self::Switch { cases, default, .. } => {
                cases.iter().for_each(|(_, label)| see(*label));
                see(*default);
            }
            _ => {}
        }
    }

    /// Jumps elsewhere.
    pub fn retarget(&mut self, from: Label, to: Label) {
        let change = |label: &mut Label| {
            if *label == from {
                *label = to;
            }
        };
        match self {
            Self::Jump(label) => change(label),
            Self::Branch { accept, reject, .. } => {
                change(accept);
                change(reject);
            }
            Self::Switch { cases, default, .. } => {
                cases.iter_mut().for_each(|(_, label)| change(label));
                change(default);
            }
            _ => {}
        }
    }
}

/// A function of scalars.
#[derive(Debug, Clone, Default, PartialEq, Eq, Hash)]
pub struct Function {
    /// As the text calls it.
    pub name: String,
    /// Of its arguments.
    pub parameters: Vec<Type>,
    /// What it does.
    pub instructions: Vec<Instruction>,
    /// Of each value.
    pub value_types: Vec<Type>,
    /// Of each variable.
    pub variable_types: Vec<Type>,
    /// Labels that it has.
    pub labels: u32,
    /// Bytes of memory of its own.
    pub stack_bytes: u32,
    /// Indices of [`Program::functions`] that its calls mean. Calls name them by their place here, so that a function
    /// doesn't change with the rest of its program.
    pub callees: Vec<usize>,
}

impl Function {
    /// The instruction at which each label stands.
    pub fn positions(&self) -> Vec<usize> {
        let mut positions = vec![usize::MAX; self.labels as usize];
        for (position, instruction) in self.instructions.iter().enumerate() {
            if let Instruction::Label(label) = instruction {
                positions[label.0 as usize] = position;
            }
        }
        positions
    }
}

/// A kernel, ready for the code generator.
#[derive(Debug, Clone, Default)]
pub struct Program {
    /// The first is the entry point: (context, scratch, workgroup's x, y, z). The others: (context, private variables,
    /// place of the result, arguments...).
    pub functions: Vec<Function>,
    /// What has to be bound, by slots of the context.
    pub bindings: Vec<Binding>,
    /// Invocations of a workgroup along each axis.
    pub workgroup_size: [u32; 3],
    /// Bytes of scratch memory that a workgroup needs.
    pub scratch_bytes: u32,
    /// How the entry point goes over its workgroup, if that is a loop over invocations that don't wait for one another.
    pub invocations: Option<Invocations>,
}

/// The loop of an entry point over the invocations of a workgroup. They may run in any order, and at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Invocations {
    /// Which one runs: from zero, one by one.
    pub index: Variable,
    /// Where each begins. Before it, only `index` is set.
    pub head: Label,
    /// Where each ends; what stands behind is only the loop's.
    pub next: Label,
}

/// Where in a dispatch's context what lies, in bytes.
pub mod context {
    /// Three words: the numbers of workgroups.
    pub const WORKGROUPS: u32 = 0;

    /// The address of a buffer, or of an image's header.
    pub fn binding(slot: usize) -> u32 {
        16 + 16 * slot as u32
    }

    /// The last index of a buffer's runtime-sized array.
    pub fn last_index(slot: usize) -> u32 {
        binding(slot) + 8
    }

    /// 64-bit words of a context.
    pub fn words(bindings: usize) -> usize {
        2 + 2 * bindings
    }
}
