//! naga's verdict on a texture, in the user's terms: every error of the file with its place and a remedy.
//!
//! naga stops at the first error of a module. To show all of them, the function an error lies in is replaced by an
//! empty one and the module is tried again, until naga is content or no function can be blamed.

use std::error::Error;
use std::ops::Range;

use naga::front::wgsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::diagnostic::{Diagnostic, Diagnostics, SourceFile};
use crate::refuse::prelude_names;
use crate::scope::{Outline, Role};
use crate::suggest::did_you_mean;

/// The published prelude: with it in front, a texture is a complete WGSL module.
pub const PRELUDE: &str = include_str!("prelude.wgsl");

/// No more errors than this are reported for one file.
const MAX_ERRORS: usize = 20;

/// Parses and validates the file with the prelude behind it (spans in the file stay what they are) and constants
/// for the custom attributes it reads.
///
/// # Errors
/// All errors naga can be made to show.
pub(crate) fn parse(
    file: &SourceFile,
    outline: &Outline<'_>,
    custom: &[String],
) -> Result<naga::Module, Diagnostics> {
    let mut text = outline.text.to_owned();
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
    let mut problems = Diagnostics::new();
    loop {
        match check(&format!("{text}{tail}")) {
            Ok(module) if problems.is_empty() => return Ok(module),
            Ok(_) => break,
            Err(problem) => {
                let blamed = problem.blamed_function(outline);
                problems.push(problem.into_diagnostic(file, outline));
                let Some(function) = blamed else { break };
                if problems.len() >= MAX_ERRORS
                    || !stub_function(outline, function, &mut text, &mut tail)
                {
                    break;
                }
            }
        }
    }
    problems.sort();
    Err(problems)
}

/// Blanks function `index` in `text` and declares one of the same signature in `tail`. False if it was done before.
fn stub_function(
    outline: &Outline<'_>,
    index: usize,
    text: &mut String,
    tail: &mut String,
) -> bool {
    let function = &outline.functions[index];
    let Some(global) = outline
        .globals
        .iter()
        .find(|global| global.name == Some(function.name))
    else {
        return false;
    };
    let span = outline.span_of(&global.tokens);
    if text[span.clone()].bytes().all(|byte| byte == b' ') {
        return false;
    }
    let header = outline.span(global.keyword).start..outline.span(function.body.start).start;
    // `loop {}` never ends, so no result is missing.
    tail.push_str(&format!("{} {{ loop {{}} }}\n", &outline.text[header]));
    text.replace_range(span.clone(), &" ".repeat(span.len()));
    true
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
    })?;
    match Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module) {
        Ok(_) => Ok(module),
        Err(error) => Err(Problem::from_validation(&error)),
    }
}

/// An error of naga's in a text.
#[derive(Debug)]
pub(crate) struct Problem {
    pub(crate) message: String,
    pub(crate) labels: Vec<(Range<usize>, String)>,
    pub(crate) notes: Vec<String>,
    /// The function it was found in, where naga says.
    function: Option<String>,
}

impl Problem {
    fn from_validation(error: &naga::WithSpan<naga::valid::ValidationError>) -> Self {
        let mut chain = vec![error.as_inner().to_string()];
        let mut source = error.as_inner().source();
        while let Some(inner) = source {
            chain.push(inner.to_string());
            source = inner.source();
        }
        let function = match error.as_inner() {
            naga::valid::ValidationError::Function { name, .. } => Some(name.clone()),
            _ => None,
        };
        let message = chain.pop().unwrap_or_default();
        let mut labels: Vec<(Range<usize>, String)> = error
            .spans()
            .filter_map(|(span, label)| Some((span.to_range()?, label.clone())))
            .collect();
        // The narrowest place is the one to look at; labels like "naga::Expression [7]" mean nothing to a user.
        labels.sort_by_key(|(span, _)| span.len());
        for (_, label) in &mut labels {
            if label.starts_with("naga::") {
                label.clear();
            }
        }
        Self {
            message,
            labels,
            notes: Vec::new(),
            function,
        }
    }

