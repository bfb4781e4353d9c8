//! What is asked before edits would be lost: by closing the window, by opening something else, by saving over what another program
//! has written, and where both have changed the same.

use std::path::PathBuf;

use egui::{Id, Modal, ScrollArea, Ui, ViewportCommand};
use engine::session::Merged;

use crate::link::{Command, Files};

use super::Viewer;
use super::dialogs::Dialog;

/// What is waiting for an answer.
#[derive(Debug, Default)]
pub(super) struct Questions {
    /// The look is about to be left.
    leaving: Option<(Leaving, Stage)>,
    /// A save would take away what another program has written.
    overwrites: bool,
    /// Both sides have changed the same.
    conflict: Option<Merged>,
}

impl Questions {
    /// Whether an answer is waited for, so that keys are not for what lies below.
    pub(super) fn is_asking(&self) -> bool {
        self.leaving.is_some() || self.overwrites || self.conflict.is_some()
    }
}

/// Why the look is left.
#[derive(Debug, Clone, PartialEq)]
enum Leaving {
    Close,
    Open(Files),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// There are edits that would be lost: what is to become of them is asked.
    Asked,
    /// As soon as they have been saved.
    OnceSaved,
    /// A picture is being finished that would be lost: it is asked whether it may.
    PictureAsked,
    /// As soon as that is written.
    OnceFinished,
    /// Whatever becomes of all that.
    Now,
}

impl Viewer {
    /// Whether there are edits that only this window has.
    pub(super) fn has_unsaved_edits(&self) -> bool {
        // After a failure that ended the render they lie beside the look already.
        let is_kept = self.status.fatal.is_some();
        !is_kept && (self.editor.has_unsaved_edits() || self.status.has_unsaved_edits)
    }

    /// Opens files; asks what is to become of edits that would be lost.
    pub(super) fn open(&mut self, files: Files) {
        match self.has_unsaved_edits() {
            true => self.questions.leaving = Some((Leaving::Open(files), Stage::Asked)),
            false => self.link.send(Command::Open(files)),
        }
    }

    /// What would leave the look doesn't.
    pub(super) fn stay(&mut self) {
        self.questions.leaving = None;
    }

    /// A look that could not be saved isn't left, nor a picture that could not be written.
    pub(super) fn stay_if_unsaved(&mut self) {
        let waits = [Stage::OnceSaved, Stage::OnceFinished];
        if (self.questions.leaving.as_ref()).is_some_and(|(_, stage)| waits.contains(stage)) {
            self.stay();
        }
    }

    /// Saves the look; asks for a file where it has none, and whether to save over what others have written there.
    pub(super) fn save(&mut self) {
        let leaves_out = (self.document_mut()).is_some_and(|document| document.leaves_out_others());
        match &self.scene.files.look {
            Some(_) if leaves_out => self.questions.overwrites = true,
            Some(_) => self.save_to(None),
            None => self.dialog = Some(Dialog::save_as(&self.scene.files)),
        }
    }

    /// Saves the look to its file, or to another one. What is edited from then on is another step, also in the midst of a drag.
    pub(super) fn save_to(&mut self, path: Option<PathBuf>) {
        if let Some(document) = self.document_mut() {
            document.end_group();
        }
        let outside = self.editor.outside();
        self.link.send(Command::Save(path, outside));
    }

    /// Both sides have changed the same: that is asked about.
    pub(super) fn ask_about(&mut self, conflict: Option<Merged>) {
        self.questions.conflict = conflict;
    }

    /// Closes the window when that has been asked for and nothing would be lost.
    pub(super) fn close(&mut self, ui: &Ui) {
        let is_asked = ui.input(|input| input.viewport().close_requested());
        let is_unsaved = self.has_unsaved_edits();
        let is_closing_now = self.questions.leaving == Some((Leaving::Close, Stage::Now));
        if is_asked && !is_closing_now && (is_unsaved || self.is_finishing()) {
            ui.ctx().send_viewport_cmd(ViewportCommand::CancelClose);
            let stage = match is_unsaved {
                true => Stage::Asked,
                false => Stage::PictureAsked,
            };
            self.questions.leaving = Some((Leaving::Close, stage));
        }
        match self.questions.leaving.take() {
            Some((leaving, Stage::OnceSaved)) if !is_unsaved => self.leave(ui, leaving),
            Some((_, Stage::OnceFinished)) if !self.is_finishing() => self.close_now(ui),
            waiting => self.questions.leaving = waiting,
        }
    }

    fn leave(&mut self, ui: &Ui, leaving: Leaving) {
        match leaving {
            Leaving::Close if self.is_finishing() => {
                self.questions.leaving = Some((leaving, Stage::PictureAsked));
            }
            Leaving::Close => self.close_now(ui),
            Leaving::Open(files) => self.link.send(Command::Open(files)),
        }
    }

