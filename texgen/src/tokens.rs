//! WGSL text to tokens: just enough for renaming and for finding constructs, never a parser. naga decides what
//! is valid; this must only agree with it on where names, numbers and comments begin and end.

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TokenKind {
    /// A name or a keyword.
    Word,
    /// A numeric literal.
    Number,
    /// One character of punctuation: `->` and `<<=` come as single characters.
    Punct,
}

/// A token and where it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Token<'a> {
    pub(crate) kind: TokenKind,
    pub(crate) text: &'a str,
    pub(crate) start: usize,
}

impl Token<'_> {
    /// Byte offset behind the token.
    pub(crate) fn end(&self) -> usize {
        self.start + self.text.len()
    }

    /// Byte range of the token.
    pub(crate) fn span(&self) -> std::ops::Range<usize> {
        self.start..self.end()
    }
}

/// A comment, delimiters included.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Comment<'a> {
    pub(crate) text: &'a str,
    pub(crate) start: usize,
    /// Index of the first token behind it.
    pub(crate) next_token: usize,
}

/// All tokens and comments of a text.
#[derive(Debug, Default)]
pub(crate) struct Tokens<'a> {
    pub(crate) tokens: Vec<Token<'a>>,
    pub(crate) comments: Vec<Comment<'a>>,
}

impl<'a> Tokens<'a> {
    /// The comment that the text ends in, where nothing closes it.
    pub(crate) fn unclosed(&self) -> Option<&Comment<'a>> {
        let last = self.comments.last()?;
        (last.text.starts_with("/*") && !is_closed(last.text)).then_some(last)
    }
}

/// Splits `text`. Never fails: what is no token is punctuation, an unterminated comment ends with the text.
pub(crate) fn tokenize(text: &str) -> Tokens<'_> {
    let mut out = Tokens::default();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let length = if is_space(c) {
            c.len_utf8()
        } else if rest.starts_with("//") {
            let length = rest.find(is_line_end).unwrap_or(rest.len());
            out.comments.push(Comment {
                text: &rest[..length],
                start: at,
                next_token: out.tokens.len(),
            });
            length
        } else if rest.starts_with("/*") {
            let length = block_comment_length(rest);
            out.comments.push(Comment {
                text: &rest[..length],
                start: at,
                next_token: out.tokens.len(),
            });
            length
        } else {
            let (kind, length) = if is_word_start(c) {
                (
                    TokenKind::Word,
                    rest.find(|c| !is_word_part(c)).unwrap_or(rest.len()),
                )
            } else if c.is_ascii_digit()
                || (c == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit()))
            {
                (TokenKind::Number, number_length(rest))
            } else {
                (TokenKind::Punct, c.len_utf8())
            };
            out.tokens.push(Token {
                kind,
                text: &rest[..length],
                start: at,
            });
            length
        };
        at += length;
    }
    out
}

/// Blank space as WGSL defines it.
fn is_space(c: char) -> bool {
    matches!(
        c,
        ' ' | '\t'..='\r' | '\u{85}' | '\u{200e}' | '\u{200f}' | '\u{2028}' | '\u{2029}'
    )
}

/// What ends a `//` comment as WGSL defines it.
fn is_line_end(c: char) -> bool {
    matches!(c, '\n'..='\r' | '\u{85}' | '\u{2028}' | '\u{2029}')
}

/// Any letter beyond ASCII counts: WGSL has no use for such a character but in names and comments.
fn is_word_start(c: char) -> bool {
    c == '_' || c.is_ascii_alphabetic() || (!c.is_ascii() && !is_space(c))
}

fn is_word_part(c: char) -> bool {
    is_word_start(c) || c.is_ascii_digit()
}

/// Block comments nest.
fn block_comment_length(text: &str) -> usize {
    block_comment(text).0
}

fn is_closed(comment: &str) -> bool {
    block_comment(comment).1
}

/// Bytes of the comment that a text begins with, and whether it is closed.
fn block_comment(text: &str) -> (usize, bool) {
    let bytes = text.as_bytes();
    let (mut at, mut depth) = (2, 1);
    while depth > 0 && at < bytes.len() {
        match (bytes[at], bytes.get(at + 1)) {
            (b'/', Some(b'*')) => {
                depth += 1;
                at += 2;
            }
            (b'*', Some(b'/')) => {
                depth -= 1;
                at += 2;
            }
            _ => at += 1,
        }
    }
    (at.min(bytes.len()), depth == 0)
}

fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let hexadecimal = bytes.len() > 1 && bytes[0] == b'0' && matches!(bytes[1], b'x' | b'X');
    let exponent: &[u8] = if hexadecimal { b"pP" } else { b"eE" };
    let mut at = if hexadecimal { 2 } else { 0 };
    while let Some(&byte) = bytes.get(at) {
        let sign_of_exponent =
            matches!(byte, b'+' | b'-') && at > 0 && exponent.contains(&bytes[at - 1]);
        if !(byte.is_ascii_alphanumeric() || byte == b'.' || sign_of_exponent) {
            break;
        }
        at += 1;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<&str> {
        tokenize(text)
            .tokens
            .iter()
            .map(|token| token.text)
            .collect()
    }

    #[test]
    fn names_numbers_and_punctuation() {
        assert_eq!(words("a+1.5e-3f*.5"), ["a", "+", "1.5e-3f", "*", ".5"]);
        assert_eq!(words("0x1p+2-x.y"), ["0x1p+2", "-", "x", ".", "y"]);
        assert_eq!(words("0xe+1"), ["0xe", "+", "1"]);
        assert_eq!(words("p.xyz.x"), ["p", ".", "xyz", ".", "x"]);
        assert_eq!(words("rost_größe=é"), ["rost_größe", "=", "é"]);
    }

    #[test]
    fn comments_hide_their_content_and_nest() {
        let text = "a /* fn b /* c */ d */ e // fn f\ng /* open";
        let tokens = tokenize(text);
        assert_eq!(words(text), ["a", "e", "g"]);
        let comments: Vec<_> = tokens.comments.iter().map(|c| c.text).collect();
        assert_eq!(comments, ["/* fn b /* c */ d */", "// fn f", "/* open"]);
        assert_eq!(tokens.comments[1].next_token, 2);
    }
}
