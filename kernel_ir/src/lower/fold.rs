//! Operations on constants, as the code would compute them.

use super::emit::{Operand, boolean, int};
use crate::ir::{Binary, Comparison, Unary};

/// The result, where it is worth knowing.
pub(super) fn unary(op: Unary, bits: u32) -> Option<u32> {
    let x = f32::from_bits(bits);
    Some(match op {
        Unary::FloatNegate => (-x).to_bits(),
        Unary::FloatAbs => x.abs().to_bits(),
        Unary::Sqrt => x.sqrt().to_bits(),
        Unary::Floor => x.floor().to_bits(),
        Unary::Ceil => x.ceil().to_bits(),
        Unary::Truncate => x.trunc().to_bits(),
        Unary::Nearest => x.round_ties_even().to_bits(),
        Unary::FloatToSigned => x as i32 as u32,
        Unary::FloatToUnsigned => x as u32,
        Unary::SignedToFloat => (bits as i32 as f32).to_bits(),
        Unary::UnsignedToFloat => (bits as f32).to_bits(),
        Unary::FloatBits | Unary::BitsToFloat | Unary::BoolToInt => bits,
        Unary::IntNegate => bits.wrapping_neg(),
        Unary::IntNot => !bits,
        Unary::BoolNot => 1 - bits,
        Unary::LeadingZeros => bits.leading_zeros(),
        Unary::TrailingZeros => bits.trailing_zeros(),
        Unary::CountOnes => bits.count_ones(),
        Unary::ReverseBits => bits.reverse_bits(),
    })
}

/// The result; none for a division by zero, which no code asks for.
pub(super) fn binary(op: Binary, x: u32, y: u32) -> Option<u32> {
    let (p, q) = (f32::from_bits(x), f32::from_bits(y));
    let (i, j) = (x as i32, y as i32);
    Some(match op {
        Binary::FloatAdd => (p + q).to_bits(),
        Binary::FloatSubtract => (p - q).to_bits(),
        Binary::FloatMultiply => (p * q).to_bits(),
        Binary::FloatDivide => (p / q).to_bits(),
        Binary::FloatMin => (if p < q { p } else { q }).to_bits(),
        Binary::FloatMax => (if p > q { p } else { q }).to_bits(),
        Binary::Add => x.wrapping_add(y),
        Binary::Subtract => x.wrapping_sub(y),
        Binary::Multiply => x.wrapping_mul(y),
        Binary::UnsignedDivide => x.checked_div(y)?,
        Binary::SignedDivide => i.checked_div(j)? as u32,
        Binary::UnsignedRemainder => x.checked_rem(y)?,
        Binary::SignedRemainder => i.checked_rem(j)? as u32,
        Binary::And | Binary::BoolAnd => x & y,
        Binary::Or | Binary::BoolOr => x | y,
        Binary::Xor | Binary::BoolXor => x ^ y,
        Binary::ShiftLeft => x.wrapping_shl(y),
        Binary::UnsignedShiftRight => x.wrapping_shr(y),
        Binary::SignedShiftRight => i.wrapping_shr(y) as u32,
        Binary::UnsignedMin => x.min(y),
        Binary::UnsignedMax => x.max(y),
        Binary::SignedMin => i.min(j) as u32,
        Binary::SignedMax => i.max(j) as u32,
    })
}

/// Whether it holds.
pub(super) fn compare(op: Comparison, x: u32, y: u32) -> bool {
    let (p, q) = (f32::from_bits(x), f32::from_bits(y));
    let (i, j) = (x as i32, y as i32);
    match op {
        Comparison::FloatEqual => p == q,
        Comparison::FloatNotEqual => p != q,
        Comparison::FloatLess => p < q,
        Comparison::FloatLessEqual => p <= q,
        Comparison::FloatGreater => p > q,
        Comparison::FloatGreaterEqual => p >= q,
        Comparison::Equal => x == y,
        Comparison::NotEqual => x != y,
        Comparison::UnsignedLess => x < y,
        Comparison::UnsignedLessEqual => x <= y,
        Comparison::UnsignedGreater => x > y,
        Comparison::UnsignedGreaterEqual => x >= y,
        Comparison::SignedLess => i < j,
        Comparison::SignedLessEqual => i <= j,
        Comparison::SignedGreater => i > j,
        Comparison::SignedGreaterEqual => i >= j,
    }
}

/// What does the same in fewer steps: quotients and remainders by powers of two, which vectors have no instruction for otherwise.
pub(super) fn simpler(op: Binary, b: Operand) -> Option<(Binary, Operand)> {
    match (op, b) {
        (Binary::UnsignedDivide, Operand::Constant(_, by)) if by.is_power_of_two() => {
            Some((Binary::UnsignedShiftRight, int(by.trailing_zeros())))
        }
        (Binary::UnsignedRemainder, Operand::Constant(_, by)) if by.is_power_of_two() => {
            Some((Binary::And, int(by - 1)))
        }
        _ => None,
    }
}

/// What an operation gives without being done. Floats are left alone: of them few identities hold.
pub(super) fn identity(op: Binary, a: Operand, b: Operand) -> Option<Operand> {
    use Binary::{
        Add, And, BoolAnd, BoolOr, BoolXor, Multiply, Or, ShiftLeft, SignedShiftRight, Subtract,
        UnsignedShiftRight, Xor,
    };
    let constant = |operand| match operand {
        Operand::Constant(_, bits) => Some(bits),
        Operand::Value(_) => None,
    };
    match (op, constant(a), constant(b)) {
        (
            Add | Subtract | Or | Xor | ShiftLeft | UnsignedShiftRight | SignedShiftRight | BoolOr
            | BoolXor,
            _,
            Some(0),
        )
        | (Multiply | BoolAnd, _, Some(1)) => Some(a),
        (Add | Or | Xor | BoolOr | BoolXor, Some(0), _) | (Multiply | BoolAnd, Some(1), _) => {
            Some(b)
        }
        (Multiply | And, _, Some(0)) | (Multiply | And, Some(0), _) => Some(int(0)),
        (BoolAnd, _, Some(0)) | (BoolAnd, Some(0), _) => Some(boolean(false)),
        (BoolOr, _, Some(1)) | (BoolOr, Some(1), _) => Some(boolean(true)),
        _ => None,
    }
}