    fn close_now(&mut self, ui: &Ui) {
        self.questions.leaving = Some((Leaving::Close, Stage::Now));
        ui.ctx().send_viewport_cmd(ViewportCommand::Close);
    }

    /// Whether a picture is being finished that closing the window would lose.
    fn is_finishing(&self) -> bool {
        self.status.saving.is_some() && self.status.fatal.is_none()
    }

    pub(super) fn questions(&mut self, ui: &Ui) {
        if self.questions.conflict.is_some() {
            self.conflict_question(ui);
        } else if self.questions.overwrites {
            self.overwrite_question(ui);
        } else if let Some((_, Stage::PictureAsked)) = self.questions.leaving {
            self.finishing_question(ui);
        } else {
            self.leaving_question(ui);
        }
    }

    fn finishing_question(&mut self, ui: &Ui) {
        let shown = Modal::new(Id::unique("leaving a picture")).show(ui.ctx(), |ui| {
            ui.heading("A picture is being finished");
            ui.horizontal(|ui| {
                if ui.button("Close once it is written").clicked() {
                    self.questions.leaving = Some((Leaving::Close, Stage::OnceFinished));
                }
                if ui.button("Close without it").clicked() {
                    self.close_now(ui);
                }
                if ui.button("Stay").clicked() {
                    self.stay();
                }
            });
        });
        if shown.should_close() {
            self.stay();
        }
    }

    fn leaving_question(&mut self, ui: &Ui) {
        let Some((leaving, Stage::Asked)) = self.questions.leaving.clone() else {
            return;
        };
        let [save, discard] = match leaving {
            Leaving::Close => ["Save and close", "Close without saving"],
            Leaving::Open(_) => ["Save and open", "Open without saving"],
        };
        let shown = Modal::new(Id::unique("leaving")).show(ui.ctx(), |ui| {
            ui.heading("The look has edits that are not saved");
            ui.horizontal(|ui| {
                if ui.button(save).clicked() {
                    self.questions.leaving = Some((leaving.clone(), Stage::OnceSaved));
                    self.save();
                }
                if ui.button(discard).clicked() {
                    self.stay();
                    self.leave(ui, leaving.clone());
                }
                if ui.button("Stay").clicked() {
                    self.stay();
                }
            });
        });
        if shown.should_close() {
            self.stay();
        }
    }

    fn overwrite_question(&mut self, ui: &Ui) {
        let mut is_answered = false;
        let shown = Modal::new(Id::unique("overwrite")).show(ui.ctx(), |ui| {
            ui.heading("What another program has saved is missing here");
            ui.label("To save the look takes it away from the file, too. The history has it.");
            ui.horizontal(|ui| {
                if ui.button("Save over it").clicked() {
                    is_answered = true;
                    if let Some(document) = self.document_mut() {
                        document.leave_out_others();
                    }
                    self.save_to(None);
                }
                if ui.button("Save as ...").clicked() {
                    is_answered = true;
                    self.dialog = Some(Dialog::save_as(&self.scene.files));
                }
                if ui.button("Don't save").clicked() {
                    is_answered = true;
                    self.stay();
                }
            });
        });
        if shown.should_close() {
            self.stay();
        }
        self.questions.overwrites = !is_answered && !shown.should_close();
    }

    /// There is no way around it: until it is answered the file and the edits are two different things.
    fn conflict_question(&mut self, ui: &Ui) {
        let Some(conflict) = self.questions.conflict.take() else {
            return;
        };
        let mut chosen = None;
        Modal::new(Id::unique("conflict")).show(ui.ctx(), |ui| {
            ui.heading("The look was changed here and by another program");
            ui.label("All that only one side has changed is kept. Both have changed:");
            ScrollArea::vertical().max_height(200.0).show(ui, |ui| {
                for what in &conflict.conflicts {
                    ui.monospace(what);
                }
            });
            ui.label("Undo goes back to the look before this.");
            ui.horizontal(|ui| {
                if ui.button("Keep mine there").clicked() {
                    chosen = Some(&conflict.text);
                }
                if ui.button("Take the file's there").clicked() {
                    chosen = Some(&conflict.theirs_first);
                }
            });
        });
        let Some(text) = chosen else {
            self.questions.conflict = Some(conflict);
            return;
        };
        let look = self.link.board().look.clone();
        let taken = look.map_or(Ok(()), |look| self.editor.take_outside(&look, text));
        if let Err(why) = taken {
            // The other choice is left.
            self.questions.conflict = Some(conflict);
            self.tell(why, true, ui.input(|input| input.time));
        }
    }
}
