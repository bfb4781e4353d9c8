//! `patina import`: a MaterialX document, or glTF's procedural textures, as the text of a look.

pub(crate) mod args;
pub(crate) mod job;

use std::io::{ErrorKind, Write};
use std::path::Path;

use engine::aside;
use engine::system::Disk;
use materialx::{Document, Wanted};

use crate::console;
use crate::failure::Failure;
use crate::output::{self, OutputError};

use job::ImportJob;

/// Writes the look.
///
/// # Errors
/// The document can't be read, has mistakes, or no such material; there is a look of that name already, or it can't be written.
pub(crate) fn run(job: &ImportJob) -> Result<(), Failure> {
    output::check(&job.output).map_err(Failure::because)?;
    let document = Document::open(&Disk, &job.file, job.drafts)?;
    let wanted = Wanted {
        material: job.material.clone(),
        name: job.name.clone(),
        folder: job.output.parent().unwrap_or(Path::new("")).to_owned(),
        ..Wanted::default()
    };
    let converted = materialx::convert(&document, &Disk, &wanted)?;
    console::diagnostics(&converted.warnings);
    if converted.materials.is_empty() {
        let file = job.file.display();
        return Err(Failure::Failed(format!(
            "nothing of {file} can be shown; the warnings say why"
        )));
    }
    let text = materialx::look_text(&converted);
    let output = job.output.display();
    let written = aside::create(&job.output, |file| file.write_all(text.as_bytes()));
    written.map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => Failure::Failed(format!(
            "{output} exists already; choose another name by -o, or remove the file first"
        )),
        _ => Failure::because(OutputError::new(&job.output, error)),
    })?;
    let (materials, nodes) = (converted.materials.len(), converted.nodes.len());
    let plural = |count: usize| if count == 1 { "" } else { "s" };
    console::note(&format!(
        "wrote {output}: {materials} material{}, {nodes} node{}",
        plural(materials),
        plural(nodes)
    ));
    Ok(())
}
