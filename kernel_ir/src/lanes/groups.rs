//! Words that stand together in memory are read and written together: a lane's four words are one access, and turning rows
//! into columns costs less than as many accesses again.

use std::collections::{HashMap, HashSet};

use super::{Flow, Kind, pointer};
use crate::ir::{Function, Instruction, Memory, Runtime, Type, Value};

/// Loads that are done at once.
#[derive(Debug, Clone)]
pub struct LoadGroup {
    /// The address that they count from.
    pub base: Value,
    /// Of the first word, in bytes.
    pub offset: i32,
    /// Two or four.
    pub words: i32,
    /// What is loaded, and which of the words it is.
    pub loads: Vec<(Value, Type, i32)>,
}

/// Four stores that are done at once.
#[derive(Debug, Clone, Copy)]
pub struct StoreGroup {
    /// The address that they count from.
    pub base: Value,
    /// Of the first word, in bytes.
    pub offset: i32,
    /// What is stored.
    pub values: [(Value, Type); 4],
}

/// The accesses of a function that are done with others.
#[derive(Debug, Default)]
pub struct Groups {
    /// By the place of the first load.
    pub loads: HashMap<usize, LoadGroup>,
    /// By the place of the last store.
    pub stores: HashMap<usize, StoreGroup>,
    /// Places of what is done with another.
    pub done: HashSet<usize>,
}

struct Pending {
    position: usize,
    to: Value,
    ty: Type,
    offset: i32,
}

pub(super) fn groups(function: &Function, flow: &Flow, kinds: &[Kind]) -> Groups {
    let mut groups = Groups::default();
    for block in 0..flow.count() {
        // In the order of their first loads, so that what is written doesn't change from build to build.
        let mut constant: Vec<(Value, Vec<Pending>)> = Vec::new();
        let mut plain: Vec<(Value, Vec<Pending>)> = Vec::new();
        for position in flow.range(block) {
            match function.instructions[position] {
                Instruction::Load {
                    to,
                    ty,
                    base,
                    offset,
                    memory: memory @ (Memory::Constant | Memory::Plain),
                } if pointer(kinds, base).is_some_and(|p| p.varies && !p.is_own) => {
                    let open = match memory {
                        Memory::Constant => &mut constant,
                        _ => &mut plain,
                    };
                    let load = Pending {
                        position,
                        to,
                        ty,
                        offset,
                    };
                    match open.iter_mut().find(|(known, _)| *known == base) {
                        Some((_, loads)) => loads.push(load),
                        None => open.push((base, vec![load])),
                    }
                }
                Instruction::Store { base, .. } => {
                    // Own memory is not what others point to.
                    if !pointer(kinds, base).is_some_and(|p| p.is_own) {
                        groups.close(&mut plain, kinds);
                    }
                    groups.store(function, kinds, position);
                }
                Instruction::Atomic { .. }
                | Instruction::CompareExchange { .. }
                | Instruction::Call { .. }
                | Instruction::CallRuntime {
                    function: Runtime::Copy | Runtime::Zero | Runtime::StoreTexel | Runtime::Host,
                    ..
                } => groups.close(&mut plain, kinds),
                _ => {}
            }
        }
        groups.close(&mut constant, kinds);
        groups.close(&mut plain, kinds);
    }
    groups
}

impl Groups {
    fn close(&mut self, open: &mut Vec<(Value, Vec<Pending>)>, kinds: &[Kind]) {
        for (base, mut loads) in open.drain(..) {
            let element = pointer(kinds, base).and_then(|p| p.element);
            loads.sort_by_key(|load| (load.offset, load.position));
            let mut rest = loads.as_slice();
            while let Some(first) = rest.first() {
                // Four words are read where all of them are asked for, or are within the element.
                let window = element.and_then(|(stride, at)| {
                    let within = (first.offset + at).div_euclid(16) * 16;
                    (within >= 0 && within + 16 <= stride as i32).then_some(within - at)
                });
                let taken = |start: i32, bytes: i32| {
                    rest.partition_point(|load| load.offset + 4 <= start + bytes)
                };
                let distinct = |count: usize| {
                    let offsets = rest[..count].chunk_by(|a, b| a.offset == b.offset);
                    offsets.count()
                };
                let (start, words, count) = match window {
                    Some(start) if distinct(taken(start, 16)) > 1 => (start, 4, taken(start, 16)),
                    _ if distinct(taken(first.offset, 16)) == 4 => {
                        (first.offset, 4, taken(first.offset, 16))
                    }
                    _ if distinct(taken(first.offset, 8)) == 2 => {
                        (first.offset, 2, taken(first.offset, 8))
                    }
                    _ => (first.offset, 1, 1),
                };
                let (group, behind) = rest.split_at(count.max(1));
                rest = behind;
                let aligned = group.iter().all(|load| (load.offset - start) % 4 == 0);
                if words == 1 || !aligned {
                    continue;
                }
                let position = group.iter().map(|load| load.position).min().unwrap_or(0);
                self.done.extend(group.iter().map(|load| load.position));
                let loads = group
                    .iter()
                    .map(|load| (load.to, load.ty, (load.offset - start) / 4));
                let loads = loads.collect();
                let group = LoadGroup {
                    base,
                    offset: start,
                    words,
                    loads,
                };
                self.loads.insert(position, group);
            }
        }
    }

    /// Looks for four stores that begin here.
    fn store(&mut self, function: &Function, kinds: &[Kind], position: usize) {
        if self.done.contains(&position) {
            return;
        }
        let mut values = Vec::new();
        let mut places = Vec::new();
        let mut first = None;
        for (place, instruction) in function.instructions.iter().enumerate().skip(position) {
            match *instruction {
                Instruction::Constant { .. } => {}
                Instruction::Store {
                    base,
                    offset,
                    value,
                    ty,
                    memory: Memory::Plain,
                } if *first.get_or_insert((base, offset))
                    == (base, offset - 4 * values.len() as i32)
                    && pointer(kinds, base).is_some_and(|p| p.varies && !p.is_own) =>
                {
                    values.push((value, ty));
                    places.push(place);
                }
                _ => return,
            }
            if let (Ok(values), Some((base, offset))) =
                (<[_; 4]>::try_from(values.as_slice()), first)
            {
                let group = StoreGroup {
                    base,
                    offset,
                    values,
                };
                self.stores.insert(place, group);
                self.done.extend(places);
                return;
            }
        }
    }
}
