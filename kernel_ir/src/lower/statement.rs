//! Statements. A condition that is known leaves the code of one side.

use naga::{Block, Expression, Handle, Span, Statement, SwitchCase, SwitchValue};

use super::{
    Lowering, Targets,
    emit::{Operand, int},
    function::Frame,
    place::Evaluated,
};
use crate::{
    CompileError, ErrorKind,
    ir::{Binary, Comparison, Instruction, Label, Type},
};

/// Zeros of more scalars than this are written by one call.
const MOST_STORED: u64 = 64;

impl<'m> Lowering<'m> {
    /// Writes a block; whether control falls out of its end.
    pub(super) fn block(
        &mut self,
        frame: &mut Frame<'m>,
        block: &'m Block,
    ) -> Result<bool, CompileError> {
        for (statement, &span) in block.span_iter() {
            if !self
                .statement(frame, statement, span)
                .map_err(|e| e.at(span))?
            {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn statement(
        &mut self,
        frame: &mut Frame<'m>,
        statement: &'m Statement,
        span: Span,
    ) -> Result<bool, CompileError> {
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone() {
                    self.emit(frame, handle)?;
                }
            }
            Statement::Block(block) => return self.block(frame, block),
            Statement::If {
                condition,
                accept,
                reject,
            } => return self.choice(frame, *condition, accept, reject),
            Statement::Switch { selector, cases } => return self.switch(frame, *selector, cases),
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => return self.repeat(frame, body, continuing, *break_if),
            Statement::Break => {
                let target = self.targets.last_mut().ok_or_else(misplaced)?;
                target.exits += 1;
                let exit = target.exit;
                self.code.jump(exit);
                return Ok(false);
            }
            Statement::Continue => {
                let next = self.targets.iter().rev().find_map(|target| target.next);
                self.code.jump(next.ok_or_else(misplaced)?);
                return Ok(false);
            }
            Statement::Return { value } => {
                let values = match value {
                    Some(value) => self.scalars(frame, *value)?,
                    None => Vec::new(),
                };
                self.leave(frame, values)?;
                return Ok(false);
            }
            Statement::Store { pointer, value } => {
                // Large zeros are no values.
                if let Expression::ZeroValue(ty) = frame.function.expressions[*value]
                    && self.types.count(&self.module.types[ty].inner) > MOST_STORED
                {
                    let place = self.place(frame, *pointer)?;
                    self.initialize(place, ty, None)?;
                    return Ok(true);
                }
                let parts = self.parts(frame, *pointer)?;
                let values = self.scalars(frame, *value)?;
                let place = self.place(frame, *pointer)?;
                self.store(place, &parts, &values)?;
            }
            Statement::Call {
                function,
                arguments,
                result,
            } => {
                let results = self.call(frame, *function, arguments)?;
                if let Some(result) = result {
                    frame.results[result.index()] = Some(Evaluated::Scalars(results));
                }
            }
            Statement::Atomic {
                pointer,
                fun,
                value,
                result,
            } => self.atomic(frame, *pointer, fun, *value, *result)?,
            Statement::ImageStore {
                image,
                coordinate,
                array_index,
                value,
            } => self.image_store(frame, *image, *coordinate, *array_index, *value)?,
            Statement::ControlBarrier(_) => self.barrier(),
            // Invocations of a workgroup run one after the other between barriers.
            Statement::MemoryBarrier(_) => {}
            Statement::WorkGroupUniformLoad { pointer, result } => {
                self.barrier();
                let parts = self.parts(frame, *pointer)?;
                let place = self.place(frame, *pointer)?;
                let values = self.load(place, &parts)?;
                frame.results[result.index()] = Some(Evaluated::Scalars(values));
                self.barrier();
            }
            other => return Err(ErrorKind::unsupported(name(other)).at(span)),
        }
        Ok(true)
    }

    fn barrier(&mut self) {
        self.code.push(Instruction::Barrier);
    }

    fn choice(
        &mut self,
        frame: &mut Frame<'m>,
        condition: Handle<Expression>,
        accept: &'m Block,
        reject: &'m Block,
    ) -> Result<bool, CompileError> {
        let condition = self.scalar(frame, condition)?;
        if let Operand::Constant(_, bits) = condition {
            return self.block(frame, if bits != 0 { accept } else { reject });
        }
        let (yes, no, join) = (
            self.code.new_label(),
            self.code.new_label(),
            self.code.new_label(),
        );
        self.code.branch(condition, yes, no);
        let before = self.known();
        self.code.label(yes);
        let accept_falls = self.block(frame, accept)?;
        if accept_falls {
            self.code.jump(join);
        }
        let after_accept = std::mem::replace(&mut self.code.known, before);
        self.code.label(no);
        let reject_falls = self.block(frame, reject)?;
        if reject_falls {
            self.code.jump(join);
        }
        match (accept_falls, reject_falls) {
            (true, true) => self
                .code
                .known
                .retain(|variable, constant| after_accept.get(variable) == Some(constant)),
            (true, false) => self.code.known = after_accept,
            (false, true) => {}
            (false, false) => return Ok(false),
        }
        self.code.label(join);
        Ok(true)
    }

    fn switch(
        &mut self,
        frame: &mut Frame<'m>,
        selector: Handle<Expression>,
        cases: &'m [SwitchCase],
    ) -> Result<bool, CompileError> {
        let selector = self.scalar(frame, selector)?;
        let exit = self.code.new_label();
        let labels: Vec<Label> = cases.iter().map(|_| self.code.new_label()).collect();
        let mut table = Vec::new();
        let mut default = exit;
        for (case, &label) in cases.iter().zip(&labels) {
            match case.value {
                SwitchValue::I32(value) => table.push((value as u32, label)),
                SwitchValue::U32(value) => table.push((value, label)),
                SwitchValue::Default => default = label,
            }
        }
        let mut exits = u32::from(default == exit);
        let only = match selector {
            Operand::Constant(_, bits) => {
                let case = table.iter().find(|(value, _)| *value == bits);
                let label = case.map_or(default, |(_, label)| *label);
                self.code.jump(label);
                Some(label)
            }
            Operand::Value(selector) => {
                self.code.push(Instruction::Switch {
                    selector,
                    cases: table,
                    default,
                });
                None
            }
        };
        let before = self.known();
        self.targets.push(Targets {
            exit,
            exits: 0,
            next: None,
        });
        let mut falls_in = false;
        for (index, case) in cases.iter().enumerate() {
            let chosen = only.is_none_or(|only| only == labels[index]);
            if !chosen && !falls_in {
                continue;
            }
            self.code.known = match falls_in {
                true => super::Known::new(),
                false => before.clone(),
            };
            self.code.label(labels[index]);
            falls_in = false;
            if self.block(frame, &case.body)? {
                let next = labels.get(index + 1).filter(|_| case.fall_through);
                falls_in = next.is_some();
                exits += u32::from(!falls_in);
                self.code.jump(next.copied().unwrap_or(exit));
            }
        }
        exits += self.targets.pop().map_or(0, |target| target.exits);
        self.code.known.clear();
        if exits == 0 {
            return Ok(false);
        }
        self.code.label(exit);
        Ok(true)
    }

    fn repeat(
        &mut self,
        frame: &mut Frame<'m>,
        body: &'m Block,
        continuing: &'m Block,
        break_if: Option<Handle<Expression>>,
    ) -> Result<bool, CompileError> {
        let (head, next, exit) = (
            self.code.new_label(),
            self.code.new_label(),
            self.code.new_label(),
        );
        let mut exits = 0;
        let counter = self.options.loop_limit.map(|limit| {
            let counter = self.code.variable(Type::I32);
            self.code.set(counter, int(limit));
            counter
        });
        self.code.jump(head);
        self.code.known.clear();
        self.code.label(head);
        if let Some(counter) = counter {
            let start = self.code.new_label();
            let left = self.code.get(counter);
            let none = self.code.compare(Comparison::Equal, left, int(0));
            self.code.branch(none, exit, start);
            self.code.label(start);
            let left = self.code.binary(Binary::Subtract, left, int(1));
            self.code.set(counter, left);
            exits += 1;
        }
        self.targets.push(Targets {
            exit,
            exits: 0,
            next: Some(next),
        });
        if self.block(frame, body)? {
            self.code.jump(next);
        }
        self.code.known.clear();
        self.code.label(next);
        if self.block(frame, continuing)? {
            match break_if {
                Some(condition) => {
                    let condition = self.scalar(frame, condition)?;
                    self.code.branch(condition, exit, head);
                    exits += 1;
                }
                None => self.code.jump(head),
            }
        }
        exits += self.targets.pop().map_or(0, |target| target.exits);
        self.code.known.clear();
        if exits == 0 {
            return Ok(false);
        }
        self.code.label(exit);
        Ok(true)
    }
}

fn misplaced() -> CompileError {
    ErrorKind::unsupported("a jump out of no loop")
}

/// What a statement is, for those who wrote it.
fn name(statement: &Statement) -> String {
    match statement {
        Statement::RayQuery { .. } => "a ray query",
        Statement::ImageAtomic { .. } => "an atomic operation on a texture",
        Statement::SubgroupBallot { .. }
        | Statement::SubgroupGather { .. }
        | Statement::SubgroupCollectiveOperation { .. } => "a subgroup operation",
        Statement::Kill => "`discard`",
        _ => "this statement",
    }
    .to_owned()
}
