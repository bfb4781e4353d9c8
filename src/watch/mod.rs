//! `patina watch`: renders live without a window. After each change of a file the picture is written anew at 1, 4, 16,
//! 64, ... samples per pixel; what is wrong with the files is said once, and that it has been mended.

pub(crate) mod args;
pub(crate) mod files;
mod folders;
pub(crate) mod job;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use device::{Device, DeviceOptions};
use engine::load;
use engine::renderer::RenderSettings;
use engine::scene::look::Look;
use engine::session::{Inputs, Opening, Session};
use engine::stats::Doubt;
use engine::system::System;
use texgen::{Diagnostic, Diagnostics};

use crate::failure::Failure;
use crate::output;
use crate::progress::Bar;
use crate::{cache, console, interrupt, library};

use files::{Changes, Watcher};
use folders::Folders;
use job::WatchJob;

/// How often a watch that has nothing to render looks whether something in the background is ready.
const IDLE: Duration = Duration::from_millis(20);
/// The same while something is being built.
const BUSY: Duration = Duration::from_millis(2);
/// Each picture has so many times the samples of the one before.
const STEP: u32 = 4;

/// Renders until a signal ends it.
///
/// # Errors
/// Always: [`Failure::Interrupted`] once what there is has been written. Else the scene can't be loaded at first, or the
/// device fails for good. Later mistakes in files are said, and waited out.
pub(crate) fn run(job: &WatchJob) -> Result<(), Failure> {
    let written: Vec<PathBuf> = job.outputs.iter().map(|o| o.path.clone()).collect();
    // A look that can't be read is told of when it is opened.
    let look = job.look.as_deref().and_then(|look| Look::load(look).ok());
    let mut read = load::files(&job.scene, look.as_ref());
    read.extend(job.look.clone());
    output::check_all(&written, &read)?;
    let (clock, begun) = (Instant::now(), SystemTime::now());
    let bar = Arc::new(Bar::of_compiling());
    let mut session = open(job, &bar)?;
    console::diagnostics(session.warnings());
    let mut warned = session.warnings().clone();
    let mut watcher = Watcher::new(
        &session.files(),
        job.look.as_deref(),
        &session.inputs().textures,
        begun,
    )?;
    let mut update = Update::new("start".to_owned(), clock);
    let mut told = String::new();
    let mut doubts = Vec::new();
    let mut generation = session.generation();
    let mut look_view = session.look_view();
    let (mut is_written, mut may_write) = (true, true);
    while !interrupt::requested() {
        let wait = match (update.next > job.spp.get(), session.is_building()) {
            (false, _) => Duration::ZERO,
            (true, true) => BUSY,
            (true, false) => IDLE,
        };
        if let Some(changes) = watcher.wait(wait) {
            update.changed(&changes);
            follow(&mut session, &changes);
        }
        session.poll()?;
        if session.generation() != generation {
            generation = session.generation();
            update.begin();
            may_write = is_free(&written, &session.files());
            watcher.set_files(&session.files(), job.look.as_deref());
        } else if session.look_view() != look_view {
            // The same samples shown in another way: what there is of them is enough.
            update.show_again();
            if may_write {
                write(job, &mut session, &update)?;
            }
        } else if !session.is_building() {
            // Nothing to be seen came of it.
            update.coming = None;
        }
        look_view = session.look_view();
        if tell_problems(&session, &mut told) {
            // A file that isn't there mends them when it comes.
            watcher.set_files(&session.files(), job.look.as_deref());
        }
        tell_warnings(&session, &mut warned);
        let target = update.next.min(job.spp.get());
        let progress = session.step(target)?;
        is_written &= update.next > job.spp.get();
        // What was swapped in meanwhile is noticed, and begun anew, in the next round.
        if session.generation() != generation {
            session.restart();
        } else if progress.is_done() && update.next <= job.spp.get() {
            if may_write {
                write(job, &mut session, &update)?;
            }
            tell_doubts(&session, update.next == job.spp.get(), &mut doubts)?;
            interrupt::has_results();
            is_written = true;
            update.next = match update.next {
                last if last == job.spp.get() => u32::MAX,
                done => done.saturating_mul(STEP).min(job.spp.get()),
            };
        }
    }
    interrupt::writes_results();
    if !is_written && may_write {
        write(job, &mut session, &update)?;
    }
    Err(Failure::Interrupted)
}

/// Whether no picture would replace a file that the scene or the look has come to name; says it where one would.
fn is_free(written: &[PathBuf], read: &[PathBuf]) -> bool {
    let refused = output::refuse_overwriting(written, read);
    if let Err(error) = &refused {
        console::error(&error.to_string());
    }
    refused.is_ok()
}

