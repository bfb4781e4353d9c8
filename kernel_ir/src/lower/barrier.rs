//! Barriers. Between two barriers the invocations of a workgroup run one after the other; at a barrier an invocation puts
//! what it still needs into its *frame* in the scratch memory, with the number of the barrier, and the next one runs. When
//! all have arrived or ended, those that wait go on from where they were. Invocations that wait at different barriers, or
//! end while others wait, do no harm.

use std::collections::{BTreeSet, HashMap, HashSet};

use crate::{
    CompileError, ErrorKind,
    ir::{Comparison, Function, Instruction, Label, Memory, Type, Value, Variable},
};

/// Places of an entry point's loop over its invocations.
pub(super) struct Points {
    pub(super) scratch: Value,
    /// Where in the scratch memory frames begin: behind workgroup variables, which are aligned.
    pub(super) frames_at: u32,
    pub(super) threads: u32,
    /// The variable that counts invocations.
    pub(super) index: Variable,
    /// Where an invocation starts.
    pub(super) head: Label,
    /// Where it ends.
    pub(super) next: Label,
    /// Where all have run.
    pub(super) done: Label,
}

/// A frame begins with where its invocation is: at the start, at barrier 1, 2, ..., or at the end.
const FRAME_HEAD: u32 = 16;
const ENDED: u32 = u32::MAX;

/// The most bytes of scratch memory.
const MOST_BYTES: u64 = 64 << 20;

/// Replaces the barriers of an entry point; bytes of scratch memory that it needs.
pub(super) fn split(function: &mut Function, points: &Points) -> Result<u32, CompileError> {
    start_anew(function, points);
    keep_values_in_variables(function);
    let live = live_at_barriers(function, points);
    let kept: BTreeSet<Variable> = live.iter().flatten().copied().collect();
    let places: HashMap<Variable, u32> = kept
        .iter()
        .zip((FRAME_HEAD..).step_by(8))
        .map(|(&variable, at)| (variable, at))
        .collect();
    let stack_at = (FRAME_HEAD + 8 * places.len() as u32).next_multiple_of(16);
    let frame_bytes = u64::from(stack_at) + u64::from(function.stack_bytes).next_multiple_of(16);
    let bytes = u64::from(points.frames_at) + frame_bytes * u64::from(points.threads);
    if bytes > MOST_BYTES {
        let limit = MOST_BYTES as u32;
        return Err(ErrorKind::Stack { bytes, limit }.into());
    }
    function.stack_bytes = 0;
    let old = std::mem::take(&mut function.instructions);
    let mut splitter = Splitter {
        frame: new_variable(function, Type::Pointer),
        waits: new_variable(function, Type::I32),
        function,
        points,
        places,
        stack_at,
        frame_bytes: frame_bytes as u32,
    };
    splitter.write(old, &live);
    Ok(bytes as u32)
}

fn new_variable(function: &mut Function, ty: Type) -> Variable {
    function.variable_types.push(ty);
    Variable(function.variable_types.len() as u32 - 1)
}

/// Moves addresses of private memory from before the loop into it: they lie in the frame of each invocation.
fn start_anew(function: &mut Function, points: &Points) {
    let mut before = std::mem::take(&mut function.instructions);
    let head = before
        .iter()
        .position(|i| *i == Instruction::Label(points.head))
        .map_or(0, |label| label + 1);
    let after = before.split_off(head);
    let is_address = |i: &Instruction| matches!(i, Instruction::StackAddress { .. });
    let (addresses, before): (Vec<_>, Vec<_>) = before.into_iter().partition(is_address);
    function.instructions = before.into_iter().chain(addresses).chain(after).collect();
}

/// The number of the block of each instruction; a barrier ends a block.
fn blocks(instructions: &[Instruction]) -> Vec<usize> {
    let mut block = 0;
    instructions
        .iter()
        .map(|instruction| {
            let here = match instruction {
                Instruction::Label(_) => block + 1,
                _ => block,
            };
            block = match instruction {
                Instruction::Barrier => here + 1,
                _ => here,
            };
            here
        })
        .collect()
}

