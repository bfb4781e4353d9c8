//! The changes that turn a user's text into its section of the kernel: prefixes on module-scope names, calls that
//! read attributes, array parameters read in place, guards in loops. Comments, formatting and lines stay as they are.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::args;
use crate::attribute::{Attribute, BuiltinAttribute};
use crate::reads::{Read, ReadSource};
use crate::scope::{LoopDecl, Outline, Role};
use crate::standard;
use crate::value::{ElementType, ParameterType};

/// A part of replacement text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Piece {
    Text(String),
    /// The texture's prefix.
    Prefix,
    /// Name of the constant that is a custom attribute's index.
    CustomIndex(String),
}

/// `span` of the source is replaced by `pieces`; an empty span inserts.
#[derive(Clone, Debug)]
pub(crate) struct TextEdit {
    pub(crate) span: Range<usize>,
    pub(crate) pieces: Vec<Piece>,
}

/// All edits of a file, ordered by position and free of overlaps.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rewrite {
    pub(crate) edits: Vec<TextEdit>,
    /// Whether some loop counts against the iteration cap.
    pub(crate) guards_loops: bool,
}

/// Name of the kernel's function that reads one element of an array parameter in place.
pub(crate) fn element_reader(element: ElementType) -> String {
    format!("patina_element_{}", element.parameter_type())
}

/// Name of the kernel's function that reads a whole array parameter.
pub(crate) fn array_reader(element: ElementType, count: u32) -> String {
    format!("patina_array_{}_{count}", element.parameter_type())
}

/// The host's function for an attribute, and its argument.
fn host_function(attribute: BuiltinAttribute) -> (String, &'static str) {
    match attribute {
        BuiltinAttribute::AO => ("patina_attr_AO".into(), "patina_occlusion.x"),
        BuiltinAttribute::AO1 => ("patina_attr_AO".into(), "patina_occlusion.y"),
        other => (format!("patina_attr_{}", other.name()), ""),
    }
}

/// An attribute as the kernel reads it, a `vec4f`.
pub(crate) fn attribute_read(attribute: &Attribute) -> String {
    match attribute {
        Attribute::Custom(name) => format!("patina_attr_custom(patina_custom{name})"),
        Attribute::Builtin(builtin) => {
            let (callee, argument) = host_function(*builtin);
            format!("{callee}({argument})")
        }
    }
}

/// Whether the array parameter that token `at` names is read element by element there; else the kernel copies it.
pub(crate) fn is_read_in_place(outline: &Outline<'_>, at: usize) -> bool {
    outline.word(at + 1) == "["
}

/// Works out the edits. `parameters` are the types of `userProc`'s parameters in order.
pub(crate) fn rewrite(
    outline: &Outline<'_>,
    reads: &[Read],
    parameters: &[ParameterType],
) -> Rewrite {
    let mut rewriter = Rewriter {
        outline,
        edits: Vec::new(),
        aliased: BTreeSet::new(),
        own_arrays: BTreeSet::new(),
    };
    // Guards first: where two insertions meet, the guard stands before the statement.
    let guards_loops = rewriter.loop_guards();
    rewriter.returns_behind_loops();
    rewriter.prefixes(reads);
    rewriter.reads(reads);
    rewriter.array_parameters(parameters);
    rewriter.aliases();
    rewriter.own_array_readers(parameters);
    let mut edits = rewriter.edits;
    edits.sort_by_key(|edit| (edit.span.start, edit.span.end));
    Rewrite {
        edits,
        guards_loops,
    }
}

struct Rewriter<'o, 'a> {
    outline: &'o Outline<'a>,
    edits: Vec<TextEdit>,
    /// Functions whose result type needs a name that no local has, or a short one.
    aliased: BTreeSet<usize>,
    /// Array parameters that are read as a whole, as a type with names of the file.
    own_arrays: BTreeSet<usize>,
}

/// A result type of more bytes than this isn't written into each loop of its function, of which there may be thousands.
const LONG_TYPE: usize = 100;

