//! What reads and writes memory. A lane that isn't active writes nothing.

use super::{
    Writer,
    operations::{atomic, of_words, to_words},
};
use crate::{
    ir::{AtomicOperation, Instruction, Memory, Runtime, Value},
    lanes::{LoadGroup, Pointer, pointer},
    rust::expression::expression,
};

impl Writer<'_> {
    /// An address that is the same in all lanes, so many bytes on.
    fn place(&self, base: Value, offset: i32, is_own: bool) -> String {
        let name = self.name(base);
        match (offset, is_own) {
            (0, _) => name,
            (offset, true) => format!(
                "{name}.offset({})",
                i64::from(offset) * i64::from(super::LANES)
            ),
            (offset, false) => format!("{name}.offset({offset})"),
        }
    }

    /// The address that a pointer counts from, and the vector of bytes behind it.
    fn parts(&self, base: Value, offset: i32) -> Option<(String, String)> {
        let Pointer {
            base: from,
            is_own,
            varies,
            ..
        } = pointer(&self.known.kinds, base)?;
        let place = self.place(from, offset, is_own);
        Some(match (varies, is_own) {
            (true, false) => (place, self.name(base)),
            (true, true) => (place, format!("own_offsets({})", self.name(base))),
            (false, false) => (place, "none()".to_owned()),
            (false, true) => (place, "own_offsets(none())".to_owned()),
        })
    }

    pub(super) fn memory(&mut self, position: usize, instruction: &Instruction) -> Option<()> {
        if let Some(group) = self.groups.loads.get(&position).cloned() {
            return self.load_group(position, &group);
        }
        if let Some(group) = self.groups.stores.get(&position).copied() {
            let (place, offsets) = self.parts(group.base, group.offset)?;
            let values = group
                .values
                .map(|(value, ty)| to_words(ty, &self.lanes(value)));
            self.line(&format!(
                "scatter_4({place}, {offsets}, {}, m);",
                values.join(", ")
            ));
            return Some(());
        }
        if self.groups.done.contains(&position) {
            return Some(());
        }
        if let Some(to) = instruction.result()
            && !self.known.homes.values[to.0 as usize].is_used
            && !matches!(
                instruction,
                Instruction::Atomic { .. } | Instruction::CompareExchange { .. }
            )
        {
            return Some(());
        }
        match *instruction {
            Instruction::Load { to, .. } => {
                let made = self.load(instruction)?;
                self.make(to, &made);
            }
            Instruction::Store {
                base,
                offset,
                value,
                ty,
                memory,
            } => {
                let words = to_words(ty, &self.lanes(value));
                let from = pointer(&self.known.kinds, base)?;
                let line = if from.is_own && !from.varies {
                    format!("own_store({}, {words}, m);", self.place(base, offset, true))
                } else {
                    let (place, offsets) = self.parts(base, offset)?;
                    let function = match memory {
                        Memory::Atomic => "scatter_atomic",
                        Memory::Constant | Memory::Plain => "scatter",
                    };
                    format!("{function}({place}, {offsets}, {words}, m);")
                };
                self.line(&line);
            }
            Instruction::Atomic {
                to,
                op,
                base,
                offset,
                value,
            } => {
                let varies = pointer(&self.known.kinds, base)?.varies;
                let (place, offsets) = self.parts(base, offset)?;
                let made = match op {
                    AtomicOperation::Add if !varies && self.is_uniform(value) => {
                        format!("add_same({place}, {}, m)", self.name(value))
                    }
                    _ => {
                        let value = self.lanes(value);
                        format!("atomic({place}, {offsets}, {value}, m, {})", atomic(op))
                    }
                };
                self.make(to, &made);
            }
            Instruction::CompareExchange {
                to,
                base,
                offset,
                expected,
                value,
            } => {
                let (place, offsets) = self.parts(base, offset)?;
                let (expected, value) = (self.lanes(expected), self.lanes(value));
                let made = format!("compare_exchange({place}, {offsets}, {expected}, {value}, m)");
                self.make(to, &made);
            }
            Instruction::StackAddress { to, offset } => {
                let bytes = u64::from(offset) * u64::from(super::LANES);
                self.make(to, &format!("(&raw mut own).cast::<u8>().add({bytes})"));
            }
            Instruction::Offset { to, base, bytes } => {
                let from = pointer(&self.known.kinds, base)?;
                let made = match from.varies {
                    true => format!("add({}, words({bytes}i32 as u32))", self.name(base)),
                    false => self.place(base, bytes, from.is_own),
                };
                self.make(to, &made);
            }
            Instruction::Element {
                to,
                base,
                index,
                stride,
            } => {
                let from = pointer(&self.known.kinds, base)?;
                let made = match (from.varies, self.is_uniform(index)) {
                    (false, true) => {
                        let bytes = if from.is_own {
                            super::LANES * stride
                        } else {
                            stride
                        };
                        format!(
                            "{}.add({} as usize * {bytes})",
                            self.name(base),
                            self.name(index)
                        )
                    }
                    (false, false) => format!("multiply({}, words({stride}))", self.lanes(index)),
                    (true, _) => format!(
                        "add({}, multiply({}, words({stride})))",
                        self.name(base),
                        self.lanes(index)
                    ),
                };
                self.make(to, &made);
            }
            _ => return None,
        }
        Some(())
    }

    fn load(&self, instruction: &Instruction) -> Option<String> {
        let Instruction::Load {
            ty,
            base,
            offset,
            memory,
            ..
        } = *instruction
        else {
            return None;
        };
        let from = pointer(&self.known.kinds, base)?;
        let words = match (from.is_own, from.varies, memory) {
            (false, false, _) => return expression(instruction, &|value| self.name(value)),
            (true, false, _) => format!("own_load({})", self.place(base, offset, true)),
            (_, _, memory) => {
                let (place, offsets) = self.parts(base, offset)?;
                let function = match memory {
                    Memory::Atomic => "gather_atomic",
                    Memory::Constant | Memory::Plain => "gather",
                };
                format!("{function}({place}, {offsets}, m)")
            }
        };
        Some(of_words(ty, &words))
    }

    fn load_group(&mut self, position: usize, group: &LoadGroup) -> Option<()> {
        let (place, offsets) = self.parts(group.base, group.offset)?;
        let words = group.words;
        self.line(&format!(
            "let g{position} = gather_{words}({place}, {offsets}, m);"
        ));
        for &(to, ty, word) in &group.loads {
            if self.known.homes.values[to.0 as usize].is_used {
                let made = of_words(ty, &format!("g{position}.{word}"));
                self.make(to, &made);
            }
        }
        Some(())
    }

    /// A function that works on memory.
    pub(super) fn runtime_memory(&mut self, instruction: &Instruction) -> Option<()> {
        let Instruction::CallRuntime {
            function,
            arguments,
            ..
        } = instruction
        else {
            return None;
        };
        let own = |value: Value| {
            let from = pointer(&self.known.kinds, value)?;
            (from.is_own && !from.varies).then(|| self.name(value))
        };
        let line = match (function, arguments.as_slice()) {
            (Runtime::LoadTexel, &[header, texel, target]) => {
                let header_from = pointer(&self.known.kinds, header)?;
                if header_from.is_own || header_from.varies {
                    return None;
                }
                format!(
                    "load_texel({}, {}, {}, m);",
                    self.name(header),
                    self.lanes(texel),
                    own(target)?
                )
            }
            (Runtime::Zero, &[target, bytes]) if self.is_uniform(bytes) => {
                format!("own_zero({}, {}, m);", own(target)?, self.name(bytes))
            }
            (Runtime::Copy, &[target, source, bytes]) if self.is_uniform(bytes) => {
                let from = pointer(&self.known.kinds, source)?;
                if from.is_own || from.varies {
                    return None;
                }
                let (source, bytes) = (self.name(source), self.name(bytes));
                format!("own_copy({}, {source}, {bytes}, m);", own(target)?)
            }
            (Runtime::Host, &[bound, taken, taken_words, given, given_words]) => {
                let bound_from = pointer(&self.known.kinds, bound)?;
                if bound_from.is_own || bound_from.varies {
                    return None;
                }
                // Their numbers are part of the text.
                let [taken_words, given_words] = [taken_words, given_words]
                    .map(|words| self.constants[words.0 as usize].clone());
                format!(
                    "host::<{{ {} as usize }}, {{ {} as usize }}>({}, {}, {}, m);",
                    taken_words?,
                    given_words?,
                    self.name(bound),
                    own(taken)?,
                    own(given)?,
                )
            }
            _ => return None,
        };
        self.line(&line);
        Some(())
    }
}
