//! Files that are the old one or the new one, never half of either: what is written goes to a temporary file in the same
//! folder, which is renamed when it is complete and on the disk.
//!
//! Which such files there are is known at any time ([`discard_all`]), so that a program that is ended from outside
//! leaves none behind.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use tempfile::NamedTempFile;

/// How the names of temporary files begin, and how many letters and digits follow.
const PREFIX: &str = ".patina-";
const RANDOM: usize = 6;
/// A file that was last written to so long ago is nobody's: writing one takes minutes at most.
const ABANDONED: Duration = Duration::from_hours(24);

/// Links that are followed one after the other: as many as Linux follows.
const MOST_LINKS: u32 = 40;

/// Files to be removed should the program end now.
static LEFTOVERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn leftovers() -> MutexGuard<'static, Vec<PathBuf>> {
    LEFTOVERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file or folder that is to be gone when the program ends, however that comes: [`discard_all`] removes it. Forgotten, not
/// removed, when dropped.
#[derive(Debug)]
pub struct Leftover(PathBuf);

impl Leftover {
    /// From now on the file is one that must not stay.
    pub fn new(path: PathBuf) -> Self {
        leftovers().push(path.clone());
        Self(path)
    }
}

impl Drop for Leftover {
    fn drop(&mut self) {
        let mut all = leftovers();
        if let Some(at) = all.iter().position(|path| *path == self.0) {
            all.swap_remove(at);
        }
    }
}

/// Removes all files that are half done. To be called right before the program ends: nothing can be written aside any
/// more after it.
pub fn discard_all() {
    let mut all = leftovers();
    for path in all.drain(..) {
        let is_folder = fs::symlink_metadata(&path).is_ok_and(|meta| meta.is_dir());
        // It may have been renamed or removed a moment ago.
        let _ = match is_folder {
            true => fs::remove_dir_all(path),
            false => fs::remove_file(path),
        };
    }
    // A thread that wants to begin another file waits for the end.
    std::mem::forget(all);
}

/// A file in the making, gone unless it is finished.
#[derive(Debug)]
pub struct Aside {
    target: PathBuf,
    file: Target,
}

#[derive(Debug)]
enum Target {
    /// Beside the target, to be renamed.
    Renamed(NamedTempFile, Leftover),
    /// A pipe or a device: what is written is gone at once, and nothing can take its place.
    Stream(File),
}

impl Aside {
    /// Begins a file that is to be at `path`. Where that is a link, the file that it points to is meant.
    ///
    /// # Errors
    /// What the system says: the folder isn't there or takes no files, the name is too long; a named pipe, or the standard input.
    pub fn begin(path: &Path) -> io::Result<Self> {
        #[cfg(unix)]
        if let Some(kind) = endless(path) {
            return Err(io::Error::other(format!(
                "it is {kind}; give the name of a file"
            )));
        }
        let is_stream = |meta: fs::Metadata| !meta.is_file() && !meta.is_dir();
        if fs::metadata(path).is_ok_and(is_stream) {
            let file = File::options().write(true).open(path)?;
            return Ok(Self {
                target: path.to_owned(),
                file: Target::Stream(file),
            });
        }
        let target = followed(path)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).rand_bytes(RANDOM);
        #[cfg(unix)]
        {
            // Temporary files are private by default; a result should be as readable as any other new file.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        // Under the lock, so that there is no moment in which the file isn't known.
        let mut all = leftovers();
        let file = builder.tempfile_in(folder_of(&target)).map_err(plain)?;
        all.push(file.path().to_owned());
        drop(all);
        if let Ok(now) = file.as_file().metadata().and_then(|meta| meta.modified()) {
            remove_abandoned(folder_of(&target), now);
        }
        let leftover = Leftover(file.path().to_owned());
        Ok(Self {
            target,
            file: Target::Renamed(file, leftover),
        })
    }

    /// Where it is written to.
    pub fn file(&self) -> &File {
        match &self.file {
            Target::Renamed(file, _) => file.as_file(),
            Target::Stream(file) => file,
        }
    }

    /// Puts it in its place, where it replaces what is there. When this returns, the disk has it.
    ///
    /// # Errors
    /// What the system says; then the old file is as it was.
    pub fn finish(self) -> io::Result<()> {
        self.place(|file, target| file.persist(target).map(drop).map_err(|error| error.error))
    }

    /// As [`Self::finish`], but nothing is replaced.
    ///
    /// # Errors
    /// As [`Self::finish`], and [`io::ErrorKind::AlreadyExists`].
    pub fn finish_new(self) -> io::Result<()> {
        self.place(|file, target| {
            let placed = file.persist_noclobber(target);
            placed.map(drop).map_err(|error| error.error)
        })
    }

    fn place(self, rename: impl FnOnce(NamedTempFile, &Path) -> io::Result<()>) -> io::Result<()> {
        let Target::Renamed(file, _leftover) = self.file else {
            return Ok(());
        };
        if let Ok(old) = fs::metadata(&self.target) {
            file.as_file().set_permissions(old.permissions())?;
        }
        file.as_file().sync_all()?;
        rename(file, &self.target)?;
        sync_folder(folder_of(&self.target))
    }
}

