//! A picture by one device.

use std::sync::Arc;
use std::time::Instant;

use device::Device;
use engine::audit::{self, Audit};
use engine::film::{Film, Origin};
use engine::fingerprint::fingerprint;
use engine::procedural::Procedural;
use engine::renderer::{Progress, RenderSettings};
use engine::scene::view::View;
use engine::session::Session;
use engine::settings::{Beside, Method};
use engine::stats::{DeviceFacts, Stats};

use crate::accuracy::Accuracy;
use crate::failure::Failure;
use crate::job::RenderJob;
use crate::motion::{self, Sight};
use crate::progress::{Bar, Reached};
use crate::{cache, console, crash, interrupt};

use super::limits::{Limit, Look, Watch};
use super::reel::{Reel, View as Seen};
use super::{
    Ended, FAREWELL, Gathered, REFINEMENTS, REFINING, Rendered, Rest, adaptive, checkpoint,
    failure, is_as_wanted, mark, settings,
};

/// What is seen first, and what has rendered it before.
pub(super) enum Scene {
    /// Nothing has.
    New(Seen),
    /// This has rendered another picture of the same size and layers.
    Next(Seen, Box<Session>),
    /// This has rendered another piece of the same picture.
    Same(Box<Session>),
}

/// What a picture is taken of.
pub(super) struct Take<'a> {
    /// Ready for the first moment.
    pub(super) ready: Ready,
    /// All of them, as long as its shutter is open.
    pub(super) sights: &'a [Sight],
    /// Where they come from; `None` where there is no further one.
    pub(super) reel: Option<&'a mut Reel>,
    /// What the picture is rendered from, where that is known.
    pub(super) written: Option<Vec<(String, String)>>,
    /// It is a piece of a picture: then whoever renders all of them judges how right that is.
    pub(super) is_piece: bool,
}

/// What renders a picture, with all that it needs.
pub(super) struct Ready {
    pub(super) session: Box<Session>,
    /// Of kernels that have not run yet.
    marker: Option<crash::Marker>,
    is_new: bool,
    beside: Option<Arc<Beside>>,
    seconds: f64,
}

impl Ready {
    /// What renders, whose kernels have run.
    pub(super) fn into_session(self) -> Box<Session> {
        self.session
    }
}

/// Brings a scene to the device.
///
/// # Errors
/// What the device refuses.
pub(super) fn prepare(
    job: &RenderJob,
    scene: Scene,
    gpu: &Device,
    bar: &Bar,
) -> Result<Ready, Failure> {
    let clock = Instant::now();
    bar.follow(gpu);
    let is_new = matches!(scene, Scene::New(_));
    let mut marker = None;
    let mut found = None;
    let session = match scene {
        Scene::New(seen) => {
            let folder = cache::folder();
            marker = mark(
                &seen.opening.loaded().procedural,
                gpu,
                folder.as_deref(),
                bar,
            )?;
            found.clone_from(&seen.beside);
            let settings = settings(job, &seen.opening.loaded().camera, &seen.sight, seen.beside);
            // Nobody waits for a render that would begin anew on another device.
            let own = gpu.clone();
            let session = seen.opening.start(
                Arc::new(move || own.check().map(|()| own.clone())),
                Arc::new(move |camera| RenderSettings {
                    camera,
                    ..settings.clone()
                }),
            );
            Box::new(session.map_err(failure)?)
        }
        Scene::Next(seen, mut session) => {
            show_part(job, &mut session)?;
            found.clone_from(&seen.beside);
            let settings = settings(job, &seen.opening.loaded().camera, &seen.sight, seen.beside);
            session
                .show(seen.opening, &settings, false)
                .map_err(failure)?;
            session
        }
        Scene::Same(mut session) => {
            show_part(job, &mut session)?;
            session
        }
    };
    Ok(Ready {
        session,
        marker,
        is_new,
        beside: found,
        seconds: clock.elapsed().as_secs_f64(),
    })
}

/// Goes to the part of the picture that is to be rendered.
fn show_part(job: &RenderJob, session: &mut Session) -> Result<(), Failure> {
    let size = [job.width, job.height];
    let now = session.settings();
    if ([now.width, now.height], now.crop) == (size, job.crop) {
        return Ok(());
    }
    session.set_part(size, job.crop).map_err(failure)
}

