//! The places of errors that naga gives none for: of the types of expressions, of types that there are none of, of nesting.
//!
//! The file is tried with ever fewer functions until one is left that has the error, then with ever less of that one. naga reads
//! a function from top to bottom, so the last statement without which the error is gone is the one. Where something else is found
//! to be wrong on the way, that comes first.

use std::ops::Range;

use super::{Attempt, MOST_READ, Part};
use crate::problem::{Conversion, FRACTION, Problem, refused_operator};
use crate::scope::{GlobalKind, Role, skip_template};
use crate::tokens::TokenKind;
use crate::verdict;

/// The first step, in statements, of a search in a long function.
const FIRST_STEP: usize = 32;

/// No more expressions of a statement than this are looked at.
const MOST_TRIED: usize = 4;

/// What naga says of a part of the file.
enum Verdict {
    Right,
    /// An error whose place it knows.
    Placed(Problem),
    /// Another one.
    Unplaced(Problem),
}

/// An expression with `[...]` behind it, in tokens.
#[derive(Clone)]
struct Indexed {
    expression: Range<usize>,
    /// Its `]`.
    close: usize,
}

/// A number with a fraction and the other operand of an operator, in tokens.
struct Mixture {
    operator: usize,
    number: usize,
    other: Range<usize>,
}

impl Attempt<'_, '_> {
    /// A problem that has no place, with its place as far as that is found; or another one that has a place.
    pub(crate) fn place(&mut self, mut problem: Problem) -> Problem {
        if let Some(at) = self.lacking_type(&problem.message) {
            problem.labels.push((self.outline.span(at), String::new()));
            return problem;
        }
        let mut functions = 0..self.outline.functions.len();
        match self.try_functions(0..0) {
            None => return problem,
            Some(Verdict::Placed(other)) => return other,
            Some(Verdict::Unplaced(_)) => return self.place_in_declaration(problem),
            Some(Verdict::Right) => {}
        }
        while functions.len() > 1 {
            let half = functions.start..functions.start + functions.len() / 2;
            match self.try_functions(half.clone()) {
                None => return problem,
                Some(Verdict::Placed(other)) => return other,
                Some(Verdict::Unplaced(_)) => functions = half,
                Some(Verdict::Right) => functions.start = half.end,
            }
        }
        match functions.next() {
            Some(function) => self.place_in_function(function, problem),
            None => problem,
        }
    }

    /// The token that names a type which textures don't have, or a number of such a type, where naga says no more than the type.
    fn lacking_type(&self, message: &str) -> Option<usize> {
        let (name, _) = message.strip_prefix("Using `")?.split_once("` values")?;
        let suffix = match name {
            "i64" => Some("li"),
            "u64" => Some("lu"),
            "f64" => Some("lf"),
            _ => None,
        };
        let mut tokens = self.outline.tokens.tokens.iter().enumerate();
        let found = tokens.find(|&(at, token)| {
            let is_meant = match token.kind {
                TokenKind::Word => {
                    token.text == name && self.outline.roles[at] == Role::Predeclared
                }
                TokenKind::Number => suffix.is_some_and(|suffix| token.text.ends_with(suffix)),
                TokenKind::Punct => false,
            };
            is_meant && !self.is_cut(at) && !self.is_in_stub(at)
        });
        found.map(|(at, _)| at)
    }

    /// Whether a token lies in a body that is gone.
    fn is_in_stub(&self, at: usize) -> bool {
        let function = self.function_at(at);
        function
            .is_some_and(|function| self.stubs.contains(&function) && self.is_in_body(function, at))
    }

    fn try_functions(&mut self, functions: Range<usize>) -> Option<Verdict> {
        self.try_part(&Part {
            functions,
            end: None,
        })
    }

