//! Opening what a user names. Every file that is read as an input comes in through here, by [`Files`], which are handed in:
//! a program whose files come over a wire, or lie in its memory, hands in its own.
//!
//! The functions, and [`Disk`], which is made of them, are the operating system's: what they open is a regular file (links are
//! followed), it is no larger than its reader allows, and never more of it is read than was there when it was opened. A named pipe would wait for a writer that never comes, and a device may never end: both are refused before they are opened.

use std::fmt::Debug;
use std::fs::{File, Metadata};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use crate::aside;

/// Files by their paths.
pub trait Files: Debug + Send + Sync {
    /// The first `length` bytes of a file, or all of a shorter one.
    ///
    /// # Errors
    /// It isn't there, or can't be read.
    fn read_start(&self, path: &Path, length: u64) -> io::Result<Vec<u8>>;

    /// A whole file of at most `limit` bytes.
    ///
    /// # Errors
    /// As [`Self::read_start`], and [`io::ErrorKind::FileTooLarge`].
    fn read(&self, path: &Path, limit: u64) -> io::Result<Vec<u8>>;

    /// Whether there is a file at a path.
    fn has(&self, path: &Path) -> bool;

    /// The files of a folder, in any order, without those below it.
    ///
    /// # Errors
    /// There is no such folder, or it can't be listed.
    fn list(&self, folder: &Path) -> io::Result<Vec<PathBuf>>;

    /// Writes a file: all of it, or nothing.
    ///
    /// # Errors
    /// It can't be written; what was there is untouched then.
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()>;

    /// Whether somebody has said that the file at a path is not to be changed. To write may be possible all the same.
    fn is_read_only(&self, _path: &Path) -> bool {
        false
    }

    /// What tells a file from all others: its path, where it has one name only.
    fn id(&self, path: &Path) -> FileId {
        FileId::named(path)
    }
}

/// The operating system's files.
#[derive(Debug, Clone, Copy, Default)]
pub struct Disk;

impl Files for Disk {
    fn read_start(&self, path: &Path, length: u64) -> io::Result<Vec<u8>> {
        read_start(path, length)
    }

    fn read(&self, path: &Path, limit: u64) -> io::Result<Vec<u8>> {
        read(path, limit)
    }

    fn has(&self, path: &Path) -> bool {
        path.is_file()
    }

    fn list(&self, folder: &Path) -> io::Result<Vec<PathBuf>> {
        let entries = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
        let paths: io::Result<Vec<PathBuf>> = entries.collect();
        Ok(paths?.into_iter().filter(|path| path.is_file()).collect())
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        aside::replace(path, |file| file.write_all(bytes))
    }

    fn is_read_only(&self, path: &Path) -> bool {
        std::fs::metadata(path).is_ok_and(|meta| meta.permissions().readonly())
    }

    fn id(&self, path: &Path) -> FileId {
        FileId::of(path)
    }
}

/// What to do where a file can't be read, to stand behind the reason; nothing where that is one of ours and tells it.
pub fn remedy(error: &io::Error) -> &'static str {
    match error.get_ref() {
        Some(_) => "",
        None => "; check the path and the permissions",
    }
}

/// Opens a regular file and tells its length in bytes.
///
/// # Errors
/// It isn't there, may not be read, or is a folder, a pipe, a socket or a device.
pub fn open(path: &Path) -> io::Result<(File, u64)> {
    check_kind(&std::fs::metadata(path)?)?;
    let file = File::open(path)?;
    let meta = file.metadata()?;
    check_kind(&meta)?;
    Ok((file, meta.len()))
}

/// Reads a whole file of at most `limit` bytes.
///
/// # Errors
/// As [`open`], and where the file is larger or memory doesn't suffice.
pub fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let (file, length) = open(path)?;
    if length > limit {
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!(
                "it has {}, and no more than {} are read",
                bytes(length),
                bytes(limit)
            ),
        ));
    }
    read_from(file, length)
}

/// Reads the first `length` bytes of a file, or all of a shorter one.
///
/// # Errors
/// As [`open`], and where memory doesn't suffice.
pub fn read_start(path: &Path, length: u64) -> io::Result<Vec<u8>> {
    let (file, whole) = open(path)?;
    read_from(file, whole.min(length))
}

/// Reads a text of at most `limit` bytes.
///
/// # Errors
/// As [`Files::read`], and where it isn't UTF-8.
pub fn read_text(files: &dyn Files, path: &Path, limit: u64) -> io::Result<String> {
    String::from_utf8(files.read(path, limit)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let problem = format!("it is not UTF-8 text (byte {at} is not); save it as UTF-8");
        io::Error::new(io::ErrorKind::InvalidData, problem)
    })
}

