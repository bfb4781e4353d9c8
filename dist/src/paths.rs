//! Paths of the machine that built a program: nobody else has use for them, and they tell whose machine it was.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

/// Characters around a path that are shown with it.
const AROUND: usize = 60;

/// Looks through a program.
///
/// # Errors
/// It holds one of the paths; each is named with what is around it.
pub(crate) fn check(program: &Path, paths: &[&str]) -> Result<()> {
    let bytes = fs::read(program).with_context(|| format!("cannot read {}", program.display()))?;
    let found: Vec<String> = paths.iter().flat_map(|path| find(&bytes, path)).collect();
    match found.is_empty() {
        true => Ok(()),
        false => bail!(
            "{} holds paths of this machine:\n  {}",
            program.display(),
            found.join("\n  ")
        ),
    }
}

/// The first place with a path below this folder.
fn find(bytes: &[u8], folder: &str) -> Option<String> {
    let inside = entries(Path::new(folder));
    let is_path = |rest: &[u8]| match &inside {
        Some(names) => names.iter().any(|name| rest.starts_with(name)),
        None => true,
    };
    let length = folder.len().max(1);
    let at = (bytes.windows(length).enumerate())
        .find(|&(at, window)| window == folder.as_bytes() && is_path(&bytes[at + length..]))?
        .0;
    let end = (at + folder.len() + AROUND).min(bytes.len());
    let text = bytes[at..end]
        .split(|byte| !(32..127).contains(byte))
        .next();
    Some(String::from_utf8_lossy(text.unwrap_or_default()).into_owned())
}

/// What lies in a folder. Short names of folders are also parts of other texts (`/root/` is a home, and a part of names on
/// a desktop's bus), but these don't go on with one of its entries. `None` where that can't be known.
fn entries(folder: &Path) -> Option<Vec<Vec<u8>>> {
    let entries = fs::read_dir(folder).ok()?.flatten();
    Some(
        entries
            .map(|entry| entry.file_name().into_encoded_bytes())
            .collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_found_among_other_bytes() {
        let bytes = b"\0\xff/rustc/abc/lib.rs\0/home/me/patina/src/a.rs\0rest";
        let found = find(bytes, "/home/me/");
        assert_eq!(found.as_deref(), Some("/home/me/patina/src/a.rs"));
        assert_eq!(find(bytes, "/home/you/"), None);

        // A folder of this machine's, and a text that only looks like it.
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("src")).expect("created");
        let name = format!("{}/", folder.path().display());
        let text = format!("bus{name}org/a11y\0{name}src/lib.rs\0");
        let found = find(text.as_bytes(), &name);
        assert_eq!(found, Some(format!("{name}src/lib.rs")));
        assert_eq!(find(format!("{name}org").as_bytes(), &name), None);

        let file = tempfile::NamedTempFile::new().expect("a file");
        fs::write(&file, bytes).expect("written");
        assert!(check(file.path(), &["/home/you/", "/build/"]).is_ok());
        let error = check(file.path(), &["/home/you/", "/home/me/"]).expect_err("it is there");
        assert!(
            error.to_string().contains("/home/me/patina/src/a.rs"),
            "{error}"
        );
    }
}
