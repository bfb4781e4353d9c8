//! Where results go: whether files can be written is tried before rendering, and what can't be written in the end is kept
//! elsewhere. The files themselves are the engine's business ([`engine::film::write`]).
//!
//! A file is written aside and renamed when it is complete ([`engine::aside`]), so that neither a full disk nor Ctrl-C leaves
//! half a picture or destroys an older one.

mod identity;
mod salvage;

use std::env;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use engine::aside::{self, Aside};
use engine::film::write::{self, Content, Form, Metadata};
use engine::film::{Layers, Origin, Part};
use engine::scene::view::View;
use thiserror::Error;

pub(crate) use self::identity::{refuse_inputs, refuse_overwriting};
pub(crate) use self::salvage::picture_flags;
use crate::console;
use crate::denoise::Denoised;
use crate::failure::Failure;
use crate::words::{Output, Outputs};

/// What is written of a render, or of a merge.
pub(crate) struct Results<'a> {
    /// What was gathered.
    pub(crate) part: &'a Part,
    /// What files of films hold in its place, where that is gone on with.
    pub(crate) kept: Option<&'a Part>,
    /// What of it files of pictures hold.
    pub(crate) layers: &'a Layers,
    /// The picture that they show, where its noise has been taken out.
    pub(crate) denoised: Option<&'a Denoised>,
    /// Without the environment behind everything.
    pub(crate) transparent: bool,
    /// How EXR files are written.
    pub(crate) form: &'a Form,
    /// How PNG and JPEG show it; EXR keeps the radiance.
    pub(crate) view: &'a View,
    /// It is one of several, whose pictures say that it is done.
    pub(crate) is_frame: bool,
}

impl Results<'_> {
    /// Without its film a frame gets no pictures: one that has them is taken for done.
    fn has_no_pictures(&self, outputs: &Outputs, failed: &[(PathBuf, OutputError)]) -> bool {
        let is_lost = |film: &PathBuf| failed.iter().any(|(path, _)| path == film);
        self.is_frame && outputs.films.iter().any(is_lost)
    }

    /// What goes to files of pictures.
    pub(crate) fn content(&self) -> Content<'_> {
        Content {
            film: &self.part.film,
            layers: self.layers,
            denoised: self.denoised.map(|denoised| &*denoised.picture),
            transparent: self.transparent,
            form: self.form,
        }
    }
}

/// A file that cannot be written.
#[derive(Debug, Error)]
pub(crate) enum OutputError {
    /// The folder does not exist.
    #[error("cannot write {}: the folder {} does not exist; create it first", path.display(), dir.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// The folder it was to lie in.
        dir: PathBuf,
    },
    /// The name is taken by a folder.
    #[error("cannot write {}: it is a folder", path.display())]
    IsFolder {
        /// The file.
        path: PathBuf,
    },
    /// The system refused.
    #[error("cannot write {}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system or the encoder said.
        reason: io::Error,
    },
}

impl OutputError {
    pub(crate) fn new(path: &Path, reason: io::Error) -> Self {
        let path = path.to_owned();
        let dir = aside::folder_of(&path);
        match reason.kind() == io::ErrorKind::NotFound && !dir.exists() {
            true => Self::NoFolder {
                dir: dir.to_owned(),
                path,
            },
            false => Self::Io { path, reason },
        }
    }
}

/// Finds out, before any work is done, whether `path` can be written later.
///
/// # Errors
/// Its folder is missing or takes no new files, its name is too long, or `path` is a folder.
pub(crate) fn check(path: &Path) -> Result<(), OutputError> {
    if path.is_dir() {
        return Err(OutputError::IsFolder {
            path: path.to_owned(),
        });
    }
    // The file made here is removed at once; what counts is that it could be made.
    let begun = Aside::begin(path).map(drop);
    begun.map_err(|reason| OutputError::new(path, reason))
}

/// As [`check`], for all results, and that none of them would replace a file that is read, or one of the others.
///
/// # Errors
/// The first that can't be written, or must not be.
pub(crate) fn check_all<'a>(
    written: impl IntoIterator<Item = &'a PathBuf> + Clone,
    read: &[PathBuf],
) -> Result<(), Failure> {
    refuse_overwriting(written.clone(), read)?;
    for path in written {
        check(path).map_err(Failure::because)?;
    }
    Ok(())
}

/// Writes a film and where it came from to `output`, as `view` shows it where that is PNG or JPEG.
///
/// # Errors
/// The file cannot be written; an older one is then untouched.
pub(crate) fn write<'a>(
    output: &Output,
    content: impl Into<Content<'a>>,
    origin: Option<&Origin>,
    view: &View,
) -> Result<(), OutputError> {
    let content = content.into();
    let metadata = origin.map(|origin| Metadata::new(content.film, origin));
    save(output, content, &metadata.unwrap_or_default(), view)
}

