//! What is left of a file without its errors: naga stops at the first one, so that the part it lies in is cut out and the
//! rest is tried again.
//!
//! The part is as small as can be cut without breaking something else: a statement, and with it everything that needs a
//! name which is declared there; the condition of an `if`; a whole function or declaration where nothing less will do. What is
//! found in the rest is an error whatever stands in the parts that are gone.

mod own_names;
mod search;
mod statements;

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;

use own_names::OwnNames;
use statements::{Statement, Statements};

use crate::problem::{Conversion, Problem};
use crate::scope::{GlobalDecl, Outline, skip_template};
use crate::tokens::TokenKind;
use crate::verdict;

/// The file as naga is given it.
pub(crate) struct Attempt<'o, 'a> {
    outline: &'o Outline<'a>,
    names: OwnNames<'a>,
    /// Functions without their bodies.
    stubs: BTreeSet<usize>,
    /// Parts that are cut out, by their first token. None lies in another one.
    cuts: BTreeMap<usize, Cut>,
    /// Tokens behind which a `;` is missing.
    semicolons: BTreeSet<usize>,
    /// Names that are gone.
    gone: BTreeSet<Lost<'a>>,
    /// Names that are to go, with what needs them.
    lost: Vec<Lost<'a>>,
    /// What comes behind the file's text.
    tail: String,
    /// What was read of it, as [`Self::cost`] counts.
    read: u64,
    /// How each function is left early.
    ways_out: Vec<WayOut>,
    statements: OnceCell<Statements>,
    /// The tokens that each name stands at, but as a member.
    mentions: OnceCell<HashMap<&'a str, Vec<usize>>>,
}

/// A name of a function, or of the file.
type Lost<'a> = (Option<usize>, &'a str);

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

/// A `return` of zero.
struct WayOut {
    text: String,
    /// What has to be declared for it: where a local hides the name of the result type, or where that is long.
    alias: Option<String>,
    /// Whether naga misses it at the end of the function.
    is_missing: bool,
}

/// A result type of more bytes than this isn't written into each `return` of its function.
const LONG_TYPE: usize = 100;

/// No more than this is read of a file, as [`Attempt::cost`] counts: some seconds. What is wrong beyond is told once that is mended.
const MOST_READ: u64 = 10 << 20;

/// So many pairs of a function's tokens take naga as long as a byte of the text: for each expression it goes through all before it.
const PAIRS_IN_A_BYTE: u64 = 512;

/// How much of the file is tried.
struct Part<'p> {
    /// The functions that have their bodies.
    functions: Range<usize>,
    /// The token that their text ends in front of, and what stands there instead.
    end: Option<(usize, &'p str)>,
}

/// A part of the file's text, in bytes, and what it becomes.
type Edit = (Range<usize>, String);

impl<'o, 'a> Attempt<'o, 'a> {
    /// The whole file with `tail` behind it.
    pub(crate) fn new(outline: &'o Outline<'a>, tail: String) -> Self {
        let names = OwnNames::new(outline, &tail);
        Self {
            outline,
            stubs: BTreeSet::new(),
            cuts: BTreeMap::new(),
            semicolons: BTreeSet::new(),
            gone: BTreeSet::new(),
            lost: Vec::new(),
            read: 0,
            ways_out: ways_out(outline, &names.text),
            statements: OnceCell::new(),
            mentions: OnceCell::new(),
            names,
            tail,
        }
    }

    /// What naga says of a text that was made of the file's, in the file's names.
    pub(crate) fn check(&self, text: &str) -> Result<naga::Module, Problem> {
        match verdict::check(text) {
            Ok(mut module) => {
                self.names.restore(&mut module);
                Ok(module)
            }
            Err(mut problem) => {
                self.names.speak(&mut problem);
                Err(problem)
            }
        }
    }

    /// What naga's work on a text costs, in bytes of a text of short functions. Those that have their bodies are given, and the token
    /// that it stops at in one of them.
    fn cost(&self, bytes: usize, functions: Range<usize>, end: Option<usize>) -> u64 {
        let with_bodies = functions.filter(|index| !self.stubs.contains(index));
        let pairs = with_bodies.map(|index| {
            let body = &self.outline.functions[index].body;
            let end = end.filter(|end| body.contains(end)).unwrap_or(body.end);
            let tokens = (end - body.start) as u64;
            tokens * tokens
        });
        bytes as u64 + pairs.sum::<u64>() / PAIRS_IN_A_BYTE
    }

