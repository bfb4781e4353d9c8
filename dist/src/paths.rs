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

/// The first place with this path.
fn find(bytes: &[u8], path: &str) -> Option<String> {
    let at = bytes
        .windows(path.len().max(1))
        .position(|window| window == path.as_bytes())?;
    let end = (at + path.len() + AROUND).min(bytes.len());
    let text = bytes[at..end]
        .split(|byte| !(32..127).contains(byte))
        .next();
    Some(String::from_utf8_lossy(text.unwrap_or_default()).into_owned())
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
