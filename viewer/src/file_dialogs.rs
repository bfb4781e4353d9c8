//! The file dialogs of the system, each on a thread of its own: neither the window nor the render waits for them.

use std::cell::Cell;
use std::path::{Path, PathBuf};

use patina_panels::{Answer, Choice, FileDialogs, FileRequest, Purpose};

/// What to do where there is none.
const UNAVAILABLE: &str = if cfg!(target_os = "linux") {
    "The system offers no file dialog here (xdg-desktop-portal or zenity would): type the path."
} else {
    "The system offers no file dialog here: type the path."
};

/// Dialogs over a window.
#[derive(Debug)]
pub(crate) struct SystemDialogs {
    /// A dialog in which all is as usual, but that it belongs to the window.
    plain: rfd::FileDialog,
}

impl SystemDialogs {
    /// Over the window that is being opened.
    pub(crate) fn over(window: &eframe::CreationContext<'_>) -> Self {
        // Where another library hears what is logged, it isn't known why nothing was chosen.
        if log::set_logger(&HEARD).is_ok() {
            log::set_max_level(log::LevelFilter::Error);
        }
        Self {
            plain: rfd::FileDialog::new().set_parent(window),
        }
    }
}

impl FileDialogs for SystemDialogs {
    fn ask(&self, request: FileRequest, answer: Answer) {
        let (folder, name) = start(&request);
        let mut dialog = self.plain.clone().set_title(request.title);
        dialog = dialog.add_filter(request.kind, &filter(&request.endings));
        if let Some(folder) = folder {
            dialog = dialog.set_directory(folder);
        }
        if let Some(name) = name {
            dialog = dialog.set_file_name(name);
        }
        let ask = move || {
            HAS_FAILED.set(false);
            let chosen = match request.purpose {
                Purpose::Open => dialog.pick_file(),
                Purpose::Save => dialog.save_file(),
            };
            answer(match chosen {
                Some(path) => Choice::File(path),
                None if HAS_FAILED.get() => Choice::Unavailable(UNAVAILABLE.to_owned()),
                None => Choice::Nothing,
            });
        };
        // Where the system starts no more threads the answer is dropped: nothing was chosen.
        let _ = std::thread::Builder::new()
            .name("file dialog".to_owned())
            .spawn(ask);
    }
}

/// How names may end: dialogs of Linux take capitals for other letters, and cameras write them.
fn filter(endings: &[&str]) -> Vec<String> {
    let mut all: Vec<_> = endings.iter().map(|ending| (*ending).to_owned()).collect();
    if cfg!(target_os = "linux") {
        all.extend(endings.iter().map(|ending| ending.to_uppercase()));
    }
    all
}

/// The folder that is shown first, the nearest one that is there; and the name that is proposed for a file to be written.
fn start(request: &FileRequest) -> (Option<PathBuf>, Option<String>) {
    let whole = std::path::absolute(&request.start).ok();
    let folder = whole.as_deref().and_then(|path| {
        let mut around = path.ancestors();
        around.find(|folder| folder.is_dir()).map(Path::to_owned)
    });
    let name = request.start.file_name();
    let name = name.filter(|_| request.purpose == Purpose::Save);
    (folder, name.map(|name| name.to_string_lossy().into_owned()))
}

thread_local! {
    /// On the thread of a dialog: it could not be opened.
    static HAS_FAILED: Cell<bool> = const { Cell::new(false) };
}

/// Hears the log: that there was no dialog to be closed is told there alone.
struct Heard;

static HEARD: Heard = Heard;

impl log::Log for Heard {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.target().starts_with("rfd")
    }

    fn log(&self, record: &log::Record<'_>) {
        // The portal is tried first; zenity is the last that is.
        let is_last = !cfg!(target_os = "linux") || record.args().to_string().contains("zenity");
        if self.enabled(record.metadata()) && record.level() == log::Level::Error && is_last {
            HAS_FAILED.set(true);
        }
    }

    fn flush(&self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(purpose: Purpose, start: &Path) -> FileRequest {
        FileRequest {
            title: String::new(),
            purpose,
            kind: "Looks",
            endings: vec!["toml"],
            start: start.to_owned(),
        }
    }

    #[test]
    fn a_dialog_begins_in_the_nearest_folder_that_is_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let here = Some(folder.path().to_owned());
        let beside = folder.path().join("a.look.toml");
        let name = Some("a.look.toml".to_owned());
        assert_eq!(
            start(&request(Purpose::Save, &beside)),
            (here.clone(), name)
        );
        let gone = folder.path().join("no/such/a.look.toml");
        assert_eq!(start(&request(Purpose::Open, &gone)), (here, None));
        let now = std::env::current_dir().expect("there is one");
        let (begins, _) = start(&request(Purpose::Save, Path::new("a.png")));
        assert_eq!(begins, Some(now));
    }
}
