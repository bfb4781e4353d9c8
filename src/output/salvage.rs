//! Samples whose picture could not be written are not lost: the film is kept where there is room, and the command that makes
//! the picture of it is told.

use std::collections::BTreeMap;
use std::env;
use std::path::{Path, PathBuf};

use engine::aside;
use engine::film::Part;
use engine::scene::look::{Section, Value};
use engine::session::Edit;

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

/// Those of the words of `patina render` that say what is made of the samples: `patina merge` has them too. What `--set` says of the view
/// becomes the flag that says the same.
pub(crate) fn picture_flags(flags: &[String]) -> Vec<String> {
    const WITH_VALUE: [&str; 8] = [
        "--look",
        "--view",
        "--exposure",
        "--white-balance",
        "--exr-compression",
        "--exr-half",
        "--exr-float",
        "--metadata",
    ];
    let mut words = Vec::new();
    let mut set = BTreeMap::new();
    let mut flags = flags.iter();
    while let Some(flag) = flags.next() {
        let name = flag.split('=').next().unwrap_or_default();
        if name == "--set" {
            let given = match flag.split_once('=') {
                Some((_, given)) => Some(given),
                None => flags.next().map(String::as_str),
            };
            // The last one counts, and the flag itself more than any.
            set.extend(given.and_then(view_flag));
        } else if matches!(flag.as_str(), "--denoise" | "--transparent")
            || (WITH_VALUE.contains(&name) && name != flag)
        {
            words.push(flag.clone());
        } else if WITH_VALUE.contains(&name) {
            words.push(flag.clone());
            words.extend(flags.next().cloned());
        }
    }
    let is_given = |name: &str| {
        let own = |word: &String| word.split('=').next() == Some(name);
        words.iter().any(own)
    };
    set.retain(|name, _| !is_given(name));
    let set = set
        .into_iter()
        .map(|(name, value)| format!("{name}={value}"));
    words.extend(set.collect::<Vec<_>>());
    words
}

/// The flag that says what an edit of the view does, and its value.
fn view_flag(edit: &str) -> Option<(&'static str, String)> {
    let Ok(Edit::Set {
        section: Section::View,
        key,
        value,
    }) = Edit::parse(edit)
    else {
        return None;
    };
    let flag = match key.as_str() {
        "exposure" => "--exposure",
        "transform" => "--view",
        "white_balance" => "--white-balance",
        _ => return None,
    };
    let number = |value: &Value| match value {
        Value::Integer(number) => Some(number.to_string()),
        Value::Float(number) => Some(number.to_string()),
        _ => None,
    };
    let value = match &value {
        Value::Text(text) => text.clone(),
        Value::List(numbers) => {
            let numbers: Option<Vec<String>> = numbers.iter().map(|v| number(&v.value)).collect();
            numbers?.join(",")
        }
        other => number(other)?,
    };
    Some((flag, value))
}

/// The command that writes what could not be written.
pub(super) fn command(film: &Path, lost: &[&Path], rendered_by: &[String]) -> String {
    let mut line = format!("patina merge {}", quoted(film));
    for path in lost {
        line += &format!(" -o {}", quoted(path));
    }
    for flag in picture_flags(rendered_by) {
        line += &format!(" {}", quoted(Path::new(&flag)));
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
            &[
                "render",
                "a.glb",
                "--exposure",
                "1.5",
                "--view=agx",
                "--spp",
                "9",
                "--denoise",
            ]
            .map(str::to_owned),
        );
        assert_eq!(
            line,
            "patina merge /tmp/a.kept.patina-film -o b.png --exposure 1.5 --view=agx --denoise"
        );
        let line = command(
            Path::new("a.patina-film"),
            &[],
            &[
                "--set",
                "view.exposure=2",
                "--set=view.exposure=-0.5",
                "--set",
                "rust.scale=3",
                "--set",
                "view.transform='agx'",
                "--view",
                "filmic",
                "--set=view.white_balance=[5000, -12]",
            ]
            .map(str::to_owned),
        );
        assert_eq!(
            line,
            "patina merge a.patina-film --view filmic --exposure=-0.5 --white-balance=5000,-12"
        );
        if !cfg!(windows) {
            assert_eq!(quoted(Path::new("it's $x.png")), "'it'\\''s $x.png'");
        }
    }
}
