//! naga's verdict on a texture, in the user's terms: every error of the file with its place and a remedy.
//!
//! naga stops at the first error of a module. To show all of them, the function an error lies in is replaced by an
//! empty one and the module is tried again, until naga is content or no function can be blamed.

use std::collections::BTreeSet;
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
    let mut attempt = Attempt {
        outline,
        stubs: BTreeSet::new(),
        tail: format!("\n{PRELUDE}\n"),
    };
    for (index, name) in custom.iter().enumerate() {
        let declared = outline
            .globals
            .iter()
            .any(|global| global.name.is_some_and(|at| outline.word(at) == name));
        if !declared {
            attempt
                .tail
                .push_str(&format!("const {name} = {}u;\n", 1000 + index));
        }
    }
    let mut problems = Diagnostics::new();
    loop {
        let (text, insertions) = attempt.text();
        match check(&text) {
            Ok(module) if problems.is_empty() => return Ok(module),
            Ok(_) => break,
            Err(mut problem) => {
                problem.undo_insertions(&insertions);
                let blamed = problem.blamed_function(outline);
                problems.push(problem.into_diagnostic(file, outline));
                let Some(function) = blamed else { break };
                if problems.len() >= MAX_ERRORS || !attempt.stub(function) {
                    break;
                }
            }
        }
    }
    problems.sort();
    Err(problems)
}

/// The module that naga is given.
struct Attempt<'o, 'a> {
    outline: &'o Outline<'a>,
    /// Functions that are replaced by empty ones.
    stubs: BTreeSet<usize>,
    /// What comes behind the file's text.
    tail: String,
}

impl Attempt<'_, '_> {
    /// Replaces a function by one of the same signature. False if it was done before.
    fn stub(&mut self, index: usize) -> bool {
        let function = &self.outline.functions[index];
        let header =
            self.outline.span(function.keyword).start..self.outline.span(function.body.start).start;
        let body = if function.result.is_empty() {
            String::new()
        } else {
            let (zero, alias) = self.zero(index);
            self.tail.push_str(&alias);
            format!("return {zero};")
        };
        self.tail
            .push_str(&format!("{} {{ {body} }}\n", &self.outline.text[header]));
        self.stubs.insert(index)
    }

    /// A zero of a function's result type, and the alias to be declared for it where a local hides the type's name.
    fn zero(&self, index: usize) -> (String, String) {
        let function = &self.outline.functions[index];
        let result = &self.outline.text[self.outline.span_of(&function.result)];
        if !self.outline.shadows_its_result(function) {
            return (format!("{result}()"), String::new());
        }
        let name = format!("patina_result{index}");
        let alias = format!("alias {name} = {result};\n");
        (format!("{name}()"), alias)
    }

    /// The text, and where how many bytes were inserted into the file's.
    fn text(&self) -> (String, Vec<(usize, usize)>) {
        let mut text = self.outline.text.to_owned();
        let mut insertions = Vec::new();
        let mut aliases = String::new();
        for (index, function) in self.outline.functions.iter().enumerate().rev() {
            if self.stubs.contains(&index) {
                let span = self.outline.span(function.keyword).start
                    ..self.outline.span_of(&function.body).end;
                text.replace_range(span.clone(), &" ".repeat(span.len()));
            } else if self.outline.ends_with_endless_loop(function) {
                let at = self.outline.span(function.body.end - 1).start;
                let (zero, alias) = self.zero(index);
                let inserted = format!(" return {zero};");
                text.insert_str(at, &inserted);
                aliases.push_str(&alias);
                insertions.push((at, inserted.len()));
            }
        }
        insertions.reverse();
        (text + &self.tail + &aliases, insertions)
    }
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

