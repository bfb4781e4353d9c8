//! Code over scalars to machine code, by Cranelift: each function on a thread of its own, then linked.

mod function;
mod lanes;
#[cfg(not(target_family = "wasm"))]
mod link;
#[cfg(target_family = "wasm")]
#[path = "no_link.rs"]
mod link;

use std::sync::Arc;

use cranelift_codegen::{
    Context, FinalizedRelocTarget,
    binemit::Reloc,
    control::ControlPlane,
    ir::{ExternalName, LibCall},
    isa::OwnedTargetIsa,
    settings::{self, Configurable, SetError},
};
use rayon::prelude::*;

use kernel_ir::lanes::{Passed, Plan, Planned};

use super::{
    AheadFunction, CompileError, ErrorKind, Options, Statistics, ahead,
    ir::{Function, Program},
};
pub(super) use link::Code;

/// Bytes of stack that a function which was compiled before is taken to need beside its own memory.
const AHEAD_STACK: u32 = 4096;

/// Machine code of one function, wherever it will lie.
#[derive(Debug)]
pub(super) struct MachineCode {
    bytes: Vec<u8>,
    alignment: u64,
    /// Where addresses have to be put.
    places: Vec<Place>,
    /// Bytes of stack that a call takes.
    stack_bytes: u32,
    /// Words that the code points to, kept as long as the code.
    _words: Vec<Arc<[u32]>>,
}

#[derive(Debug, Clone, Copy)]
struct Place {
    offset: u32,
    kind: Reloc,
    target: Target,
    addend: i64,
}

/// What an address in machine code is that of.
#[derive(Debug, Clone, Copy)]
enum Target {
    /// By its place in the function's list of callees.
    Callee(u32),
    /// Something that this processor has no instruction for.
    Library(LibCall),
    /// The function's own code.
    Own(u32),
}

