//! Memory: what lanes share, and what each has of its own, word by word, of each word the lanes.

use cranelift_codegen::ir::{
    self, Endianness, InstBuilder, MemFlagsData,
    types::{I8X16, I32, I32X4, I64, I64X2},
};
use cranelift_frontend::FunctionBuilder;
use kernel_ir::lanes::{LoadGroup, Pointer, pointer};

use super::{LANES, Lanes, Pair, Refused, calls::Helper, unaligned};
use crate::native::compile::ir::{Instruction, Memory, Type, Value};

impl Lanes<'_> {
    fn known(&self, value: Value) -> Result<Pointer, Refused> {
        pointer(&self.analysis.kinds, value).ok_or(Refused)
    }

    /// An address that is the same in all lanes, so many bytes on.
    fn place(&mut self, base: Value, offset: i32, is_own: bool) -> ir::Value {
        let base = self.one(base);
        let bytes = if is_own { LANES as i32 } else { 1 } * offset;
        match bytes {
            0 => base,
            _ => self.scalar.builder.ins().iadd_imm_s(base, i64::from(bytes)),
        }
    }

    /// The address that a pointer counts from, and of each lane the bytes behind it.
    fn parts(&mut self, base: Value, offset: i32) -> Result<(ir::Value, Pair), Refused> {
        let known = self.known(base)?;
        let place = self.place(known.base, offset, known.is_own);
        let bytes = match known.varies {
            true => self.pair(base),
            false => self.words(0),
        };
        if !known.is_own {
            return Ok((place, bytes));
        }
        let bytes = self.each(|builder, i| {
            let lanes = (0..4).flat_map(|lane| (4 * lane + 16 * i as u32).to_le_bytes());
            let lanes: Vec<u8> = lanes.collect();
            let constant = builder.func.dfg.constants.insert(lanes.into());
            let lanes = builder.ins().vconst(ir::types::I32X4, constant);
            let scaled = builder.ins().ishl_imm_u(bytes[i], 3);
            builder.ins().iadd(scaled, lanes)
        });
        Ok((place, bytes))
    }

    pub(super) fn memory(
        &mut self,
        position: usize,
        instruction: &Instruction,
    ) -> Result<(), Refused> {
        if let Some(group) = self.groups.loads.remove(&position) {
            return self.load_group(&group);
        }
        if let Some(group) = self.groups.stores.remove(&position) {
            let mut rows = vec![self.words(0)];
            for (value, ty) in group.values {
                let value = self.pair(value);
                rows.push(self.words_of(ty, value));
            }
            let (place, bytes) = self.parts(group.base, group.offset)?;
            rows[0] = bytes;
            self.help(Helper::ScatterFour, place, &rows);
            return Ok(());
        }
        if self.groups.done.contains(&position) {
            return Ok(());
        }
        match *instruction {
            Instruction::Load {
                to,
                ty: Type::Pointer,
                ..
            } => self.as_scalar(instruction, to)?,
            Instruction::Load {
                to,
                ty,
                base,
                offset,
                memory,
            } => {
                let known = self.known(base)?;
                let words = if known.is_own && !known.varies {
                    let place = self.place(base, offset, true);
                    self.load_row(place, 0)
                } else {
                    let (place, bytes) = self.parts(base, offset)?;
                    self.gather(place, bytes, memory)
                };
                let made = self.of_words(ty, words);
                self.make(to, made);
            }
            Instruction::Store {
                base,
                offset,
                value,
                ty,
                memory,
            } => {
                let value = self.pair(value);
                let words = self.words_of(ty, value);
                let known = self.known(base)?;
                if known.is_own && !known.varies {
                    let place = self.place(base, offset, true);
                    self.own_store(place, 0, words);
                } else {
                    let (place, bytes) = self.parts(base, offset)?;
                    let helper = match memory {
                        Memory::Atomic => Helper::ScatterAtomic,
                        Memory::Constant | Memory::Plain => Helper::Scatter,
                    };
                    self.help(helper, place, &[bytes, words]);
                }
            }
            Instruction::Atomic {
                to,
                op,
                base,
                offset,
                value,
            } => {
                let value = self.pair(value);
                let (place, bytes) = self.parts(base, offset)?;
                self.help(Helper::Atomic(op), place, &[bytes, value]);
                let made = self.handed_row(0);
                self.make(to, made);
            }
            Instruction::CompareExchange {
                to,
                base,
                offset,
                expected,
                value,
            } => {
                let (expected, value) = (self.pair(expected), self.pair(value));
                let (place, bytes) = self.parts(base, offset)?;
                self.help(Helper::CompareExchange, place, &[bytes, expected, value]);
                let made = self.handed_row(0);
                self.make(to, made);
            }
            Instruction::Offset { to, base, bytes } => {
                let known = self.known(base)?;
                if known.varies {
                    let (from, more) = (self.pair(base), self.words(bytes as u32));
                    let made = self.each(|builder, i| builder.ins().iadd(from[i], more[i]));
                    self.make(to, made);
                } else {
                    let made = self.place(base, bytes, known.is_own);
                    self.make_one(to, made);
                }
            }
            Instruction::Element {
                to,
                base,
                index,
                stride,
            } => {
                let known = self.known(base)?;
                if !known.varies && self.is_uniform(index) {
                    let (base, index) = (self.one(base), self.one(index));
                    let builder = &mut self.scalar.builder;
                    let index = builder.ins().uextend(I64, index);
                    let stride = if known.is_own { LANES * stride } else { stride };
                    let bytes = builder.ins().imul_imm_s(index, i64::from(stride));
                    let made = builder.ins().iadd(base, bytes);
                    self.make_one(to, made);
                } else {
                    let index = self.pair(index);
                    let mut made = self.each(|builder, i| match stride.is_power_of_two() {
                        true => builder
                            .ins()
                            .ishl_imm_u(index[i], i64::from(stride.ilog2())),
                        false => {
                            let stride = builder.ins().iconst(I32, i64::from(stride));
                            let stride = builder.ins().splat(I32X4, stride);
                            builder.ins().imul(index[i], stride)
                        }
                    });
                    if known.varies {
                        let from = self.pair(base);
                        made = self.each(|builder, i| builder.ins().iadd(from[i], made[i]));
                    }
                    self.make(to, made);
                }
            }
            _ => return Err(Refused),
        }
        Ok(())
    }

    /// Words of lanes that run; the others read what the address points to.
    fn gather(&mut self, place: ir::Value, bytes: Pair, memory: Memory) -> Pair {
        let bytes = self.and(bytes, self.mask);
        let flags = match memory {
            Memory::Constant => MemFlagsData::trusted().with_readonly().with_can_move(),
            Memory::Plain | Memory::Atomic => MemFlagsData::trusted(),
        };
        self.each(|builder, i| {
            let mut made = bytes[i];
            for lane in 0..4_u8 {
                let offset = builder.ins().extractlane(bytes[i], lane);
                let offset = builder.ins().uextend(I64, offset);
                let at = builder.ins().iadd(place, offset);
                let word = match memory {
                    Memory::Atomic => builder.ins().atomic_load(I32, MemFlagsData::trusted(), at),
                    _ => builder.ins().load(I32, flags, at, 0),
                };
                made = builder.ins().insertlane(made, word, lane);
            }
            made
        })
    }

    /// Words that stand together are one access for each lane; then rows become columns.
    fn load_group(&mut self, group: &LoadGroup) -> Result<(), Refused> {
        let (place, bytes) = self.parts(group.base, group.offset)?;
        let bytes = self.and(bytes, self.mask);
        let columns = [0, 1].map(|half| {
            let rows = [0, 1, 2, 3].map(|lane| {
                let builder = &mut self.scalar.builder;
                let offset = builder.ins().extractlane(bytes[half], lane);
                let offset = builder.ins().uextend(I64, offset);
                let at = builder.ins().iadd(place, offset);
                match group.words {
                    2 => {
                        let two = builder.ins().load(I64, unaligned(), at, 0);
                        builder.ins().scalar_to_vector(I64X2, two)
                    }
                    _ => builder.ins().load(I32X4, unaligned(), at, 0),
                }
            });
            self.transposed(rows)
        });
        for &(to, ty, word) in &group.loads {
            let words = [0, 1].map(|half| columns[half][word as usize]);
            let made = self.of_words(ty, words);
            self.make(to, made);
        }
        Ok(())
    }

    /// Columns of four rows of words.
    fn transposed(&mut self, [a, b, c, d]: [ir::Value; 4]) -> [ir::Value; 4] {
        let mut shuffle = |a, b, words| shuffle(&mut self.scalar.builder, a, b, words);
        let [low, high] = [[0, 16, 4, 20], [8, 24, 12, 28]];
        let (ab, cd) = (shuffle(a, b, low), shuffle(c, d, low));
        let (x, y) = (
            shuffle(ab, cd, [0, 4, 16, 20]),
            shuffle(ab, cd, [8, 12, 24, 28]),
        );
        let (ab, cd) = (shuffle(a, b, high), shuffle(c, d, high));
        let (z, w) = (
            shuffle(ab, cd, [0, 4, 16, 20]),
            shuffle(ab, cd, [8, 12, 24, 28]),
        );
        [x, y, z, w]
    }

    /// Stores words of lanes that run.
    pub(super) fn own_store(&mut self, place: ir::Value, offset: i32, words: Pair) {
        let before = self.load_row(place, offset);
        let words = self.select(self.mask, words, before);
        self.store_row(place, offset, words);
    }
}

/// A vector of the words that begin at these bytes of two others, one behind the other.
pub(super) fn shuffle(
    builder: &mut FunctionBuilder<'_>,
    a: ir::Value,
    b: ir::Value,
    words: [u8; 4],
) -> ir::Value {
    let flags = MemFlagsData::new().with_endianness(Endianness::Little);
    let bytes = words.into_iter().flat_map(|first| first..first + 4);
    let bytes: Vec<u8> = bytes.collect();
    let mask = builder.func.dfg.immediates.push(bytes.into());
    let [a, b] = [a, b].map(|v| builder.ins().bitcast(I8X16, flags, v));
    let made = builder.ins().shuffle(a, b, mask);
    builder.ins().bitcast(I32X4, flags, made)
}
