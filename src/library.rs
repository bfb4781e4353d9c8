//! Where textures are looked for: the folders named on the command line, then the usual ones. Behind them all are the
//! standard textures, which are part of the program (`TextureSources::search`).

use std::env;
use std::path::{Path, PathBuf};

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
    for dir in candidates.filter(|dir| dir.is_dir()) {
        let place = dir.canonicalize().unwrap_or_else(|_| dir.clone());
        if !seen.contains(&place) {
            seen.push(place);
            dirs.push(dir);
        }
    }
    Ok(dirs)
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
    fn a_missing_named_folder_is_an_error() {
        assert!(texture_dirs(&["no/such/folder".into()], None).is_err());
    }
}
