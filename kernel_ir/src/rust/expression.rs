//! Operations as expressions of Rust. Each gives the bits that machine code made at run time gives: nothing is fused.

use crate::ir::{
    AtomicOperation, Binary, Comparison, Instruction, Memory, Runtime, Type, Unary, Value,
};

pub(super) fn type_name(ty: Type) -> &'static str {
    match ty {
        Type::F32 => "f32",
        Type::I32 => "u32",
        Type::Bool => "bool",
        Type::Pointer => "*mut u8",
    }
}

pub(super) fn zero(ty: Type) -> &'static str {
    match ty {
        Type::F32 => "0f32",
        Type::I32 => "0u32",
        Type::Bool => "false",
        Type::Pointer => "core::ptr::null_mut()",
    }
}

pub(super) fn literal(ty: Type, bits: u32) -> String {
    match ty {
        Type::F32 => {
            let x = f32::from_bits(bits);
            // Without parentheses: for each that it takes for superfluous, rustc copies all of the text before it.
            match x.is_finite() && x.is_sign_positive() {
                true => format!("{x:e}f32"),
                false => format!("f32::from_bits({bits}u32)"),
            }
        }
        Type::Bool => (bits != 0).to_string(),
        Type::I32 | Type::Pointer => format!("{bits}u32"),
    }
}

/// What an instruction makes, if it makes a value by an expression.
pub(super) fn expression(
    instruction: &Instruction,
    name: &dyn Fn(Value) -> String,
) -> Option<String> {
    Some(match *instruction {
        Instruction::Parameter { index, .. } => format!("p{index}"),
        Instruction::StackAddress { offset, .. } => {
            format!("stack.as_mut_ptr().cast::<u8>().add({offset})")
        }
        Instruction::Unary { op, a, .. } => unary(op, &name(a)),
        Instruction::Binary { op, a, b, .. } => binary(op, &name(a), &name(b)),
        Instruction::Compare { op, a, b, .. } => comparison(op, &name(a), &name(b)),
        Instruction::Select {
            condition,
            accept,
            reject,
            ..
        } => format!(
            "if {} {{ {} }} else {{ {} }}",
            name(condition),
            name(accept),
            name(reject)
        ),
        Instruction::Load {
            ty,
            base,
            offset,
            memory,
            ..
        } => load(ty, &at(&name(base), offset), memory),
        Instruction::Atomic {
            op,
            base,
            offset,
            value,
            ..
        } => atomic(op, &at(&name(base), offset), &name(value)),
        Instruction::CompareExchange {
            base,
            offset,
            expected,
            value,
            ..
        } => format!(
            "AtomicU32::from_ptr({}.cast()).compare_exchange({}, {}, Relaxed, Relaxed).unwrap_or_else(|found| found)",
            at(&name(base), offset),
            name(expected),
            name(value)
        ),
        Instruction::Element {
            base,
            index,
            stride,
            ..
        } => format!("{}.add({} as usize * {stride})", name(base), name(index)),
        Instruction::Offset { base, bytes, .. } => at(&name(base), bytes),
        Instruction::Get { variable, .. } => format!("x{}", variable.0),
        Instruction::CallRuntime {
            function,
            ref arguments,
            ..
        } => call(function, arguments, name),
        _ => return None,
    })
}

/// So many bytes behind an address.
pub(super) fn at(base: &str, offset: i32) -> String {
    match offset {
        0 => base.to_owned(),
        offset => format!("{base}.offset({offset})"),
    }
}

fn load(ty: Type, place: &str, memory: Memory) -> String {
    let word = match memory {
        Memory::Atomic => format!("AtomicU32::from_ptr({place}.cast()).load(Relaxed)"),
        Memory::Constant | Memory::Plain if ty == Type::Bool => {
            format!("{place}.cast::<u32>().read()")
        }
        Memory::Constant | Memory::Plain => {
            return format!("{place}.cast::<{}>().read()", type_name(ty));
        }
    };
    match ty {
        Type::Bool => format!("{word} != 0"),
        Type::F32 => format!("f32::from_bits({word})"),
        Type::I32 | Type::Pointer => word,
    }
}

