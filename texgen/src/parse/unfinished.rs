//! Files that end with the beginning of a declaration: naga would read on behind them, into another one or the prelude, and blame that.

use crate::diagnostic::Diagnostic;
use crate::habits::Habit;
use crate::libraries::Whole;
use crate::scope::Outline;

/// What a declaration goes on behind.
const BEGINNINGS: [&str; 8] = [
    "@", "fn", "const", "struct", "alias", "let", "var", "override",
];

/// The error of a texture, or of a file that it uses, that breaks off behind such a word.
pub(super) fn unfinished(
    whole: &Whole,
    outline: &Outline<'_>,
    habits: &[Habit<'_>],
) -> Option<Diagnostic> {
    let tokens = &outline.tokens.tokens;
    let mut ends = whole.parts.iter().filter_map(|part| {
        let behind = tokens.partition_point(|token| token.start < part.range.end);
        let last = behind.checked_sub(1)?;
        part.range.contains(&tokens[last].start).then_some(last)
    });
    let last = ends.find(|last| {
        let is_habit = habits.iter().any(|habit| habit.tokens.contains(last));
        BEGINNINGS.contains(&tokens[*last].text) && !is_habit
    })?;
    let word = outline.word(last);
    let error = Diagnostic::error(format!("something is missing behind `{word}`"));
    let error = error.with_label(&whole.file, outline.span(last), "the file ends here");
    Some(error.with_note("write the rest of the declaration, or remove its beginning"))
}