/// Lets no value be used in another block than its own: variables carry them there.
fn keep_values_in_variables(function: &mut Function) {
    let numbers = blocks(&function.instructions);
    let mut made_in: HashMap<Value, usize> = HashMap::new();
    let mut carried: HashMap<Value, Variable> = HashMap::new();
    let mut needed: Vec<Value> = Vec::new();
    for (instruction, &block) in function.instructions.iter_mut().zip(&numbers) {
        for operand in instruction.operands() {
            if made_in.get(operand).is_some_and(|&made| made != block) {
                needed.push(*operand);
            }
        }
        if let Some(result) = instruction.result() {
            made_in.insert(result, block);
        }
    }
    for value in needed {
        let ty = function.value_types[value.0 as usize];
        carried
            .entry(value)
            .or_insert_with(|| new_variable(function, ty));
    }
    let old = std::mem::take(&mut function.instructions);
    for (mut instruction, block) in old.into_iter().zip(numbers) {
        for operand in instruction.operands() {
            if let Some(&variable) = carried.get(operand)
                && made_in[operand] != block
            {
                let ty = function.value_types[operand.0 as usize];
                function.value_types.push(ty);
                let to = Value(function.value_types.len() as u32 - 1);
                function
                    .instructions
                    .push(Instruction::Get { to, variable });
                *operand = to;
            }
        }
        let result = instruction.result();
        function.instructions.push(instruction);
        if let Some(value) = result
            && let Some(&variable) = carried.get(&value)
        {
            function
                .instructions
                .push(Instruction::Set { variable, value });
        }
    }
}

/// Of each barrier, in their order, the variables that are read behind it before they are set.
fn live_at_barriers(function: &Function, points: &Points) -> Vec<Vec<Variable>> {
    #[derive(Default)]
    struct Block {
        reads: HashSet<Variable>,
        sets: HashSet<Variable>,
        followers: Vec<usize>,
        barrier: bool,
    }
    let numbers = blocks(&function.instructions);
    let mut labels: HashMap<Label, usize> = HashMap::new();
    for (instruction, &block) in function.instructions.iter().zip(&numbers) {
        if let Instruction::Label(label) = instruction {
            labels.insert(*label, block);
        }
    }
    let mut all: Vec<Block> = Vec::new();
    all.resize_with(numbers.last().map_or(0, |last| last + 1), Block::default);
    for (instruction, &number) in function.instructions.iter().zip(&numbers) {
        let block = &mut all[number];
        match instruction {
            Instruction::Get { variable, .. } if !block.sets.contains(variable) => {
                block.reads.insert(*variable);
            }
            Instruction::Set { variable, .. } => {
                block.sets.insert(*variable);
            }
            Instruction::Barrier => {
                block.barrier = true;
                block.followers.push(number + 1);
            }
            // The next invocation starts anew: it takes nothing with it.
            Instruction::Jump(label) if *label != points.next => {
                block.followers.push(labels[label]);
            }
            Instruction::Branch { accept, reject, .. } => {
                let targets = [accept, reject];
                let inner = targets.into_iter().filter(|label| **label != points.next);
                block.followers.extend(inner.map(|label| labels[label]));
            }
            Instruction::Switch { cases, default, .. } => {
                let targets = cases.iter().map(|(_, label)| label).chain([default]);
                block.followers.extend(targets.map(|label| labels[label]));
            }
            _ => {}
        }
    }
    let mut live: Vec<HashSet<Variable>> = all.iter().map(|block| block.reads.clone()).collect();
    let mut changed = true;
    while changed {
        changed = false;
        for number in (0..all.len()).rev() {
            for &follower in &all[number].followers {
                let after: Vec<Variable> = live[follower]
                    .iter()
                    .filter(|variable| !all[number].sets.contains(variable))
                    .copied()
                    .collect();
                for variable in after {
                    changed |= live[number].insert(variable);
                }
            }
        }
    }
    all.iter()
        .enumerate()
        .filter(|(_, block)| block.barrier)
        .map(|(number, _)| {
            let mut behind: Vec<_> = live[number + 1]
                .iter()
                .copied()
                .filter(|&variable| variable != points.index)
                .collect();
            behind.sort_unstable();
            behind
        })
        .collect()
}

/// Writes the function again, with frames.
struct Splitter<'a> {
    function: &'a mut Function,
    points: &'a Points,
    /// The invocation's frame.
    frame: Variable,
    /// Whether an invocation waits.
    waits: Variable,
    /// Where in a frame a variable waits.
    places: HashMap<Variable, u32>,
    stack_at: u32,
    frame_bytes: u32,
}

