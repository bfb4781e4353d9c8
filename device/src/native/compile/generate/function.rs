//! One function as Cranelift's code.

use std::sync::Arc;

use cranelift_codegen::{
    ir::{
        self, AbiParam, AtomicRmwOp, ExtFuncData, ExternalName, FuncRef, InstBuilder, MemFlagsData,
        SigRef, Signature, StackSlot, StackSlotData, StackSlotKind, UserExternalName, UserFuncName,
        condcodes::{FloatCC, IntCC},
        immediates::Ieee32,
        types::{F32, I8, I32, I64},
    },
    isa::{CallConv, TargetIsa},
};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext, Switch};

use crate::native::compile::{
    ir::{
        AtomicOperation, Binary, Comparison, Function, Instruction, Memory, Program, Runtime, Type,
        Unary, Value,
    },
    runtime::{self, Kind},
};

pub(super) fn type_of(ty: Type) -> ir::Type {
    match ty {
        Type::F32 => F32,
        Type::I32 => I32,
        Type::Bool => I8,
        Type::Pointer => I64,
    }
}

fn signature(function: &Function, convention: CallConv) -> Signature {
    let mut signature = Signature::new(convention);
    let parameters = function.parameters.iter();
    signature
        .params
        .extend(parameters.map(|&ty| AbiParam::new(type_of(ty))));
    signature
}

/// Writes a function; the words that its code points to.
pub(super) fn write(
    target: &mut ir::Function,
    program: &Program,
    function: &Function,
    isa: &dyn TargetIsa,
) -> Vec<Arc<[u32]>> {
    let convention = isa.default_call_conv();
    target.signature = signature(function, convention);
    target.name = UserFuncName::user(0, 0);
    let mut context = FunctionBuilderContext::new();
    let builder = FunctionBuilder::new(target, &mut context);
    let bytes = function.stack_bytes.max(4);
    let mut writer = Writer::new(builder, program, function, convention, bytes);
    for instruction in &function.instructions {
        writer.instruction(instruction);
    }
    writer.finish(isa)
}

pub(super) struct Writer<'a> {
    pub(super) builder: FunctionBuilder<'a>,
    program: &'a Program,
    function: &'a Function,
    pub(super) convention: CallConv,
    pub(super) first: ir::Block,
    pub(super) variables: Vec<cranelift_frontend::Variable>,
    blocks: Vec<ir::Block>,
    pub(super) stack: StackSlot,
    pub(super) values: Vec<Option<ir::Value>>,
    callees: Vec<Option<FuncRef>>,
    runtime: Vec<(Runtime, SigRef)>,
    words: Vec<Arc<[u32]>>,
}

impl<'a> Writer<'a> {
    /// Begins a function whose signature is there, with so much memory of its own.
    pub(super) fn new(
        mut builder: FunctionBuilder<'a>,
        program: &'a Program,
        function: &'a Function,
        convention: CallConv,
        stack_bytes: u32,
    ) -> Self {
        let first = builder.create_block();
        builder.append_block_params_for_function_params(first);
        builder.switch_to_block(first);
        let variables = function.variable_types.iter();
        let variables = variables
            .map(|&ty| builder.declare_var(type_of(ty)))
            .collect();
        let blocks = (0..function.labels)
            .map(|_| builder.create_block())
            .collect();
        let slot = StackSlotData::new(StackSlotKind::ExplicitSlot, stack_bytes, 4);
        Self {
            stack: builder.create_sized_stack_slot(slot),
            callees: vec![None; function.callees.len()],
            runtime: Vec::new(),
            values: vec![None; function.value_types.len()],
            words: Vec::new(),
            first,
            variables,
            blocks,
            program,
            function,
            convention,
            builder,
        }
    }

    /// Ends the function; the words that its code points to.
    pub(super) fn finish(self, isa: &dyn TargetIsa) -> Vec<Arc<[u32]>> {
        let Self {
            mut builder, words, ..
        } = self;
        builder.seal_all_blocks();
        builder.finalize(isa.frontend_config());
        words
    }

    fn value(&self, value: Value) -> ir::Value {
        self.values[value.0 as usize].expect("values are made before they are used")
    }

    fn made(&mut self, value: Value, made: ir::Value) {
        self.values[value.0 as usize] = Some(made);
    }

