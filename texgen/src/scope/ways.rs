//! Where statements lead, over tokens: WGSL's "Behavior Analysis", as far as it tells whether a function's end is reached.
//!
//! naga follows no loops there: behind a loop that nothing but a `return` leaves, it wants a `return`.

use super::{FunctionDecl, Outline, matching};
use crate::tokens::Token;

/// Blocks are followed this deep; naga refuses deeper ones.
const MAX_DEPTH: usize = 127;

/// Where a statement leads, but for a `return`.
#[derive(Clone, Copy, Debug)]
struct Ways {
    /// To the statement behind it.
    goes_on: bool,
    /// Out of the loop or `switch` that it is in.
    breaks: bool,
    /// naga sees that it doesn't go on, if it doesn't.
    is_seen: bool,
}

impl Ways {
    /// A plain statement.
    const ON: Self = Self {
        goes_on: true,
        breaks: false,
        is_seen: false,
    };

    /// Nowhere, as a `return`.
    const NOWHERE: Self = Self {
        goes_on: false,
        breaks: false,
        is_seen: true,
    };

    /// Of one of two statements.
    fn or(self, other: Self) -> Self {
        Self {
            goes_on: self.goes_on || other.goes_on,
            breaks: self.breaks || other.breaks,
            is_seen: self.is_seen && other.is_seen,
        }
    }
}

impl Outline<'_> {
    /// Whether no way through a function with a result leads to its end, but some end in a loop that nothing but a `return`
    /// leaves: naga, unlike WGSL, wants a `return` at the function's end then, also where the loop is within a block.
    pub(crate) fn ends_with_endless_loop(&self, function: &FunctionDecl) -> bool {
        if function.result.is_empty() {
            return false;
        }
        let mut reader = Reader {
            tokens: &self.tokens.tokens,
            at: function.body.start,
            depth: 0,
        };
        let ways = reader.block();
        !ways.goes_on && !ways.is_seen
    }
}

/// Reads statements one after the other, each token once.
struct Reader<'o, 'a> {
    tokens: &'o [Token<'a>],
    at: usize,
    /// Blocks that it is in.
    depth: usize,
}

