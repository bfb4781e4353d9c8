//! Where a value is used, by the text of the statement that uses it: of what is declared elsewhere, naga knows that place only.

use std::ops::Range;

use naga::{Block, Span, Statement};

use crate::tokens::tokenize;

/// Which of several places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    First,
    Last,
}

/// The place of the first statement that is meant, in the order in which naga checks them.
pub(super) fn find(block: &Block, is_meant: &dyn Fn(&Statement) -> bool) -> Option<Span> {
    for (statement, span) in block.span_iter() {
        if is_meant(statement) {
            return Some(*span);
        }
        let inside = match statement {
            Statement::Block(inner) => find(inner, is_meant),
            Statement::If { accept, reject, .. } => {
                find(accept, is_meant).or_else(|| find(reject, is_meant))
            }
            Statement::Switch { cases, .. } => {
                cases.iter().find_map(|case| find(&case.body, is_meant))
            }
            Statement::Loop {
                body, continuing, ..
            } => find(body, is_meant).or_else(|| find(continuing, is_meant)),
            _ => None,
        };
        if inside.is_some() {
            return inside;
        }
    }
    None
}

/// A statement without its block, its semicolon and the blanks around it.
pub(super) fn head(text: &str, statement: &Range<usize>) -> Range<usize> {
    let Some(whole) = text.get(statement.clone()) else {
        return statement.clone();
    };
    let tokens = tokenize(whole).tokens;
    let mut head = tokens
        .iter()
        .take_while(|token| !matches!(token.text, "{" | ";"));
    let Some(first) = head.next() else {
        return statement.start..statement.start;
    };
    let last = head.last().unwrap_or(first);
    statement.start + first.start..statement.start + last.end()
}

/// The end of a loop, where its `break if` stands.
pub(super) fn from_last_break(text: &str, the_loop: Range<usize>) -> Range<usize> {
    let whole = text.get(the_loop.clone()).unwrap_or_default();
    let tokens = tokenize(whole).tokens;
    let last = tokens.iter().rfind(|token| token.text == "break");
    let start = the_loop.start + last.map_or(0, |token| token.start);
    start..the_loop.end
}

/// A place where a stretch of the text has a name that isn't a member's.
pub(super) fn mention(
    text: &str,
    within: &Range<usize>,
    name: &str,
    side: Side,
) -> Option<Range<usize>> {
    let tokens = tokenize(text.get(within.clone())?).tokens;
    let is_it = |&at: &usize| {
        let is_member = at > 0 && tokens[at - 1].text == ".";
        tokens[at].text == name && !is_member
    };
    let mut places = 0..tokens.len();
    let at = match side {
        Side::First => places.find(is_it),
        Side::Last => places.rev().find(is_it),
    }?;
    let start = within.start + tokens[at].start;
    Some(start..start + name.len())
}

/// An argument of a call that has `count` of them, where the text leaves no doubt.
pub(super) fn argument(
    text: &str,
    call: &Range<usize>,
    number: usize,
    count: usize,
) -> Option<Range<usize>> {
    let tokens = tokenize(text.get(call.clone())?).tokens;
    let open = tokens.iter().position(|token| token.text == "(")?;
    let mut arguments: Vec<Range<usize>> = Vec::new();
    let mut current: Option<Range<usize>> = None;
    let mut depth = 0usize;
    for token in &tokens[open + 1..] {
        match token.text {
            "(" | "[" => depth += 1,
            ")" | "," if depth == 0 => {
                arguments.extend(current.take());
                if token.text == ")" {
                    break;
                }
                continue;
            }
            ")" | "]" => depth = depth.saturating_sub(1),
            _ => {}
        }
        let start = current.map_or(token.start, |before| before.start);
        current = Some(start..token.end());
    }
    let found = arguments.get(number).filter(|_| arguments.len() == count)?;
    Some(call.start + found.start..call.start + found.end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uses_are_found_in_the_text_of_a_statement() {
        let text = "if  a.x > x { x = 1.0; }";
        let head = head(text, &(0..text.len()));
        assert_eq!(&text[head.clone()], "if  a.x > x");
        assert_eq!(mention(text, &head, "x", Side::First), Some(10..11));
        assert_eq!(mention(text, &head, "a", Side::Last), Some(4..5));
        assert_eq!(mention(text, &head, "y", Side::First), None);
        let text = "loop { if a { break; } continuing { break if a; } }";
        let end = from_last_break(text, 0..text.len());
        assert_eq!(&text[end], "break if a; } }");
    }

    #[test]
    fn comments_belong_to_no_statement() {
        let text = "if /* a; b { */ a /* { */ { }";
        let head = head(text, &(0..text.len()));
        assert_eq!(&text[head.clone()], "if /* a; b { */ a");
        assert_eq!(mention(text, &head, "a", Side::First), Some(16..17));
        let text = "loop { continuing { break if breaks; /* no break */ } }";
        let end = from_last_break(text, 0..text.len());
        assert_eq!(&text[end], "break if breaks; /* no break */ } }");
    }

    #[test]
    fn arguments_are_counted() {
        let text = "f(g(a, b[c, d]), 2.0 * x, )";
        let of = |number: usize, count: usize| {
            argument(text, &(0..text.len()), number, count).map(|span| &text[span])
        };
        assert_eq!(of(0, 2), Some("g(a, b[c, d])"));
        assert_eq!(of(1, 2), Some("2.0 * x"));
        assert_eq!(of(1, 3), None, "a template's comma may be among them");
    }
}