fn open(job: &WatchJob, bar: &Arc<Bar>) -> Result<Session, Failure> {
    let textures = library::texture_dirs_to_come(&job.texture_dirs, job.look.as_deref())?;
    let system = System {
        files: Arc::new(Folders::new(&textures)),
        ..System::default()
    };
    let inputs = Inputs {
        scene: job.scene.clone(),
        look: job.look.clone(),
        textures,
        camera: job.camera.clone(),
    };
    let (device, folder) = (job.device.clone(), cache::folder());
    let bar = Arc::clone(bar);
    let (width, height, max_depth, seed) = (job.width, job.height, job.max_depth, job.seed);
    let opening = Opening::read(inputs, system)?;
    let session = opening.start(
        Arc::new(move || {
            Device::open_with(&DeviceOptions::new(&device).with_cache(folder.as_deref()))
                .inspect(|device| bar.follow(device))
        }),
        Arc::new(move |camera| RenderSettings {
            max_depth,
            seed,
            ..RenderSettings::new(width, height, &camera)
        }),
    );
    session.map_err(Failure::from)
}

fn follow(session: &mut Session, changes: &Changes) {
    if changes.look {
        session.look_changed();
    }
    if changes.textures {
        session.sources_changed();
    }
    if changes.assets {
        session.assets_changed();
    }
}

/// What a picture is written for.
struct Update {
    number: u32,
    /// What changed.
    what: String,
    /// When the change was noticed.
    since: Instant,
    /// A change that the picture doesn't show yet.
    coming: Option<(String, Instant)>,
    /// Samples of the next picture.
    next: u32,
}

impl Update {
    fn new(what: String, since: Instant) -> Self {
        Self {
            number: 0,
            what,
            since,
            coming: None,
            next: 1,
        }
    }

    fn changed(&mut self, changes: &Changes) {
        let (names, since) = (changes.names.join(", "), changes.since);
        match &mut self.coming {
            // What was waiting becomes part of what is to come.
            Some((what, _)) if !what.contains(&names) => *what = format!("{what}, {names}"),
            Some(_) => {}
            None => self.coming = Some((names, since)),
        }
    }

    /// The picture has begun anew.
    fn begin(&mut self) {
        self.show_again();
        self.next = 1;
    }

    /// The picture is shown in another way.
    fn show_again(&mut self) {
        if let Some((what, since)) = self.coming.take() {
            (self.what, self.since) = (what, since);
            self.number += 1;
        }
    }
}

fn write(job: &WatchJob, session: &mut Session, update: &Update) -> Result<(), Failure> {
    let snapshot = session.snapshot()?;
    let film = snapshot.film;
    let (spp, most) = film.sample_bounds();
    if most == 0 {
        return Ok(());
    }
    let origin = session.origin();
    let view = job.display.or(session.look_view()).view();
    let mut names = Vec::new();
    for output in &job.outputs {
        match output::write(output, &film, Some(&origin), &view) {
            Ok(()) => names.push(output.path.display().to_string()),
            // A full disk may have room again at the next change.
            Err(error) => console::error(&error.to_string()),
        }
    }
    // Why nothing was written has been said.
    if names.is_empty() {
        return Ok(());
    }
    console::print(&format!(
        "{}: {}: {spp} spp after {:.3} s: {}",
        update.number,
        update.what,
        update.since.elapsed().as_secs_f64(),
        names.join(", ")
    ));
    Ok(())
}

/// Says what is wrong with the picture, each thing once. What a picture with all its samples no more shows is mended.
fn tell_doubts(
    session: &Session,
    has_all_samples: bool,
    told: &mut Vec<Doubt>,
) -> Result<(), Failure> {
    let stats = session.stats()?;
    let doubts = stats.doubts();
    let holds = |list: &[Doubt], doubt: &Doubt| list.iter().any(|other| other.is_same(doubt));
    for doubt in doubts.iter().filter(|doubt| !holds(told, doubt)) {
        console::warning(&doubt.to_string());
    }
    if has_all_samples {
        told.retain(|doubt| holds(&doubts, doubt));
    }
    let new: Vec<_> = doubts.into_iter().filter(|d| !holds(told, d)).collect();
    told.extend(new);
    Ok(())
}

/// Says what is odd about what is shown, as far as that is new.
fn tell_warnings(session: &Session, told: &mut Diagnostics) {
    let warnings = session.warnings();
    if session.is_building() || warnings == told {
        return;
    }
    let known: Vec<String> = told.iter().map(Diagnostic::render).collect();
    let is_new = |warning: &&Diagnostic| !known.contains(&warning.render());
    let new: Diagnostics = warnings.iter().filter(is_new).cloned().collect();
    if !new.is_empty() {
        console::diagnostics(&new);
    }
    *told = warnings.clone();
}

/// Says what is wrong when that has changed; whether something is.
fn tell_problems(session: &Session, told: &mut String) -> bool {
    // While something is built it may turn out otherwise.
    if session.is_building() {
        return false;
    }
    let problems = session.problems();
    let text = problems.render();
    if text == *told {
        return false;
    }
    if problems.is_empty() {
        console::print("no more problems");
    } else {
        console::diagnostics(&problems);
    }
    *told = text;
    !problems.is_empty()
}
