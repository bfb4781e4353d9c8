//! Edits that can't be saved, as when the device is gone or the program is ended from outside: they are kept in a file of their own.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use crate::aside;
use crate::system::Disk;

use super::Inputs;
use super::moved::moved;

/// How the file's name ends; a number follows where there are others.
const ENDING: &str = ".recovered";
/// As many files may lie in a folder that nobody has looked at.
const MOST: u32 = 1000;

/// Where the edits of a look are kept that could not be saved: beside it, or where that can't be written, in the folder for temporary
/// files: what it names relative to its folder is named from there, then. What was kept at former times stays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovery {
    /// Its ending and a number are added.
    beside: PathBuf,
    /// Where the look's paths begin: without a file, where the program was started.
    folder: PathBuf,
    kept: Option<PathBuf>,
}

impl Recovery {
    /// Of the look that is rendered; without a file it would lie beside the scene.
    pub fn of(inputs: &Inputs) -> Self {
        let beside = inputs.look.clone();
        let folder = beside.as_deref().and_then(Path::parent);
        Self {
            folder: folder.map(Path::to_owned).unwrap_or_default(),
            beside: beside.unwrap_or_else(|| inputs.scene.with_extension("look.toml")),
            kept: None,
        }
    }

    /// Keeps a text, in place of what this has kept before. Gives the file.
    ///
    /// # Errors
    /// What the system says of the file beside the look, where there is none in the folder for temporary files, either.
    pub fn keep(&mut self, text: &str) -> io::Result<&Path> {
        let former = self.kept.take();
        let again = former.filter(|path| {
            let text = self.moved(text, aside::folder_of(path));
            aside::replace(path, |file| file.write_all(text.as_bytes())).is_ok()
        });
        let kept = match again {
            Some(path) => path,
            None => {
                let beside = self.keep_in(aside::folder_of(&self.beside), text);
                let elsewhere = || self.keep_in(&std::env::temp_dir(), text);
                beside.or_else(|why| elsewhere().map_err(|_| why))?
            }
        };
        Ok(self.kept.insert(kept).as_path())
    }

    /// A text as it is to be written in a folder.
    fn moved(&self, text: &str, folder: &Path) -> String {
        moved(&Disk, text, [&self.folder, folder])
    }

    /// In a file of a folder that wasn't there.
    fn keep_in(&self, folder: &Path, text: &str) -> io::Result<PathBuf> {
        let name = self.beside.file_name().unwrap_or_default();
        let text = self.moved(text, folder);
        for number in 1..=MOST {
            let mut name = name.to_owned();
            name.push(ENDING);
            if number > 1 {
                name.push(format!("-{number}"));
            }
            let path = folder.join(name);
            if path.symlink_metadata().is_ok() {
                continue;
            }
            match aside::create(&path, |file| file.write_all(text.as_bytes())) {
                Ok(()) => return Ok(path),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        let why = format!("there are {MOST} files {ENDING} already");
        Err(io::Error::new(io::ErrorKind::AlreadyExists, why))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recovery(look: &Path) -> Recovery {
        Recovery::of(&Inputs {
            scene: PathBuf::from("scene.gltf"),
            look: Some(look.to_owned()),
            textures: Vec::new(),
            camera: None,
        })
    }

    #[test]
    fn edits_are_kept_beside_the_look_and_none_are_lost() {
        let folder = tempfile::tempdir().expect("a folder");
        let look = folder.path().join("a.look.toml");
        let read = |path: &Path| std::fs::read_to_string(path).expect("it is there");
        let mut first = recovery(&look);
        let path = first.keep("one").expect("kept").to_owned();
        assert_eq!(path, folder.path().join("a.look.toml.recovered"));
        // What is done until it is said.
        assert_eq!(first.keep("two").expect("kept"), path);
        assert_eq!(read(&path), "two");
        // Another time.
        let mut second = recovery(&look);
        let other = second.keep("three").expect("kept");
        assert_eq!(other, folder.path().join("a.look.toml.recovered-2"));
        assert_eq!((read(&path), read(other)), ("two".into(), "three".into()));
        assert!(!look.exists());
    }

    #[test]
    fn a_folder_that_takes_no_files_is_no_end_of_edits() {
        let folder = tempfile::tempdir().expect("a folder");
        let name = folder.path().file_name().expect("it has one");
        let gone = folder.path().join("no/such").join(name);
        let mut recovery = recovery(&gone);
        let path = recovery.keep("all").expect("kept elsewhere").to_owned();
        assert_eq!(path.parent(), Some(&*std::env::temp_dir()));
        assert_eq!(std::fs::read_to_string(&path).expect("it is there"), "all");
        std::fs::remove_file(path).expect("removed");
    }

    #[test]
    fn a_look_without_a_file_would_lie_beside_the_scene() {
        let inputs = Inputs {
            scene: PathBuf::from("a/scene.gltf"),
            look: None,
            textures: Vec::new(),
            camera: None,
        };
        let beside = Recovery::of(&inputs).beside;
        assert_eq!(beside, Path::new("a/scene.look.toml"));
    }

    #[test]
    fn edits_kept_elsewhere_name_the_same_files() {
        let folder = tempfile::tempdir().expect("a folder");
        let look = |image: &str| format!("environment = {{ image = '{image}' }} # sky\n");
        // Without a file it begins where the program was started, and is kept beside the scene.
        let mut recovery = Recovery::of(&Inputs {
            scene: folder.path().join("scene.gltf"),
            look: None,
            textures: Vec::new(),
            camera: None,
        });
        let root = std::env::current_dir().expect("a folder");
        let sky = |path: &Path| {
            let text = std::fs::read_to_string(path).expect("it is there");
            let name = text.split('\'').nth(1).expect("an image").to_owned();
            let image = path.parent().expect("a folder").join(name);
            let there = image.parent().expect("a folder").canonicalize();
            (there.expect("it is there"), text.ends_with(" # sky\n"))
        };
        let root = (root.canonicalize().expect("a folder"), true);
        // What was kept before is replaced by what was done since then.
        for name in ["sky.hdr", "other.hdr"] {
            let path = recovery.keep(&look(name)).expect("kept").to_owned();
            assert_eq!(path, folder.path().join("scene.look.toml.recovered"));
            assert_eq!(sky(&path), root, "{name}");
        }
    }

    #[test]
    fn edits_kept_beside_the_look_are_kept_to_the_byte() {
        let folder = tempfile::tempdir().expect("a folder");
        let text = "environment = { image = './tex//sky.hdr' }\n";
        let mut recovery = recovery(&folder.path().join("a.look.toml"));
        let path = recovery.keep(text).expect("kept").to_owned();
        assert_eq!(std::fs::read_to_string(&path).expect("it is there"), text);
    }
}