/// Renders until all samples are there, or a signal comes.
///
/// # Errors
/// What the device refuses.
pub(super) fn render(
    job: &RenderJob,
    take: Take<'_>,
    gpu: &Device,
    view: &View,
    bar: &Bar,
    mut watch: Watch,
) -> Result<Rendered, Failure> {
    let clock = Instant::now();
    let Ready {
        mut session,
        mut marker,
        is_new,
        beside,
        seconds,
    } = take.ready;
    let mut settings_written = match take.written {
        Some(written) => written,
        None => written(
            job,
            session.scene(),
            session.procedural(),
            session.settings(),
        ),
    };
    if (job.stats || job.stats_json.is_some()) && !session.is_timing() {
        session.time_passes().map_err(failure)?;
    }
    let name = gpu.description().name.clone();
    let names = job.layers.names(session.scene());
    let mut writer = None;
    let mut refined = 0;
    if let Some(checkpoints) = &job.checkpoints {
        let mut origin = Origin::new(
            &name,
            &job.scene,
            job.look.as_deref(),
            settings_written.clone(),
        );
        origin.names.clone_from(&names);
        let former = match checkpoints.resumes {
            true => checkpoint::read(
                checkpoints,
                &origin,
                session.settings(),
                session.paths_per_sample(),
                job,
            )?,
            false => None,
        };
        if let Some(former) = former {
            refined = former.refined;
            for _ in 0..refined {
                session.refine();
            }
            session
                .resume(&former.film, former.paths)
                .map_err(failure)?;
        }
        let mut begun = checkpoint::Writer::new(checkpoints, job, *view, origin);
        begun.tell_refined(refined);
        writer = Some(begun);
    }
    let resumed_at = session.paths_done();
    let prepare_seconds = seconds + clock.elapsed().as_secs_f64();

    let clock = Instant::now();
    let first = || {
        // Some drivers compile a kernel when it runs for the first time.
        drop(marker.take());
        interrupt::has_results();
        if is_new {
            // A cache that can't be written costs time at the next start, nothing else.
            let _ = gpu.save_cache();
        }
    };
    let samples = job.first_sample..job.first_sample + job.spp.get();
    let moments = take.sights.len() as u32;
    let ends = motion::shares(moments, job.whole_spp, &samples);
    let ends_of_all = motion::shares(moments, job.whole_spp, &(0..job.whole_spp));
    let mut exposure = Exposure {
        job,
        bar,
        watch: &mut watch,
        writer: writer.as_mut(),
        after_first: Some(first),
        between: None,
    };
    let mut shutter = Shutter {
        job,
        sights: take.sights,
        reel: take.reel,
        beside,
    };
    let is_film_wanted = !job.outputs.films.is_empty();
    let (done, audit) = loop {
        let mut ended = None;
        if job.adaptive {
            ended = exposure.distribute(&mut session)?;
        }
        for (number, &end) in ends.iter().enumerate().filter(|_| !job.adaptive) {
            if session.paths_done() >= u64::from(end) * session.paths_per_sample() {
                continue; // a part of the samples, or a film that goes on, has no more of this moment
            }
            if let Some(before) = number.checked_sub(1) {
                shutter.show(&mut session, number, ends_of_all[before], refined)?;
            }
            ended = exposure.accumulate(&mut session, end)?;
            if ended.is_some() {
                break;
            }
        }
        if !is_as_wanted(ended.as_ref()) {
            interrupt::writes_results();
        }
        let mut film = session.snapshot().map_err(failure)?.film;
        // A picture may be of what goes ahead of it, but not what others go on with.
        let is_preview = ended.is_some() && session.is_preview();
        if is_film_wanted && is_preview {
            film = Film::with_layers(job.width, job.height, job.layers.clone());
        } else if ended.is_some() && is_film_wanted && !job.adaptive {
            let (_, most) = film.sample_bounds();
            complete_sample(&mut session, most)?;
            film = session.snapshot().map_err(failure)?.film;
        }
        let done = Done {
            paths: paths_of(job, &film, &session),
            stats: session.stats().map_err(failure)?,
            film,
            ended,
            is_preview,
            is_awaited: session.records_awaited().is_some(),
        };
        let is_judged = job.method != Method::Path && shutter.is_judged() && !take.is_piece;
        let audit = match is_judged && is_as_wanted(done.ended.as_ref()) {
            true => {
                bar.stage("looking how right the picture is");
                let truth = shutter.truth(&mut session)?;
                truth.and_then(|truth| Audit::new(&done.film, truth.each_ref()))
            }
            false => None,
        };
        let is_wrong = audit.as_ref().is_some_and(Audit::is_wrong);
        if !is_wrong || job.accuracy != Some(Accuracy::Final) || refined == REFINEMENTS {
            break (done, audit);
        }
        refined += 1;
        bar.stage(REFINING);
        match shutter.is_still() {
            true => session.refine(),
            false => shutter.show(&mut session, 0, 0, refined)?,
        }
        exposure.watch.begin_anew();
        if let Some(writer) = exposure.writer.as_mut() {
            writer.tell_refined(refined);
        }
    };
    checkpoint::tell_refined(&mut settings_written, refined);
    interrupt::writes_results();
    let Done {
        film,
        paths,
        stats,
        ended,
        is_preview,
        is_awaited,
    } = done;
    // A frame that was interrupted isn't written, not even its film: what there is of it is here.
    let is_dropped = job.motion.is_sequence() && matches!(ended, Some(Ended::Interrupted));
    let is_written = is_film_wanted && !is_dropped;
    let between = exposure.between.take().filter(|_| writer.is_some());
    let mut kept = between.map(|film| {
        let paths = adaptive::paths(&film, &session);
        (film, paths)
    });
    if let (Some(writer), false) = (&mut writer, is_written || is_preview) {
        let (film, paths) = kept.take().unwrap_or_else(|| (film.clone(), paths));
        writer.write(film, paths);
        writer.finish();
    }
    drop(writer);
    if ended.is_some() && is_awaited && resumed_at > 0 && paths == resumed_at {
        bar.suspend(|| {
            console::warning(
                "nothing was added: the resumed picture had to find out about the light anew, which was not done in time",
            );
        });
    }
    let render_seconds = clock.elapsed().as_secs_f64();
    let (_, most) = film.sample_bounds();
    Ok(Rendered {
        gathered: Gathered::Whole(film),
        samples: job.first_sample..job.first_sample + most,
        names,
        paths: Some(paths),
        kept,
        ended,
        is_preview: is_preview && most > 0,
        device: name,
        facts: DeviceFacts::new(gpu.description()),
        shares: Vec::new(),
        settings: settings_written,
        audit,
        stats,
        prepare_seconds,
        render_seconds,
        rest: Rest::Alone(session),
    })
}

