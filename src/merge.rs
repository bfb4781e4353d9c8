//! `patina merge`: adds films of parts of a picture's samples and writes the picture they make.

use std::ops::Range;
use std::path::PathBuf;

use engine::film::write::TRANSPARENCY;
use engine::film::{Part, PartError};
use engine::scene::look::Look;
use engine::scene::view::ViewChoice;

use crate::failure::Failure;
use crate::job::MergeJob;
use crate::output::{self, Results};
use crate::{console, denoise, form, interrupt, picture};

/// Reads one film after the other, so that memory holds two at most, and writes their sum.
///
/// # Errors
/// A film can't be read, films don't belong together, or a result can't be written.
pub(crate) fn run(job: &MergeJob) -> Result<(), Failure> {
    let written: Vec<PathBuf> = job.outputs.paths().cloned().collect();
    let inputs: Vec<PathBuf> = job.parts.iter().chain(&job.look).cloned().collect();
    output::check_all(&written, &inputs)?;
    let look = job.look.as_deref().map(Look::load).transpose()?;
    let look_view = look.map_or_else(ViewChoice::default, |look| look.view);
    let view = job.display.or(look_view).view();
    let denoiser = denoise::for_job(job.denoise, &job.outputs)?;
    let mut merged: Option<Part> = None;
    for path in &job.parts {
        let refused = |error: PartError| Failure::Failed(format!("{}: {error}", path.display()));
        let part = picture::film(path).map_err(refused)?;
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
    if let Some(expected) = &job.expected {
        expect(&merged, expected).map_err(Failure::Failed)?;
    }
    // From here on it is a matter of moments.
    interrupt::writes_results();
    console::note(&format!(
        "samples {}: {} per pixel",
        ranges.join(", "),
        console::grouped(u64::from(merged.film.sample_bounds().0))
    ));
    let lacks = |name: &&&str| !merged.film.layers().iter().any(|l| l.name == **name);
    if let (true, Some(name)) = (job.transparent, TRANSPARENCY.iter().find(lacks)) {
        return Err(Failure::Failed(format!(
            "--transparent: the parts have no layer `{name}`: render them with --transparent"
        )));
    }
    job.form
        .check(merged.film.layers())
        .map_err(|error| form::refused("--exr-compression", &error))?;
    let mut results = Results {
        part: &merged,
        kept: None,
        layers: merged.film.layers(),
        denoised: None,
        transparent: job.transparent,
        form: &job.form,
        view: &view,
        is_frame: false,
    };
    let denoised = (denoiser.as_ref())
        .map(|denoiser| denoise::film(denoiser, &results.content()).map_err(Failure::because))
        .transpose()?;
    results.denoised = denoised.as_ref();
    output::write_all(&job.outputs, &results)
}

/// Whether a film has exactly these samples; else what is missing, or too much.
fn expect(part: &Part, expected: &Range<u32>) -> Result<(), String> {
    let (mut missing, mut at) = (Vec::new(), expected.start);
    for range in part.ranges() {
        if range.start < expected.start || range.end > expected.end {
            let (start, end) = (range.start, range.end);
            return Err(format!(
                "--expect {}..{}: there are samples {start}..{end}",
                expected.start, expected.end
            ));
        }
        if at < range.start {
            missing.push(format!("{at}..{}", range.start));
        }
        at = range.end;
    }
    if at < expected.end {
        missing.push(format!("{at}..{}", expected.end));
    }
    let because = match (missing.is_empty(), part.is_even()) {
        (true, true) => return Ok(()),
        (true, false) => "a part was ended early, and lacks samples of some pixels".to_owned(),
        (false, _) => format!("samples {} are missing", missing.join(", ")),
    };
    Err(format!(
        "--expect {}..{}: {because}; nothing was written",
        expected.start, expected.end
    ))
}