/// What tells a file from all others, whatever it is called: links and other spellings lead to the same one.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct FileId(Id);

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Id {
    #[cfg(unix)]
    Inode(u64, u64),
    Path(PathBuf),
}

impl FileId {
    /// Of a file that has one name only.
    pub fn named(path: &Path) -> Self {
        Self(Id::Path(path.to_owned()))
    }

    /// Of the file that is at `path` now; of the path itself where there is none.
    pub fn of(path: &Path) -> Self {
        #[cfg(unix)]
        if let Ok(meta) = std::fs::metadata(path) {
            use std::os::unix::fs::MetadataExt as _;
            return Self(Id::Inode(meta.dev(), meta.ino()));
        }
        let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        Self(Id::Path(path))
    }
}

fn read_from(file: File, length: u64) -> io::Result<Vec<u8>> {
    let mut read = Vec::new();
    let size = usize::try_from(length).unwrap_or(usize::MAX);
    read.try_reserve_exact(size).map_err(|_| {
        let problem = format!("there is no memory for its {}", bytes(length));
        io::Error::new(io::ErrorKind::OutOfMemory, problem)
    })?;
    file.take(length).read_to_end(&mut read)?;
    Ok(read)
}

fn check_kind(meta: &Metadata) -> io::Result<()> {
    if meta.is_file() {
        return Ok(());
    }
    let problem = format!("it is {}, not a regular file", kind(meta));
    Err(io::Error::new(io::ErrorKind::InvalidInput, problem))
}

fn kind(meta: &Metadata) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        let kind = meta.file_type();
        if kind.is_fifo() {
            return "a named pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
        if kind.is_block_device() || kind.is_char_device() {
            return "a device";
        }
    }
    if meta.is_dir() {
        "a folder"
    } else {
        "something else"
    }
}

/// A number of bytes as people say it.
fn bytes(count: u64) -> String {
    let tenths = |unit: u64| count as f64 / unit as f64;
    match count {
        0x4000_0000.. => format!("{:.1} GiB", tenths(1 << 30)),
        0x10_0000.. => format!("{:.1} MiB", tenths(1 << 20)),
        _ => format!("{count} bytes"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_bound() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a");
        std::fs::write(&path, [7; 100]).expect("written");
        assert_eq!(read(&path, 100).expect("fits"), [7; 100]);
        assert_eq!(read_start(&path, 10).expect("a part"), [7; 10]);
        assert_eq!(read_start(&path, 1000).expect("all of it"), [7; 100]);
        let error = read(&path, 99).expect_err("too large").to_string();
        assert!(
            error.contains("100 bytes") && error.contains("99 bytes"),
            "{error}"
        );
        assert!(read_text(&Disk, &path, 100).is_ok());
        std::fs::write(&path, [b'a', 0xFF]).expect("written");
        let error = read_text(&Disk, &path, 100).expect_err("no text");
        assert!(error.to_string().contains("byte 1"));
        assert_eq!(remedy(&error), "", "the path is right, and may be read");
        let error = read(&folder.path().join("b"), 100).expect_err("not there");
        assert!(remedy(&error).contains("check the path"));
    }

    #[cfg(unix)]
    #[test]
    fn pipes_devices_and_folders_are_refused_at_once_and_links_are_followed() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let made = std::process::Command::new("mkfifo")
            .arg(at("pipe"))
            .status();
        assert!(made.is_ok_and(|status| status.success()));
        std::os::unix::fs::symlink(at("pipe"), at("link")).expect("a link");
        assert_eq!(remedy(&read(folder.path(), 1).expect_err("no file")), "");
        for (path, word) in [
            (at("pipe"), "pipe"),
            (at("link"), "pipe"),
            ("/dev/zero".into(), "device"),
            (folder.path().to_owned(), "folder"),
        ] {
            for result in [
                read(&path, u64::MAX).map(drop),
                read_start(&path, 10).map(drop),
                read_text(&Disk, &path, 10).map(drop),
            ] {
                let error = result.expect_err("no file").to_string();
                assert!(error.contains(word), "{error}");
            }
        }
        std::fs::write(at("file"), "text").expect("written");
        std::os::unix::fs::symlink(at("file"), at("other")).expect("a link");
        std::fs::hard_link(at("file"), at("third")).expect("a link");
        assert_eq!(
            read_text(&Disk, &at("other"), 10).expect("the file"),
            "text"
        );
        for name in ["other", "third"] {
            assert_eq!(FileId::of(&at("file")), FileId::of(&at(name)));
        }
        assert_ne!(FileId::of(&at("file")), FileId::of(&at("missing")));
    }
}
