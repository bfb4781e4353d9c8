//! A picture by one device.

use std::sync::Arc;
use std::time::Instant;

use device::Device;
use engine::film::Origin;
use engine::fingerprint::fingerprint;
use engine::renderer::RenderSettings;
use engine::scene::view::View;
use engine::session::{Opening, Session};
use engine::stats::DeviceFacts;

use crate::failure::Failure;
use crate::job::RenderJob;
use crate::progress::Bar;
use crate::{cache, interrupt};

use super::limits::Watch;
use super::{Ended, FAREWELL, Rendered, Rest, checkpoint, failure, mark, settings};

/// Renders until all samples are there, or a signal comes.
///
/// # Errors
/// What the device refuses.
pub(super) fn render(
    job: &RenderJob,
    opening: Opening,
    gpu: &Device,
    view: &View,
    bar: &Bar,
    mut watch: Watch,
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
    let name = gpu.description().name.clone();
    let names = job.layers.names(session.scene());
    let mut writer = None;
    if let Some(checkpoints) = &job.checkpoints {
        let mut origin = Origin::new(
            &name,
            &job.scene,
            job.look.as_deref(),
            settings_written.clone(),
        );
        origin.names.clone_from(&names);
        if checkpoints.resumes
            && let Some((film, paths)) = checkpoint::read(
                checkpoints,
                &origin,
                session.settings(),
                session.paths_per_sample(),
            )?
        {
            session.resume(&film, paths).map_err(failure)?;
        }
        writer = Some(checkpoint::Writer::new(checkpoints, job, *view, origin));
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
    let ended = accumulate(&mut session, job, bar, first, &mut watch, writer.as_mut())?;
    let mut film = session.snapshot().map_err(failure)?.film;
    interrupt::writes_results();
    let is_film_wanted = !job.outputs.films.is_empty();
    if let (Some(writer), false) = (&mut writer, is_film_wanted) {
        writer.write(film.clone(), session.paths_done());
        writer.finish();
    }
    drop(writer);
    if ended.is_some() && is_film_wanted {
        let (_, most) = film.sample_bounds();
        complete_sample(&mut session, most)?;
        film = session.snapshot().map_err(failure)?.film;
    }
    let render_seconds = clock.elapsed().as_secs_f64();
    let (_, most) = film.sample_bounds();
    Ok(Rendered {
        film,
        samples: job.first_sample..job.first_sample + most,
        names,
        paths: Some(session.paths_done()),
        ended,
        device: name,
        facts: DeviceFacts::new(gpu.description()),
        shares: Vec::new(),
        settings: settings_written,
        stats: session.stats().map_err(failure)?,
        prepare_seconds,
        render_seconds,
        rest: Rest::Alone(Box::new(session)),
    })
}

/// Renders wave by wave, with something to do after the first, until all samples are taken, or for as long as nothing ends it before.
fn accumulate(
    session: &mut Session,
    job: &RenderJob,
    bar: &Bar,
    after_first: impl FnOnce(),
    watch: &mut Watch,
    mut writer: Option<&mut checkpoint::Writer<'_>>,
) -> Result<Option<Ended>, Failure> {
    let spp = job.spp.get();
    let pixels = f64::from(job.width) * f64::from(job.height);
    let mut after_first = Some(after_first);
    loop {
        let progress = session.step(spp).map_err(failure)?;
        if let Some(after_first) = after_first.take() {
            after_first();
        }
        if progress.samples_done >= progress.samples_total {
            bar.update(&progress, spp);
            return Ok(None);
        }
        if interrupt::requested() {
            return Ok(Some(Ended::Interrupted));
        }
        let samples = progress.samples_done as f64 / pixels;
        let error = || {
            Ok(Some(
                session.snapshot().map_err(failure)?.film.relative_error(),
            ))
        };
        if let Some(limit) = watch.reached::<Failure>(samples, error)? {
            return Ok(Some(Ended::Enough(limit)));
        }
        bar.update(&watch.progress(&progress, samples), spp);
        if let Some(writer) = writer.as_mut().filter(|writer| writer.is_due()) {
            writer.write(
                session.snapshot().map_err(failure)?.film,
                session.paths_done(),
            );
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
