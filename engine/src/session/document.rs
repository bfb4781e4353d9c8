//! The look that is edited, with its history.
//!
//! The text is the truth: each step of the history is a patch of the text, so that undoing restores it to the byte,
//! comments included. Nothing here knows widgets or devices: whoever edits holds a [`Document`], at once up to date, and
//! brings what has changed to the session, which may be busy on another thread.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use texgen::Diagnostics;

use crate::scene::look::{Field, Look, LookDocument, Section, Value};

use super::change::{Change, ChangeQueue};
use super::edit::{Edit, summary};
use super::patch::Patch;

/// Steps that can be undone.
const MAX_STEPS: usize = 10_000;
/// Bytes of text that these may take together: a look may be large, and an editor replace all of it with each step.
const MAX_BYTES: usize = 64 << 20;

/// Numbers what other programs have written, in all documents: what is kept of one may be brought back in another.
static WRITTEN_BY_OTHERS: AtomicU64 = AtomicU64::new(1);

/// One step of the history.
#[derive(Debug, Clone)]
struct Step {
    label: String,
    patch: Patch,
    /// Further edits of this group belong to this step, as those of one drag.
    group: Option<u64>,
    /// What other programs have written to the file that it brings.
    brings: Vec<u64>,
    /// The same that it takes away.
    leaves_out: Vec<u64>,
}

/// A look as text, with undo and redo for every change.
#[derive(Debug)]
pub struct Document {
    path: PathBuf,
    text: String,
    /// `text`, to be edited.
    document: LookDocument,
    /// `text`, parsed.
    look: Look,
    undo: Vec<Step>,
    redo: Vec<Step>,
    changes: ChangeQueue,
    revision: u64,
    /// What other programs have written to the file, by numbers, as far as the text has it.
    others: BTreeSet<u64>,
    /// All of that, unless somebody has decided to leave it out.
    others_of_file: BTreeSet<u64>,
}

impl Document {
    /// The look in `text`, which lies at `path` or would lie there.
    ///
    /// # Errors
    /// All mistakes of its form.
    pub fn new(path: &Path, text: &str) -> Result<Self, Diagnostics> {
        Ok(Self {
            path: path.to_owned(),
            document: LookDocument::parse(path, text)?,
            look: Look::parse(path, text)?,
            text: text.to_owned(),
            undo: Vec::new(),
            redo: Vec::new(),
            changes: ChangeQueue::default(),
            revision: 0,
            others: BTreeSet::new(),
            others_of_file: BTreeSet::new(),
        })
    }

    /// The whole text, comments, order and formatting as they were written: what is to be saved.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The look that the text means.
    pub fn look(&self) -> &Look {
        &self.look
    }

    /// The keys of a table as they are written; none where there is no such table.
    pub fn table(&self, section: &Section) -> Vec<Field> {
        self.document.table(section).unwrap_or_default()
    }