impl<'a> Reader<'_, 'a> {
    /// The token that it stands at; empty at the end.
    fn word(&self) -> &'a str {
        self.tokens.get(self.at).map_or("", |token| token.text)
    }

    /// Steps to the next brace or `;`.
    fn skip(&mut self) {
        while !matches!(self.word(), "" | "{" | "}" | ";") {
            self.at += 1;
        }
    }

    /// Steps behind the bracket that closes the one here.
    fn skip_brackets(&mut self) {
        self.at = self.tokens.len().min(matching(self.tokens, self.at) + 1);
    }

    /// Steps over a block. Stays where there is none: it isn't WGSL then.
    fn block(&mut self) -> Ways {
        if self.word() != "{" {
            return Ways::ON;
        }
        if self.depth == MAX_DEPTH {
            self.skip_brackets();
            return Ways::ON;
        }
        self.depth += 1;
        self.at += 1;
        let mut ways = Ways::ON;
        loop {
            match self.word() {
                "" => break,
                "}" => {
                    self.at += 1;
                    break;
                }
                ";" => self.at += 1,
                // It is reached by `continue`, too.
                "continuing" => {
                    self.at += 1;
                    ways.breaks |= self.block().breaks;
                }
                _ => {
                    let last = self.statement();
                    ways.is_seen = last.is_seen;
                    // Else it is never reached.
                    if ways.goes_on {
                        ways.goes_on = last.goes_on;
                        ways.breaks |= last.breaks;
                    }
                }
            }
        }
        self.depth -= 1;
        ways
    }

    /// Steps over a statement.
    fn statement(&mut self) -> Ways {
        let keyword = self.word();
        if keyword == "{" {
            return self.block();
        }
        self.at += 1;
        match keyword {
            "if" => self.branches(),
            "switch" => self.cases(),
            "loop" => self.turns(true),
            "while" => {
                self.skip();
                self.turns(false)
            }
            "for" => {
                let is_endless = self.header();
                self.turns(is_endless)
            }
            _ => {
                let is_conditional = self.word() == "if";
                self.skip();
                match keyword {
                    "return" | "continue" => Ways::NOWHERE,
                    "break" => Ways {
                        goes_on: is_conditional,
                        breaks: true,
                        is_seen: true,
                    },
                    _ => Ways::ON,
                }
            }
        }
    }

    /// What is behind an `if`.
    fn branches(&mut self) -> Ways {
        let mut any = Ways::NOWHERE;
        loop {
            self.skip();
            any = any.or(self.block());
            if self.word() != "else" {
                return any.or(Ways::ON);
            }
            self.at += 1;
            if self.word() != "if" {
                return any.or(self.block());
            }
            self.at += 1;
        }
    }

    /// What is behind a `switch`.
    fn cases(&mut self) -> Ways {
        self.skip();
        if self.word() != "{" {
            return Ways::ON;
        }
        self.at += 1;
        let mut any = Ways::NOWHERE;
        loop {
            match self.word() {
                "" => break,
                "}" => {
                    self.at += 1;
                    break;
                }
                "{" => any = any.or(self.block()),
                _ => self.at += 1, // `case` and its values
            }
        }
        Ways {
            goes_on: any.goes_on || any.breaks,
            breaks: false,
            is_seen: any.is_seen,
        }
    }

    /// A `for` loop's header; whether it has no condition.
    fn header(&mut self) -> bool {
        let start = self.at;
        self.skip_brackets();
        let mut semicolons = (start..self.at).filter(|&at| self.tokens[at].text == ";");
        let first = semicolons.next();
        first.is_some_and(|first| semicolons.next() == Some(first + 1))
    }

    /// A loop's body.
    fn turns(&mut self, is_endless: bool) -> Ways {
        let body = self.block();
        Ways {
            goes_on: !is_endless || body.breaks,
            breaks: false,
            is_seen: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Outline;

    /// Whether a function with this body wants a `return` at its end.
    fn ends(body: &str) -> bool {
        let text = format!("fn f() -> f32 {{ {body} }}");
        let outline = Outline::new(&text);
        outline.ends_with_endless_loop(&outline.functions[0])
    }

    #[test]
    fn endless_loops_are_found_wherever_they_end_a_function() {
        for body in [
            "loop { return 1.0; }",
            "for (;;) { if a { return 1.0; } }",
            "for (var i = 0; ; i++) { }",
            "{ loop { return 1.0; } }",
            "{ { loop { } } };",
            "if a { loop { } } else { return 2.0; }",
            "if a { return 1.0; } else if b { { for (;;) { } } } else { return 2.0; }",
            "switch a { case 1, 2: { loop { } } default: { return 1.0; } }",
            "loop { switch a { case 1: { break; } default { continue; } } }",
            "loop { loop { break; } while a { break; } for (; a; ) { break; } }",
            "loop { let x = 1; continuing { x(); } }",
            "loop { } let x = 1;",
            "return 1.0; let x = 1;",
            "loop { return 1.0; break; }",
        ] {
            assert!(ends(body), "{body}");
        }
    }

    #[test]
    fn what_may_reach_the_end_or_ends_plainly_is_left_alone() {
        for body in [
            "",
            "let x = 1;",
            "return 1.0;",
            "{ return 1.0; }",
            "if a { return 1.0; } else { return 2.0; }",
            "loop { } return 1.0;",
            "loop { break; }",
            "loop { if a { break; } }",
            "loop { return 1.0; continuing { break if a; } }",
            "for (; a; ) { return 1.0; }",
            "while a { return 1.0; }",
            "if a { loop { } }",
            "if a { loop { } } else if b { return 1.0; }",
            "switch a { case 1: { loop { } } default: { break; } }",
            "switch a { case 1: { loop { } } default: { } }",
        ] {
            assert!(!ends(body), "{body}");
        }
        let deep = format!("{}loop {{ }}{}", "{".repeat(5000), "}".repeat(5000));
        assert!(!ends(&deep));
    }

    #[test]
    fn broken_text_is_survived() {
        for body in [
            "if",
            "if a",
            "if a {",
            "else",
            "switch",
            "switch a {",
            "for",
            "for (",
            "for (;",
            "loop",
            "loop {",
            "continuing",
            "}",
            "} }",
            "break",
            "return",
            "if a { } else",
            "case",
        ] {
            let _ = ends(body);
        }
        // A function that ends in the middle of something.
        for text in [
            "fn f() -> f32 {",
            "fn f() -> f32 { loop",
            "fn f() -> f32 { for",
        ] {
            let outline = Outline::new(text);
            let _ = outline.ends_with_endless_loop(&outline.functions[0]);
        }
    }
}
