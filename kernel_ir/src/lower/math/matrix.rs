//! Functions of matrices, which are lists of columns.

use naga::MathFunction as Math;

use super::Arguments;
use crate::{
    ir::Binary,
    lower::emit::{Emitter, Operand, float},
};

pub(super) fn lower(
    code: &mut Emitter,
    function: Math,
    arguments: &Arguments,
) -> Option<Vec<Operand>> {
    let (matrix, rows) = (&arguments.all[0], arguments.rows?);
    match function {
        Math::Transpose => Some(
            (0..rows)
                .flat_map(|row| matrix.iter().copied().skip(row).step_by(rows))
                .collect(),
        ),
        Math::Determinant => {
            let columns: Vec<&[Operand]> = matrix.chunks(rows).collect();
            Some(vec![determinant(
                code,
                &columns,
                &(0..rows).collect::<Vec<_>>(),
            )])
        }
        _ => None,
    }
}

/// By the first column, of the given rows.
fn determinant(code: &mut Emitter, columns: &[&[Operand]], rows: &[usize]) -> Operand {
    if let [row] = rows {
        return columns[0][*row];
    }
    let mut sum = None;
    for (index, &row) in rows.iter().enumerate() {
        let others: Vec<usize> = rows.iter().copied().filter(|&other| other != row).collect();
        let minor = determinant(code, &columns[1..], &others);
        let term = code.binary(Binary::FloatMultiply, columns[0][row], minor);
        sum = Some(match sum {
            None => term,
            Some(sum) if index % 2 == 1 => code.binary(Binary::FloatSubtract, sum, term),
            Some(sum) => code.binary(Binary::FloatAdd, sum, term),
        });
    }
    sum.unwrap_or(float(1.0))
}
