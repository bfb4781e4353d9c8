//! `patina texture new`: a commented template to begin with.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};

use crate::console;
use crate::exit::Failure;

use super::job::NewJob;

/// The template; it is a valid texture as it stands.
const TEMPLATE: &str = include_str!("template.wgsl");

/// Writes the file.
///
/// # Errors
/// There is a file of that name already, or it can't be written.
pub(crate) fn run(job: &NewJob) -> Result<(), Failure> {
    let path = job.dir.join(format!("{}.wgsl", job.name));
    let refused = |error: std::io::Error| {
        Failure::Failed(match error.kind() {
            ErrorKind::AlreadyExists => format!(
                "{} exists already; choose another name, or remove the file first",
                path.display()
            ),
            _ => format!("cannot write {}: {error}", path.display()),
        })
    };
    let sources = super::sources(&[], None)?;
    if let Some(other) = sources.path(&job.name).filter(|other| *other != path) {
        console::warning(&format!(
            "there is a texture of this name already: {}; the folder that is searched first decides which one is used",
            other.display()
        ));
    }
    fs::create_dir_all(&job.dir).map_err(refused)?;
    let mut file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&path)
        .map_err(refused)?;
    file.write_all(TEMPLATE.replace("NAME", &job.name).as_bytes())
        .map_err(refused)?;
    console::print(&format!(
        "wrote {}\nsee it with: patina texture preview {} --textures {}",
        path.display(),
        job.name,
        job.dir.display()
    ));
    Ok(())
}