/// What the samples of a picture are made from, as its files tell it.
pub(super) fn written(
    job: &RenderJob,
    scene: &engine::scene::Scene,
    procedural: &Procedural,
    settings: &RenderSettings,
) -> Vec<(String, String)> {
    let mut written = fingerprint(scene, procedural, settings);
    written.extend(job.motion.written(job.whole_spp));
    written
}

/// A picture that is done, as well as that went.
struct Done {
    film: Film,
    /// How far it is.
    paths: u64,
    stats: Stats,
    ended: Option<Ended>,
    /// It is of what goes ahead of the picture.
    is_preview: bool,
    /// It waited for what is found out about the light.
    is_awaited: bool,
}

/// Two pictures of a few paths each, to compare a biased one with. That one is gone from the device after that.
///
/// # Errors
/// What the device refuses.
pub(super) fn truth(session: &mut Session) -> Result<[Film; 2], Failure> {
    let mut paths = |seed| session.trace_apart(seed, audit::SAMPLES).map_err(failure);
    Ok([paths(1)?, paths(2)?])
}

/// The moments at which a picture is taken.
struct Shutter<'a> {
    job: &'a RenderJob,
    sights: &'a [Sight],
    /// Where further ones come from.
    reel: Option<&'a mut Reel>,
    beside: Option<Arc<Beside>>,
}

impl Shutter<'_> {
    /// There is but one.
    fn is_still(&self) -> bool {
        self.sights.len() == 1
    }

    /// Whether paths can tell what is wrong with the picture.
    fn is_judged(&self) -> bool {
        let job = self.job;
        let is_whole = (job.first_sample, job.spp.get()) == (0, job.whole_spp);
        self.is_still() || is_whole && job.motion.has_equal_halves(job.whole_spp)
    }

    /// Shows the scene at one of the moments, which has the samples after so many. At the first one the picture begins anew.
    fn show(
        &mut self,
        session: &mut Session,
        moment: usize,
        samples: u32,
        refined: u32,
    ) -> Result<(), Failure> {
        let Some(reel) = self.reel.as_deref_mut() else {
            return Ok(()); // it is the only one
        };
        let Seen { opening, sight, .. } = reel.at(&self.sights[moment])?;
        let camera = &opening.loaded().camera;
        let settings = RenderSettings {
            moment_since: samples,
            refinement: refined,
            ..settings(self.job, camera, &sight, self.beside.clone())
        };
        (session.show(opening, &settings, moment > 0)).map_err(failure)
    }

    /// As [`truth`], of all moments; `None` if a signal comes meanwhile. The last one is shown after that.
    fn truth(&mut self, session: &mut Session) -> Result<Option<[Film; 2]>, Failure> {
        if self.is_still() {
            return truth(session).map(Some);
        }
        // As many of each one.
        let samples = audit::SAMPLES.div_ceil(self.sights.len() as u32);
        let mut films: Option<[Film; 2]> = None;
        for moment in 0..self.sights.len() {
            if interrupt::requested() {
                return Ok(None);
            }
            self.show(session, moment, 0, 0)?;
            let mut paths = |film| {
                let seed = 2 * moment as u32 + film;
                session.trace_apart(seed, samples).map_err(failure)
            };
            let further = [paths(1)?, paths(2)?];
            match &mut films {
                None => films = Some(further),
                Some(films) => films.iter_mut().zip(&further).for_each(|(a, b)| a.add(b)),
            }
        }
        Ok(films)
    }
}

