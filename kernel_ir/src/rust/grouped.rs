//! Calls of one small function with different arguments, done at once in the lanes of a vector: the corners of a noise's cell are
//! independent of each other. Each lane computes what the scalar function does, operation by operation, so the bits are the same.
//!
//! The vectors are those of AVX2: four or eight lanes.

use std::collections::HashMap;
use std::fmt::Write as _;

use crate::ir::{Binary, Function, Instruction, Memory, Program, Type, Unary, Value};

/// Fewer calls than this stay what they are.
const FEWEST: usize = 3;

/// Whether a function can be done in lanes: it computes scalars from its arguments, without branches or memory.
pub(super) fn is_possible(program: &Program, index: usize) -> bool {
    lanes_of(program, index, &WIDE).is_some()
}

/// The function for eight lanes and for four, or nothing.
pub(super) fn functions(program: &Program, index: usize, attributes: &str) -> String {
    let written = [&WIDE, &NARROW].map(|shape| lanes_of(program, index, shape));
    let mut text = String::new();
    for written in written.into_iter().flatten() {
        let _ = writeln!(text, "{attributes}\n{written}");
    }
    text
}

/// A number of lanes, as intrinsics call it.
struct Shape {
    lanes: usize,
    prefix: &'static str,
    float: &'static str,
    word: &'static str,
    bits: &'static str,
}

const WIDE: Shape = Shape {
    lanes: 8,
    prefix: "_mm256",
    float: "__m256",
    word: "__m256i",
    bits: "si256",
};

const NARROW: Shape = Shape {
    lanes: 4,
    prefix: "_mm",
    float: "__m128",
    word: "__m128i",
    bits: "si128",
};

impl Shape {
    fn type_name(&self, ty: Type) -> Option<&'static str> {
        match ty {
            Type::F32 => Some(self.float),
            Type::I32 => Some(self.word),
            Type::Bool | Type::Pointer => None,
        }
    }

    fn splat(&self, ty: Type, bits: u32) -> String {
        let prefix = self.prefix;
        match ty {
            Type::F32 => format!("{prefix}_set1_ps(f32::from_bits({bits}u32))"),
            _ => format!("{prefix}_set1_epi32({bits}u32 as i32)"),
        }
    }
}

/// The text of a function for so many lanes: floats and words in, a tuple of results out.
fn lanes_of(program: &Program, index: usize, shape: &Shape) -> Option<String> {
    let function = &program.functions[index];
    let mut writer = LaneWriter {
        shape,
        function,
        constants: HashMap::new(),
        small: vec![false; function.value_types.len()],
        text: String::new(),
        results: Vec::new(),
    };
    let types = |types: &[Type]| {
        let types = types.iter().map(|&ty| shape.type_name(ty));
        types.collect::<Option<Vec<_>>>()
    };
    let parameters = types(function.parameters.get(3..)?)?;
    let mut at = 0;
    while let Some(instruction) = function.instructions.get(at) {
        at += 1;
        if let Instruction::Call { callee, arguments } = instruction {
            let callee = function.callees[*callee as usize];
            is_possible(program, callee).then_some(())?;
            let arguments = arguments[3..].iter().map(|&value| writer.name(value));
            let arguments: Vec<String> = arguments.collect();
            let lanes = shape.lanes;
            let call = format!("let t{at} = f{callee}_x{lanes}({});", arguments.join(", "));
            let _ = writeln!(writer.text, "{call}");
            let base = result_of(&function.instructions[at - 1])?;
            let made = at;
            while let Some((to, word)) = function
                .instructions
                .get(at)
                .and_then(|next| loaded(next, base))
            {
                let _ = writeln!(writer.text, "let v{} = t{made}.{word};", to.0);
                at += 1;
            }
            continue;
        }
        writer.instruction(instruction)?;
    }
    writer.results.sort_unstable();
    let results: Vec<String> = (writer.results.iter().enumerate())
        .map(|(word, (place, value))| (*place == 4 * word as i32).then(|| writer.name(*value)))
        .collect::<Option<_>>()?;
    let result_types: Vec<Type> = (writer.results.iter())
        .map(|(_, value)| function.value_types[value.0 as usize])
        .collect();
    let result_types = types(&result_types)?;
    let parameters: Vec<String> = (3..)
        .zip(parameters)
        .map(|(index, ty)| format!("p{index}: {ty}"))
        .collect();
    let mut text = format!(
        "unsafe fn f{index}_x{}({}) -> ({},) {{ unsafe {{\n",
        shape.lanes,
        parameters.join(", "),
        result_types.join(", "),
    );
    text += &writer.text;
    let _ = writeln!(text, "({},)\n}} }}", results.join(", "));
    Some(text)
}

