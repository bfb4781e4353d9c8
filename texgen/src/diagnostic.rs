//! What went wrong, where, and what to do next: diagnostics with source line and caret.
//!
//! Nothing here knows WGSL: a look file's TOML errors are reported with the same types. Positions are byte
//! ranges into a [`SourceFile`]; lines and columns are worked out only when someone asks. Nothing here prints.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use codespan_reporting::diagnostic as codespan;
use codespan_reporting::files::SimpleFiles;
use codespan_reporting::term;

/// The text of one file with the name it goes by. Cheap to clone: the text is shared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    name: Arc<str>,
    path: Arc<str>,
    text: Arc<str>,
}

impl SourceFile {
    /// A file called `name` (for a texture: the texture's name), shown in messages as `path`.
    pub fn new(
        name: impl Into<Arc<str>>,
        path: impl Into<Arc<str>>,
        text: impl Into<Arc<str>>,
    ) -> Self {
        Self {
            name: name.into(),
            path: path.into(),
            text: text.into(),
        }
    }

    /// The name the file's content goes by: for a texture, its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The path as messages show it.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The whole text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Line and column of a byte offset. Offsets beyond the end or inside a character are moved back to the
    /// nearest valid one.
    pub fn location(&self, offset: usize) -> Location {
        let offset = floor_char_boundary(&self.text, offset);
        let before = &self.text[..offset];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Location {
            path: self.path.to_string(),
            line: before.matches('\n').count() + 1,
            column: self.text[line_start..offset].chars().count() + 1,
        }
    }

    /// Byte offset of a line and column, both counted from one; `None` where the file has no such line.
    /// A column beyond the end of its line is moved back to the end.
    pub fn offset(&self, line: usize, column: usize) -> Option<usize> {
        let mut start = 0;
        for _ in 1..line {
            start += self.text[start..].find('\n')? + 1;
        }
        let rest = &self.text[start..];
        let length = rest.find('\n').unwrap_or(rest.len());
        let within = rest[..length]
            .char_indices()
            .nth(column.saturating_sub(1))
            .map_or(length, |(at, _)| at);
        Some(start + within)
    }
}

/// A place in a file as people and editors count it: lines and columns (in characters) from one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The file's path as messages show it.
    pub path: String,
    /// Line, counted from one.
    pub line: usize,
    /// Column in characters, counted from one.
    pub column: usize,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.path, self.line, self.column)
    }
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The file can be used; something in it is probably not what its author meant.
    Warning,
    /// The file can't be used.
    Error,
}

impl Severity {
    /// `warning` or `error`.
    pub fn as_str(self) -> &'static str {
        match self {
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// A marked range of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The file the range lies in.
    pub file: SourceFile,
    /// Byte range.
    pub span: Range<usize>,
    /// What the range has to do with the problem; may be empty.
    pub text: String,
    /// The first primary label is *the* place of the diagnostic.
    pub primary: bool,
}

/// One problem: a message, the places it concerns, and notes that say what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// One line, without the place.
    pub message: String,
    /// The places, the most important one first.
    pub labels: Vec<Label>,
    /// Remedies and explanations.
    pub notes: Vec<String>,
}

impl Diagnostic {
    /// An error without a place yet.
    pub fn error(message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            message: message.into(),
            labels: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// A warning without a place yet.
    pub fn warning(message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Warning,
            ..Self::error(message)
        }
    }

    /// Marks the place of the problem.
    pub fn with_label(
        self,
        file: &SourceFile,
        span: Range<usize>,
        text: impl Into<String>,
    ) -> Self {
        self.push_label(file, span, text.into(), true)
    }

    /// Marks a place that helps to understand the problem.
    pub fn with_secondary(
        self,
        file: &SourceFile,
        span: Range<usize>,
        text: impl Into<String>,
    ) -> Self {
        self.push_label(file, span, text.into(), false)
    }

    /// Adds a remedy or an explanation.
    pub fn with_note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    fn push_label(
        mut self,
        file: &SourceFile,
        span: Range<usize>,
        text: String,
        primary: bool,
    ) -> Self {
        let start = floor_char_boundary(file.text(), span.start);
        let end = floor_char_boundary(file.text(), span.end).max(start);
        self.labels.push(Label {
            file: file.clone(),
            span: start..end,
            text,
            primary,
        });
        self
    }

    /// The place of the problem: where its first primary label begins.
    pub fn location(&self) -> Option<Location> {
        let label = self
            .labels
            .iter()
            .find(|label| label.primary)
            .or(self.labels.first())?;
        Some(label.file.location(label.span.start))
    }

