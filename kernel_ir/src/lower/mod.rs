//! naga's module to code over scalars.

mod access;
mod atomic;
mod barrier;
mod emit;
mod entry;
mod expression;
mod fold;
mod function;
mod global;
mod image;
mod math;
mod operator;
mod overrides;
mod place;
mod plan;
mod statement;
mod types;

use std::collections::HashMap;

use naga::{
    Function, GlobalVariable, Handle, Module, ShaderStage,
    valid::{FunctionInfo, ModuleInfo},
};

use crate::{
    Binding, CompileError, ErrorKind, Options,
    ir::{Label, Program, Value},
};
use emit::{Emitter, Known};
use global::GlobalPlace;
use plan::Plan;
use types::Types;

pub use overrides::with_constants;

fn entry_index(module: &Module, entry: &str) -> Result<usize, CompileError> {
    module
        .entry_points
        .iter()
        .position(|e| e.name == entry && e.stage == ShaderStage::Compute)
        .ok_or_else(|| ErrorKind::NoEntryPoint(entry.to_owned()).into())
}

/// Where `break` and `continue` lead to, and how often they do.
struct Targets {
    exit: Label,
    exits: u32,
    /// None in a switch.
    next: Option<Label>,
}

/// A program that is being written.
struct Lowering<'m> {
    module: &'m Module,
    info: &'m ModuleInfo,
    options: &'m Options<'m>,
    types: Types<'m>,
    plan: Plan,
    globals: HashMap<Handle<GlobalVariable>, GlobalPlace>,
    bindings: Vec<Binding>,
    private_bytes: u64,
    workgroup_bytes: u64,
    /// Functions apart that are called, by their numbers in the program.
    numbers: HashMap<Handle<Function>, usize>,
    waiting: Vec<Handle<Function>>,
    // Of the function that is being written:
    code: Emitter,
    context: Value,
    private: Value,
    scratch: Option<Value>,
    targets: Vec<Targets>,
}

/// Lowers one entry point of a module without overrides.
pub fn lower(
    module: &Module,
    info: &ModuleInfo,
    entry: &str,
    options: &Options<'_>,
) -> Result<Program, CompileError> {
    let index = entry_index(module, entry)?;
    let (entry, entry_info) = (&module.entry_points[index], info.get_entry_point(index));
    let types = Types::new(module);
    let plan = Plan::new(module, info, entry, entry_info, options, &types);
    let mut lowering = Lowering {
        module,
        info,
        options,
        types,
        plan,
        globals: HashMap::new(),
        bindings: Vec::new(),
        private_bytes: 0,
        workgroup_bytes: 0,
        numbers: HashMap::new(),
        waiting: Vec::new(),
        code: Emitter::default(),
        context: Value(0),
        private: Value(0),
        scratch: None,
        targets: Vec::new(),
    };
    lowering.program(entry, entry_info)
}

impl<'m> Lowering<'m> {
    fn program(
        &mut self,
        entry: &'m naga::EntryPoint,
        info: &'m FunctionInfo,
    ) -> Result<Program, CompileError> {
        self.place_globals(info)?;
        let (scratch_bytes, invocations) = self.entry(entry, info)?;
        let mut functions = vec![std::mem::take(&mut self.code.function)];
        let mut numbered = Vec::new();
        while let Some(handle) = self.waiting.pop() {
            self.function(handle)?;
            let function = std::mem::take(&mut self.code.function);
            numbered.push((self.numbers[&handle], function));
        }
        numbered.sort_unstable_by_key(|(number, _)| *number);
        functions.extend(numbered.into_iter().map(|(_, function)| function));
        Ok(Program {
            functions,
            bindings: std::mem::take(&mut self.bindings),
            workgroup_size: entry.workgroup_size,
            scratch_bytes,
            invocations,
        })
    }

    /// Starts a function; its parameters are the values that come back.
    fn begin(&mut self, name: &str, parameters: &[crate::ir::Type]) -> Vec<Value> {
        let (code, values) = Emitter::begin(name, parameters);
        self.code = code;
        self.scratch = None;
        self.targets.clear();
        values
    }

    /// What is known of variables, to come back to.
    fn known(&self) -> Known {
        self.code.known.clone()
    }
}
