//! The disk's files, but that folders with textures may be missing which come later: then there is nothing in them.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use engine::input::FileId;
use engine::system::{Assets, Disk, Files};

/// Files of a render that is followed.
#[derive(Debug)]
pub(super) struct Folders {
    awaited: Vec<PathBuf>,
}

impl Folders {
    /// Of these folders those that aren't there may come. One that goes is missed all the same.
    pub(super) fn new(textures: &[PathBuf]) -> Self {
        let awaited = textures.iter().filter(|folder| !folder.is_dir());
        Self {
            awaited: awaited.cloned().collect(),
        }
    }
}

impl Files for Folders {
    fn read_start(&self, path: &Path, length: u64) -> io::Result<Vec<u8>> {
        Disk.read_start(path, length)
    }

    fn read(&self, path: &Path, limit: u64) -> io::Result<Vec<u8>> {
        Disk.read(path, limit)
    }

    fn has(&self, path: &Path) -> bool {
        Disk.has(path)
    }

    fn list(&self, folder: &Path) -> io::Result<Vec<PathBuf>> {
        let is_awaited = || self.awaited.iter().any(|awaited| awaited == folder);
        match Disk.list(folder) {
            Err(error) if error.kind() == ErrorKind::NotFound && is_awaited() => Ok(Vec::new()),
            listed => listed,
        }
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        Disk.write(path, bytes)
    }

    fn id(&self, path: &Path) -> FileId {
        Disk.id(path)
    }
}

impl Assets for Folders {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_come_is_empty_until_then() {
        let root = tempfile::tempdir().expect("a temporary folder");
        let [late, there] = ["late", "there"].map(|name| root.path().join(name));
        std::fs::create_dir(&there).expect("a folder");
        let files = Folders::new(&[late.clone(), there.clone()]);
        assert!(files.list(&late).expect("it may come").is_empty());
        std::fs::remove_dir(&there).expect("removed");
        assert!(files.list(&there).is_err());
        std::fs::create_dir(&late).expect("a folder");
        std::fs::write(late.join("t.wgsl"), "").expect("written");
        assert_eq!(files.list(&late).expect("there"), [late.join("t.wgsl")]);
    }
}
