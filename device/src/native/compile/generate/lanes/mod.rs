//! A function for eight invocations at once, as Cranelift's code: each value of the text is a vector of eight, in two halves of
//! four lanes, as wide as Cranelift's vectors are.
//!
//! [`kernel_ir::lanes`] tells which values all lanes have in common, which stay scalars, and which blocks all lanes run
//! together, whose jumps stay jumps. All other blocks run in the order of the text, each under the mask of the lanes that
//! wait for it. Each lane computes what the scalar code does, to the bit; only the order in which invocations meet in atomic
//! operations is another.
//!
//! A function that is called gets scalars that all lanes share and addresses as they are, and last the address of its *frame*:
//! eight words for each parameter that lanes have of their own, and the mask of the lanes that call it.

mod calls;
mod flow;
mod memory;
mod operations;

use std::sync::Arc;

use cranelift_codegen::{
    ir::{
        self, AbiParam, InstBuilder, MemFlagsData, Signature, StackSlot, StackSlotData,
        StackSlotKind, UserFuncName,
        types::{F32X4, I32, I32X4, I64},
    },
    isa::{CallConv, TargetIsa},
};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext, Variable as Held};
use kernel_ir::lanes::{Analysis, Groups, Kind, Passed, Planned};

use super::function::{Writer, type_of};
use crate::native::compile::ir::{Function, Instruction, Program, Type, Value};

/// Invocations that run at once.
pub(super) const LANES: u32 = 8;

/// Bytes of a vector.
const VECTOR: i64 = 4 * LANES as i64;

/// Both halves of a vector.
type Pair = [ir::Value; 2];

/// What is not as the plan has it: then there is no code in lanes.
pub(super) struct Refused;

/// A function of a program in lanes.
pub(super) struct InLanes<'a> {
    pub(super) program: &'a Program,
    /// How all of its functions get their parameters.
    pub(super) passed: &'a [Vec<Passed>],
    pub(super) planned: &'a Planned,
    /// Its place among the functions.
    pub(super) index: usize,
}

/// Writes a function; the words that its code points to.
pub(super) fn write(
    target: &mut ir::Function,
    from: &InLanes<'_>,
    isa: &dyn TargetIsa,
) -> Result<Vec<Arc<[u32]>>, Refused> {
    let convention = isa.default_call_conv();
    let passed = &from.passed[from.index];
    let parameters = &from.planned.function.parameters;
    let is_entry = from.index == 0;
    target.signature = match is_entry {
        true => scalar_signature(parameters, convention),
        false => signature(parameters, passed, convention),
    };
    target.name = UserFuncName::user(0, 0);
    let mut context = FunctionBuilderContext::new();
    let builder = FunctionBuilder::new(target, &mut context);
    let function = &from.planned.function;
    let bytes = LANES * function.stack_bytes + VECTOR as u32;
    let scalar = Writer::new(builder, from.program, function, convention, bytes);
    let mut writer = Lanes::new(scalar, from)?;
    writer.body()?;
    Ok(writer.scalar.finish(isa))
}

fn scalar_signature(parameters: &[Type], convention: CallConv) -> Signature {
    let mut signature = Signature::new(convention);
    let parameters = parameters.iter().map(|&ty| AbiParam::new(type_of(ty)));
    signature.params.extend(parameters);
    signature
}

/// Of a function that is called in lanes.
fn signature(parameters: &[Type], passed: &[Passed], convention: CallConv) -> Signature {
    let direct = (parameters.iter().zip(passed)).filter(|&(_, passed)| *passed != Passed::Lanes);
    let direct: Vec<Type> = direct.map(|(&ty, _)| ty).collect();
    let mut signature = scalar_signature(&direct, convention);
    signature.params.push(AbiParam::new(I64));
    signature
}

/// Accesses of vectors: no address traps, but not all are multiples of 16.
fn unaligned() -> MemFlagsData {
    MemFlagsData::new().with_notrap()
}

