//! Line ends of a text that is edited: what writes TOML ends all lines with LF.

use std::collections::{HashMap, VecDeque};

/// Before the first line, in some files.
pub(super) const BYTE_ORDER_MARK: &str = "\u{feff}";
const CR_LF: &str = "\r\n";

/// How the lines of a text end.
#[derive(Debug, Clone)]
pub(super) enum LineEnds {
    Lf,
    CrLf,
    /// Some this way, some that way: the text itself.
    Mixed(String),
}

impl LineEnds {
    pub(super) fn of(text: &str) -> Self {
        let with_cr = text.matches(CR_LF).count();
        match (with_cr, text.matches('\n').count() - with_cr) {
            (0, _) => Self::Lf,
            (_, 0) => Self::CrLf,
            _ => Self::Mixed(text.to_owned()),
        }
    }

    /// A later version of the text, whose lines end with LF: those that were there before end as they did, the others as most do.
    pub(super) fn restored(&self, text: String) -> String {
        match self {
            Self::Lf => text,
            Self::CrLf => text.replace(CR_LF, "\n").replace('\n', CR_LF),
            Self::Mixed(before) => restored(before, &text),
        }
    }
}

fn restored(before: &str, after: &str) -> String {
    let old: Vec<&str> = before.split_inclusive('\n').collect();
    let new: Vec<&str> = after.split_inclusive('\n').collect();
    let with_cr = before.matches(CR_LF).count();
    let usual = match 2 * with_cr > before.matches('\n').count() {
        true => CR_LF,
        false => "\n",
    };
    let is_same = |(a, b): &(&&str, &&str)| content(a) == content(b);
    let start = old.iter().zip(&new).take_while(is_same).count();
    let shorter = old.len().min(new.len());
    let last = (old.iter().rev().zip(new.iter().rev())).take_while(is_same);
    let last = last.count().min(shorter - start);
    // Where several lines between those are the same, they end in their order.
    let mut between: HashMap<&str, VecDeque<&str>> = HashMap::new();
    for line in &old[start..old.len() - last] {
        between
            .entry(content(line))
            .or_default()
            .push_back(end(line));
    }
    let mut text = String::with_capacity(before.len().max(after.len()));
    for (at, line) in new.iter().enumerate() {
        text.push_str(line.trim_end_matches(['\r', '\n']));
        if !line.ends_with('\n') {
            continue;
        }
        let known = match new.len() - at {
            _ if at < start => Some(end(old[at])),
            left if left <= last => Some(end(old[old.len() - left])),
            _ => between.get_mut(content(line)).and_then(VecDeque::pop_front),
        };
        // The last line may have had none.
        text.push_str(known.filter(|end| !end.is_empty()).unwrap_or(usual));
    }
    text
}

/// A line without its end.
fn content(line: &str) -> &str {
    let line = line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line);
    line.trim_end_matches(['\r', '\n'])
}

fn end(line: &str) -> &'static str {
    match line {
        _ if line.ends_with(CR_LF) => CR_LF,
        _ if line.ends_with('\n') => "\n",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_keep_their_ends_wherever_others_come_and_go() {
        let before = "a\r\nb\nc\r\n\nd\r\n\ne";
        let ends = LineEnds::of(before);
        let restored = |text: &str| ends.restored(text.to_owned());
        assert_eq!(restored("a\nb\nc\n\nd\n\ne"), before);
        assert_eq!(restored("a\nb\nc\n\nd\ne"), "a\r\nb\nc\r\n\nd\r\ne");
        assert_eq!(
            restored("x\na\nb\nC\n\nd\n\ne\n"),
            "x\na\r\nb\nC\n\nd\r\n\ne\n"
        );
        assert_eq!(restored(""), "");
        assert!(matches!(LineEnds::of("a\nb"), LineEnds::Lf));
        assert!(matches!(LineEnds::of("a\r\nb\r\n"), LineEnds::CrLf));
    }
}
