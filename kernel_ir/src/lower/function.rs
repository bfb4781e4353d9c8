//! Functions: written where they are called, or apart.

use naga::{Expression, Function, Handle, TypeInner, valid::FunctionInfo};

use super::{
    Lowering,
    emit::{Address, Operand, int},
    place::{Evaluated, Place},
    plan::InMemory,
    types::Part,
};
use crate::{
    CompileError,
    ir::{Instruction, Label, Memory, Runtime, Type, Variable, context},
};

/// Where a function's result goes.
pub(super) enum Exit {
    /// Written in place, with one return at its end.
    Direct(Option<Vec<Operand>>),
    /// Written in place.
    Jump {
        results: Variable,
        parts: Vec<Part>,
        label: Label,
        jumps: u32,
    },
    /// Apart: to memory, one scalar after the other.
    Memory(Address),
}

/// A function of the text while it is being written.
pub(super) struct Frame<'m> {
    pub(super) function: &'m Function,
    pub(super) info: &'m FunctionInfo,
    /// Of each expression that was written.
    pub(super) results: Vec<Option<Evaluated>>,
    /// Of each local variable.
    pub(super) locals: Vec<Place>,
    pub(super) arguments: Vec<Evaluated>,
    pub(super) exit: Exit,
}

impl<'m> Lowering<'m> {
    /// Begins a function: its local variables get their places and first values.
    pub(super) fn frame(
        &mut self,
        function: &'m Function,
        info: &'m FunctionInfo,
        in_memory: &InMemory,
        arguments: Vec<Evaluated>,
        exit: Exit,
    ) -> Result<Frame<'m>, CompileError> {
        let mut frame = Frame {
            function,
            info,
            results: vec![None; function.expressions.len()],
            locals: Vec::new(),
            arguments,
            exit,
        };
        for (handle, local) in function.local_variables.iter() {
            let span = function.local_variables.get_span(handle);
            let place = if in_memory.locals.contains(&handle) {
                let bytes = self.types.size(local.ty);
                Place::Memory(self.code.allocate(bytes))
            } else {
                let parts = self.types.parts(local.ty).map_err(|e| e.at(span))?;
                Place::Variables(self.code.variables(&parts))
            };
            frame.locals.push(place);
        }
        for (handle, local) in function.local_variables.iter() {
            let span = function.local_variables.get_span(handle);
            // Zero is what a variable starts with anyway, whatever its size.
            let zero = |init| matches!(function.expressions[init], Expression::ZeroValue(_));
            let init = match local.init.filter(|&init| !zero(init)) {
                Some(init) => Some(self.scalars(&mut frame, init)?),
                None => None,
            };
            let place = frame.locals[handle.index()];
            self.initialize(place, local.ty, init)
                .map_err(|e| e.at(span))?;
        }
        Ok(frame)
    }

    /// Calls a function: the scalars of its result.
    pub(super) fn call(
        &mut self,
        caller: &mut Frame<'m>,
        handle: Handle<Function>,
        arguments: &[Handle<Expression>],
    ) -> Result<Vec<Operand>, CompileError> {
        let arguments = arguments
            .iter()
            .map(|&argument| self.evaluate(caller, argument))
            .collect::<Result<Vec<_>, _>>()?;
        let function = &self.module.functions[handle];
        let parts = match &function.result {
            Some(result) => self.types.parts(result.ty)?.to_vec(),
            None => Vec::new(),
        };
        let mark = self.code.mark();
        let results = if self.plan.host.contains(&handle) {
            self.call_host(handle, arguments, &parts)?
        } else if self.plan.separate.contains(&handle) {
            self.call_apart(handle, arguments, &parts)?
        } else {
            self.inline(handle, function, arguments, parts)?
        };
        self.code.release(mark);
        Ok(results)
    }

    fn inline(
        &mut self,
        handle: Handle<Function>,
        function: &'m Function,
        arguments: Vec<Evaluated>,
        parts: Vec<Part>,
    ) -> Result<Vec<Operand>, CompileError> {
        let exit = match self.plan.straight.contains(&handle) {
            true => Exit::Direct(None),
            false => Exit::Jump {
                results: self.code.variables(&parts),
                parts: parts.clone(),
                label: self.code.new_label(),
                jumps: 0,
            },
        };
        // Its own variables are nobody else's.
        let first = self.code.function.variable_types.len() as u32;
        let targets = std::mem::take(&mut self.targets);
        let in_memory = self.plan.in_memory.remove(&handle).unwrap_or_default();
        let info = &self.info[handle];
        let frame = self.frame(function, info, &in_memory, arguments, exit);
        self.plan.in_memory.insert(handle, in_memory);
        let mut frame = frame?;
        let falls = self.block(&mut frame, &function.body)?;
        self.targets = targets;
        let results = match frame.exit {
            // The one return is behind what never ends. What is written after that never runs.
            Exit::Direct(None) if !falls => {
                self.code.known.clear();
                let label = self.code.new_label();
                self.code.label(label);
                let Variable(first) = self.code.variables(&parts);
                (first..)
                    .take(parts.len())
                    .map(|variable| self.code.get(Variable(variable)))
                    .collect()
            }
            Exit::Direct(results) => results.unwrap_or_default(),
            Exit::Memory(_) => Vec::new(),
            Exit::Jump {
                results,
                parts,
                label,
                jumps,
            } => {
                let last = self.code.function.instructions.last();
                let at_end = matches!(last, Some(Instruction::Jump(to)) if *to == label);
                if !falls && jumps == 1 && at_end {
                    // The one way out is the end of what was written: no label is needed.
                    self.code.function.instructions.pop();
                } else if !falls || jumps > 0 {
                    if falls {
                        self.code.jump(label);
                    }
                    self.code.known.clear();
                    self.code.label(label);
                }
                (results.0..)
                    .take(parts.len())
                    .map(|variable| self.code.get(Variable(variable)))
                    .collect()
            }
        };
        self.code.known.retain(|variable, _| variable.0 < first);
        Ok(results)
    }

    fn call_apart(
        &mut self,
        handle: Handle<Function>,
        arguments: Vec<Evaluated>,
        parts: &[Part],
    ) -> Result<Vec<Operand>, CompileError> {
        let next = self.numbers.len() + 1;
        let number = *self.numbers.entry(handle).or_insert_with(|| {
            self.waiting.push(handle);
            next
        });
        let callees = &mut self.code.function.callees;
        let callee = callees
            .iter()
            .position(|&callee| callee == number)
            .unwrap_or_else(|| {
                callees.push(number);
                callees.len() - 1
            });
        let packed = packed(parts);
        let memory = self.code.allocate(4 * packed.len() as u64);
        let mut flat = vec![self.context, self.private, memory.base];
        for argument in arguments {
            match argument {
                Evaluated::Scalars(scalars) => {
                    for scalar in scalars {
                        flat.push(self.code.materialize(scalar));
                    }
                }
                Evaluated::Place(Place::Memory(address)) => flat.push(self.code.pointer(address)),
                Evaluated::Place(_) => {
                    return Err(super::ErrorKind::unsupported("this pointer as an argument"));
                }
            }
        }
        self.code.push(Instruction::Call {
            callee: callee as u32,
            arguments: flat,
        });
        self.load(Place::Memory(memory), &packed)
    }

    /// Calls what is bound in a function's place.
    fn call_host(
        &mut self,
        handle: Handle<Function>,
        arguments: Vec<Evaluated>,
        parts: &[Part],
    ) -> Result<Vec<Operand>, CompileError> {
        let mut scalars = Vec::new();
        for argument in arguments {
            match argument {
                Evaluated::Scalars(argument) => scalars.extend(argument),
                Evaluated::Place(_) => {
                    return Err(super::ErrorKind::unsupported(
                        "a pointer as an argument of a function of the program",
                    ));
                }
            }
        }
        let packed = packed(parts);
        let words = [scalars.len(), packed.len()];
        let entry = context::binding(self.host_binding(handle, words));
        let entry = self.context_place(entry);
        let function = self.code.load(entry, Type::Pointer);
        let function = self.code.materialize(function);
        let [from, to] = words.map(|words| self.code.allocate(4 * words as u64));
        let dense = self.dense(&scalars);
        self.store(Place::Memory(from), &dense, &scalars)?;
        let [taken, given] = words.map(|words| {
            self.code
                .materialize(int(u32::try_from(words).unwrap_or(0)))
        });
        let (from, target) = (self.code.pointer(from), self.code.pointer(to));
        let arguments = vec![function, from, taken, target, given];
        self.code.runtime_memory(Runtime::Host, arguments);
        self.load(Place::Memory(to), &packed)
    }

    /// Writes a function apart: context, private variables, place of the result, arguments.
    pub(super) fn function(&mut self, handle: Handle<Function>) -> Result<(), CompileError> {
        let module = self.module;
        let function = &module.functions[handle];
        let mut parameters = vec![Type::Pointer; 3];
        let mut shapes = Vec::new();
        for argument in &function.arguments {
            match module.types[argument.ty].inner {
                TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } => {
                    shapes.push(None);
                    parameters.push(Type::Pointer);
                }
                _ => {
                    let parts = self.types.parts(argument.ty)?;
                    shapes.push(Some(parts.len()));
                    parameters.extend(parts.iter().map(|part| part.ty));
                }
            }
        }
        let values = self.begin(function.name.as_deref().unwrap_or("function"), &parameters);
        (self.context, self.private) = (values[0], values[1]);
        let own = |base| Address {
            base,
            offset: 0,
            memory: Memory::Plain,
            binding: None,
        };
        let mut rest = &values[3..];
        let mut arguments = Vec::new();
        for shape in shapes {
            let (first, others) = rest.split_at(shape.unwrap_or(1));
            rest = others;
            arguments.push(match shape {
                None => Evaluated::Place(Place::Memory(own(first[0]))),
                Some(_) => {
                    Evaluated::Scalars(first.iter().map(|&value| Operand::Value(value)).collect())
                }
            });
        }
        let exit = Exit::Memory(own(values[2]));
        let in_memory = self.plan.in_memory[&handle].clone();
        let mut frame = self.frame(function, &self.info[handle], &in_memory, arguments, exit)?;
        if self.block(&mut frame, &function.body)? {
            self.code.push(Instruction::Return);
        }
        Ok(())
    }

    /// Leaves the function.
    pub(super) fn leave(
        &mut self,
        frame: &mut Frame<'m>,
        values: Vec<Operand>,
    ) -> Result<(), CompileError> {
        match &mut frame.exit {
            Exit::Direct(results) => *results = Some(values),
            Exit::Jump {
                results,
                label,
                jumps,
                ..
            } => {
                *jumps += 1;
                for (variable, value) in (results.0..).zip(values) {
                    self.code.set(Variable(variable), value);
                }
                self.code.jump(*label);
            }
            Exit::Memory(memory) => {
                let memory = *memory;
                let parts = self.dense(&values);
                self.store(Place::Memory(memory), &parts, &values)?;
                self.code.push(Instruction::Return);
            }
        }
        Ok(())
    }
}

/// Scalars one after the other.
fn packed(parts: &[Part]) -> Vec<Part> {
    (0..)
        .zip(parts)
        .map(|(index, part)| Part {
            offset: 4 * index,
            ty: part.ty,
        })
        .collect()
}
