//! Samples whose picture could not be written are not lost: the film is kept where there is room, and the command that makes
//! the picture of it is told.

use std::env;
use std::path::{Path, PathBuf};

use engine::aside;
use engine::film::Part;

use crate::words::FILM_EXTENSION;

/// Names that are tried in a folder.
const MOST_NAMES: u32 = 100;

/// Keeps the film beside `lost`, else in the current folder, else in that for temporary files: where it is.
pub(super) fn keep(part: &Part, lost: &Path) -> Option<PathBuf> {
    let folders = [
        aside::folder_of(lost).to_owned(),
        PathBuf::from("."),
        env::temp_dir(),
    ];
    let stem = lost.file_stem().unwrap_or_default().to_string_lossy();
    // A name may be what the system didn't like.
    let stem: String = stem.chars().take(40).collect();
    folders.iter().find_map(|folder| {
        let names = (0..MOST_NAMES).map(|number| match number {
            0 => format!("{stem}.kept.{FILM_EXTENSION}"),
            n => format!("{stem}.kept-{n}.{FILM_EXTENSION}"),
        });
        let free = names.map(|name| folder.join(name)).find(|p| !p.exists())?;
        let kept = aside::create(&free, |file| part.write(file));
        kept.ok().map(|()| free)
    })
}

/// The command that writes what could not be written.
pub(super) fn command(
    film: &Path,
    lost: &[&Path],
    is_denoised: bool,
    is_transparent: bool,
) -> String {
    let mut line = format!("patina merge {}", quoted(film));
    for path in lost {
        line += &format!(" -o {}", quoted(path));
    }
    if is_denoised {
        line += " --denoise";
    }
    if is_transparent {
        line += " --transparent";
    }
    line
}

/// As a shell takes it for one word.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+=:,@%\\".contains(c);
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text,
        false if cfg!(windows) => format!("\"{text}\""),
        false => format!("'{}'", text.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_can_be_copied_into_a_shell() {
        let line = command(
            Path::new("/tmp/a.kept.patina-film"),
            &[Path::new("b.png")],
            false,
            false,
        );
        assert_eq!(line, "patina merge /tmp/a.kept.patina-film -o b.png");
        if !cfg!(windows) {
            assert_eq!(quoted(Path::new("it's $x.png")), "'it'\\''s $x.png'");
        }
    }
}
