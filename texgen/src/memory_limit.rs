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
use crate::rewrite::is_read_in_place;
use crate::scope::{FunctionDecl, Outline, Role};

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

/// Adds up parameters, variables, and what is copied into memory: tables that an index chooses from, and array parameters
/// of `userProc` that are used as a whole. A value that no variable holds counts where it alone is more than that.
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
        let Unnamed {
            tables: mut copied,
            value,
        } = unnamed(module, function, is_entry, &outline.span(decl.name));
        if is_entry {
            copied.extend(whole_parameters(module, function, outline, decl));
        }
        let sum = copied
            .iter()
            .map(|copy| copy.bytes)
            .fold(0u32, u32::saturating_add);
        let value_bytes = value.as_ref().map_or(0, |value| value.bytes);
        sizes.insert(handle, named.saturating_add(sum).max(value_bytes));
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
        for candidate in copied.into_iter().chain(variables).chain(value) {
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

/// What a function has that no variable holds.
struct Unnamed {
    /// The arrays that it chooses an element of by an index, with the places where it does.
    tables: Vec<Largest>,
    /// The largest of its arrays and structures, but for parameters.
    value: Option<Largest>,
}

/// Works that out. What has no place of its own is at `otherwise`.
fn unnamed(
    module: &Module,
    function: &Function,
    is_entry: bool,
    otherwise: &Range<usize>,
) -> Unnamed {
    let context =
        ResolveContext::with_locals(module, &function.local_variables, &function.arguments);
    let mut typifier = Typifier::new();
    let mut seen = BTreeSet::new();
    let mut found = Unnamed {
        tables: Vec::new(),
        value: None,
    };
    for (handle, expression) in function.expressions.iter() {
        if typifier
            .grow(handle, &function.expressions, &context)
            .is_err()
        {
            return found; // it was validated before
        }
        let largest = |of: Handle<Expression>| Largest {
            bytes: (typifier.get(of, &module.types))
                .try_size(module.to_ctx())
                .unwrap_or(u32::MAX),
            span: (function.expressions.get_span(handle))
                .to_range()
                .unwrap_or_else(|| otherwise.clone()),
        };
        // Array parameters of `userProc` are read in place, or count as a whole; other parameters count already.
        let is_parameter = |handle: Handle<Expression>| {
            matches!(
                function.expressions[handle],
                Expression::FunctionArgument(_)
            )
        };
        let is_composite = matches!(
            typifier.get(handle, &module.types),
            TypeInner::Array { .. } | TypeInner::Struct { .. }
        );
        if is_composite && !is_parameter(handle) {
            let value = largest(handle);
            let former = found.value.as_ref();
            if former.is_none_or(|former| value.bytes > former.bytes) {
                found.value = Some(value);
            }
        }
        let &Expression::Access { base, .. } = expression else {
            continue;
        };
        if is_parameter(base) && is_entry {
            continue;
        }
        // One constant may be used many times.
        let key = match function.expressions[base] {
            Expression::Constant(constant) => (0, constant.index()),
            Expression::ZeroValue(ty) => (1, ty.index()),
            _ => (2, base.index()),
        };
        let is_array = matches!(typifier.get(base, &module.types), TypeInner::Array { .. });
        if is_array && seen.insert(key) {
            found.tables.push(largest(base));
        }
    }
    found
}

/// The array parameters of `userProc` that it uses otherwise than element by element, with the first places where it does:
/// the kernel copies those.
fn whole_parameters(
    module: &Module,
    function: &Function,
    outline: &Outline<'_>,
    entry: &FunctionDecl,
) -> Vec<Largest> {
    let arrays: HashMap<usize, u32> = (entry.params.iter().zip(&function.arguments))
        .filter(|(_, argument)| matches!(module.types[argument.ty].inner, TypeInner::Array { .. }))
        .map(|(param, argument)| (param.name, size_of(module, argument.ty)))
        .collect();
    let mut seen = BTreeSet::new();
    let copied = entry.body.clone().filter_map(|at| {
        let Role::Local(declared) = outline.roles[at] else {
            return None;
        };
        let &bytes = arrays.get(&declared)?;
        let is_first = !is_read_in_place(outline, at) && seen.insert(declared);
        is_first.then(|| Largest {
            bytes,
            span: outline.span(at),
        })
    });
    copied.collect()
}
