//! Whole kernels with eight invocations at once, in the lanes of vectors.
//!
//! How blocks run, [`crate::lanes`] decides. Every lane computes what the scalar code does, operation
//! by operation, so the bits are the same; only the order in which invocations meet in atomic operations is another.

mod memory;
mod operations;

use std::fmt::Write as _;
use std::sync::Arc;

use super::{
    constants,
    expression::{expression, type_name},
    tables,
};
use crate::{
    ir::{Function, Instruction, Program, Type, Value, Variable},
    lanes::{Analysis, ENTRY, Groups, Kind, Passed, one_invocation, pointer},
};
use operations::{call, of_words, select, snake, to_words, vector, zero};

/// Lanes of a vector.
const LANES: u32 = 8;

/// As [`super::module`], with eight invocations at a time. What is written expects, beside what that does, a module `lanes` in
/// scope with a function for each operation on vectors of eight numbers, as the crate `kernels` has it.
///
/// None for what isn't written this way: programs with barriers or functions apart, and workgroups that aren't a
/// multiple of eight.
pub fn lanes_module(program: &Program, attributes: &str) -> Option<String> {
    let [function] = program.functions.as_slice() else {
        return None;
    };
    let invocations = program.invocations?;
    let threads: u32 = program.workgroup_size.iter().product();
    if !threads.is_multiple_of(LANES) {
        return None;
    }
    let function = one_invocation(function, &invocations)?;
    let mut words = Vec::new();
    let known = Analysis::new(&function, Some(invocations.index), &ENTRY)?;
    let entry = Called {
        program,
        passed: &ENTRY,
        index: Some(invocations.index),
    };
    let body = Writer::write(&function, known, entry, &mut words)?;
    let mut text = format!(
        "use super::lanes::*;\n{attributes}\nunsafe fn f0(p0: *mut u8, p1: *mut u8, p2: u32, p3: u32, p4: u32, first: u32) {{ unsafe {{\n{body}}} }}\n"
    );
    tables(&mut text, &words);
    let _ = writeln!(
        text,
        "{attributes}\npub unsafe extern \"C\" fn entry(p0: *const u64, p1: *mut u64, p2: u32, p3: u32, p4: u32) {{\n\
         for group in 0..{} {{ unsafe {{ f0(p0.cast_mut().cast(), p1.cast(), p2, p3, p4, {LANES} * group) }} }}\n}}",
        threads / LANES
    );
    Some(text)
}

/// A module of Rust with `pub unsafe extern "C" fn lN` for each function N of the program but its entry point, for eight calls at
/// once: it has that function's addresses as parameters, each lane's own but for the first, and last the address of rows of eight words, one for
/// each other parameter, and the mask of the lanes that call. It expects what [`lanes_module`] does.
///
/// None for what isn't written this way.
pub fn lanes_functions(program: &Program, attributes: &str) -> Option<String> {
    let mut text = "use super::lanes::*;\n".to_owned();
    let mut words = Vec::new();
    for (index, function) in program.functions.iter().enumerate().skip(1) {
        let passed = passed(function);
        let known = Analysis::new(function, None, &passed)?;
        let called = Called {
            program,
            passed: &passed,
            index: None,
        };
        let body = Writer::write(function, known, called, &mut words)?;
        let direct = addresses(function).map(|place| format!("p{place}: *mut u8, "));
        let direct: String = direct.collect();
        let _ = writeln!(
            text,
            "{attributes}\npub unsafe extern \"C\" fn l{index}({direct}rows: *const u8) {{ unsafe {{\n{body}}} }}"
        );
    }
    tables(&mut text, &words);
    Some(text)
}

/// How a function that is called in lanes gets its parameters: the dispatch's context, and what lanes have of their own.
fn passed(function: &Function) -> Vec<Passed> {
    let parameters = function.parameters.iter().enumerate();
    let passed = parameters.map(|(place, ty)| match ty {
        Type::Pointer if place == 0 => Passed::Shared,
        Type::Pointer => Passed::Own,
        _ => Passed::Lanes,
    });
    passed.collect()
}

/// The places of those of its parameters that are addresses.
fn addresses(function: &Function) -> impl Iterator<Item = usize> {
    let parameters = function.parameters.iter().enumerate();
    parameters.filter_map(|(place, ty)| (*ty == Type::Pointer).then_some(place))
}