    /// What naga says of a part of the file. None where enough was tried.
    fn try_part(&mut self, part: &Part<'_>) -> Option<Verdict> {
        if self.has_read_enough() {
            return None;
        }
        let (text, edits) = self.text_of(part);
        let end = part.end.map(|(end, _)| end);
        let cost = self.cost(text.len(), part.functions.clone(), end);
        if self.read + cost > MOST_READ {
            return None;
        }
        self.read += cost;
        Some(match self.check(&text) {
            Ok(_) => Verdict::Right,
            Err(problem) if problem.is_unplaced() => Verdict::Unplaced(problem),
            Err(mut problem) => {
                edits.undo(&mut problem);
                Verdict::Placed(problem)
            }
        })
    }

    /// The problem at the declaration that has it by itself, without the rest of the file.
    fn place_in_declaration(&mut self, mut problem: Problem) -> Problem {
        let outline = self.outline;
        for global in &outline.globals {
            if global.kind == GlobalKind::Function || self.is_cut(global.tokens.start) {
                continue;
            }
            let text = &self.names.text[outline.span_of(&global.tokens)];
            self.read += text.len() as u64;
            if self.has_read_enough() {
                break;
            }
            if verdict::check(text).is_err_and(|error| error.is_unplaced()) {
                let place = global.name.unwrap_or(global.keyword);
                problem.labels.push((outline.span(place), String::new()));
                break;
            }
        }
        problem
    }

    /// The problem at the statement of a function that has it, else at the function.
    fn place_in_function(&mut self, function: usize, mut problem: Problem) -> Problem {
        let outline = self.outline;
        let decl = &outline.functions[function];
        problem.function = Some(outline.word(decl.name).to_owned());
        let ends = self.ends(&decl.body);
        let mut found = None;
        let (mut low, mut high, mut step) = (0, ends.len(), FIRST_STEP);
        while low < high {
            // From the beginning on as long as there is no error: a long function's end costs most.
            let half = (high - low) / 2;
            let ahead = if found.is_some() {
                half
            } else {
                half.min(step)
            };
            let middle = low + ahead;
            step = step.saturating_mul(2);
            let part = Part {
                functions: function..function + 1,
                end: Some((ends[middle], "")),
            };
            match self.try_part(&part) {
                None => return problem,
                Some(Verdict::Unplaced(one)) => {
                    found = Some((ends[middle], one));
                    high = middle;
                }
                Some(_) => low = middle + 1,
            }
        }
        let Some((end, one)) = found else {
            return problem;
        };
        let function_name = problem.function;
        problem = Problem {
            function: function_name,
            ..one
        };
        match self.statement(end - 1) {
            Some(statement) if !statement.tokens.is_empty() => {
                self.point_out(function, &statement.tokens, problem)
            }
            _ => problem,
        }
    }

    /// The tokens that the text of a function's body may end in front of: behind each statement and each `{`.
    fn ends(&self, body: &Range<usize>) -> Vec<usize> {
        let statements = self.statements().among(body).iter();
        let ends = statements.map(|statement| match statement.block {
            Some(block) => block + 1,
            None => statement.tokens.end,
        });
        ends.filter(|&end| matches!(self.outline.word(end - 1), ";" | "{") && !self.is_cut(end - 1))
            .collect()
    }

    /// The problem at the expression of a statement that it is about, where the statement leaves no doubt; else at the statement.
    fn point_out(
        &mut self,
        function: usize,
        statement: &Range<usize>,
        mut problem: Problem,
    ) -> Problem {
        let message = problem.message.as_str();
        let beyond = message.strip_prefix("Index ");
        let beyond = beyond.and_then(|rest| rest.split_once(" is out of bounds"));
        let mut place = statement.clone();
        if let Some((index, _)) = beyond {
            let said = self.beyond_the_end(function, statement, index);
            if let Some((indexed, message)) = said {
                place = indexed.expression.start..indexed.close + 1;
                problem.message = message;
            }
        } else if message.starts_with("Invalid access into")
            || message.starts_with("Invalid sub-access into")
        {
            if let Some((indexed, message)) = self.without_components(function, statement) {
                place = indexed.expression.start..indexed.close + 1;
                problem.message = message;
            }
        } else if let Some(operator) = refused_operator(message)
            && let [one] = &self.operators(statement, operator)[..]
        {
            place = one.clone();
        }
        let place = self.outline.span_of(&place);
        problem.labels.push((place, String::new()));
        problem
    }