/// Where a call's result goes.
fn result_of(call: &Instruction) -> Option<Value> {
    match call {
        Instruction::Call { arguments, .. } => arguments.get(2).copied(),
        _ => None,
    }
}

/// A scalar that is read of a result, and which.
fn loaded(instruction: &Instruction, base: Value) -> Option<(Value, u32)> {
    match *instruction {
        Instruction::Load {
            to,
            base: from,
            offset,
            ..
        } if from == base => Some((to, offset as u32 / 4)),
        _ => None,
    }
}

struct LaneWriter<'a> {
    shape: &'a Shape,
    function: &'a Function,
    constants: HashMap<Value, u32>,
    /// Words whose highest bit isn't set.
    small: Vec<bool>,
    text: String,
    /// By their places.
    results: Vec<(i32, Value)>,
}

impl LaneWriter<'_> {
    fn name(&self, value: Value) -> String {
        match self.constants.get(&value) {
            Some(&bits) => (self.shape).splat(self.function.value_types[value.0 as usize], bits),
            None => format!("v{}", value.0),
        }
    }

    /// None where there is no such operation on vectors.
    fn instruction(&mut self, instruction: &Instruction) -> Option<()> {
        let (to, made) = match *instruction {
            Instruction::Constant { to, ty, bits } => {
                self.shape.type_name(ty)?;
                self.constants.insert(to, bits);
                self.small[to.0 as usize] = bits >> 31 == 0;
                return Some(());
            }
            // Addresses: of the results, and of what isn't used.
            Instruction::Parameter { index: 0..3, .. } | Instruction::StackAddress { .. } => {
                return Some(());
            }
            Instruction::Parameter { to, index } => (to, format!("p{index}")),
            Instruction::Unary { to, op, a } => (to, self.unary(op, a)?),
            Instruction::Binary { to, op, a, b } => (to, self.binary(to, op, a, b)?),
            Instruction::Store {
                base,
                offset,
                value,
                memory: Memory::Plain,
                ..
            } if self.is_result(base) => {
                self.results.push((offset, value));
                return Some(());
            }
            Instruction::Return => return Some(()),
            _ => return None,
        };
        let _ = writeln!(self.text, "let v{} = {made};", to.0);
        Some(())
    }

    fn is_result(&self, base: Value) -> bool {
        let mut instructions = self.function.instructions.iter();
        instructions.any(|instruction| {
            matches!(instruction, Instruction::Parameter { to, index: 2 } if *to == base)
        })
    }

    fn unary(&self, op: Unary, a: Value) -> Option<String> {
        let Shape { prefix, bits, .. } = *self.shape;
        let name = self.name(a);
        Some(match op {
            Unary::FloatNegate => {
                format!("{prefix}_xor_ps({name}, {prefix}_set1_ps(-0.0))")
            }
            Unary::FloatAbs => format!("{prefix}_andnot_ps({prefix}_set1_ps(-0.0), {name})"),
            Unary::Sqrt => format!("{prefix}_sqrt_ps({name})"),
            Unary::Floor => format!("{prefix}_floor_ps({name})"),
            Unary::SignedToFloat => format!("{prefix}_cvtepi32_ps({name})"),
            Unary::UnsignedToFloat if self.small[a.0 as usize] => {
                format!("{prefix}_cvtepi32_ps({name})")
            }
            Unary::FloatBits => format!("{prefix}_castps_{bits}({name})"),
            Unary::BitsToFloat => format!("{prefix}_cast{bits}_ps({name})"),
            _ => return None,
        })
    }

    fn binary(&mut self, to: Value, op: Binary, a: Value, b: Value) -> Option<String> {
        let Shape { prefix, bits, .. } = *self.shape;
        let small = |value: Value| self.small[value.0 as usize];
        self.small[to.0 as usize] = match op {
            Binary::And => small(a) || small(b),
            Binary::Or | Binary::Xor => small(a) && small(b),
            Binary::UnsignedShiftRight => self.constants.get(&b).is_some_and(|b| b % 32 > 0),
            _ => false,
        };
        if let (Binary::ShiftLeft | Binary::UnsignedShiftRight, Some(by)) =
            (op, self.constants.get(&b))
        {
            let direction = if op == Binary::ShiftLeft { "l" } else { "r" };
            let by = by % 32;
            return Some(format!(
                "{prefix}_s{direction}li_epi32::<{by}>({})",
                self.name(a)
            ));
        }
        let (a, b) = (self.name(a), self.name(b));
        let low = |b: &str| format!("{prefix}_and_{bits}({b}, {prefix}_set1_epi32(31))");
        Some(match op {
            Binary::FloatAdd => format!("{prefix}_add_ps({a}, {b})"),
            Binary::FloatSubtract => format!("{prefix}_sub_ps({a}, {b})"),
            Binary::FloatMultiply => format!("{prefix}_mul_ps({a}, {b})"),
            Binary::FloatDivide => format!("{prefix}_div_ps({a}, {b})"),
            Binary::FloatMin => format!("{prefix}_min_ps({a}, {b})"),
            Binary::FloatMax => format!("{prefix}_max_ps({a}, {b})"),
            Binary::Add => format!("{prefix}_add_epi32({a}, {b})"),
            Binary::Subtract => format!("{prefix}_sub_epi32({a}, {b})"),
            Binary::Multiply => format!("{prefix}_mullo_epi32({a}, {b})"),
            Binary::And => format!("{prefix}_and_{bits}({a}, {b})"),
            Binary::Or => format!("{prefix}_or_{bits}({a}, {b})"),
            Binary::Xor => format!("{prefix}_xor_{bits}({a}, {b})"),
            Binary::ShiftLeft => format!("{prefix}_sllv_epi32({a}, {})", low(&b)),
            Binary::UnsignedShiftRight => format!("{prefix}_srlv_epi32({a}, {})", low(&b)),
            _ => return None,
        })
    }
}

