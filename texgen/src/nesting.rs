//! How deep a texture nests as software drivers see it.
//!
//! Mesa's llvmpipe keeps a mask for each `if` around a statement, 80 at most (`LP_MAX_TGSI_NESTING` in gallivm); what lies
//! deeper is done where it shouldn't be, without a word. Before that it has put all behind an early `return`, `break` or
//! `continue` into an `if` of its own, functions into their callers, and the cases of a `switch` one behind the other.

use std::collections::HashMap;

use naga::{Block, Function, Handle, Module, Statement};

use crate::diagnostic::{Diagnostic, SourceFile};
use crate::rewrite::plainly_short;
use crate::scope::Outline;

/// As deep is warned of: the kernel around a texture takes a part of the 80.
const DEEP: usize = 70;

/// A warning at each function that nests too deeply, but for those that only do since they call one.
pub(crate) fn warnings(
    file: &SourceFile,
    outline: &Outline<'_>,
    module: &Module,
) -> Vec<Diagnostic> {
    let mut depths = HashMap::new();
    let mut guards = guards(outline);
    let mut found = Vec::new();
    // naga has callees before their callers.
    for (handle, function) in module.functions.iter() {
        let name = function.name.as_deref().unwrap_or_default();
        let mut walk = Walk {
            depths: &depths,
            guards: guards.remove(name).unwrap_or_default().into_iter(),
            deepest: 0,
            calls_deep: false,
        };
        walk.block(&function.body, 0, &mut Leaves::default());
        let (depth, is_told) = (walk.deepest, walk.calls_deep);
        depths.insert(handle, depth);
        if depth < DEEP || is_told {
            continue;
        }
        if let Some(decl) = outline.function(name) {
            let message = format!(
                "`{name}` is nested {depth} deep, counting what it calls, and what follows an early `return`, `break` or `continue` as nested, also behind loops without literal bounds: Mesa's llvmpipe gives wrong values beyond 80"
            );
            found.push(
                Diagnostic::warning(message)
                    .with_label(file, outline.span(decl.name), "")
                    .with_note("assign to a variable in the place of each early `return`, and choose by a `switch` whose cases only assign; give loops literal bounds, as in `for (var i = 0; i < 8; i++)`"),
            );
        }
    }
    found
}

/// How the guard that the kernel has at the beginning of each loop that isn't plainly short leaves it, for the loops of each function,
/// by its name: outer loops before those in them, as naga has them.
fn guards<'a>(outline: &Outline<'a>) -> HashMap<&'a str, Vec<Leaves>> {
    let mut by_function: HashMap<&str, Vec<Leaves>> = HashMap::new();
    for (the_loop, is_short) in outline.loops.iter().zip(plainly_short(outline)) {
        let guard = Leaves {
            returns: !is_short && !the_loop.in_continuing,
            breaks: !is_short && the_loop.in_continuing,
            continues: false,
        };
        let name = outline.word(outline.functions[the_loop.function].name);
        by_function.entry(name).or_default().push(guard);
    }
    by_function
}

/// How a block is left early.
#[derive(Clone, Copy, Default)]
struct Leaves {
    returns: bool,
    breaks: bool,
    continues: bool,
}

impl Leaves {
    fn any(self) -> bool {
        self.returns || self.breaks || self.continues
    }

    fn add(&mut self, other: Self) {
        self.returns |= other.returns;
        self.breaks |= other.breaks;
        self.continues |= other.continues;
    }
}

/// A walk through a function.
struct Walk<'d> {
    /// Of the functions that it may call.
    depths: &'d HashMap<Handle<Function>, usize>,
    /// Of the loops that it hasn't come to yet.
    guards: std::vec::IntoIter<Leaves>,
    /// How deep its deepest statement lies.
    deepest: usize,
    /// It calls a function that is too deep by itself.
    calls_deep: bool,
}

impl Walk<'_> {
    /// Walks through a block that lies so deep; says how deep that lies which follows its last statement.
    fn block(&mut self, block: &Block, depth: usize, leaves: &mut Leaves) -> usize {
        let mut now = depth;
        for statement in block.iter() {
            self.deepest = self.deepest.max(now);
            match statement {
                Statement::Return { .. } => leaves.returns = true,
                Statement::Break => leaves.breaks = true,
                Statement::Continue => leaves.continues = true,
                Statement::Block(inner) => now = self.block(inner, now, leaves),
                Statement::Call { function, .. } => {
                    let callee = self.depths.get(function).copied().unwrap_or(0);
                    self.deepest = self.deepest.max(now + callee);
                    self.calls_deep |= callee >= DEEP;
                }
                Statement::If { accept, reject, .. } => {
                    let mut behind = now;
                    for arm in [accept, reject] {
                        let mut of_arm = Leaves::default();
                        // An `else` that isn't there is none.
                        if !arm.is_empty() {
                            self.block(arm, now + 1, &mut of_arm);
                        }
                        behind += usize::from(of_arm.any());
                        leaves.add(of_arm);
                    }
                    now = behind;
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        let mut of_case = Leaves::default();
                        self.block(&case.body, now + 1, &mut of_case);
                        // Its `break` ends the `switch` alone.
                        of_case.breaks = false;
                        now += usize::from(of_case.any());
                        leaves.add(of_case);
                    }
                }
                Statement::Loop {
                    body, continuing, ..
                } => {
                    // What naga was given has no guards.
                    let mut of_loop = self.guards.next().unwrap_or_default();
                    let inside = now + 1 + usize::from(of_loop.any());
                    self.block(body, inside, &mut of_loop);
                    self.block(continuing, now + 1, &mut Leaves::default());
                    now += usize::from(of_loop.returns);
                    leaves.returns |= of_loop.returns;
                }
                _ => {}
            }
        }
        now
    }
}
