//! Blocks of a function, and what is known of the ways between them.

use crate::ir::{Function, Instruction, Label, Value, Variable};

/// Sets of small numbers, one for each block.
#[derive(Debug)]
pub struct Sets {
    words: usize,
    bits: Vec<u64>,
}

impl Sets {
    fn new(sets: usize, numbers: usize, fill: bool) -> Self {
        let words = numbers.div_ceil(64);
        Self {
            words,
            bits: vec![if fill { !0 } else { 0 }; sets * words],
        }
    }

    /// Whether a set has a number.
    pub fn has(&self, set: usize, number: usize) -> bool {
        self.bits[set * self.words + number / 64] >> (number % 64) & 1 == 1
    }

    fn insert(&mut self, set: usize, number: usize) {
        self.bits[set * self.words + number / 64] |= 1 << (number % 64);
    }

    fn of(&self, set: usize) -> &[u64] {
        &self.bits[set * self.words..][..self.words]
    }

    /// Whether that changes it.
    fn replace(&mut self, set: usize, by: &[u64]) -> bool {
        let old = &mut self.bits[set * self.words..][..self.words];
        let changed = old != by;
        old.copy_from_slice(by);
        changed
    }
}

/// A loop, as blocks.
#[derive(Debug, Clone, Copy)]
pub struct Loop {
    /// The first.
    pub head: usize,
    /// The first block behind it.
    pub end: usize,
}

impl Loop {
    /// Whether a block is in it.
    pub fn holds(&self, block: usize) -> bool {
        (self.head..self.end).contains(&block)
    }
}

/// The blocks of a function in their order: from one label to the next.
#[derive(Debug)]
pub struct Flow {
    /// The first instruction of each.
    pub starts: Vec<usize>,
    instructions: usize,
    /// Where each leads.
    pub next: Vec<Vec<usize>>,
    /// Where each is come to from.
    pub before: Vec<Vec<usize>>,
    /// Outer ones first.
    pub loops: Vec<Loop>,
    /// What each begins with.
    pub labels: Vec<Option<Label>>,
}

impl Flow {
    /// None if a loop is entered other than by its head, or ends within another.
    pub(super) fn new(function: &Function) -> Option<Self> {
        let instructions = &function.instructions;
        let label = |instruction: &Instruction| match *instruction {
            Instruction::Label(label) => Some(label),
            _ => None,
        };
        let mut starts = vec![0];
        starts.extend((1..instructions.len()).filter(|&at| label(&instructions[at]).is_some()));
        let labels: Vec<_> = starts.iter().map(|&at| label(&instructions[at])).collect();
        let positions = function.positions();
        let count = starts.len();
        let block = |position: usize| starts.partition_point(|&start| start <= position) - 1;
        let mut flow = Self {
            instructions: instructions.len(),
            next: vec![Vec::new(); count],
            before: vec![Vec::new(); count],
            loops: Vec::new(),
            labels,
            starts: Vec::new(),
        };
        for from in 0..count {
            let end = starts.get(from + 1).copied().unwrap_or(instructions.len());
            for instruction in &instructions[starts[from]..end] {
                instruction.targets(|label| {
                    let to = block(positions[label.0 as usize]);
                    if !flow.next[from].contains(&to) {
                        flow.next[from].push(to);
                        flow.before[to].push(from);
                    }
                });
                if !flow.next[from].is_empty() || *instruction == Instruction::Return {
                    break;
                }
            }
        }
        flow.starts = starts;
        for head in 0..count {
            let last = flow.before[head].iter().filter(|&&from| from >= head);
            if let Some(&last) = last.max() {
                let end = last + 1;
                flow.loops.push(Loop { head, end });
            }
        }
        let nests = |a: &Loop, b: &Loop| b.head >= a.end || b.end <= a.end;
        for (index, outer) in flow.loops.iter().enumerate() {
            let enters = |to: usize| {
                to != outer.head && flow.before[to].iter().any(|&from| !outer.holds(from))
            };
            if flow.loops[index..].iter().any(|inner| !nests(outer, inner))
                || (outer.head..outer.end).any(enters)
            {
                return None;
            }
        }
        Some(flow)
    }

    /// How many blocks there are.
    pub fn count(&self) -> usize {
        self.starts.len()
    }

    /// The block that begins with a label.
    pub fn block(&self, label: Label) -> usize {
        let mut labels = self.labels.iter();
        labels.position(|&known| known == Some(label)).unwrap_or(0)
    }

    /// The instructions of a block.
    pub fn range(&self, block: usize) -> std::ops::Range<usize> {
        let end = self.starts.get(block + 1).copied();
        self.starts[block]..end.unwrap_or(self.instructions)
    }

    /// The innermost loop around a block.
    pub(super) fn innermost(&self, block: usize) -> Option<usize> {
        self.loops.iter().rposition(|l| l.holds(block))
    }

    /// Blocks through which every way to a block goes.
    pub(super) fn dominators(&self) -> Sets {
        let order: Vec<usize> = (0..self.count()).collect();
        self.solve(&self.before, &order, &|block| block == 0)
    }

    /// Blocks through which every way from a block goes that doesn't lead back to the head of this loop, or of one around
    /// it.
    pub(super) fn postdominators(&self, of: Option<usize>) -> Sets {
        let order: Vec<usize> = (0..self.count()).rev().collect();
        let around: Vec<usize> = match of {
            Some(of) => (self.loops.iter())
                .filter(|l| l.head <= self.loops[of].head && self.loops[of].end <= l.end)
                .map(|l| l.head)
                .collect(),
            None => Vec::new(),
        };
        let ends = |block: usize| {
            let mut next = self.next[block].iter();
            next.any(|&to| to <= block && around.contains(&to))
        };
        self.solve(&self.next, &order, &ends)
    }

