//! `patina texture new`: a commented template to begin with, or a copy of another texture.

use std::fs;
use std::io::{ErrorKind, Write};

use engine::aside;
use engine::procedural::LIBRARIES;
use texgen::SourceFile;

use crate::console;
use crate::failure::Failure;

use super::job::NewJob;

/// The template; it is a valid texture as it stands.
const TEMPLATE: &str = include_str!("template.wgsl");

/// Writes the file.
///
/// # Errors
/// There is a file of that name already, or it can't be written; there is no texture to copy.
pub(crate) fn run(job: &NewJob) -> Result<(), Failure> {
    let path = job.dir.join(format!("{}.wgsl", job.name));
    let no_folder = |error: std::io::Error| {
        let dir = job.dir.display();
        Failure::Failed(match job.dir.exists() {
            true => format!("--dir {dir}: it is no folder; name another one"),
            false => format!("cannot create the folder {dir}: {error}"),
        })
    };
    let refused = |error: std::io::Error| {
        Failure::Failed(match error.kind() {
            ErrorKind::AlreadyExists => format!(
                "{} exists already; choose another name, or remove the file first",
                path.display()
            ),
            _ => format!("cannot write {}: {error}", path.display()),
        })
    };
    let sources = super::sources(&job.texture_dirs, None)?;
    let original = match &job.from {
        Some(original) => Some(super::read(&sources, original)?),
        None => None,
    };
    let text = match &original {
        Some(original) => original.text().to_owned(),
        None => TEMPLATE.replace("NAME", &job.name),
    };
    if let Some(other) = sources.path(&job.name).filter(|other| *other != path) {
        console::warning(&format!(
            "there is a texture of this name already: {}; the folder that is searched first decides which one is used",
            other.display()
        ));
    } else if sources.is_built_in(&job.name) {
        console::warning(
            "there is a standard texture of this name already: yours takes its place wherever its folder is searched",
        );
    }
    fs::create_dir_all(&job.dir).map_err(no_folder)?;
    aside::create(&path, |file| file.write_all(text.as_bytes())).map_err(refused)?;
    for library in original.iter().flat_map(SourceFile::libraries) {
        copy_shared(job, library)?;
    }
    console::note(&format!(
        "wrote {}\nsee it with: patina texture preview {} --textures {}",
        path.display(),
        job.name,
        job.dir.display()
    ));
    Ok(())
}

/// Puts a shared file that the copied texture uses where the copy looks for it, unless there is one.
fn copy_shared(job: &NewJob, library: &SourceFile) -> Result<(), Failure> {
    let folder = job.dir.join(LIBRARIES);
    let path = folder.join(format!("{}.wgsl", library.name()));
    let cannot = |error: std::io::Error| {
        Failure::Failed(format!(
            "cannot write {}, which the texture uses: {error}",
            path.display()
        ))
    };
    if path.exists() {
        if fs::read(&path).map_err(cannot)? != library.text().as_bytes() {
            console::warning(&format!(
                "the texture uses {}, and gets {}, which is another one",
                library.path(),
                path.display()
            ));
        }
        return Ok(());
    }
    fs::create_dir_all(&folder).map_err(cannot)?;
    aside::create(&path, |file| file.write_all(library.text().as_bytes())).map_err(cannot)?;
    console::note(&format!("wrote {}, which it uses", path.display()));
    Ok(())
}
