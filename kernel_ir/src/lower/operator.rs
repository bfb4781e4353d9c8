//! Operators and conversions.

use naga::{BinaryOperator, Expression, Handle, ScalarKind, TypeInner, UnaryOperator};

use super::{
    Lowering,
    emit::{Emitter, Operand, float, int},
    function::Frame,
    types::components,
};
use crate::{
    CompileError, ErrorKind,
    ir::{Binary, Comparison, Unary},
};

/// The largest float that an `i32` holds.
const MOST_SIGNED: f32 = 2_147_483_520.0;
/// The largest float that a `u32` holds.
const MOST_UNSIGNED: f32 = 4_294_967_040.0;

/// An operator for scalars of a kind.
pub(super) fn unary(op: UnaryOperator, kind: Option<ScalarKind>) -> Unary {
    match (op, kind) {
        (UnaryOperator::Negate, Some(ScalarKind::Float)) => Unary::FloatNegate,
        (UnaryOperator::Negate, _) => Unary::IntNegate,
        (UnaryOperator::LogicalNot, _) => Unary::BoolNot,
        (UnaryOperator::BitwiseNot, Some(ScalarKind::Bool)) => Unary::BoolNot,
        (UnaryOperator::BitwiseNot, _) => Unary::IntNot,
    }
}

/// A conversion by value. What doesn't fit becomes the nearest that does, as WGSL says.
pub(super) fn convert(
    code: &mut Emitter,
    value: Operand,
    from: ScalarKind,
    to: ScalarKind,
) -> Operand {
    use ScalarKind::{Bool, Float, Sint, Uint};
    match (from, to) {
        (Float, Sint) => {
            let value = code.binary(Binary::FloatMin, value, float(MOST_SIGNED));
            code.unary(Unary::FloatToSigned, value)
        }
        (Float, Uint) => {
            let value = code.binary(Binary::FloatMin, value, float(MOST_UNSIGNED));
            code.unary(Unary::FloatToUnsigned, value)
        }
        (Sint, Float) => code.unary(Unary::SignedToFloat, value),
        (Uint, Float) => code.unary(Unary::UnsignedToFloat, value),
        (Bool, Float) => code.select(value, float(1.0), float(0.0)),
        (Bool, Sint | Uint) => code.unary(Unary::BoolToInt, value),
        (Float, Bool) => code.compare(Comparison::FloatNotEqual, value, float(0.0)),
        (Sint | Uint, Bool) => code.compare(Comparison::NotEqual, value, int(0)),
        _ => value,
    }
}

/// A conversion of the bits.
pub(super) fn reinterpret(
    code: &mut Emitter,
    value: Operand,
    from: ScalarKind,
    to: ScalarKind,
) -> Operand {
    use ScalarKind::{Float, Sint, Uint};
    match (from, to) {
        (Float, Sint | Uint) => code.unary(Unary::FloatBits, value),
        (Sint | Uint, Float) => code.unary(Unary::BitsToFloat, value),
        _ => value,
    }
}

/// The sum of products of floats.
pub(super) fn dot(code: &mut Emitter, a: &[Operand], b: &[Operand]) -> Operand {
    sum_of_products(code, Binary::FloatMultiply, Binary::FloatAdd, a, b)
}

/// Products and their sum, in the order of the components.
pub(super) fn sum_of_products(
    code: &mut Emitter,
    multiply: Binary,
    add: Binary,
    a: &[Operand],
    b: &[Operand],
) -> Operand {
    let mut sum = code.binary(multiply, a[0], b[0]);
    for (&a, &b) in a.iter().zip(b).skip(1) {
        let product = code.binary(multiply, a, b);
        sum = code.binary(add, sum, product);
    }
    sum
}

