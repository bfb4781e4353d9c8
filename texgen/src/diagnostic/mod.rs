//! What went wrong, where, and what to do next: diagnostics with source line and caret.
//!
//! Nothing here knows WGSL: a look file's TOML errors are reported with the same types. Positions are byte
//! ranges into a [`SourceFile`]; lines and columns are worked out only when someone asks. Nothing here prints.

mod list;
mod printable;
mod render;
mod wrap;

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

pub use list::Diagnostics;
pub use printable::must_be_escaped;
pub use printable::printable;

/// Columns of a source line that are shown where nobody says how wide the terminal is.
pub const COLUMNS: usize = 100;

/// The text of one file with the name it goes by. Cheap to clone: the text is shared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    name: Arc<str>,
    path: Arc<str>,
    text: Arc<str>,
    libraries: Arc<[SourceFile]>,
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
            libraries: Arc::new([]),
        }
    }

    /// The same with the shared files that it may take functions from by `@use`: those that it names, and those that they name.
    #[must_use]
    pub fn with_libraries(self, libraries: impl Into<Arc<[SourceFile]>>) -> Self {
        Self {
            libraries: libraries.into(),
            ..self
        }
    }

    /// The shared files that it may take functions from.
    pub fn libraries(&self) -> &[SourceFile] {
        &self.libraries
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

    /// Plain text: message, `file:line:column`, the source lines with carets, notes. Ends with a newline. Long source lines are
    /// cut around the marks; sentences stay in one line, for whoever searches in them. Control characters are written out,
    /// see [`printable`].
    pub fn render(&self) -> String {
        render::render(self, None)
    }

    /// The same for a terminal of some width: sentences are wrapped, and only a path may be wider.
    pub fn render_within(&self, columns: usize) -> String {
        render::render(self, Some(columns))
    }
}

impl std::error::Error for Diagnostic {}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.render().trim_end())
    }
}

fn floor_char_boundary(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
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
        assert_eq!(
            text,
            "error: bad \\u{7}\n  --> a:1:5\n  |\n1 | let \\u{1b}[31m = \\u{85}1;\n  |     ^^^^^^\n\n"
        );
    }

    #[test]
    fn a_long_line_is_cut_around_its_mark() {
        let words: String = (0..100).map(|i| format!("word{i} ")).collect();
        let file = SourceFile::new("a", "a", words.as_str());
        let at = words.find("word50").expect("there");
        let report = Diagnostic::error("bad word")
            .with_label(&file, at..at + 6, "this one")
            .render_within(60);
        assert_eq!(
            report,
            "error: bad word
  --> a:1:341
  |
1 | ...7 word48 word49 word50 word51 word52 word53 word54...
  |                    ^^^^^^ this one

"
        );
        let report = Diagnostic::error("bad word")
            .with_label(
                &file,
                at..at + 6,
                "a label that needs more room than there is beside its mark",
            )
            .with_secondary(&file, 0..5, "far away in the same line")
            .with_note("write this sentence in the place of the other one, which is no good")
            .render_within(60);
        assert!(report.lines().all(|line| line.len() <= 60), "{report}");
        for part in [
            "= a label that needs",
            "= line 1: far away",
            "= note: write this",
        ] {
            assert!(report.contains(part), "{report}");
        }
    }

    #[test]
    fn labels_of_several_lines_are_shown_with_the_line_between() {
        let file = SourceFile::new("a", "a", "one\r\n\ttwo\r\nthree four\r\nfive");
        let report = Diagnostic::warning("odd")
            .with_label(&file, 11..16, "here")
            .with_secondary(&file, 0..21, "begins here")
            .render();
        assert_eq!(
            report,
            "warning: odd
  --> a:3:1
  |
1 | one
  | --- begins here
2 |     two
3 | three four
  | ^^^^^ here

"
        );
    }
}
