//! naga's verdict on a texture, in the user's terms: every error of the file with its place and a remedy.
//!
//! naga stops at the first error of a module. To show all of them, what an error lies in is cut out (`recover`) and the
//! rest is tried again, until naga is content or nothing can be blamed.

mod brackets;
mod unfinished;

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::habits::Habit;
use crate::libraries::Whole;
use crate::prelude::STUBS;
use crate::recover::Attempt;
use crate::scope::Outline;
use crate::standard;

/// No more errors of naga's than this are looked for in one file, as many as are shown: each costs a parse, and a long file ends
/// the search before.
const MAX_ERRORS: usize = 50;

/// Parses and validates the file with what it needs of the prelude behind it (spans in the file stay what they are) and constants
/// for the custom attributes it reads. What comes from another language was found before: the file is read without it.
///
/// # Errors
/// All errors naga can be made to show.
pub(crate) fn parse<'a>(
    whole: &Whole,
    outline: &Outline<'a>,
    custom: &[String],
    habits: &[Habit<'a>],
) -> Result<naga::Module, Diagnostics> {
    let file = &whole.file;
    if let Some(comment) = outline.tokens.unclosed() {
        // It would swallow what is put behind the file, and naga's places would lie there.
        let start = comment.start;
        return Err(Diagnostic::error("this comment is not closed")
            .with_label(file, start..start + 2, "it goes on to the end of the file")
            .with_note("close it with `*/`; comments within it need their own")
            .into());
    }
    let broken_off = brackets::unclosed(file, outline, habits)
        .or_else(|| unfinished::unfinished(whole, outline, habits));
    if let Some(problem) = broken_off {
        return Err(problem.into());
    }
    let mut tail = format!("\n{STUBS}\n");
    for place in standard::needed_by(outline) {
        tail.push_str(standard::source(place));
        tail.push('\n');
    }
    for (index, name) in custom.iter().enumerate() {
        let declared = outline
            .globals
            .iter()
            .any(|global| global.name.is_some_and(|at| outline.word(at) == name));
        if !declared {
            tail.push_str(&format!("const {name} = {}u;\n", 1000 + index));
        }
    }
    let mut attempt = Attempt::new(outline, tail);
    for habit in habits {
        attempt.cut_tokens(habit.tokens.clone(), &habit.names);
    }
    let mut problems = Diagnostics::new();
    for tried in 1.. {
        let (text, edits) = attempt.text();
        let mut problem = match attempt.check(&text) {
            Ok(module) if problems.is_empty() && habits.is_empty() => return Ok(module),
            Ok(_) => break,
            Err(problem) => problem,
        };
        edits.undo(&mut problem);
        // The validator, which names the function, has read all.
        let is_of_parser = problem.function.is_none();
        if problem.is_unplaced() {
            problem = attempt.place(problem);
        }
        attempt.tell_operands(&mut problem);
        let place = problem.labels.first().map(|(span, _)| span.start);
        attempt.count(text.len(), place.filter(|_| is_of_parser));
        problem.sort_labels(outline);
        let is_new = !attempt.has_caused(&problem);
        let goes_on = attempt.mend(&problem);
        let is_last = tried >= MAX_ERRORS || attempt.has_read_enough();
        if is_new {
            let mut diagnostic = problem.into_diagnostic(file, outline);
            if goes_on && is_last {
                let note = "there may be more errors than these: correct them first";
                diagnostic = diagnostic.with_note(note);
            }
            if !is_told(&problems, &diagnostic) {
                problems.push(diagnostic);
            }
        }
        if !goes_on || is_last {
            break;
        }
    }
    problems.sort();
    Err(problems)
}

/// Whether the last of the problems is this one: what was cut out hasn't mended it.
fn is_told(problems: &Diagnostics, diagnostic: &Diagnostic) -> bool {
    let place = |one: &Diagnostic| one.labels.first().map(|label| label.span.start);
    let last = problems.as_slice().last();
    last.is_some_and(|last| last.message == diagnostic.message && place(last) == place(diagnostic))
}
