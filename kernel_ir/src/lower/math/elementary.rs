//! Functions of single numbers.

use naga::{MathFunction as Math, ScalarKind};

use super::Arguments;
use crate::{
    ir::{Binary, Comparison, Runtime, Type, Unary},
    lower::{
        emit::{Emitter, Operand, float},
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
        Math::Atan => by(code, Runtime::Atan),
        Math::Atan2 => by(code, Runtime::Atan2),
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
