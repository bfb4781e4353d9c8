//! Blocks: jumps where all lanes go together, masks where they don't.

use cranelift_codegen::ir::{self, InstBuilder, types::I32};
use cranelift_frontend::{FunctionBuilder, Switch};
use kernel_ir::lanes::Analysis;

use super::{LANES, Lanes, Pair, Refused};
use crate::native::compile::ir::{Instruction, Label, Value};

/// Blocks one after the other that lanes don't run together.
pub(super) struct Run {
    first: usize,
    /// The one behind the last.
    end: usize,
    start: ir::Block,
    /// Where all lanes meet again; none if that is the function's end.
    meets: Option<usize>,
}

/// All of them; refused where lanes would meet again in different places.
pub(super) fn runs(
    analysis: &Analysis,
    builder: &mut FunctionBuilder<'_>,
) -> Result<Vec<Run>, Refused> {
    let mut runs = Vec::new();
    let count = analysis.flow.count();
    let mut first = 0;
    while first < count {
        if analysis.converged[first] {
            first += 1;
            continue;
        }
        let blocks = first..count;
        let end = blocks.clone().find(|&block| analysis.converged[block]);
        let end = end.unwrap_or(count);
        let mut meets = None;
        for block in first..end {
            // Nothing leads to some of them, so they lead nowhere.
            let is_dead = block > 0 && analysis.flow.before[block].is_empty();
            for &next in analysis.flow.next[block].iter().filter(|_| !is_dead) {
                if (first..end).contains(&next) {
                    continue;
                }
                if !analysis.converged[next] || meets.is_some_and(|known| known != next) {
                    return Err(Refused);
                }
                meets = Some(next);
            }
        }
        runs.push(Run {
            first,
            end,
            start: builder.create_block(),
            meets,
        });
        first = end;
    }
    Ok(runs)
}

/// A guard that is open.
struct Open {
    guard: usize,
    /// The mask around it.
    around: Pair,
    /// Where it begins again, if it is a loop.
    head: Option<ir::Block>,
    /// Where it ends, if it can be left out or is a loop.
    exit: Option<ir::Block>,
}