/// The type of a half.
fn half(ty: Type) -> ir::Type {
    match ty {
        Type::F32 => F32X4,
        Type::I32 | Type::Bool | Type::Pointer => I32X4,
    }
}

/// Where a value is that some path may leave out.
#[derive(Clone, Copy)]
enum Kept {
    Scalar(Held),
    Pair([Held; 2]),
}

struct Lanes<'a> {
    scalar: Writer<'a>,
    from: &'a InLanes<'a>,
    function: &'a Function,
    analysis: &'a Analysis,
    /// Words that are read and written together.
    groups: Groups,
    /// Of each value that lanes have of their own.
    vectors: Vec<Option<Pair>>,
    /// Of each value that isn't only used where it is made.
    kept: Vec<Option<Kept>>,
    /// Of each variable that lanes have of their own.
    variables: Vec<Option<[Held; 2]>>,
    /// Of each block that has a mask of its own.
    masks: Vec<Option<[Held; 2]>>,
    /// Of the lanes that the function is for, and of those that run now.
    all: Pair,
    mask: Pair,
    /// The first invocation of those that run, in an entry point.
    first: Option<Held>,
    /// Where blocks begin that all lanes run together.
    starts: Vec<Option<ir::Block>>,
    runs: Vec<flow::Run>,
    /// Where an invocation ends.
    end: ir::Block,
    /// Memory for what is handed over, to functions of the program and to others.
    handed: StackSlot,
}

