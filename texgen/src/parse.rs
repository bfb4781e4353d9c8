//! naga's verdict on a texture, in the user's terms: every error of the file with its place and a remedy.
//!
//! naga stops at the first error of a module. To show all of them, what an error lies in is cut out (`recover`) and the
//! rest is tried again, until naga is content or nothing can be blamed.

use std::ops::Range;

use naga::front::wgsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::diagnostic::{Diagnostic, Diagnostics, SourceFile};
use crate::habits::Habit;
use crate::recover::{Attempt, Edits};
use crate::scope::Outline;
use crate::validation::{self, Conversion};
use crate::wording::{expected, in_user_terms, plain_message, plain_notes, remedies};

/// The published prelude: with it in front, a texture is a complete WGSL module.
pub const PRELUDE: &str = include_str!("prelude.wgsl");

/// No more errors of naga's than this are looked for in one file: each costs a parse.
const MAX_ERRORS: usize = 20;

/// What a texture may use beyond plain WGSL: `pack2x16float`, `unpack2x16float` and `quantizeToF16` compute with `f32`, and
/// all Vulkan, Metal and DirectX 12 devices have them.
pub const CAPABILITIES: Capabilities = Capabilities::SHADER_FLOAT16_IN_FLOAT32;

/// Parses and validates the file with the prelude behind it (spans in the file stay what they are) and constants
/// for the custom attributes it reads. What comes from another language was found before: the file is read without it.
///
/// # Errors
/// All errors naga can be made to show.
pub(crate) fn parse<'a>(
    file: &SourceFile,
    outline: &Outline<'a>,
    custom: &[String],
    habits: &[Habit<'a>],
) -> Result<naga::Module, Diagnostics> {
    if let Some(comment) = outline.tokens.unclosed() {
        // It would swallow what is put behind the file, and naga's places would lie there.
        let start = comment.start;
        return Err(Diagnostic::error("this comment is not closed")
            .with_label(file, start..start + 2, "it goes on to the end of the file")
            .with_note("close it with `*/`; comments within it need their own")
            .into());
    }
    let mut tail = format!("\n{PRELUDE}\n");
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
        let mut problem = match check(&text) {
            Ok(module) if problems.is_empty() && habits.is_empty() => return Ok(module),
            Ok(_) => break,
            Err(problem) => problem,
        };
        problem.undo(&edits);
        let is_new = !attempt.has_caused(&problem);
        let goes_on = attempt.mend(&problem);
        if is_new {
            let mut diagnostic = problem.into_diagnostic(file, outline);
            if goes_on && tried >= MAX_ERRORS {
                let note = "there may be more errors than these: correct them first";
                diagnostic = diagnostic.with_note(note);
            }
            problems.push(diagnostic);
        }
        if !goes_on || tried >= MAX_ERRORS {
            break;
        }
    }
    problems.sort();
    Err(problems)
}

/// Parses and validates a whole module.
pub(crate) fn check(text: &str) -> Result<naga::Module, Problem> {
    let module = wgsl::parse_str(text).map_err(|error| Problem {
        message: error.message().to_owned(),
        labels: error
            .labels()
            .filter_map(|(span, label)| Some((span.to_range()?, label.to_owned())))
            .collect(),
        notes: error.notes().map(str::to_owned).collect(),
        function: None,
        conversion: None,
    })?;
    match Validator::new(ValidationFlags::all(), CAPABILITIES).validate(&module) {
        Ok(_) => Ok(module),
        Err(error) => Err(validation::problem(&error, &module)),
    }
}

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

impl Problem {
    /// Moves places in an edited text to where they are in the file.
    fn undo(&mut self, edits: &Edits) {
        let original = |span: &Range<usize>| {
            let start = edits.original(span.start);
            start..edits.original(span.end).max(start)
        };
        for (span, _) in &mut self.labels {
            *span = original(span);
        }
        if let Some(Conversion {
            operand: Some(span),
            ..
        }) = self.conversion.as_deref_mut()
        {
            *span = original(span);
        }
    }

    /// Whether the parser had expected a `;`.
    pub(crate) fn lacks_semicolon(&self) -> bool {
        expected(&self.message) == Some("`;`")
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

    fn into_diagnostic(self, file: &SourceFile, outline: &Outline<'_>) -> Diagnostic {
        let length = outline.text.len();
        let ended = self
            .labels
            .first()
            .is_some_and(|(span, _)| span.start >= length);
        let lacks_semicolon = self.lacks_semicolon();
        let mut message = in_user_terms(&self.message);
        if ended {
            // naga read on into the prelude: it wanted more of the file.
            let expected = message.split(", found").next().unwrap_or_default();
            message = format!("{expected}, found the end of the file");
        }
        let mut diagnostic = Diagnostic::error(message);
        let mut labels: Vec<_> = self
            .labels
            .into_iter()
            .filter(|(span, _)| span.start < length && span.end <= length)
            .collect();
        if labels.is_empty() {
            let function = self
                .function
                .as_deref()
                .and_then(|name| outline.function(name));
            let last = outline.tokens.tokens.len().saturating_sub(1);
            let place = function.map_or(last, |function| function.name);
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
            let mut text = plain_message(&text);
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
        for note in plain_notes(&self.notes) {
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
