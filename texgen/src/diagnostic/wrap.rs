//! Long sentences as lines of a terminal's width.

/// Columns that a character takes, at most: East Asian ones and pictures take two.
pub(super) fn width_of(c: char) -> usize {
    match c {
        c if c < '\u{1100}' => 1,
        _ => 2,
    }
}

/// Columns that a text takes, at most.
pub(super) fn width(text: &str) -> usize {
    text.chars().map(width_of).sum()
}

/// `text` with line breaks between words, so that its first line takes at most `first` columns and the others at most
/// `others`. Words that are longer are cut. Breaks that it has stay.
pub(super) fn wrap(text: &str, first: usize, others: usize) -> String {
    let (first, others) = (first.max(8), others.max(8));
    let mut out = String::with_capacity(text.len() + 8);
    for (number, line) in text.lines().enumerate() {
        if number > 0 {
            out.push('\n');
        }
        wrap_line(
            line,
            if number == 0 { first } else { others },
            others,
            &mut out,
        );
    }
    out
}

fn wrap_line(line: &str, first: usize, others: usize, out: &mut String) {
    let (mut column, mut room) = (0, first);
    for word in words(line) {
        let bare = width(word.trim_end_matches(' '));
        if column > 0 && column + bare > room {
            out.truncate(out.trim_end_matches(' ').len());
            out.push('\n');
            (column, room) = (0, others);
        }
        for c in word.chars() {
            if column + width_of(c) > room {
                if c == ' ' {
                    continue; // at the end of a full line
                }
                out.push('\n');
                (column, room) = (0, others);
            }
            out.push(c);
            column += width_of(c);
        }
    }
    out.truncate(out.trim_end_matches(' ').len());
}

/// The words of a line, each with the blanks behind it. What stands in backticks is one word: it is code.
fn words(line: &str) -> impl Iterator<Item = &str> {
    let mut is_code = false;
    line.split_inclusive(move |c: char| {
        is_code ^= c == '`';
        c == ' ' && !is_code
    })
}

#[cfg(test)]
mod tests {
    use super::wrap;

    #[test]
    fn lines_break_between_words_and_long_words_are_cut() {
        assert_eq!(wrap("short", 10, 10), "short");
        assert_eq!(wrap("one two three four", 10, 12), "one two\nthree four");
        assert_eq!(wrap("0123456789abcdef", 10, 8), "0123456789\nabcdef");
        assert_eq!(wrap("two\nlines stay two", 10, 10), "two\nlines stay\ntwo");
        assert_eq!(wrap("  indented text", 11, 10), "  indented\ntext");
        assert_eq!(wrap("write `a b c`, or", 10, 10), "write\n`a b c`,\nor");
        assert_eq!(wrap("", 10, 10), "");
    }
}
