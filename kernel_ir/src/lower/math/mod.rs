//! WGSL's functions. Those of numbers work component by component; formulas are those of WGSL's specification (section
//! "Builtin functions").

mod bits;
mod elementary;
mod geometry;
mod matrix;
mod pack;

use naga::{Expression, Handle, MathFunction, ScalarKind, TypeInner};

use super::{
    Lowering,
    emit::{Emitter, Operand},
    function::Frame,
    types::components,
};
use crate::{
    CompileError, ErrorKind,
    ir::{Binary, Runtime, Type},
};

/// Arguments of a function, each as its scalars.
struct Arguments {
    all: [Vec<Operand>; 4],
    kind: ScalarKind,
    /// Rows, if the first is a matrix.
    rows: Option<usize>,
}

impl Arguments {
    /// A component of an argument; a scalar stands for all components.
    fn of(&self, argument: usize, component: usize) -> Operand {
        let all = &self.all[argument];
        all[if all.len() == 1 { 0 } else { component }]
    }

    /// Components of the result.
    fn width(&self) -> usize {
        self.all.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// A number per component.
    fn each(&self, mut result: impl FnMut(usize) -> Operand) -> Vec<Operand> {
        (0..self.width()).map(&mut result).collect()
    }

    /// A function of the runtime for each component.
    fn each_by(&self, code: &mut Emitter, function: Runtime, ty: Type) -> Vec<Operand> {
        let count = self.all.iter().filter(|a| !a.is_empty()).count();
        self.each(|i| {
            let arguments: Vec<_> = (0..count).map(|a| self.of(a, i)).collect();
            code.runtime(function, ty, &arguments)
        })
    }

    fn is_float(&self) -> bool {
        self.kind == ScalarKind::Float
    }

    fn min(&self) -> Binary {
        match self.kind {
            ScalarKind::Float => Binary::FloatMin,
            ScalarKind::Sint => Binary::SignedMin,
            _ => Binary::UnsignedMin,
        }
    }

    fn max(&self) -> Binary {
        match self.kind {
            ScalarKind::Float => Binary::FloatMax,
            ScalarKind::Sint => Binary::SignedMax,
            _ => Binary::UnsignedMax,
        }
    }
}

impl<'m> Lowering<'m> {
    pub(super) fn math(
        &mut self,
        frame: &mut Frame<'m>,
        function: MathFunction,
        handles: [Option<Handle<Expression>>; 4],
    ) -> Result<Vec<Operand>, CompileError> {
        let unsupported = || ErrorKind::unsupported(format!("the function {function:?}"));
        let first = handles[0].ok_or_else(unsupported)?;
        let inner = self.inner(frame, first);
        let rows = match *inner {
            TypeInner::Matrix { rows, .. } => Some(components(rows) as usize),
            _ => None,
        };
        let kind = inner.scalar_kind().ok_or_else(unsupported)?;
        let mut all: [Vec<Operand>; 4] = Default::default();
        for (scalars, handle) in all.iter_mut().zip(handles) {
            if let Some(handle) = handle {
                *scalars = self.scalars(frame, handle)?;
            }
        }
        let arguments = Arguments { all, kind, rows };
        let code = &mut self.code;
        elementary::lower(code, function, &arguments)
            .or_else(|| geometry::lower(code, function, &arguments))
            .or_else(|| matrix::lower(code, function, &arguments))
            .or_else(|| bits::lower(code, function, &arguments))
            .or_else(|| pack::lower(code, function, &arguments))
            .ok_or_else(unsupported)
    }
}