/// Calls that are done at once.
struct Group {
    /// Arguments of each call, without addresses.
    calls: Vec<Vec<Value>>,
    callee: usize,
}

/// A function's instructions in an order in which calls that can be done at once stand together.
pub(super) struct Grouped {
    pub(super) instructions: Vec<Instruction>,
    /// By the place of the first call of each.
    groups: HashMap<usize, Group>,
    /// Places of the other calls.
    pub(super) others: Vec<usize>,
    /// What is read of their results: place of the group, word, lane.
    reads: HashMap<Value, (usize, u32, usize)>,
}

/// Something that may change places with others of its segment.
struct Item {
    instructions: Vec<Instruction>,
    /// The function that it calls.
    callee: Option<usize>,
    level: usize,
}

impl Grouped {
    pub(super) fn new(program: &Program, function: &Function) -> Self {
        let mut grouped = Self {
            instructions: Vec::new(),
            groups: HashMap::new(),
            others: Vec::new(),
            reads: HashMap::new(),
        };
        let mut items: Vec<Item> = Vec::new();
        // How many calls stand one after the other before a value is there.
        let mut levels = vec![0; function.value_types.len()];
        let mut rest = function.instructions.as_slice();
        while let Some((instruction, behind)) = rest.split_first() {
            rest = behind;
            let mut taken = instruction.clone();
            let operands = taken.operands();
            let below = (operands.iter())
                .map(|value| levels[value.0 as usize])
                .max()
                .unwrap_or(0);
            match instruction {
                Instruction::Call { callee, .. }
                    if is_possible(program, function.callees[*callee as usize]) =>
                {
                    let base = result_of(instruction).unwrap_or(Value(0));
                    let mut instructions = vec![instruction.clone()];
                    while let Some((next, behind)) = rest.split_first()
                        && let Some((to, _)) = loaded(next, base)
                    {
                        levels[to.0 as usize] = below + 1;
                        instructions.push(next.clone());
                        rest = behind;
                    }
                    items.push(Item {
                        instructions,
                        callee: Some(function.callees[*callee as usize]),
                        level: below,
                    });
                }
                Instruction::Constant { .. }
                | Instruction::Words { .. }
                | Instruction::Parameter { .. }
                | Instruction::StackAddress { .. }
                | Instruction::Unary { .. }
                | Instruction::Binary { .. }
                | Instruction::Compare { .. }
                | Instruction::Select { .. }
                | Instruction::Element { .. }
                | Instruction::Offset { .. }
                | Instruction::Get { .. }
                | Instruction::Load {
                    memory: Memory::Constant,
                    ..
                } => {
                    if let Some(made) = instruction.result() {
                        levels[made.0 as usize] = below;
                    }
                    items.push(Item {
                        instructions: vec![instruction.clone()],
                        callee: None,
                        level: below,
                    });
                }
                _ => {
                    grouped.segment(std::mem::take(&mut items));
                    levels.fill(0);
                    grouped.instructions.push(instruction.clone());
                }
            }
        }
        grouped.segment(items);
        grouped
    }

