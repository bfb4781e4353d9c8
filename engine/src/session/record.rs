//! What was read, by its contents: a file that is saved as it was, or mended to that, is no reason to begin anew.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::film::Hash;
use crate::input::{FileId, Files};
use crate::scene::import::{ImportError, Imported, Importer};
use crate::system::Assets;

/// Something that was asked of files.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Request {
    Has(PathBuf),
    /// The first bytes.
    Start(PathBuf, u64),
    /// All of at most so many.
    Whole(PathBuf, u64),
}

/// What files answered, each request once; contents as hashes.
#[derive(Debug, Clone, Default)]
pub(super) struct Record {
    answers: BTreeMap<Request, Option<u64>>,
    /// A scene has come from elsewhere.
    is_unknown: bool,
}

impl Record {
    /// Whether the same requests would have the same answers now.
    pub(super) fn is_of(&self, files: &dyn Assets) -> bool {
        let answer = |request: &Request| match request {
            Request::Has(path) => files.has(path).then_some(0),
            Request::Start(path, length) => hashed(&files.read_start(path, *length)),
            Request::Whole(path, limit) => hashed(&files.read(path, *limit)),
        };
        !self.is_unknown
            && (self.answers.iter()).all(|(request, former)| answer(request) == *former)
    }

    fn has_read(&self, wanted: &Path) -> bool {
        self.answers.keys().any(|request| match request {
            Request::Has(_) => false,
            Request::Start(path, _) | Request::Whole(path, _) => path == wanted,
        })
    }
}

fn hashed(bytes: &io::Result<Vec<u8>>) -> Option<u64> {
    let bytes = bytes.as_ref().ok()?;
    let mut hash = Hash::new();
    hash.bytes(bytes);
    Some(hash.value())
}

/// Files that remember what they were asked for. What textures in WGSL say is left out, as they are followed one by one, but not that they
/// are there.
#[derive(Debug)]
pub(super) struct Recorder {
    files: Arc<dyn Assets>,
    record: Mutex<Record>,
}

impl Recorder {
    pub(super) fn new(files: &Arc<dyn Assets>) -> Arc<Self> {
        Arc::new(Self {
            files: Arc::clone(files),
            record: Mutex::default(),
        })
    }

    /// What has been asked so far.
    pub(super) fn record(&self) -> Record {
        self.locked().clone()
    }

    fn locked(&self) -> std::sync::MutexGuard<'_, Record> {
        self.record.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn note_texture(&self, path: &Path, is_there: bool) {
        self.note(Request::Has(path.to_owned()), is_there.then_some(0));
    }

    fn note(&self, request: Request, answer: Option<u64>) {
        self.locked().answers.insert(request, answer);
    }
}

fn is_texture(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "wgsl")
}

impl Files for Recorder {
    fn read_start(&self, path: &Path, length: u64) -> io::Result<Vec<u8>> {
        let bytes = self.files.read_start(path, length);
        match is_texture(path) {
            true => self.note_texture(path, bytes.is_ok()),
            false => self.note(Request::Start(path.to_owned(), length), hashed(&bytes)),
        }
        bytes
    }

    fn read(&self, path: &Path, limit: u64) -> io::Result<Vec<u8>> {
        let bytes = self.files.read(path, limit);
        match is_texture(path) {
            true => self.note_texture(path, bytes.is_ok()),
            false => self.note(Request::Whole(path.to_owned(), limit), hashed(&bytes)),
        }
        bytes
    }

    fn has(&self, path: &Path) -> bool {
        let is_there = self.files.has(path);
        self.note(Request::Has(path.to_owned()), is_there.then_some(0));
        is_there
    }

    fn list(&self, folder: &Path) -> io::Result<Vec<PathBuf>> {
        self.files.list(folder)
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        self.files.write(path, bytes)
    }

    fn is_read_only(&self, path: &Path) -> bool {
        self.files.is_read_only(path)
    }

    fn id(&self, path: &Path) -> FileId {
        self.files.id(path)
    }
}

impl Assets for Recorder {
    fn scene(&self, importer: &mut Importer, path: &Path) -> Result<Imported, ImportError> {
        let scene = self.files.scene(importer, path);
        let mut record = self.locked();
        record.is_unknown |= !record.has_read(path);
        scene
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Disk;

    #[test]
    fn what_is_saved_as_it_was_is_known() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("a.bin"), "abc").expect("written");
        std::fs::write(path("t.wgsl"), "one").expect("written");
        let disk: Arc<dyn Assets> = Arc::new(Disk);
        let files = Recorder::new(&disk);
        files.read(&path("a.bin"), 100).expect("read");
        files.read(&path("t.wgsl"), 100).expect("read");
        assert!(!files.has(&path("b.bin")));
        let record = files.record();
        assert!(record.is_of(&Disk));
        for text in ["abd", "ab", "abcd"] {
            std::fs::write(path("a.bin"), text).expect("written");
            assert!(!record.is_of(&Disk), "{text}");
        }
        std::fs::remove_file(path("a.bin")).expect("removed");
        assert!(!record.is_of(&Disk));
        std::fs::write(path("a.bin"), "abc").expect("written");
        std::fs::write(path("t.wgsl"), "two").expect("written");
        assert!(record.is_of(&Disk));
        std::fs::write(path("b.bin"), "").expect("written");
        assert!(!record.is_of(&Disk), "a file that has come");
        std::fs::remove_file(path("b.bin")).expect("removed");
        assert!(record.is_of(&Disk));
        std::fs::remove_file(path("t.wgsl")).expect("removed");
        assert!(!record.is_of(&Disk), "a texture that has gone");
    }
}
