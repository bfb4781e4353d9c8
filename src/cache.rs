//! Where things are kept between runs that can be made again: compiled pipelines, and the marker of a build. Nothing is
//! opened here.

use std::ffi::OsString;
use std::path::PathBuf;

/// Names the folder, or switches caching off with `off`.
const VARIABLE: &str = "PATINA_CACHE";

/// The folder for what can be made again: `patina` in the platform's folder for caches, or what `PATINA_CACHE` names.
/// None where that says `off`, or the system doesn't tell.
pub(crate) fn folder() -> Option<PathBuf> {
    folder_of(|name| std::env::var_os(name))
}

fn folder_of(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    // The base directory specification takes absolute paths only.
    let absolute = |name: &str| {
        let path = PathBuf::from(variable(name)?);
        path.is_absolute().then_some(path)
    };
    match variable(VARIABLE) {
        Some(given) if given == "off" => return None,
        Some(given) if !given.is_empty() => return Some(PathBuf::from(given)),
        _ => {}
    }
    let base = if cfg!(windows) {
        absolute("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        absolute("HOME").map(|home| home.join("Library/Caches"))
    } else {
        absolute("XDG_CACHE_HOME").or_else(|| absolute("HOME").map(|home| home.join(".cache")))
    };
    base.map(|base| base.join("patina"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(variables: &[(&str, &str)]) -> Option<PathBuf> {
        folder_of(|name| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| OsString::from(value))
        })
    }

    #[test]
    fn a_variable_names_the_folder_or_switches_it_off() {
        let home = ("HOME", "/home/ann");
        assert_eq!(folder(&[home, (VARIABLE, "off")]), None);
        assert_eq!(folder(&[home, (VARIABLE, "here")]), Some("here".into()));
        assert_eq!(folder(&[home, (VARIABLE, "")]), folder(&[home]));
        assert_eq!(folder(&[]), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn without_it_the_platforms_folder_is_used() {
        let home = ("HOME", "/home/ann");
        assert_eq!(folder(&[home]), Some("/home/ann/.cache/patina".into()));
        let cache = |path| folder(&[home, ("XDG_CACHE_HOME", path)]);
        assert_eq!(cache("/tmp/c"), Some("/tmp/c/patina".into()));
        assert_eq!(cache("relative"), Some("/home/ann/.cache/patina".into()));
    }
}
