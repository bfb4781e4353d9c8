//! `patina texture preview`: a texture on three objects, rendered within a second.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use device::Device;
use engine::isolated::Subject;
use engine::preview::Preview;
use engine::scene::look::Look;
use engine::scene::view::View;

use crate::failure::Failure;
use crate::output;
use crate::progress::Bar;
use crate::{console, interrupt};

use super::job::PreviewJob;

/// Samples per pixel, where the time suffices.
const MAX_SPP: u32 = 64;
/// Samples per pixel, whatever time they take.
const MIN_SPP: u32 = 2;
/// From the start until no further samples are taken: writing the picture takes the rest of a second.
const PATIENCE: Duration = Duration::from_millis(900);
/// The same where compiling alone takes seconds: the rest of five.
const MORE_PATIENCE: Duration = Duration::from_millis(3800);

/// Renders and writes the picture.
///
/// # Errors
/// Mistakes in the texture or its arguments; no device; the picture can't be written.
pub(crate) fn run(job: &PreviewJob) -> Result<(), Failure> {
    let start = Instant::now();
    let target = &job.target;
    let written = [job.output.path.clone()];
    let named: Vec<PathBuf> = target.look.iter().cloned().collect();
    output::check_all(&written, &named)?;
    let sources = super::sources(&target.texture_dirs, target.look.as_deref())?;
    let look = target.look.as_deref().map(Look::load).transpose()?;
    let subject = match &look {
        Some(look) => Subject::Node(&target.name, look),
        None => Subject::Texture(&target.name),
    };
    let mut read = match &look {
        Some(look) => engine::load::files(Path::new(""), Some(look)),
        None => Vec::new(),
    };
    // An argument may be an image.
    let values = target.sets.iter().map(|(_, value)| value.trim_matches('"'));
    read.extend(values.map(PathBuf::from));
    output::check_all(&written, &read)?;
    let mut preview = Preview::new(subject, &sources, job.range)?;
    console::diagnostics(preview.warnings());
    for (parameter, value) in &target.sets {
        preview.set(parameter, value).map_err(Failure::because)?;
    }

    let bar = Bar::new("preparing the device");
    let device = Device::open(&target.device).map_err(Failure::because)?;
    bar.follow(&device);
    let mut renderer = preview
        .renderer(&device, job.size)
        .map_err(Failure::because)?;
    let patience = match device.traits().compiles_slowly {
        true => MORE_PATIENCE,
        false => PATIENCE,
    };
    renderer.set_longest_wave(patience / 8);
    let mut is_complete = true;
    loop {
        let progress = renderer.step(MAX_SPP).map_err(Failure::because)?;
        bar.update(&progress, MAX_SPP);
        interrupt::has_results();
        let spp = progress.samples_done * u64::from(MAX_SPP) / progress.samples_total.max(1);
        if interrupt::requested() {
            is_complete = false;
            break;
        }
        if progress.is_done() || (spp >= u64::from(MIN_SPP) && start.elapsed() > patience) {
            break;
        }
    }
    let film = renderer.film().map_err(Failure::because)?;
    interrupt::writes_results();
    bar.finish();

    output::write(&job.output, &film, None, &View::default()).map_err(Failure::because)?;
    console::note(&format!("wrote {}", job.output.path.display()));
    match is_complete {
        true => Ok(()),
        false => Err(Failure::Interrupted),
    }
}
