//! Programs as Rust, for the build to compile: one function of the text for each of the program's, with the same bits as
//! results as machine code that is made at run time.
//!
//! What is written expects a module `runtime` in scope with the functions of [`Runtime`](crate::ir::Runtime) by their names
//! in lower case, `AtomicU32`, `AtomicI32` and `Relaxed`. It is code for compilers, not for readers.

mod expression;
mod grouped;
mod scopes;
mod spmd;

use std::fmt::Write as _;
use std::sync::Arc;

use crate::ir::{Function, Instruction, Label, Program, Type, Value};

use expression::{at, expression, literal, store, type_name, zero};
use grouped::Grouped;
use scopes::{Home, Scope, homes, scopes};

pub use spmd::{lanes_functions, lanes_module};

/// A module of Rust with `pub unsafe extern "C" fn entry`, which has the parameters of the program's entry point: the
/// dispatch's context (`*const u64`) and scratch memory (`*mut u64`), and the workgroup's place (three `u32`). `attributes` stand before
/// each function.
///
/// None for what isn't written this way: programs with barriers, whose invocations change places.
pub fn module(program: &Program, attributes: &str) -> Option<String> {
    let mut text = String::new();
    let mut words = Vec::new();
    for (index, function) in program.functions.iter().enumerate() {
        text.push_str(&Writer::new(function, &mut words)?.function(index, attributes));
    }
    tables(&mut text, &words);
    let _ = writeln!(
        text,
        "{attributes}\npub unsafe extern \"C\" fn entry(p0: *const u64, p1: *mut u64, p2: u32, p3: u32, p4: u32) {{\n\
         unsafe {{ f0(p0.cast_mut().cast(), p1.cast(), p2, p3, p4) }}\n}}"
    );
    Some(text)
}

/// A module of Rust with `pub unsafe extern "C" fn eN` for each function N of the program but its entry point, which has that
/// function's parameters: floats, words, and addresses as `*mut u8`. `attributes` stand before each function. With
/// `in_lanes`, calls of small functions that don't wait for one another are done at once, by AVX2: then the intrinsics of
/// x86-64 must be in scope, and the attributes ask for it.
///
/// None for what isn't written this way.
pub fn functions(program: &Program, attributes: &str, in_lanes: bool) -> Option<String> {
    let mut text = String::new();
    let mut words = Vec::new();
    for (index, function) in program.functions.iter().enumerate().skip(1) {
        // How a byte that is a condition is passed, platforms see differently.
        if function.parameters.contains(&Type::Bool) {
            return None;
        }
        let grouped = in_lanes.then(|| Grouped::new(program, function));
        let ordered = grouped.as_ref().map(|grouped| Function {
            instructions: grouped.instructions.clone(),
            ..function.clone()
        });
        let mut writer = Writer::new(ordered.as_ref().unwrap_or(function), &mut words)?;
        writer.grouped = grouped.as_ref().map(|grouped| (grouped, program));
        text.push_str(&writer.function(index, attributes));
        if in_lanes {
            text.push_str(&grouped::functions(program, index, attributes));
        }
        let parameters = parameters(function);
        let names: Vec<String> = (0..function.parameters.len())
            .map(|index| format!("p{index}"))
            .collect();
        let _ = writeln!(
            text,
            "{attributes}\npub unsafe extern \"C\" fn e{index}({parameters}) {{ unsafe {{ f{index}({}) }} }}",
            names.join(", ")
        );
    }
    tables(&mut text, &words);
    Some(text)
}

fn parameters(function: &Function) -> String {
    let parameters: Vec<String> = (function.parameters.iter().enumerate())
        .map(|(index, &ty)| format!("p{index}: {}", type_name(ty)))
        .collect();
    parameters.join(", ")
}

/// Of each value that is written where it is used, how; `words` are the tables of all functions, by number.
fn constants(function: &Function, words: &mut Vec<Arc<[u32]>>) -> Vec<Option<String>> {
    let mut constants = vec![None; function.value_types.len()];
    for instruction in &function.instructions {
        match instruction {
            Instruction::Constant { to, ty, bits } => {
                constants[to.0 as usize] = Some(literal(*ty, *bits));
            }
            Instruction::Words { to, words: table } => {
                words.push(Arc::clone(table));
                let name = format!("((&raw const T{}) as *mut u8)", words.len() - 1);
                constants[to.0 as usize] = Some(name);
            }
            _ => {}
        }
    }
    constants
}

fn tables(text: &mut String, words: &[Arc<[u32]>]) {
    for (index, words) in words.iter().enumerate() {
        let _ = writeln!(
            text,
            "static T{index}: [u32; {}] = {:?};",
            words.len(),
            words
        );
    }
}

struct Writer<'a> {
    function: &'a Function,
    positions: Vec<usize>,
    scopes: Vec<Scope>,
    homes: Vec<Home>,
    /// Values that are written where they are used.
    constants: Vec<Option<String>>,
    /// What is done in lanes, of which program.
    grouped: Option<(&'a Grouped, &'a Program)>,
    text: String,
}

impl<'a> Writer<'a> {
    /// `words` are the tables of all functions, by number.
    fn new(function: &'a Function, words: &mut Vec<Arc<[u32]>>) -> Option<Self> {
        let positions = function.positions();
        let scopes = scopes(function, &positions)?;
        let homes = homes(function, &scopes);
        if function.instructions.contains(&Instruction::Barrier) {
            return None;
        }
        let constants = constants(function, words);
        Some(Self {
            function,
            positions,
            scopes,
            homes,
            constants,
            grouped: None,
            text: String::new(),
        })
    }