/// Creates or replaces the file at `path` with what `fill` writes, all of it or nothing.
///
/// # Errors
/// The system refuses, or `fill` fails.
pub fn replace(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> io::Result<()> {
    let aside = Aside::begin(path)?;
    write(&aside, fill)?;
    aside.finish()
}

/// As [`replace`], but a file that is there already is an error.
///
/// # Errors
/// As [`replace`], and [`io::ErrorKind::AlreadyExists`].
pub fn create(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> io::Result<()> {
    let aside = Aside::begin(path)?;
    write(&aside, fill)?;
    aside.finish_new()
}

fn write(
    aside: &Aside,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> io::Result<()> {
    let mut writer = BufWriter::new(aside.file());
    fill(&mut writer)?;
    writer.flush()
}

/// Removes temporary files of runs that were killed or lost their power: once for each folder that is written to. What can't be
/// removed stays. `now` is the time that the folder's file system has.
fn remove_abandoned(folder: &Path, now: SystemTime) {
    static SEEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    if !seen.insert(folder.to_owned()) {
        return;
    }
    drop(seen);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let random = name.to_str().and_then(|name| name.strip_prefix(PREFIX));
        let is_random = |r: &str| r.len() == RANDOM && r.bytes().all(|b| b.is_ascii_alphanumeric());
        if !random.is_some_and(is_random) {
            continue;
        }
        // Of the entry itself: a link is none of ours.
        let written = entry.metadata().ok().filter(fs::Metadata::is_file);
        let written = written.and_then(|meta| meta.modified().ok());
        let age = written.and_then(|written| now.duration_since(written).ok());
        if age.is_some_and(|age| age > ABANDONED) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Where a path leads: links are followed, also to what isn't there yet.
///
/// # Errors
/// A circle of links, a name that is too long.
pub fn followed(path: &Path) -> io::Result<PathBuf> {
    followed_past(path, |_| ())
}

/// As [`followed`]; `pass` sees each place on the way.
fn followed_past(path: &Path, mut pass: impl FnMut(&Path)) -> io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..MOST_LINKS {
        pass(&target);
        match fs::symlink_metadata(&target) {
            Ok(meta) if meta.file_type().is_symlink() => {
                let link = fs::read_link(&target)?;
                target = target.parent().unwrap_or(Path::new("")).join(link);
            }
            Ok(_) => return Ok(target),
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(target),
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::other("it is a link that leads to itself"))
}

/// What a path leads to where writing to it may wait for ever.
#[cfg(unix)]
fn endless(path: &Path) -> Option<&'static str> {
    use std::os::unix::fs::FileTypeExt as _;

    let (mut is_input, mut is_open) = (false, false);
    let end = followed_past(path, |place| {
        let folder = folder_of(place).canonicalize().unwrap_or_default();
        let is_system = ["/proc", "/dev"]
            .iter()
            .any(|root| folder.starts_with(root));
        let is_numbered = is_system && folder.ends_with("fd");
        is_open |= is_numbered;
        is_input |= place == Path::new("/dev/stdin") || is_numbered && place.ends_with("0");
    });
    if is_input {
        // Nobody reads what is written to a pipe's end that is read from.
        return Some("the standard input");
    }
    // To open a pipe waits until somebody reads it, and who did so before goes when it is closed once. One that the program was given
    // open, as `/dev/stdout` may be, has its reader.
    let is_pipe = |path: PathBuf| fs::symlink_metadata(path).map(|m| m.file_type().is_fifo());
    (!is_open && end.and_then(is_pipe).unwrap_or(false)).then_some("a named pipe")
}

/// The folder that a file lies in.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// The new name is on the disk as well.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if !cfg!(unix) {
        return Ok(());
    }
    let synced = File::open(folder).and_then(|folder| folder.sync_all());
    match synced {
        // Some file systems have nothing to sync there; some folders may be written but not read.
        Err(error)
            if matches!(
                error.kind(),
                io::ErrorKind::InvalidInput
                    | io::ErrorKind::Unsupported
                    | io::ErrorKind::PermissionDenied
            ) =>
        {
            Ok(())
        }
        other => other,
    }
}

/// What the system said, without the name of a temporary file that nobody has asked for.
fn plain(error: io::Error) -> io::Error {
    // `tempfile` wraps the system's error with the path, and gives out no more of it than its kind and its text.
    if error.get_ref().is_none() {
        return error;
    }
    let text = error.to_string();
    // The kind that has no name, such as that of too many open files.
    match text.split_once(" at path ") {
        Some((said, _)) if format!("{:?}", error.kind()) == "Uncategorized" => {
            io::Error::other(said.to_owned())
        }
        _ => error.kind().into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_named_pipe_is_refused() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = dir.path().join("pipe.png");
        let link = dir.path().join("link.png");
        std::os::unix::fs::symlink("pipe.png", &link).expect("a link");
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        if !made.is_ok_and(|status| status.success()) {
            eprintln!("skipped: there is no mkfifo");
            return;
        }
        let begun = |path: &Path| Aside::begin(path).map(drop);
        for path in [&path, &link] {
            let refused = begun(path).expect_err("a pipe").to_string();
            assert!(refused.contains("named pipe"), "{refused}");
        }
        let input = dir.path().join("input.png");
        std::os::unix::fs::symlink("/dev/stdin", &input).expect("a link");
        let refused = begun(&input).expect_err("the input").to_string();
        assert!(refused.contains("standard input"), "{refused}");
    }

    #[test]
    fn what_the_system_said_is_told_without_the_name() {
        let wrapped = |code: i32| {
            let inner = io::Error::from_raw_os_error(code);
            io::Error::new(inner.kind(), format!("{inner} at path \"/x/.patina\""))
        };
        assert_eq!(plain(wrapped(2)).kind(), io::ErrorKind::NotFound);
        // Too many open files, on Linux.
        let text = plain(wrapped(24)).to_string();
        assert!(
            !text.contains("path") && !text.contains("uncategorized"),
            "{text}"
        );
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = dir.path().join("x.png");
        fs::write(&path, "old").expect("written");
        let failed = replace(&path, |file| {
            file.write_all(b"half of it")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.expect_err("it failed").to_string().contains("full"));
        assert_eq!(fs::read_to_string(&path).expect("there"), "old");
        let exists = create(&path, |_| Ok(())).expect_err("there is one");
        assert_eq!(exists.kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read_dir(dir.path()).expect("a folder").count(), 1);
        let known = |name: &PathBuf| name.starts_with(dir.path());
        assert!(!leftovers().iter().any(known), "all are forgotten");
    }

    #[test]
    fn what_a_killed_run_has_left_is_removed_by_a_later_one() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let day = Duration::from_hours(24);
        let now = SystemTime::now();
        let file = |name: &str, age: Duration| {
            let file = File::create(dir.path().join(name)).expect("created");
            file.set_modified(now - age).expect("the time is set");
        };
        file(".patina-a1B2c3", day + Duration::from_secs(60));
        file(".patina-d4E5f6", day - Duration::from_secs(600));
        // Others' files, however old.
        for name in [
            ".patina-a1B2c",
            ".patina-notes1.txt",
            "patina-a1B2c3",
            "x.png",
        ] {
            file(name, 9 * day);
        }
        replace(&dir.path().join("y.png"), |_| Ok(())).expect("written");
        let is_there = |name: &str| dir.path().join(name).exists();
        assert!(!is_there(".patina-a1B2c3") && is_there(".patina-d4E5f6"));
        assert_eq!(fs::read_dir(dir.path()).expect("a folder").count(), 6);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_what_it_points_to_is_replaced() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| dir.path().join(name);
        fs::create_dir(path("below")).expect("a folder");
        fs::write(path("below/real"), "old").expect("written");
        symlink("below/real", path("link")).expect("a link");
        symlink("below/not-yet", path("early")).expect("a link");
        symlink("circle", path("circle")).expect("a link");
        for (link, real) in [("link", "below/real"), ("early", "below/not-yet")] {
            replace(&path(link), |file| file.write_all(b"new")).expect("written");
            let meta = fs::symlink_metadata(path(link)).expect("there");
            assert!(meta.file_type().is_symlink(), "{link}");
            assert_eq!(fs::read_to_string(path(real)).expect("there"), "new");
        }
        assert!(replace(&path("circle"), |_| Ok(())).is_err());
        let long = "x".repeat(300);
        assert!(
            Aside::begin(&path(&long)).is_err(),
            "found before it is written"
        );
    }

    #[cfg(unix)]
    #[test]
    fn results_are_as_readable_as_other_new_files() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().expect("a temporary folder");
        let (ours, plain) = (dir.path().join("ours"), dir.path().join("plain"));
        replace(&ours, |_| Ok(())).expect("written");
        fs::write(&plain, "").expect("written");
        let mode = |path| fs::metadata(path).expect("there").permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_device_is_written_to_and_stays_one() {
        let full = replace(Path::new("/dev/full"), |file| file.write_all(b"x"));
        assert!(full.is_err());
        replace(Path::new("/dev/null"), |file| file.write_all(b"x")).expect("it takes all");
        let meta = fs::metadata("/dev/null").expect("there");
        assert!(!meta.is_file());
    }

    #[test]
    fn errors_do_not_name_temporary_files() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let gone = dir.path().join("no/such/folder");
        let wrapped = tempfile::Builder::new().prefix(PREFIX).tempfile_in(gone);
        let wrapped = wrapped.expect_err("there is no such folder");
        assert!(wrapped.to_string().contains(".patina-"), "{wrapped}");
        let said = plain(wrapped);
        assert_eq!(said.kind(), io::ErrorKind::NotFound);
        assert!(!said.to_string().contains(".patina-"), "{said}");
    }
}
