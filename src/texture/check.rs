//! `patina texture check`: every mistake of every file, for people, editors and continuous integration.

use std::path::Path;

use engine::procedural::TextureSources;
use texgen::{Diagnostic, Diagnostics, Severity, SourceFile, TextureType};

use crate::console;
use crate::failure::Failure;

use super::counted;
use super::job::CheckJob;

/// Prints what is wrong and what is odd.
///
/// # Errors
/// A texture has an error.
pub(crate) fn run(job: &CheckJob) -> Result<(), Failure> {
    let sources = super::sources(&job.texture_dirs, None)?;
    let files = if job.files.is_empty() {
        all(&sources)
    } else {
        let named = job.files.iter().map(|file| find(file, &sources));
        named.collect::<Result<Vec<_>, _>>()?.concat()
    };
    let (mut faulty, mut errors, mut warnings) = (0, 0, 0);
    for file in &files {
        let found = problems(file);
        let count = found.count(Severity::Error);
        faulty += usize::from(count > 0);
        errors += count;
        warnings += found.count(Severity::Warning);
        console::print_diagnostics(&found);
    }
    if !console::is_json() {
        console::print(&format!(
            "checked {}: {}, {}",
            counted(files.len(), "texture"),
            counted(errors, "error"),
            counted(warnings, "warning")
        ));
    }
    match faulty {
        0 => Ok(()),
        _ => Err(Failure::Failed(format!(
            "{} of {} can't be used",
            faulty,
            counted(files.len(), "texture")
        ))),
    }
}

type Read = Result<SourceFile, Diagnostic>;

fn all(sources: &TextureSources) -> Vec<Read> {
    let names = sources.names();
    names.map(|name| super::read(sources, name)).collect()
}

/// What a word of the command line means: a file, all textures of a folder, or a texture by name.
fn find(given: &Path, sources: &TextureSources) -> Result<Vec<Read>, Failure> {
    if given.is_dir() {
        let folder = TextureSources::scan(&[given]).map_err(Failure::because)?;
        let paths = folder.names().filter_map(|name| folder.path(name));
        return Ok(paths.map(open).collect());
    }
    let name = given.to_string_lossy();
    if !given.exists() && sources.names().any(|known| known == name) {
        return Ok(vec![super::read(sources, &name)]);
    }
    let is_path = given.exists() || given.extension().is_some() || given.components().count() > 1;
    Ok(vec![match is_path {
        true => open(given),
        false => Err(super::unknown(sources, &name)),
    }])
}

/// A texture's file; one that textures share is checked as they use it.
fn open(path: &Path) -> Read {
    let file = TextureSources::open(path).map_err(super::unreadable)?;
    let is_texture = file.text().contains("fn userProc");
    match TextureSources::user_of(path).filter(|_| !is_texture) {
        Some(user) => user.map_err(super::unreadable),
        None => Ok(file),
    }
}

fn problems(file: &Read) -> Diagnostics {
    match file {
        Err(error) => error.clone().into(),
        Ok(file) => match TextureType::parse(file.clone()) {
            Ok(texture) => texture.warnings().clone(),
            Err(problems) => problems,
        },
    }
}
