//! `patina merge`: adds films of parts of a picture's samples and writes the picture they make.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use engine::film::{Part, PartError};
use engine::input;

use crate::failure::Failure;
use crate::job::MergeJob;
use crate::{console, interrupt, output};

/// Reads one film after the other, so that memory holds two at most, and writes their sum.
///
/// # Errors
/// A film can't be read, films don't belong together, or a result can't be written.
pub(crate) fn run(job: &MergeJob) -> Result<(), Failure> {
    let written: Vec<PathBuf> = job.outputs.paths().cloned().collect();
    output::check_all(&written, &job.parts)?;
    let mut merged: Option<Part> = None;
    for path in &job.parts {
        let refused = |error: PartError| Failure::Failed(format!("{}: {error}", path.display()));
        let part = read(path).map_err(refused)?;
        match &mut merged {
            Some(merged) => {
                if part.origin.device != merged.origin.device {
                    console::warning(&format!(
                        "{} was rendered on {}, the partial renders before it on {}: the picture is right, but not to the last bit \
                         that of one device",
                        path.display(),
                        part.origin.device,
                        merged.origin.device
                    ));
                }
                merged.merge(&part).map_err(refused)?;
            }
            None => merged = Some(part),
        }
    }
    let Some(merged) = merged else {
        return Ok(()); // the command line has at least one
    };
    let ranges: Vec<_> = merged
        .ranges()
        .iter()
        .map(|range| format!("{}..{}", range.start, range.end))
        .collect();
    // From here on it is a matter of moments.
    interrupt::writes_results();
    console::note(&format!(
        "samples {}: {} per pixel",
        ranges.join(", "),
        console::grouped(u64::from(merged.film.sample_bounds().0))
    ));
    output::write_all(&job.outputs, &merged, job.exposure)
}

fn read(path: &Path) -> Result<Part, PartError> {
    let (file, length) = input::open(path)?;
    Part::read(&mut BufReader::new(file), length)
}