    fn solve(
        &self,
        from: &[Vec<usize>],
        order: &[usize],
        is_start: &dyn Fn(usize) -> bool,
    ) -> Sets {
        let mut sets = Sets::new(self.count(), self.count(), true);
        loop {
            let mut changed = false;
            for &block in order {
                let mut all = vec![0; sets.words];
                if let Some((&first, rest)) = from[block].split_first()
                    && !is_start(block)
                {
                    all.copy_from_slice(sets.of(first));
                    for &other in rest {
                        (all.iter_mut().zip(sets.of(other))).for_each(|(all, other)| *all &= other);
                    }
                }
                all[block / 64] |= 1 << (block % 64);
                changed |= sets.replace(block, &all);
            }
            if !changed {
                return sets;
            }
        }
    }

    /// Variables whose values are needed where a block begins.
    pub(super) fn live(&self, function: &Function) -> Sets {
        let variables = function.variable_types.len();
        let mut live = Sets::new(self.count(), variables, false);
        let (mut read, mut set) = (
            Sets::new(self.count(), variables, false),
            Sets::new(self.count(), variables, false),
        );
        for block in 0..self.count() {
            for instruction in &function.instructions[self.range(block)] {
                match *instruction {
                    Instruction::Get { variable, .. } if !set.has(block, variable.0 as usize) => {
                        read.insert(block, variable.0 as usize);
                    }
                    Instruction::Set { variable, .. } => set.insert(block, variable.0 as usize),
                    _ => {}
                }
            }
        }
        loop {
            let mut changed = false;
            for block in (0..self.count()).rev() {
                let mut all = vec![0; live.words];
                for &next in &self.next[block] {
                    (all.iter_mut().zip(live.of(next))).for_each(|(all, next)| *all |= next);
                }
                for ((all, set), read) in all.iter_mut().zip(set.of(block)).zip(read.of(block)) {
                    *all = *all & !set | read;
                }
                changed |= live.replace(block, &all);
            }
            if !changed {
                return live;
            }
        }
    }

    /// Blocks at which lanes may wait while another is run.
    fn waiting(&self, block: usize) -> Vec<usize> {
        let may_wait = |&at: &usize| {
            at != block
                && self.before[at].iter().any(|&from| {
                    let earlier = from < block && (at > block || at <= from);
                    // In an earlier round of a loop that they have left.
                    let left = |l: &Loop| l.holds(from) && l.holds(block) && !l.holds(at);
                    earlier || self.loops.iter().any(left)
                })
        };
        (0..self.count()).filter(may_wait).collect()
    }

    /// Of each block, the variables whose values no lane needs that waits elsewhere: they may be set for all.
    pub(super) fn free(&self, function: &Function, live: &Sets) -> Sets {
        let variables = function.variable_types.len();
        let mut free = Sets::new(self.count(), variables, true);
        for block in 0..self.count() {
            let sets = |i: &Instruction| matches!(i, Instruction::Set { .. });
            if !function.instructions[self.range(block)].iter().any(sets) {
                continue;
            }
            let mut all = vec![!0; free.words];
            for at in self.waiting(block) {
                (all.iter_mut().zip(live.of(at))).for_each(|(all, live)| *all &= !live);
            }
            free.replace(block, &all);
        }
        free
    }
}

impl Flow {
    /// Blocks that all lanes come to together, or none: where no condition on the way is one that lanes see differently, as
    /// far as that isn't over.
    pub(super) fn converged(
        &self,
        function: &Function,
        is_uniform: &dyn Fn(Value) -> bool,
    ) -> Vec<bool> {
        let behind = self.postdominators(None);
        // What nothing leads to stands among what others run.
        let mut converged = self.reachable();
        for block in 0..self.count() {
            let parts = function.instructions[self.range(block)].iter();
            let mut conditions = parts.filter_map(|instruction| match *instruction {
                Instruction::Branch { condition, .. } => Some(condition),
                Instruction::Switch { selector, .. } => Some(selector),
                _ => None,
            });
            if conditions.next().is_none_or(is_uniform) {
                continue;
            }
            let mut open = self.next[block].clone();
            let mut seen = vec![false; self.count()];
            while let Some(at) = open.pop() {
                if (at != block && behind.has(block, at)) || seen[at] {
                    continue;
                }
                seen[at] = true;
                converged[at] = false;
                open.extend(&self.next[at]);
            }
        }
        // Who leaves a loop may wait in the midst of its text, until all others have left.
        for l in &self.loops {
            if !converged[l.head] {
                converged[l.head..l.end].fill(false);
            }
        }
        converged
    }

    /// Blocks that something leads to from the first.
    fn reachable(&self) -> Vec<bool> {
        let mut reachable = vec![false; self.count()];
        let mut open = vec![0];
        while let Some(block) = open.pop() {
            if !std::mem::replace(&mut reachable[block], true) {
                open.extend(&self.next[block]);
            }
        }
        reachable
    }
}

/// Whether a variable's value comes into a block from before.
pub(super) fn comes_in(live: &Sets, block: usize, variable: Variable) -> bool {
    live.has(block, variable.0 as usize)
}