impl<'a> Lanes<'a> {
    fn new(mut scalar: Writer<'a>, from: &'a InLanes<'a>) -> Result<Self, Refused> {
        let function = &from.planned.function;
        let analysis = &from.planned.analysis;
        let builder = &mut scalar.builder;
        let vectors = |builder: &mut FunctionBuilder<'_>, ty: Type| {
            [(); 2].map(|()| builder.declare_var(half(ty)))
        };
        let mut kept = vec![None; function.value_types.len()];
        for (value, home) in analysis.homes.values.iter().enumerate() {
            let ty = function.value_types[value];
            kept[value] = match analysis.kinds[value] {
                _ if !home.is_used || home.is_local => None,
                Kind::Uniform => Some(Kept::Scalar(builder.declare_var(type_of(ty)))),
                Kind::Lanes => Some(Kept::Pair(vectors(builder, ty))),
                Kind::Pointer(pointer) if pointer.varies => {
                    Some(Kept::Pair(vectors(builder, Type::I32)))
                }
                Kind::Pointer(_) => Some(Kept::Scalar(builder.declare_var(I64))),
            };
        }
        let variables = (function.variable_types.iter().zip(&analysis.uniform))
            .map(|(&ty, &uniform)| (!uniform).then(|| vectors(builder, ty)))
            .collect();
        let blocks = 0..analysis.flow.count();
        let masks = (blocks.clone())
            .map(|block| {
                let has_mask = analysis.roots[block] == block && !analysis.converged[block];
                has_mask.then(|| vectors(builder, Type::Bool))
            })
            .collect();
        let starts = blocks
            .map(|block| analysis.converged[block].then(|| builder.create_block()))
            .collect();
        let runs = flow::runs(analysis, builder)?;
        let end = builder.create_block();
        let rows = 6 + calls::most_rows(function, from);
        let slot = StackSlotData::new(StackSlotKind::ExplicitSlot, 32 * rows, 4);
        let handed = builder.create_sized_stack_slot(slot);
        let zero = builder.ins().iconst(I32, 0);
        let zero = builder.ins().splat(I32X4, zero);
        Ok(Self {
            function,
            analysis,
            groups: analysis.groups(function),
            vectors: vec![None; function.value_types.len()],
            kept,
            variables,
            masks,
            all: [zero; 2],
            mask: [zero; 2],
            first: None,
            starts,
            runs,
            end,
            handed,
            from,
            scalar,
        })
    }

    fn ty(&self, value: Value) -> Type {
        self.function.value_types[value.0 as usize]
    }

    fn is_uniform(&self, value: Value) -> bool {
        self.analysis.is_uniform(value)
    }

    /// A value that is the same in all lanes, or the address of what they share.
    fn one(&mut self, value: Value) -> ir::Value {
        if let Some(Kept::Scalar(held)) = self.kept[value.0 as usize] {
            return self.scalar.builder.use_var(held);
        }
        self.scalar.values[value.0 as usize].expect("values are made before they are used")
    }

    /// A value as a vector: of an address that varies, the bytes behind the one that it counts from.
    fn pair(&mut self, value: Value) -> Pair {
        if self.is_uniform(value) {
            let (one, ty) = (self.one(value), self.ty(value));
            return self.splat(ty, one);
        }
        if let Some(Kept::Pair(held)) = self.kept[value.0 as usize] {
            return held.map(|held| self.scalar.builder.use_var(held));
        }
        self.vectors[value.0 as usize].expect("values are made before they are used")
    }

    fn splat(&mut self, ty: Type, one: ir::Value) -> Pair {
        let builder = &mut self.scalar.builder;
        let one = match ty {
            Type::Bool => {
                let word = builder.ins().uextend(I32, one);
                builder.ins().ineg(word)
            }
            _ => one,
        };
        [builder.ins().splat(half(ty), one); 2]
    }

    fn words(&mut self, word: u32) -> Pair {
        let one = self.scalar.builder.ins().iconst(I32, i64::from(word));
        self.splat(Type::I32, one)
    }

    fn make_one(&mut self, to: Value, made: ir::Value) {
        self.scalar.values[to.0 as usize] = Some(made);
        if let Some(Kept::Scalar(held)) = self.kept[to.0 as usize] {
            self.scalar.builder.def_var(held, made);
        }
    }

    fn make(&mut self, to: Value, made: Pair) {
        let Some(Kept::Pair(held)) = self.kept[to.0 as usize] else {
            self.vectors[to.0 as usize] = Some(made);
            return;
        };
        let home = self.analysis.homes.values[to.0 as usize];
        let made = match home.outlives {
            true => {
                let before = held.map(|held| self.scalar.builder.use_var(held));
                self.select(self.mask, made, before)
            }
            false => made,
        };
        self.define(held, made);
    }

    fn define(&mut self, held: [Held; 2], pair: Pair) {
        for (held, half) in held.into_iter().zip(pair) {
            self.scalar.builder.def_var(held, half);
        }
    }

    /// `a` where the mask is set, else `b`.
    fn select(&mut self, mask: Pair, a: Pair, b: Pair) -> Pair {
        let builder = &mut self.scalar.builder;
        [0, 1].map(|i| {
            let ty = builder.func.dfg.value_type(a[i]);
            let mask = match ty == I32X4 {
                true => mask[i],
                false => builder.ins().bitcast(ty, MemFlagsData::new(), mask[i]),
            };
            builder.ins().bitselect(mask, a[i], b[i])
        })
    }

    /// Something done to each half.
    fn each(&mut self, mut does: impl FnMut(&mut FunctionBuilder<'a>, usize) -> ir::Value) -> Pair {
        [0, 1].map(|half| does(&mut self.scalar.builder, half))
    }

    fn bits(&mut self, pair: Pair) -> Pair {
        self.each(|builder, i| match builder.func.dfg.value_type(pair[i]) {
            I32X4 => pair[i],
            _ => builder.ins().bitcast(I32X4, MemFlagsData::new(), pair[i]),
        })
    }

    /// A vector of a type, from words.
    fn of_words(&mut self, ty: Type, words: Pair) -> Pair {
        match ty {
            Type::F32 => {
                self.each(|builder, i| builder.ins().bitcast(F32X4, MemFlagsData::new(), words[i]))
            }
            Type::Bool => {
                let zero = self.words(0);
                let not_equal = ir::condcodes::IntCC::NotEqual;
                self.each(|builder, i| builder.ins().icmp(not_equal, words[i], zero[i]))
            }
            Type::I32 | Type::Pointer => words,
        }
    }

    /// The words of a vector of a type.
    fn words_of(&mut self, ty: Type, vector: Pair) -> Pair {
        match ty {
            Type::F32 => self.bits(vector),
            Type::Bool => self.each(|builder, i| builder.ins().ushr_imm_u(vector[i], 31)),
            Type::I32 | Type::Pointer => vector,
        }
    }

    /// Whether any lane of a mask is set: not zero.
    fn any(&mut self, mask: Pair) -> ir::Value {
        let builder = &mut self.scalar.builder;
        let both = builder.ins().bor(mask[0], mask[1]);
        builder.ins().vany_true(both)
    }

    fn and(&mut self, a: Pair, b: Pair) -> Pair {
        self.each(|builder, i| builder.ins().band(a[i], b[i]))
    }

    fn without(&mut self, a: Pair, b: Pair) -> Pair {
        self.each(|builder, i| builder.ins().band_not(a[i], b[i]))
    }

    /// What stands before all blocks: parameters, and what never changes.
    fn prologue(&mut self) -> Result<(), Refused> {
        let parameters = self.scalar.builder.block_params(self.scalar.first).to_vec();
        let passed = &self.from.passed[self.from.index];
        let frame = (self.from.index != 0).then(|| parameters[parameters.len() - 1]);
        let mut rows = 0;
        let mut direct = parameters.into_iter();
        let mut places = Vec::new();
        for &passed in passed {
            places.push(match passed {
                Passed::Lanes => {
                    rows += 1;
                    Err(rows - 1)
                }
                _ => Ok(direct.next().ok_or(Refused)?),
            });
        }
        self.all = match frame {
            Some(frame) => self.load_row(frame, 32 * rows),
            None => self.words(u32::MAX),
        };
        self.mask = self.all;
        // Functions that were compiled ahead access whole vectors of it, at multiples of their size.
        let stack = self.scalar.stack;
        let builder = &mut self.scalar.builder;
        let own = builder.ins().stack_addr(I64, stack, 0);
        let own = builder.ins().iadd_imm_s(own, VECTOR - 1);
        let own = builder.ins().band_imm_s(own, -VECTOR);
        let instructions = &self.function.instructions;
        for instruction in instructions {
            match *instruction {
                Instruction::Constant { to, .. } | Instruction::Words { to, .. } => {
                    self.scalar.instruction(instruction);
                    self.kept[to.0 as usize] = None;
                }
                Instruction::Parameter { to, index } => {
                    self.kept[to.0 as usize] = None;
                    match (places[index as usize], frame) {
                        (Ok(value), _) => self.scalar.values[to.0 as usize] = Some(value),
                        (Err(row), Some(frame)) => {
                            let words = self.load_row(frame, 32 * row);
                            let made = match self.ty(to) {
                                // A mask as it is.
                                Type::Bool => words,
                                ty => self.of_words(ty, words),
                            };
                            self.vectors[to.0 as usize] = Some(made);
                        }
                        _ => return Err(Refused),
                    }
                }
                Instruction::StackAddress { to, offset } => {
                    let offset = i64::from(LANES * offset);
                    let made = self.scalar.builder.ins().iadd_imm_s(own, offset);
                    self.scalar.values[to.0 as usize] = Some(made);
                    self.kept[to.0 as usize] = None;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Eight words that lie together.
    fn load_row(&mut self, base: ir::Value, offset: i32) -> Pair {
        self.each(|builder, i| {
            builder
                .ins()
                .load(I32X4, unaligned(), base, offset + 16 * i as i32)
        })
    }

    fn store_row(&mut self, base: ir::Value, offset: i32, words: Pair) {
        for (i, half) in (0..).zip(words) {
            self.scalar
                .builder
                .ins()
                .store(unaligned(), half, base, offset + 16 * i);
        }
    }
}