    /// The function of the file that the error lies in.
    fn blamed_function(&self, outline: &Outline<'_>) -> Option<usize> {
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
        let mut diagnostic = Diagnostic::error(plain_message(&self.message));
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
            labels.extend(function.map(|function| (outline.span(function.name), String::new())));
        }
        for (index, (span, text)) in labels.into_iter().enumerate() {
            diagnostic = if index == 0 {
                diagnostic.with_label(file, span, plain_message(&text))
            } else {
                diagnostic.with_secondary(file, span, plain_message(&text))
            };
        }
        for note in self.notes {
            diagnostic = diagnostic.with_note(note);
        }
        for note in remedies(&self.message, &diagnostic, outline) {
            diagnostic = diagnostic.with_note(note);
        }
        diagnostic
    }
}

/// naga's message without its internal numbers: `Expression [7]`, `Handle([3])`.
fn plain_message(message: &str) -> String {
    let mut out = String::new();
    let mut rest = message;
    while let Some(at) = rest.find(" [") {
        let digits = rest[at + 2..]
            .bytes()
            .take_while(u8::is_ascii_digit)
            .count();
        if digits > 0 && rest[at + 2 + digits..].starts_with(']') {
            out.push_str(&rest[..at]);
            rest = &rest[at + 2 + digits + 1..];
        } else {
            out.push_str(&rest[..at + 2]);
            rest = &rest[at + 2..];
        }
    }
    out + rest
}

fn remedies(message: &str, diagnostic: &Diagnostic, outline: &Outline<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    let message = message.to_lowercase();
    if message.contains("no definition in scope") || message.contains("unknown type") {
        if let Some(label) = diagnostic.labels.first() {
            let word = &outline.text[label.span.clone()];
            if let Some(near) = did_you_mean(word, names_in_scope(outline, label.span.start)) {
                notes.push(format!("did you mean `{near}`?"));
            }
        }
    }
    if message.contains("is recursive") || message.contains("is cyclic") {
        notes.push("WGSL has no recursion: use a loop, with a bounded number of iterations".into());
    }
    if message.contains("redefinition") {
        notes.push("names of functions, structs, constants and aliases are unique within a file: rename one of them".into());
    }
    notes
}

/// WGSL's own names that a texture is likely to want.
const BUILTINS: &str = "abs acos all any asin atan atan2 bool ceil clamp cos cosh cross degrees distance dot exp \
    exp2 f32 faceForward floor fma fract i32 inverseSqrt ldexp length log log2 mat2x2f mat3x3f \
    mat4x4f max min mix modf normalize pow radians reflect refract round saturate select sign \
    sin sinh smoothstep sqrt step tan tanh transpose trunc u32 vec2f vec2i vec2u vec3f vec3i \
    vec3u vec4f vec4i vec4u";

/// Names that may be meant at a place: the file's, the prelude's, locals, and common built-ins.
fn names_in_scope<'a>(outline: &Outline<'a>, place: usize) -> Vec<&'a str> {
    let in_place = outline
        .functions
        .iter()
        .find(|function| outline.span_of(&function.body).contains(&place));
    let mut names: Vec<&'a str> = Vec::new();
    for (at, role) in outline.roles.iter().enumerate() {
        let declares_local = *role == Role::Local(at)
            && in_place.is_some_and(|function| {
                function.body.contains(&at) || function.params.iter().any(|param| param.name == at)
            });
        if declares_local && outline.span(at).start < place {
            names.push(outline.word(at));
        }
    }
    names.extend(
        outline
            .globals
            .iter()
            .filter_map(|global| global.name)
            .map(|name| outline.word(name)),
    );
    names.extend(prelude_names().map(|name| -> &'a str { name }));
    names.extend(BUILTINS.split_whitespace());
    names
}
