//! Functions of integers' bits.

use naga::{MathFunction as Math, ScalarKind};

use super::Arguments;
use crate::{
    ir::{Binary, Comparison, Unary},
    lower::emit::{Emitter, Operand, int},
};

pub(super) fn lower(
    code: &mut Emitter,
    function: Math,
    arguments: &Arguments,
) -> Option<Vec<Operand>> {
    let of = |argument, i| arguments.of(argument, i);
    let signed = arguments.kind == ScalarKind::Sint;
    let unary = |code: &mut Emitter, op| Some(arguments.each(|i| code.unary(op, of(0, i))));
    match function {
        Math::CountTrailingZeros => unary(code, Unary::TrailingZeros),
        Math::CountLeadingZeros => unary(code, Unary::LeadingZeros),
        Math::CountOneBits => unary(code, Unary::CountOnes),
        Math::ReverseBits => unary(code, Unary::ReverseBits),
        // -1 if no bit is set.
        Math::FirstTrailingBit => Some(arguments.each(|i| {
            let none = code.compare(Comparison::Equal, of(0, i), int(0));
            let zeros = code.unary(Unary::TrailingZeros, of(0, i));
            code.select(none, int(u32::MAX), zeros)
        })),
        // Of negative numbers, the first bit that isn't set.
        Math::FirstLeadingBit => Some(arguments.each(|i| {
            let mut bits = of(0, i);
            if signed {
                let sign = code.binary(Binary::SignedShiftRight, bits, int(31));
                bits = code.binary(Binary::Xor, bits, sign);
            }
            let zeros = code.unary(Unary::LeadingZeros, bits);
            code.binary(Binary::Subtract, int(31), zeros)
        })),
        Math::ExtractBits => {
            let (offset, count) = field(code, arguments.of(1, 0), arguments.of(2, 0));
            let right = match signed {
                true => Binary::SignedShiftRight,
                false => Binary::UnsignedShiftRight,
            };
            let taken = code.binary(Binary::Add, offset, count);
            let above = code.binary(Binary::Subtract, int(32), taken);
            let below = code.binary(Binary::Subtract, int(32), count);
            let none = code.compare(Comparison::Equal, count, int(0));
            Some(
                arguments.all[0]
                    .iter()
                    .map(|&bits| {
                        let top = code.binary(Binary::ShiftLeft, bits, above);
                        let field = code.binary(right, top, below);
                        code.select(none, int(0), field)
                    })
                    .collect(),
            )
        }
        Math::InsertBits => {
            let (offset, count) = field(code, arguments.of(2, 0), arguments.of(3, 0));
            let unused = code.binary(Binary::Subtract, int(32), count);
            let ones = code.binary(Binary::UnsignedShiftRight, int(u32::MAX), unused);
            let mask = code.binary(Binary::ShiftLeft, ones, offset);
            let none = code.compare(Comparison::Equal, count, int(0));
            let mask = code.select(none, int(0), mask);
            let kept = code.unary(Unary::IntNot, mask);
            Some(
                arguments.all[0]
                    .iter()
                    .zip(&arguments.all[1])
                    .map(|(&bits, &inserted)| {
                        let kept = code.binary(Binary::And, bits, kept);
                        let shifted = code.binary(Binary::ShiftLeft, inserted, offset);
                        let new = code.binary(Binary::And, shifted, mask);
                        code.binary(Binary::Or, kept, new)
                    })
                    .collect(),
            )
        }
        _ => None,
    }
}

/// Offset and count, restricted to a word.
fn field(code: &mut Emitter, offset: Operand, count: Operand) -> (Operand, Operand) {
    let offset = code.binary(Binary::UnsignedMin, offset, int(32));
    let room = code.binary(Binary::Subtract, int(32), offset);
    (offset, code.binary(Binary::UnsignedMin, count, room))
}