/// How far a film is that may be gone on with.
fn paths_of(job: &RenderJob, film: &Film, session: &Session) -> u64 {
    match job.adaptive {
        true => adaptive::paths(film, session),
        false => session.paths_done(),
    }
}

/// A picture while it is rendered.
pub(super) struct Exposure<'a, 'w, F> {
    pub(super) job: &'a RenderJob,
    pub(super) bar: &'a Bar,
    pub(super) watch: &'a mut Watch,
    pub(super) writer: Option<&'a mut checkpoint::Writer<'w>>,
    /// What is to be done after the first wave.
    after_first: Option<F>,
    /// The film as it was before the round in which an adaptive picture has ended, from which that is decided anew when it goes on.
    pub(super) between: Option<Film>,
}

impl<F: FnOnce()> Exposure<'_, '_, F> {
    /// A wave is done, perhaps the first one.
    pub(super) fn first_is_done(&mut self) {
        if let Some(after_first) = self.after_first.take() {
            after_first();
        }
    }

    /// The limit that a picture which is gone on with has reached already: it would have more samples each time.
    fn is_enough(&mut self, session: &mut Session) -> Result<Option<Limit>, Failure> {
        let limits = &self.job.limits;
        let has_limit = limits.noise.is_some() || limits.flip.is_some();
        if !has_limit || session.paths_done() == 0 || session.records_awaited().is_some() {
            return Ok(None);
        }
        let film = session.snapshot().map_err(failure)?.film;
        let samples = f64::from(film.sample_bounds().0);
        self.watch
            .reached::<Failure>(samples, |look| Ok(Some(look.at(&film))))
    }

    /// Renders wave by wave until `end` samples are taken, or for as long as nothing ends it before.
    fn accumulate(&mut self, session: &mut Session, end: u32) -> Result<Option<Ended>, Failure> {
        let (job, spp) = (self.job, self.job.spp.get());
        let pixels = f64::from(job.width) * f64::from(job.height);
        if let Some(limit) = self.is_enough(session)? {
            return Ok(Some(Ended::Enough(limit)));
        }
        loop {
            let step = session.step(end).map_err(failure)?;
            self.first_is_done();
            let progress = Progress {
                samples_total: u64::from(spp) * u64::from(job.width) * u64::from(job.height),
                ..step
            };
            if step.is_done() {
                self.bar.update(&Reached::of(&progress, spp), spp);
                return Ok(None);
            }
            if interrupt::requested() {
                return Ok(Some(Ended::Interrupted));
            }
            let samples = progress.samples_done as f64 / pixels;
            // Neither error nor time ends a picture before all of it is there, if only as what goes ahead of it.
            let is_ahead = session.records_awaited().is_some();
            let noise = |look: &Look| {
                let film = session.snapshot().map_err(failure)?.film;
                Ok(Some(look.at(&film)))
            };
            if (samples >= 1.0 || is_ahead)
                && let Some(limit) = self.watch.reached::<Failure>(samples, noise)?
            {
                return Ok(Some(Ended::Enough(limit)));
            }
            match session.records_awaited() {
                Some(records) => awaits(self.bar, records),
                None => self
                    .bar
                    .update(&self.watch.reached_so_far(&progress, samples), spp),
            }
            // What goes ahead of the picture is no part of it.
            if let Some(writer) = self.writer.as_mut()
                && !session.is_preview()
                && writer.is_due()
            {
                writer.write(
                    session.snapshot().map_err(failure)?.film,
                    session.paths_done(),
                );
            }
        }
    }
}

/// Says what a picture waits for, that needs to know the light and of which so many records are there.
pub(super) fn awaits(bar: &Bar, records: usize) {
    bar.go_on(match records {
        0 => "finding out about the light".to_owned(),
        _ => format!("making records of irradiance, {records} so far"),
    });
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
