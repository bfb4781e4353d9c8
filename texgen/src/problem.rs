//! An error of naga's, and how it is told in the user's terms.

mod plain;

use std::ops::Range;

use plain::{in_plain_words, of_literals, of_vector_and_number, type_in};

use crate::diagnostic::{Diagnostic, SourceFile};
use crate::scope::{GlobalKind, Outline};
use crate::wording::{
    expected, in_user_terms, parameter_to_copy, plain_message, plain_notes, remedies,
};

pub(crate) use plain::refused_operator;

/// A number such as `2.0`, which becomes an `f32` by itself, but no integer.
pub(crate) const FRACTION: &str = "a number with a fraction";

/// An error of naga's in a text.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) message: String,
    pub(crate) labels: Vec<(Range<usize>, String)>,
    pub(crate) notes: Vec<String>,
    /// The function it was found in, where naga says.
    pub(crate) function: Option<String>,
    pub(crate) conversion: Option<Box<Conversion>>,
}

/// An operand of the wrong type, and the conversion that makes it fit.
#[derive(Clone, Debug)]
pub(crate) struct Conversion {
    /// Its place, or its name where naga knows no more than that.
    pub(crate) operand: Option<Range<usize>>,
    pub(crate) name: Option<String>,
    /// As `f32`.
    pub(crate) to: String,
}

impl Problem {
    /// Whether naga says neither its place nor the function that it is in.
    pub(crate) fn is_unplaced(&self) -> bool {
        self.labels.is_empty() && self.function.is_none()
    }

    /// Puts an expression in front of the struct whose member it doesn't fit, and leaves out what isn't in the file.
    pub(crate) fn sort_labels(&mut self, outline: &Outline<'_>) {
        let is_inside = |span: &Range<usize>| span.start < outline.text.len();
        if self.labels.iter().any(|(span, _)| is_inside(span)) {
            self.labels.retain(|(span, _)| is_inside(span));
        }
        if self.labels.len() < 2 || !self.message.starts_with("automatic conversions") {
            return;
        }
        let wanted = self.labels[0].0.start;
        let structure = outline.globals.iter().find(|global| {
            global.kind == GlobalKind::Struct && outline.span_of(&global.tokens).contains(&wanted)
        });
        if let Some(name) = structure.and_then(|structure| structure.name) {
            self.labels[0] = (outline.span(name), "its members are declared here".into());
            self.labels.swap(0, 1);
        }
    }

    /// Whether the parser had expected a `;`.
    pub(crate) fn lacks_semicolon(&self) -> bool {
        expected(&self.message) == Some("`;`")
    }

    /// Whether a `break if` stands where there can't be one.
    pub(crate) fn is_of_break_if(&self) -> bool {
        self.message.starts_with("A break if")
    }

    /// Whether cases of a `switch` don't go together.
    pub(crate) fn is_of_cases(&self) -> bool {
        let first = self.labels.first();
        first.is_some_and(|(_, text)| text.ends_with("switch arm here"))
    }

    /// Whether a number that has no type of its own stands beside something that it doesn't become like, and naga says no more.
    pub(crate) fn is_of_mixture(&self) -> bool {
        plain::is_of_mixture(&self.message)
    }

    /// The function of the file that the error lies in.
    pub(crate) fn function_in(&self, outline: &Outline<'_>) -> Option<usize> {
        let by_name = self.function.as_ref().and_then(|name| {
            outline
                .functions
                .iter()
                .position(|function| outline.word(function.name) == name)
        });
        by_name.or_else(|| {
            let place = self.labels.first()?.0.start;
            outline
                .functions
                .iter()
                .position(|function| outline.span_of(&function.body).contains(&place))
        })
    }

    /// What the user is told: marks, and remedies where any are known.
    pub(crate) fn into_diagnostic(self, file: &SourceFile, outline: &Outline<'_>) -> Diagnostic {
        let length = outline.text.len();
        let ended = self
            .labels
            .first()
            .is_some_and(|(span, _)| span.start >= length);
        let lacks_semicolon = self.lacks_semicolon();
        let of_arguments = of_vector_and_number(&self.message, &self.labels, outline.text);
        let is_of_arguments = of_arguments.is_some();
        let first = self.labels.first().filter(|_| self.is_of_mixture());
        let special =
            of_arguments.or_else(|| first.and_then(|(span, _)| of_literals(outline, span)));
        let (mut message, remedy) = match special {
            Some((message, remedy)) => (message, Some(remedy)),
            None => in_plain_words(&self.message)
                .unwrap_or_else(|| (in_user_terms(&self.message), None)),
        };
        if ended {
            // naga read on into the prelude: it wanted more of the file.
            message = match expected(&self.message) {
                Some(what) => format!("expected {what}, found the end of the file"),
                None => "something is missing at the end of the file".to_owned(),
            };
        }
        let mut diagnostic = Diagnostic::error(message);
        let mut labels: Vec<_> = self
            .labels
            .into_iter()
            .filter(|(span, _)| span.start < length)
            .map(|(span, text)| (span.start..span.end.min(length), text))
            .collect();
        if labels.is_empty() {
            let function = self
                .function
                .as_deref()
                .and_then(|name| outline.function(name));
            let place = match function.or_else(|| outline.function("userProc")) {
                _ if ended => outline.tokens.tokens.len().saturating_sub(1),
                Some(function) => function.name,
                None => 0,
            };
            labels.push((outline.span(place), String::new()));
        }
        let found = labels.clone();
        for (index, (mut span, text)) in labels.into_iter().enumerate() {
            // A function as a whole is marked at its name.
            let whole = outline
                .functions
                .iter()
                .find(|f| span == (outline.span(f.keyword).start..outline.span_of(&f.body).end));
            if let Some(function) = whole {
                span = outline.span(function.name);
            }
            let mut text = match type_in(&text).filter(|_| is_of_arguments) {
                Some(ty) if ty.starts_with("vec") => "a vector".to_owned(),
                Some(_) => "a number".to_owned(),
                None => plain_message(&text),
            };
            if index == 0 && lacks_semicolon && !ended {
                // It is missing where the statement ends, not where the next one begins.
                let before = outline.tokens.tokens.iter();
                let before = before.take_while(|token| token.end() <= span.start).last();
                let end = before.map_or(span.start, |token| token.end());
                (span, text) = (end..end, "`;` is missing here".into());
            }
            if index == 0 {
                diagnostic = diagnostic.with_label(file, span, text);
            } else if !text.is_empty() {
                diagnostic = diagnostic.with_secondary(file, span, text);
            }
        }
        let notes = match parameter_to_copy(&found, outline) {
            Some(note) => vec![note],
            // They speak of one of the arguments only.
            None if is_of_arguments => Vec::new(),
            None => plain_notes(&self.notes),
        };
        for note in notes.into_iter().chain(remedy) {
            diagnostic = diagnostic.with_note(note);
        }
        if ended {
            diagnostic =
                diagnostic.with_note("something is not closed: look for a missing `}`, `)` or `;`");
        }
        if let Some(Conversion { operand, name, to }) = self.conversion.as_deref() {
            let text = operand.clone().and_then(|span| outline.text.get(span));
            let text = text
                .or(name.as_deref())
                .filter(|text| text.len() <= 60 && !text.contains('\n'));
            diagnostic = diagnostic.with_note(match text {
                Some(text) => format!("convert: `{to}({text})`"),
                None => format!("convert one of them: `{to}(...)`"),
            });
        }
        for note in remedies(&self.message, &found, outline) {
            diagnostic = diagnostic.with_note(note);
        }
        diagnostic
    }
}