impl Rewriter<'_, '_> {
    fn replace(&mut self, span: Range<usize>, text: impl Into<String>) {
        self.edits.push(TextEdit {
            span,
            pieces: vec![Piece::Text(text.into())],
        });
    }

    fn prefixes(&mut self, reads: &[Read]) {
        for at in 0..self.outline.tokens.tokens.len() {
            let is_read_name = || reads.binary_search_by_key(&at, |read| read.name).is_ok();
            if self.outline.roles[at] == Role::Global && !is_read_name() {
                let start = self.outline.span(at).start;
                self.edits.push(TextEdit {
                    span: start..start,
                    pieces: vec![Piece::Prefix],
                });
            } else if self.is_standard(at) {
                let start = self.outline.span(at).start;
                self.replace(start..start, standard::PREFIX);
            }
        }
    }

    /// Whether this names a standard function or structure.
    fn is_standard(&self, at: usize) -> bool {
        self.outline.roles[at] == Role::Predeclared && standard::is_standard(self.outline.word(at))
    }

    fn reads(&mut self, reads: &[Read]) {
        for read in reads {
            let (callee, argument) = match &read.source {
                ReadSource::Attribute(Attribute::Custom(name)) => (
                    "patina_attr_custom".into(),
                    Piece::CustomIndex(name.clone()),
                ),
                ReadSource::Attribute(Attribute::Builtin(builtin)) => {
                    let (callee, argument) = host_function(*builtin);
                    (callee, Piece::Text(argument.into()))
                }
                ReadSource::Global(global) => (
                    format!("patina_global_{}", global.name()),
                    Piece::Text(String::new()),
                ),
            };
            self.replace(self.outline.span(read.callee), callee);
            self.edits.push(TextEdit {
                span: self.outline.span(read.name),
                pieces: vec![argument],
            });
            if let Some(comma) = read.comma {
                self.replace(self.outline.span(comma), "");
            }
        }
    }

    /// An array parameter becomes the offset of its words in the fake stack; `a[i]` reads that element,
    /// any other use reads the whole array.
    fn array_parameters(&mut self, parameters: &[ParameterType]) {
        let Some(entry) = self.outline.function("userProc") else {
            return;
        };
        for (place, (param, ty)) in entry.params.iter().zip(parameters).enumerate() {
            let &ParameterType::Array(element, count) = ty else {
                continue;
            };
            let word = match self.outline.is_shadowed(entry, "u32") {
                true => "patina_u32",
                false => "u32",
            };
            // To the compiler an array of a type by another name is another array.
            let has_names = param
                .ty
                .clone()
                .any(|at| self.outline.roles[at] == Role::Global);
            let ty = self.outline.span_of(&param.ty);
            self.edits
                .retain(|edit| !(ty.start <= edit.span.start && edit.span.end <= ty.end));
            self.offset_type(ty);
            for at in entry.body.clone() {
                if self.outline.roles[at] != Role::Local(param.name) {
                    continue;
                }
                let name = self.outline.span(at);
                if is_read_in_place(self.outline, at) {
                    self.replace(
                        name.start..name.start,
                        format!("{}(", element_reader(element)),
                    );
                    self.replace(self.outline.span(at + 1), format!(", {count}u, {word}("));
                    self.replace(self.outline.span(self.outline.closing(at + 1)), "))");
                } else {
                    let reader = match has_names {
                        true => {
                            self.own_arrays.insert(place);
                            vec![Piece::Prefix, Piece::Text(own_array_reader(place) + "(")]
                        }
                        false => vec![Piece::Text(array_reader(element, count) + "(")],
                    };
                    self.edits.push(TextEdit {
                        span: name.start..name.start,
                        pieces: reader,
                    });
                    self.replace(name.end..name.end, ")");
                }
            }
        }
    }