    pub(super) fn instruction(&mut self, instruction: &Instruction) {
        match *instruction {
            Instruction::Constant { to, ty, bits } => {
                let made = match ty {
                    Type::F32 => self.builder.ins().f32const(Ieee32::with_bits(bits)),
                    ty => self.builder.ins().iconst(type_of(ty), i64::from(bits)),
                };
                self.made(to, made);
            }
            Instruction::Words { to, ref words } => {
                let made = self.builder.ins().iconst(I64, words.as_ptr() as i64);
                self.words.push(words.clone());
                self.made(to, made);
            }
            Instruction::Parameter { to, index } => {
                let made = self.builder.block_params(self.first)[index as usize];
                self.made(to, made);
            }
            Instruction::StackAddress { to, offset } => {
                let stack = self.stack;
                let made = self.builder.ins().stack_addr(I64, stack, offset as i32);
                self.made(to, made);
            }
            Instruction::Unary { to, op, a } => {
                let a = self.value(a);
                let made = self.unary(op, a);
                self.made(to, made);
            }
            Instruction::Binary { to, op, a, b } => {
                let (a, b) = (self.value(a), self.value(b));
                let made = self.binary(op, a, b);
                self.made(to, made);
            }
            Instruction::Compare { to, op, a, b } => {
                let (a, b) = (self.value(a), self.value(b));
                let made = match comparison(op) {
                    Condition::Float(condition) => self.builder.ins().fcmp(condition, a, b),
                    Condition::Int(condition) => self.builder.ins().icmp(condition, a, b),
                };
                self.made(to, made);
            }
            Instruction::Select {
                to,
                condition,
                accept,
                reject,
            } => {
                let condition = self.value(condition);
                let (accept, reject) = (self.value(accept), self.value(reject));
                let made = self.builder.ins().select(condition, accept, reject);
                self.made(to, made);
            }
            Instruction::Get { to, variable } => {
                let variable = self.variables[variable.0 as usize];
                let made = self.builder.use_var(variable);
                self.made(to, made);
            }
            Instruction::Set { variable, value } => {
                let value = self.value(value);
                let variable = self.variables[variable.0 as usize];
                self.builder.def_var(variable, value);
            }
            Instruction::CallRuntime {
                to,
                function,
                ref arguments,
            } => self.call_runtime(to, function, arguments),
            Instruction::Call {
                callee,
                ref arguments,
            } => {
                let callee = self.callee(callee);
                let arguments: Vec<_> = arguments.iter().map(|&a| self.value(a)).collect();
                self.builder.ins().call(callee, &arguments);
            }
            // Lowering has replaced them.
            Instruction::Barrier => {}
            Instruction::Label(label) => {
                self.builder.switch_to_block(self.blocks[label.0 as usize]);
            }
            Instruction::Jump(label) => {
                let block = self.blocks[label.0 as usize];
                self.builder.ins().jump(block, &[]);
            }
            Instruction::Branch {
                condition,
                accept,
                reject,
            } => {
                let condition = self.value(condition);
                let accept = self.blocks[accept.0 as usize];
                let reject = self.blocks[reject.0 as usize];
                self.builder.ins().brif(condition, accept, &[], reject, &[]);
            }
            Instruction::Switch {
                selector,
                ref cases,
                default,
            } => {
                let selector = self.value(selector);
                let mut switch = Switch::new();
                for &(value, label) in cases {
                    switch.set_entry(u128::from(value), self.blocks[label.0 as usize]);
                }
                let default = self.blocks[default.0 as usize];
                switch.emit(&mut self.builder, selector, default);
            }
            Instruction::Return => {
                self.builder.ins().return_(&[]);
            }
            Instruction::Load { .. }
            | Instruction::Store { .. }
            | Instruction::Atomic { .. }
            | Instruction::CompareExchange { .. }
            | Instruction::Element { .. }
            | Instruction::Offset { .. } => self.memory(instruction),
        }
    }

    fn memory(&mut self, instruction: &Instruction) {
        match *instruction {
            Instruction::Load {
                to,
                ty,
                base,
                offset,
                memory,
            } => {
                let base = self.value(base);
                let word = if ty == Type::Bool { I32 } else { type_of(ty) };
                let loaded = match memory {
                    Memory::Atomic => {
                        let place = self.builder.ins().iadd_imm_s(base, i64::from(offset));
                        self.builder
                            .ins()
                            .atomic_load(word, MemFlagsData::trusted(), place)
                    }
                    _ => self.builder.ins().load(word, flags(memory), base, offset),
                };
                let made = match ty {
                    Type::Bool => self.builder.ins().ireduce(I8, loaded),
                    _ => loaded,
                };
                self.made(to, made);
            }
            Instruction::Store {
                base,
                offset,
                value,
                ty,
                memory,
            } => {
                let (base, value) = (self.value(base), self.value(value));
                let word = match ty {
                    Type::Bool => self.builder.ins().uextend(I32, value),
                    _ => value,
                };
                self.builder.ins().store(flags(memory), word, base, offset);
            }
            Instruction::Atomic {
                to,
                op,
                base,
                offset,
                value,
            } => {
                let (base, value) = (self.value(base), self.value(value));
                let place = self.builder.ins().iadd_imm_s(base, i64::from(offset));
                let op = atomic(op);
                let flags = MemFlagsData::trusted();
                let made = self.builder.ins().atomic_rmw(I32, flags, op, place, value);
                self.made(to, made);
            }
            Instruction::CompareExchange {
                to,
                base,
                offset,
                expected,
                value,
            } => {
                let base = self.value(base);
                let (expected, value) = (self.value(expected), self.value(value));
                let place = self.builder.ins().iadd_imm_s(base, i64::from(offset));
                let flags = MemFlagsData::trusted();
                let made = self.builder.ins().atomic_cas(flags, place, expected, value);
                self.made(to, made);
            }
            Instruction::Element {
                to,
                base,
                index,
                stride,
            } => {
                let (base, index) = (self.value(base), self.value(index));
                let index = self.builder.ins().uextend(I64, index);
                let bytes = self.builder.ins().imul_imm_s(index, i64::from(stride));
                let made = self.builder.ins().iadd(base, bytes);
                self.made(to, made);
            }
            Instruction::Offset { to, base, bytes } => {
                let base = self.value(base);
                let made = self.builder.ins().iadd_imm_s(base, i64::from(bytes));
                self.made(to, made);
            }
            _ => {}
        }
    }

