//! A diagnostic as text for a terminal of some width: the lines that its labels mark, cut where they are too long, and
//! its notes in lines that fit. Of a file only what is shown is copied.

use std::ops::Range;
use std::sync::Arc;

use codespan_reporting::diagnostic as codespan;
use codespan_reporting::files::{Error, Files, Location};
use codespan_reporting::term;

use super::printable::{must_be_escaped, printable};
use super::wrap::{width, width_of, wrap};
use super::{COLUMNS, Diagnostic, Label, Severity, SourceFile};

/// Fewer columns are not made use of.
const MIN_COLUMNS: usize = 40;

/// What stands where a line was cut.
const CUT: &str = "...";

/// Columns from one tab stop to the next.
const TAB: usize = 4;

/// Message, `file:line:column`, the source lines with carets, notes. Ends with an empty line.
/// Without a width, sentences stay in one line.
pub(super) fn render(diagnostic: &Diagnostic, columns: Option<usize>) -> String {
    let is_wrapped = columns.is_some();
    let columns = columns.unwrap_or(COLUMNS).max(MIN_COLUMNS);
    let wrap = |text: &str, first: usize, others: usize, indent: &str| match is_wrapped {
        true => wrap(text, first, others).replace('\n', &format!("\n{indent}")),
        false => text.to_owned(),
    };
    let lines: Vec<usize> = diagnostic.labels.iter().map(line_of).collect();
    let digits = lines.iter().max().map_or(0, |line| digits(line + 1));
    // "12 | " stands before a line, "   = " before a note.
    let room = columns - (digits + 3);
    let mut notes = Vec::new();
    let mut excerpts = Excerpts::new(&diagnostic.labels, &lines, room);
    let mut labels = Vec::new();
    for (at, label) in diagnostic.labels.iter().enumerate() {
        let text = printable(&label.text);
        let Some((file, span, column)) = excerpts.place(at) else {
            if !text.is_empty() {
                notes.push(format!("line {}: {text}", lines[at] + 1));
            }
            continue;
        };
        let fits = !is_wrapped || column + (span.len().max(1)) + 1 + width(&text) <= room;
        let text = match fits || text.is_empty() {
            true => text.into_owned(),
            false => {
                notes.push(text.into_owned());
                String::new()
            }
        };
        let marked = if label.primary {
            codespan::Label::primary(file, span)
        } else {
            codespan::Label::secondary(file, span)
        };
        labels.push(marked.with_message(text));
    }
    let named = diagnostic.notes.iter();
    notes.extend(named.map(|note| format!("note: {}", printable(note))));
    let severity = match diagnostic.severity {
        Severity::Error => codespan::Severity::Error,
        Severity::Warning => codespan::Severity::Warning,
    };
    let word = diagnostic.severity.as_str();
    let message = printable(&diagnostic.message);
    let first = columns - (word.len() + 2);
    let shown = codespan::Diagnostic::new(severity)
        .with_message(wrap(&message, first, columns - 4, "    "))
        .with_labels(labels)
        .with_notes(
            notes
                .iter()
                .map(|note| wrap(note, room, room, ""))
                .collect(),
        );
    let config = term::Config {
        chars: term::Chars::ascii(),
        ..term::Config::default()
    };
    term::emit_into_string(&config, &excerpts, &shown)
        .unwrap_or_else(|_| format!("{word}: {message}\n"))
}

/// Index of the line that a label begins in.
fn line_of(label: &Label) -> usize {
    let before = &label.file.text().as_bytes()[..label.span.start];
    before.iter().filter(|&&byte| byte == b'\n').count()
}

fn digits(number: usize) -> usize {
    number.ilog10() as usize + 1
}

/// The parts of the files that are shown.
struct Excerpts<'a> {
    files: Vec<Excerpt<'a>>,
    /// Of each label: its file, and its place in that file's excerpt with the column there. None where it is not shown.
    places: Vec<Option<(usize, Range<usize>, usize)>>,
}

/// The shown lines of a file.
struct Excerpt<'a> {
    file: &'a SourceFile,
    text: String,
    /// Sorted by index.
    lines: Vec<Line>,
    /// Where labels begin in `text`, and the columns of these places in the file.
    columns: Vec<(usize, usize)>,
}

