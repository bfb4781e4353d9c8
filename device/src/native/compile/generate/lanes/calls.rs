//! Calls: of the text's functions, of the program's, and of what does to lanes what there are no instructions for.

use cranelift_codegen::ir::{
    self, AbiParam, InstBuilder, Signature,
    condcodes::IntCC,
    types::{I32, I64},
};
use kernel_ir::lanes::{Kind, Passed};

use super::{InLanes, Lanes, Pair, Refused, signature};
use crate::native::compile::{
    ir::{AtomicOperation, Function, Instruction, Runtime, Type, Value},
    runtime::{self, lanes as helpers},
};

/// Functions that do something to each lane that runs: (address, rows of eight words, of which the last is the mask).
#[derive(Debug, Clone, Copy)]
pub(super) enum Helper {
    Scatter,
    ScatterFour,
    ScatterAtomic,
    CompareExchange,
    LoadTexel,
    Atomic(AtomicOperation),
}

impl Helper {
    fn address(self) -> helpers::Helper {
        match self {
            Self::Scatter => helpers::scatter,
            Self::ScatterFour => helpers::scatter_four,
            Self::ScatterAtomic => helpers::scatter_atomic,
            Self::CompareExchange => helpers::compare_exchange,
            Self::LoadTexel => helpers::load_texel,
            Self::Atomic(op) => helpers::atomic(op),
        }
    }
}

/// The most rows that any function which is called wants.
pub(super) fn most_rows(function: &Function, from: &InLanes<'_>) -> u32 {
    let callees = function.instructions.iter().filter_map(|i| match i {
        Instruction::Call { callee, .. } => Some(function.callees[*callee as usize]),
        _ => None,
    });
    let rows = callees.map(|callee| {
        let passed = from.passed[callee].iter();
        1 + passed.filter(|&&passed| passed == Passed::Lanes).count() as u32
    });
    rows.max().unwrap_or(0)
}

