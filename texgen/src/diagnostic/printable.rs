//! Text from files as a terminal may get it: nothing in it moves the cursor, changes colours or turns the reading direction.

use std::borrow::Cow;

/// `text` with its control characters written as `\u{1b}`, so that what a file holds can't steer a terminal. Line breaks and
/// tabs stay as they are (a carriage return in front of a line break is left out). Characters that turn the direction of
/// what follows are written out as well: they make text look like what it isn't.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(must_be_escaped) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '\r' if rest.peek() == Some(&'\n') => {}
            c if must_be_escaped(c) => out.extend(c.escape_unicode()),
            c => out.push(c),
        }
    }
    Cow::Owned(out)
}

/// Whether [`printable`] writes this character out.
pub fn must_be_escaped(c: char) -> bool {
    (c.is_control() && !matches!(c, '\n' | '\t'))
        || matches!(
            c,
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        )
}

#[cfg(test)]
mod tests {
    use super::printable;

    #[test]
    fn control_characters_are_written_out() {
        assert!(matches!(
            printable("a\tb\nc é"),
            std::borrow::Cow::Borrowed("a\tb\nc é")
        ));
        assert_eq!(printable("\u{1b}[31mred"), "\\u{1b}[31mred");
        assert_eq!(
            printable("bell\u{7}, csi \u{9b}0m"),
            "bell\\u{7}, csi \\u{9b}0m"
        );
        assert_eq!(printable("a\r\nb\rc"), "a\nb\\u{d}c");
        assert_eq!(printable("\u{202e}gnp.exe"), "\\u{202e}gnp.exe");
    }
}