/// A quotient or remainder of integers. By zero the quotient is the dividend and the remainder zero; likewise where the
/// quotient doesn't fit.
fn divide(code: &mut Emitter, op: BinaryOperator, signed: bool, a: Operand, b: Operand) -> Operand {
    let op = match (op == BinaryOperator::Modulo, signed) {
        (false, false) => Binary::UnsignedDivide,
        (false, true) => Binary::SignedDivide,
        (true, false) => Binary::UnsignedRemainder,
        (true, true) => Binary::SignedRemainder,
    };
    let harmless = match b {
        Operand::Constant(_, bits) => bits != 0 && !(signed && bits == u32::MAX),
        Operand::Value(_) => false,
    };
    if harmless {
        return code.binary(op, a, b);
    }
    let mut bad = code.compare(Comparison::Equal, b, int(0));
    if signed {
        let by_minus_one = code.compare(Comparison::Equal, b, int(u32::MAX));
        let of_least = code.compare(Comparison::Equal, a, int(0x8000_0000));
        let overflows = code.binary(Binary::BoolAnd, by_minus_one, of_least);
        bad = code.binary(Binary::BoolOr, bad, overflows);
    }
    // By one the quotient is the dividend, and the remainder zero.
    let b = code.select(bad, int(1), b);
    code.binary(op, a, b)
}

/// One of three, by the kind of the operands.
fn by_kind<T>(kind: ScalarKind, floats: T, signs: T, others: T) -> T {
    match kind {
        ScalarKind::Float => floats,
        ScalarKind::Sint => signs,
        _ => others,
    }
}

/// An operator on two scalars of one kind; of shifts, the kind is that of the left one.
fn scalars(
    code: &mut Emitter,
    op: BinaryOperator,
    kind: ScalarKind,
    a: Operand,
    b: Operand,
) -> Operand {
    use BinaryOperator as Op;
    let (of_floats, signed, of_bools) = (
        kind == ScalarKind::Float,
        kind == ScalarKind::Sint,
        kind == ScalarKind::Bool,
    );
    let binary = match op {
        Op::Add => by_kind(kind, Binary::FloatAdd, Binary::Add, Binary::Add),
        Op::Subtract => by_kind(
            kind,
            Binary::FloatSubtract,
            Binary::Subtract,
            Binary::Subtract,
        ),
        Op::Multiply => by_kind(
            kind,
            Binary::FloatMultiply,
            Binary::Multiply,
            Binary::Multiply,
        ),
        Op::Divide if of_floats => Binary::FloatDivide,
        Op::Modulo if of_floats => {
            let quotient = code.binary(Binary::FloatDivide, a, b);
            let whole = code.unary(Unary::Truncate, quotient);
            let product = code.binary(Binary::FloatMultiply, whole, b);
            return code.binary(Binary::FloatSubtract, a, product);
        }
        Op::Divide | Op::Modulo => return divide(code, op, signed, a, b),
        Op::And | Op::LogicalAnd if of_bools => Binary::BoolAnd,
        Op::InclusiveOr | Op::LogicalOr if of_bools => Binary::BoolOr,
        Op::ExclusiveOr if of_bools => Binary::BoolXor,
        Op::NotEqual if of_bools => Binary::BoolXor,
        Op::Equal if of_bools => {
            let differ = code.binary(Binary::BoolXor, a, b);
            return code.unary(Unary::BoolNot, differ);
        }
        Op::And | Op::LogicalAnd => Binary::And,
        Op::InclusiveOr | Op::LogicalOr => Binary::Or,
        Op::ExclusiveOr => Binary::Xor,
        Op::ShiftLeft => Binary::ShiftLeft,
        Op::ShiftRight => match signed {
            true => Binary::SignedShiftRight,
            false => Binary::UnsignedShiftRight,
        },
        Op::Equal | Op::NotEqual | Op::Less | Op::LessEqual | Op::Greater | Op::GreaterEqual => {
            use Comparison as C;
            let comparison = match op {
                Op::Equal => by_kind(kind, C::FloatEqual, C::Equal, C::Equal),
                Op::NotEqual => by_kind(kind, C::FloatNotEqual, C::NotEqual, C::NotEqual),
                Op::Less => by_kind(kind, C::FloatLess, C::SignedLess, C::UnsignedLess),
                Op::LessEqual => by_kind(
                    kind,
                    C::FloatLessEqual,
                    C::SignedLessEqual,
                    C::UnsignedLessEqual,
                ),
                Op::Greater => by_kind(kind, C::FloatGreater, C::SignedGreater, C::UnsignedGreater),
                _ => by_kind(
                    kind,
                    C::FloatGreaterEqual,
                    C::SignedGreaterEqual,
                    C::UnsignedGreaterEqual,
                ),
            };
            return code.compare(comparison, a, b);
        }
    };
    // Shifts take the low five bits, also where constants say more.
    let b = match (binary, b) {
        (
            Binary::ShiftLeft | Binary::SignedShiftRight | Binary::UnsignedShiftRight,
            Operand::Constant(ty, bits),
        ) => Operand::Constant(ty, bits & 31),
        _ => b,
    };
    code.binary(binary, a, b)
}

