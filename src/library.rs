//! Where textures are looked for: the folders named on the command line, then the usual ones. Behind them all are the
//! standard textures, which are part of the program (`TextureSources::search`).

use std::env;
use std::path::{Path, PathBuf};

use engine::aside;
use engine::procedural::LIBRARIES;

use crate::failure::Failure;

const FOLDER: &str = "user_textures";

/// Folders with user textures in the order they are searched, all existing, none twice: those in `given`, then
/// `user_textures` beside the look, in the current directory, and where this program is.
///
/// # Errors
/// A folder in `given` that isn't one.
pub(crate) fn texture_dirs(
    given: &[PathBuf],
    look: Option<&Path>,
) -> Result<Vec<PathBuf>, Failure> {
    let mut dirs = texture_dirs_to_come(given, look)?;
    dirs.retain(|dir| dir.is_dir());
    Ok(dirs)
}

/// The same with the usual folders that aren't there yet, for whoever follows what is saved.
///
/// # Errors
/// As [`texture_dirs`].
pub(crate) fn texture_dirs_to_come(
    given: &[PathBuf],
    look: Option<&Path>,
) -> Result<Vec<PathBuf>, Failure> {
    if let Some(missing) = given.iter().find(|dir| !dir.is_dir()) {
        return Err(Failure::Failed(format!(
            "--textures {}: there is no such folder",
            missing.display()
        )));
    }
    let standard = [
        look.map(|look| look.parent().unwrap_or(Path::new("")).join(FOLDER)),
        Some(PathBuf::from(FOLDER)),
        shipped(),
    ];
    let candidates = given.iter().cloned().chain(standard.into_iter().flatten());
    let mut dirs: Vec<PathBuf> = Vec::new();
    let mut seen: Vec<PathBuf> = Vec::new();
    for dir in candidates.filter(|dir| dir.is_dir() || !dir.exists()) {
        let place = place(&dir);
        if !seen.contains(&place) {
            seen.push(place);
            dirs.push(dir);
        }
    }
    Ok(dirs)
}

/// Where a folder is, or will be.
fn place(dir: &Path) -> PathBuf {
    let to_come = || {
        let folder = aside::folder_of(dir).canonicalize().ok()?;
        Some(folder.join(dir.file_name()?))
    };
    let there = dir.canonicalize().ok();
    there.or_else(to_come).unwrap_or_else(|| dir.to_owned())
}

/// All textures in these folders, and what they share: no result takes the place of one.
pub(crate) fn files(dirs: &[PathBuf]) -> Vec<PathBuf> {
    let folders = dirs
        .iter()
        .flat_map(|dir| [dir.clone(), dir.join(LIBRARIES)]);
    let entries = folders.flat_map(std::fs::read_dir).flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    paths
        .filter(|path| path.extension().is_some_and(|ending| ending == "wgsl"))
        .collect()
}

/// The folder beside the executable, or that of the checkout in whose `target/PROFILE` it lies: there the standard
/// textures are edited without building the program again. No further up, where others may keep theirs.
fn shipped() -> Option<PathBuf> {
    let executable = env::current_exe().ok()?;
    let beside = executable.parent()?;
    let target = beside.parent().filter(|folder| folder.ends_with("target"));
    [Some(beside), target.and_then(Path::parent)]
        .into_iter()
        .flatten()
        .map(|folder| folder.join(FOLDER))
        .find(|folder| folder.is_dir())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_folders_come_first_and_none_comes_twice() {
        let root = tempfile::tempdir().expect("a temporary folder");
        let mine = root.path().join("mine");
        let beside = root.path().join(FOLDER);
        for dir in [&mine, &beside] {
            std::fs::create_dir(dir).expect("a folder");
        }
        let look = root.path().join("a.look.toml");
        let given = [mine.clone(), beside.clone(), mine.clone()];
        let dirs = texture_dirs(&given, Some(&look)).expect("all exist");
        assert_eq!(dirs[..2], [mine, beside.clone()]);
        assert_eq!(dirs.iter().filter(|dir| **dir == beside).count(), 1);
    }

    #[test]
    fn a_usual_folder_may_come_later() {
        let root = tempfile::tempdir().expect("a temporary folder");
        let look = root.path().join("a.look.toml");
        let beside = root.path().join(FOLDER);
        let known =
            |dirs: Result<Vec<PathBuf>, Failure>| dirs.expect("none is named").contains(&beside);
        assert!(!known(texture_dirs(&[], Some(&look))));
        assert!(known(texture_dirs_to_come(&[], Some(&look))));
        std::fs::write(&beside, "no folder").expect("written");
        assert!(!known(texture_dirs_to_come(&[], Some(&look))));
    }

    #[test]
    fn textures_are_listed_with_what_they_share() {
        let root = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| root.path().join(name);
        std::fs::create_dir(path(LIBRARIES)).expect("a folder");
        for name in ["a.wgsl", "a.txt", "lib/b.wgsl"] {
            std::fs::write(path(name), "").expect("written");
        }
        let found = files(&[root.path().to_owned(), path("missing")]);
        assert_eq!(found, [path("a.wgsl"), path("lib/b.wgsl")]);
    }

    #[test]
    fn a_missing_named_folder_is_an_error() {
        assert!(texture_dirs(&["no/such/folder".into()], None).is_err());
    }
}