    /// What is indexed by a number that is too large, and the sentence about it.
    fn beyond_the_end(
        &mut self,
        function: usize,
        statement: &Range<usize>,
        index: &str,
    ) -> Option<(Indexed, String)> {
        let all = self.indexed(statement);
        let is_by_number = |one: &&Indexed| {
            let number = self.outline.word(one.expression.end + 1);
            one.close == one.expression.end + 2 && number.trim_end_matches(['i', 'u']) == index
        };
        let by_number: Vec<&Indexed> = all.iter().filter(is_by_number).collect();
        let one = match (&by_number[..], &all[..]) {
            ([one], _) => (*one).clone(),
            ([], [one]) => one.clone(),
            _ => return None,
        };
        let what = self.quoted(&one.expression)?;
        let ty = self.type_of(function, statement.start, &one.expression);
        let which = ty.map_or(String::new(), |ty| format!(", which is `{ty}`"));
        let message = format!("index {index} is beyond the end of {what}{which}");
        Some((one, message))
    }

    /// What is indexed though it has no components, and the sentence about it.
    fn without_components(
        &mut self,
        function: usize,
        statement: &Range<usize>,
    ) -> Option<(Indexed, String)> {
        let all = self.indexed(statement);
        let is_only = all.len() == 1;
        for one in all.into_iter().take(MOST_TRIED) {
            let ty = self.type_of(function, statement.start, &one.expression);
            let has_components = |ty: &str| {
                let kinds = ["vec", "mat", "array", "ptr"];
                kinds.iter().any(|kind| ty.starts_with(kind))
            };
            let message = match ty {
                Some(ty) if !has_components(&ty) => {
                    let what = self.quoted(&one.expression)?;
                    format!("{what} is `{ty}`, which has no components")
                }
                None if is_only => {
                    let what = self.quoted(&one.expression)?;
                    format!("{what} has no components")
                }
                _ => continue,
            };
            return Some((one, message));
        }
        None
    }

    /// An expression as the file has it, where it is short.
    fn quoted(&self, expression: &Range<usize>) -> Option<String> {
        let text = &self.outline.text[self.outline.span_of(expression)];
        let is_short = text.len() <= 60 && !text.contains('\n');
        is_short.then(|| format!("`{text}`"))
    }

    /// The type that an expression would have in front of a statement, as WGSL writes it: naga says it where another one is wanted.
    fn type_of(
        &mut self,
        function: usize,
        statement: usize,
        expression: &Range<usize>,
    ) -> Option<String> {
        let text = &self.names.text[self.outline.span_of(expression)];
        let probe = format!("let patina_probe: sam2D = {text};");
        let part = Part {
            functions: function..function + 1,
            end: Some((statement, &probe)),
        };
        let Verdict::Placed(problem) = self.try_part(&part)? else {
            return None;
        };
        let expected = "the type of `patina_probe` is expected to be ";
        let (_, got) = (problem.message.strip_prefix(expected)?).split_once("but got `")?;
        let ty = got.strip_suffix('`')?;
        // A number without a type of its own is shown in braces.
        (!ty.contains('{')).then(|| ty.to_owned())
    }

    /// Names the operator that has a number with a fraction beside an integer, where naga says no more than that a statement mixes them.
    pub(crate) fn tell_operands(&mut self, problem: &mut Problem) {
        let place = problem.labels.first().map(|(span, _)| span.start);
        let Some(place) = place.filter(|_| problem.is_of_mixture()) else {
            return;
        };
        let tokens = &self.outline.tokens.tokens;
        let at = tokens.partition_point(|token| token.end() <= place);
        let function = self.function_at(at);
        let Some(function) = function.filter(|&function| self.is_in_body(function, at)) else {
            return;
        };
        let Some(statement) = self.statement(at).map(|statement| statement.tokens) else {
            return;
        };
        for mixture in self.mixtures(&statement).into_iter().take(MOST_TRIED) {
            let Some(ty) = self.type_of(function, statement.start, &mixture.other) else {
                continue;
            };
            if let Some(to) = float_like(&ty) {
                self.tell_mixture(&mixture, ty, to, problem);
                return;
            }
        }
    }