    fn callee(&mut self, index: u32) -> FuncRef {
        let callee = &self.program.functions[self.function.callees[index as usize]];
        let signature = signature(callee, self.convention);
        self.imported(index, signature)
    }

    /// The function in this place among the callees.
    pub(super) fn imported(&mut self, index: u32, signature: Signature) -> FuncRef {
        if let Some(known) = self.callees[index as usize] {
            return known;
        }
        let signature = self.builder.import_signature(signature);
        let name = UserExternalName {
            namespace: 0,
            index,
        };
        let name = self.builder.func.declare_imported_user_function(name);
        let imported = self.builder.import_function(ExtFuncData {
            name: ExternalName::user(name),
            signature,
            colocated: false,
            patchable: false,
        });
        self.callees[index as usize] = Some(imported);
        imported
    }

    fn call_runtime(&mut self, to: Option<Value>, function: Runtime, arguments: &[Value]) {
        let called = runtime::signature(function);
        let kind = |kind| {
            AbiParam::new(match kind {
                Kind::F32 => F32,
                Kind::I32 => I32,
                Kind::Pointer => I64,
            })
        };
        let known = self.runtime.iter().find(|(known, _)| *known == function);
        let signature = match known {
            Some((_, signature)) => *signature,
            None => {
                let mut signature = Signature::new(self.convention);
                let parameters = called.parameters.iter();
                signature.params.extend(parameters.map(|&p| kind(p)));
                signature.returns.extend(called.result.map(kind));
                let signature = self.builder.import_signature(signature);
                self.runtime.push((function, signature));
                signature
            }
        };
        let address = self.builder.ins().iconst(I64, called.address as i64);
        let arguments: Vec<_> = arguments.iter().map(|&a| self.value(a)).collect();
        let call = self
            .builder
            .ins()
            .call_indirect(signature, address, &arguments);
        if let Some(to) = to {
            let made = self.builder.inst_results(call)[0];
            self.made(to, made);
        }
    }

    pub(super) fn unary(&mut self, op: Unary, a: ir::Value) -> ir::Value {
        let ins = self.builder.ins();
        match op {
            Unary::FloatNegate => ins.fneg(a),
            Unary::FloatAbs => ins.fabs(a),
            Unary::Sqrt => ins.sqrt(a),
            Unary::Floor => ins.floor(a),
            Unary::Ceil => ins.ceil(a),
            Unary::Truncate => ins.trunc(a),
            Unary::Nearest => ins.nearest(a),
            Unary::FloatToSigned => ins.fcvt_to_sint_sat(I32, a),
            Unary::FloatToUnsigned => {
                // By way of 64 bits with sign: shorter than the conversion without. What is too large has been restricted.
                let zero = ins.f32const(0.0);
                let above = self.builder.ins().fcmp(FloatCC::GreaterThan, a, zero);
                let a = self.builder.ins().select(above, a, zero);
                let wide = self.builder.ins().fcvt_to_sint_sat(I64, a);
                self.builder.ins().ireduce(I32, wide)
            }
            Unary::SignedToFloat => ins.fcvt_from_sint(F32, a),
            Unary::UnsignedToFloat => ins.fcvt_from_uint(F32, a),
            Unary::FloatBits => ins.bitcast(I32, MemFlagsData::new(), a),
            Unary::BitsToFloat => ins.bitcast(F32, MemFlagsData::new(), a),
            Unary::IntNegate => ins.ineg(a),
            Unary::IntNot => ins.bnot(a),
            Unary::BoolNot => ins.bxor_imm_u(a, 1),
            Unary::BoolToInt => ins.uextend(I32, a),
            Unary::LeadingZeros => ins.clz(a),
            Unary::TrailingZeros => ins.ctz(a),
            Unary::CountOnes => ins.popcnt(a),
            Unary::ReverseBits => ins.bitrev(a),
        }
    }