    /// Moves places in a text with insertions to where they are without.
    fn undo_insertions(&mut self, insertions: &[(usize, usize)]) {
        let original = |offset: usize| {
            let mut shift = 0;
            for &(at, length) in insertions {
                if at + shift < offset {
                    shift += length.min(offset - at - shift);
                }
            }
            offset - shift
        };
        for (span, _) in &mut self.labels {
            *span = original(span.start)..original(span.end);
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
        let ended = self
            .labels
            .first()
            .is_some_and(|(span, _)| span.start >= length);
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
        for (index, (mut span, text)) in labels.into_iter().enumerate() {
            // A function as a whole is marked at its name.
            let whole = outline
                .functions
                .iter()
                .find(|f| span == (outline.span(f.keyword).start..outline.span_of(&f.body).end));
            if let Some(function) = whole {
                span = outline.span(function.name);
            }
            let text = plain_message(&text);
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
        for note in remedies(&self.message, &diagnostic, outline) {
            diagnostic = diagnostic.with_note(note);
        }
        diagnostic
    }
}

/// naga's notes, with its lists of types in one line and without the types that textures don't have.
fn plain_notes(notes: &[String]) -> Vec<String> {
    let allowed = |note: &String| note.strip_prefix("allowed type: ").map(str::to_owned);
    let types: Vec<String> = notes
        .iter()
        .filter_map(allowed)
        .filter(|ty| {
            !["f16", "f64", "i64", "u64", "Abstract"]
                .iter()
                .any(|absent| ty.contains(absent))
        })
        .collect();
    let mut plain: Vec<String> = notes
        .iter()
        .filter(|note| allowed(note).is_none())
        .cloned()
        .collect();
    if let Some(last) = plain.last_mut().filter(|_| !types.is_empty()) {
        *last = format!("{} {}", last, types.join(", "));
    }
    plain
}

/// Messages of naga's that speak of its own structures, said so that an author of a texture understands them.
fn in_user_terms(message: &str) -> String {
    if let Some(rest) = message.strip_prefix("Argument ")
        && let Some((number, _)) = rest.split_once(" value ")
        && let Ok(number) = number.parse::<u32>()
    {
        return format!(
            "argument {} of the call is not of the type that the function declares",
            number + 1
        );
    }
    if message.starts_with("The `return` expression None") {
        return "not every way through the function ends with a `return` of its result".into();
    }
    if message.starts_with("The `return` expression Some") {
        return "the returned value is not of the type that the function declares".into();
    }
    let mut plain = plain_message(message);
    // One sentence style for all messages: they begin small, but for names.
    if plain.starts_with(|c: char| c.is_ascii_uppercase())
        && plain[1..].starts_with(|c: char| c.is_ascii_lowercase() || c == ' ')
    {
        plain[..1].make_ascii_lowercase();
    }
    plain
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
    type_names(out + rest)
}

/// Types as WGSL writes them, where naga shows its own structures.
fn type_names(mut message: String) -> String {
    if !message.contains("Scalar {") {
        return message;
    }
    let scalars = [("Float", "f32"), ("Sint", "i32"), ("Uint", "u32")];
    for (kind, name) in scalars {
        message = message.replace(&format!("Scalar {{ kind: {kind}, width: 4 }}"), name);
    }
    message = message.replace("Scalar { kind: Bool, width: 1 }", "bool");
    const SIZES: [(&str, u32); 3] = [("Bi", 2), ("Tri", 3), ("Quad", 4)];
    for scalar in ["f32", "i32", "u32", "bool"] {
        for (size, n) in SIZES {
            let vector = format!("Vector {{ size: {size}, scalar: {scalar} }}");
            message = message.replace(&vector, &format!("vec{n}<{scalar}>"));
            for (rows, m) in SIZES {
                let matrix =
                    format!("Matrix {{ columns: {size}, rows: {rows}, scalar: {scalar} }}");
                message = message.replace(&matrix, &format!("mat{n}x{m}<{scalar}>"));
            }
        }
        message = message.replace(&format!("Scalar({scalar})"), scalar);
    }
    // "(of type f32)" without the words around it that say the same again.
    message.replace("value of value ", "value of type ")
}

fn remedies(message: &str, diagnostic: &Diagnostic, outline: &Outline<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    let message = message.to_lowercase();
    let unknown = message.contains("no definition in scope") || message.contains("unknown type");
    if let Some(label) = diagnostic.labels.first().filter(|_| unknown) {
        let word = &outline.text[label.span.clone()];
        if let Some(near) = did_you_mean(word, names_in_scope(outline, label.span.start)) {
            notes.push(format!("did you mean `{near}`?"));
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
