//! A render under way as a file, so that an hour's work isn't lost with the process: the film with how far it is, written aside and
//! renamed while rendering goes on.

use std::thread::JoinHandle;
use std::time::Instant;

use engine::adaptive::GRAIN;
use engine::film::write::{Content, Form};
use engine::film::{Film, Layers, Origin, Part, PartError};
use engine::fingerprint::REFINEMENT;
use engine::renderer::RenderSettings;
use engine::scene::view::View;

use super::REFINEMENTS;
use crate::accuracy::Accuracy;
use crate::failure::Failure;
use crate::job::{Checkpoints, RenderJob};
use crate::words::Outputs;
use crate::{console, output, picture};

/// What a former run has left.
pub(super) struct Former {
    pub(super) film: Film,
    /// How many of the picture's paths it has.
    pub(super) paths: u64,
    /// How often the picture had begun anew with finer records.
    pub(super) refined: u32,
}

/// In what a film isn't the one to be gone on with.
pub(super) fn differing(error: PartError) -> String {
    match error {
        PartError::Foreigner { what, here, there } => {
            format!("it is of another picture: {what} was {here} and is now {there}")
        }
        error => error.to_string(),
    }
}

/// Says in what a picture's files tell of it that it has begun anew so often.
pub(super) fn tell_refined(settings: &mut Vec<(String, String)>, refined: u32) {
    settings.retain(|(name, _)| name != REFINEMENT);
    if refined > 0 {
        settings.push((REFINEMENT.to_owned(), refined.to_string()));
    }
}

/// How often a picture had begun anew with finer records, as its files tell.
pub(super) fn told_refined(origin: &Origin) -> u32 {
    let said = origin.setting(REFINEMENT);
    let said = said.and_then(|refined| refined.parse().ok());
    said.filter(|refined| (1..=REFINEMENTS).contains(refined))
        .unwrap_or(0)
}

/// Reads what a former run has left; nothing where there is no such file. A picture that may be refined goes on with as fine records
/// as the film has.
///
/// # Errors
/// It can't be read, is no render under way, or is one of something else.
pub(super) fn read(
    checkpoints: &Checkpoints,
    origin: &Origin,
    settings: &RenderSettings,
    paths_per_sample: u64,
    job: &RenderJob,
) -> Result<Option<Former>, Failure> {
    let RenderSettings {
        width,
        height,
        first_sample,
        layers,
        ..
    } = settings;
    let (path, size) = (&checkpoints.path, (*width, *height));
    if !path.exists() {
        console::note(&format!(
            "{} is not there yet: the render begins",
            path.display()
        ));
        return Ok(None);
    }
    let refused = |error: &dyn std::fmt::Display| {
        let remedy = "render with the same settings, or without --resume to begin anew";
        Failure::Failed(format!(
            "cannot resume {}: {error}; {remedy}",
            path.display()
        ))
    };
    let part = picture::film(path).map_err(|error| refused(&error))?;
    let refined = match job.accuracy {
        Some(Accuracy::Final) => told_refined(&part.origin),
        _ => 0,
    };
    let mut wanted = origin.clone();
    tell_refined(&mut wanted.settings, refined);
    wanted
        .fits(&part.origin)
        .map_err(|error| refused(&differing(error)))?;
    // What its header says of itself may not be so.
    let is_its_film = (part.film.width, part.film.height) == size && part.film.layers() == layers;
    if !is_its_film {
        return Err(refused(&"it has another size, or other layers"));
    }
    let (Some(paths), [samples]) = (part.paths(paths_per_sample), part.ranges()) else {
        return Err(refused(&"it lacks samples in between"));
    };
    if samples.start != *first_sample {
        let error = format!("its first sample is {}, not {first_sample}", samples.start);
        return Err(refused(&error));
    }
    if part.origin.device != origin.device {
        console::warning(&format!(
            "{} was rendered on {}, and goes on on {}: the picture is right, but not to the last bit that of one device",
            path.display(),
            part.origin.device,
            origin.device
        ));
    }
    let (fewest, most) = part.film.sample_bounds();
    // A picture whose samples go everywhere has a burst of difference while it is under way.
    if !job.adaptive && most - fewest >= GRAIN {
        let error = format!("its pixels have {fewest} to {most} samples, as --adaptive gives them");
        return Err(refused(&error));
    }
    let samples = console::grouped(u64::from(fewest));
    console::note(&format!(
        "resumed {}: {samples} samples per pixel",
        path.display()
    ));
    let film = part.film;
    Ok(Some(Former {
        film,
        paths,
        refined,
    }))
}

