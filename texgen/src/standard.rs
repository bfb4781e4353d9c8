//! The standard functions: the part of the prelude that is real WGSL. What a texture doesn't call is neither parsed with it
//! nor in its kernel.

use std::collections::{BTreeSet, HashMap};
use std::sync::LazyLock;

use crate::scope::{Outline, Role};

/// Their text, all of it.
pub(crate) const STANDARD: &str = concat!(
    include_str!("standard/hash.wgsl"),
    include_str!("standard/noise.wgsl"),
    include_str!("standard/fractal.wgsl"),
    include_str!("standard/cells.wgsl"),
    include_str!("standard/color.wgsl"),
    include_str!("standard/shape.wgsl"),
);

/// What their names begin with in a kernel, where the host has names of its own.
pub(crate) const PREFIX: &str = "patina_";

/// The published name of what may be a standard function, by the name that it has in a kernel.
pub fn standard_function(name: &str) -> Option<&str> {
    name.strip_prefix(PREFIX)
}

/// One function, structure or constant.
struct Declaration {
    /// As it is published.
    source: &'static str,
    /// As it stands in a kernel.
    kernel: String,
    /// Places of the declarations that it names.
    uses: BTreeSet<usize>,
    /// Names and operators once all calls are expanded.
    expanded: u64,
}

struct Declarations {
    all: Vec<Declaration>,
    by_name: HashMap<&'static str, usize>,
}

static DECLARATIONS: LazyLock<Declarations> = LazyLock::new(|| {
    let outline = Outline::new(STANDARD);
    let named = |at: usize| outline.globals[at].name.map(|name| outline.word(name));
    let by_name: HashMap<&'static str, usize> = (0..outline.globals.len())
        .filter_map(|at| Some((named(at)?, at)))
        .collect();
    let all = outline.globals.iter().map(|global| {
        let span = outline.span_of(&global.tokens);
        let mut kernel = String::new();
        let mut last = span.start;
        let mut uses = BTreeSet::new();
        for at in global.tokens.clone() {
            if outline.roles[at] == Role::Global {
                let start = outline.span(at).start;
                kernel.push_str(&STANDARD[last..start]);
                kernel.push_str(PREFIX);
                last = start;
                uses.extend(by_name.get(outline.word(at)));
            }
        }
        kernel.push_str(&STANDARD[last..span.end]);
        Declaration {
            source: &STANDARD[span],
            kernel,
            uses,
            expanded: global.tokens.len() as u64,
        }
    });
    let mut declarations = Declarations {
        all: all.collect(),
        by_name,
    };
    let sizes = declarations.all.iter().map(|one| {
        let mut open: Vec<usize> = one.uses.iter().copied().collect();
        let mut seen: BTreeSet<usize> = one.uses.clone();
        let mut size = one.expanded;
        while let Some(at) = open.pop() {
            size += declarations.all[at].expanded;
            open.extend(
                declarations.all[at]
                    .uses
                    .iter()
                    .filter(|&&u| seen.insert(u)),
            );
        }
        size
    });
    let sizes: Vec<u64> = sizes.collect();
    for (one, size) in declarations.all.iter_mut().zip(sizes) {
        one.expanded = size;
    }
    declarations
});

/// Whether a standard function, structure or constant has this name.
pub(crate) fn is_standard(name: &str) -> bool {
    DECLARATIONS.by_name.contains_key(name)
}

/// Names and operators of a standard function with those that it calls; 0 for other names.
pub(crate) fn expanded_size(name: &str) -> u64 {
    let at = DECLARATIONS.by_name.get(name);
    at.map_or(0, |&at| DECLARATIONS.all[at].expanded)
}

/// Places of all declarations that a text needs, those that they need themselves included, ascending.
pub(crate) fn needed_by(outline: &Outline<'_>) -> BTreeSet<usize> {
    let predeclared = (0..outline.roles.len()).filter(|&at| outline.roles[at] == Role::Predeclared);
    let named = predeclared.filter_map(|at| DECLARATIONS.by_name.get(outline.word(at)));
    let mut open: Vec<usize> = named.copied().collect();
    let mut needed = BTreeSet::new();
    while let Some(at) = open.pop() {
        if needed.insert(at) {
            open.extend(&DECLARATIONS.all[at].uses);
        }
    }
    needed
}

/// A declaration as it is published.
pub(crate) fn source(place: usize) -> &'static str {
    DECLARATIONS.all[place].source
}

/// A declaration as a kernel has it.
pub(crate) fn in_kernel(place: usize) -> &'static str {
    &DECLARATIONS.all[place].kernel
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_needs_what_it_calls_and_what_that_calls() {
        let text = "fn userProc() -> f32 { let hashU2 = 1.0; return perlin2D(vec2f()) * hashU2; }";
        let needed = needed_by(&Outline::new(text));
        let texts: String = needed.iter().map(|&place| in_kernel(place)).collect();
        assert!(texts.contains("fn patina_hashU1(") && texts.contains("fn patina_perlin2DGrad("));
        assert!(!texts.contains("hashU2") && !texts.contains("perlin3D"));
        assert!(needed_by(&Outline::new("fn userProc() -> f32 { return 1.0; }")).is_empty());
    }

    #[test]
    fn no_standard_name_is_one_of_the_runtime() {
        let runtime = include_str!("runtime.wgsl");
        for name in DECLARATIONS.by_name.keys() {
            assert!(!runtime.contains(&format!("{PREFIX}{name}")), "{name}");
        }
    }

    #[test]
    fn loops_of_standard_functions_are_short() {
        // They are not counted against the limit of a node.
        assert!(!STANDARD.contains("while ") && !STANDARD.contains("loop "));
        let heads = STANDARD
            .lines()
            .filter(|line| line.trim_start().starts_with("for "));
        for head in heads {
            let limit = head
                .split_once("< ")
                .map_or("", |(_, rest)| rest.trim_start_matches("= "));
            let limit = limit.split(['u', ';']).next().unwrap_or_default();
            let limit = limit.trim_start_matches("= ").parse::<u32>();
            assert!(
                limit.is_ok_and(|limit| limit <= 27) || head.contains("<= "),
                "{head}"
            );
        }
    }
}
