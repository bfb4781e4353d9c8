//! Changes on their way from who edits to the session, which may be busy for a while.

use super::edit::Edit;
use super::{Session, SessionError};

/// What a session has to be told.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// One key has changed, as while a slider is dragged. `text` is the whole look with it.
    Edit {
        /// What.
        edit: Edit,
        /// Everything.
        text: String,
    },
    /// Any number of keys and tables have changed; the look is this now.
    Text(String),
}

impl Change {
    /// The whole look with it.
    pub fn text(&self) -> &str {
        match self {
            Self::Edit { text, .. } | Self::Text(text) => text,
        }
    }

    /// Whether it says all that `former` said, too.
    fn replaces(&self, former: &Self) -> bool {
        match (former, self) {
            (_, Self::Text(_)) => true,
            (
                Self::Edit {
                    edit: Edit::Set { section, key, .. },
                    ..
                },
                Self::Edit {
                    edit:
                        Edit::Set {
                            section: same_section,
                            key: same_key,
                            ..
                        },
                    ..
                },
            ) => section == same_section && key == same_key,
            _ => false,
        }
    }
}

/// Changes that wait, in order. Of several of one key that follow each other the last counts, and a whole text counts
/// more than all that came before it: a stream of them, as while a slider is dragged, doesn't become a queue.
#[derive(Debug, Clone, Default)]
pub struct ChangeQueue {
    changes: Vec<Change>,
}

impl ChangeQueue {
    /// One more.
    pub fn push(&mut self, change: Change) {
        if let Some(Change::Text(text)) = self.changes.last_mut() {
            // The text that waits is sent as a whole anyway.
            change.text().clone_into(text);
            return;
        }
        while self.changes.pop_if(|last| change.replaces(last)).is_some() {}
        self.changes.push(change);
    }

    /// Nothing waits.
    pub fn is_empty(&self) -> bool {
        self.changes.is_empty()
    }

    /// All of them, from now on no longer here.
    pub fn take(&mut self) -> Vec<Change> {
        std::mem::take(&mut self.changes)
    }
}

impl Session {
    /// Makes a change that was made to a [`super::Document`]. What can't be shown becomes one of the
    /// [problems](Self::problems), and the picture stays as it is until that is mended or undone.
    ///
    /// # Errors
    /// The device.
    pub fn apply(&mut self, change: &Change) -> Result<(), SessionError> {
        let Change::Edit { edit, text } = change else {
            return self.replace_look(change.text());
        };
        match self.edit(edit) {
            // As a whole text it is no error but a problem, and stays one until it is mended.
            Err(SessionError::Refused(_)) => self.replace_look(text),
            // The same look may be written in another way where edits before this one were left out.
            Ok(()) if self.look_text() != *text => self.replace_look(text),
            outcome => outcome,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(key: &str, x: f32) -> Change {
        let edit = Edit::argument("a", key, &texgen::Value::F32(x));
        let text = format!("{key} {x}");
        Change::Edit { edit, text }
    }

    fn waiting(changes: impl IntoIterator<Item = Change>) -> Vec<Change> {
        let mut queue = ChangeQueue::default();
        changes.into_iter().for_each(|change| queue.push(change));
        queue.take()
    }

    #[test]
    fn what_a_later_change_says_too_is_left_out() {
        let text = |text: &str| Change::Text(text.to_owned());
        let drag = [set("x", 1.0), set("x", 2.0), set("y", 1.0), set("x", 3.0)];
        let kept = [set("x", 2.0), set("y", 1.0), set("x", 3.0)];
        assert_eq!(waiting(drag), kept);
        assert_eq!(waiting([set("x", 1.0), text("all")]), [text("all")]);
        assert_eq!(waiting([text("all"), set("x", 1.0)]), [text("x 1")]);
        assert_eq!(waiting([text("one"), text("two")]), [text("two")]);
    }
}