    /// The type of an array parameter's offset, with what the file has there as a comment, unless it holds comments that would end that.
    fn offset_type(&mut self, ty: Range<usize>) {
        let comments = &self.outline.tokens.comments;
        let first = comments.partition_point(|comment| comment.start < ty.start);
        if comments.get(first).is_some_and(|one| one.start < ty.end) {
            let lines = self.outline.text[ty.clone()].matches('\n').count();
            self.replace(ty, format!("u32{}", "\n".repeat(lines)));
        } else {
            self.replace(ty.start..ty.start, "u32 /* ");
            self.replace(ty.end..ty.end, " */");
        }
    }

    /// Every loop that isn't plainly short ends once a texture's evaluation has used up its iterations.
    fn loop_guards(&mut self) -> bool {
        let outline = self.outline;
        let mut any = false;
        for (the_loop, is_short) in outline.loops.iter().zip(plainly_short(outline)) {
            if is_short {
                continue;
            }
            any = true;
            let behind_brace = outline.span(the_loop.body.start).end;
            let mut pieces = vec![Piece::Text(" if patina_loops_spent() { ".into())];
            pieces.extend(self.way_out(the_loop));
            pieces.push(Piece::Text(" }".into()));
            self.edits.push(TextEdit {
                span: behind_brace..behind_brace,
                pieces,
            });
        }
        any
    }

    /// `return` rather than `break`: behind a loop that only returns, WGSL lets a function end without a result.
    fn way_out(&mut self, the_loop: &LoopDecl) -> Vec<Piece> {
        if the_loop.in_continuing {
            return vec![Piece::Text("break;".into())];
        }
        self.return_zero(the_loop.function)
    }

    /// `return T();`, or `return;` from a function without a result.
    fn return_zero(&mut self, index: usize) -> Vec<Piece> {
        let function = &self.outline.functions[index];
        if function.result.is_empty() {
            return vec![Piece::Text("return;".into())];
        }
        let mut pieces = vec![Piece::Text("return ".into())];
        let is_long = self.outline.span_of(&function.result).len() > LONG_TYPE;
        if is_long || self.outline.shadows_its_result(function) {
            self.aliased.insert(index);
            pieces.extend([Piece::Prefix, Piece::Text(alias_name(index))]);
        } else {
            pieces.extend(self.module_type(&function.result));
        }
        pieces.push(Piece::Text("();".into()));
        pieces
    }

    /// A type as it is written at module scope. Blanks stay where there are some: `- -1` is no `--1`.
    fn module_type(&self, tokens: &Range<usize>) -> Vec<Piece> {
        let mut pieces = Vec::new();
        for at in tokens.clone() {
            if at > tokens.start && self.outline.span(at - 1).end < self.outline.span(at).start {
                pieces.push(Piece::Text(" ".into()));
            }
            if self.outline.roles[at] == Role::Global {
                pieces.push(Piece::Prefix);
            } else if self.is_standard(at) {
                pieces.push(Piece::Text(standard::PREFIX.into()));
            }
            pieces.push(Piece::Text(self.outline.word(at).to_owned()));
        }
        pieces
    }

    /// Declares, behind the file's text, the result types that a local of their function hides, and long ones.
    fn aliases(&mut self) {
        let end = self.outline.text.len();
        for index in std::mem::take(&mut self.aliased) {
            let mut pieces = vec![
                Piece::Text("\nalias ".into()),
                Piece::Prefix,
                Piece::Text(format!("{} = ", alias_name(index))),
            ];
            pieces.extend(self.module_type(&self.outline.functions[index].result));
            pieces.push(Piece::Text(";".into()));
            self.edits.push(TextEdit {
                span: end..end,
                pieces,
            });
        }
    }

