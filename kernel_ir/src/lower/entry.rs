//! The entry point: runs the invocations of one workgroup, one after the other.

use naga::{AddressSpace, BuiltIn, EntryPoint, valid::FunctionInfo};

use super::{
    Lowering, barrier,
    emit::{Operand, int},
    function::Exit,
    global::GlobalPlace,
    place::Evaluated,
};
use crate::{
    CompileError, ErrorKind,
    ir::{Binary, Comparison, Instruction, Invocations, Type, Value, context},
};

/// The most bytes of workgroup variables; of all workgroups that run at once, each has its own.
const MOST_WORKGROUP_BYTES: u64 = 4 << 20;

impl<'m> Lowering<'m> {
    /// Writes the entry point; bytes of scratch memory that it needs, and the loop over invocations if it is one.
    pub(super) fn entry(
        &mut self,
        entry: &'m EntryPoint,
        info: &'m FunctionInfo,
    ) -> Result<(u32, Option<Invocations>), CompileError> {
        let parameters = [
            Type::Pointer,
            Type::Pointer,
            Type::I32,
            Type::I32,
            Type::I32,
        ];
        let values = self.begin(&entry.name, &parameters);
        self.context = values[0];
        self.scratch = Some(values[1]);
        let workgroup = [values[2], values[3], values[4]];
        let scratch_bytes = self.workgroup_bytes;
        if scratch_bytes > MOST_WORKGROUP_BYTES {
            let limit = MOST_WORKGROUP_BYTES as u32;
            let bytes = scratch_bytes;
            return Err(ErrorKind::Stack { bytes, limit }.into());
        }
        let private = self.code.allocate(self.private_bytes);
        self.private = private.base;

        let index = self.code.variable(Type::I32);
        self.code.set(index, int(0));
        let (head, next, done) = (
            self.code.new_label(),
            self.code.new_label(),
            self.code.new_label(),
        );
        self.code.jump(head);
        self.code.known.clear();
        self.code.label(head);
        let local_index = self.code.get(index);
        self.initialize_private(info)?;
        let arguments = self.builtins(entry, workgroup, local_index)?;
        let exit = Exit::Jump {
            results: crate::ir::Variable(0),
            parts: Vec::new(),
            label: next,
            jumps: 0,
        };
        let in_memory = self.plan.entry_in_memory.clone();
        let mut frame = self.frame(&entry.function, info, &in_memory, arguments, exit)?;
        if self.block(&mut frame, &entry.function.body)? {
            self.code.jump(next);
        }
        self.code.known.clear();
        self.code.label(next);
        let threads: u32 = entry.workgroup_size.iter().product();
        let after = self.code.get(index);
        let after = self.code.binary(Binary::Add, after, int(1));
        self.code.set(index, after);
        let more = self
            .code
            .compare(Comparison::UnsignedLess, after, int(threads));
        self.code.branch(more, head, done);
        self.code.label(done);
        self.code.push(Instruction::Return);

        let function = &mut self.code.function;
        let waits = function
            .instructions
            .iter()
            .any(|i| matches!(i, Instruction::Barrier));
        if !waits {
            let invocations = Invocations { index, head, next };
            return Ok((scratch_bytes as u32, Some(invocations)));
        }
        let points = barrier::Points {
            scratch: values[1],
            frames_at: scratch_bytes as u32,
            threads,
            index,
            head,
            next,
            done,
        };
        Ok((barrier::split(function, &points)?, None))
    }

    /// Private variables start anew in each invocation.
    fn initialize_private(&mut self, info: &FunctionInfo) -> Result<(), CompileError> {
        let module = self.module;
        for (handle, variable) in module.global_variables.iter() {
            if variable.space != AddressSpace::Private || info[handle].is_empty() {
                continue;
            }
            if !self.plan.globals_in_memory.contains(&handle) {
                let parts = self.types.parts(variable.ty)?;
                let first = self.code.variables(&parts);
                self.globals
                    .insert(handle, GlobalPlace::Variables { first });
            }
            let expressions = &module.global_expressions;
            let zero = |init| matches!(expressions[init], naga::Expression::ZeroValue(_));
            let init = match variable.init.filter(|&init| !zero(init)) {
                Some(init) => Some(self.constant(init)?),
                None => None,
            };
            let place = self.global(handle)?;
            self.initialize(place, variable.ty, init)?;
        }
        Ok(())
    }

    fn builtins(
        &mut self,
        entry: &EntryPoint,
        workgroup: [Value; 3],
        local_index: Operand,
    ) -> Result<Vec<Evaluated>, CompileError> {
        let module = self.module;
        let mut arguments = Vec::new();
        for argument in &entry.function.arguments {
            let mut scalars = Vec::new();
            match (&argument.binding, &module.types[argument.ty].inner) {
                (Some(binding), _) => {
                    scalars.extend(self.builtin(entry, binding, workgroup, local_index)?);
                }
                (None, naga::TypeInner::Struct { members, .. }) => {
                    for member in members {
                        let binding = member.binding.as_ref().ok_or_else(unknown)?;
                        scalars.extend(self.builtin(entry, binding, workgroup, local_index)?);
                    }
                }
                _ => return Err(unknown()),
            }
            arguments.push(Evaluated::Scalars(scalars));
        }
        Ok(arguments)
    }

    fn builtin(
        &mut self,
        entry: &EntryPoint,
        binding: &naga::Binding,
        workgroup: [Value; 3],
        local_index: Operand,
    ) -> Result<Vec<Operand>, CompileError> {
        let naga::Binding::BuiltIn(builtin) = *binding else {
            return Err(unknown());
        };
        let workgroup = workgroup.map(Operand::Value);
        let size = entry.workgroup_size.map(int);
        Ok(match builtin {
            BuiltIn::WorkGroupId => workgroup.to_vec(),
            BuiltIn::WorkGroupSize => size.to_vec(),
            BuiltIn::NumWorkGroups => (0..3)
                .map(|axis| {
                    let place = self.context_place(context::WORKGROUPS + 4 * axis);
                    self.code.load(place, Type::I32)
                })
                .collect(),
            BuiltIn::LocalInvocationIndex => vec![local_index],
            BuiltIn::LocalInvocationId => self.local_id(entry, local_index),
            BuiltIn::GlobalInvocationId => {
                let local = self.local_id(entry, local_index);
                (0..3)
                    .map(|axis| {
                        let first = self
                            .code
                            .binary(Binary::Multiply, workgroup[axis], size[axis]);
                        self.code.binary(Binary::Add, first, local[axis])
                    })
                    .collect()
            }
            other => {
                return Err(ErrorKind::unsupported(format!("the built-in {other:?}")));
            }
        })
    }

    fn local_id(&mut self, entry: &EntryPoint, index: Operand) -> Vec<Operand> {
        let [width, height, depth] = entry.workgroup_size;
        let code = &mut self.code;
        if height == 1 && depth == 1 {
            return vec![index, int(0), int(0)];
        }
        let x = code.binary(Binary::UnsignedRemainder, index, int(width));
        let rows = code.binary(Binary::UnsignedDivide, index, int(width));
        let y = code.binary(Binary::UnsignedRemainder, rows, int(height));
        let z = code.binary(Binary::UnsignedDivide, rows, int(height));
        vec![x, y, z]
    }
}

fn unknown() -> CompileError {
    ErrorKind::unsupported("an argument of the entry point that is no built-in")
}