    /// Counts a try of the whole file, a text of so many bytes. Of its parser's errors naga reads no further than the first.
    pub(crate) fn count(&mut self, bytes: usize, stopped_at: Option<usize>) {
        let tokens = &self.outline.tokens.tokens;
        let end = stopped_at.map(|place| tokens.partition_point(|token| token.end() <= place));
        self.read += self.cost(bytes, 0..self.outline.functions.len(), end);
    }

    /// Whether more would take too long.
    pub(crate) fn has_read_enough(&self) -> bool {
        self.read > MOST_READ
    }

    /// Cuts out tokens that are no WGSL, and with them names that they would declare: at module scope, or in the
    /// function that they lie in.
    pub(crate) fn cut_tokens(&mut self, tokens: Range<usize>, names: &[&'a str]) {
        let at = tokens.start;
        let function = self.function_at(at);
        let global = self.global_at(at).filter(|global| global.keyword <= at);
        match function {
            Some(function) if self.is_in_body(function, at) => {
                if !self.cut_statement(at) && !self.is_cut(at) {
                    self.stubs.insert(function);
                }
            }
            _ if global.is_some() => {
                self.drop_global(at);
            }
            _ => self.cut(tokens, Instead::Nothing),
        }
        self.lost.extend(names.iter().map(|&name| (function, name)));
        self.settle();
    }

    /// Whether a problem may come of what was cut out before.
    pub(crate) fn has_caused(&self, problem: &Problem) -> bool {
        let Some(function) = problem.function_in(self.outline) else {
            return false;
        };
        let body = self.outline.functions[function].body.clone();
        problem.message.starts_with("The `return` expression None")
            && self.cuts.range(body).next().is_some()
    }

    /// Cuts out what has a problem. False where nothing is to be done any more.
    pub(crate) fn mend(&mut self, problem: &Problem) -> bool {
        let goes_on = self.cut_out(problem);
        self.settle();
        goes_on
    }

    fn cut_out(&mut self, problem: &Problem) -> bool {
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
                self.cut_all(problem, at) || self.cut_statement(at) || self.stubs.insert(function)
            }
            _ => self.drop_global(at),
        }
    }

    /// Cuts out all of a statement where the problem would stay with what is left of it: a `break if` that stands in no
    /// `continuing`, a `switch` whose cases don't go together. False where it is another problem, or that was done before.
    fn cut_all(&mut self, problem: &Problem, at: usize) -> bool {
        if problem.is_of_cases() {
            let switch = self.switch_around(at);
            return switch.is_some_and(|switch| self.cut_statement(switch));
        }
        let statement = self.statement(at).filter(|_| problem.is_of_break_if());
        let tokens = statement.map(|statement| statement.tokens);
        let is_there = |tokens: &Range<usize>| !tokens.is_empty() && !self.is_cut(tokens.start);
        let Some(tokens) = tokens.filter(is_there) else {
            return false;
        };
        self.cut(tokens, Instead::Nothing);
        true
    }

    /// The first token of the innermost `switch` around another one.
    fn switch_around(&self, at: usize) -> Option<usize> {
        let function = self.function_at(at)?;
        let start = self.outline.functions[function].body.start;
        let before = self.statements().among(&(start..at + 1));
        let around = before.iter().rev().find(|statement| {
            let is_switch = self.outline.word(statement.tokens.start) == "switch";
            let block = statement.block.filter(|_| is_switch);
            block.is_some_and(|block| at <= self.outline.closing(block))
        });
        Some(around?.tokens.start)
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
        let behind = functions.partition_point(|function| function.keyword <= at);
        let index = behind.checked_sub(1)?;
        (at < functions[index].body.end).then_some(index)
    }

    fn is_in_body(&self, function: usize, at: usize) -> bool {
        self.outline.functions[function].body.contains(&at)
    }

    fn global_at(&self, at: usize) -> Option<&'o GlobalDecl> {
        let globals = &self.outline.globals;
        let index = globals.partition_point(|global| global.tokens.end <= at);
        globals
            .get(index)
            .filter(|global| global.tokens.contains(&at))
    }

    /// The statement of a function's body that a token lies in.
    fn statement(&self, at: usize) -> Option<Statement> {
        self.statements().at(at).cloned()
    }

    fn statements(&self) -> &Statements {
        self.statements
            .get_or_init(|| Statements::new(self.outline))
    }

    /// Cuts out the statement that a token lies in. False where that can't be done, or was done before.
    fn cut_statement(&mut self, at: usize) -> bool {
        let outline = self.outline;
        let Some(function) = self.function_at(at) else {
            return false;
        };
        let Some(Statement { tokens, block }) = self.statement(at) else {
            return false;
        };
        let word = |at: usize| outline.word(at);
        let start = tokens.start;
        let is_else = usize::from(word(start) == "else");
        let (tokens, instead, name) = match (word(start + is_else), block) {
            ("if" | "while", Some(block)) => (start + is_else + 1..block, Instead::False, None),
            ("for" | "switch" | "loop", Some(block)) => {
                (start..outline.closing(block) + 1, Instead::Nothing, None)
            }
            (_, Some(_)) => return false,
            ("return", None) => (tokens, Instead::Return, None),
            ("let" | "const", None) => (tokens, Instead::Nothing, Some(word(start + 1))),
            ("var", None) => {
                let name = skip_template(&outline.tokens.tokens, start + 1);
                (tokens, Instead::Nothing, Some(word(name)))
            }
            // The end of a `continuing` block: the loop must not lose its way out.
            ("break", None) if word(start + 1) == "if" => (
                start + 2..tokens.end.saturating_sub(1),
                Instead::False,
                None,
            ),
            _ => (tokens, Instead::Nothing, None),
        };
        if tokens.is_empty() || self.is_cut(tokens.start) {
            return false;
        }
        self.cut(tokens, instead);
        self.lost.extend(name.map(|name| (Some(function), name)));
        true
    }

    /// Cuts out tokens, of which the first is not gone yet.
    fn cut(&mut self, tokens: Range<usize>, instead: Instead) {
        if tokens.is_empty() || self.is_cut(tokens.start) {
            return;
        }
        let inside = self.cuts.range(tokens.clone());
        let inside: Vec<usize> = inside.map(|(&start, _)| start).collect();
        for start in inside {
            self.cuts.remove(&start);
        }
        self.cuts.insert(tokens.start, Cut { tokens, instead });
    }

    /// Whether a token is gone already.
    fn is_cut(&self, at: usize) -> bool {
        let before = self.cuts.range(..=at).next_back();
        before.is_some_and(|(_, cut)| cut.tokens.contains(&at))
    }

    /// Cuts out a declaration of module scope. False where there is none, or it is gone.
    fn drop_global(&mut self, at: usize) -> bool {
        let Some(global) = self.global_at(at) else {
            return false;
        };
        let tokens = global.tokens.clone();
        if tokens.is_empty() || self.is_cut(tokens.start) {
            return false;
        }
        self.cut(tokens, Instead::Nothing);
        let name = global.name.map(|name| self.outline.word(name));
        self.lost.extend(name.map(|name| (None, name)));
        true
    }

    /// Cuts out what needs a name that is gone: in a function, or anywhere.
    fn settle(&mut self) {
        while let Some((function, name)) = self.lost.pop() {
            if !self.gone.insert((function, name)) {
                continue;
            }
            for at in self.mentions(function, name) {
                if self.is_cut(at) {
                    continue;
                }
                match self.function_at(at) {
                    Some(function) if self.is_in_body(function, at) => {
                        if !self.stubs.contains(&function) && !self.cut_statement(at) {
                            self.stubs.insert(function);
                        }
                    }
                    _ => {
                        self.drop_global(at);
                    }
                }
            }
        }
    }

    /// The tokens of a function's body, or of the file, that are this name.
    fn mentions(&self, function: Option<usize>, name: &str) -> Vec<usize> {
        let all = self.mentions.get_or_init(|| {
            let mut all: HashMap<&'a str, Vec<usize>> = HashMap::new();
            for (at, token) in self.outline.tokens.tokens.iter().enumerate() {
                let is_member = at > 0 && self.outline.word(at - 1) == ".";
                if token.kind == TokenKind::Word && !is_member {
                    all.entry(token.text).or_default().push(at);
                }
            }
            all
        });
        let Some(places) = all.get(name) else {
            return Vec::new();
        };
        let Some(function) = function else {
            return places.clone();
        };
        let body = &self.outline.functions[function].body;
        let first = places.partition_point(|&at| at < body.start);
        let end = places.partition_point(|&at| at < body.end);
        places[first..end].to_vec()
    }

    /// The text, and the edits that made it of the file's.
    pub(crate) fn text(&self) -> (String, Edits) {
        self.text_of(&Part {
            functions: 0..self.outline.functions.len(),
            end: None,
        })
    }

    /// The text of a part of the file, with all declarations and without the other functions' bodies.
    fn text_of(&self, part: &Part<'_>) -> (String, Edits) {
        let mut edits: Vec<Edit> = Vec::new();
        let mut left = BTreeSet::new();
        let mut way_out = |function: usize| {
            left.insert(function);
            self.ways_out[function].text.clone()
        };
        for (index, function) in self.outline.functions.iter().enumerate() {
            let body = self.outline.span_of(&function.body);
            if self.stubs.contains(&index) || !part.functions.contains(&index) {
                edits.push((body, format!("{{ {} }}", way_out(index))));
            } else if let Some((end, instead)) = part.end {
                let start = self.outline.span(end - 1).end;
                let tokens = function.body.start..end;
                let open = tokens.fold(0usize, |open, at| match self.outline.word(at) {
                    "{" => open + 1,
                    "}" => open.saturating_sub(1),
                    _ => open,
                });
                let end = start.max(body.end);
                edits.push((start..end, format!(" {instead} {}", "}".repeat(open))));
            } else if self.ways_out[index].is_missing {
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
        let source = &self.names.text;
        let mut text = String::with_capacity(source.len() + self.tail.len());
        let mut done = Edits(Vec::new());
        let mut at = 0;
        for (span, instead) in edits {
            if span.start < at {
                continue;
            }
            text.push_str(&source[at..span.start]);
            done.0
                .push((text.len()..text.len() + instead.len(), span.clone()));
            text.push_str(&instead);
            at = span.end;
        }
        text.push_str(&source[at..]);
        text.push_str(&self.tail);
        let aliases = left.iter().map(|&function| &self.ways_out[function].alias);
        text.extend(aliases.flatten().map(String::as_str));
        (text, done)
    }
}

/// How each function is left, in the words of `source`.
fn ways_out(outline: &Outline<'_>, source: &str) -> Vec<WayOut> {
    let functions = outline.functions.iter().enumerate();
    functions
        .map(|(index, function)| {
            let is_missing = outline.ends_with_endless_loop(function);
            let (text, alias) = if function.result.is_empty() {
                ("return;".to_owned(), None)
            } else {
                let result = &source[outline.span_of(&function.result)];
                if result.len() > LONG_TYPE || outline.shadows_its_result(function) {
                    let name = format!("patina_result{index}");
                    let alias = format!("alias {name} = {result};\n");
                    (format!("return {name}();"), Some(alias))
                } else {
                    (format!("return {result}();"), None)
                }
            };
            WayOut {
                text,
                alias,
                is_missing,
            }
        })
        .collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn little_is_read_of_functions_that_take_long() {
        let tries = |text: &str, stopped_at: Option<usize>| {
            let outline = Outline::new(text);
            let mut attempt = Attempt::new(&outline, String::new());
            let count = |tries: &usize| {
                attempt.count(text.len(), stopped_at);
                attempt.has_read_enough() || *tries >= 1000
            };
            (1..).find(count)
        };
        let long = format!("fn f() {{ {} }}", "x+=1;".repeat(8_000));
        let short = "fn f() { x+=1; }".repeat(500);
        assert_eq!(tries(&long, None), Some(4));
        assert!(tries(&long, Some(100)) > Some(200));
        assert_eq!(tries(&short, None), Some(1000));
    }

    #[test]
    fn nothing_is_searched_once_enough_was_read() {
        let text = "fn f() { } fn userProc(v: vec3f) -> f32 { return v[3]; }";
        let outline = Outline::new(text);
        let mut attempt = Attempt::new(&outline, String::new());
        let (whole, _) = attempt.text();
        let unplaced = |attempt: &Attempt<'_, '_>| {
            let problem = attempt.check(&whole).expect_err("an index beyond the end");
            assert!(problem.is_unplaced());
            problem
        };
        let problem = unplaced(&attempt);
        let placed = attempt.place(problem);
        let span = placed.labels.first().map(|(span, _)| span.clone());
        assert_eq!(span.map(|span| &text[span]), Some("v[3]"));
        attempt.read = MOST_READ;
        let problem = unplaced(&attempt);
        assert!(attempt.place(problem).is_unplaced());
    }
}
