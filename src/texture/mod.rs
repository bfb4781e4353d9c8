//! `patina texture`: tools for those who write textures. One file per command; what they share is here.

pub(crate) mod args;
mod check;
mod doc;
mod eval;
mod inspect;
pub(crate) mod job;
mod list;
mod new;
mod preview;
mod programs;
mod written;

use std::path::{Path, PathBuf};

use engine::procedural::{SourcesError, TextureSources};
use texgen::{Diagnostic, Diagnostics, SourceFile, did_you_mean};

use crate::console;
use crate::failure::Failure;
use crate::library;

use job::TextureJob;

/// Does what was asked.
///
/// # Errors
/// Mistakes in the user's files, and whatever keeps results from being written.
pub(crate) fn run(job: TextureJob) -> Result<(), Failure> {
    match job {
        TextureJob::List(texture_dirs) => list::run(&texture_dirs),
        TextureJob::Doc(job) => doc::run(&job),
        TextureJob::Prelude => {
            console::print(texgen::PRELUDE);
            Ok(())
        }
        TextureJob::Check(job) => check::run(&job),
        TextureJob::New(job) => new::run(&job),
        TextureJob::Inspect(job) => inspect::run(&job),
        TextureJob::Eval(job) => eval::run(&job),
        TextureJob::Preview(job) => preview::run(&job),
    }
}

/// The textures of all folders that are searched.
fn sources(texture_dirs: &[PathBuf], look: Option<&Path>) -> Result<TextureSources, Failure> {
    let dirs = library::texture_dirs(texture_dirs, look)?;
    TextureSources::search(&dirs).map_err(Failure::because)
}

/// The text of the texture of that name.
fn read(sources: &TextureSources, name: &str) -> Result<SourceFile, Diagnostic> {
    match sources.read(name) {
        Some(file) => file.map_err(unreadable),
        None => Err(unknown(sources, name)),
    }
}

fn unreadable(error: SourcesError) -> Diagnostic {
    Diagnostic::error(error.to_string())
}

fn unknown(sources: &TextureSources, name: &str) -> Diagnostic {
    let error = Diagnostic::error(format!("there is no texture called `{name}`"));
    match did_you_mean(name, sources.names()) {
        Some(near) => error.with_note(format!("did you mean `{near}`?")),
        None => error.with_note("`patina texture list` shows those there are"),
    }
}
/// A number of things, as in `2 errors`.
fn counted(count: usize, what: &str) -> String {
    match count {
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    }
}

impl From<Diagnostic> for Failure {
    fn from(mistake: Diagnostic) -> Self {
        Self::Mistakes(Diagnostics::from(mistake))
    }
}