    fn tell_mixture(&self, mixture: &Mixture, ty: String, to: &str, problem: &mut Problem) {
        let &Mixture {
            operator,
            number,
            ref other,
        } = mixture;
        let operands = match number < operator {
            true => format!("{FRACTION} and `{ty}`"),
            false => format!("`{ty}` and {FRACTION}"),
        };
        problem.message = format!("`{}` can't take {operands}", self.outline.word(operator));
        problem.notes.clear();
        let whole = other.start.min(number)..other.end.max(number + 1);
        let whole = self.outline.span_of(&whole);
        let other = self.outline.span_of(other);
        problem.labels = vec![(whole, String::new()), (other.clone(), ty)];
        problem.conversion = Some(Box::new(Conversion {
            operand: Some(other),
            name: None,
            to: to.to_owned(),
        }));
    }

    /// The operators of a statement that have a number with a fraction on one side. First those without such numbers on the other
    /// side: once they are mended, the types around them are others.
    fn mixtures(&self, statement: &Range<usize>) -> Vec<Mixture> {
        let mut found = Vec::new();
        for operator in statement.start + 1..statement.end {
            let is_operator = matches!(self.outline.word(operator), "*" | "/" | "%" | "+" | "-");
            if !is_operator || !self.ends_operand(operator - 1) {
                continue;
            }
            let is_negative = self.outline.word(operator + 1) == "-";
            let [before, behind] = [operator - 1, operator + 1 + usize::from(is_negative)];
            let (number, other) = match [before, behind].map(|at| self.is_fraction(at)) {
                [true, false] => (before, self.operand_behind(operator, statement.end)),
                [false, true] => (behind, self.operand_before(operator, statement.start)),
                _ => continue,
            };
            found.push(Mixture {
                operator,
                number,
                other,
            });
        }
        found.sort_by_key(|mixture| mixture.other.clone().any(|at| self.is_fraction(at)));
        found
    }

    /// Whether a token is a number with a fraction, which has no type of its own.
    fn is_fraction(&self, at: usize) -> bool {
        let token = self.outline.tokens.tokens.get(at);
        token.is_some_and(|token| {
            let text = token.text;
            let is_hexadecimal = text.starts_with("0x") || text.starts_with("0X");
            let is_decimal = token.kind == TokenKind::Number && !is_hexadecimal;
            is_decimal && text.contains(['.', 'e', 'E']) && !text.ends_with(['f', 'h'])
        })
    }

    /// The left operand of an operator: products belong together, and in front of a sum all that is added up.
    fn operand_before(&self, operator: usize, limit: usize) -> Range<usize> {
        let is_sum = matches!(self.outline.word(operator), "+" | "-");
        let mut first = self.first_of_operand(operator - 1, limit);
        while first >= limit + 2 {
            let belongs = match self.outline.word(first - 1) {
                "*" | "/" | "%" => true,
                "+" | "-" => is_sum,
                _ => false,
            };
            if !belongs || !self.ends_operand(first - 2) {
                break;
            }
            first = self.first_of_operand(first - 2, limit);
        }
        first..operator
    }

    /// The right operand of an operator: of a sum a whole product.
    fn operand_behind(&self, operator: usize, limit: usize) -> Range<usize> {
        let is_sum = matches!(self.outline.word(operator), "+" | "-");
        let mut end = self.end_of_operand(operator + 1, limit);
        while is_sum && end < limit && matches!(self.outline.word(end), "*" | "/" | "%") {
            end = self.end_of_operand(end + 1, limit);
        }
        operator + 1..end
    }

    /// The token behind the operand that begins with `first`.
    fn end_of_operand(&self, first: usize, limit: usize) -> usize {
        let word = |at: usize| self.outline.word(at);
        let mut at = first;
        while matches!(word(at), "-" | "!" | "~" | "&" | "*") {
            at += 1;
        }
        if word(at) != "(" {
            let behind = skip_template(&self.outline.tokens.tokens, at + 1);
            at = if word(behind) == "(" { behind } else { at + 1 };
        }
        loop {
            at = match word(at) {
                "(" | "[" => self.outline.closing(at) + 1,
                "." => at + 2,
                _ => return at.min(limit),
            };
        }
    }

