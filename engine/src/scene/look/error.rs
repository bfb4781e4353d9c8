//! What is wrong with a look file, shown with its line and a caret.

use std::fmt;
use std::path::PathBuf;

use super::value::Span;

/// One mistake in a look file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Where, in bytes of the text.
    pub span: Span,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub note: Option<String>,
}

/// Why there is no look.
#[derive(Debug, thiserror::Error)]
pub enum LookError {
    /// The file can't be read.
    #[error("can't read the look {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file has mistakes.
    #[error("{}", Shown { path, text, problems })]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Its text.
        text: String,
        /// Its mistakes, in the order of the file.
        problems: Vec<Problem>,
    },
}

struct Shown<'a> {
    path: &'a PathBuf,
    text: &'a str,
    problems: &'a [Problem],
}

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.problems.iter().enumerate() {
            let start = problem.span.start.min(self.text.len());
            let line_start = self.text[..start].rfind('\n').map_or(0, |at| at + 1);
            let line = self.text[line_start..].lines().next().unwrap_or("");
            let number = self.text[..start].matches('\n').count() + 1;
            let column = self.text[line_start..start].chars().count() + 1;
            let width = self
                .text
                .get(start..problem.span.end)
                .unwrap_or("")
                .lines()
                .next();
            let carets = width.map_or(1, |w| w.chars().count().max(1));
            let gutter = " ".repeat(number.to_string().len());
            if i > 0 {
                writeln!(f)?;
            }
            writeln!(f, "error: {}", problem.message)?;
            writeln!(f, "{gutter}--> {}:{number}:{column}", self.path.display())?;
            writeln!(f, "{number} | {line}")?;
            write!(
                f,
                "{gutter} | {}{}",
                " ".repeat(column - 1),
                "^".repeat(carets)
            )?;
            if let Some(note) = &problem.note {
                write!(f, "\n{gutter} = {note}")?;
            }
        }
        Ok(())
    }
}
