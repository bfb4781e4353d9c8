//! What is left of a file without its errors: naga stops at the first one, so that the part it lies in is cut out and the
//! rest is tried again.
//!
//! The part is as small as can be cut without breaking something else: a statement, and with it everything that needs a
//! name which is declared there; the condition of an `if`; a whole function or declaration where nothing less will do. What is
//! found in the rest is an error whatever stands in the parts that are gone.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use crate::problem::{Conversion, Problem};
use crate::scope::{GlobalDecl, Outline};
use crate::tokens::TokenKind;

/// The file as naga is given it.
pub(crate) struct Attempt<'o, 'a> {
    outline: &'o Outline<'a>,
    /// Functions without their bodies.
    stubs: BTreeSet<usize>,
    /// Parts that are cut out, by their first token.
    cuts: BTreeMap<usize, Cut>,
    /// Tokens behind which a `;` is missing.
    semicolons: BTreeSet<usize>,
    /// Names that are gone: of a function, or of the file.
    gone: BTreeSet<(Option<usize>, &'a str)>,
    /// What comes behind the file's text.
    tail: String,
}

/// Something that is cut out, and what takes its place.
#[derive(Clone, Debug)]
struct Cut {
    tokens: Range<usize>,
    instead: Instead,
}

#[derive(Clone, Copy, Debug)]
enum Instead {
    Nothing,
    /// A `return` of zero: the function's way out stays.
    Return,
    /// A condition.
    False,
}

/// A part of the file's text, in bytes, and what it becomes.
type Edit = (Range<usize>, String);

impl<'o, 'a> Attempt<'o, 'a> {
    /// The whole file with `tail` behind it.
    pub(crate) fn new(outline: &'o Outline<'a>, tail: String) -> Self {
        Self {
            outline,
            stubs: BTreeSet::new(),
            cuts: BTreeMap::new(),
            semicolons: BTreeSet::new(),
            gone: BTreeSet::new(),
            tail,
        }
    }