/// What a function has to do with others.
#[derive(Clone, Copy)]
struct Called<'a> {
    program: &'a Program,
    passed: &'a [Passed],
    /// Which invocation runs, if it is an entry point.
    index: Option<Variable>,
}

struct Writer<'a> {
    function: &'a Function,
    called: Called<'a>,
    known: Analysis,
    groups: Groups,
    /// Values that are written where they are used.
    constants: Vec<Option<String>>,
    text: String,
}

impl<'a> Writer<'a> {
    /// What stands in the braces of the function.
    fn write(
        function: &'a Function,
        known: Analysis,
        called: Called<'a>,
        words: &mut Vec<Arc<[u32]>>,
    ) -> Option<String> {
        let groups = known.groups(function);
        let constants = constants(function, words);
        let mut writer = Self {
            function,
            called,
            known,
            groups,
            constants,
            text: String::new(),
        };
        writer.body()?;
        Some(writer.text)
    }

    fn body(&mut self) -> Option<()> {
        let own = self.function.stack_bytes.div_ceil(4).max(1);
        self.line(&format!("let mut own = Own::<{own}>([[0; W]; {own}]);"));
        self.declare(None);
        match self.called.index {
            Some(_) => self.line("let m = all();"),
            None => self.line(&format!(
                "let m = row(rows, {});",
                self.rows_before(usize::MAX)
            )),
        }
        let mut open: Vec<usize> = Vec::new();
        let mut next = 0;
        for block in 0..=self.known.flow.count() {
            while let Some(&inner) = open.last().filter(|&&g| self.known.guards[g].end <= block) {
                let guard = self.known.guards[inner];
                if guard.is_loop {
                    self.line(&format!("if !any(m{}.now) {{ break; }}", guard.start));
                }
                self.line("}");
                open.pop();
            }
            if block == self.known.flow.count() {
                break;
            }
            while next < self.known.guards.len() && self.known.guards[next].start == block {
                let guard = self.known.guards[next];
                if guard.is_loop {
                    self.line("loop {");
                } else {
                    let test = match guard.is_tested {
                        true => format!("if any(m{block}.now) {{"),
                        false => "{".to_owned(),
                    };
                    self.line(&test);
                    self.line(&format!("let m = m{block}.now;"));
                    if self.known.flow.loops.iter().any(|l| l.head == block) {
                        self.line(&format!("m{block}.now = none();"));
                    }
                }
                self.declare(Some(next));
                open.push(next);
                next += 1;
            }
            for position in self.known.flow.range(block) {
                let instruction = &self.function.instructions[position];
                self.instruction(block, position, instruction)?;
                if ends(instruction) {
                    break;
                }
            }
        }
        Some(())
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn is_uniform(&self, value: Value) -> bool {
        self.known.kinds[value.0 as usize] == Kind::Uniform
    }

    /// What is declared at the beginning of a guard.
    fn declare(&mut self, guard: Option<usize>) {
        let mut text = String::new();
        for (value, home) in self.known.homes.values.iter().enumerate() {
            if home.at != guard || !home.is_used || self.constants[value].is_some() {
                continue;
            }
            let ty = self.function.value_types[value];
            let (ty, zero) = match self.known.kinds[value] {
                _ if home.is_local => continue,
                Kind::Uniform => (type_name(ty), super::expression::zero(ty)),
                Kind::Lanes => (vector(ty), zero(ty)),
                Kind::Pointer(pointer) if pointer.varies => ("I", "none()"),
                Kind::Pointer(_) => ("*mut u8", "core::ptr::null_mut()"),
            };
            let _ = writeln!(
                text,
                "let mut v{value} = Changing::<{ty}> {{ now: {zero} }};"
            );
        }
        for (variable, home) in self.known.homes.variables.iter().enumerate() {
            let ty = self.function.variable_types[variable];
            let is_index = self.called.index == Some(Variable(variable as u32));
            if *home == Some(guard) && !is_index {
                let (ty, zero) = match self.known.uniform[variable] {
                    true => (type_name(ty), super::expression::zero(ty)),
                    false => (vector(ty), zero(ty)),
                };
                let _ = writeln!(
                    text,
                    "let mut x{variable} = Changing::<{ty}> {{ now: {zero} }};"
                );
            }
        }
        for (block, home) in self.known.homes.masks.iter().enumerate() {
            if *home == guard && self.known.roots[block] == block && block > 0 {
                let _ = writeln!(text, "let mut m{block} = Changing::<M> {{ now: none() }};");
            }
        }
        self.text.push_str(&text);
    }

    /// A value as it is: a scalar, a vector, an address, or bytes behind one.
    fn name(&self, value: Value) -> String {
        let constant = self.constants[value.0 as usize].clone();
        constant.unwrap_or_else(
            || match self.known.homes.values[value.0 as usize].is_local {
                true => format!("v{}", value.0),
                false => format!("v{}.now", value.0),
            },
        )
    }

    /// A value as a vector.
    fn lanes(&self, value: Value) -> String {
        let name = self.name(value);
        match (
            self.is_uniform(value),
            self.function.value_types[value.0 as usize],
        ) {
            (true, Type::F32) => format!("floats({name})"),
            (true, Type::Bool) => format!("mask({name})"),
            (true, Type::I32) => format!("words({name})"),
            _ => name,
        }
    }

    /// Lets lanes wait for a block: nothing where all of the guard's lanes go there.
    fn go(&self, block: usize, mask: &str) -> String {
        match self.known.roots[block] == block {
            true => format!("m{block}.now = or(m{block}.now, {mask});"),
            false => String::new(),
        }
    }

    fn instruction(
        &mut self,
        block: usize,
        position: usize,
        instruction: &Instruction,
    ) -> Option<()> {
        let line = match *instruction {
            Instruction::Constant { .. } | Instruction::Words { .. } | Instruction::Label(_) => {
                return Some(());
            }
            Instruction::Barrier => return None,
            Instruction::Call {
                callee,
                ref arguments,
            } => self.call(callee, arguments)?,
            Instruction::Set { variable, value } => {
                let x = variable.0;
                let value = match self.known.uniform[variable.0 as usize] {
                    true => self.name(value),
                    false => self.lanes(value),
                };
                let ty = self.function.variable_types[variable.0 as usize];
                match self.known.is_free(block, variable) {
                    true => format!("x{x}.now = {value};"),
                    false => format!("x{x}.now = {}(m, {value}, x{x}.now);", select(ty)),
                }
            }
            Instruction::Jump(label) => self.go(self.known.flow.block(label), "m"),
            Instruction::Branch {
                condition,
                accept,
                reject,
            } => {
                let [accept, reject] = [accept, reject].map(|label| self.known.flow.block(label));
                let name = self.name(condition);
                match self.is_uniform(condition) {
                    true => format!(
                        "if {name} {{ {} }} else {{ {} }}",
                        self.go(accept, "m"),
                        self.go(reject, "m")
                    ),
                    false => format!(
                        "{} {}",
                        self.go(accept, &format!("and(m, {name})")),
                        self.go(reject, &format!("without(m, {name})"))
                    ),
                }
            }
            Instruction::Switch {
                selector,
                ref cases,
                default,
            } => {
                let selector = self.lanes(selector);
                let mut text = "let rest = m;".to_owned();
                for &(value, label) in cases {
                    let go = self.go(self.known.flow.block(label), "case");
                    let _ = write!(
                        text,
                        "let case = and(rest, equal({selector}, words({value}))); let rest = without(rest, case); {go}"
                    );
                }
                text + &self.go(self.known.flow.block(default), "rest")
            }
            Instruction::Return => return Some(()),
            Instruction::Load { .. }
            | Instruction::Store { .. }
            | Instruction::Atomic { .. }
            | Instruction::CompareExchange { .. }
            | Instruction::Element { .. }
            | Instruction::Offset { .. }
            | Instruction::StackAddress { .. } => return self.memory(position, instruction),
            Instruction::CallRuntime { to: None, .. } => return self.runtime_memory(instruction),
            _ => {
                let to = instruction.result()?;
                if !self.known.homes.values[to.0 as usize].is_used {
                    return Some(());
                }
                let made = self.operation(instruction)?;
                self.make(to, &made);
                return Some(());
            }
        };
        self.line(&line);
        Some(())
    }

    /// What makes a value of others.
    fn operation(&self, instruction: &Instruction) -> Option<String> {
        let to = instruction.result()?;
        if let Instruction::Get { variable, .. } = *instruction
            && Some(variable) != self.called.index
        {
            return Some(format!("x{}.now", variable.0));
        }
        if let Instruction::Parameter { index, .. } = *instruction
            && self.called.passed[index as usize] == Passed::Lanes
        {
            let row = format!("row(rows, {})", self.rows_before(index as usize));
            return Some(match self.function.value_types[to.0 as usize] {
                Type::Bool => row,
                ty => of_words(ty, &row),
            });
        }
        if self.is_uniform(to) || matches!(instruction, Instruction::Parameter { .. }) {
            return expression(instruction, &|value| self.name(value));
        }
        Some(match *instruction {
            Instruction::Get { .. } => "count_from(first)".to_owned(),
            Instruction::Unary { op, a, .. } => format!("{}({})", snake(op), self.lanes(a)),
            Instruction::Binary { op, a, b, .. } => {
                format!("{}({}, {})", snake(op), self.lanes(a), self.lanes(b))
            }
            Instruction::Compare { op, a, b, .. } => {
                format!("{}({}, {})", snake(op), self.lanes(a), self.lanes(b))
            }
            Instruction::Select {
                condition,
                accept,
                reject,
                ..
            } => {
                let (accept, reject) = (self.lanes(accept), self.lanes(reject));
                let name = self.name(condition);
                let ty = self.function.value_types[to.0 as usize];
                match self.is_uniform(condition) {
                    true => format!("if {name} {{ {accept} }} else {{ {reject} }}"),
                    false => format!("{}({name}, {accept}, {reject})", select(ty)),
                }
            }
            Instruction::CallRuntime {
                function,
                ref arguments,
                ..
            } => {
                let arguments: Vec<String> = arguments.iter().map(|&a| self.lanes(a)).collect();
                call(function, &arguments)?
            }
            _ => return None,
        })
    }

    /// How many parameters before this one have rows.
    fn rows_before(&self, parameter: usize) -> usize {
        let passed = self.called.passed.iter().take(parameter);
        passed.filter(|&&passed| passed == Passed::Lanes).count()
    }

    /// A call of another function, by the lanes that run.
    fn call(&self, callee: u32, arguments: &[Value]) -> Option<String> {
        let index = self.function.callees[callee as usize];
        let called = &self.called.program.functions[index];
        let (mut direct, mut rows) = (String::new(), Vec::new());
        for (&argument, &ty) in arguments.iter().zip(&called.parameters) {
            match ty {
                Type::Pointer => {
                    if pointer(&self.known.kinds, argument)?.varies {
                        return None;
                    }
                    direct += &format!("{}, ", self.name(argument));
                }
                Type::Bool => rows.push(self.lanes(argument)),
                ty => rows.push(to_words(ty, &self.lanes(argument))),
            }
        }
        rows.push("m".to_owned());
        let rows = rows.join(", ");
        Some(format!(
            "{{ let rows = [{rows}]; l{index}({direct}rows.as_ptr().cast()); }}"
        ))
    }

    /// Gives a value what makes it.
    fn make(&mut self, to: Value, made: &str) {
        let home = self.known.homes.values[to.0 as usize];
        let (v, ty) = (to.0, self.function.value_types[to.0 as usize]);
        let line = match (home.is_used, home.is_local) {
            (false, _) => format!("{made};"),
            (true, true) => format!("let v{v} = {made};"),
            (true, false) if home.outlives && self.known.kinds[to.0 as usize] == Kind::Lanes => {
                format!("v{v}.now = {}(m, {made}, v{v}.now);", select(ty))
            }
            (true, false) => format!("v{v}.now = {made};"),
        };
        self.line(&line);
    }
}

/// Whether nothing runs behind an instruction.
fn ends(instruction: &Instruction) -> bool {
    matches!(
        instruction,
        Instruction::Jump(_)
            | Instruction::Branch { .. }
            | Instruction::Switch { .. }
            | Instruction::Return
    )
}
