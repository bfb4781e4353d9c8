//! Functions of vectors as a whole.

use naga::MathFunction as Math;

use super::Arguments;
use crate::{
    ir::{Binary, Comparison, Unary},
    lower::{
        emit::{Emitter, Operand, float, int},
        operator::{dot, sum_of_products},
    },
};

pub(super) fn lower(
    code: &mut Emitter,
    function: Math,
    arguments: &Arguments,
) -> Option<Vec<Operand>> {
    let [a, b, c, _] = &arguments.all;
    let of = |argument, i| arguments.of(argument, i);
    let multiply = |code: &mut Emitter, x, y| code.binary(Binary::FloatMultiply, x, y);
    let subtract = |code: &mut Emitter, x, y| code.binary(Binary::FloatSubtract, x, y);
    Some(match function {
        Math::Dot if arguments.is_float() => vec![dot(code, a, b)],
        Math::Dot => vec![sum_of_products(code, Binary::Multiply, Binary::Add, a, b)],
        Math::Dot4I8Packed | Math::Dot4U8Packed => {
            let shift = match function {
                Math::Dot4I8Packed => Binary::SignedShiftRight,
                _ => Binary::UnsignedShiftRight,
            };
            let mut bytes = |word: Operand| -> Vec<Operand> {
                (0..4)
                    .map(|byte| {
                        let top = code.binary(Binary::ShiftLeft, word, int(24 - 8 * byte));
                        code.binary(shift, top, int(24))
                    })
                    .collect()
            };
            let (a, b) = (bytes(a[0]), bytes(b[0]));
            vec![sum_of_products(code, Binary::Multiply, Binary::Add, &a, &b)]
        }
        Math::Cross => {
            let mut term = |i: usize, j: usize| {
                let first = multiply(code, a[i], b[j]);
                let second = multiply(code, a[j], b[i]);
                subtract(code, first, second)
            };
            vec![term(1, 2), term(2, 0), term(0, 1)]
        }
        Math::Outer => b
            .iter()
            .flat_map(|&column| a.iter().map(move |&row| (column, row)))
            .map(|(column, row)| multiply(code, row, column))
            .collect(),
        Math::Length => vec![length(code, a)],
        Math::Distance => {
            let difference = arguments.each(|i| subtract(code, of(0, i), of(1, i)));
            vec![length(code, &difference)]
        }
        Math::Normalize => {
            let square = dot(code, a, a);
            let length = code.unary(Unary::Sqrt, square);
            let scale = code.binary(Binary::FloatDivide, float(1.0), length);
            arguments.each(|i| multiply(code, of(0, i), scale))
        }
        Math::FaceForward => {
            let cosine = dot(code, b, c);
            let keeps = code.compare(Comparison::FloatLess, cosine, float(0.0));
            arguments.each(|i| {
                let turned = code.unary(Unary::FloatNegate, of(0, i));
                code.select(keeps, of(0, i), turned)
            })
        }
        Math::Reflect => {
            let cosine = dot(code, b, a);
            let twice = multiply(code, cosine, float(2.0));
            arguments.each(|i| {
                let along = multiply(code, twice, of(1, i));
                subtract(code, of(0, i), along)
            })
        }
        Math::Refract => refract(code, a, b, c[0]),
        _ => return None,
    })
}

fn length(code: &mut Emitter, vector: &[Operand]) -> Operand {
    match vector {
        [scalar] => code.unary(Unary::FloatAbs, *scalar),
        _ => {
            let square = dot(code, vector, vector);
            code.unary(Unary::Sqrt, square)
        }
    }
}

/// Zero where all is reflected.
fn refract(
    code: &mut Emitter,
    incident: &[Operand],
    normal: &[Operand],
    eta: Operand,
) -> Vec<Operand> {
    let cosine = dot(code, normal, incident);
    let square = code.binary(Binary::FloatMultiply, cosine, cosine);
    let sine = code.binary(Binary::FloatSubtract, float(1.0), square);
    let eta_square = code.binary(Binary::FloatMultiply, eta, eta);
    let refracted = code.binary(Binary::FloatMultiply, eta_square, sine);
    let k = code.binary(Binary::FloatSubtract, float(1.0), refracted);
    let total = code.compare(Comparison::FloatLess, k, float(0.0));
    let k = code.binary(Binary::FloatMax, k, float(0.0));
    let root = code.unary(Unary::Sqrt, k);
    let along = code.binary(Binary::FloatMultiply, eta, cosine);
    let along = code.binary(Binary::FloatAdd, along, root);
    incident
        .iter()
        .zip(normal)
        .map(|(&incident, &normal)| {
            let kept = code.binary(Binary::FloatMultiply, eta, incident);
            let bent = code.binary(Binary::FloatMultiply, along, normal);
            let result = code.binary(Binary::FloatSubtract, kept, bent);
            code.select(total, float(0.0), result)
        })
        .collect()
}
