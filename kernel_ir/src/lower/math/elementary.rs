//! Functions of single numbers.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use naga::{MathFunction as Math, ScalarKind};

use super::Arguments;
use crate::{
    ir::{Binary, Comparison, Runtime, Type, Unary},
    lower::{
        emit::{Emitter, Operand, float, int},
        operator::{saturate, sign},
    },
};

pub(super) fn lower(
    code: &mut Emitter,
    function: Math,
    arguments: &Arguments,
) -> Option<Vec<Operand>> {
    let of = |argument, i| arguments.of(argument, i);
    let by = |code: &mut Emitter, function| Some(arguments.each_by(code, function, Type::F32));
    let unary = |code: &mut Emitter, op| Some(arguments.each(|i| code.unary(op, of(0, i))));
    let (min, max) = (arguments.min(), arguments.max());
    match function {
        Math::Abs => match arguments.kind {
            ScalarKind::Float => unary(code, Unary::FloatAbs),
            ScalarKind::Sint => Some(arguments.each(|i| {
                let negative = code.unary(Unary::IntNegate, of(0, i));
                code.binary(Binary::SignedMax, of(0, i), negative)
            })),
            _ => Some(arguments.all[0].clone()),
        },
        Math::Min => Some(arguments.each(|i| code.binary(min, of(0, i), of(1, i)))),
        Math::Max => Some(arguments.each(|i| code.binary(max, of(0, i), of(1, i)))),
        Math::Clamp => Some(arguments.each(|i| {
            let raised = code.binary(max, of(0, i), of(1, i));
            code.binary(min, raised, of(2, i))
        })),
        Math::Saturate => Some(arguments.each(|i| saturate(code, of(0, i)))),
        Math::Sign => Some(arguments.each(|i| sign(code, of(0, i), arguments.kind))),
        Math::Cos => by(code, Runtime::Cos),
        Math::Sin => by(code, Runtime::Sin),
        Math::Tan => by(code, Runtime::Tan),
        Math::Acos => by(code, Runtime::Acos),
        Math::Asin => by(code, Runtime::Asin),
        Math::Atan => Some(arguments.each(|i| arc_tangent(code, of(0, i), float(1.0)))),
        Math::Atan2 => Some(arguments.each(|i| arc_tangent(code, of(0, i), of(1, i)))),
        Math::Cosh => by(code, Runtime::Cosh),
        Math::Sinh => by(code, Runtime::Sinh),
        Math::Tanh => by(code, Runtime::Tanh),
        Math::Acosh => by(code, Runtime::Acosh),
        Math::Asinh => by(code, Runtime::Asinh),
        Math::Atanh => by(code, Runtime::Atanh),
        Math::Exp => by(code, Runtime::Exp),
        Math::Exp2 => by(code, Runtime::Exp2),
        Math::Log => by(code, Runtime::Log),
        Math::Log2 => by(code, Runtime::Log2),
        Math::Pow => by(code, Runtime::Pow),
        Math::Ldexp => by(code, Runtime::Ldexp),
        Math::Frexp => {
            // The fractions, and behind them the exponents.
            let mut all = arguments.each_by(code, Runtime::FrexpFraction, Type::F32);
            all.extend(arguments.each_by(code, Runtime::FrexpExponent, Type::I32));
            Some(all)
        }
        Math::Modf => {
            let wholes = arguments.each(|i| code.unary(Unary::Truncate, of(0, i)));
            let mut all =
                arguments.each(|i| code.binary(Binary::FloatSubtract, of(0, i), wholes[i]));
            all.extend(wholes);
            Some(all)
        }
        Math::Radians => Some(
            arguments
                .each(|i| code.binary(Binary::FloatMultiply, of(0, i), float(1.0f32.to_radians()))),
        ),
        Math::Degrees => Some(
            arguments
                .each(|i| code.binary(Binary::FloatMultiply, of(0, i), float(1.0f32.to_degrees()))),
        ),
        Math::Ceil => unary(code, Unary::Ceil),
        Math::Floor => unary(code, Unary::Floor),
        Math::Round => unary(code, Unary::Nearest),
        Math::Trunc => unary(code, Unary::Truncate),
        Math::Sqrt => unary(code, Unary::Sqrt),
        Math::InverseSqrt => Some(arguments.each(|i| {
            let root = code.unary(Unary::Sqrt, of(0, i));
            code.binary(Binary::FloatDivide, float(1.0), root)
        })),
        Math::Fract => Some(arguments.each(|i| {
            let whole = code.unary(Unary::Floor, of(0, i));
            code.binary(Binary::FloatSubtract, of(0, i), whole)
        })),
        // In two steps, as WGSL allows it: not every processor has the instruction.
        Math::Fma => Some(arguments.each(|i| {
            let product = code.binary(Binary::FloatMultiply, of(0, i), of(1, i));
            code.binary(Binary::FloatAdd, product, of(2, i))
        })),
        Math::Mix => Some(arguments.each(|i| {
            let rest = code.binary(Binary::FloatSubtract, float(1.0), of(2, i));
            let first = code.binary(Binary::FloatMultiply, of(0, i), rest);
            let second = code.binary(Binary::FloatMultiply, of(1, i), of(2, i));
            code.binary(Binary::FloatAdd, first, second)
        })),
        Math::Step => Some(arguments.each(|i| {
            let reached = code.compare(Comparison::FloatLessEqual, of(0, i), of(1, i));
            code.select(reached, float(1.0), float(0.0))
        })),
        Math::SmoothStep => Some(arguments.each(|i| {
            let above = code.binary(Binary::FloatSubtract, of(2, i), of(0, i));
            let range = code.binary(Binary::FloatSubtract, of(1, i), of(0, i));
            let t = code.binary(Binary::FloatDivide, above, range);
            let t = saturate(code, t);
            let twice = code.binary(Binary::FloatMultiply, float(2.0), t);
            let slope = code.binary(Binary::FloatSubtract, float(3.0), twice);
            let square = code.binary(Binary::FloatMultiply, t, t);
            code.binary(Binary::FloatMultiply, square, slope)
        })),
        Math::QuantizeToF16 => Some(arguments.each(|i| {
            let half = code.runtime(Runtime::FloatToHalf, Type::I32, &[of(0, i)]);
            code.runtime(Runtime::HalfToFloat, Type::F32, &[half])
        })),
        _ => None,
    }
}