/// A shown line.
struct Line {
    /// In the file.
    index: usize,
    /// In the excerpt's text, with its end.
    span: Range<usize>,
}

impl<'a> Excerpts<'a> {
    fn new(labels: &'a [Label], lines: &[usize], room: usize) -> Self {
        let mut files: Vec<Excerpt<'a>> = Vec::new();
        let mut of_label = Vec::with_capacity(labels.len());
        for label in labels {
            let known = files.iter().position(|e| is_same(e.file, &label.file));
            of_label.push(known.unwrap_or_else(|| {
                files.push(Excerpt {
                    file: &label.file,
                    text: String::new(),
                    lines: Vec::new(),
                    columns: Vec::new(),
                });
                files.len() - 1
            }));
        }
        let mut places = vec![None; labels.len()];
        for (number, excerpt) in files.iter_mut().enumerate() {
            let here = (0..labels.len()).filter(|&at| of_label[at] == number);
            let mut here: Vec<usize> = here.collect();
            // The first label of a line decides which part of it is shown.
            here.sort_by_key(|&at| (lines[at], !labels[at].primary, at));
            for of_line in here.chunk_by(|&a, &b| lines[a] == lines[b]) {
                let index = lines[of_line[0]];
                if excerpt
                    .lines
                    .last()
                    .is_some_and(|last| last.index + 2 == index)
                {
                    // The renderer shows a line that stands alone between two others.
                    let start = labels[of_line[0]].span.start;
                    let end = line_around(excerpt.file.text(), start)
                        .start
                        .saturating_sub(1);
                    let between = line_around(excerpt.file.text(), end);
                    let shown = Window::new(
                        excerpt.file.text(),
                        between.clone(),
                        between.start..between.start,
                        room,
                    );
                    excerpt.push(index - 1, &shown);
                }
                let main = &labels[of_line[0]];
                let line = line_around(main.file.text(), main.span.start);
                let shown = Window::new(main.file.text(), line.clone(), main.span.clone(), room);
                let offset = excerpt.text.len();
                excerpt.push(index, &shown);
                for &at in of_line {
                    let span = &labels[at].span;
                    let Some(within) = shown.span(span.start..span.end.min(line.end)) else {
                        continue;
                    };
                    let column = width(&shown.text[..within.start]);
                    let start = offset + within.start;
                    let before = &main.file.text()[line.start..span.start];
                    excerpt.columns.push((start, before.chars().count() + 1));
                    places[at] = Some((number, start..offset + within.end, column));
                }
            }
        }
        Self { files, places }
    }

    fn place(&mut self, label: usize) -> Option<(usize, Range<usize>, usize)> {
        self.places[label].take()
    }
}

impl Excerpt<'_> {
    fn push(&mut self, index: usize, shown: &Window) {
        let start = self.text.len();
        self.text.push_str(&shown.text);
        self.text.push('\n');
        let span = start..self.text.len();
        self.lines.push(Line { index, span });
    }
}

fn is_same(a: &SourceFile, b: &SourceFile) -> bool {
    Arc::ptr_eq(&a.text, &b.text) && a.path == b.path
}

/// The line that a byte lies in, without its end.
fn line_around(text: &str, at: usize) -> Range<usize> {
    let start = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
    let end = text[at..]
        .find('\n')
        .map_or(text.len(), |newline| at + newline);
    let line = &text[start..end];
    start..start + line.strip_suffix('\r').unwrap_or(line).len()
}

/// What is shown of a line.
struct Window {
    text: String,
    /// Byte in the file and in `text` of each character shown, and of the end.
    cells: Vec<(usize, usize)>,
}