impl<'m> Lowering<'m> {
    pub(super) fn binary(
        &mut self,
        frame: &mut Frame<'m>,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Result<Vec<Operand>, CompileError> {
        let shape = |inner: &TypeInner| match *inner {
            TypeInner::Matrix { columns, rows, .. } => {
                Some((components(columns) as usize, components(rows) as usize))
            }
            _ => None,
        };
        let (of_left, of_right) = (self.inner(frame, left), self.inner(frame, right));
        let matrices = (shape(of_left), shape(of_right));
        let vectors = matches!(of_left, TypeInner::Vector { .. })
            || matches!(of_right, TypeInner::Vector { .. });
        let kind = of_left
            .scalar_kind()
            .ok_or_else(|| ErrorKind::unsupported("this operator"))?;
        let a = self.scalars(frame, left)?;
        let b = self.scalars(frame, right)?;
        let code = &mut self.code;
        let row = |matrix: &[Operand], rows: usize, row: usize| -> Vec<Operand> {
            matrix.iter().copied().skip(row).step_by(rows).collect()
        };
        if op == BinaryOperator::Multiply {
            match matrices {
                (Some((_, rows)), None) if vectors => {
                    return Ok((0..rows)
                        .map(|r| dot(code, &row(&a, rows, r), &b))
                        .collect());
                }
                (None, Some((_, rows))) if vectors => {
                    return Ok(b.chunks(rows).map(|column| dot(code, &a, column)).collect());
                }
                (Some((inner, rows)), Some(_)) => {
                    return Ok(b
                        .chunks(inner)
                        .flat_map(|column| (0..rows).map(move |r| (column, r)))
                        .map(|(column, r)| dot(code, &row(&a, rows, r), column))
                        .collect());
                }
                _ => {}
            }
        }
        let count = a.len().max(b.len());
        let of = |all: &[Operand], index: usize| all[if all.len() == 1 { 0 } else { index }];
        Ok((0..count)
            .map(|i| scalars(code, op, kind, of(&a, i), of(&b, i)))
            .collect())
    }
}

/// Whether a scalar is below zero or above.
pub(super) fn sign(code: &mut Emitter, value: Operand, kind: ScalarKind) -> Operand {
    let (above, below, one, minus_one, zero) = match kind {
        ScalarKind::Float => (
            Comparison::FloatGreater,
            Comparison::FloatLess,
            float(1.0),
            float(-1.0),
            float(0.0),
        ),
        _ => (
            Comparison::SignedGreater,
            Comparison::SignedLess,
            int(1),
            int(u32::MAX),
            int(0),
        ),
    };
    let above = code.compare(above, value, zero);
    let below = code.compare(below, value, zero);
    let otherwise = code.select(below, minus_one, zero);
    code.select(above, one, otherwise)
}

/// Neither below zero nor above one.
pub(super) fn saturate(code: &mut Emitter, value: Operand) -> Operand {
    let value = code.binary(Binary::FloatMax, value, float(0.0));
    code.binary(Binary::FloatMin, value, float(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lower::emit::boolean;

    #[test]
    fn constants_leave_no_code() {
        let mut code = Emitter::default();
        let kind = ScalarKind::Sint;
        let zero = scalars(&mut code, BinaryOperator::Modulo, kind, int(7), int(0));
        assert_eq!(zero, int(0));
        let same = scalars(&mut code, BinaryOperator::Divide, kind, int(7), int(0));
        assert_eq!(same, int(7));
        let least = int(0x8000_0000);
        let quotient = scalars(
            &mut code,
            BinaryOperator::Divide,
            kind,
            least,
            int(u32::MAX),
        );
        assert_eq!(quotient, least);
        let equal = scalars(
            &mut code,
            BinaryOperator::Equal,
            ScalarKind::Bool,
            boolean(true),
            boolean(true),
        );
        assert_eq!(equal, boolean(true));
        assert_eq!(
            convert(&mut code, float(3e9), ScalarKind::Float, kind),
            int(2_147_483_520)
        );
        assert!(code.function.instructions.is_empty());
    }
}