/// Coefficients of z, z^2 and so on in (atan(r)/r - 1), z = r^2 up to tan^2(pi/8): weighted least squares towards the least largest error,
/// 7e-10.
const ARC_TANGENT: [f32; 5] = [
    -0.333_333_16,
    0.199_984_83,
    -0.142_437_37,
    0.105_951_28,
    -0.060_811_28,
];

/// The angle of a point, within 2.7 units in the last place, by arithmetic alone: processors do that for all lanes at once, where
/// a library's function is called for each. Octants are brought to the first half of one, |angle| up to pi/8, as in
/// Moshier's Cephes (`atanf`).
fn arc_tangent(code: &mut Emitter, y: Operand, x: Operand) -> Operand {
    let [height, width] = [y, x].map(|side| code.unary(Unary::FloatAbs, side));
    let short = code.binary(Binary::FloatMin, height, width);
    let long = code.binary(Binary::FloatMax, height, width);
    // tan(a - pi/4) = (tan(a) - 1)/(tan(a) + 1).
    let bound = code.binary(Binary::FloatMultiply, long, float(0.414_213_57));
    let is_beyond = code.compare(Comparison::FloatGreater, short, bound);
    let turned = [
        code.binary(Binary::FloatSubtract, short, long),
        code.binary(Binary::FloatAdd, short, long),
    ];
    let above = code.select(is_beyond, turned[0], short);
    let below = code.select(is_beyond, turned[1], long);
    let quotient = code.binary(Binary::FloatDivide, above, below);
    // The angle of the origin is 0.
    let is_somewhere = code.compare(Comparison::FloatGreater, long, float(0.0));
    let r = code.select(is_somewhere, quotient, float(0.0));
    let z = code.binary(Binary::FloatMultiply, r, r);
    let [rest @ .., last] = ARC_TANGENT;
    let mut sum = float(last);
    for coefficient in rest.into_iter().rev() {
        let product = code.binary(Binary::FloatMultiply, sum, z);
        sum = code.binary(Binary::FloatAdd, product, float(coefficient));
    }
    let bend = code.binary(Binary::FloatMultiply, sum, z);
    let bend = code.binary(Binary::FloatMultiply, bend, r);
    let angle = code.binary(Binary::FloatAdd, r, bend);
    let back = code.binary(Binary::FloatAdd, angle, float(FRAC_PI_4));
    let angle = code.select(is_beyond, back, angle);
    let is_steep = code.compare(Comparison::FloatGreater, height, width);
    let other = code.binary(Binary::FloatSubtract, float(FRAC_PI_2), angle);
    let angle = code.select(is_steep, other, angle);
    let sign = |code: &mut Emitter, of: Operand| {
        let bits = code.unary(Unary::FloatBits, of);
        code.binary(Binary::And, bits, int(1 << 31))
    };
    let left = sign(code, x);
    let is_left = code.compare(Comparison::SignedLess, left, int(0));
    let other = code.binary(Binary::FloatSubtract, float(PI), angle);
    let angle = code.select(is_left, other, angle);
    let bits = code.unary(Unary::FloatBits, angle);
    let down = sign(code, y);
    let bits = code.binary(Binary::Or, bits, down);
    code.unary(Unary::BitsToFloat, bits)
}