    /// Cuts out tokens that are no WGSL, and with them names that they would declare: at module scope, or in the
    /// function that they lie in.
    pub(crate) fn cut_tokens(&mut self, tokens: Range<usize>, names: &[&'a str]) {
        let at = tokens.start;
        let function = self.function_at(at);
        let is_in_global = |global: &GlobalDecl| (global.keyword..global.tokens.end).contains(&at);
        match function {
            Some(function) if self.is_in_body(function, at) => {
                if !self.cut_statement(at) && !self.is_cut(at) {
                    self.stubs.insert(function);
                }
            }
            _ if self.outline.globals.iter().any(is_in_global) => {
                self.drop_global(at);
            }
            _ => {
                let instead = Instead::Nothing;
                self.cuts.insert(at, Cut { tokens, instead });
            }
        }
        for name in names {
            self.lose(function, name);
        }
    }

    /// Whether a problem may come of what was cut out before.
    pub(crate) fn has_caused(&self, problem: &Problem) -> bool {
        let Some(function) = problem.function_in(self.outline) else {
            return false;
        };
        let body = self.outline.functions[function].body.clone();
        problem.message.starts_with("The `return` expression None")
            && self.cuts.keys().any(|start| body.contains(start))
    }

    /// Cuts out what has a problem. False where nothing is to be done any more.
    pub(crate) fn mend(&mut self, problem: &Problem) -> bool {
        let place = problem.labels.first().map(|(span, _)| span.start);
        let Some(place) = place.filter(|&place| place < self.outline.text.len()) else {
            return match problem.function_in(self.outline) {
                Some(function) => self.stubs.insert(function),
                None => false,
            };
        };
        let tokens = &self.outline.tokens.tokens;
        let at = tokens.partition_point(|token| token.end() <= place);
        if at >= tokens.len() {
            return false;
        }
        if problem.lacks_semicolon() && self.insert_semicolon(at) {
            return true;
        }
        match self.function_at(at) {
            Some(function) if self.is_in_body(function, at) => {
                self.cut_statement(at) || self.stubs.insert(function)
            }
            _ => self.drop_global(at),
        }
    }

    /// Puts a `;` in front of a token that begins a line or ends a block, once.
    fn insert_semicolon(&mut self, at: usize) -> bool {
        let Some(before) = at.checked_sub(1) else {
            return false;
        };
        let between = self.outline.span(before).end..self.outline.span(at).start;
        let is_next_line = self.outline.text[between].contains('\n');
        (is_next_line || self.outline.word(at) == "}") && self.semicolons.insert(before)
    }

    fn function_at(&self, at: usize) -> Option<usize> {
        let functions = &self.outline.functions;
        functions
            .iter()
            .position(|function| (function.keyword..function.body.end).contains(&at))
    }

    fn is_in_body(&self, function: usize, at: usize) -> bool {
        self.outline.functions[function].body.contains(&at)
    }

    /// Cuts out the statement that a token lies in. False where that can't be done, or was done before.
    fn cut_statement(&mut self, at: usize) -> bool {
        let Some(function) = self.function_at(at) else {
            return false;
        };
        let Some(statement) = self.statement(function, at) else {
            return false;
        };
        let word = |at: usize| self.outline.word(at);
        let start = statement.tokens.start;
        let is_else = usize::from(word(start) == "else");
        let (tokens, instead, name) = match (word(start + is_else), &statement.block) {
            ("if" | "while", Some(block)) => {
                let condition = start + is_else + 1..block.start;
                (condition, Instead::False, None)
            }
            ("for" | "switch" | "loop", Some(block)) => (start..block.end, Instead::Nothing, None),
            (_, Some(_)) => return false,
            ("return", None) => (statement.tokens, Instead::Return, None),
            ("let" | "const", None) => {
                let name = word(start + 1);
                (statement.tokens, Instead::Nothing, Some(name))
            }
            ("var", None) => {
                let name = crate::scope::skip_template(&self.outline.tokens.tokens, start + 1);
                (statement.tokens, Instead::Nothing, Some(word(name)))
            }
            // The end of a `continuing` block: the loop must not lose its way out.
            ("break", None) if word(start + 1) == "if" => {
                let condition = start + 2..statement.tokens.end.saturating_sub(1);
                (condition, Instead::False, None)
            }
            _ => (statement.tokens, Instead::Nothing, None),
        };
        if tokens.is_empty() || self.is_cut(tokens.start) {
            return false;
        }
        self.cuts.insert(tokens.start, Cut { tokens, instead });
        if let Some(name) = name {
            self.lose(Some(function), name);
        }
        true
    }

    /// Whether a token is gone already.
    fn is_cut(&self, at: usize) -> bool {
        let before = self.cuts.range(..=at).map(|(_, cut)| cut);
        before.into_iter().any(|cut| cut.tokens.contains(&at))
    }

    /// The statement of a function's body that a token lies in.
    fn statement(&self, function: usize, at: usize) -> Option<Statement> {
        let body = &self.outline.functions[function].body;
        let (mut start, mut depth) = (body.start + 1, 0usize);
        for before in body.start + 1..at {
            match self.outline.word(before) {
                "(" | "[" => depth += 1,
                ")" | "]" => depth = depth.saturating_sub(1),
                ";" if depth == 0 => start = before + 1,
                "{" | "}" => (start, depth) = (before + 1, 0),
                _ => {}
            }
        }
        for end in at..body.end {
            match self.outline.word(end) {
                "(" | "[" => depth += 1,
                ")" | "]" => depth = depth.saturating_sub(1),
                ";" if depth == 0 => {
                    return Some(Statement {
                        tokens: start..end + 1,
                        block: None,
                    });
                }
                "{" => {
                    let block = end..self.outline.closing(end) + 1;
                    return Some(Statement {
                        tokens: start..end,
                        block: Some(block),
                    });
                }
                // The last one of a block, without its semicolon.
                "}" => {
                    return (start < end).then_some(Statement {
                        tokens: start..end,
                        block: None,
                    });
                }
                _ => {}
            }
        }
        None
    }

    /// Cuts out a declaration of module scope, and what needs it.
    fn drop_global(&mut self, at: usize) -> bool {
        let mut globals = self.outline.globals.iter();
        let Some(global) = globals.find(|global| global.tokens.contains(&at)) else {
            return false;
        };
        let tokens = global.tokens.clone();
        if tokens.is_empty() || self.is_cut(tokens.start) {
            return false;
        }
        let instead = Instead::Nothing;
        self.cuts.insert(tokens.start, Cut { tokens, instead });
        if let Some(name) = global.name {
            self.lose(None, self.outline.word(name));
        }
        true
    }

    /// Cuts out what needs a name that is gone: in a function, or anywhere.
    fn lose(&mut self, function: Option<usize>, name: &'a str) {
        if !self.gone.insert((function, name)) {
            return;
        }
        let everything = 0..self.outline.tokens.tokens.len();
        let range = function.map_or(everything, |function| {
            self.outline.functions[function].body.clone()
        });
        for at in range {
            let token = self.outline.tokens.tokens[at];
            let is_name = token.kind == TokenKind::Word && token.text == name;
            if !is_name || (at > 0 && self.outline.word(at - 1) == ".") || self.is_cut(at) {
                continue;
            }
            match self.function_at(at) {
                Some(function) if self.is_in_body(function, at) => {
                    if !self.cut_statement(at) {
                        self.stubs.insert(function);
                    }
                }
                _ => {
                    self.drop_global(at);
                }
            }
        }
    }

    /// A zero of a function's result type, and the alias to be declared for it where a local hides the type's name.
    fn zero(&self, index: usize) -> (String, Option<String>) {
        let function = &self.outline.functions[index];
        let result = &self.outline.text[self.outline.span_of(&function.result)];
        if !self.outline.shadows_its_result(function) {
            return (format!("{result}()"), None);
        }
        let name = format!("patina_result{index}");
        let alias = format!("alias {name} = {result};\n");
        (format!("{name}()"), Some(alias))
    }

    /// The text, and the edits that made it of the file's.
    pub(crate) fn text(&self) -> (String, Edits) {
        let mut edits: Vec<Edit> = Vec::new();
        let mut aliases = BTreeSet::new();
        let mut way_out = |function: usize| {
            if self.outline.functions[function].result.is_empty() {
                return "return;".to_owned();
            }
            let (zero, alias) = self.zero(function);
            aliases.extend(alias);
            format!("return {zero};")
        };
        for (index, function) in self.outline.functions.iter().enumerate() {
            if self.stubs.contains(&index) {
                let body = self.outline.span_of(&function.body);
                edits.push((body, format!("{{ {} }}", way_out(index))));
            } else if self.outline.ends_with_endless_loop(function) {
                let at = self.outline.span(function.body.end - 1).start;
                edits.push((at..at, format!(" {}", way_out(index))));
            }
        }
        for cut in self.cuts.values() {
            let instead = match (cut.instead, self.function_at(cut.tokens.start)) {
                (Instead::Return, Some(function)) => way_out(function),
                (Instead::False, _) => " false ".to_owned(),
                _ => " ".to_owned(),
            };
            edits.push((self.outline.span_of(&cut.tokens), instead));
        }
        for &before in &self.semicolons {
            let at = self.outline.span(before).end;
            edits.push((at..at, ";".to_owned()));
        }
        // Of two that overlap the outer one holds.
        edits.sort_by_key(|(span, _)| (span.start, std::cmp::Reverse(span.end)));
        let mut text = String::with_capacity(self.outline.text.len() + self.tail.len());
        let mut done = Edits(Vec::new());
        let mut at = 0;
        for (span, instead) in edits {
            if span.start < at {
                continue;
            }
            text.push_str(&self.outline.text[at..span.start]);
            done.0
                .push((text.len()..text.len() + instead.len(), span.clone()));
            text.push_str(&instead);
            at = span.end;
        }
        text.push_str(&self.outline.text[at..]);
        text.push_str(&self.tail);
        text.extend(aliases);
        (text, done)
    }
}

/// Tokens of a statement, its `;` included; of one with a block, those before the block.
struct Statement {
    tokens: Range<usize>,
    /// `{` to `}`.
    block: Option<Range<usize>>,
}

/// Where the text that naga sees differs from the file's: the bytes there, and the bytes of the file that they stand for.
#[derive(Debug)]
pub(crate) struct Edits(Vec<(Range<usize>, Range<usize>)>);

impl Edits {
    /// Moves places in an edited text to where they are in the file.
    pub(crate) fn undo(&self, problem: &mut Problem) {
        let original = |span: &Range<usize>| {
            let start = self.original(span.start);
            start..self.original(span.end).max(start)
        };
        for (span, _) in &mut problem.labels {
            *span = original(span);
        }
        if let Some(Conversion {
            operand: Some(span),
            ..
        }) = problem.conversion.as_deref_mut()
        {
            *span = original(span);
        }
    }

    /// The byte of the file that a byte of naga's text stands for.
    pub(crate) fn original(&self, offset: usize) -> usize {
        let at = self.0.partition_point(|(text, _)| text.end <= offset);
        let before = at.checked_sub(1).map(|at| &self.0[at]);
        match self.0.get(at) {
            Some((text, file)) if text.start < offset => file.start,
            _ => before.map_or(offset, |(text, file)| offset - text.end + file.end),
        }
    }
}