/// A function of a program.
#[derive(Debug, Clone)]
pub(super) enum Part {
    Compiled(Arc<MachineCode>),
    Ahead(&'static AheadFunction),
    /// Only what was compiled before calls it.
    Unused,
}

/// What is done about each function: those that were compiled before aren't again, nor is what they alone call.
fn parts(program: &Program, ahead: &'static [AheadFunction]) -> Vec<Option<Part>> {
    let mut parts = vec![Some(Part::Unused); program.functions.len()];
    let mut open = vec![0];
    while let Some(index) = open.pop() {
        if !matches!(parts[index], Some(Part::Unused)) {
            continue;
        }
        parts[index] = ahead::find_function(program, index, ahead).map(Part::Ahead);
        if parts[index].is_none() {
            open.extend(&program.functions[index].callees);
        }
    }
    parts
}

/// Compiles a program, as far as the cache doesn't have it.
pub(super) fn compile(
    program: &Program,
    options: &Options<'_>,
) -> Result<(Code, Statistics), CompileError> {
    for function in &program.functions {
        check_stack(u64::from(function.stack_bytes), options)?;
    }
    let isa = target().map_err(|message| refused("the kernel", message))?;
    let mut found = parts(program, options.ahead_functions);
    if let Some(cache) = options.cache {
        for (function, part) in program.functions.iter().zip(&mut found) {
            if part.is_none() {
                *part = cache.find(function, None).map(Part::Compiled);
            }
        }
    }
    let compiled = found.iter().filter(|part| part.is_none()).count();
    let parts = program
        .functions
        .par_iter()
        .zip(found)
        .map(|(function, found)| match found {
            Some(part) => Ok(part),
            None => {
                let writes = |target: &mut _| Ok(function::write(target, program, function, &*isa));
                let code = Arc::new(machine_code(function, &isa, writes)?);
                if let Some(cache) = options.cache {
                    cache.keep(function, None, &code);
                }
                Ok(Part::Compiled(code))
            }
        })
        .collect::<Result<Vec<_>, CompileError>>()?;
    if let Some(cache) = options.cache {
        cache.age();
    }
    let stack_bytes = deepest(program, &parts, 1);
    check_stack(stack_bytes, options)?;
    let codes = parts.iter().filter_map(|part| match part {
        Part::Compiled(code) => Some(code),
        Part::Ahead(_) | Part::Unused => None,
    });
    let statistics = Statistics {
        functions: codes.clone().count(),
        compiled,
        ahead: (parts.iter().filter(|part| matches!(part, Part::Ahead(_)))).count(),
        code_bytes: codes.map(|code| code.bytes.len()).sum(),
        stack_bytes: u32::try_from(stack_bytes).unwrap_or(u32::MAX),
        ..Statistics::default()
    };
    let code = link::link(program, parts, isa)?;
    Ok((code, statistics))
}

/// Compiles a program for eight invocations at once. Functions that `once` names are called once for each set of different
/// scalars that lanes have.
///
/// # Errors
/// Where it can't be done; then there is the other code.
pub(super) fn compile_lanes(
    program: &Program,
    options: &Options<'_>,
    once: &dyn Fn(&str) -> bool,
) -> Result<Code, CompileError> {
    let cannot = || refused("the kernel", "not in lanes");
    let threads: u32 = program.workgroup_size.iter().product();
    if !threads.is_multiple_of(lanes::LANES) {
        return Err(cannot());
    }
    for function in &program.functions {
        let bytes = u64::from(function.stack_bytes) * u64::from(lanes::LANES);
        check_stack(bytes, options)?;
    }
    let isa = target().map_err(|message| refused("the kernel", message))?;
    let found = parts(program, options.ahead_lanes);
    let is_there = |index: usize| matches!(found[index], Some(Part::Ahead(_)));
    let plan = Plan::new(program, &is_there, once).ok_or_else(cannot)?;
    let parts = (found.into_iter().zip(&plan.functions).enumerate())
        .map(|(index, (found, planned))| match (found, planned) {
            (Some(part), _) => Ok(part),
            (None, None) => Err(cannot()),
            (None, Some(planned)) => {
                code_in_lanes(program, &plan, index, planned, options, &isa).map(Part::Compiled)
            }
        })
        .collect::<Result<Vec<_>, CompileError>>()?;
    if let Some(cache) = options.cache {
        cache.age();
    }
    check_stack(deepest(program, &parts, lanes::LANES), options)?;
    link::link(program, parts, isa)
}

fn code_in_lanes(
    program: &Program,
    plan: &Plan,
    index: usize,
    planned: &Planned,
    options: &Options<'_>,
    isa: &OwnedTargetIsa,
) -> Result<Arc<MachineCode>, CompileError> {
    let function = &planned.function;
    // What it calls gets its parameters as the plan has it, and so does it.
    let callees = function.callees.iter();
    let passed: Vec<Vec<Passed>> = (std::iter::once(&index).chain(callees))
        .map(|&function| plan.passed[function].clone())
        .collect();
    if let Some(cache) = options.cache
        && let Some(code) = cache.find(function, Some(&passed))
    {
        return Ok(code);
    }
    let from = lanes::InLanes {
        program,
        passed: &plan.passed,
        planned,
        index,
    };
    let code = machine_code(function, isa, |target| {
        lanes::write(target, &from, &**isa)
            .map_err(|lanes::Refused| refused(&function.name, "not in lanes"))
    })?;
    let code = Arc::new(code);
    if let Some(cache) = options.cache {
        cache.keep(function, Some(&passed), &code);
    }
    Ok(code)
}

fn check_stack(bytes: u64, options: &Options<'_>) -> Result<(), CompileError> {
    let limit = options.stack_limit;
    match bytes > u64::from(limit) {
        true => Err(ErrorKind::Stack { bytes, limit }.into()),
        false => Ok(()),
    }
}

fn refused(function: &str, message: impl ToString) -> CompileError {
    ErrorKind::Code {
        function: function.to_owned(),
        message: message.to_string(),
    }
    .into()
}

/// This processor, with all that it has.
fn target() -> Result<OwnedTargetIsa, String> {
    let mut flags = settings::builder();
    let mut set = |name, value| flags.set(name, value);
    let all: Result<(), SetError> = [
        ("opt_level", "speed"),
        ("regalloc_algorithm", "backtracking"),
        ("is_pic", "false"),
        // Code may lie far from what it calls.
        ("use_colocated_libcalls", "false"),
        // What is lowered is checked by tests; the check would cost a quarter of the time.
        ("enable_verifier", if cfg!(test) { "true" } else { "false" }),
        // Nothing unwinds through kernels: what they call doesn't panic.
        ("unwind_info", "false"),
        // Frames of more than a page touch each of their pages, so that the guard page behind a stack is met.
        ("enable_probestack", "true"),
        ("probestack_strategy", "inline"),
    ]
    .into_iter()
    .try_for_each(|(name, value)| set(name, value));
    all.map_err(|error| error.to_string())?;
    cranelift_native::builder()
        .map_err(str::to_owned)?
        .finish(settings::Flags::new(flags))
        .map_err(|error| error.to_string())
}

/// Code of a function that `writes` has written.
fn machine_code(
    function: &Function,
    isa: &OwnedTargetIsa,
    writes: impl FnOnce(&mut cranelift_codegen::ir::Function) -> Result<Vec<Arc<[u32]>>, CompileError>,
) -> Result<MachineCode, CompileError> {
    let mut context = Context::new();
    let words = writes(&mut context.func)?;
    context
        .compile(&**isa, &mut ControlPlane::default())
        .map_err(|error| refused(&function.name, format!("{:?}", error.inner)))?;
    let failed = || refused(&function.name, "no code");
    let code = context.compiled_code().ok_or_else(failed)?;
    let frame = code.buffer.frame_layout();
    let places = code
        .buffer
        .relocs()
        .iter()
        .map(|place| {
            let target = match &place.target {
                FinalizedRelocTarget::ExternalName(ExternalName::User(name)) => {
                    Target::Callee(context.func.params.user_named_funcs()[*name].index)
                }
                FinalizedRelocTarget::ExternalName(ExternalName::LibCall(call)) => {
                    Target::Library(*call)
                }
                FinalizedRelocTarget::Func(offset) => Target::Own(*offset),
                other => return Err(refused(&function.name, format!("{other:?}"))),
            };
            Ok(Place {
                offset: place.offset,
                kind: place.kind,
                target,
                addend: place.addend,
            })
        })
        .collect::<Result<_, _>>()?;
    Ok(MachineCode {
        bytes: code.code_buffer().to_vec(),
        alignment: u64::from(code.buffer.alignment).max(32),
        places,
        // With what a call itself puts there.
        stack_bytes: frame.map_or(function.stack_bytes, |frame| frame.frame_to_fp_offset) + 64,
        _words: words,
    })
}

/// Bytes of stack that the deepest chain of calls takes, from the kernel on, with so many invocations at once.
fn deepest(program: &Program, parts: &[Part], invocations: u32) -> u64 {
    fn below(
        index: usize,
        program: &Program,
        parts: &[Part],
        invocations: u32,
        known: &mut [Option<u64>],
    ) -> u64 {
        if let Some(known) = known[index] {
            return known;
        }
        // No function of WGSL calls itself, so this ends.
        let callees = program.functions[index].callees.iter();
        let deepest = callees.map(|&callee| below(callee, program, parts, invocations, known));
        let own = match &parts[index] {
            Part::Compiled(code) => code.stack_bytes,
            // Nobody tells; those functions are small.
            Part::Ahead(_) | Part::Unused => {
                invocations * (program.functions[index].stack_bytes + AHEAD_STACK)
            }
        };
        let sum = u64::from(own) + deepest.max().unwrap_or(0);
        known[index] = Some(sum);
        sum
    }
    let mut known = vec![None; parts.len()];
    below(0, program, parts, invocations, &mut known)
}
