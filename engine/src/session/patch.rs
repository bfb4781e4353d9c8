//! One change of a text, as small as it can be said: what is taken out at a place, and what comes in.

/// Takes `removed` out at a byte offset and puts `inserted` there. It can be undone to the byte.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Patch {
    at: usize,
    removed: String,
    inserted: String,
}

impl Patch {
    /// What makes `after` of `before`; `None` where they are the same.
    pub(super) fn between(before: &str, after: &str) -> Option<Self> {
        if before == after {
            return None;
        }
        let same = |(a, b): &(u8, u8)| a == b;
        let mut start = before.bytes().zip(after.bytes()).take_while(same).count();
        // A character may differ in its last byte only.
        while !before.is_char_boundary(start) {
            start -= 1;
        }
        let (old, new) = (&before[start..], &after[start..]);
        let backwards = old.bytes().rev().zip(new.bytes().rev());
        let mut end = backwards.take_while(same).count();
        while !old.is_char_boundary(old.len() - end) {
            end -= 1;
        }
        Some(Self {
            at: start,
            removed: old[..old.len() - end].to_owned(),
            inserted: new[..new.len() - end].to_owned(),
        })
    }

    /// What it takes to remember it.
    pub(super) fn bytes(&self) -> usize {
        self.removed.len() + self.inserted.len()
    }

    /// Changes the text it was made for.
    pub(super) fn apply(&self, text: &mut String) {
        text.replace_range(self.at..self.at + self.removed.len(), &self.inserted);
    }

    /// Changes it back.
    pub(super) fn revert(&self, text: &mut String) {
        text.replace_range(self.at..self.at + self.inserted.len(), &self.removed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_goes_both_ways() {
        for (before, after) in [
            ("", "a"),
            ("a", ""),
            ("aaa", "aa"),
            ("scale = 1 # é", "scale = 12 # é"),
            ("é", "è"),
            ("xéx", "xèx"),
            ("é", "\u{fe9}"),
            ("abcabc", "abc"),
        ] {
            let patch = Patch::between(before, after).expect("they differ");
            let mut text = before.to_owned();
            patch.apply(&mut text);
            assert_eq!(text, after);
            patch.revert(&mut text);
            assert_eq!(text, before);
        }
        assert_eq!(Patch::between("same", "same"), None);
        let small = Patch::between("scale = 1.0\nx = 2", "scale = 1.5\nx = 2");
        let expected = Patch {
            at: 10,
            removed: "0".into(),
            inserted: "5".into(),
        };
        assert_eq!(small, Some(expected));
    }
}