impl Lanes<'_> {
    pub(super) fn body(&mut self) -> Result<(), Refused> {
        self.prologue()?;
        let threads: u32 = self.from.program.workgroup_size.iter().product();
        let again = self.scalar.builder.create_block();
        if self.from.index == 0 {
            let first = self.scalar.builder.declare_var(I32);
            let zero = self.scalar.builder.ins().iconst(I32, 0);
            self.scalar.builder.def_var(first, zero);
            self.first = Some(first);
        }
        self.scalar.builder.ins().jump(again, &[]);
        self.scalar.builder.switch_to_block(again);
        let mut open: Vec<Open> = Vec::new();
        let mut next = 0;
        // Where it begins.
        let begin = match self.starts[0] {
            Some(start) => start,
            None => return Err(Refused),
        };
        self.scalar.builder.ins().jump(begin, &[]);
        for block in 0..=self.analysis.flow.count() {
            let ended = |open: &Open| self.analysis.guards[open.guard].end <= block;
            while let Some(inner) = open.pop_if(|open| ended(open)) {
                self.close(inner);
            }
            if let Some(run) = self.runs.iter().position(|run| run.end == block) {
                let meets = match self.runs[run].meets {
                    Some(meets) => self.starts[meets].ok_or(Refused)?,
                    None => self.end,
                };
                self.scalar.builder.ins().jump(meets, &[]);
            }
            if block == self.analysis.flow.count() {
                break;
            }
            if let Some(start) = self.starts[block] {
                if !open.is_empty() {
                    return Err(Refused);
                }
                self.scalar.builder.switch_to_block(start);
                self.mask = self.all;
            }
            if let Some(run) = self.runs.iter().position(|run| run.first == block) {
                self.scalar.builder.switch_to_block(self.runs[run].start);
            }
            while next < self.analysis.guards.len() && self.analysis.guards[next].start == block {
                if !self.analysis.converged[block] {
                    let opened = self.open(next)?;
                    open.push(opened);
                }
                next += 1;
            }
            for position in self.analysis.flow.range(block) {
                let instruction = &self.function.instructions[position];
                if self.is_end(block, instruction)? {
                    break;
                }
                self.instruction(block, position, instruction)?;
            }
        }
        self.scalar.builder.switch_to_block(self.end);
        if let Some(first) = self.first {
            let now = self.scalar.builder.use_var(first);
            let now = self.scalar.builder.ins().iadd_imm_s(now, i64::from(LANES));
            self.scalar.builder.def_var(first, now);
            let less = ir::condcodes::IntCC::UnsignedLessThan;
            let all = self.scalar.builder.ins().iconst(I32, i64::from(threads));
            let more = self.scalar.builder.ins().icmp(less, now, all);
            let done = self.scalar.builder.create_block();
            self.scalar.builder.ins().brif(more, again, &[], done, &[]);
            self.scalar.builder.switch_to_block(done);
        }
        self.scalar.builder.ins().return_(&[]);
        Ok(())
    }

    fn open(&mut self, guard: usize) -> Result<Open, Refused> {
        let known = self.analysis.guards[guard];
        let around = self.mask;
        let block = known.start;
        if known.is_loop {
            let (head, exit) = (
                self.scalar.builder.create_block(),
                self.scalar.builder.create_block(),
            );
            self.scalar.builder.ins().jump(head, &[]);
            self.scalar.builder.switch_to_block(head);
            self.clear_masks(Some(guard));
            return Ok(Open {
                guard,
                around,
                head: Some(head),
                exit: Some(exit),
            });
        }
        let held = self.masks[block].ok_or(Refused)?;
        let mask = held.map(|held| self.scalar.builder.use_var(held));
        let mut exit = None;
        if known.is_tested {
            let (inside, behind) = (
                self.scalar.builder.create_block(),
                self.scalar.builder.create_block(),
            );
            let any = self.any(mask);
            self.scalar
                .builder
                .ins()
                .brif(any, inside, &[], behind, &[]);
            self.scalar.builder.switch_to_block(inside);
            exit = Some(behind);
        }
        if self.analysis.flow.loops.iter().any(|l| l.head == block) {
            let none = self.words(0);
            self.define(held, none);
        }
        self.mask = mask;
        self.clear_masks(Some(guard));
        Ok(Open {
            guard,
            around,
            head: None,
            exit,
        })
    }

    fn close(&mut self, open: Open) {
        self.mask = open.around;
        let Some(exit) = open.exit else { return };
        match open.head {
            Some(head) => {
                let start = self.analysis.guards[open.guard].start;
                let held = self.masks[start].expect("a loop's head has a mask");
                let mask = held.map(|held| self.scalar.builder.use_var(held));
                let any = self.any(mask);
                self.scalar.builder.ins().brif(any, head, &[], exit, &[]);
            }
            None => {
                self.scalar.builder.ins().jump(exit, &[]);
            }
        }
        self.scalar.builder.switch_to_block(exit);
    }

    /// Nobody waits yet for the blocks whose masks begin with a guard; with none, for those of all runs.
    fn clear_masks(&mut self, guard: Option<usize>) {
        let none = self.words(0);
        for block in 0..self.masks.len() {
            let home = self.analysis.homes.masks[block];
            // A guard that all lanes go through together isn't opened.
            let home =
                home.filter(|&home| !self.analysis.converged[self.analysis.guards[home].start]);
            if let Some(held) = self.masks[block]
                && home == guard
            {
                self.define(held, none);
            }
        }
    }

    /// Lets lanes wait for a block.
    fn go(&mut self, block: usize, mask: Pair) {
        if let Some(held) = self.masks[block] {
            let before = held.map(|held| self.scalar.builder.use_var(held));
            let both = self.each(|builder, i| builder.ins().bor(before[i], mask[i]));
            self.define(held, both);
        }
    }

    /// The run that a block is in.
    fn run_of(&self, block: usize) -> Result<usize, Refused> {
        let mut runs = self.runs.iter();
        let found = runs.position(|run| (run.first..run.end).contains(&block));
        found.ok_or(Refused)
    }

    /// Where to jump so that all lanes are at a block; with what has to be written there first, if it is in a run.
    fn way(&mut self, block: usize, landings: &mut Vec<(ir::Block, usize)>) -> ir::Block {
        match self.starts[block] {
            Some(start) => start,
            None => {
                let landing = self.scalar.builder.create_block();
                landings.push((landing, block));
                landing
            }
        }
    }

    /// Goes with all lanes into runs.
    fn land(&mut self, landings: Vec<(ir::Block, usize)>) -> Result<(), Refused> {
        for (landing, block) in landings {
            self.scalar.builder.switch_to_block(landing);
            self.clear_masks(None);
            self.go(block, self.mask);
            let run = self.run_of(block)?;
            let start = self.runs[run].start;
            self.scalar.builder.ins().jump(start, &[]);
        }
        Ok(())
    }

    /// Writes what ends a block, if an instruction does.
    fn is_end(&mut self, block: usize, instruction: &Instruction) -> Result<bool, Refused> {
        let together = self.analysis.converged[block];
        let of = |label: Label| self.analysis.flow.block(label);
        match *instruction {
            Instruction::Jump(label) if together => {
                let mut landings = Vec::new();
                let place = self.way(of(label), &mut landings);
                self.scalar.builder.ins().jump(place, &[]);
                self.land(landings)?;
            }
            Instruction::Jump(label) => self.go(of(label), self.mask),
            Instruction::Branch {
                condition,
                accept,
                reject,
            } => {
                let (accept, reject) = (of(accept), of(reject));
                if together && self.is_uniform(condition) {
                    let mut landings = Vec::new();
                    let condition = self.one(condition);
                    let accept = self.way(accept, &mut landings);
                    let reject = self.way(reject, &mut landings);
                    let builder = &mut self.scalar.builder;
                    builder.ins().brif(condition, accept, &[], reject, &[]);
                    self.land(landings)?;
                } else {
                    let condition = self.pair(condition);
                    let taken = self.and(self.mask, condition);
                    let left = self.without(self.mask, condition);
                    self.part(together, &[(accept, taken), (reject, left)])?;
                }
            }
            Instruction::Switch {
                selector,
                ref cases,
                default,
            } => {
                let of_cases: Vec<(u32, usize)> = cases
                    .iter()
                    .map(|&(value, label)| (value, of(label)))
                    .collect();
                let default = of(default);
                match together && self.is_uniform(selector) {
                    true => self.switch(selector, &of_cases, default)?,
                    false => self.masked_switch(together, selector, &of_cases, default)?,
                }
            }
            Instruction::Return => {
                if together {
                    self.scalar.builder.ins().jump(self.end, &[]);
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Lets lanes go different ways: from where they all were, or from within a run.
    fn part(&mut self, together: bool, ways: &[(usize, Pair)]) -> Result<(), Refused> {
        if !together {
            for &(block, mask) in ways {
                self.go(block, mask);
            }
            return Ok(());
        }
        self.clear_masks(None);
        let mut run = None;
        for &(block, mask) in ways {
            if self.analysis.converged[block] {
                continue;
            }
            let own = self.run_of(block)?;
            if run.is_some_and(|run| run != own) {
                return Err(Refused);
            }
            run = Some(own);
            self.go(block, mask);
        }
        // Who isn't in the run waits where it ends.
        let waits = ways.iter().map(|way| way.0);
        let mut waits = waits.filter(|&block| self.analysis.converged[block]);
        let meets = match run {
            Some(run) => self.runs[run].meets,
            None => waits.clone().next(),
        };
        if waits.any(|block| Some(block) != meets) {
            return Err(Refused);
        }
        let to = match (run, meets) {
            (Some(run), _) => self.runs[run].start,
            (None, Some(meets)) => self.starts[meets].ok_or(Refused)?,
            (None, None) => return Err(Refused),
        };
        self.scalar.builder.ins().jump(to, &[]);
        Ok(())
    }

    fn switch(
        &mut self,
        selector: Value,
        cases: &[(u32, usize)],
        default: usize,
    ) -> Result<(), Refused> {
        let mut landings = Vec::new();
        let selector = self.one(selector);
        let mut switch = Switch::new();
        for &(value, block) in cases {
            let place = self.way(block, &mut landings);
            switch.set_entry(u128::from(value), place);
        }
        let default = self.way(default, &mut landings);
        switch.emit(&mut self.scalar.builder, selector, default);
        self.land(landings)
    }

    fn masked_switch(
        &mut self,
        together: bool,
        selector: Value,
        cases: &[(u32, usize)],
        default: usize,
    ) -> Result<(), Refused> {
        let selector = self.pair(selector);
        let mut ways = Vec::new();
        let mut rest = self.mask;
        for &(value, block) in cases {
            let value = self.words(value);
            let equal = ir::condcodes::IntCC::Equal;
            let is = self.each(|builder, i| builder.ins().icmp(equal, selector[i], value[i]));
            let case = self.and(rest, is);
            rest = self.without(rest, case);
            ways.push((block, case));
        }
        ways.push((default, rest));
        self.part(together, &ways)
    }
}