/// A word written to an address.
pub(super) fn store(ty: Type, place: &str, value: &str, memory: Memory) -> String {
    let word = match ty {
        Type::Bool => format!("u32::from({value})"),
        Type::F32 if memory == Memory::Atomic => format!("{value}.to_bits()"),
        _ => value.to_owned(),
    };
    match memory {
        Memory::Atomic => format!("AtomicU32::from_ptr({place}.cast()).store({word}, Relaxed);"),
        Memory::Constant | Memory::Plain => {
            let ty = match ty {
                Type::Bool => type_name(Type::I32),
                ty => type_name(ty),
            };
            format!("{place}.cast::<{ty}>().write({word});")
        }
    }
}

fn unary(op: Unary, a: &str) -> String {
    match op {
        Unary::FloatNegate => format!("-{a}"),
        Unary::FloatAbs => format!("{a}.abs()"),
        Unary::Sqrt => format!("{a}.sqrt()"),
        Unary::Floor => format!("{a}.floor()"),
        Unary::Ceil => format!("{a}.ceil()"),
        Unary::Truncate => format!("{a}.trunc()"),
        Unary::Nearest => format!("{a}.round_ties_even()"),
        Unary::FloatToSigned => format!("{a} as i32 as u32"),
        Unary::FloatToUnsigned => format!("{a} as u32"),
        Unary::SignedToFloat => format!("{a} as i32 as f32"),
        Unary::UnsignedToFloat => format!("{a} as f32"),
        Unary::FloatBits => format!("{a}.to_bits()"),
        Unary::BitsToFloat => format!("f32::from_bits({a})"),
        Unary::IntNegate => format!("{a}.wrapping_neg()"),
        Unary::IntNot | Unary::BoolNot => format!("!{a}"),
        Unary::BoolToInt => format!("u32::from({a})"),
        Unary::LeadingZeros => format!("{a}.leading_zeros()"),
        Unary::TrailingZeros => format!("{a}.trailing_zeros()"),
        Unary::CountOnes => format!("{a}.count_ones()"),
        Unary::ReverseBits => format!("{a}.reverse_bits()"),
    }
}

fn binary(op: Binary, a: &str, b: &str) -> String {
    let method = |name| format!("{a}.{name}({b})");
    let signed = |name| format!("({a} as i32).{name}({b} as i32) as u32");
    match op {
        Binary::FloatAdd => format!("{a} + {b}"),
        Binary::FloatSubtract => format!("{a} - {b}"),
        Binary::FloatMultiply => format!("{a} * {b}"),
        Binary::FloatDivide => format!("{a} / {b}"),
        Binary::FloatMin => format!("if {a} < {b} {{ {a} }} else {{ {b} }}"),
        Binary::FloatMax => format!("if {b} < {a} {{ {a} }} else {{ {b} }}"),
        Binary::Add => method("wrapping_add"),
        Binary::Subtract => method("wrapping_sub"),
        Binary::Multiply => method("wrapping_mul"),
        // No divisor is zero: that was seen to. Without a check Rust would need a panic.
        Binary::UnsignedDivide => format!("{a}.checked_div({b}).unwrap_or(0)"),
        Binary::UnsignedRemainder => format!("{a}.checked_rem({b}).unwrap_or(0)"),
        Binary::SignedDivide => {
            format!("({a} as i32).checked_div({b} as i32).unwrap_or(0) as u32")
        }
        Binary::SignedRemainder => {
            format!("({a} as i32).checked_rem({b} as i32).unwrap_or(0) as u32")
        }
        Binary::And | Binary::BoolAnd => format!("{a} & {b}"),
        Binary::Or | Binary::BoolOr => format!("{a} | {b}"),
        Binary::Xor | Binary::BoolXor => format!("{a} ^ {b}"),
        Binary::ShiftLeft => method("wrapping_shl"),
        Binary::UnsignedShiftRight => method("wrapping_shr"),
        Binary::SignedShiftRight => format!("({a} as i32).wrapping_shr({b}) as u32"),
        Binary::UnsignedMin => method("min"),
        Binary::UnsignedMax => method("max"),
        Binary::SignedMin => signed("min"),
        Binary::SignedMax => signed("max"),
    }
}