    pub(super) fn binary(&mut self, op: Binary, a: ir::Value, b: ir::Value) -> ir::Value {
        let ins = self.builder.ins();
        match op {
            Binary::FloatAdd => ins.fadd(a, b),
            Binary::FloatSubtract => ins.fsub(a, b),
            Binary::FloatMultiply => ins.fmul(a, b),
            Binary::FloatDivide => ins.fdiv(a, b),
            // One instruction, where the own minimum of floats takes five for what isn't a number.
            Binary::FloatMin => {
                let less = ins.fcmp(FloatCC::LessThan, a, b);
                self.builder.ins().select(less, a, b)
            }
            Binary::FloatMax => {
                let less = ins.fcmp(FloatCC::LessThan, b, a);
                self.builder.ins().select(less, a, b)
            }
            Binary::Add => ins.iadd(a, b),
            Binary::Subtract => ins.isub(a, b),
            Binary::Multiply => ins.imul(a, b),
            Binary::UnsignedDivide => ins.udiv(a, b),
            Binary::SignedDivide => ins.sdiv(a, b),
            Binary::UnsignedRemainder => ins.urem(a, b),
            Binary::SignedRemainder => ins.srem(a, b),
            Binary::And | Binary::BoolAnd => ins.band(a, b),
            Binary::Or | Binary::BoolOr => ins.bor(a, b),
            Binary::Xor | Binary::BoolXor => ins.bxor(a, b),
            Binary::ShiftLeft => ins.ishl(a, b),
            Binary::UnsignedShiftRight => ins.ushr(a, b),
            Binary::SignedShiftRight => ins.sshr(a, b),
            Binary::UnsignedMin => ins.umin(a, b),
            Binary::UnsignedMax => ins.umax(a, b),
            Binary::SignedMin => ins.smin(a, b),
            Binary::SignedMax => ins.smax(a, b),
        }
    }
}

/// No access traps and all are aligned: addresses were restricted when the code was lowered.
fn flags(memory: Memory) -> MemFlagsData {
    let flags = MemFlagsData::trusted();
    match memory {
        Memory::Constant => flags.with_readonly().with_can_move(),
        Memory::Plain | Memory::Atomic => flags,
    }
}

fn atomic(op: AtomicOperation) -> AtomicRmwOp {
    match op {
        AtomicOperation::Add => AtomicRmwOp::Add,
        AtomicOperation::Subtract => AtomicRmwOp::Sub,
        AtomicOperation::And => AtomicRmwOp::And,
        AtomicOperation::Or => AtomicRmwOp::Or,
        AtomicOperation::Xor => AtomicRmwOp::Xor,
        AtomicOperation::UnsignedMin => AtomicRmwOp::Umin,
        AtomicOperation::UnsignedMax => AtomicRmwOp::Umax,
        AtomicOperation::SignedMin => AtomicRmwOp::Smin,
        AtomicOperation::SignedMax => AtomicRmwOp::Smax,
        AtomicOperation::Exchange => AtomicRmwOp::Xchg,
    }
}

pub(super) enum Condition {
    Float(FloatCC),
    Int(IntCC),
}

pub(super) fn comparison(op: Comparison) -> Condition {
    match op {
        Comparison::FloatEqual => Condition::Float(FloatCC::Equal),
        Comparison::FloatNotEqual => Condition::Float(FloatCC::NotEqual),
        Comparison::FloatLess => Condition::Float(FloatCC::LessThan),
        Comparison::FloatLessEqual => Condition::Float(FloatCC::LessThanOrEqual),
        Comparison::FloatGreater => Condition::Float(FloatCC::GreaterThan),
        Comparison::FloatGreaterEqual => Condition::Float(FloatCC::GreaterThanOrEqual),
        Comparison::Equal => Condition::Int(IntCC::Equal),
        Comparison::NotEqual => Condition::Int(IntCC::NotEqual),
        Comparison::UnsignedLess => Condition::Int(IntCC::UnsignedLessThan),
        Comparison::UnsignedLessEqual => Condition::Int(IntCC::UnsignedLessThanOrEqual),
        Comparison::UnsignedGreater => Condition::Int(IntCC::UnsignedGreaterThan),
        Comparison::UnsignedGreaterEqual => Condition::Int(IntCC::UnsignedGreaterThanOrEqual),
        Comparison::SignedLess => Condition::Int(IntCC::SignedLessThan),
        Comparison::SignedLessEqual => Condition::Int(IntCC::SignedLessThanOrEqual),
        Comparison::SignedGreater => Condition::Int(IntCC::SignedGreaterThan),
        Comparison::SignedGreaterEqual => Condition::Int(IntCC::SignedGreaterThanOrEqual),
    }
}
