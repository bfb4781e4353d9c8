//! Windows that ask for a file, and the list of shortcuts.

use std::path::{Path, PathBuf};

use egui::{Id, Key, Modal, Ui, ViewportCommand};

use crate::link::{Command, Files};

use super::{Viewer, name};

/// Whether the window is about to be closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Closing {
    No,
    /// There are edits that would be lost: what is to become of them is asked.
    Asked,
    /// As soon as they have been saved.
    OnceSaved,
    /// Whatever becomes of them.
    Now,
}

/// A file that is asked for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dialog {
    what: What,
    path: String,
    look: String,
    /// It has just been opened: the path gets the keyboard.
    is_new: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum What {
    Look,
    Picture,
    Scene,
}

impl Dialog {
    fn new(what: What, path: &Path, look: Option<&Path>) -> Self {
        let text = |path: &Path| path.display().to_string();
        Self {
            what,
            path: text(path),
            look: look.map(text).unwrap_or_default(),
            is_new: true,
        }
    }

    pub(super) fn save_as(files: &Files) -> Self {
        let beside = files.scene.with_extension("look.toml");
        let path = files.look.as_deref().unwrap_or(&beside);
        Self::new(What::Look, path, None)
    }

    pub(super) fn save_picture(files: &Files) -> Self {
        let named = files.look.as_deref().unwrap_or(&files.scene);
        let stem = name(named);
        let stem = stem.split('.').next().unwrap_or("picture");
        Self::new(What::Picture, Path::new(&format!("{stem}.png")), None)
    }

    pub(super) fn open(files: &Files) -> Self {
        Self::new(What::Scene, &files.scene, files.look.as_deref())
    }

    fn title(&self) -> &'static str {
        match self.what {
            What::Look => "Save the look as",
            What::Picture => "Save the picture: .png or .jpg as shown, .exr as radiance",
            What::Scene => "Open",
        }
    }

    fn button(&self) -> &'static str {
        match self.what {
            What::Scene => "Open",
            _ => "Save",
        }
    }

    fn command(&self) -> Command {
        let path = PathBuf::from(self.path.trim());
        match self.what {
            What::Look => Command::Save(Some(path)),
            What::Picture => Command::SavePicture(path),
            What::Scene => Command::Open(Files {
                scene: path,
                look: Some(PathBuf::from(self.look.trim())).filter(|p| *p != Path::new("")),
                camera: None,
            }),
        }
    }
}

impl Viewer {
    pub(super) fn dialogs(&mut self, ui: &Ui) {
        self.shortcut_list(ui);
        self.closing_dialog(ui);
        let Some(mut dialog) = self.dialog.take() else {
            return;
        };
        let (mut is_done, mut is_cancelled) = (false, false);
        let shown = Modal::new(Id::unique("file dialog")).show(ui.ctx(), |ui| {
            ui.set_width(460.0);
            ui.heading(dialog.title());
            let label = ui.label("File");
            let edit = egui::TextEdit::singleline(&mut dialog.path).desired_width(f32::INFINITY);
            let path = ui.add(edit).labelled_by(label.id);
            if std::mem::take(&mut dialog.is_new) {
                path.request_focus();
            }
            if dialog.what == What::Scene {
                let label = ui.label("Look (may be empty)");
                let edit =
                    egui::TextEdit::singleline(&mut dialog.look).desired_width(f32::INFINITY);
                ui.add(edit).labelled_by(label.id);
            }
            let is_there = Path::new(dialog.path.trim()).exists();
            if dialog.what != What::Scene && is_there {
                ui.label("The file is there, and will be replaced.");
            }
            ui.horizontal(|ui| {
                let is_named = !dialog.path.trim().is_empty();
                let button = egui::Button::new(dialog.button());
                let enter = ui.input(|input| input.key_pressed(Key::Enter));
                is_done = ui.add_enabled(is_named, button).clicked() || is_named && enter;
                is_cancelled = ui.button("Cancel").clicked();
            });
        });
        if is_done {
            self.link.send(dialog.command());
        } else if !is_cancelled && !shown.should_close() {
            self.dialog = Some(dialog);
        }
    }

    /// Closes the window when that has been asked for and nothing would be lost.
    pub(super) fn close(&mut self, ui: &Ui) {
        let is_asked = ui.input(|input| input.viewport().close_requested());
        // After a failure that ended the render they lie beside the look already.
        let is_saved = !self.status.has_unsaved_edits || self.status.fatal.is_some();
        if is_asked && self.closing != Closing::Now && !is_saved {
            ui.ctx().send_viewport_cmd(ViewportCommand::CancelClose);
            self.closing = Closing::Asked;
        }
        if self.closing == Closing::OnceSaved && is_saved {
            self.closing = Closing::Now;
            ui.ctx().send_viewport_cmd(ViewportCommand::Close);
        }
    }

    fn closing_dialog(&mut self, ui: &Ui) {
        if self.closing != Closing::Asked {
            return;
        }
        let shown = Modal::new(Id::unique("closing")).show(ui.ctx(), |ui| {
            ui.heading("The look has edits that are not saved");
            ui.horizontal(|ui| {
                if ui.button("Save and close").clicked() {
                    self.closing = Closing::OnceSaved;
                    self.save();
                }
                if ui.button("Close without saving").clicked() {
                    self.closing = Closing::Now;
                    ui.ctx().send_viewport_cmd(ViewportCommand::Close);
                }
                if ui.button("Stay").clicked() {
                    self.closing = Closing::No;
                }
            });
        });
        if shown.should_close() {
            self.closing = Closing::No;
        }
    }
}