    fn function(mut self, index: usize, attributes: &str) -> String {
        let function = self.function;
        let parameters = parameters(function);
        self.line(&format!(
            "{attributes}\nunsafe fn f{index}({parameters}) {{ unsafe {{"
        ));
        for (index, &ty) in function.variable_types.iter().enumerate() {
            self.line(&format!("let mut x{index} = {};", zero(ty)));
        }
        let longs = function.stack_bytes.div_ceil(8).max(1);
        self.line(&format!(
            "let mut stack = core::mem::MaybeUninit::<[u64; {longs}]>::uninit();"
        ));
        self.declare(None);
        let mut open: Vec<usize> = Vec::new();
        let mut next = 0;
        for position in 0..=function.instructions.len() {
            while let Some(&inner) = open.last().filter(|&&s| self.scopes[s].end <= position) {
                let scope = self.scopes[inner];
                if scope.is_loop {
                    // What ends here has jumped already.
                    self.line(&format!("break 'l{};", scope.label.0));
                }
                self.line("}");
                open.pop();
            }
            let Some(instruction) = function.instructions.get(position) else {
                break;
            };
            while next < self.scopes.len() && self.scopes[next].start == position {
                let scope = self.scopes[next];
                match scope.is_loop {
                    true => self.line(&format!("'l{}: loop {{", scope.label.0)),
                    false => self.line(&format!("'b{}: {{", scope.label.0)),
                }
                self.declare(Some(next));
                open.push(next);
                next += 1;
            }
            self.instruction(position, instruction);
        }
        self.line("} }");
        self.text
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// Values that are made in a scope within this one, and used behind it.
    fn declare(&mut self, scope: Option<usize>) {
        for value in 0..self.homes.len() {
            let home = self.homes[value];
            let is_early = home.is_used && home.declared == scope && home.declared != home.made;
            if is_early && self.constants[value].is_none() {
                let ty = type_name(self.function.value_types[value]);
                self.line(&format!("let v{value}: {ty};"));
            }
        }
    }

    fn name(&self, value: Value) -> String {
        let constant = self.constants[value.0 as usize].clone();
        constant.unwrap_or_else(|| format!("v{}", value.0))
    }

    /// A jump from an instruction; nothing where the label comes next.
    fn go(&self, position: usize, label: Label) -> String {
        let target = self.positions[label.0 as usize];
        match target {
            _ if target == position + 1 => String::new(),
            _ if target > position => format!("break 'b{};", label.0),
            _ => format!("continue 'l{};", label.0),
        }
    }

    fn instruction(&mut self, position: usize, instruction: &Instruction) {
        let name = |value: Value| self.name(value);
        let grouped = self.grouped.and_then(|(grouped, program)| {
            (grouped.others.contains(&position))
                .then(String::new)
                .or_else(|| grouped.call(position, program, &name))
        });
        if let Some(line) = grouped {
            self.line(&line);
            return;
        }
        let line = match *instruction {
            Instruction::Constant { .. }
            | Instruction::Words { .. }
            | Instruction::Label(_)
            | Instruction::Barrier => return,
            Instruction::Store {
                base,
                offset,
                value,
                ty,
                memory,
            } => store(ty, &at(&name(base), offset), &name(value), memory),
            Instruction::Set { variable, value } => {
                format!("x{} = {};", variable.0, name(value))
            }
            Instruction::Call {
                callee,
                ref arguments,
            } => {
                let arguments: Vec<String> = arguments.iter().map(|&a| name(a)).collect();
                let callee = self.function.callees[callee as usize];
                format!("f{callee}({});", arguments.join(", "))
            }
            Instruction::Jump(label) => self.go(position, label),
            Instruction::Branch {
                condition,
                accept,
                reject,
            } => {
                let condition = name(condition);
                let (accept, reject) = (self.go(position, accept), self.go(position, reject));
                match (accept.is_empty(), reject.is_empty()) {
                    (true, _) => format!("if !{condition} {{ {reject} }}"),
                    (_, true) => format!("if {condition} {{ {accept} }}"),
                    _ => format!("if {condition} {{ {accept} }} else {{ {reject} }}"),
                }
            }
            Instruction::Switch {
                selector,
                ref cases,
                default,
            } => {
                let mut text = format!("match {} {{ ", name(selector));
                for &(value, label) in cases {
                    let _ = write!(text, "{value}u32 => {{ {} }} ", self.go(position, label));
                }
                let _ = write!(text, "_ => {{ {} }} }}", self.go(position, default));
                text
            }
            Instruction::Return => "return;".to_owned(),
            _ => {
                let read = instruction.result().and_then(|value| {
                    let ty = self.function.value_types[value.0 as usize];
                    self.grouped?.0.read(value, ty)
                });
                let Some(made) = read.or_else(|| expression(instruction, &name)) else {
                    return;
                };
                match instruction.result() {
                    None => format!("{made};"),
                    Some(value) => {
                        let home = self.homes[value.0 as usize];
                        let has_effect = matches!(
                            instruction,
                            Instruction::Atomic { .. }
                                | Instruction::CompareExchange { .. }
                                | Instruction::CallRuntime { .. }
                        );
                        match (home.is_used, has_effect, home.declared == home.made) {
                            (false, false, _) => return,
                            (false, true, _) => format!("{made};"),
                            (true, _, true) => format!("let v{} = {made};", value.0),
                            (true, _, false) => format!("v{} = {made};", value.0),
                        }
                    }
                }
            }
        };
        self.line(&line);
    }
}
