//! Diagnostics as JSON, for editors: one object in one line, so that a stream of them can be read line by line.
//!
//! The names of the members are an interface: they are added to, never changed.

use serde::Serialize;

use crate::diagnostic::{Diagnostic, Diagnostics, Label, SourceFile, must_be_escaped};

/// The whole object. The members of the place are absent where the problem has none.
#[derive(Serialize)]
struct Message<'a> {
    severity: &'static str,
    message: &'a str,
    #[serde(flatten)]
    place: Option<Place<'a>>,
    notes: &'a [String],
    /// Further places that help to understand the problem.
    related: Vec<Place<'a>>,
}

#[derive(Serialize)]
struct Place<'a> {
    file: &'a str,
    line: usize,
    column: usize,
    end_line: usize,
    end_column: usize,
    byte_start: usize,
    byte_end: usize,
    label: &'a str,
}

impl<'a> From<&'a Label> for Place<'a> {
    fn from(label: &'a Label) -> Self {
        let [start, end] = [label.span.start, label.span.end].map(|at| place(&label.file, at));
        Self {
            file: label.file.path(),
            line: start.0,
            column: start.1,
            end_line: end.0,
            end_column: end.1,
            byte_start: label.span.start,
            byte_end: label.span.end,
            label: &label.text,
        }
    }
}

fn place(file: &SourceFile, at: usize) -> (usize, usize) {
    let location = file.location(at);
    (location.line, location.column)
}

impl Diagnostic {
    /// One JSON object in one line, without a newline at its end: `severity` (`"error"` or `"warning"`), `message`,
    /// `notes`, `related` (further places), and where the problem has a place `file`, `line`, `column`, `end_line`,
    /// `end_column` (counted from one, columns in characters; the end is behind the last character), `byte_start`,
    /// `byte_end` and `label`. The places in `related` have the same members.
    pub fn to_json(&self) -> String {
        let main = self.labels.iter().position(|label| label.primary);
        let main = main.or((!self.labels.is_empty()).then_some(0));
        let message = Message {
            severity: self.severity.as_str(),
            message: &self.message,
            place: main.map(|main| Place::from(&self.labels[main])),
            notes: &self.notes,
            related: self
                .labels
                .iter()
                .enumerate()
                .filter(|(at, _)| Some(*at) != main)
                .map(|(_, label)| Place::from(label))
                .collect(),
        };
        let json = serde_json::to_string(&message).expect("texts and numbers always are JSON");
        escaped(json)
    }
}

impl Diagnostics {
    /// One object per line, see [`Diagnostic::to_json`]; every line ends with a newline.
    pub fn to_json_lines(&self) -> String {
        let all = self.iter().cloned().chain(self.rest());
        all.map(|one| one.to_json() + "\n").collect()
    }
}

/// JSON leaves some characters as they are that steer a terminal: they stand in strings, so they can be escaped.
fn escaped(json: String) -> String {
    if !json.contains(must_be_escaped) {
        return json;
    }
    let mut out = String::with_capacity(json.len() + 16);
    for c in json.chars() {
        match must_be_escaped(c) {
            true => out.push_str(&format!("\\u{:04x}", c as u32)),
            false => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_lines_columns_and_bytes() {
        let file = SourceFile::new("a", "dir/a.wgsl", "é x\nlet \"y\";\nz");
        let diagnostic = Diagnostic::error("bad \"y\"\n")
            .with_secondary(&file, 0..2, "see here")
            .with_label(&file, 9..13, "this")
            .with_note("write z");
        let line = diagnostic.to_json();
        assert!(!line.contains('\n'), "{line}");
        let json: serde_json::Value = serde_json::from_str(&line).expect("JSON");
        let expected = serde_json::json!({
            "severity": "error", "message": "bad \"y\"\n", "notes": ["write z"],
            "file": "dir/a.wgsl", "line": 2, "column": 5, "end_line": 2, "end_column": 9,
            "byte_start": 9, "byte_end": 13, "label": "this",
            "related": [{
                "file": "dir/a.wgsl", "line": 1, "column": 1, "end_line": 1, "end_column": 2,
                "byte_start": 0, "byte_end": 2, "label": "see here",
            }],
        });
        assert_eq!(json, expected);
        let odd = Diagnostic::error("\u{9b}0m \u{1b} \u{202e}").to_json();
        assert!(
            odd.starts_with(r#"{"severity":"error","message":"\u009b0m \u001b \u202e","#),
            "{odd}"
        );
        let bare = Diagnostic::warning("odd").to_json();
        assert_eq!(
            bare,
            r#"{"severity":"warning","message":"odd","notes":[],"related":[]}"#
        );
    }
}
