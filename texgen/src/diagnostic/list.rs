//! All diagnostics of something: as many as people read, and the number of the others.

use std::fmt;

use super::{Diagnostic, Severity};

/// No more errors than this are kept, and as many warnings: nobody reads on, and a file can hold a hundred thousand.
const MOST: usize = 50;

/// Everything that is wrong with a file: never empty when returned as an error. Holds at most 50 errors and as many
/// warnings, and counts those beyond.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics {
    kept: Vec<Diagnostic>,
    /// Errors and warnings beyond.
    more: [usize; 2],
}

impl Diagnostics {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let severity = diagnostic.severity;
        if self.kept.len() >= MOST && self.of(severity).count() >= MOST {
            self.more[place(severity)] += 1;
        } else {
            self.kept.push(diagnostic);
        }
    }

    /// Adds all of another list, those that it only counts included.
    pub fn append(&mut self, other: Self) {
        for severity in [Severity::Error, Severity::Warning] {
            self.more[place(severity)] += other.more[place(severity)];
        }
        self.extend(other.kept);
    }

    /// The same with something done to each that was kept.
    pub(crate) fn map(self, change: impl Fn(Diagnostic) -> Diagnostic) -> Self {
        Self {
            kept: self.kept.into_iter().map(change).collect(),
            ..self
        }
    }

    /// Those that were kept, in the order they were found.
    pub fn as_slice(&self) -> &[Diagnostic] {
        &self.kept
    }

    /// Those that were kept, in the order they were found.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.kept.iter()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// How many were kept.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// How many there are of a severity, those that were not kept included.
    pub fn count(&self, severity: Severity) -> usize {
        self.of(severity).count() + self.more[place(severity)]
    }

    /// Whether one of them is an error.
    pub fn has_errors(&self) -> bool {
        self.of(Severity::Error).next().is_some()
    }

    fn of(&self, severity: Severity) -> impl Iterator<Item = &Diagnostic> {
        self.iter().filter(move |one| one.severity == severity)
    }

    /// Plain text of all, one after the other with an empty line between: see [`Diagnostic::render`].
    pub fn render(&self) -> String {
        self.joined(Diagnostic::render)
    }

    /// The same for a terminal of some width.
    pub fn render_within(&self, columns: usize) -> String {
        self.joined(|one| one.render_within(columns))
    }

    fn joined(&self, render: impl Fn(&Diagnostic) -> String) -> String {
        let all = self.iter().cloned().chain(self.rest());
        all.map(|one| format!("{}\n", render(&one).trim_end()))
            .collect::<Vec<_>>()
            .join("\n")
    }

    /// What stands for those that were not kept: at the end of everything that is written.
    pub(crate) fn rest(&self) -> Option<Diagnostic> {
        let [errors, warnings] = self.more;
        let counted = |count: usize, word: &str| match count {
            1 => format!("1 more {word}"),
            _ => format!("{count} more {word}s"),
        };
        let is_or_are = if errors + warnings == 1 { "is" } else { "are" };
        let what = match (errors, warnings) {
            (0, 0) => return None,
            (errors, 0) => counted(errors, "error"),
            (0, warnings) => counted(warnings, "warning"),
            _ => format!(
                "{} and {}",
                counted(errors, "error"),
                counted(warnings, "warning")
            ),
        };
        let message = format!("{what} {is_or_are} not shown");
        Some(match errors {
            0 => Diagnostic::warning(message),
            _ => Diagnostic::error(message),
        })
    }

    /// In order of file position: errors of one file found by different stages read from top to bottom.
    pub(crate) fn sort(&mut self) {
        self.kept.sort_by_key(|diagnostic| {
            diagnostic
                .labels
                .first()
                .map_or(usize::MAX, |label| label.span.start)
        });
    }

    /// Errors before warnings, and otherwise as they are.
    pub(crate) fn errors_first(&mut self) {
        self.kept.sort_by_key(|one| place(one.severity));
    }
}

fn place(severity: Severity) -> usize {
    match severity {
        Severity::Error => 0,
        Severity::Warning => 1,
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self::from_iter([diagnostic])
    }
}

impl FromIterator<Diagnostic> for Diagnostics {
    fn from_iter<I: IntoIterator<Item = Diagnostic>>(iter: I) -> Self {
        let mut all = Self::new();
        all.extend(iter);
        all
    }
}

impl Extend<Diagnostic> for Diagnostics {
    fn extend<I: IntoIterator<Item = Diagnostic>>(&mut self, iter: I) {
        iter.into_iter().for_each(|one| self.push(one));
    }
}

impl IntoIterator for Diagnostics {
    type Item = Diagnostic;
    type IntoIter = std::vec::IntoIter<Diagnostic>;

    /// Those that were kept.
    fn into_iter(self) -> Self::IntoIter {
        self.kept.into_iter()
    }
}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.kept.iter()
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.render().trim_end())
    }
}

impl std::error::Error for Diagnostics {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_list_is_cut_and_says_so() {
        let mut all: Diagnostics = (0..20_000)
            .map(|i| Diagnostic::error(format!("number {i}")))
            .collect();
        all.push(Diagnostic::warning("odd"));
        assert_eq!((all.len(), all.count(Severity::Error)), (MOST + 1, 20_000));
        let mut both = Diagnostics::from(Diagnostic::error("first"));
        both.append(all);
        assert_eq!(
            (both.count(Severity::Error), both.count(Severity::Warning)),
            (20_001, 1)
        );
        let report = both.render();
        assert!(
            report.ends_with("\nwarning: odd\n\nerror: 19951 more errors are not shown\n"),
            "{report}"
        );
        assert!(
            both.to_json_lines()
                .trim_end()
                .ends_with("more errors are not shown\",\"notes\":[],\"related\":[]}")
        );
        // Warnings never push errors out.
        let mut warnings: Diagnostics = (0..100).map(|_| Diagnostic::warning("odd")).collect();
        warnings.push(Diagnostic::error("wrong"));
        assert!(warnings.has_errors());
    }
}