/// The same of a picture from which this has taken the noise.
///
/// # Errors
/// As [`write()`].
pub(crate) fn write_denoised(
    output: &Output,
    content: Content<'_>,
    origin: &Origin,
    view: &View,
    denoiser: &str,
) -> Result<(), OutputError> {
    let metadata = Metadata::new(content.film, origin).denoised_by(denoiser);
    save(output, content, &metadata, view)
}

fn save(
    output: &Output,
    content: Content<'_>,
    metadata: &Metadata,
    view: &View,
) -> Result<(), OutputError> {
    let written = write::save(&output.path, output.format, content, metadata, view);
    written.map_err(|reason| OutputError::new(&output.path, reason))
}

/// Writes 8-bit RGBA as it is shown: see [`write::save_shown`].
///
/// # Errors
/// As [`write()`].
pub(crate) fn write_shown(output: &Output, size: [u32; 2], rgba: &[u8]) -> Result<(), OutputError> {
    let written = write::save_shown(&output.path, output.format, size, rgba);
    written.map_err(|reason| OutputError::new(&output.path, reason))
}

/// Writes 8-bit RGBA of a texture, and tells whether it has all its channels there: see [`write::save_texture`].
///
/// # Errors
/// As [`write()`].
pub(crate) fn write_texture(
    output: &Output,
    size: [u32; 2],
    rgba: &[u8],
) -> Result<bool, OutputError> {
    let written = write::save_texture(&output.path, output.format, size, rgba);
    written.map_err(|reason| OutputError::new(&output.path, reason))
}

/// Writes the files of a merge: its pictures, and its sums.
///
/// # Errors
/// What could not be written. The other files are written all the same: one full disk must not cost all.
pub(crate) fn write_all(outputs: &Outputs, results: &Results<'_>) -> Result<(), Failure> {
    let failed = try_all(outputs, results);
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Failure::Failed(text(&failed))),
    }
}

/// As [`write_all`], for what would have to be rendered again: where a file could not be written, the sums are kept elsewhere.
///
/// # Errors
/// As [`write_all`], with the place of the sums.
pub(crate) fn write_or_keep(outputs: &Outputs, results: &Results<'_>) -> Result<(), Failure> {
    let failed = try_all(outputs, results);
    let mut lost: Vec<&Path> = failed.iter().map(|(path, _)| path.as_path()).collect();
    let Some(&first) = lost.first() else {
        return Ok(());
    };
    if results.has_no_pictures(outputs, &failed) {
        lost.extend(outputs.pictures.iter().map(|output| output.path.as_path()));
    }
    let written = outputs
        .films
        .iter()
        .find(|film| !lost.contains(&film.as_path()));
    let kept = match written {
        Some(film) => Some(film.clone()),
        None => salvage::keep(results.part, first),
    };
    let given: Vec<String> = env::args_os()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let hint = match &kept {
        Some(film) => format!(
            "the samples are in {}; what is missing is written by: {}",
            film.display(),
            salvage::command(film, &lost, &given)
        ),
        None => "nor could the samples be kept anywhere else".to_owned(),
    };
    Err(Failure::Failed(format!("{}\n{hint}", text(&failed))))
}

/// Writes what can be written; what can't, with the reason.
fn try_all(outputs: &Outputs, results: &Results<'_>) -> Vec<(PathBuf, OutputError)> {
    let part = results.part;
    let content = results.content();
    let mut metadata = Metadata::new(&part.film, &part.origin);
    if let Some(denoised) = results.denoised {
        metadata = metadata.denoised_by(&denoised.by);
    }
    let mut failed = Vec::new();
    let note = |failed: &mut Vec<_>, path: &Path, written: Result<(), OutputError>| match written {
        Ok(()) => console::note(&format!("wrote {}", path.display())),
        Err(error) => failed.push((path.to_owned(), error)),
    };
    for path in &outputs.films {
        let film = results.kept.unwrap_or(part);
        let written = write_aside(path, |file| film.write(file));
        note(&mut failed, path, written);
    }
    if results.has_no_pictures(outputs, &failed) {
        return failed;
    }
    for output in &outputs.pictures {
        let written = save(output, content, &metadata, results.view);
        note(&mut failed, &output.path, written);
    }
    failed
}

fn text(failed: &[(PathBuf, OutputError)]) -> String {
    let lines = failed.iter().map(|(_, error)| error.to_string());
    lines.collect::<Vec<_>>().join("\n")
}

/// Creates or replaces the file at `path` with what `fill` writes, all of it or nothing.
///
/// # Errors
/// The system refuses, or `fill` fails.
pub(crate) fn write_aside(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    aside::replace(path, fill).map_err(|reason| OutputError::new(path, reason))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn trouble_is_found_before_rendering() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let missing = check(&dir.path().join("no/x.png")).unwrap_err();
        assert!(matches!(missing, OutputError::NoFolder { .. }), "{missing}");
        let folder = check(dir.path()).unwrap_err();
        assert!(matches!(folder, OutputError::IsFolder { .. }), "{folder}");
        assert!(check(&dir.path().join("x.png")).is_ok());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }
}
