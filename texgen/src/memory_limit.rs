//! How much private memory a texture may ask for.
//!
//! GPUs keep some hundred bytes of a thread's arrays in registers; more lies in slow memory, of which each of a hundred
//! thousand threads needs its own. Software drivers (Mesa's llvmpipe) unroll every access to an element: an
//! array of 256 numbers compiles for seconds, one of 1,000 for minutes. So much is warned of, and far more is refused.

use std::collections::{BTreeSet, HashMap};
use std::ops::Range;

use naga::front::Typifier;
use naga::proc::ResolveContext;
use naga::{Expression, Function, Handle, Module, TypeInner};

use crate::diagnostic::{Diagnostic, SourceFile};
use crate::private_memory::{bytes_of, deepest, size_of};
use crate::scope::Outline;

/// More is warned of, bytes.
const MUCH: u32 = 1024;

/// More is refused, bytes.
const MOST: u32 = 16 * 1024;

/// The largest thing of a texture's that needs memory, where it is.
struct Largest {
    bytes: u32,
    span: Range<usize>,
}

/// What a texture's functions need.
pub(crate) struct Needs {
    /// Parameters and variables of all functions together.
    pub(crate) total: u32,
    /// An error or a warning.
    pub(crate) problem: Option<Diagnostic>,
}

/// Adds up parameters, variables, and tables that an index chooses from: those are copied into memory.
pub(crate) fn needs(file: &SourceFile, outline: &Outline<'_>, module: &Module) -> Needs {
    let mut sizes: HashMap<Handle<Function>, u32> = HashMap::new();
    let mut total = 0u32;
    let mut largest = Largest {
        bytes: 0,
        span: 0..0,
    };
    for (handle, function) in module.functions.iter() {
        let name = function.name.as_deref().unwrap_or_default();
        let Some(decl) = outline.function(name) else {
            continue; // of the prelude
        };
        let is_entry = name == "userProc";
        let named = bytes_of(module, function, is_entry);
        total = total.saturating_add(named);
        let tables = tables(module, function, is_entry);
        let sum = tables
            .iter()
            .map(|table| table.bytes)
            .fold(0u32, u32::saturating_add);
        sizes.insert(handle, named.saturating_add(sum));
        let variables = function
            .local_variables
            .iter()
            .map(|(variable, local)| Largest {
                bytes: size_of(module, local.ty),
                span: match function.local_variables.get_span(variable).to_range() {
                    Some(span) => span,
                    None => outline.span(decl.name),
                },
            });
        for candidate in tables.into_iter().chain(variables) {
            if candidate.bytes > largest.bytes {
                largest = candidate;
            }
        }
    }
    let (mut bytes, mut chain) = deepest(module, &sizes);
    // A function that nobody calls yet is told of as well.
    for (&function, &alone) in &sizes {
        if alone > bytes {
            bytes = alone;
            chain = module.functions[function].name.iter().cloned().collect();
        }
    }
    let chain = chain
        .iter()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ");
    let span = match outline.text.get(largest.span.clone()) {
        Some(_) if largest.bytes > 0 => largest.span,
        _ => outline
            .function("userProc")
            .map_or(0..0, |entry| outline.span(entry.name)),
    };
    let problem = match bytes {
        0..=MUCH => None,
        _ if bytes <= MOST => Some(Diagnostic::warning(format!(
            "{bytes} bytes of variables in {chain}: more than {MUCH} are slow on GPUs, and software drivers compile them for minutes"
        ))),
        _ => Some(Diagnostic::error(format!(
            "{bytes} bytes of variables in {chain}: at most {MOST} are possible"
        ))),
    };
    let problem = problem.map(|problem| {
        problem
            .with_label(file, span, format!("{} bytes", largest.bytes))
            .with_note("put tables into images, or into `array<T, N>` parameters of `userProc`, which are read in place; compute small ones")
    });
    Needs { total, problem }
}

/// The arrays without a name that a function chooses an element of by an index, with the places where it does.
fn tables(module: &Module, function: &Function, is_entry: bool) -> Vec<Largest> {
    let context =
        ResolveContext::with_locals(module, &function.local_variables, &function.arguments);
    let mut typifier = Typifier::new();
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    for (access, expression) in function.expressions.iter() {
        if typifier
            .grow(access, &function.expressions, &context)
            .is_err()
        {
            return found; // it was validated before
        }
        let &Expression::Access { base, .. } = expression else {
            continue;
        };
        // Array parameters of `userProc` are read in place; other parameters count already.
        let is_parameter = matches!(function.expressions[base], Expression::FunctionArgument(_));
        if is_parameter && is_entry {
            continue;
        }
        let inner = typifier.get(base, &module.types);
        // One constant may be used many times.
        let key = match function.expressions[base] {
            Expression::Constant(constant) => (0, constant.index()),
            Expression::ZeroValue(ty) => (1, ty.index()),
            _ => (2, base.index()),
        };
        if matches!(inner, TypeInner::Array { .. }) && seen.insert(key) {
            found.push(Largest {
                bytes: inner.try_size(module.to_ctx()).unwrap_or(u32::MAX),
                span: function
                    .expressions
                    .get_span(access)
                    .to_range()
                    .unwrap_or(0..0),
            });
        }
    }
    found
}