    /// All that is indexed in a statement.
    fn indexed(&self, statement: &Range<usize>) -> Vec<Indexed> {
        let mut found = Vec::new();
        for open in statement.start + 1..statement.end {
            if self.outline.word(open) == "[" && self.ends_operand(open - 1) {
                let first = self.first_of_operand(open - 1, statement.start);
                found.push(Indexed {
                    expression: first..open,
                    close: self.outline.closing(open),
                });
            }
        }
        found
    }

    /// The places of an operator between two operands.
    fn operators(&self, statement: &Range<usize>, operator: &str) -> Vec<Range<usize>> {
        let text = self.outline.text;
        let is_longer = |end: usize| {
            let next = text[end..].chars().next();
            matches!(operator, "<" | ">") && next.is_some_and(|c| "<>=".contains(c))
        };
        let mut found = Vec::new();
        for at in statement.start + 1..statement.end {
            let start = self.outline.span(at).start;
            let is_it = text[start..].starts_with(operator) && self.ends_operand(at - 1);
            if is_it && !is_longer(start + operator.len()) {
                found.push(at..at + operator.len());
            }
        }
        found
    }

    /// Whether an operand may end with a token.
    fn ends_operand(&self, at: usize) -> bool {
        let token = self.outline.tokens.tokens[at];
        match token.kind {
            TokenKind::Number => true,
            TokenKind::Word => !begins_expression(token.text),
            TokenKind::Punct => matches!(token.text, ")" | "]"),
        }
    }

    /// The first token of the operand that ends with `last`: a name, a number or brackets, with members, indices and calls behind it.
    fn first_of_operand(&self, last: usize, limit: usize) -> usize {
        let mut at = last;
        loop {
            if matches!(self.outline.word(at), ")" | "]") {
                let Some(open) = self.opening(at, limit) else {
                    return at;
                };
                match self.in_front_of(open, limit) {
                    Some(before) => at = before,
                    None => return open,
                }
            } else if at >= limit + 2 && self.outline.word(at - 1) == "." {
                at -= 2;
            } else {
                return at;
            }
        }
    }

    /// The last token of what is called or indexed with the bracket at `open`. None where that stands around an expression.
    fn in_front_of(&self, open: usize, limit: usize) -> Option<usize> {
        let within = |at: &usize| *at >= limit;
        let before = open.checked_sub(1).filter(within)?;
        let last = match self.outline.word(before) {
            ">" => self.opening(before, limit)?.checked_sub(1).filter(within)?,
            _ => before,
        };
        self.ends_operand(last).then_some(last)
    }

    /// The bracket that the one at `close` closes.
    fn opening(&self, close: usize, limit: usize) -> Option<usize> {
        let closer = self.outline.word(close);
        let opener = match closer {
            ")" => "(",
            "]" => "[",
            _ => "<",
        };
        let mut depth = 0usize;
        (limit..=close).rev().find(|&at| {
            let word = self.outline.word(at);
            if word == closer {
                depth += 1;
            } else if word == opener {
                depth -= 1;
            }
            depth == 0
        })
    }
}

/// Whether an expression may follow a word, which so is no name.
fn begins_expression(word: &str) -> bool {
    matches!(
        word,
        "return" | "if" | "while" | "switch" | "case" | "else" | "const_assert"
    )
}

/// The type that an integer, or a vector of them, is to become where it meets numbers with fractions. None of other types.
fn float_like(ty: &str) -> Option<&'static str> {
    let (shape, scalar) = match ty.split_once('<') {
        Some((shape, rest)) => (shape, rest.trim_end_matches('>')),
        None => ("", ty),
    };
    let to = match shape {
        "" => "f32",
        "vec2" => "vec2f",
        "vec3" => "vec3f",
        "vec4" => "vec4f",
        _ => return None,
    };
    matches!(scalar, "i32" | "u32").then_some(to)
}
