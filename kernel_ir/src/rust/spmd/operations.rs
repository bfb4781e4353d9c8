//! Operations as calls of functions of vectors, which have the operations' names.

use crate::ir::{AtomicOperation, Runtime, Type};

/// The name of an operation as a function has it.
pub(super) fn snake(operation: impl std::fmt::Debug) -> String {
    let mut name = String::new();
    for letter in format!("{operation:?}").chars() {
        if letter.is_ascii_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.push(letter.to_ascii_lowercase());
    }
    name
}

/// The type of as many lanes.
pub(super) fn vector(ty: Type) -> &'static str {
    match ty {
        Type::F32 => "F",
        Type::Bool => "M",
        Type::I32 | Type::Pointer => "I",
    }
}

/// The function that chooses lanes.
pub(super) fn select(ty: Type) -> &'static str {
    match ty {
        Type::F32 => "select_f",
        Type::Bool => "select_m",
        Type::I32 | Type::Pointer => "select_i",
    }
}

/// Zero in all lanes.
pub(super) fn zero(ty: Type) -> &'static str {
    match ty {
        Type::F32 => "floats(0.0)",
        Type::Bool | Type::I32 | Type::Pointer => "none()",
    }
}

/// A vector of a type, from a vector of words.
pub(super) fn of_words(ty: Type, words: &str) -> String {
    match ty {
        Type::F32 => format!("bits_to_float({words})"),
        Type::Bool => format!("int_to_bool({words})"),
        Type::I32 | Type::Pointer => words.to_owned(),
    }
}

/// The words of a vector of a type.
pub(super) fn to_words(ty: Type, vector: &str) -> String {
    match ty {
        Type::F32 => format!("float_bits({vector})"),
        Type::Bool => format!("bool_to_int({vector})"),
        Type::I32 | Type::Pointer => vector.to_owned(),
    }
}

/// What one lane does with a word in memory.
pub(super) fn atomic(op: AtomicOperation) -> &'static str {
    match op {
        AtomicOperation::Add => "|word, x| word.fetch_add(x, Relaxed)",
        AtomicOperation::Subtract => "|word, x| word.fetch_sub(x, Relaxed)",
        AtomicOperation::And => "|word, x| word.fetch_and(x, Relaxed)",
        AtomicOperation::Or => "|word, x| word.fetch_or(x, Relaxed)",
        AtomicOperation::Xor => "|word, x| word.fetch_xor(x, Relaxed)",
        AtomicOperation::UnsignedMin => "|word, x| word.fetch_min(x, Relaxed)",
        AtomicOperation::UnsignedMax => "|word, x| word.fetch_max(x, Relaxed)",
        AtomicOperation::SignedMin => {
            "|word, x| AtomicI32::from_ptr(word.as_ptr().cast()).fetch_min(x as i32, Relaxed) as u32"
        }
        AtomicOperation::SignedMax => {
            "|word, x| AtomicI32::from_ptr(word.as_ptr().cast()).fetch_max(x as i32, Relaxed) as u32"
        }
        AtomicOperation::Exchange => "|word, x| word.swap(x, Relaxed)",
    }
}

/// A function of numbers, of each lane of a mask.
pub(super) fn call(function: Runtime, arguments: &[String]) -> Option<String> {
    let name = snake(function);
    let words = |a: &str, b: &str, does: &str| {
        format!("call_words({a}, {b}, m, |a, b| {{ let _ = b; {does} }})")
    };
    Some(match (function, arguments) {
        (Runtime::Host | Runtime::Zero | Runtime::Copy, _) => return None,
        (Runtime::LoadTexel | Runtime::StoreTexel, _) => return None,
        (Runtime::FrexpFraction, [a]) => format!("call_1(runtime::{name}, {a}, m)"),
        (Runtime::FrexpExponent, [a]) => words(
            &format!("float_bits({a})"),
            "none()",
            "runtime::frexp_exponent(f32::from_bits(a)) as u32",
        ),
        (Runtime::Ldexp, [a, b]) => format!(
            "bits_to_float({})",
            words(
                &format!("float_bits({a})"),
                b,
                "runtime::ldexp(f32::from_bits(a), b as i32).to_bits()",
            )
        ),
        (Runtime::FloatToHalf, [a]) => words(
            &format!("float_bits({a})"),
            "none()",
            "runtime::float_to_half(f32::from_bits(a))",
        ),
        (Runtime::HalfToFloat, [a]) => {
            let half = words(a, "none()", "runtime::half_to_float(a).to_bits()");
            format!("bits_to_float({half})")
        }
        (_, [a]) => format!("call_1(runtime::{name}, {a}, m)"),
        (_, [a, b]) => format!("call_2(runtime::{name}, {a}, {b}, m)"),
        _ => return None,
    })
}