    /// Declares, behind the file's text, what reads array parameters as a whole whose types have names of the file.
    fn own_array_readers(&mut self, parameters: &[ParameterType]) {
        let end = self.outline.text.len();
        let Some(entry) = self.outline.function("userProc") else {
            return;
        };
        for place in std::mem::take(&mut self.own_arrays) {
            let ParameterType::Array(element, count) = parameters[place] else {
                continue;
            };
            let element = element.parameter_type();
            let size = args::words_of(element);
            let ty = self.module_type(&entry.params[place].ty);
            let mut pieces = vec![Piece::Text("\nfn ".into()), Piece::Prefix];
            let name = own_array_reader(place);
            pieces.push(Piece::Text(format!("{name}(at: u32) -> ")));
            pieces.extend(ty.iter().cloned());
            pieces.push(Piece::Text(" { var values: ".into()));
            pieces.extend(ty);
            pieces.push(Piece::Text(format!(
                "; for (var i = 0u; i < {count}u; i++) {{ values[i] = patina_arg_{element}(at + {size}u * i); }} return values; }}"
            )));
            self.edits.push(TextEdit {
                span: end..end,
                pieces,
            });
        }
    }

    /// naga wants a `return` at the end of a function, also where a loop that never ends is before it.
    fn returns_behind_loops(&mut self) {
        for (index, function) in self.outline.functions.iter().enumerate() {
            if self.outline.ends_with_endless_loop(function) {
                let brace = self.outline.span(function.body.end - 1).start;
                let mut pieces = self.return_zero(index);
                pieces.push(Piece::Text(" ".into()));
                self.edits.push(TextEdit {
                    span: brace..brace,
                    pieces,
                });
            }
        }
    }
}

/// Name of the result type of the function with this number, where its own name is hidden or long.
fn alias_name(function: usize) -> String {
    format!("patina_result{function}")
}

/// Name of the function that reads the array parameter at this place as a whole, in the file's own words.
fn own_array_reader(place: usize) -> String {
    format!("patina_array{place}")
}

/// For each function whether it loops, itself or through functions it calls.
fn functions_that_loop(outline: &Outline<'_>) -> Vec<bool> {
    let functions = &outline.functions;
    let mut loops = vec![false; functions.len()];
    for the_loop in &outline.loops {
        loops[the_loop.function] = true;
    }
    let calls: Vec<Vec<usize>> = functions
        .iter()
        .map(|function| outline.calls(function.body.clone()))
        .collect();
    loop {
        let mut changed = false;
        for (caller, callees) in calls.iter().enumerate() {
            if !loops[caller] && callees.iter().any(|&callee| loops[callee]) {
                loops[caller] = true;
                changed = true;
            }
        }
        if !changed {
            return loops;
        }
    }
}

/// Loops of at most this many iterations, nested ones multiplied, run without a guard.
const SHORT: i64 = 64;

/// For each loop whether it counts with literals over few iterations and calls nothing that loops: then it has no guard.
pub(crate) fn plainly_short(outline: &Outline<'_>) -> Vec<bool> {
    let looping = functions_that_loop(outline);
    let calls_looping = |the_loop: &LoopDecl| {
        let calls = outline.calls(the_loop.body.clone());
        calls.iter().any(|&callee| looping[callee])
    };
    // The loops around the next one: where each ends, and its iterations multiplied with those of the ones around it.
    let mut around: Vec<(usize, i64)> = Vec::new();
    let mut short = Vec::with_capacity(outline.loops.len());
    // A loop comes before those in it.
    for the_loop in &outline.loops {
        let body = &the_loop.body;
        while around.pop_if(|last| last.0 <= body.start).is_some() {}
        let count = trip_count(outline, the_loop);
        let outer = around.last().map_or(1, |&(_, trips)| trips);
        // Inside a guarded loop the guard of the outer one is enough, if this one is short itself.
        let trips = outer.saturating_mul(count.unwrap_or(1));
        around.push((body.end, trips));
        short.push(count.is_some() && trips <= SHORT && !calls_looping(the_loop));
    }
    short
}