    /// Plain text: message, `file:line:column`, the source lines with carets, notes. Ends with a newline.
    pub fn render(&self) -> String {
        let mut files = SimpleFiles::new();
        let mut known: Vec<&SourceFile> = Vec::new();
        let mut labels = Vec::new();
        for label in &self.labels {
            let id = known
                .iter()
                .position(|file| **file == label.file)
                .unwrap_or_else(|| {
                    known.push(&label.file);
                    files.add(printable(label.file.path()), printable(label.file.text()))
                });
            let marked = if label.primary {
                codespan::Label::primary(id, label.span.clone())
            } else {
                codespan::Label::secondary(id, label.span.clone())
            };
            labels.push(marked.with_message(printable(&label.text)));
        }
        let severity = match self.severity {
            Severity::Error => codespan::Severity::Error,
            Severity::Warning => codespan::Severity::Warning,
        };
        let diagnostic = codespan::Diagnostic::new(severity)
            .with_message(printable(&self.message))
            .with_labels(labels)
            .with_notes(
                self.notes
                    .iter()
                    .map(|note| format!("note: {}", printable(note)))
                    .collect(),
            );
        let config = term::Config {
            chars: term::Chars::ascii(),
            ..term::Config::default()
        };
        term::emit_into_string(&config, &files, &diagnostic)
            .unwrap_or_else(|_| format!("{}: {}\n", severity_word(self.severity), self.message))
    }
}

impl std::error::Error for Diagnostic {}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.render().trim_end())
    }
}

/// Everything that is wrong with a file: never empty when returned as an error.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics(Vec<Diagnostic>);

impl Diagnostics {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.0.push(diagnostic);
    }

    /// All of them, in the order they were found.
    pub fn as_slice(&self) -> &[Diagnostic] {
        &self.0
    }

    /// In the order they were found.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.0.iter()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether one of them is an error.
    pub fn has_errors(&self) -> bool {
        self.0
            .iter()
            .any(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// Plain text of all, one after the other with an empty line between.
    pub fn render(&self) -> String {
        self.0
            .iter()
            .map(|diagnostic| format!("{diagnostic}\n"))
            .collect::<Vec<_>>()
            .join("\n")
    }

    /// In order of file position: errors of one file found by different stages read from top to bottom.
    pub(crate) fn sort(&mut self) {
        self.0.sort_by_key(|diagnostic| {
            diagnostic
                .labels
                .first()
                .map_or(usize::MAX, |label| label.span.start)
        });
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self(vec![diagnostic])
    }
}

impl FromIterator<Diagnostic> for Diagnostics {
    fn from_iter<I: IntoIterator<Item = Diagnostic>>(iter: I) -> Self {
        Self(iter.into_iter().collect())
    }
}

impl Extend<Diagnostic> for Diagnostics {
    fn extend<I: IntoIterator<Item = Diagnostic>>(&mut self, iter: I) {
        self.0.extend(iter);
    }
}

impl IntoIterator for Diagnostics {
    type Item = Diagnostic;
    type IntoIter = std::vec::IntoIter<Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.render().trim_end())
    }
}

impl std::error::Error for Diagnostics {}

fn severity_word(severity: Severity) -> &'static str {
    severity.as_str()
}

fn floor_char_boundary(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}

/// Control characters (but tabs and newlines) would garble a terminal; each is replaced by one of its own
/// length in bytes so that spans stay right.
fn printable(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '\n' | '\t' => c,
            c if c.is_ascii_control() => ' ',
            '\u{80}'..='\u{9f}' => '\u{b7}',
            c => c,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn renders_file_line_column_source_and_caret() {
        let file = SourceFile::new("a", "dir/a.toml", "x = 1\nscale = \"big\"\n");
        let diagnostic = Diagnostic::error("`scale` is a number")
            .with_label(&file, 14..19, "this is text")
            .with_note("write 1.0");
        assert_eq!(
            diagnostic.render(),
            "error: `scale` is a number\n  --> dir/a.toml:2:9\n  |\n2 | scale = \"big\"\n  |         ^^^^^ this is text\n  |\n  = note: write 1.0\n\n"
        );
        assert_eq!(
            diagnostic.location().map(|l| (l.line, l.column)),
            Some((2, 9))
        );
    }

    #[test]
    fn locations_count_characters_and_survive_bad_offsets() {
        let file = SourceFile::new("a", "a", "é\nüx");
        assert_eq!((file.location(5).line, file.location(5).column), (2, 2));
        assert_eq!(file.location(1).column, 1); // inside é
        assert_eq!(file.location(1000).line, 2);
        assert_eq!(file.offset(2, 2), Some(5));
        assert_eq!(file.offset(2, 99), Some(6));
        assert_eq!(file.offset(9, 1), None);
    }

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        let file = SourceFile::new("a", "a", "let \u{1b}[31m = \u{85}1;");
        let text = Diagnostic::error("bad \u{7}")
            .with_label(&file, 4..5, "")
            .render();
        assert!(!text.contains(['\u{1b}', '\u{7}', '\u{85}']), "{text:?}");
    }
}
