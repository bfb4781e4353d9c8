//! Atomic operations.

use naga::{AtomicFunction, Expression, Handle, ScalarKind, TypeInner};

use super::{
    Lowering,
    emit::Operand,
    function::Frame,
    place::{Evaluated, Place},
    types::Part,
};
use crate::{
    CompileError, ErrorKind,
    ir::{AtomicOperation, Comparison, Instruction, Memory, Type},
};

impl<'m> Lowering<'m> {
    pub(super) fn atomic(
        &mut self,
        frame: &mut Frame<'m>,
        pointer: Handle<Expression>,
        function: &AtomicFunction,
        value: Handle<Expression>,
        result: Option<Handle<Expression>>,
    ) -> Result<(), CompileError> {
        let signed = match self.inner(frame, value).scalar() {
            Some(scalar) if scalar.width == 4 && scalar.kind == ScalarKind::Sint => true,
            Some(scalar) if scalar.width == 4 && scalar.kind == ScalarKind::Uint => false,
            _ => return Err(ErrorKind::unsupported("an atomic of this type")),
        };
        let value = self.scalar(frame, value)?;
        let value = self.code.materialize(value);
        let Place::Memory(address) = self.place(frame, pointer)? else {
            return Err(ErrorKind::unsupported("an atomic here"));
        };
        let (base, offset) = (address.base, address.offset);
        let choose = |signs, others| if signed { signs } else { others };
        let op = match *function {
            AtomicFunction::Add => AtomicOperation::Add,
            AtomicFunction::Subtract => AtomicOperation::Subtract,
            AtomicFunction::And => AtomicOperation::And,
            AtomicFunction::InclusiveOr => AtomicOperation::Or,
            AtomicFunction::ExclusiveOr => AtomicOperation::Xor,
            AtomicFunction::Min => choose(AtomicOperation::SignedMin, AtomicOperation::UnsignedMin),
            AtomicFunction::Max => choose(AtomicOperation::SignedMax, AtomicOperation::UnsignedMax),
            AtomicFunction::Exchange { compare: None } => AtomicOperation::Exchange,
            AtomicFunction::Exchange {
                compare: Some(compare),
            } => {
                let compare = self.scalar(frame, compare)?;
                let expected = self.code.materialize(compare);
                let to = self.code.value(Type::I32);
                self.code.push(Instruction::CompareExchange {
                    to,
                    base,
                    offset,
                    expected,
                    value,
                });
                let old = Operand::Value(to);
                let exchanged = self.code.compare(Comparison::Equal, old, compare);
                if let Some(result) = result {
                    let results = vec![old, exchanged];
                    frame.results[result.index()] = Some(Evaluated::Scalars(results));
                }
                return Ok(());
            }
        };
        let to = self.code.value(Type::I32);
        self.code.push(Instruction::Atomic {
            to,
            op,
            base,
            offset,
            value,
        });
        if let Some(result) = result {
            let results = vec![Operand::Value(to)];
            frame.results[result.index()] = Some(Evaluated::Scalars(results));
        }
        Ok(())
    }

    /// Reads what a pointer points to.
    pub(super) fn load_expression(
        &mut self,
        frame: &mut Frame<'m>,
        pointer: Handle<Expression>,
    ) -> Result<Vec<Operand>, CompileError> {
        let span = frame.function.expressions.get_span(pointer);
        let parts = self.parts(frame, pointer).map_err(|e| e.at(span))?;
        let place = self.place(frame, pointer)?;
        let is_atomic = match *self.inner(frame, pointer) {
            TypeInner::Pointer { base, .. } => {
                matches!(self.module.types[base].inner, TypeInner::Atomic(_))
            }
            _ => false,
        };
        match (place, &*parts) {
            (Place::Memory(address), [Part { ty, .. }]) if is_atomic => {
                let memory = Memory::Atomic;
                Ok(vec![
                    self.code
                        .load(super::emit::Address { memory, ..address }, *ty),
                ])
            }
            _ => self.load(place, &parts),
        }
    }
}
