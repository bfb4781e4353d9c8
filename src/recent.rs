//! What the window has shown, the latest first, in a file of the user's configuration folder.

use std::ffi::OsString;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use patina_viewer::link::Files;

use crate::output::{self, OutputError};

/// In the folder.
const FILE: &str = "recent.json";
/// Read of it at most: whoever has made it larger, it is not what was written here.
const MOST_BYTES: u64 = 1 << 20;

/// The file, in `patina` in the platform's folder for configuration; none where the system doesn't tell where that is.
pub(crate) fn file() -> Option<PathBuf> {
    folder_of(|name| std::env::var_os(name)).map(|folder| folder.join(FILE))
}

fn folder_of(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let absolute = |name: &str| {
        let path = PathBuf::from(variable(name)?);
        path.is_absolute().then_some(path)
    };
    let base = if cfg!(windows) {
        absolute("APPDATA")
    } else if cfg!(target_os = "macos") {
        absolute("HOME").map(|home| home.join("Library/Application Support"))
    } else {
        absolute("XDG_CONFIG_HOME").or_else(|| absolute("HOME").map(|home| home.join(".config")))
    };
    base.map(|base| base.join("patina"))
}

/// What the file has. One that isn't there, or that something else has written, has nothing: it is replaced by the next scene.
pub(crate) fn read(file: &Path) -> Vec<Files> {
    let is_small = fs::metadata(file).is_ok_and(|found| found.len() <= MOST_BYTES);
    let text = is_small.then(|| fs::read_to_string(file).ok()).flatten();
    let list = text.and_then(|text| serde_json::from_str(&text).ok());
    list.unwrap_or_default()
}

/// Writes the file, all of it or nothing. Paths are kept as they are from anywhere.
///
/// # Errors
/// The system refuses.
pub(crate) fn write(file: &Path, list: &[Files]) -> Result<(), OutputError> {
    if let Some(folder) = file.parent() {
        // Where it can't be made, the file can't either, and that says why.
        let _ = fs::create_dir_all(folder);
    }
    // A path that is no text can't be kept.
    let is_text = |files: &&Files| serde_json::to_value(files).is_ok();
    let list: Vec<&Files> = list.iter().filter(is_text).collect();
    let text = serde_json::json!(list);
    output::write_aside(file, |to| writeln!(to, "{text:#}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_anything_else_is_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("new").join(FILE);
        assert_eq!(read(&file), []);
        let list = ["a.glb", "b.gltf"].map(|scene| Files {
            scene: scene.into(),
            look: Some("x.look.toml".into()),
            camera: None,
        });
        write(&file, &list).expect("written");
        assert_eq!(read(&file), list);
        for text in ["", "[", "{}", "[1]"] {
            fs::write(&file, text).expect("written");
            assert_eq!(read(&file), [], "{text}");
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn it_lies_in_the_folder_for_configuration() {
        let folder = |variables: &[(&str, &str)]| {
            folder_of(|name| {
                let found = variables.iter().find(|(known, _)| *known == name);
                found.map(|(_, value)| OsString::from(value))
            })
        };
        let home = ("HOME", "/home/ann");
        assert_eq!(folder(&[home]), Some("/home/ann/.config/patina".into()));
        let own = [home, ("XDG_CONFIG_HOME", "/etc/ann")];
        assert_eq!(folder(&own), Some("/etc/ann/patina".into()));
        assert_eq!(folder(&[("XDG_CONFIG_HOME", "relative")]), None);
        assert_eq!(folder(&[]), None);
    }
}
