//! Shared files of a texture's own: `/// @use NAME` takes the functions of `lib/NAME.wgsl`.
//!
//! A texture and the files that it uses are checked and emitted as one text; whatever is said about a place in it is said about
//! the file that the place is in.

use std::ops::Range;

use crate::diagnostic::{Diagnostic, Diagnostics, Label, SourceFile};
use crate::tokens::tokenize;

/// The names behind `@use` in a text's `///` and `//!` lines, with their places.
pub(crate) fn uses(text: &str) -> Vec<(String, Range<usize>)> {
    let tokens = tokenize(text);
    let mut found = Vec::new();
    for comment in &tokens.comments {
        let marked = ["///", "//!"]
            .iter()
            .any(|mark| comment.text.starts_with(mark));
        let Some(rest) = comment.text.get(3..).filter(|_| marked) else {
            continue;
        };
        let Some(names) = rest.trim_start().strip_prefix("@use ") else {
            continue;
        };
        let mut at = comment.start + comment.text.len() - names.len();
        for name in names.split([' ', ',', '\r', '\n']) {
            if !name.is_empty() {
                found.push((name.to_owned(), at..at + name.len()));
            }
            at += name.len() + 1;
        }
    }
    found
}

/// Names of the shared files that a text uses itself, in their order.
pub fn used_libraries(text: &str) -> Vec<String> {
    uses(text).into_iter().map(|(name, _)| name).collect()
}

/// A stretch of the whole text, and the file that it is.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Bytes of the whole text.
    pub(crate) range: Range<usize>,
    pub(crate) file: SourceFile,
}

/// A texture with the files that it uses behind it.
#[derive(Clone, Debug)]
pub(crate) struct Whole {
    /// Its name and path are the texture's.
    pub(crate) file: SourceFile,
    pub(crate) parts: Vec<Part>,
}

impl Whole {
    /// # Errors
    /// A file that isn't there, or one that uses itself; in the file that says `@use`.
    pub(crate) fn new(file: &SourceFile) -> Result<Self, Diagnostics> {
        let mut problems = Diagnostics::new();
        let mut order = Vec::new();
        let mut open = vec![file.clone()];
        gather(file, file, &mut open, &mut order, &mut problems);
        if !problems.is_empty() {
            return Err(problems);
        }
        // Blanks of a byte-order mark's length keep all positions.
        let blanked = |text: &str| match text.strip_prefix('\u{feff}') {
            Some(rest) => format!("   {rest}"),
            None => text.to_owned(),
        };
        let mut text = blanked(file.text());
        let mut parts = vec![Part {
            range: 0..text.len(),
            file: file.clone(),
        }];
        for library in order {
            text.push('\n');
            let start = text.len();
            text.push_str(&blanked(library.text()));
            parts.push(Part {
                range: start..text.len(),
                file: library,
            });
        }
        let file = SourceFile::new(file.name(), file.path(), text);
        Ok(Self { file, parts })
    }

    /// Bytes of the texture's own file.
    pub(crate) fn own_len(&self) -> usize {
        self.parts[0].range.len()
    }

    /// The part that a place lies in; behind the last one, that one.
    pub(crate) fn part_at(&self, offset: usize) -> &Part {
        let at = self
            .parts
            .partition_point(|part| part.range.start <= offset);
        &self.parts[at.max(1) - 1]
    }

    /// The same problems in the files that they are in.
    pub(crate) fn placed(&self, problems: Diagnostics) -> Diagnostics {
        let placed = |label: Label| {
            if label.file != self.file {
                return label;
            }
            let part = self.part_at(label.span.start);
            let within = |offset: usize| {
                offset
                    .saturating_sub(part.range.start)
                    .min(part.range.len())
            };
            Label {
                file: part.file.clone(),
                span: within(label.span.start)..within(label.span.end),
                ..label
            }
        };
        problems.map(|problem| Diagnostic {
            labels: problem.labels.into_iter().map(placed).collect(),
            ..problem
        })
    }
}

/// Adds the files that `file` uses, each once, and those that they use.
fn gather(
    texture: &SourceFile,
    file: &SourceFile,
    open: &mut Vec<SourceFile>,
    order: &mut Vec<SourceFile>,
    problems: &mut Diagnostics,
) {
    for (name, span) in uses(file.text()) {
        if open.iter().skip(1).any(|one| one.name() == name) {
            let names: Vec<String> = (open.iter().skip(1))
                .map(|one| format!("`{}`", one.name()))
                .collect();
            problems.push(
                Diagnostic::error(format!("`{name}` uses itself"))
                    .with_label(file, span, format!("here, by way of {}", names.join(", ")))
                    .with_note("move what both need into a third file"),
            );
            continue;
        }
        if order.iter().any(|one| one.name() == name) {
            continue;
        }
        let Some(library) = texture.libraries().iter().find(|one| one.name() == name) else {
            let names = texture.libraries().iter().map(SourceFile::name);
            let near = crate::suggest::did_you_mean(&name, names);
            problems.push(
                Diagnostic::error(format!("there is no shared file `{name}`"))
                    .with_label(
                        file,
                        span,
                        near.map_or(String::new(), |near| format!("did you mean `{near}`?")),
                    )
                    .with_note(format!(
                        "it is looked for as `lib/{name}.wgsl` in the folder of the texture"
                    )),
            );
            continue;
        };
        open.push(library.clone());
        gather(texture, library, open, order, problems);
        open.pop();
        // Twice where two others came to it: once is enough.
        if !order.iter().any(|one| one.name() == name) {
            order.push(library.clone());
        }
    }
}
