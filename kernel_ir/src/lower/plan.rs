//! What is decided before code is written: which functions get code of their own, and which variables lie in memory.

use std::collections::{HashMap, HashSet};

use naga::{
    AddressSpace, Block, EntryPoint, Expression, Function, GlobalVariable, Handle, LocalVariable,
    Module, Statement, TypeInner,
    valid::{FunctionInfo, ModuleInfo},
};

use super::types::Types;
use crate::Options;

/// Functions of more expressions than this, with all that is inlined into them, are compiled apart if they are called
/// more than once: else the size of code would grow with each level of calls.
const MOST_INLINED: usize = 3000;

/// Functions that are nested more deeply than this, in calls that are inlined and in blocks, are compiled apart: code is written by
/// recursion along both. A call counts as two blocks.
const MOST_NESTED: usize = 200;

/// Variables of more scalars than this lie in memory: each scalar would be a variable of its own.
const MOST_VARIABLES: u64 = 64;

/// What of a function lies in memory, because it is indexed at run time or pointed to by code apart.
#[derive(Debug, Clone, Default)]
pub(super) struct InMemory {
    pub(super) locals: HashSet<Handle<LocalVariable>>,
    /// Arguments that are pointers.
    pub(super) arguments: HashSet<u32>,
}

/// The decisions.
pub(super) struct Plan {
    pub(super) separate: HashSet<Handle<Function>>,
    /// Functions of the program that are called in place of the text's.
    pub(super) host: HashSet<Handle<Function>>,
    pub(super) in_memory: HashMap<Handle<Function>, InMemory>,
    pub(super) entry_in_memory: InMemory,
    /// Private variables.
    pub(super) globals_in_memory: HashSet<Handle<GlobalVariable>>,
    /// Functions that have one return, at their end.
    pub(super) straight: HashSet<Handle<Function>>,
}

type Calls = Vec<(Handle<Function>, Vec<Handle<Expression>>)>;

impl Plan {
    pub(super) fn new(
        module: &Module,
        info: &ModuleInfo,
        entry: &EntryPoint,
        entry_info: &FunctionInfo,
        options: &Options<'_>,
        types: &Types<'_>,
    ) -> Self {
        let is_host = |function: &Function| {
            let name = function.name.as_deref();
            name.is_some_and(|name| options.host.contains(&name))
        };
        let functions = module.functions.iter();
        let host: HashSet<_> = functions
            .filter(|(_, function)| is_host(function))
            .map(|(handle, _)| handle)
            .collect();
        // What the program does in their place calls nothing of the text.
        let calls: HashMap<_, Calls> = module
            .functions
            .iter()
            .map(|(handle, function)| match host.contains(&handle) {
                true => (handle, Calls::new()),
                false => (handle, calls_of(&function.body)),
            })
            .collect();
        let entry_calls = calls_of(&entry.function.body);
        let times = times_called(&calls, &entry_calls);
        let separate = separate(module, info, &calls, &times, &host, options);
        let mut plan = Self {
            in_memory: HashMap::new(),
            entry_in_memory: InMemory::default(),
            globals_in_memory: HashSet::new(),
            straight: HashSet::new(),
            separate,
            host,
        };
        // Callees come before their callers in naga's arena.
        for (handle, function) in module.functions.iter() {
            // What is never called decides nothing.
            if !times.contains_key(&handle) {
                continue;
            }
            let of = plan.variables(module, function, &info[handle], &calls[&handle], types);
            plan.in_memory.insert(handle, of);
            let ends = matches!(function.body.last(), Some(Statement::Return { .. }));
            if ends && returns_in(&function.body) == 1 {
                plan.straight.insert(handle);
            }
        }
        plan.entry_in_memory =
            plan.variables(module, &entry.function, entry_info, &entry_calls, types);
        for (handle, variable) in module.global_variables.iter() {
            if variable.space != AddressSpace::Private {
                continue;
            }
            let apart = plan.separate.iter().any(|&f| !info[f][handle].is_empty());
            let count = types.count(&module.types[variable.ty].inner);
            if apart || count > MOST_VARIABLES {
                plan.globals_in_memory.insert(handle);
            }
        }
        plan
    }

    /// Marks what of a function lies in memory, and private variables that it indexes.
    fn variables(
        &mut self,
        module: &Module,
        function: &Function,
        info: &FunctionInfo,
        calls: &Calls,
        types: &Types<'_>,
    ) -> InMemory {
        let mut found = InMemory::default();
        for (local, variable) in function.local_variables.iter() {
            if types.count(&module.types[variable.ty].inner) > MOST_VARIABLES {
                found.locals.insert(local);
            }
        }
        let is_pointer = |handle: Handle<Expression>| {
            matches!(
                info[handle].ty.inner_with(&module.types),
                TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. }
            )
        };
        for (_, expression) in function.expressions.iter() {
            if let Expression::Access { base, .. } = *expression
                && is_pointer(base)
            {
                self.mark(module, function, base, &mut found);
            }
        }
        for (callee, arguments) in calls {
            for (index, &argument) in (0..).zip(arguments) {
                let apart = self.separate.contains(callee)
                    || self.in_memory[callee].arguments.contains(&index);
                if is_pointer(argument) && apart {
                    self.mark(module, function, argument, &mut found);
                }
            }
        }
        found
    }

    /// Marks what a pointer points into.
    fn mark(
        &mut self,
        module: &Module,
        function: &Function,
        mut pointer: Handle<Expression>,
        found: &mut InMemory,
    ) {
        loop {
            match function.expressions[pointer] {
                Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => {
                    pointer = base;
                }
                Expression::LocalVariable(local) => {
                    found.locals.insert(local);
                    return;
                }
                Expression::FunctionArgument(index) => {
                    found.arguments.insert(index);
                    return;
                }
                Expression::GlobalVariable(global) => {
                    if module.global_variables[global].space == AddressSpace::Private {
                        self.globals_in_memory.insert(global);
                    }
                    return;
                }
                _ => return,
            }
        }
    }
}