impl Lanes<'_> {
    fn handed_address(&mut self) -> ir::Value {
        let slot = self.handed;
        self.scalar.builder.ins().stack_addr(I64, slot, 0)
    }

    /// A row of what a function has left.
    pub(super) fn handed_row(&mut self, row: i32) -> Pair {
        let base = self.handed_address();
        self.load_row(base, 32 * row)
    }

    fn call_address(
        &mut self,
        address: *const u8,
        parameters: &[ir::Type],
        arguments: &[ir::Value],
    ) {
        let mut signature = Signature::new(self.scalar.convention);
        let parameters = parameters.iter().map(|&ty| AbiParam::new(ty));
        signature.params.extend(parameters);
        let builder = &mut self.scalar.builder;
        let signature = builder.import_signature(signature);
        let address = builder.ins().iconst(I64, address as i64);
        builder.ins().call_indirect(signature, address, arguments);
    }

    /// Calls a helper with rows, behind which the mask is put.
    pub(super) fn help(&mut self, helper: Helper, place: ir::Value, rows: &[Pair]) {
        let frame = self.handed_address();
        for (row, &words) in (0..).zip(rows) {
            self.store_row(frame, 32 * row, words);
        }
        let mask = self.mask;
        self.store_row(frame, 32 * rows.len() as i32, mask);
        self.call_address(helper.address() as *const u8, &[I64, I64], &[place, frame]);
    }

    /// A function of numbers.
    pub(super) fn call_numbers(
        &mut self,
        to: Value,
        function: Runtime,
        arguments: &[Value],
    ) -> Result<(), Refused> {
        let Some(helper) = helpers::numbers(function) else {
            return Err(Refused);
        };
        let frame = self.handed_address();
        for row in 0..2 {
            let value = arguments[(row as usize).min(arguments.len() - 1)];
            let (ty, words) = (self.ty(value), self.pair(value));
            let words = self.words_of(ty, words);
            self.store_row(frame, 32 * row, words);
        }
        let mask = self.mask;
        self.store_row(frame, 64, mask);
        let does = runtime::signature(function).address;
        let does = self.scalar.builder.ins().iconst(I64, does as i64);
        self.call_address(helper as *const u8, &[I64, I64], &[does, frame]);
        let words = self.handed_row(0);
        let made = self.of_words(self.ty(to), words);
        self.make(to, made);
        Ok(())
    }

    /// A function that works on memory.
    pub(super) fn call_memory(
        &mut self,
        function: Runtime,
        arguments: &[Value],
    ) -> Result<(), Refused> {
        let kinds = &self.analysis.kinds;
        let is_one = |value: Value, own: bool| match kinds[value.0 as usize] {
            Kind::Pointer(pointer) => pointer.is_own == own && !pointer.varies,
            _ => false,
        };
        match (function, arguments) {
            (Runtime::LoadTexel, &[header, texel, target])
                if is_one(header, false) && is_one(target, true) =>
            {
                let (header, texel) = (self.one(header), self.pair(texel));
                self.help(Helper::LoadTexel, header, &[texel]);
                let target = self.one(target);
                for word in 0..4 {
                    let words = self.handed_row(word);
                    self.own_store(target, 32 * word, words);
                }
                Ok(())
            }
            (Runtime::Zero, &[target, bytes]) if is_one(target, true) && self.is_uniform(bytes) => {
                let (target, bytes) = (self.one(target), self.one(bytes));
                self.own_call(helpers::own_zero as *const u8, target, None, bytes);
                Ok(())
            }
            (Runtime::Copy, &[target, source, bytes])
                if is_one(target, true) && is_one(source, false) && self.is_uniform(bytes) =>
            {
                let (target, source) = (self.one(target), self.one(source));
                let bytes = self.one(bytes);
                self.own_call(helpers::own_copy as *const u8, target, Some(source), bytes);
                Ok(())
            }
            (Runtime::Host, &[bound, taken, taken_words, given, given_words])
                if is_one(bound, false) && is_one(taken, true) && is_one(given, true) =>
            {
                let words = [taken_words, given_words].map(|words| self.constant(words));
                if !words
                    .iter()
                    .all(|words| words.is_some_and(|words| words <= helpers::MOST_HOST_WORDS))
                {
                    return Err(Refused);
                }
                let frame = self.handed_address();
                let mask = self.mask;
                self.store_row(frame, 0, mask);
                let mut arguments: Vec<ir::Value> =
                    arguments.iter().map(|&a| self.one(a)).collect();
                arguments.push(frame);
                let parameters = [I64, I64, I32, I64, I32, I64];
                self.call_address(helpers::host as *const u8, &parameters, &arguments);
                Ok(())
            }
            _ => Err(Refused),
        }
    }

    /// What a constant is.
    fn constant(&self, value: Value) -> Option<u32> {
        let mut instructions = self.function.instructions.iter();
        instructions.find_map(|instruction| match *instruction {
            Instruction::Constant { to, bits, .. } if to == value => Some(bits),
            _ => None,
        })
    }

    fn own_call(
        &mut self,
        address: *const u8,
        target: ir::Value,
        source: Option<ir::Value>,
        bytes: ir::Value,
    ) {
        let frame = self.handed_address();
        let mask = self.mask;
        self.store_row(frame, 0, mask);
        let source = source.unwrap_or(target);
        self.call_address(
            address,
            &[I64, I64, I32, I64],
            &[target, source, bytes, frame],
        );
    }

    /// One of the text's functions: for all lanes that run, or, where it wants scalars that differ from lane to lane, for those
    /// that have the same, until all are through.
    pub(super) fn call(&mut self, callee: u32, arguments: &[Value]) -> Result<(), Refused> {
        let index = self.function.callees[callee as usize];
        let passed = &self.from.passed[index];
        let different: Vec<Value> = (arguments.iter().zip(passed))
            .filter(|&(&argument, passed)| *passed == Passed::Uniform && !self.is_uniform(argument))
            .map(|(&argument, _)| argument)
            .collect();
        if different.is_empty() {
            return self.call_with(callee, arguments, &[], self.mask);
        }
        if different.iter().any(|&value| self.ty(value) != Type::I32) {
            return Err(Refused);
        }
        let rest = [(); 2].map(|()| self.scalar.builder.declare_var(ir::types::I32X4));
        let mask = self.mask;
        self.define(rest, mask);
        let (head, inside, behind) = (
            self.scalar.builder.create_block(),
            self.scalar.builder.create_block(),
            self.scalar.builder.create_block(),
        );
        self.scalar.builder.ins().jump(head, &[]);
        self.scalar.builder.switch_to_block(head);
        let left = rest.map(|held| self.scalar.builder.use_var(held));
        let any = self.any(left);
        self.scalar
            .builder
            .ins()
            .brif(any, inside, &[], behind, &[]);
        self.scalar.builder.switch_to_block(inside);
        // The first lane that is left.
        let builder = &mut self.scalar.builder;
        let [low, high] = left.map(|half| builder.ins().vhigh_bits(I32, half));
        let high = builder.ins().ishl_imm_u(high, 4);
        let bits = builder.ins().bor(low, high);
        let lane = builder.ins().ctz(bits);
        let lane = builder.ins().uextend(I64, lane);
        let lane = builder.ins().ishl_imm_u(lane, 2);
        let frame = self.handed_address();
        let mut ones = Vec::new();
        let mut same = left;
        for &value in &different {
            let words = self.pair(value);
            self.store_row(frame, 0, words);
            let builder = &mut self.scalar.builder;
            let place = builder.ins().iadd(frame, lane);
            let one = builder.ins().load(I32, super::unaligned(), place, 0);
            let all = self.splat(Type::I32, one);
            let equal = self.each(|builder, i| builder.ins().icmp(IntCC::Equal, words[i], all[i]));
            same = self.and(same, equal);
            ones.push((value, one));
        }
        let left = self.without(left, same);
        self.define(rest, left);
        self.call_with(callee, arguments, &ones, same)?;
        self.scalar.builder.ins().jump(head, &[]);
        self.scalar.builder.switch_to_block(behind);
        Ok(())
    }

    /// `ones` are values that all lanes of the mask have in common.
    fn call_with(
        &mut self,
        callee: u32,
        arguments: &[Value],
        ones: &[(Value, ir::Value)],
        mask: Pair,
    ) -> Result<(), Refused> {
        let index = self.function.callees[callee as usize];
        let called = &self.from.program.functions[index];
        let passed = &self.from.passed[index];
        let frame = self.handed_address();
        let mut direct = Vec::new();
        let mut row = 0;
        for (&argument, passed) in arguments.iter().zip(passed) {
            match passed {
                Passed::Lanes => {
                    let words = self.pair(argument);
                    let words = self.bits(words);
                    self.store_row(frame, 32 * row, words);
                    row += 1;
                }
                _ => {
                    let known = ones.iter().find(|known| known.0 == argument);
                    let one = match known {
                        Some(&(_, one)) => one,
                        None => self.one(argument),
                    };
                    direct.push(one);
                }
            }
        }
        self.store_row(frame, 32 * row, mask);
        direct.push(frame);
        let signature = signature(&called.parameters, passed, self.scalar.convention);
        let imported = self.scalar.imported(callee, signature);
        self.scalar.builder.ins().call(imported, &direct);
        Ok(())
    }
}
