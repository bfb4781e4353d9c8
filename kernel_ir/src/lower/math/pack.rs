//! Small numbers in one word, and back.

use naga::{MathFunction as Math, ScalarKind};

use super::Arguments;
use crate::{
    ir::{Binary, Runtime, Type, Unary},
    lower::emit::{Emitter, Operand, float, int},
};

pub(super) fn lower(
    code: &mut Emitter,
    function: Math,
    arguments: &Arguments,
) -> Option<Vec<Operand>> {
    let values = &arguments.all[0];
    Some(match function {
        Math::Pack4x8snorm => vec![normalized(code, values, 8, -1.0, 127.0)],
        Math::Pack4x8unorm => vec![normalized(code, values, 8, 0.0, 255.0)],
        Math::Pack2x16snorm => vec![normalized(code, values, 16, -1.0, 32767.0)],
        Math::Pack2x16unorm => vec![normalized(code, values, 16, 0.0, 65535.0)],
        Math::Pack2x16float => {
            let halves: Vec<_> = values
                .iter()
                .map(|&value| code.runtime(Runtime::FloatToHalf, Type::I32, &[value]))
                .collect();
            vec![joined(code, &halves, 16)]
        }
        Math::Pack4xI8 | Math::Pack4xU8 => vec![joined(code, values, 8)],
        Math::Pack4xI8Clamp => {
            let values = clamped(code, values, arguments, int(-128i32 as u32), int(127));
            vec![joined(code, &values, 8)]
        }
        Math::Pack4xU8Clamp => {
            let values = clamped(code, values, arguments, int(0), int(255));
            vec![joined(code, &values, 8)]
        }
        Math::Unpack4x8snorm => fractions(code, values[0], 8, true, 127.0),
        Math::Unpack4x8unorm => fractions(code, values[0], 8, false, 255.0),
        Math::Unpack2x16snorm => fractions(code, values[0], 16, true, 32767.0),
        Math::Unpack2x16unorm => fractions(code, values[0], 16, false, 65535.0),
        Math::Unpack2x16float => split(code, values[0], 16, false)
            .into_iter()
            .map(|half| code.runtime(Runtime::HalfToFloat, Type::F32, &[half]))
            .collect(),
        Math::Unpack4xI8 => split(code, values[0], 8, true),
        Math::Unpack4xU8 => split(code, values[0], 8, false),
        _ => return None,
    })
}

fn clamped(
    code: &mut Emitter,
    values: &[Operand],
    arguments: &Arguments,
    least: Operand,
    most: Operand,
) -> Vec<Operand> {
    let max = match arguments.kind {
        ScalarKind::Sint => Binary::SignedMax,
        _ => Binary::UnsignedMax,
    };
    values
        .iter()
        .map(|&value| {
            let raised = code.binary(max, value, least);
            code.binary(arguments.min(), raised, most)
        })
        .collect()
}

/// The low bits of each value, the first lowest.
fn joined(code: &mut Emitter, values: &[Operand], bits: u32) -> Operand {
    let mask = int((1 << bits) - 1);
    let mut word = int(0);
    for (shift, &value) in (0..).step_by(bits as usize).zip(values) {
        let low = code.binary(Binary::And, value, mask);
        let moved = code.binary(Binary::ShiftLeft, low, int(shift));
        word = code.binary(Binary::Or, word, moved);
    }
    word
}

/// Fractions of `scale` as whole numbers.
fn normalized(
    code: &mut Emitter,
    values: &[Operand],
    bits: u32,
    least: f32,
    scale: f32,
) -> Operand {
    let wholes: Vec<_> = values
        .iter()
        .map(|&value| {
            let raised = code.binary(Binary::FloatMax, value, float(least));
            let lowered = code.binary(Binary::FloatMin, raised, float(1.0));
            let scaled = code.binary(Binary::FloatMultiply, lowered, float(scale));
            let nearest = code.unary(Unary::Nearest, scaled);
            code.unary(Unary::FloatToSigned, nearest)
        })
        .collect();
    joined(code, &wholes, bits)
}

/// The parts of a word, the lowest first.
fn split(code: &mut Emitter, word: Operand, bits: u32, signed: bool) -> Vec<Operand> {
    let shift = match signed {
        true => Binary::SignedShiftRight,
        false => Binary::UnsignedShiftRight,
    };
    (0..32)
        .step_by(bits as usize)
        .map(|at| {
            let top = code.binary(Binary::ShiftLeft, word, int(32 - bits - at));
            code.binary(shift, top, int(32 - bits))
        })
        .collect()
}

/// Parts of a word as fractions of `scale`.
fn fractions(
    code: &mut Emitter,
    word: Operand,
    bits: u32,
    signed: bool,
    scale: f32,
) -> Vec<Operand> {
    split(code, word, bits, signed)
        .into_iter()
        .map(|part| {
            // No part is that large that its sign matters.
            let number = code.unary(Unary::SignedToFloat, part);
            let fraction = code.binary(Binary::FloatMultiply, number, float(1.0 / scale));
            match signed {
                true => code.binary(Binary::FloatMax, fraction, float(-1.0)),
                false => fraction,
            }
        })
        .collect()
}