    /// What a key of a table is set to; `blend.mask` is a key of the table `blend`.
    pub fn value(&self, section: &Section, key: &str) -> Option<Value> {
        let take = |mut fields: Vec<Field>, key: &str| {
            let at = fields.iter().position(|field| field.key.value == key)?;
            Some(fields.swap_remove(at).value.value)
        };
        let (path, last) = key.rsplit_once('.').unwrap_or(("", key));
        let mut fields = self.table(section);
        for step in path.split('.').filter(|step| !step.is_empty()) {
            match take(fields, step)? {
                Value::Table(below) => fields = below,
                _ => return None,
            }
        }
        take(fields, last)
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// It lies elsewhere from now on, as after "save as". Paths in it are relative to that place, and there is nothing of others there.
    pub fn set_path(&mut self, path: &Path) {
        self.path = path.to_owned();
        self.look.path = path.to_owned();
        self.others_of_file.clone_from(&self.others);
        self.revision += 1;
    }

    /// Counts the changes of the text.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Makes some edits as one step that is called `label`, all or none. Edits of one `group` that follow each other
    /// are one step: those of a drag.
    ///
    /// # Errors
    /// With them the text would be no look: says why. Nothing has changed then.
    pub fn apply(&mut self, label: &str, edits: &[Edit], group: Option<u64>) -> Result<(), String> {
        self.change(label, group, edits, |document| {
            edits.iter().try_for_each(|edit| edit.write(document))
        })
    }

    /// Changes the text as one step by whatever means. `told` is what the session may be told of it, if that is all.
    ///
    /// # Errors
    /// As [`Self::apply`].
    pub fn change(
        &mut self,
        label: &str,
        group: Option<u64>,
        told: &[Edit],
        change: impl FnOnce(&mut LookDocument) -> Result<(), String>,
    ) -> Result<(), String> {
        let checked = change(&mut self.document).and_then(|()| {
            let text = self.document.text();
            let look = Look::parse(&self.path, &text).map_err(|p| summary(&p))?;
            Ok((text, look))
        });
        match checked {
            Ok((text, look)) => {
                if let Some(patch) = Patch::between(&self.text, &text) {
                    self.text = text;
                    self.look = look;
                    self.remember(label, patch, group);
                    self.tell(told);
                }
                Ok(())
            }
            Err(message) => {
                self.parse_again();
                Err(message)
            }
        }
    }

    /// Replaces the whole text as one step, as when its file was saved by an editor.
    ///
    /// # Errors
    /// All mistakes of its form; nothing has changed then.
    pub fn replace(&mut self, label: &str, text: &str) -> Result<(), Diagnostics> {
        let document = LookDocument::parse(&self.path, text)?;
        let look = Look::parse(&self.path, text)?;
        if let Some(patch) = Patch::between(&self.text, text) {
            self.text = text.to_owned();
            (self.document, self.look) = (document, look);
            self.remember(label, patch, None);
            self.tell(&[]);
        }
        Ok(())
    }

    /// As [`Self::replace`], with what another program has written to the file, which must not be lost unnoticed: see
    /// [`Self::leaves_out_others`].
    ///
    /// # Errors
    /// As there.
    pub fn replace_by_others(&mut self, label: &str, text: &str) -> Result<(), Diagnostics> {
        let revision = self.revision;
        self.replace(label, text)?;
        if self.revision != revision
            && let Some(step) = self.undo.last_mut()
        {
            let number = WRITTEN_BY_OTHERS.fetch_add(1, Ordering::Relaxed);
            step.brings.push(number);
            self.others.insert(number);
            self.others_of_file.insert(number);
        }
        Ok(())
    }

    /// As [`Self::replace`], with the text that another one has after its last step: what others have written comes and goes as with that.
    ///
    /// # Errors
    /// As there.
    pub(super) fn replace_as_in(
        &mut self,
        other: &Self,
        label: &str,
        text: &str,
    ) -> Result<(), Diagnostics> {
        let revision = self.revision;
        self.replace(label, text)?;
        if self.revision != revision
            && let (Some(step), Some(of)) = (self.undo.last_mut(), other.undo.last())
        {
            step.brings.clone_from(&of.brings);
            step.leaves_out.clone_from(&of.leaves_out);
        }
        Ok(())
    }

    /// What the text has of others, and what there is of them where it lies, if that is all.
    pub(super) fn set_others(&mut self, others: BTreeSet<u64>) {
        self.others_of_file.clone_from(&others);
        self.others = others;
    }

    /// What other programs have written to the file, by numbers, as far as the text has it: to be kept beside a text that
    /// [`Self::return_to`] may bring back.
    pub fn others(&self) -> &BTreeSet<u64> {
        &self.others
    }

    /// As [`Self::replace`], with a text that was kept when it had of others what `others` says: see [`Self::others`]. What they have
    /// written since then is left out by it.
    ///
    /// # Errors
    /// As there.
    pub fn return_to(
        &mut self,
        label: &str,
        text: &str,
        others: &BTreeSet<u64>,
    ) -> Result<(), Diagnostics> {
        let revision = self.revision;
        self.replace(label, text)?;
        if self.revision != revision
            && let Some(step) = self.undo.last_mut()
        {
            step.brings = others.difference(&self.others).copied().collect();
            step.leaves_out = self.others.difference(others).copied().collect();
            self.others.clone_from(others);
        }
        Ok(())
    }

    /// The text lacks something that another program has written to the file: to save would take it away there, too.
    pub fn leaves_out_others(&self) -> bool {
        !self.others_of_file.is_subset(&self.others)
    }

    /// What others have written may be left out: somebody has decided so.
    pub fn leave_out_others(&mut self) {
        let has = &self.others;
        self.others_of_file.retain(|number| has.contains(number));
    }

    /// Ends a group of edits: what follows is a step of its own.
    pub fn end_group(&mut self) {
        if let Some(step) = self.undo.last_mut() {
            step.group = None;
        }
    }

    /// Undoes the last step; false where there is none.
    pub fn undo(&mut self) -> bool {
        let is_there = self.step_back();
        if is_there {
            self.went();
        }
        is_there
    }

    /// Does again what was undone last; false where there is nothing.
    pub fn redo(&mut self) -> bool {
        let is_there = self.step_on();
        if is_there {
            self.went();
        }
        is_there
    }

    /// What the steps are called, the first one first: those that [`Self::done`] counts, then those that were undone.
    pub fn steps(&self) -> impl Iterator<Item = &str> {
        let all = self.undo.iter().chain(self.redo.iter().rev());
        all.map(|step| step.label.as_str())
    }

    /// How many of the steps the text has.
    pub fn done(&self) -> usize {
        self.undo.len()
    }

    /// Undoes steps or does them again until so many are done; false where the text has them already.
    pub fn go_to(&mut self, done: usize) -> bool {
        let before = self.done();
        while self.done() > done && self.step_back() {}
        while self.done() < done && self.step_on() {}
        let is_other = self.done() != before;
        if is_other {
            self.went();
        }
        is_other
    }

    fn step_back(&mut self) -> bool {
        let Some(step) = self.undo.pop() else {
            return false;
        };
        step.patch.revert(&mut self.text);
        self.others.retain(|number| !step.brings.contains(number));
        self.others.extend(&step.leaves_out);
        self.redo.push(step);
        true
    }

    fn step_on(&mut self) -> bool {
        let Some(step) = self.redo.pop() else {
            return false;
        };
        step.patch.apply(&mut self.text);
        self.others
            .retain(|number| !step.leaves_out.contains(number));
        self.others.extend(&step.brings);
        self.undo.push(step);
        true
    }

    /// What [`Self::undo`] would undo.
    pub fn undo_label(&self) -> Option<&str> {
        self.undo.last().map(|step| step.label.as_str())
    }

    /// What [`Self::redo`] would do again.
    pub fn redo_label(&self) -> Option<&str> {
        self.redo.last().map(|step| step.label.as_str())
    }

    /// What has changed since the last call, for [`super::Session::apply`], in order.
    pub fn take_changes(&mut self) -> Vec<Change> {
        self.changes.take()
    }

    fn went(&mut self) {
        self.end_group();
        self.parse_again();
        self.tell(&[]);
    }

    fn remember(&mut self, label: &str, patch: Patch, group: Option<u64>) {
        let goes_on = self.redo.is_empty() && group.is_some();
        self.redo.clear();
        let last = self.undo.last().filter(|_| goes_on);
        if last.is_some_and(|last| last.group == group) {
            let last = self.undo.pop().expect("there is one");
            let mut before = self.text.clone();
            patch.revert(&mut before);
            last.patch.revert(&mut before);
            if let Some(patch) = Patch::between(&before, &self.text) {
                self.undo.push(Step { patch, ..last });
            }
            return;
        }
        self.undo.push(Step {
            label: label.to_owned(),
            patch,
            group,
            brings: Vec::new(),
            leaves_out: Vec::new(),
        });
        self.forget_old_steps();
    }

    /// The last step always can be undone.
    fn forget_old_steps(&mut self) {
        let mut bytes = 0;
        let kept = self.undo.iter().rev().take(MAX_STEPS);
        let kept = kept.take_while(|step| {
            bytes += step.patch.bytes();
            bytes <= MAX_BYTES
        });
        let kept = kept.count().max(1);
        self.undo.drain(..self.undo.len() - kept);
    }

    /// Notes what the session has to know: one edit as such, anything else as the whole text.
    fn tell(&mut self, edits: &[Edit]) {
        self.revision += 1;
        let text = self.text.clone();
        self.changes.push(match edits {
            [edit] => Change::Edit {
                edit: edit.clone(),
                text,
            },
            _ => Change::Text(text),
        });
    }

    /// Makes the text what `document` and `look` say again. It was a look before, so it is one now.
    fn parse_again(&mut self) {
        if let Ok(document) = LookDocument::parse(&self.path, &self.text) {
            self.document = document;
        }
        if let Ok(look) = Look::parse(&self.path, &self.text) {
            self.look = look;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# Rust.\n[node.a] # first\ntexture = 't'\nscale = 4 # patches\n";

    fn document() -> Document {
        Document::new(Path::new("a.look.toml"), TEXT).unwrap_or_else(|e| panic!("{e}"))
    }

    fn scale(x: f32) -> [Edit; 1] {
        [Edit::argument("a", "scale", &texgen::Value::F32(x))]
    }

    #[test]
    fn a_drag_is_one_step() {
        let mut document = document();
        for x in [4.5, 5.0, 5.5] {
            document.apply("scale", &scale(x), Some(7)).expect("fine");
        }
        document.end_group();
        document.apply("scale", &scale(6.0), Some(7)).expect("fine");
        assert!(document.text().contains("scale = 6.0 # patches"));
        assert!(document.undo());
        assert!(document.text().contains("scale = 5.5 # patches"));
        assert!(document.undo());
        assert_eq!(document.text(), TEXT);
        assert!(!document.undo());
        assert!(document.redo() && document.redo() && !document.redo());
        assert!(document.text().contains("scale = 6.0 # patches"));
    }

    #[test]
    fn any_step_can_be_gone_to() {
        let mut document = document();
        for x in [5.0, 6.0, 7.0] {
            let label = format!("to {x}");
            document.apply(&label, &scale(x), None).expect("fine");
        }
        document.take_changes();
        let labels = ["to 5", "to 6", "to 7"];
        assert!(document.go_to(1));
        assert!(document.text().contains("scale = 5.0 # patches"));
        assert!(document.steps().eq(labels), "none is lost");
        assert_eq!(document.done(), 1);
        assert_eq!(
            document.take_changes(),
            [Change::Text(document.text().to_owned())],
            "the session is told of the last one alone"
        );
        assert!(!document.go_to(1));
        assert!(document.go_to(0));
        assert_eq!(document.text(), TEXT);
        assert!(document.go_to(9), "as far as there are any");
        assert!(document.text().contains("scale = 7.0 # patches"));
        document.go_to(2);
        document.apply("to 1", &scale(1.0), None).expect("fine");
        assert!(document.steps().eq(["to 5", "to 6", "to 1"]));
    }

    #[test]
    fn a_drag_back_to_the_start_is_no_step() {
        let mut document = document();
        let back = [Edit::argument("a", "scale", &texgen::Value::I32(4))];
        document.apply("scale", &scale(5.0), Some(1)).expect("fine");
        document.apply("scale", &back, Some(1)).expect("fine");
        assert_eq!(document.undo_label(), None);
    }

    #[test]
    fn what_is_no_look_is_refused() {
        let mut document = document();
        let bad = [
            scale(3.0)[0].clone(),
            Edit::material("M", "roughness", Value::number(7.0)),
        ];
        let message = document.apply("bad", &bad, None).expect_err("no look");
        assert!(message.contains("0 to 1"), "{message}");
        assert_eq!(document.text(), TEXT);
        assert!(document.take_changes().is_empty());
        document.apply("scale", &scale(3.0), None).expect("fine");
        assert!(document.text().contains("scale = 3.0"));
    }

    #[test]
    fn the_session_is_told_what_is_needed() {
        let mut document = document();
        for x in [1.0, 2.0] {
            document.apply("scale", &scale(x), Some(1)).expect("fine");
        }
        let changes = document.take_changes();
        assert!(
            matches!(&changes[..], [Change::Edit { edit, .. }] if *edit == scale(2.0)[0]),
            "{changes:?}"
        );
        document.apply("scale", &scale(3.0), None).expect("fine");
        let two = [Edit::add_node("b", "t"), Edit::add_node("c", "t")];
        document.apply("two", &two, None).expect("fine");
        assert_eq!(
            document.take_changes(),
            [Change::Text(document.text().to_owned())]
        );
        document.undo();
        document.apply("scale", &scale(9.0), None).expect("fine");
        assert_eq!(
            document.take_changes(),
            [Change::Text(document.text().to_owned())]
        );
    }

    #[test]
    fn history_has_a_limit() {
        let mut document = document();
        for i in 0..MAX_STEPS + 10 {
            let comment = format!("# {i}\n{TEXT}");
            document.replace("step", &comment).expect("a look");
        }
        assert_eq!(document.undo.len(), MAX_STEPS);
        let large = |letter: &str| format!("# {}\n", letter.repeat(MAX_BYTES / 5));
        for letter in ["a", "b", "c", "d"] {
            document.replace("step", &large(letter)).expect("a look");
        }
        assert_eq!(document.undo.len(), 2, "each has what goes and what comes");
        assert!(document.undo() && document.undo() && !document.undo());
        assert_eq!(document.text(), large("b"));
    }

    #[test]
    fn what_others_have_written_is_left_out_knowingly() {
        let mut document = document();
        let theirs = format!("# Theirs.\n{TEXT}");
        document.replace_by_others("file", TEXT).expect("a look");
        assert_eq!(document.undo_label(), None);
        document.replace_by_others("file", &theirs).expect("a look");
        document.apply("scale", &scale(9.0), None).expect("fine");
        assert!(document.undo() && !document.leaves_out_others());
        assert!(document.undo() && document.leaves_out_others());
        assert!(document.redo() && !document.leaves_out_others());
        assert!(document.undo());
        // There is nothing to redo any more, but the file still has it.
        document.apply("scale", &scale(8.0), None).expect("fine");
        assert!(document.leaves_out_others());
        document.leave_out_others();
        assert!(!document.leaves_out_others());
        assert!(document.undo() && document.redo());
        assert!(!document.leaves_out_others());
    }

    #[test]
    fn a_text_that_was_kept_leaves_out_what_others_have_written_since() {
        let mut document = document();
        let kept = |document: &Document| (document.text().to_owned(), document.others().clone());
        let theirs = |document: &mut Document, comment: &str| {
            let text = format!("# {comment}.\n{}", document.text());
            document.replace_by_others("file", &text).expect("a look");
        };
        let return_to = |document: &mut Document, (text, others): &(String, BTreeSet<u64>)| {
            document.return_to("kept", text, others).expect("a look");
        };
        let first = kept(&document);
        theirs(&mut document, "Theirs");
        let second = kept(&document);
        return_to(&mut document, &first);
        assert_eq!(document.text(), TEXT);
        assert!(document.leaves_out_others());
        assert!(document.undo() && !document.leaves_out_others());
        assert!(document.redo() && document.leaves_out_others());
        // The other one has it.
        return_to(&mut document, &second);
        assert!(!document.leaves_out_others());
        assert!(document.undo() && document.leaves_out_others());
        assert!(document.redo() && !document.leaves_out_others());
        // As many as the text has now, but another one of them.
        assert!(document.go_to(0) && document.leaves_out_others());
        theirs(&mut document, "Later");
        assert!(document.leaves_out_others(), "the first one is undone");
        document.leave_out_others();
        return_to(&mut document, &second);
        assert!(document.leaves_out_others(), "it lacks the later one");
        assert!(document.undo() && !document.leaves_out_others());
        // Where it is saved as another file there was nothing of them.
        return_to(&mut document, &first);
        document.set_path(Path::new("other.look.toml"));
        assert!(!document.leaves_out_others());
        // What has been decided needs no answer any more.
        return_to(&mut document, &second);
        return_to(&mut document, &first);
        document.leave_out_others();
        assert!(document.undo() && document.redo());
        assert!(!document.leaves_out_others());
    }

    #[test]
    fn a_text_of_another_editor_is_a_step() {
        let mut document = document();
        document.apply("scale", &scale(9.0), None).expect("fine");
        let own = document.text().to_owned();
        assert!(document.replace("another editor", "node = 3").is_err());
        document.replace("another editor", "# new\n").expect("fine");
        assert!(document.undo());
        assert_eq!(document.text(), own);
        let remove = Edit::Remove {
            section: Section::Node("a".into()),
        };
        document.apply("gone", &[remove], None).expect("fine");
        assert!(document.look().nodes.is_empty());
    }
}
