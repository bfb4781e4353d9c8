//! Names of WGSL's own that a file declares itself, as `fn mix`.
//!
//! The prelude's functions stand in one text with the file, where they would mean the file's `mix`. So naga is given another name for
//! that, of the same length: places in the file stay what they are. In a kernel the file's names have a prefix.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashSet};
use std::sync::LazyLock;

use crate::prelude::PRELUDE;
use crate::problem::Problem;
use crate::scope::{Outline, Role};

/// What the prelude takes from WGSL.
static NEEDED: LazyLock<HashSet<&'static str>> = LazyLock::new(|| {
    let outline = Outline::new(PRELUDE);
    let tokens = 0..outline.roles.len();
    let predeclared = tokens.filter(|&at| outline.roles[at] == Role::Predeclared);
    predeclared.map(|at| outline.word(at)).collect()
});

/// A file's text with other names for such declarations.
pub(super) struct OwnNames<'a> {
    pub(super) text: Cow<'a, str>,
    /// The name that naga is given, and the file's.
    stand_ins: Vec<(String, &'a str)>,
}

impl<'a> OwnNames<'a> {
    /// For a file that `tail` stands behind.
    pub(super) fn new(outline: &Outline<'a>, tail: &str) -> Self {
        let names = outline.globals.iter().filter_map(|global| global.name);
        let names = names.map(|at| outline.word(at));
        let names: BTreeSet<&'a str> = names.filter(|name| NEEDED.contains(*name)).collect();
        let mut numbers = 0..10_000usize;
        let is_free = |name: &String| !outline.text.contains(name) && !tail.contains(name);
        let stand_ins: Vec<(String, &'a str)> = names
            .into_iter()
            .filter_map(|name| {
                let free = numbers.find_map(|number| stand_in(name.len(), number).filter(&is_free));
                Some((free?, name))
            })
            .collect();
        if stand_ins.is_empty() {
            return Self {
                text: Cow::Borrowed(outline.text),
                stand_ins,
            };
        }
        let mut text = outline.text.to_owned();
        for (at, role) in outline.roles.iter().enumerate() {
            let word = outline.word(at);
            let mut known = stand_ins.iter().filter(|(_, name)| *name == word);
            if *role == Role::Global
                && let Some((stand_in, _)) = known.next()
            {
                text.replace_range(outline.span(at), stand_in);
            }
        }
        Self {
            text: Cow::Owned(text),
            stand_ins,
        }
    }

    /// Says of the file's names what naga says of the others.
    pub(super) fn speak(&self, problem: &mut Problem) {
        for (stand_in, name) in &self.stand_ins {
            let own = |text: &mut String| {
                if text.contains(stand_in.as_str()) {
                    *text = text.replace(stand_in.as_str(), name);
                }
            };
            own(&mut problem.message);
            problem.labels.iter_mut().for_each(|(_, text)| own(text));
            problem.notes.iter_mut().for_each(own);
            problem.function.iter_mut().for_each(own);
            if let Some(conversion) = problem.conversion.as_deref_mut() {
                own(&mut conversion.to);
                conversion.name.iter_mut().for_each(own);
            }
        }
    }

    /// Gives functions their names back.
    pub(super) fn restore(&self, module: &mut naga::Module) {
        if self.stand_ins.is_empty() {
            return;
        }
        for (_, function) in module.functions.iter_mut() {
            let Some(called) = &mut function.name else {
                continue;
            };
            let mut known = self.stand_ins.iter();
            if let Some((_, name)) = known.find(|(stand_in, _)| *stand_in == *called) {
                (*name).clone_into(called);
            }
        }
    }
}

/// A name of so many letters that neither WGSL nor the prelude has.
fn stand_in(length: usize, number: usize) -> Option<String> {
    let name = format!("Q{number}");
    let blank = length.checked_sub(name.len())?;
    Some(name + &"_".repeat(blank))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_of_wgsl_gets_another_one_of_its_length() {
        let text = "fn mix(a: f32) -> f32 { let Q0_ = a; return Q0_; }\nfn userProc(max: f32) -> f32 { return mix(max) + min(max, 1.0); }";
        let outline = Outline::new(text);
        let names = OwnNames::new(&outline, "");
        assert_eq!(names.text.len(), text.len());
        assert!(names.text.starts_with("fn Q1_(a: f32)"), "{}", names.text);
        assert!(names.text.ends_with("return Q1_(max) + min(max, 1.0); }"));
        let plain = "fn blend(a: f32) -> f32 { return mix(a, a, a); }";
        assert_eq!(OwnNames::new(&Outline::new(plain), "").text, plain);
    }
}