impl Window {
    /// The part of a line around `mark` that fits.
    fn new(text: &str, line: Range<usize>, mark: Range<usize>, room: usize) -> Self {
        // Far more than fits, so that a line of a megabyte costs no more than another one.
        let far = 8 * room;
        let from = floor(text, mark.start.saturating_sub(far).max(line.start));
        let to = floor(text, (mark.start + far).min(line.end)).max(from);
        let (mut pieces, mut column) = (Vec::new(), 0);
        for (offset, c) in text[from..to].char_indices() {
            let mut piece = String::new();
            match c {
                '\t' => piece.extend(std::iter::repeat_n(' ', TAB - column % TAB)),
                c if must_be_escaped(c) => piece.extend(c.escape_unicode()),
                c => piece.push(c),
            }
            let wide = if piece.chars().count() == 1 {
                width_of(c)
            } else {
                piece.len()
            };
            pieces.push((from + offset, piece, column, wide));
            column += wide;
        }
        let is_whole = from == line.start && to == line.end && column <= room;
        let (mut first, mut last) = (0, pieces.len());
        if !is_whole {
            let marked = pieces.partition_point(|piece| piece.0 < mark.start);
            let at = pieces.get(marked).map_or(column, |piece| piece.2);
            let room = room.saturating_sub(2 * CUT.len());
            // A third of the room lies before the mark; more where the line ends.
            let start = at.saturating_sub(room / 3).min(column.saturating_sub(room));
            first = pieces.partition_point(|piece| piece.2 < start);
            last = pieces.partition_point(|piece| piece.2 + piece.3 <= start + room);
        }
        let begins = pieces.get(first).map_or(from, |piece| piece.0);
        let ends = pieces.get(last).map_or(to, |piece| piece.0);
        let mut shown = Self {
            text: String::new(),
            cells: Vec::with_capacity(last - first + 1),
        };
        if begins > line.start {
            shown.text.push_str(CUT);
        }
        for (byte, piece, ..) in &pieces[first..last] {
            shown.cells.push((*byte, shown.text.len()));
            shown.text.push_str(piece);
        }
        shown.cells.push((ends, shown.text.len()));
        if ends < line.end {
            shown.text.push_str(CUT);
        }
        shown
    }

    /// Where a range of the file is in the shown text, as far as it is in it.
    fn span(&self, range: Range<usize>) -> Option<Range<usize>> {
        let (first, last) = (self.cells.first()?.0, self.cells.last()?.0);
        if range.end < first || range.start > last {
            return None;
        }
        let find = |byte: usize| {
            let at = self.cells.partition_point(|cell| cell.0 < byte);
            self.cells[at.min(self.cells.len() - 1)].1
        };
        let start = find(range.start.max(first));
        Some(start..find(range.end.min(last)).max(start))
    }
}

fn floor(text: &str, mut at: usize) -> usize {
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

impl<'a> Files<'a> for Excerpts<'a> {
    type FileId = usize;
    type Name = std::borrow::Cow<'a, str>;
    type Source = &'a str;

    fn name(&'a self, id: usize) -> Result<Self::Name, Error> {
        Ok(printable(self.file(id)?.file.path()))
    }

    fn source(&'a self, id: usize) -> Result<&'a str, Error> {
        Ok(&self.file(id)?.text)
    }

    fn line_index(&'a self, id: usize, byte: usize) -> Result<usize, Error> {
        let lines = &self.file(id)?.lines;
        let at = lines.partition_point(|line| line.span.end <= byte);
        let line = lines.get(at).or(lines.last()).ok_or(Error::FileMissing)?;
        Ok(line.index)
    }

    fn line_range(&'a self, id: usize, index: usize) -> Result<Range<usize>, Error> {
        let lines = &self.file(id)?.lines;
        let at = lines.binary_search_by_key(&index, |line| line.index);
        let max = lines.last().map_or(0, |line| line.index);
        let at = at.map_err(|_| Error::LineTooLarge { given: index, max })?;
        Ok(lines[at].span.clone())
    }

    /// Only places where labels begin are asked for.
    fn location(&'a self, id: usize, byte: usize) -> Result<Location, Error> {
        let columns = &self.file(id)?.columns;
        let column = columns.iter().find(|(start, _)| *start == byte);
        Ok(Location {
            line_number: self.line_index(id, byte)? + 1,
            column_number: column.map_or(1, |(_, column)| *column),
        })
    }
}

impl Excerpts<'_> {
    fn file(&self, id: usize) -> Result<&Excerpt<'_>, Error> {
        self.files.get(id).ok_or(Error::FileMissing)
    }
}
