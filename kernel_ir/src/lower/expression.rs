//! Expressions: each is written once, where the text evaluates it.

use std::sync::Arc;

use naga::{Expression, Handle, RelationalFunction, TypeInner};

use super::{
    Lowering,
    emit::{Operand, float},
    function::Frame,
    global::literal,
    place::{Evaluated, Place},
    types::{Part, components, scalar_type},
};
use crate::{
    CompileError, ErrorKind,
    ir::{Binary, Comparison, Unary, context},
};

impl<'m> Lowering<'m> {
    /// The type of an expression.
    pub(super) fn inner<'a>(
        &self,
        frame: &'a Frame<'m>,
        handle: Handle<Expression>,
    ) -> &'a TypeInner
    where
        'm: 'a,
    {
        frame.info[handle].ty.inner_with(&self.module.types)
    }

    /// The scalars of what an expression is, or points to.
    pub(super) fn parts(
        &mut self,
        frame: &Frame<'m>,
        handle: Handle<Expression>,
    ) -> Result<Arc<[Part]>, CompileError> {
        match *frame.info[handle].ty.inner_with(&self.module.types) {
            TypeInner::Pointer { base, .. } => self.types.parts(base),
            TypeInner::ValuePointer { size, scalar, .. } => {
                let ty = scalar_type(scalar)?;
                let count = size.map_or(1, components);
                Ok((0..count)
                    .map(|index| Part {
                        offset: 4 * index,
                        ty,
                    })
                    .collect())
            }
            ref inner => Ok(self.types.of_inner(inner)?.into()),
        }
    }

    pub(super) fn scalars(
        &mut self,
        frame: &mut Frame<'m>,
        handle: Handle<Expression>,
    ) -> Result<Vec<Operand>, CompileError> {
        match self.evaluate(frame, handle)? {
            Evaluated::Scalars(scalars) => Ok(scalars),
            Evaluated::Place(_) => Err(ErrorKind::unsupported("a pointer as a value")
                .at(frame.function.expressions.get_span(handle))),
        }
    }

    pub(super) fn scalar(
        &mut self,
        frame: &mut Frame<'m>,
        handle: Handle<Expression>,
    ) -> Result<Operand, CompileError> {
        Ok(self.scalars(frame, handle)?[0])
    }

    pub(super) fn place(
        &mut self,
        frame: &mut Frame<'m>,
        handle: Handle<Expression>,
    ) -> Result<Place, CompileError> {
        match self.evaluate(frame, handle)? {
            Evaluated::Place(place) => Ok(place),
            Evaluated::Scalars(_) => Err(ErrorKind::unsupported("a value as a pointer")
                .at(frame.function.expressions.get_span(handle))),
        }
    }

    /// What an expression is; written now if it isn't yet.
    pub(super) fn evaluate(
        &mut self,
        frame: &mut Frame<'m>,
        handle: Handle<Expression>,
    ) -> Result<Evaluated, CompileError> {
        if let Some(known) = &frame.results[handle.index()] {
            return Ok(known.clone());
        }
        // What no statement evaluates is cheap, and may be asked for on another branch first: it is written anew.
        self.expression(frame, handle)
    }

    /// Evaluates an expression here, once and for all.
    pub(super) fn emit(
        &mut self,
        frame: &mut Frame<'m>,
        handle: Handle<Expression>,
    ) -> Result<(), CompileError> {
        let result = self.expression(frame, handle)?;
        frame.results[handle.index()] = Some(result);
        Ok(())
    }

    fn expression(
        &mut self,
        frame: &mut Frame<'m>,
        handle: Handle<Expression>,
    ) -> Result<Evaluated, CompileError> {
        let function = frame.function;
        self.expression_unplaced(frame, handle, &function.expressions[handle])
            .map_err(|error| error.at(function.expressions.get_span(handle)))
    }

    fn expression_unplaced(
        &mut self,
        frame: &mut Frame<'m>,
        handle: Handle<Expression>,
        expression: &'m Expression,
    ) -> Result<Evaluated, CompileError> {
        let module = self.module;
        Ok(Evaluated::Scalars(match *expression {
            Expression::Literal(ref value) => vec![literal(value)?],
            Expression::Constant(constant) => self.constant(module.constants[constant].init)?,
            Expression::ZeroValue(ty) => self.zeros(ty)?,
            Expression::Compose { ref components, .. } => {
                let mut all = Vec::new();
                for &component in components {
                    all.extend(self.scalars(frame, component)?);
                }
                all
            }
            Expression::Splat { size, value } => {
                vec![self.scalar(frame, value)?; components(size) as usize]
            }
            Expression::Swizzle {
                size,
                vector,
                pattern,
            } => {
                let vector = self.scalars(frame, vector)?;
                let chosen = &pattern[..components(size) as usize];
                chosen.iter().map(|&c| vector[c as usize]).collect()
            }
            Expression::FunctionArgument(index) => {
                return Ok(frame.arguments[index as usize].clone());
            }
            Expression::GlobalVariable(global) => {
                return Ok(Evaluated::Place(self.global(global)?));
            }
            Expression::LocalVariable(local) => {
                return Ok(Evaluated::Place(frame.locals[local.index()]));
            }
            Expression::Load { pointer } => self.load_expression(frame, pointer)?,
            Expression::AccessIndex { base, index } => {
                return self.access_index(frame, base, index);
            }
            Expression::Access { base, index } => return self.access(frame, base, index),
            Expression::Unary { op, expr } => {
                let kind = self.inner(frame, expr).scalar_kind();
                let values = self.scalars(frame, expr)?;
                let op = super::operator::unary(op, kind);
                values
                    .into_iter()
                    .map(|value| self.code.unary(op, value))
                    .collect()
            }
            Expression::Binary { op, left, right } => self.binary(frame, op, left, right)?,
            Expression::Select {
                condition,
                accept,
                reject,
            } => {
                let condition = self.scalars(frame, condition)?;
                let accept = self.scalars(frame, accept)?;
                let reject = self.scalars(frame, reject)?;
                let choices = accept.into_iter().zip(reject);
                choices
                    .zip(condition.iter().cycle())
                    .map(|((accept, reject), &condition)| {
                        self.code.select(condition, accept, reject)
                    })
                    .collect()
            }
            Expression::Relational { fun, argument } => {
                let values = self.scalars(frame, argument)?;
                self.relational(fun, values)
            }
            Expression::Math {
                fun,
                arg,
                arg1,
                arg2,
                arg3,
            } => {
                let arguments = [Some(arg), arg1, arg2, arg3];
                self.math(frame, fun, arguments)?
            }
            Expression::As {
                expr,
                kind,
                convert,
            } => {
                let from = match *self.inner(frame, expr) {
                    TypeInner::Matrix { .. } => return self.evaluate(frame, expr),
                    ref inner => inner
                        .scalar_kind()
                        .ok_or_else(|| ErrorKind::unsupported("this conversion"))?,
                };
                let width = convert.unwrap_or(4);
                scalar_type(naga::Scalar { kind, width })?;
                let values = self.scalars(frame, expr)?;
                values
                    .into_iter()
                    .map(|value| match convert {
                        Some(_) => super::operator::convert(&mut self.code, value, from, kind),
                        None => super::operator::reinterpret(&mut self.code, value, from, kind),
                    })
                    .collect()
            }
            Expression::ArrayLength(array) => match self.place(frame, array)? {
                Place::Memory(address) if address.binding.is_some() => {
                    let last = self.last_index(address.binding.unwrap_or_default());
                    vec![self.code.binary(Binary::Add, last, super::emit::int(1))]
                }
                _ => return Err(ErrorKind::unsupported("the length of this array")),
            },
            Expression::ImageLoad {
                image,
                coordinate,
                array_index,
                ..
            } => self.image_load(frame, image, coordinate, array_index)?,
            Expression::ImageQuery { image, query } => self.image_query(frame, image, query)?,
            // Statements write these.
            Expression::CallResult(_)
            | Expression::AtomicResult { .. }
            | Expression::WorkGroupUniformLoadResult { .. } => {
                return Err(ErrorKind::unsupported("a result before its statement"));
            }
            ref other => return Err(ErrorKind::unsupported(name(other, handle))),
        }))
    }

    /// The last index of a buffer's runtime-sized array.
    pub(super) fn last_index(&mut self, binding: usize) -> Operand {
        let place = self.context_place(context::last_index(binding));
        self.code.load(place, crate::ir::Type::I32)
    }

    fn relational(&mut self, fun: RelationalFunction, values: Vec<Operand>) -> Vec<Operand> {
        let code = &mut self.code;
        let mut fold = |op| {
            let combine = |a, b| code.binary(op, a, b);
            values.iter().copied().reduce(combine).into_iter().collect()
        };
        match fun {
            RelationalFunction::All => fold(Binary::BoolAnd),
            RelationalFunction::Any => fold(Binary::BoolOr),
            RelationalFunction::IsNan => values
                .iter()
                .map(|&x| code.compare(Comparison::FloatNotEqual, x, x))
                .collect(),
            RelationalFunction::IsInf => values
                .iter()
                .map(|&x| {
                    let size = code.unary(Unary::FloatAbs, x);
                    code.compare(Comparison::FloatEqual, size, float(f32::INFINITY))
                })
                .collect(),
        }
    }
}

/// What an expression is, for those who wrote it.
fn name(expression: &Expression, handle: Handle<Expression>) -> String {
    match expression {
        Expression::ImageSample { .. } => "a texture sample".to_owned(),
        Expression::Derivative { .. } => "a derivative".to_owned(),
        Expression::RayQueryProceedResult
        | Expression::RayQueryGetIntersection { .. }
        | Expression::RayQueryVertexPositions { .. } => "a ray query".to_owned(),
        Expression::SubgroupBallotResult | Expression::SubgroupOperationResult { .. } => {
            "a subgroup operation".to_owned()
        }
        other => format!("{other:?} ({handle:?})"),
    }
}