/// How often each function is called, of those that the entry point reaches: by places in the text.
fn times_called(
    calls: &HashMap<Handle<Function>, Calls>,
    entry_calls: &Calls,
) -> HashMap<Handle<Function>, usize> {
    let mut times: HashMap<Handle<Function>, usize> = HashMap::new();
    let mut waiting: Vec<_> = entry_calls.iter().map(|call| call.0).collect();
    while let Some(function) = waiting.pop() {
        let called = times.entry(function).or_default();
        *called += 1;
        if *called == 1 {
            waiting.extend(calls[&function].iter().map(|call| call.0));
        }
    }
    times
}

/// Functions that get code of their own.
fn separate(
    module: &Module,
    info: &ModuleInfo,
    calls: &HashMap<Handle<Function>, Calls>,
    times: &HashMap<Handle<Function>, usize>,
    host: &HashSet<Handle<Function>>,
    options: &Options<'_>,
) -> HashSet<Handle<Function>> {
    let mut separate = HashSet::new();
    // What a call costs where it stands.
    let mut sizes: HashMap<Handle<Function>, usize> = HashMap::new();
    let mut depths: HashMap<Handle<Function>, usize> = HashMap::new();
    let mut waits = HashSet::new();
    for (handle, function) in module.functions.iter() {
        if host.contains(&handle) {
            sizes.insert(handle, 5);
            continue;
        }
        let own = function.expressions.len();
        let below: usize = calls[&handle].iter().map(|call| sizes[&call.0]).sum();
        let size = own.saturating_add(below);
        // Workgroup memory and barriers are the entry point's: what uses them is part of it.
        let of_workgroup = barrier_in(&function.body)
            || calls[&handle].iter().any(|call| waits.contains(&call.0))
            || module.global_variables.iter().any(|(global, variable)| {
                variable.space == AddressSpace::WorkGroup && !info[handle][global].is_empty()
            });
        if of_workgroup {
            waits.insert(handle);
        }
        let name = function.name.as_deref().unwrap_or_default();
        let large = size > MOST_INLINED && times.get(&handle).is_some_and(|&times| times > 1);
        let depth = nesting(&function.body, &depths);
        let is_better_apart = large || depth > MOST_NESTED || (options.separate)(name);
        let apart = !of_workgroup && times.contains_key(&handle) && is_better_apart;
        if apart {
            separate.insert(handle);
        }
        sizes.insert(handle, if apart { 5 } else { size });
        depths.insert(handle, if apart { 0 } else { depth });
    }
    separate
}

/// How deeply blocks are nested, those of calls among them: `depths` are those of functions.
fn nesting(block: &Block, depths: &HashMap<Handle<Function>, usize>) -> usize {
    let of = |statement: &Statement| match statement {
        Statement::Call { function, .. } => 2 + depths.get(function).copied().unwrap_or(0),
        _ => (blocks_of(statement).into_iter())
            .map(|inner| 1 + nesting(inner, depths))
            .max()
            .unwrap_or(0),
    };
    block.iter().map(of).max().unwrap_or(0)
}

/// The blocks within a statement.
fn blocks_of(statement: &Statement) -> Vec<&Block> {
    match statement {
        Statement::Block(block) => vec![block],
        Statement::If { accept, reject, .. } => vec![accept, reject],
        Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        Statement::Loop {
            body, continuing, ..
        } => vec![body, continuing],
        _ => Vec::new(),
    }
}

fn visit<'b>(block: &'b Block, see: &mut impl FnMut(&'b Statement)) {
    for statement in block.iter() {
        see(statement);
        for inner in blocks_of(statement) {
            visit(inner, see);
        }
    }
}

fn calls_of(block: &Block) -> Calls {
    let mut calls = Vec::new();
    visit(block, &mut |statement| {
        if let Statement::Call {
            function,
            arguments,
            ..
        } = statement
        {
            calls.push((*function, arguments.clone()));
        }
    });
    calls
}

fn returns_in(block: &Block) -> usize {
    let mut returns = 0;
    visit(block, &mut |statement| {
        returns += usize::from(matches!(statement, Statement::Return { .. }));
    });
    returns
}

fn barrier_in(block: &Block) -> bool {
    let mut found = false;
    visit(block, &mut |statement| {
        found |= matches!(
            statement,
            Statement::ControlBarrier(_) | Statement::WorkGroupUniformLoad { .. }
        );
    });
    found
}