fn comparison(op: Comparison, a: &str, b: &str) -> String {
    use Comparison::{
        Equal, FloatEqual, FloatGreater, FloatGreaterEqual, FloatLess, FloatLessEqual,
        FloatNotEqual, NotEqual, SignedGreater, SignedGreaterEqual, SignedLess, SignedLessEqual,
        UnsignedGreater, UnsignedGreaterEqual, UnsignedLess, UnsignedLessEqual,
    };
    let operator = match op {
        FloatEqual | Equal => "==",
        FloatNotEqual | NotEqual => "!=",
        FloatLess | UnsignedLess | SignedLess => "<",
        FloatLessEqual | UnsignedLessEqual | SignedLessEqual => "<=",
        FloatGreater | UnsignedGreater | SignedGreater => ">",
        FloatGreaterEqual | UnsignedGreaterEqual | SignedGreaterEqual => ">=",
    };
    match op {
        SignedLess | SignedLessEqual | SignedGreater | SignedGreaterEqual => {
            format!("({a} as i32) {operator} ({b} as i32)")
        }
        _ => format!("{a} {operator} {b}"),
    }
}

fn atomic(op: AtomicOperation, place: &str, value: &str) -> String {
    let word = format!("AtomicU32::from_ptr({place}.cast())");
    let signed = format!("AtomicI32::from_ptr({place}.cast())");
    match op {
        AtomicOperation::Add => format!("{word}.fetch_add({value}, Relaxed)"),
        AtomicOperation::Subtract => format!("{word}.fetch_sub({value}, Relaxed)"),
        AtomicOperation::And => format!("{word}.fetch_and({value}, Relaxed)"),
        AtomicOperation::Or => format!("{word}.fetch_or({value}, Relaxed)"),
        AtomicOperation::Xor => format!("{word}.fetch_xor({value}, Relaxed)"),
        AtomicOperation::UnsignedMin => format!("{word}.fetch_min({value}, Relaxed)"),
        AtomicOperation::UnsignedMax => format!("{word}.fetch_max({value}, Relaxed)"),
        AtomicOperation::SignedMin => format!("{signed}.fetch_min({value} as i32, Relaxed) as u32"),
        AtomicOperation::SignedMax => format!("{signed}.fetch_max({value} as i32, Relaxed) as u32"),
        AtomicOperation::Exchange => format!("{word}.swap({value}, Relaxed)"),
    }
}

/// A call of the program's own function, by the name that it has where the text is compiled.
fn call(function: Runtime, arguments: &[Value], name: &dyn Fn(Value) -> String) -> String {
    let called = match function {
        Runtime::Sin => "sin",
        Runtime::Cos => "cos",
        Runtime::Tan => "tan",
        Runtime::Asin => "asin",
        Runtime::Acos => "acos",
        Runtime::Sinh => "sinh",
        Runtime::Cosh => "cosh",
        Runtime::Tanh => "tanh",
        Runtime::Asinh => "asinh",
        Runtime::Acosh => "acosh",
        Runtime::Atanh => "atanh",
        Runtime::Exp => "exp",
        Runtime::Exp2 => "exp2",
        Runtime::Log => "log",
        Runtime::Log2 => "log2",
        Runtime::Pow => "pow",
        Runtime::FrexpFraction => "frexp_fraction",
        Runtime::FrexpExponent => "frexp_exponent",
        Runtime::Ldexp => "ldexp",
        Runtime::FloatToHalf => "float_to_half",
        Runtime::HalfToFloat => "half_to_float",
        Runtime::Zero => "zero",
        Runtime::Copy => "copy",
        Runtime::LoadTexel => "load_texel",
        Runtime::StoreTexel => "store_texel",
        Runtime::Host => "host",
    };
    // Pointers are cast to what the function takes.
    let pointers: &[usize] = match function {
        Runtime::Zero => &[0],
        Runtime::Copy => &[0, 1],
        Runtime::LoadTexel => &[0, 2],
        Runtime::StoreTexel => &[0, 4],
        Runtime::Host => &[0, 1, 3],
        _ => &[],
    };
    let arguments: Vec<String> = (arguments.iter().enumerate())
        .map(|(index, &argument)| {
            let argument = name(argument);
            match (function, pointers.contains(&index)) {
                (Runtime::Ldexp, _) if index == 1 => format!("{argument} as i32"),
                (_, true) => format!("{argument}.cast()"),
                (_, false) => argument,
            }
        })
        .collect();
    let result = match function {
        Runtime::FrexpExponent => " as u32",
        _ => "",
    };
    format!("runtime::{called}({}){result}", arguments.join(", "))
}
