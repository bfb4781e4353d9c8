//! What a command line says in place of the look's file.

use std::path::{Path, PathBuf};

use engine::scene::look::{Section, Value};
use engine::session::Edit;

use crate::usage::UsageError;
use crate::words::parse_point;

/// Edits of the look, from the flags that are short for them, then as they were given.
///
/// # Errors
/// One that can't be understood.
pub(crate) fn parse(
    set: &[String],
    environment: Option<&Path>,
    position: Option<&str>,
    look_at: Option<&str>,
) -> Result<Vec<Edit>, UsageError> {
    let mut edits = Vec::new();
    if let Some(path) = environment {
        // A look names files from where it lies.
        let path = std::path::absolute(path).unwrap_or_else(|_| PathBuf::from(path));
        let image = Value::Text(path.display().to_string());
        edits.push(Edit::Remove {
            section: Section::Environment,
        });
        edits.push(Edit::environment("image", image));
    }
    for (flag, key, given) in [
        ("--camera-at", "position", position),
        ("--look-at", "look_at", look_at),
    ] {
        if let Some(given) = given {
            let point = parse_point(flag, given)?;
            edits.push(Edit::camera(key, Value::numbers(&point)));
        }
    }
    for given in set {
        let edit = Edit::parse(given).map_err(|form| UsageError::Set {
            given: given.clone(),
            form,
        })?;
        edits.push(edit);
    }
    Ok(edits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_edits_in_their_order() {
        let set = ["rust.scale=2".to_owned()];
        let edits = parse(&set, Some(Path::new("/a/sky.hdr")), Some("1,2,3"), None);
        let edits = edits.expect("well-formed");
        let sections: Vec<_> = edits
            .iter()
            .map(|edit| edit.section().to_string())
            .collect();
        let expected = ["[environment]", "[environment]", "[camera]", "[node.rust]"];
        assert_eq!(sections, expected);
        assert!(parse(&["rust".to_owned()], None, None, None).is_err());
        assert!(parse(&[], None, Some("1,2"), None).is_err());
        assert!(parse(&[], None, None, Some("1,2,inf")).is_err());
    }
}
