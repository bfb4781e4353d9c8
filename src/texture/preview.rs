//! `patina texture preview`: a texture on three objects, rendered within a few seconds.

use std::time::{Duration, Instant};

use engine::gpu::Gpu;
use engine::isolated::Subject;
use engine::preview::Preview;
use engine::scene::look::Look;

use crate::console;
use crate::exit::Failure;
use crate::output::{self, Picture};
use crate::progress::Bar;

use super::job::PreviewJob;

/// Samples per pixel, where the time suffices.
const MAX_SPP: u32 = 64;
/// Samples per pixel, whatever time they take.
const MIN_SPP: u32 = 2;
/// From the start until no further samples are taken: writing the picture takes the rest of five seconds.
const PATIENCE: Duration = Duration::from_millis(3800);

/// Renders and writes the picture.
///
/// # Errors
/// Mistakes in the texture or its arguments; no device; the picture can't be written.
pub(crate) fn run(job: &PreviewJob) -> Result<(), Failure> {
    let start = Instant::now();
    output::check(&job.output.path).map_err(Failure::because)?;
    let target = &job.target;
    let sources = super::sources(&target.texture_dirs, target.look.as_deref())?;
    let look = target.look.as_deref().map(Look::load).transpose()?;
    let subject = match &look {
        Some(look) => Subject::Node(&target.name, look),
        None => Subject::Texture(&target.name),
    };
    let mut preview = Preview::new(subject, &sources, job.range)?;
    console::diagnostics(preview.warnings());
    for (parameter, value) in &target.sets {
        preview.set(parameter, value).map_err(Failure::because)?;
    }

    let mut bar = Bar::new("preparing the device");
    let gpu = Gpu::new(&target.device).map_err(Failure::because)?;
    let mut renderer = preview.renderer(&gpu, job.size).map_err(Failure::because)?;
    loop {
        let progress = renderer.step(MAX_SPP).map_err(Failure::because)?;
        bar.update(&progress);
        let spp = progress.samples_done * u64::from(MAX_SPP) / progress.samples_total.max(1);
        if progress.is_done() || (spp >= u64::from(MIN_SPP) && start.elapsed() > PATIENCE) {
            break;
        }
    }
    let film = renderer.film().map_err(Failure::because)?;
    bar.finish();

    let picture = Picture {
        width: film.width,
        height: film.height,
        rgb: film.mean(),
        facts: Vec::new(),
    };
    output::write(&job.output, &picture, 0.0).map_err(Failure::because)?;
    console::print(&format!("wrote {}", job.output.path.display()));
    Ok(())
}
