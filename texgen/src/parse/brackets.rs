//! Brackets that nothing closes: naga would read on behind the file, into another one or the prelude, and blame that.

use crate::diagnostic::{Diagnostic, SourceFile};
use crate::habits::Habit;
use crate::scope::Outline;

/// The error of a bracket that nothing closes, or of a `)` or `]` that closes nothing: the function would seem to end there. What closes
/// another one than the last that was opened, naga finds where it is.
pub(super) fn unclosed(
    file: &SourceFile,
    outline: &Outline<'_>,
    habits: &[Habit<'_>],
) -> Option<Diagnostic> {
    let mut open: Vec<usize> = Vec::new();
    // Declarations that begin within brackets, each with the innermost one.
    let mut within: Vec<(usize, usize)> = Vec::new();
    for at in 0..outline.tokens.tokens.len() {
        if habits.iter().any(|habit| habit.tokens.contains(&at)) {
            continue;
        }
        match outline.word(at) {
            "(" | "[" | "{" => open.push(at),
            word @ (")" | "]") if open.last().is_none_or(|&inner| outline.word(inner) == "{") => {
                let error = Diagnostic::error(format!("this `{word}` closes nothing"));
                let error = error.with_label(file, outline.span(at), "");
                return Some(error.with_note("remove it, or open the bracket further up"));
            }
            word @ (")" | "]" | "}") => {
                let opened = open.pop()?;
                if closer(outline.word(opened)) != word {
                    return None;
                }
            }
            "fn" | "struct" | "alias" => within.extend(open.last().map(|&inner| (inner, at))),
            _ => {}
        }
    }
    let last = *open.last()?;
    // Of several files that are one text, this keeps to the right one.
    let mut stays_open = within
        .into_iter()
        .filter(|(bracket, _)| open.binary_search(bracket).is_ok());
    let (bracket, still) = match stays_open.next() {
        Some((bracket, declaration)) => {
            let declared = outline.span_of(&(declaration..declaration + 2));
            let declared = outline.text.get(declared).unwrap_or_default();
            (bracket, format!("still open where `{declared}` begins"))
        }
        None => (last, "still open at the end".to_owned()),
    };
    let word = outline.word(bracket);
    let error = Diagnostic::error(format!("this `{word}` is not closed"));
    let error = error.with_label(file, outline.span(bracket), still);
    Some(error.with_note(format!("a `{}` is missing", closer(word))))
}

fn closer(bracket: &str) -> &'static str {
    match bracket {
        "(" => ")",
        "[" => "]",
        _ => "}",
    }
}