/// Writes checkpoints, one at a time, on a thread of its own.
pub(super) struct Writer<'a> {
    checkpoints: &'a Checkpoints,
    /// Written with each, where that is wanted.
    pictures: Outputs,
    view: View,
    /// What they hold of the film.
    layers: Layers,
    transparent: bool,
    form: Form,
    origin: Origin,
    first_sample: u32,
    last: Instant,
    /// Returns what went wrong.
    writing: Option<JoinHandle<Vec<String>>>,
    /// What went wrong with the last one, of which the user knows: a disk that is full is full at the next one, too.
    told: Vec<String>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(
        checkpoints: &'a Checkpoints,
        job: &RenderJob,
        view: View,
        origin: Origin,
    ) -> Self {
        let pictures = match checkpoints.with_pictures {
            true => job.outputs.pictures.clone(),
            false => Vec::new(),
        };
        Self {
            checkpoints,
            pictures: Outputs {
                pictures,
                films: Vec::new(),
            },
            view,
            layers: job.shown_layers.clone(),
            transparent: job.transparent,
            form: job.form.clone(),
            origin,
            first_sample: job.first_sample,
            last: Instant::now(),
            writing: None,
            told: Vec::new(),
        }
    }

    /// Whether one is to be written now.
    pub(super) fn is_due(&self) -> bool {
        let is_free = self.writing.as_ref().is_none_or(JoinHandle::is_finished);
        is_free && self.last.elapsed() >= self.checkpoints.every
    }

    /// From now on they are of a picture that has begun anew so often.
    pub(super) fn tell_refined(&mut self, refined: u32) {
        tell_refined(&mut self.origin.settings, refined);
    }

    /// Begins to write one of a film with so many paths. What goes wrong is a warning: the render goes on.
    pub(super) fn write(&mut self, film: Film, paths: u64) {
        self.finish();
        self.last = Instant::now();
        let (fewest, most) = film.sample_bounds();
        if most == 0 {
            return;
        }
        let first = self.first_sample;
        let part = Part::new(film, first..first + most, self.origin.clone()).under_way(paths);
        let (path, pictures) = (self.checkpoints.path.clone(), self.pictures.clone());
        let (layers, view, transparent) = (self.layers.clone(), self.view, self.transparent);
        let form = self.form.clone();
        let told = self.told.clone();
        let work = move || {
            let mut failed = Vec::new();
            let written = output::write_aside(&path, |file| part.write(file));
            if let Err(error) = written {
                tell(&mut failed, &told, format!("no checkpoint: {error}"));
            }
            // Pictures of less than a sample would have holes.
            let content = Content {
                film: &part.film,
                layers: &layers,
                denoised: None,
                transparent,
                form: &form,
            };
            for picture in pictures.pictures.iter().filter(|_| fewest > 0) {
                let written = output::write(picture, content, Some(&part.origin), &view);
                if let Err(error) = written {
                    tell(&mut failed, &told, error.to_string());
                }
            }
            failed
        };
        match std::thread::Builder::new()
            .name("checkpoint".to_owned())
            .spawn(work)
        {
            Ok(thread) => self.writing = Some(thread),
            Err(error) => {
                let told = std::mem::take(&mut self.told);
                let text = format!("no checkpoint: no thread can be started: {error}");
                tell(&mut self.told, &told, text);
            }
        }
    }

    /// Waits until what has begun is written.
    pub(super) fn finish(&mut self) {
        if let Some(writing) = self.writing.take() {
            // It has said itself what went wrong.
            self.told = writing.join().unwrap_or_default();
        }
    }
}

/// Notes what went wrong with a checkpoint, and warns of it unless that has been told of the one before.
fn tell(failed: &mut Vec<String>, told: &[String], text: String) {
    if !told.contains(&text) {
        console::warning(&text);
    }
    failed.push(text);
}

impl Drop for Writer<'_> {
    fn drop(&mut self) {
        self.finish();
    }
}
