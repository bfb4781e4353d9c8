//! Files that a dialog of the system is asked for. What opens it is handed in: nothing here knows a window system, and tests play
//! the system.

use std::fmt::Debug;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use egui::{Button, Id, Ui};

use super::name;

/// What becomes of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// It is there, and is read.
    Open,
    /// It is written, whether it is there or not.
    Save,
}

/// What is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileRequest {
    /// Over the dialog.
    pub title: String,
    /// What becomes of the file.
    pub purpose: Purpose,
    /// What people call such files.
    pub kind: &'static str,
    /// How their names end, without the dot, in small letters.
    pub endings: Vec<&'static str>,
    /// What is named so far: its folder is shown first, and to save, its name.
    pub start: PathBuf,
}

/// What became of the question.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Choice {
    /// This file.
    File(PathBuf),
    /// The dialog was closed.
    Nothing,
    /// There was no dialog; the text is for people.
    Unavailable(String),
}

/// Takes the answer, on whatever thread.
pub type Answer = Box<dyn FnOnce(Choice) + Send>;

/// The file dialogs of the system.
pub trait FileDialogs: Debug {
    /// Opens a dialog and returns at once. The answer comes once it is closed; where it is dropped, nothing was chosen.
    fn ask(&self, request: FileRequest, answer: Answer);
}

/// Buttons that ask the system for a file, and the question that is open.
#[derive(Debug, Default)]
pub struct Browser {
    system: Option<Arc<dyn FileDialogs>>,
    /// The button that has asked, and where the answer comes.
    asked: Option<(Id, Receiver<Choice>)>,
    refusal: Option<String>,
}

impl Browser {
    /// Asks that system from now on.
    pub fn set_system(&mut self, system: Arc<dyn FileDialogs>) {
        self.system = Some(system);
    }

    /// Whether buttons are shown at all.
    pub fn has_system(&self) -> bool {
        self.system.is_some()
    }

    /// Why there was no dialog the last time, told once.
    pub fn take_refusal(&mut self) -> Option<String> {
        self.refusal.take()
    }

    /// What is still to be answered isn't wanted any more.
    pub fn forget(&mut self) {
        self.asked = None;
    }

    /// A button; gives the file once it has been chosen. Other buttons have other `what`s: `"the scene"`.
    pub fn button(
        &mut self,
        ui: &mut Ui,
        text: &str,
        what: &str,
        request: impl FnOnce() -> FileRequest,
    ) -> Option<PathBuf> {
        let system = Arc::clone(self.system.as_ref()?);
        let id = Id::unique(("browse", what));
        let is_open = matches!(&self.asked, Some((by, _)) if *by == id);
        let button = ui.add_enabled(!is_open, Button::new(text));
        name(&button, &format!("Browse for {what}"));
        if button.clicked() {
            let (sender, answer) = channel();
            self.asked = Some((id, answer));
            self.refusal = None;
            let ctx = ui.ctx().clone();
            let answer = move |choice| {
                // Who asked may be gone by now.
                let _ = sender.send(choice);
                ctx.request_repaint();
            };
            system.ask(request(), Box::new(answer));
        }
        button.on_disabled_hover_text("the system's dialog is open");
        self.answer_to(id)
    }

    fn answer_to(&mut self, id: Id) -> Option<PathBuf> {
        let (_, answer) = self.asked.as_ref().filter(|(by, _)| *by == id)?;
        let choice = match answer.try_recv() {
            Ok(choice) => choice,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Choice::Nothing,
        };
        self.asked = None;
        match choice {
            Choice::File(path) => return Some(path),
            Choice::Nothing => {}
            Choice::Unavailable(why) => self.refusal = Some(why),
        }
        None
    }
}

/// A file as a look in that folder names it: from there where it lies below, with slashes on every system.
pub fn named_from(folder: &Path, file: &Path) -> String {
    let here = match folder == Path::new("") {
        true => Path::new("."),
        false => folder,
    };
    let is_plain = |path: &&Path| {
        let mut parts = path.components();
        parts.all(|part| matches!(part, Component::Normal(_)))
    };
    let below = file.strip_prefix(folder).ok().filter(is_plain);
    let below = below.map(Path::to_owned).or_else(|| {
        let folder = here.canonicalize().ok()?;
        let file = file.canonicalize().ok()?;
        file.strip_prefix(folder).ok().map(Path::to_owned)
    });
    let Some(below) = below else {
        return file.display().to_string();
    };
    let parts = below.iter().map(|part| part.to_string_lossy());
    parts.collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_below_the_look_are_named_from_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let (own, other) = (folder.path().join("look"), folder.path().join("other"));
        for made in [own.join("maps"), other.clone()] {
            std::fs::create_dir_all(made).expect("a folder");
        }
        for file in [own.join("maps/a.png"), other.join("b.png")] {
            std::fs::write(file, "").expect("a file");
        }
        assert_eq!(named_from(&own, &own.join("maps/a.png")), "maps/a.png");
        let around = own.join("../look/maps/a.png");
        assert_eq!(named_from(&own, &around), "maps/a.png");
        let apart = other.join("b.png");
        assert_eq!(named_from(&own, &apart), apart.display().to_string());
        assert_eq!(named_from(&own, Path::new("/no/such")), "/no/such");
    }

    #[test]
    fn a_look_without_a_folder_lies_in_the_one_of_now() {
        let manifest = Path::new("Cargo.toml").canonicalize().expect("it is there");
        assert_eq!(named_from(Path::new(""), &manifest), "Cargo.toml");
        assert_eq!(
            named_from(Path::new(""), Path::new("maps/a.png")),
            "maps/a.png"
        );
    }
}
