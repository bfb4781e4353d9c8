//! Frames: one picture after the other, by what has rendered the one before.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use device::Device;
use engine::session::Session;

use crate::failure::Failure;
use crate::job::RenderJob;
use crate::motion::{Frame, numbered};
use crate::progress::Bar;
use crate::usage::UsageError;
use crate::{console, denoise, devices, interrupt, output};

use super::alone::Scene;
use super::pieces::{self, Division};
use super::reel::Reel;
use super::{
    Ended, Rest, Start, Told, beside, check, end, inputs, missed, spare_inputs, view_of, write,
    written,
};

/// Renders all frames.
///
/// # Errors
/// The first frame that can't be rendered or written; a signal.
pub(super) fn run(job: &RenderJob) -> Result<(), Failure> {
    let denoiser = denoise::for_job(job.denoise, &job.outputs)?;
    let frames = job.motion.frames();
    let resumes = (job.checkpoints.as_ref()).is_some_and(|checkpoints| checkpoints.resumes);
    let all = frames.iter().map(|&frame| job.of_frame(frame));
    let due = all.filter(|own| !(resumes && is_done(own)));
    spare_inputs(job, due.flat_map(|own| written(&own)))?;
    let mut studio: Option<(Device, Reel)> = None;
    let mut session: Option<Box<Session>> = None;
    // What suffices for a frame suffices for the next one.
    let mut division: Option<Option<Division>> = None;
    let mut told = HashSet::new();
    let mut skipped = 0;
    for &frame in &frames {
        let mut own = job.of_frame(frame);
        if resumes && is_done(&own) {
            skipped += 1;
            continue;
        }
        if !resumes {
            spare_others(&mut own);
        }
        let clock = Instant::now();
        let number = frame.number.unwrap_or(0);
        let written = written(&own);
        check(&own, &written)?;
        let bar = Bar::read_by(job.progress, &format!("loading frame {number}"));
        let (device, reel) = match &mut studio {
            Some(studio) => studio,
            None => {
                let reel = Reel::open(job, inputs(job)?)?;
                let devices = devices::open(&job.devices, &bar)?;
                let Ok([device]) = <[Device; 1]>::try_from(devices) else {
                    let flag = "--frames";
                    return Err(UsageError::OneDevice { flag }.into());
                };
                studio.insert((device, reel))
            }
        };
        let sights = job.motion.sights(frame);
        let beside = beside(job, reel, frame)?;
        let mut first = reel.at(&sights[0])?;
        first.beside = beside;
        let warnings = &first.opening.loaded().warnings;
        let warnings = job.overrides.told(job.look.as_deref(), warnings);
        let news = warnings
            .iter()
            .filter(|warning| told.insert(warning.render()));
        let news = news.cloned().collect();
        bar.suspend(|| console::diagnostics(&news));
        let asked = own;
        let own = asked.for_scene(&first.opening.loaded().scene);
        let news = missed(&asked, &own).filter(|warning| told.insert((*warning).to_owned()));
        if let Some(warning) = news {
            bar.suspend(|| console::warning(warning));
        }
        output::check_all(&written, &first.opening.files())?;
        let view = view_of(job, &first);
        let says = Told::new(&own, &first.opening.loaded().scene, clock);
        bar.stage(&format!("preparing frame {number}"));
        let division = match division {
            Some(division) => division,
            None => *division.insert(pieces::plan(&own, &first, device, &bar)?),
        };
        let start = Start {
            scene: match session.take() {
                Some(session) => Scene::Next(first, session),
                None => Scene::New(first),
            },
            sights: &sights,
            reel: Some(reel),
            clock,
        };
        let rendered = start.render(&own, division, device, &view, &bar)?;
        bar.finish();
        if let Some(Ended::Interrupted) = rendered.ended {
            // Whoever looks for a frame's file takes it for whole; what there is of it is in its checkpoint.
            console::warning(&format!(
                "interrupted in frame {number}, which isn't written; those before it are"
            ));
            end(rendered.rest);
            return Err(Failure::Interrupted);
        }
        let (outcome, rest) = write(&own, rendered, &view, denoiser.as_ref(), &says);
        outcome?;
        if let Some(path) = kept(&own) {
            // One that can't be taken away is in nobody's way.
            let _ = fs::remove_file(path);
        }
        if let Rest::Alone(used) = rest {
            session = Some(used);
        }
        if interrupt::requested() {
            return Err(Failure::Interrupted);
        }
        interrupt::goes_on();
    }
    if skipped > 0 {
        let all = frames.len();
        let were = if skipped == 1 { "was" } else { "were" };
        console::note(&format!("{skipped} of {all} frames {were} there already"));
    }
    Ok(())
}

/// Whether all files of a frame are there, of which pictures are written last. Where only films are written, each is gone on with.
fn is_done(job: &RenderJob) -> bool {
    let outputs = &job.outputs;
    let mut files =
        (outputs.films.iter()).chain(outputs.pictures.iter().map(|picture| &picture.path));
    !outputs.pictures.is_empty() && files.all(|path| path.exists())
}

/// What is kept of a frame only while it is under way: nobody has asked for it.
fn kept(job: &RenderJob) -> Option<&PathBuf> {
    let path = job.checkpoints.as_ref().map(|kept| &kept.path)?;
    (!job.outputs.films.contains(path)).then_some(path)
}

/// Leaves a film alone that an earlier render has written and that isn't gone on with: the frame has no checkpoint then, for that would
/// take its place, and be taken away when the frame is done.
fn spare_others(job: &mut RenderJob) {
    if let Some(path) = kept(job)
        && path.exists()
    {
        console::warning(&format!(
            "{} is there already and isn't gone on with, so that this frame has no checkpoint: say --resume, or take it away",
            path.display()
        ));
        job.checkpoints = None;
    }
}

impl RenderJob {
    /// The same for one frame.
    fn of_frame(&self, frame: Frame) -> Self {
        match frame.number {
            Some(number) => self.renamed(|path: &Path| numbered(path, number)),
            None => self.clone(),
        }
    }
}