    /// Puts down what has no order but that of its values: level by level, first what calls nothing.
    fn segment(&mut self, items: Vec<Item>) {
        let levels = items.iter().map(|item| item.level + 1).max().unwrap_or(0);
        let mut by_level: Vec<[Vec<Item>; 2]> = (0..levels).map(|_| Default::default()).collect();
        for item in items {
            let kind = usize::from(item.callee.is_some());
            by_level[item.level][kind].push(item);
        }
        for [plain, mut calls] in by_level {
            self.instructions
                .extend(plain.into_iter().flat_map(|item| item.instructions));
            // Stable, so that what is written doesn't change from build to build.
            calls.sort_by_key(|item| item.callee);
            for calls in calls.chunk_by(|a, b| a.callee == b.callee) {
                for calls in calls.chunks(8) {
                    self.calls(calls);
                }
            }
        }
    }

    fn calls(&mut self, calls: &[Item]) {
        let Some(callee) = calls[0].callee.filter(|_| calls.len() >= FEWEST) else {
            let instructions = calls.iter().flat_map(|item| item.instructions.clone());
            self.instructions.extend(instructions);
            return;
        };
        let place = self.instructions.len();
        let mut group = Group {
            calls: Vec::new(),
            callee,
        };
        let mut reads = Vec::new();
        for (lane, item) in calls.iter().enumerate() {
            let Some((call, loads)) = item.instructions.split_first() else {
                continue;
            };
            if let (Instruction::Call { arguments, .. }, Some(base)) = (call, result_of(call)) {
                group.calls.push(arguments[3..].to_vec());
                if lane > 0 {
                    self.others.push(place + lane);
                }
                self.instructions.push(call.clone());
                for load in loads {
                    if let Some((to, word)) = loaded(load, base) {
                        self.reads.insert(to, (place, word, lane));
                    }
                    reads.push(load.clone());
                }
            }
        }
        self.instructions.extend(reads);
        self.groups.insert(place, group);
    }

    /// What is written for the first call of a group; `types` are those of the callee's parameters behind the addresses.
    pub(super) fn call(
        &self,
        place: usize,
        program: &Program,
        name: &dyn Fn(Value) -> String,
    ) -> Option<String> {
        let group = self.groups.get(&place)?;
        let shape = if group.calls.len() > 4 {
            &WIDE
        } else {
            &NARROW
        };
        let callee = &program.functions[group.callee];
        let arguments: Vec<String> = (callee.parameters[3..].iter().enumerate())
            .map(|(parameter, &ty)| {
                // Lanes too many do what the last call does.
                let lanes = (0..shape.lanes).map(|lane| {
                    let call = &group.calls[lane.min(group.calls.len() - 1)];
                    let name = name(call[parameter]);
                    match ty {
                        Type::F32 => name,
                        _ => format!("{name} as i32"),
                    }
                });
                let lanes: Vec<String> = lanes.collect();
                let suffix = if ty == Type::F32 { "ps" } else { "epi32" };
                format!("{}_setr_{suffix}({})", shape.prefix, lanes.join(", "))
            })
            .collect();
        let lanes = shape.lanes;
        Some(format!(
            "let g{place} = f{}_x{lanes}({});",
            group.callee,
            arguments.join(", ")
        ))
    }

    /// What is written for a scalar that is read of a group's results.
    pub(super) fn read(&self, value: Value, ty: Type) -> Option<String> {
        let &(place, word, lane) = self.reads.get(&value)?;
        let lanes = if self.groups[&place].calls.len() > 4 {
            8
        } else {
            4
        };
        let ty = if ty == Type::F32 { "f32" } else { "u32" };
        Some(format!(
            "core::mem::transmute::<_, [{ty}; {lanes}]>(g{place}.{word})[{lane}]"
        ))
    }
}
