//! Which file a path means, whatever the path looks like: a result must not replace something that was read, and two
//! results must not replace each other.

use std::path::{Path, PathBuf};

use engine::aside;

use crate::usage::UsageError;

/// A file. Two paths that lead to one file, by links, hard links or other spellings, have one identity.
#[derive(Debug, PartialEq, Eq)]
enum Identity {
    /// It exists: device and number there.
    #[cfg(unix)]
    Number(u64, u64),
    /// By its real folder and its name.
    Place(PathBuf),
}

impl Identity {
    fn of(path: &Path) -> Option<Self> {
        #[cfg(unix)]
        if let Ok(meta) = std::fs::metadata(path) {
            use std::os::unix::fs::MetadataExt;
            // A device or a pipe isn't replaced, and may be written to several times.
            let is_file = meta.is_file();
            return is_file.then(|| Self::Number(meta.dev(), meta.ino()));
        }
        if let Ok(real) = path.canonicalize() {
            return Some(Self::Place(real));
        }
        // It isn't there yet.
        let target = aside::followed(path).ok()?;
        let folder = aside::folder_of(&target).canonicalize().ok()?;
        Some(Self::Place(folder.join(target.file_name()?)))
    }
}

/// Refuses results that would replace an input or one another.
///
/// # Errors
/// Names the first one.
pub(crate) fn refuse_overwriting<'a>(
    written: impl IntoIterator<Item = &'a PathBuf>,
    read: &[PathBuf],
) -> Result<(), UsageError> {
    let inputs: Vec<Identity> = read.iter().filter_map(|path| Identity::of(path)).collect();
    let mut seen: Vec<Identity> = Vec::new();
    for path in written {
        let Some(identity) = Identity::of(path) else {
            continue;
        };
        if inputs.contains(&identity) {
            return Err(UsageError::OverwritesInput { path: path.clone() });
        }
        if seen.contains(&identity) {
            return Err(UsageError::Twice { path: path.clone() });
        }
        seen.push(identity);
    }
    Ok(())
}

/// Refuses results that are there already and would replace an input. They may be links to one file, and none has to be writable.
///
/// # Errors
/// Names the first one.
pub(crate) fn refuse_inputs(written: &[PathBuf], read: &[PathBuf]) -> Result<(), UsageError> {
    let inputs: Vec<Identity> = read.iter().filter_map(|path| Identity::of(path)).collect();
    let is_input = |path: &PathBuf| Identity::of(path).is_some_and(|file| inputs.contains(&file));
    match written.iter().find(|&path| is_input(path)) {
        Some(path) => Err(UsageError::OverwritesInput { path: path.clone() }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_file_is_known_by_all_its_names() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| dir.path().join(name);
        fs::create_dir(path("below")).expect("a folder");
        fs::write(path("scene.glb"), "scene").expect("written");
        fs::hard_link(path("scene.glb"), path("hard.png")).expect("a hard link");
        let mut names = vec!["scene.glb", "below/../scene.glb", "hard.png"];
        if cfg!(unix) {
            #[cfg(unix)]
            std::os::unix::fs::symlink("scene.glb", path("soft.png")).expect("a link");
            names.push("soft.png");
        } else {
            names.pop();
        }
        let read = [path("scene.glb"), path("is-not-there.png")];
        for name in names {
            let refused = refuse_overwriting([&path(name)], &read);
            assert!(
                matches!(refused, Err(UsageError::OverwritesInput { .. })),
                "{name}: {refused:?}"
            );
        }
        let (new, same) = (path("new.png"), path("below/../new.png"));
        assert!(refuse_overwriting([&new], &read).is_ok());
        let twice = refuse_overwriting([&new, &same], &read);
        assert!(matches!(twice, Err(UsageError::Twice { .. })), "{twice:?}");
    }

    #[cfg(unix)]
    #[test]
    fn links_to_one_file_are_no_inputs() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| dir.path().join(name);
        for (file, link) in [("scene.glb", "2.png"), ("0.png", "1.png")] {
            fs::write(path(file), file).expect("written");
            fs::hard_link(path(file), path(link)).expect("a hard link");
        }
        let read = [path("scene.glb"), path("is-not-there.png")];
        assert!(refuse_inputs(&[path("0.png"), path("1.png")], &read).is_ok());
        let refused = refuse_inputs(&[path("0.png"), path("2.png")], &read);
        let Err(UsageError::OverwritesInput { path: named }) = refused else {
            panic!("{refused:?}");
        };
        assert_eq!(named, path("2.png"));
    }
}
