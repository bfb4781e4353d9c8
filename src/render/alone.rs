//! A picture by one device.

use std::sync::Arc;
use std::time::Instant;

use device::Device;
use engine::fingerprint::fingerprint;
use engine::renderer::RenderSettings;
use engine::session::{Opening, Session};
use engine::stats::DeviceFacts;

use crate::failure::Failure;
use crate::job::RenderJob;
use crate::progress::Bar;
use crate::{cache, interrupt};

use super::{Ended, FAREWELL, Rendered, Rest, failure, mark, settings};

/// Renders until all samples are there, or a signal comes.
///
/// # Errors
/// What the device refuses.
pub(super) fn render(
    job: &RenderJob,
    opening: Opening,
    gpu: &Device,
    bar: &Bar,
) -> Result<Rendered, Failure> {
    let clock = Instant::now();
    bar.follow(gpu);
    let mut marker = mark(
        &opening.loaded().procedural,
        gpu,
        cache::folder().as_deref(),
        bar,
    )?;
    // Nobody waits for a render that would begin anew on another device.
    let (own, settings) = (gpu.clone(), settings(job, &opening.loaded().camera));
    let mut session = opening
        .start(
            Arc::new(move || own.check().map(|()| own.clone())),
            Arc::new(move |camera| RenderSettings {
                camera,
                ..settings.clone()
            }),
        )
        .map_err(failure)?;
    let settings_written = fingerprint(session.scene(), session.procedural(), session.settings());
    if job.stats || job.stats_json.is_some() {
        session.time_passes().map_err(failure)?;
    }
    let prepare_seconds = clock.elapsed().as_secs_f64();

    let clock = Instant::now();
    let first = || {
        // Some drivers compile a kernel when it runs for the first time.
        drop(marker.take());
        interrupt::has_results();
        // A cache that can't be written costs time at the next start, nothing else.
        let _ = gpu.save_cache();
    };
    let complete = accumulate(&mut session, job.spp.get(), bar, first)?;
    let mut film = session.snapshot().map_err(failure)?.film;
    interrupt::writes_results();
    if !complete && !job.outputs.films.is_empty() {
        let (_, most) = film.sample_bounds();
        complete_sample(&mut session, most)?;
        film = session.snapshot().map_err(failure)?.film;
    }
    let render_seconds = clock.elapsed().as_secs_f64();
    let (_, most) = film.sample_bounds();
    Ok(Rendered {
        film,
        samples: job.first_sample..job.first_sample + most,
        ended: (!complete).then_some(Ended::Interrupted),
        device: gpu.description().name.clone(),
        facts: DeviceFacts::new(gpu.description()),
        shares: Vec::new(),
        settings: settings_written,
        stats: session.stats().map_err(failure)?,
        prepare_seconds,
        render_seconds,
        rest: Rest::Alone(Box::new(session)),
    })
}

/// Renders wave by wave, with something to do after the first; returns whether all samples were taken before the user asked to stop.
fn accumulate(
    session: &mut Session,
    spp: u32,
    bar: &Bar,
    after_first: impl FnOnce(),
) -> Result<bool, Failure> {
    let mut after_first = Some(after_first);
    loop {
        let progress = session.step(spp).map_err(failure)?;
        if let Some(after_first) = after_first.take() {
            after_first();
        }
        bar.update(&progress, spp);
        if progress.samples_done >= progress.samples_total {
            return Ok(true);
        }
        if interrupt::requested() {
            return Ok(false);
        }
    }
}

/// Gives all pixels the same samples, as a film that is to be merged should have: if that is a matter of moments, because
/// whoever ends a render doesn't wait for long.
fn complete_sample(session: &mut Session, spp: u32) -> Result<(), Failure> {
    let clock = Instant::now();
    while clock.elapsed() < FAREWELL {
        if session.step(spp).map_err(failure)?.is_done() {
            break;
        }
    }
    Ok(())
}
