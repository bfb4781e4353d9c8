//! The statements of a file's functions, over tokens: worked out once, however many of them are asked for.

use std::ops::Range;

use crate::scope::Outline;

/// Tokens of a statement, its `;` included; of one with a block, those before the block.
#[derive(Clone, Debug)]
pub(super) struct Statement {
    pub(super) tokens: Range<usize>,
    /// The `{` of its block.
    pub(super) block: Option<usize>,
}

/// The statements of all functions.
#[derive(Debug)]
pub(super) struct Statements {
    all: Vec<Statement>,
    /// The one that each token lies in.
    of_token: Vec<Option<usize>>,
}

impl Statements {
    pub(super) fn new(outline: &Outline<'_>) -> Self {
        let mut all = Vec::new();
        let mut of_token = vec![None; outline.tokens.tokens.len()];
        for function in &outline.functions {
            let inside = function.body.start + 1..function.body.end;
            let (mut start, mut depth) = (inside.start, 0usize);
            for at in inside {
                let (tokens, block) = match outline.word(at) {
                    "(" | "[" => {
                        depth += 1;
                        continue;
                    }
                    ")" | "]" => {
                        depth = depth.saturating_sub(1);
                        continue;
                    }
                    ";" if depth == 0 => (start..at + 1, None),
                    "{" => (start..at, Some(at)),
                    "}" => (start..at, None),
                    _ => continue,
                };
                // In front of a `}` stands the last one of a block without its semicolon, or nothing.
                if block.is_some() || !tokens.is_empty() {
                    of_token[start..=at].fill(Some(all.len()));
                    all.push(Statement { tokens, block });
                }
                (start, depth) = (at + 1, 0);
            }
        }
        Self { all, of_token }
    }

    /// The one that a token of a function's body lies in.
    pub(super) fn at(&self, token: usize) -> Option<&Statement> {
        let index = (*self.of_token.get(token)?)?;
        self.all.get(index)
    }

    /// Those that begin among some tokens.
    pub(super) fn among(&self, tokens: &Range<usize>) -> &[Statement] {
        let first = self
            .all
            .partition_point(|statement| statement.tokens.start < tokens.start);
        let end = self
            .all
            .partition_point(|statement| statement.tokens.start < tokens.end);
        &self.all[first..end]
    }
}