/// Iterations of `for (var i = A; i < B; i++)` (or `<=`, `i += C`) with literals and a body that leaves `i` alone.
fn trip_count(outline: &Outline<'_>, the_loop: &LoopDecl) -> Option<i64> {
    let mut header = Cursor {
        outline,
        at: the_loop.keyword,
    };
    header.expect("for")?.expect("(")?.expect("var")?;
    let declared = header.at;
    let name = outline.word(declared);
    header.at += 1;
    if outline.word(header.at) == ":" {
        header.at += 2; // the name of a scalar type
    }
    let from = header.expect("=")?.literal()?;
    header.expect(";")?.expect(name)?.expect("<")?;
    let inclusive = header.expect("=").is_some();
    let to = header.literal()?;
    header.expect(";")?.expect(name)?.expect("+")?;
    let step = match header.expect("+") {
        Some(_) => 1,
        None => header.expect("=")?.literal()?,
    };
    header.expect(")")?;
    let plain =
        header.at == the_loop.body.start && step > 0 && !is_changed(outline, the_loop, declared);
    plain.then(|| ((to - from + i64::from(inclusive)).max(0) + step - 1) / step)
}

/// Whether the loop's body may assign to the local declared at token `declared`: as the target of an assignment or
/// through its address. May say yes where it doesn't, never no where it does.
fn is_changed(outline: &Outline<'_>, the_loop: &LoopDecl, declared: usize) -> bool {
    let word = |at: usize| outline.word(at);
    the_loop
        .body
        .clone()
        .filter(|&at| outline.roles[at] == Role::Local(declared))
        .any(|at| {
            let mut behind = at + 1;
            while word(behind) == ")" {
                behind += 1; // `(i) = 1` assigns too
            }
            let [first, second, third] = [word(behind), word(behind + 1), word(behind + 2)];
            let assigned = match first {
                "=" => second != "=",
                "+" | "-" | "*" | "/" | "%" | "&" | "|" | "^" => second == "=" || second == first,
                "<" | ">" => second == first && third == "=",
                _ => false,
            };
            let mut before = at - 1;
            while word(before) == "(" {
                before -= 1;
            }
            assigned || word(before) == "&"
        })
}

/// Reads tokens one after the other.
struct Cursor<'o, 'a> {
    outline: &'o Outline<'a>,
    at: usize,
}

impl Cursor<'_, '_> {
    /// Steps over `text`, or stays where another token is.
    fn expect(&mut self, text: &str) -> Option<&mut Self> {
        if self.outline.word(self.at) != text {
            return None;
        }
        self.at += 1;
        Some(self)
    }

    /// Steps over an integer literal with an optional minus sign, small enough to count with.
    fn literal(&mut self) -> Option<i64> {
        let sign = if self.expect("-").is_some() { -1 } else { 1 };
        let digits = self.outline.word(self.at).trim_end_matches(['i', 'u']);
        let value: i64 = digits.parse().ok().filter(|&value| value <= 1 << 20)?;
        self.at += 1;
        Some(sign * value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Per loop, neither the other loops nor the function's body may be looked through.
    #[test]
    fn thousands_of_loops_are_guarded() {
        for (one, count) in [("loop{}", 40_000), ("for(var i=0;i<9;i++){}", 10_000)] {
            let loops = one.repeat(count);
            let text = format!("fn userProc() -> vec4f {{ {loops} return vec4f(); }}");
            let outline = Outline::new(&text);
            let rewrite = rewrite(&outline, &[], &[]);
            assert_eq!(rewrite.guards_loops, one == "loop{}");
            // Beside the guards the prefix of `userProc`.
            let guards = if rewrite.guards_loops { count } else { 0 };
            assert_eq!(rewrite.edits.len(), guards + 1);
        }
    }

    #[test]
    fn a_long_result_type_is_written_once() {
        let name = "A".repeat(10_000);
        let text = format!(
            "struct {name} {{ a: f32 }}\nfn f() -> {name} {{ {} }}\nfn userProc() -> f32 {{ return f().a; }}",
            "while true { }".repeat(100)
        );
        let rewrite = rewrite(&Outline::new(&text), &[], &[]);
        let pieces = rewrite.edits.iter().flat_map(|edit| &edit.pieces);
        let bytes = pieces.map(|piece| match piece {
            Piece::Text(text) => text.len(),
            Piece::Prefix | Piece::CustomIndex(_) => 0,
        });
        let bytes: usize = bytes.sum();
        assert!((10_000..20_000).contains(&bytes), "{bytes}");
    }
}
