//! Operations on numbers.

use cranelift_codegen::ir::{
    self, Endianness, InstBuilder, MemFlagsData,
    condcodes::{FloatCC, IntCC},
    types::{F32X4, F64X2, I32, I32X4, I64X2},
};
use cranelift_frontend::{FunctionBuilder, Variable as Held};
use kernel_ir::lanes::Kind;

use super::{
    super::function::{Condition, comparison},
    Lanes, Pair, Refused,
    memory::shuffle,
};
use crate::native::compile::ir::{Binary, Comparison, Instruction, Type, Unary, Value, Variable};

/// 2^52.
const DOUBLE: f64 = 4_503_599_627_370_496.0;

impl Lanes<'_> {
    pub(super) fn instruction(
        &mut self,
        block: usize,
        position: usize,
        instruction: &Instruction,
    ) -> Result<(), Refused> {
        if let Some(to) = instruction.result() {
            // Others may be loaded with one that nobody needs.
            let is_needed = self.analysis.homes.values[to.0 as usize].is_used
                || matches!(
                    instruction,
                    Instruction::Atomic { .. }
                        | Instruction::CompareExchange { .. }
                        | Instruction::CallRuntime { .. }
                )
                || self.groups.loads.contains_key(&position);
            if !is_needed {
                return Ok(());
            }
        }
        match *instruction {
            // These stand before all blocks.
            Instruction::Constant { .. }
            | Instruction::Words { .. }
            | Instruction::Parameter { .. }
            | Instruction::StackAddress { .. }
            | Instruction::Label(_) => Ok(()),
            Instruction::Set { variable, value } => {
                let Some(held) = self.variables[variable.0 as usize] else {
                    let value = self.one(value);
                    let held = self.scalar.variables[variable.0 as usize];
                    self.scalar.builder.def_var(held, value);
                    return Ok(());
                };
                let mut made = self.pair(value);
                if !self.analysis.is_free(block, variable) {
                    let before = held.map(|held| self.scalar.builder.use_var(held));
                    made = self.select(self.mask, made, before);
                }
                self.define(held, made);
                Ok(())
            }
            Instruction::Get { to, variable } => {
                if let (Some(first), Kind::Lanes) = (self.first, self.analysis.kinds[to.0 as usize])
                    && self.is_index(variable)
                {
                    let made = self.count_from(first);
                    self.make(to, made);
                    return Ok(());
                }
                match self.variables[variable.0 as usize] {
                    Some(held) => {
                        let made = held.map(|held| self.scalar.builder.use_var(held));
                        self.make(to, made);
                    }
                    None => {
                        let held = self.scalar.variables[variable.0 as usize];
                        let made = self.scalar.builder.use_var(held);
                        self.make_one(to, made);
                    }
                }
                Ok(())
            }
            Instruction::Call {
                callee,
                ref arguments,
            } => self.call(callee, arguments),
            Instruction::CallRuntime {
                to,
                function,
                ref arguments,
            } => match to {
                Some(to) if self.is_uniform(to) => self.as_scalar(instruction, to),
                Some(to) => self.call_numbers(to, function, arguments),
                None => self.call_memory(function, arguments),
            },
            // A word that all lanes read.
            Instruction::Load { to, .. } if self.is_uniform(to) => self.as_scalar(instruction, to),
            Instruction::Load { .. }
            | Instruction::Store { .. }
            | Instruction::Atomic { .. }
            | Instruction::CompareExchange { .. }
            | Instruction::Element { .. }
            | Instruction::Offset { .. } => self.memory(position, instruction),
            Instruction::Unary { to, .. }
            | Instruction::Binary { to, .. }
            | Instruction::Compare { to, .. }
            | Instruction::Select { to, .. }
                if self.is_uniform(to) =>
            {
                self.as_scalar(instruction, to)
            }
            Instruction::Unary { to, op, a } => {
                let a = self.pair(a);
                let made = self.unary(op, a);
                self.make(to, made);
                Ok(())
            }
            Instruction::Binary { to, op, a, b } => {
                let made = self.binary(op, a, b);
                self.make(to, made);
                Ok(())
            }
            Instruction::Compare { to, op, a, b } => {
                let (a, b) = (self.pair(a), self.pair(b));
                let made = self.compare(op, a, b);
                self.make(to, made);
                Ok(())
            }
            Instruction::Select {
                to,
                condition,
                accept,
                reject,
            } => {
                let condition = self.pair(condition);
                let (accept, reject) = (self.pair(accept), self.pair(reject));
                let made = self.select(condition, accept, reject);
                self.make(to, made);
                Ok(())
            }
            Instruction::Barrier
            | Instruction::Jump(_)
            | Instruction::Branch { .. }
            | Instruction::Switch { .. }
            | Instruction::Return => Err(Refused),
        }
    }

    fn is_index(&self, variable: Variable) -> bool {
        let invocations = self.from.program.invocations;
        invocations.is_some_and(|invocations| invocations.index == variable)
    }

    /// The numbers of the invocations that run.
    fn count_from(&mut self, first: Held) -> Pair {
        let first = self.scalar.builder.use_var(first);
        let first = self.splat(Type::I32, first);
        self.each(|builder, i| {
            let numbers = (0..4).flat_map(|lane| (lane + 4 * i as u32).to_le_bytes());
            let bytes: Vec<u8> = numbers.collect();
            let constant = builder.func.dfg.constants.insert(bytes.into());
            let numbers = builder.ins().vconst(I32X4, constant);
            builder.ins().iadd(first[i], numbers)
        })
    }

    /// What all lanes have in common is made once.
    pub(super) fn as_scalar(
        &mut self,
        instruction: &Instruction,
        to: Value,
    ) -> Result<(), Refused> {
        for value in instruction.clone().operands() {
            let value = *value;
            let one = self.one(value);
            self.scalar.values[value.0 as usize] = Some(one);
        }
        self.scalar.instruction(instruction);
        let made = self.scalar.values[to.0 as usize].ok_or(Refused)?;
        self.make_one(to, made);
        Ok(())
    }

    fn unary(&mut self, op: Unary, a: Pair) -> Pair {
        match op {
            Unary::FloatBits => self.bits(a),
            Unary::BitsToFloat => self.of_words(Type::F32, a),
            Unary::BoolToInt => self.words_of(Type::Bool, a),
            Unary::ReverseBits => self.each(|builder, i| reverse_bits(builder, a[i])),
            Unary::LeadingZeros | Unary::TrailingZeros | Unary::CountOnes => {
                self.lane_by_lane(a, a, |builder, a, _| match op {
                    Unary::LeadingZeros => builder.ins().clz(a),
                    Unary::TrailingZeros => builder.ins().ctz(a),
                    _ => builder.ins().popcnt(a),
                })
            }
            Unary::FloatToSigned => {
                self.each(|builder, i| builder.ins().fcvt_to_sint_sat(I32X4, a[i]))
            }
            Unary::FloatToUnsigned => {
                self.each(|builder, i| builder.ins().fcvt_to_uint_sat(I32X4, a[i]))
            }
            Unary::SignedToFloat => {
                self.each(|builder, i| builder.ins().fcvt_from_sint(F32X4, a[i]))
            }
            Unary::UnsignedToFloat => {
                self.each(|builder, i| builder.ins().fcvt_from_uint(F32X4, a[i]))
            }
            Unary::BoolNot => self.each(|builder, i| builder.ins().bnot(a[i])),
            // The same instructions do it to vectors.
            _ => a.map(|half| self.scalar.unary(op, half)),
        }
    }

    fn compare(&mut self, op: Comparison, a: Pair, b: Pair) -> Pair {
        self.each(|builder, i| match comparison(op) {
            Condition::Float(condition) => builder.ins().fcmp(condition, a[i], b[i]),
            Condition::Int(condition) => builder.ins().icmp(condition, a[i], b[i]),
        })
    }

    fn binary(&mut self, op: Binary, a: Value, b: Value) -> Pair {
        let is_shift = matches!(
            op,
            Binary::ShiftLeft | Binary::UnsignedShiftRight | Binary::SignedShiftRight
        );
        if is_shift && self.is_uniform(b) {
            let (a, b) = (self.pair(a), self.one(b));
            return self.each(|builder, i| match op {
                Binary::ShiftLeft => builder.ins().ishl(a[i], b),
                Binary::UnsignedShiftRight => builder.ins().ushr(a[i], b),
                _ => builder.ins().sshr(a[i], b),
            });
        }
        let (a, b) = (self.pair(a), self.pair(b));
        match op {
            Binary::ShiftLeft => self.lane_by_lane(a, b, |builder, a, b| builder.ins().ishl(a, b)),
            Binary::UnsignedShiftRight => {
                self.lane_by_lane(a, b, |builder, a, b| builder.ins().ushr(a, b))
            }
            Binary::SignedShiftRight => {
                self.lane_by_lane(a, b, |builder, a, b| builder.ins().sshr(a, b))
            }
            Binary::UnsignedDivide => self.unsigned_quotient(a, b),
            Binary::UnsignedRemainder => {
                let quotient = self.unsigned_quotient(a, b);
                self.each(|builder, i| {
                    let product = builder.ins().imul(quotient[i], b[i]);
                    builder.ins().isub(a[i], product)
                })
            }
            Binary::SignedDivide | Binary::SignedRemainder => self.signed_divide(op, a, b),
            Binary::FloatMin | Binary::FloatMax => {
                let less = self.each(|builder, i| match op {
                    Binary::FloatMin => builder.ins().fcmp(FloatCC::LessThan, a[i], b[i]),
                    _ => builder.ins().fcmp(FloatCC::LessThan, b[i], a[i]),
                });
                self.select(less, a, b)
            }
            // The same instructions do it to vectors.
            _ => [0, 1].map(|i| self.scalar.binary(op, a[i], b[i])),
        }
    }

    /// By doubles: no whole number of 32 bits is so near to another that their quotient would round to it.
    fn unsigned_quotient(&mut self, a: Pair, b: Pair) -> Pair {
        let flags = MemFlagsData::new().with_endianness(Endianness::Little);
        self.each(|builder, i| {
            // A double that 2^52 was added to has a whole number in its low bits.
            let large = builder.ins().f64const(DOUBLE);
            let large = builder.ins().splat(F64X2, large);
            let bits = builder.ins().bitcast(I64X2, flags, large);
            let mut doubles = |half: ir::Value, low: bool| {
                let wide = match low {
                    true => builder.ins().uwiden_low(half),
                    false => builder.ins().uwiden_high(half),
                };
                let sum = builder.ins().bor(wide, bits);
                let sum = builder.ins().bitcast(F64X2, flags, sum);
                builder.ins().fsub(sum, large)
            };
            let quotients = [true, false].map(|low| (doubles(a[i], low), doubles(b[i], low)));
            let [low, high] = quotients.map(|(a, b)| {
                let quotient = builder.ins().fdiv(a, b);
                let quotient = builder.ins().floor(quotient);
                let sum = builder.ins().fadd(quotient, large);
                builder.ins().bitcast(I32X4, flags, sum)
            });
            shuffle(builder, low, high, [0, 8, 16, 24])
        })
    }

    /// Division traps where the divisor is zero or the quotient doesn't fit, and lanes that don't run may have anything.
    fn signed_divide(&mut self, op: Binary, a: Pair, b: Pair) -> Pair {
        let (zero, one) = (self.words(0), self.words(1));
        let is_zero = self.each(|builder, i| builder.ins().icmp(IntCC::Equal, b[i], zero[i]));
        let runs = self.without(self.mask, is_zero);
        let a = self.and(a, runs);
        let b = self.select(runs, b, one);
        self.lane_by_lane(a, b, |builder, a, b| match op {
            Binary::SignedDivide => builder.ins().sdiv(a, b),
            _ => builder.ins().srem(a, b),
        })
    }

    /// What there is no instruction for that does it to vectors.
    fn lane_by_lane(
        &mut self,
        a: Pair,
        b: Pair,
        does: impl Fn(&mut FunctionBuilder<'_>, ir::Value, ir::Value) -> ir::Value,
    ) -> Pair {
        self.each(|builder, i| {
            let mut made = a[i];
            for lane in 0..4_u8 {
                let (x, y) = (
                    builder.ins().extractlane(a[i], lane),
                    builder.ins().extractlane(b[i], lane),
                );
                debug_assert_eq!(builder.func.dfg.value_type(x), I32);
                let one = does(builder, x, y);
                made = builder.ins().insertlane(made, one, lane);
            }
            made
        })
    }
}

/// Of each of four words, by changing places of neighbours: single bits, pairs, and so on.
fn reverse_bits(builder: &mut FunctionBuilder<'_>, words: ir::Value) -> ir::Value {
    let mut words = words;
    for (bits, mask) in [
        (1, 0x5555_5555_u32),
        (2, 0x3333_3333),
        (4, 0x0f0f_0f0f),
        (8, 0x00ff_00ff),
    ] {
        let mask = builder.ins().iconst(I32, i64::from(mask));
        let mask = builder.ins().splat(I32X4, mask);
        let high = builder.ins().ushr_imm_u(words, bits);
        let high = builder.ins().band(high, mask);
        let low = builder.ins().band(words, mask);
        let low = builder.ins().ishl_imm_u(low, bits);
        words = builder.ins().bor(high, low);
    }
    let high = builder.ins().ushr_imm_u(words, 16);
    let low = builder.ins().ishl_imm_u(words, 16);
    builder.ins().bor(high, low)
}