impl Splitter<'_> {
    fn push(&mut self, instruction: Instruction) {
        self.function.instructions.push(instruction);
    }

    fn value(&mut self, ty: Type) -> Value {
        self.function.value_types.push(ty);
        Value(self.function.value_types.len() as u32 - 1)
    }

    fn label(&mut self) -> Label {
        self.function.labels += 1;
        Label(self.function.labels - 1)
    }

    fn get(&mut self, variable: Variable) -> Value {
        let to = self.value(self.function.variable_types[variable.0 as usize]);
        self.push(Instruction::Get { to, variable });
        to
    }

    fn set_constant(&mut self, variable: Variable, bits: u32) {
        let value = self.constant(bits);
        self.push(Instruction::Set { variable, value });
    }

    fn constant(&mut self, bits: u32) -> Value {
        let to = self.value(Type::I32);
        let ty = Type::I32;
        self.push(Instruction::Constant { to, ty, bits });
        to
    }

    fn store(&mut self, base: Value, offset: u32, value: Value) {
        let ty = self.function.value_types[value.0 as usize];
        self.push(Instruction::Store {
            base,
            offset: offset as i32,
            value,
            ty,
            memory: Memory::Plain,
        });
    }

    fn load(&mut self, base: Value, offset: u32, ty: Type) -> Value {
        let to = self.value(ty);
        self.push(Instruction::Load {
            to,
            ty,
            base,
            offset: offset as i32,
            memory: Memory::Plain,
        });
        to
    }

    fn write(&mut self, old: Vec<Instruction>, live: &[Vec<Variable>]) {
        let (start, ended) = (self.label(), self.label());
        let resumes: Vec<Label> = live.iter().map(|_| self.label()).collect();
        let mut barriers = live.iter().zip(&resumes).zip(1..);
        let mut in_tail = false;
        self.set_constant(self.waits, 0);
        for mut instruction in old {
            match instruction {
                Instruction::Label(label) if label == self.points.head => {
                    self.push(instruction);
                    self.head(start, &resumes);
                    continue;
                }
                Instruction::Label(label) if label == self.points.next => {
                    self.end(ended);
                    in_tail = true;
                }
                Instruction::Label(label) if label == self.points.done => {
                    self.push(instruction);
                    self.round();
                    continue;
                }
                Instruction::StackAddress { to, offset } => {
                    let base = self.get(self.frame);
                    instruction = Instruction::Offset {
                        to,
                        base,
                        bytes: (self.stack_at + offset) as i32,
                    };
                }
                Instruction::Barrier => {
                    if let Some(((live, &resume), number)) = barriers.next() {
                        self.wait(live, resume, number);
                    }
                    continue;
                }
                _ if !in_tail => instruction.retarget(self.points.next, ended),
                _ => {}
            }
            self.push(instruction);
        }
    }

    /// The start of an invocation: where it was, it goes on.
    fn head(&mut self, start: Label, resumes: &[Label]) {
        let index = self.get(self.points.index);
        let frames = self.value(Type::Pointer);
        let scratch = self.points.scratch;
        self.push(Instruction::Offset {
            to: frames,
            base: scratch,
            bytes: self.points.frames_at as i32,
        });
        let frame = self.value(Type::Pointer);
        self.push(Instruction::Element {
            to: frame,
            base: frames,
            index,
            stride: self.frame_bytes,
        });
        let variable = self.frame;
        self.push(Instruction::Set {
            variable,
            value: frame,
        });
        let selector = self.load(frame, 0, Type::I32);
        let cases = (1..).zip(resumes.iter().copied());
        self.push(Instruction::Switch {
            selector,
            cases: [(0, start)].into_iter().chain(cases).collect(),
            default: self.points.next,
        });
        self.push(Instruction::Label(start));
    }

    fn wait(&mut self, live: &[Variable], resume: Label, number: u32) {
        let frame = self.get(self.frame);
        for &variable in live {
            let value = self.get(variable);
            self.store(frame, self.places[&variable], value);
        }
        let number = self.constant(number);
        self.store(frame, 0, number);
        self.set_constant(self.waits, 1);
        self.push(Instruction::Jump(self.points.next));
        self.push(Instruction::Label(resume));
        let frame = self.get(self.frame);
        for &variable in live {
            let ty = self.function.variable_types[variable.0 as usize];
            let value = self.load(frame, self.places[&variable], ty);
            self.push(Instruction::Set { variable, value });
        }
    }

    fn end(&mut self, ended: Label) {
        self.push(Instruction::Label(ended));
        let frame = self.get(self.frame);
        let state = self.constant(ENDED);
        self.store(frame, 0, state);
        self.push(Instruction::Jump(self.points.next));
    }

    /// All invocations have run: those that wait run again.
    fn round(&mut self) {
        let waits = self.get(self.waits);
        let none = self.constant(0);
        let condition = self.value(Type::Bool);
        self.push(Instruction::Compare {
            to: condition,
            op: Comparison::NotEqual,
            a: waits,
            b: none,
        });
        let (again, leave) = (self.label(), self.label());
        self.push(Instruction::Branch {
            condition,
            accept: again,
            reject: leave,
        });
        self.push(Instruction::Label(again));
        self.set_constant(self.waits, 0);
        self.set_constant(self.points.index, 0);
        self.push(Instruction::Jump(self.points.head));
        self.push(Instruction::Label(leave));
    }
}
