//! Finds what a file reads: every `readAttr(NAME)` and `readGlobal(NAME)`, and every misuse of those names.

use std::collections::HashSet;

use crate::attribute::{Attribute, BUILTIN_ATTRIBUTES, BuiltinAttribute, GLOBALS, Global};
use crate::diagnostic::{Diagnostic, Diagnostics, SourceFile};
use crate::scope::{Outline, Role};
use crate::suggest::did_you_mean;
use crate::tokens::TokenKind;

/// What one call reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ReadSource {
    Attribute(Attribute),
    Global(Global),
}

/// One call of `readAttr` or `readGlobal`, by token index.
#[derive(Clone, Debug)]
pub(crate) struct Read {
    pub(crate) callee: usize,
    pub(crate) name: usize,
    /// A comma behind the name, which WGSL allows.
    pub(crate) comma: Option<usize>,
    pub(crate) source: ReadSource,
}

/// All calls of a file, and what is wrong with them.
pub(crate) fn find_reads(file: &SourceFile, outline: &Outline<'_>) -> (Vec<Read>, Diagnostics) {
    let mut reads = Vec::new();
    let mut problems = Diagnostics::new();
    let custom = custom_reads(outline);
    let mut at = 0;
    while at < outline.tokens.tokens.len() {
        let predeclared = outline.roles[at] == Role::Predeclared;
        let word = outline.word(at);
        if predeclared && matches!(word, "readAttr" | "readGlobal") {
            if outline.word(at + 1) != "(" {
                problems.push(
                    Diagnostic::error(format!("`{word}` can only be called"))
                        .with_label(file, outline.span(at), "")
                        .with_note(format!("write `{word}(NAME)`")),
                );
                at += 1;
                continue;
            }
            let close = outline.closing(at + 1);
            match read(file, outline, at, close) {
                Ok(read) => reads.push(read),
                Err(problem) => problems.push(problem),
            }
            at = close + 1;
            continue;
        }
        let of_mesh = || (is_custom(word) && custom.contains(word)).then_some("readAttr");
        if let Some(reader) = reader_of(word).or_else(of_mesh).filter(|_| predeclared) {
            problems.push(
                Diagnostic::error(format!("`{word}` is a name to be read, not a value"))
                    .with_label(file, outline.span(at), "")
                    .with_note(format!("write `{reader}({word})`")),
            );
        }
        at += 1;
    }
    (reads, problems)
}

/// Whether an attribute of the mesh may be called so.
fn is_custom(name: &str) -> bool {
    name.starts_with('_') && name.len() > 1
}

/// The attributes of the mesh that a file reads: by themselves their names are nothing.
fn custom_reads<'a>(outline: &Outline<'a>) -> HashSet<&'a str> {
    let tokens = 0..outline.tokens.tokens.len();
    let readers = tokens.filter(|&at| {
        outline.roles[at] == Role::Predeclared
            && outline.word(at) == "readAttr"
            && outline.word(at + 1) == "("
    });
    let names = readers.map(|at| outline.word(at + 2));
    names.filter(|name| is_custom(name)).collect()
}

/// Whether the language's `tex2DLod` is mentioned.
pub(crate) fn reads_levels(outline: &Outline<'_>) -> bool {
    let mut tokens = 0..outline.tokens.tokens.len();
    tokens.any(|at| outline.roles[at] == Role::Predeclared && outline.word(at) == "tex2DLod")
}

fn reader_of(name: &str) -> Option<&'static str> {
    if BuiltinAttribute::from_name(name).is_some() {
        Some("readAttr")
    } else {
        Global::from_name(name).map(|_| "readGlobal")
    }
}

fn read(
    file: &SourceFile,
    outline: &Outline<'_>,
    callee: usize,
    close: usize,
) -> Result<Read, Diagnostic> {
    let reader = outline.word(callee);
    let name = callee + 2;
    let comma = (outline.word(name + 1) == ",").then_some(name + 1);
    let end = comma.map_or(name + 1, |comma| comma + 1);
    let is_name = outline
        .tokens
        .tokens
        .get(name)
        .is_some_and(|token| token.kind == TokenKind::Word);
    if end != close || !is_name {
        let inside = (name..close.max(name)).start;
        return Err(Diagnostic::error(format!("`{reader}` takes one name"))
            .with_label(file, outline.span(inside).start..outline.span(close).start.max(outline.span(inside).start), "")
            .with_note(format!(
                "the name is known when the kernel is built: write `{reader}({})`, and choose between several with `select` or `if`",
                if reader == "readAttr" { "TexCoord0" } else { "Time" }
            )));
    }
    let word = outline.word(name);
    let custom = reader == "readAttr" && is_custom(word);
    let local = match outline.roles[name] {
        Role::Local(declared) => Some(declared),
        // A file may declare `const _WETNESS = 0u;` itself to be valid WGSL elsewhere.
        Role::Global if !custom => outline
            .globals
            .iter()
            .filter_map(|g| g.name)
            .find(|&g| outline.word(g) == word),
        _ => None,
    };
    if let Some(declared) = local {
        return Err(Diagnostic::error(format!(
            "`{word}` is declared in this file: `{reader}` takes a name of the texture language"
        ))
        .with_label(file, outline.span(name), "")
        .with_secondary(file, outline.span(declared), "declared here")
        .with_note("rename the declaration if the attribute was meant"));
    }
    let source = if reader == "readGlobal" {
        Global::from_name(word).map(ReadSource::Global)
    } else if custom {
        Some(ReadSource::Attribute(Attribute::Custom(word.to_owned())))
    } else {
        BuiltinAttribute::from_name(word).map(|builtin| ReadSource::Attribute(builtin.into()))
    };
    match source {
        Some(source) => Ok(Read {
            callee,
            name,
            comma,
            source,
        }),
        None => Err(unknown(file, outline, reader, name)),
    }
}

fn unknown(file: &SourceFile, outline: &Outline<'_>, reader: &str, name: usize) -> Diagnostic {
    let word = outline.word(name);
    let kind = if reader == "readAttr" {
        "attribute"
    } else {
        "global"
    };
    let diagnostic = Diagnostic::error(format!("there is no {kind} called `{word}`"));
    let known: Vec<&str> = if reader == "readAttr" {
        BUILTIN_ATTRIBUTES
            .iter()
            .map(|attribute| attribute.name())
            .collect()
    } else {
        GLOBALS.iter().map(|global| global.name()).collect()
    };
    if let Some(other) = reader_of(word) {
        return diagnostic
            .with_label(file, outline.span(name), "")
            .with_note(format!("write `{other}({word})`"));
    }
    match did_you_mean(word, known.iter().copied()) {
        Some(near) => {
            diagnostic.with_label(file, outline.span(name), format!("did you mean `{near}`?"))
        }
        None => diagnostic.with_label(file, outline.span(name), ""),
    }
    .with_note(format!("the {kind}s are {}", known.join(", ")))
    .with_note(if reader == "readAttr" {
        "a custom attribute of the mesh begins with an underscore, as in glTF: `readAttr(_WETNESS)`"
    } else {
        "what belongs to the hit is read with `readAttr`"
    })
}
