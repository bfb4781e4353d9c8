//! `patina render`: loads, renders, writes. Reads in the order things happen.

mod adaptive;
mod alone;
mod cameras;
mod checkpoint;
mod frames;
mod limits;
mod pieces;
mod reel;
mod together;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use device::Device;
use engine::audit::Audit;
use engine::denoise::Denoiser;
use engine::film::layers::{SHADOW_CATCHER, VECTOR};
use engine::film::{Film, Origin, Part, Tally};
use engine::fleet::{DeviceShare, Fleet};
use engine::procedural::Procedural;
use engine::renderer::{RenderSettings, TextureCosts};
use engine::scene::view::{View, ViewChoice};
use engine::scene::{Camera, LightKind};
use engine::session::{Inputs, Session, SessionError};
use engine::settings::{Beside, Method};
use engine::stats::{DeviceFacts, Stats};

use crate::failure::Failure;
use crate::job::RenderJob;
use crate::motion::{Frame, Sight};
use crate::output::{self, Results};
use crate::progress::Bar;
use crate::report::{Report, Seconds};
use crate::usage::UsageError;
use crate::{console, crash, denoise, devices, interrupt, library, memory};

use self::alone::{Scene as Shown, Take};
use self::limits::{Limit, Watch};
use self::pieces::{Division, Pieces};
use self::reel::{Reel, View as Seen};

/// The word for each camera in turn.
const ALL_CAMERAS: &str = "all";
/// Most of the time that goes into measuring textures, where figures are asked for.
const COSTS: Duration = Duration::from_secs(5);
/// Most times that a picture is rendered again with finer records.
const REFINEMENTS: u32 = 2;
/// What is done meanwhile.
const REFINING: &str = "rendering again with finer records";
/// Most of the time that an interrupted render goes on for, so that a film is even.
const FAREWELL: Duration = Duration::from_secs(1);

/// Renders a scene and writes the pictures. A signal ends the rendering early, not the writing.
///
/// # Errors
/// Anything that keeps even one of the results from being written.
pub(crate) fn run(job: &RenderJob) -> Result<(), Failure> {
    if job.motion.is_sequence() {
        return frames::run(job);
    }
    if job.camera.as_deref() != Some(ALL_CAMERAS) {
        return picture(job);
    }
    let scene = engine::scene::import::load(&job.scene)
        .map_err(Failure::because)?
        .scene;
    // A camera of this name is meant where there is one.
    if scene
        .cameras
        .iter()
        .any(|camera| camera.name == ALL_CAMERAS)
        || scene.cameras.is_empty()
    {
        return picture(job);
    }
    let names = cameras::file_names(&scene.cameras);
    let jobs = scene.cameras.iter().zip(&names);
    let jobs = jobs.map(|(camera, name)| job.through(camera, name));
    spare_inputs(job, jobs.flat_map(|own| written(&own)))?;
    for (camera, name) in scene.cameras.iter().zip(&names) {
        // What comes while one is written must not cost the next one's file.
        if interrupt::requested() {
            return Err(Failure::Interrupted);
        }
        interrupt::goes_on();
        picture(&job.through(camera, name))?;
    }
    Ok(())
}

/// Renders one picture.
fn picture(job: &RenderJob) -> Result<(), Failure> {
    let clock = Instant::now();
    let written = written(job);
    check(job, &written)?;
    let denoiser = denoise::for_job(job.denoise, &job.outputs)?;
    let bar = Bar::read_by(job.progress, "loading the scene");
    let mut reel = Reel::open(job, inputs(job)?)?;
    let sights = job.motion.sights(Frame { number: None });
    let beside = beside(job, &mut reel, Frame { number: None })?;
    let (mut first, mut reel) = match sights.len() == 1 && beside.is_none() {
        true => (reel.once(&sights[0])?, None),
        false => (reel.at(&sights[0])?, Some(reel)),
    };
    first.beside = beside;
    let loaded = first.opening.loaded();
    let warnings = job.overrides.told(job.look.as_deref(), &loaded.warnings);
    bar.suspend(|| console::diagnostics(&warnings));
    let without = job;
    let job = &job.for_scene(&loaded.scene);
    if let Some(warning) = missed(without, job) {
        bar.suspend(|| console::warning(warning));
    }
    // What else was read is known only now.
    output::check_all(&written, &first.opening.files())?;
    let view = view_of(job, &first);
    let told = Told::new(job, &loaded.scene, clock);

    bar.stage("preparing the device");
    let devices = devices::open(&job.devices, &bar)?;
    let rendered = match <[Device; 1]>::try_from(devices) {
        Ok([device]) => {
            let division = pieces::plan(job, &first, &device, &bar)?;
            let start = Start {
                scene: Shown::New(first),
                sights: &sights,
                reel: reel.as_mut(),
                clock,
            };
            start.render(job, division, &device, &view, &bar)?
        }
        Err(_) if job.checkpoints.is_some() || job.adaptive => {
            let flag = match &job.checkpoints {
                _ if job.adaptive => "--adaptive",
                Some(kept) if kept.resumes => "--resume",
                Some(kept) if kept.with_pictures => "--refresh",
                _ => "--checkpoint",
            };
            return Err(UsageError::OneDevice { flag }.into());
        }
        Err(devices) => {
            let Seen {
                opening,
                sight,
                beside,
            } = first;
            let loaded = opening.into_loaded();
            let settings = settings(job, &loaded.camera, &sight, beside);
            let watch = Watch::new(job.limits, view, clock);
            together::render(job, loaded, settings, &devices, &bar, watch)?
        }
    };
    bar.finish();
    let (outcome, rest) = write(job, rendered, &view, denoiser.as_ref(), &told);
    end(rest);
    outcome
}

/// What the film must know of the frames before and after one for its layers.
fn beside(job: &RenderJob, reel: &mut Reel, frame: Frame) -> Result<Option<Arc<Beside>>, Failure> {
    let has_motion = job.layers.iter().any(|layer| layer.name == VECTOR);
    let sights = job.motion.beside(frame).filter(|_| has_motion);
    sights.map(|sights| reel.beside(&sights)).transpose()
}

/// The files that a render writes.
fn written(job: &RenderJob) -> Vec<PathBuf> {
    let kept = job.checkpoints.iter().map(|checkpoints| &checkpoints.path);
    // A film that is asked for is the checkpoint, too.
    let kept = kept.filter(|path| !job.outputs.films.contains(path));
    let outputs = job.outputs.paths().chain(&job.stats_json);
    outputs.chain(kept).cloned().collect()
}

/// Refuses files of several pictures that are inputs: before the first one, not after hours, when it is their turn. Only what is there can
/// be one.
fn spare_inputs(job: &RenderJob, written: impl Iterator<Item = PathBuf>) -> Result<(), Failure> {
    let there: Vec<PathBuf> = written.filter(|path| path.exists()).collect();
    if there.is_empty() {
        return Ok(());
    }
    let look = job.overrides.look(job.look.as_deref())?;
    let mut read = engine::load::files(&job.scene, look.as_ref());
    read.extend(job.look.clone());
    output::refuse_inputs(&there, &read).map_err(Failure::from)
}

/// Whether files can be written, none of them over what is named, or over a texture that may be read.
fn check(job: &RenderJob, written: &[PathBuf]) -> Result<(), Failure> {
    let folders = library::texture_dirs(&job.texture_dirs, job.look.as_deref())?;
    let mut read = library::files(&folders);
    read.extend(job.look.iter().chain([&job.scene]).cloned());
    output::check_all(written, &read)
}

fn inputs(job: &RenderJob) -> Result<Inputs, Failure> {
    Ok(Inputs {
        scene: job.scene.clone(),
        look: job.look.clone(),
        textures: library::texture_dirs(&job.texture_dirs, job.look.as_deref())?,
        camera: None,
    })
}

/// How a picture is shown, by the command line and the look.
fn view_of(job: &RenderJob, seen: &Seen) -> View {
    let look = seen.opening.loaded().look.as_ref();
    let look_view = look.map_or_else(ViewChoice::default, |look| look.view);
    job.display.or(look_view).view()
}

/// What one device begins a picture with.
struct Start<'a> {
    scene: Shown,
    /// The moments at which its shutter is open.
    sights: &'a [Sight],
    /// Where they come from; `None` where there is no further one.
    reel: Option<&'a mut Reel>,
    /// When it began.
    clock: Instant,
}

impl Start<'_> {
    /// Renders the picture, as a whole or piece by piece.
    fn render(
        self,
        job: &RenderJob,
        division: Option<Division>,
        gpu: &Device,
        view: &View,
        bar: &Bar,
    ) -> Result<Rendered, Failure> {
        if let Some(division) = division {
            return pieces::render(job, division, self, gpu, view, bar);
        }
        let take = Take {
            ready: alone::prepare(job, self.scene, gpu, bar)?,
            sights: self.sights,
            reel: self.reel,
            written: None,
            is_piece: false,
        };
        let watch = Watch::new(job.limits, *view, self.clock);
        alone::render(job, take, gpu, view, bar, watch)
    }
}

/// The samples of a picture.
enum Gathered {
    Whole(Film),
    /// On the disk.
    Pieces(Pieces),
}

impl Gathered {
    fn tally(&self) -> Tally {
        match self {
            Self::Whole(film) => Tally::of(film),
            Self::Pieces(pieces) => *pieces.tally(),
        }
    }
}

/// A picture, complete or not, and what is known of how it came about.
struct Rendered {
    gathered: Gathered,
    /// The numbers of the samples that pixels may have.
    samples: Range<u32>,
    /// Of what layers of ids show.
    names: BTreeMap<String, Vec<String>>,
    /// How many of the picture's paths are there, where these are the first ones.
    paths: Option<u64>,
    /// What is gone on with in place of that, and its paths.
    kept: Option<(Film, u64)>,
    /// Why it isn't complete, if it isn't.
    ended: Option<Ended>,
    /// Whether it is of paths that go ahead of the picture, which isn't begun.
    is_preview: bool,
    /// Names of the devices.
    device: String,
    facts: DeviceFacts,
    /// Each one's part, where there are several.
    shares: Vec<DeviceShare>,
    settings: Vec<(String, String)>,
    /// What paths say of it, where it is biased.
    audit: Option<Audit>,
    stats: Stats,
    /// Opening the device, acceleration structures and kernels.
    prepare_seconds: f64,
    render_seconds: f64,
    /// What goes on after the picture.
    rest: Rest,
}

/// Why a picture isn't complete.
enum Ended {
    /// It was good enough, or the time was over.
    Enough(Limit),
    /// A signal came.
    Interrupted,
    /// There is no device left.
    Failed(String),
}

/// Whether a picture is as it was to be, and so worth a look at how right it is: after a signal nobody waits for that, nor when the
/// time is over.
fn is_as_wanted(ended: Option<&Ended>) -> bool {
    matches!(
        ended,
        None | Some(Ended::Enough(Limit::Noise(_) | Limit::Flip(_)))
    )
}

/// What rendered, while it is still there.
enum Rest {
    /// Costs of textures can be measured.
    Alone(Box<Session>),
    Together(Fleet),
    /// All was there already.
    Nothing,
}

/// What else is told of a render.
struct Told {
    load_seconds: f64,
    /// Photons bring light of lamps without size that paths, which find those by light samples alone, don't.
    is_more_than_paths_find: bool,
}

impl Told {
    /// When all is read, since the clock was started.
    fn new(job: &RenderJob, scene: &engine::scene::Scene, clock: Instant) -> Self {
        let mut lights = scene.lights.iter();
        let has_size = |kind: LightKind| matches!(kind, LightKind::Disk { .. });
        Self {
            load_seconds: clock.elapsed().as_secs_f64(),
            is_more_than_paths_find: job.method.has_photons()
                && lights.any(|light| !has_size(light.kind)),
        }
    }
}

/// What is said of layers that were asked for, and that a scene hasn't.
fn missed(asked: &RenderJob, of_scene: &RenderJob) -> Option<&'static str> {
    let has = |job: &RenderJob| {
        let mut layers = job.shown_layers.iter();
        layers.any(|layer| layer.name == SHADOW_CATCHER)
    };
    (has(asked) && !has(of_scene))
        .then_some("no material is a `shadow_catcher`: there is no layer of that name")
}

/// Writes the pictures, and tells what is to be told. What has rendered is given back.
fn write(
    job: &RenderJob,
    rendered: Rendered,
    view: &View,
    denoiser: Option<&Denoiser>,
    told: &Told,
) -> (Result<(), Failure>, Rest) {
    let &Told {
        load_seconds,
        is_more_than_paths_find,
    } = told;
    let tally = match rendered.is_preview {
        true => Tally::default(),
        false => rendered.gathered.tally(),
    };
    let (lowest, _) = tally.sample_bounds();
    if rendered.is_preview {
        let reason = match &rendered.ended {
            Some(Ended::Enough(_)) => "the time was over",
            Some(Ended::Interrupted) => "interrupted",
            Some(Ended::Failed(_)) | None => "it ended",
        };
        console::warning(&format!(
            "{reason} before the first sample: what is written shows paths that go ahead of the picture"
        ));
    } else if let (Some(Ended::Enough(_)), 0) = (&rendered.ended, tally.samples()) {
        let text = "the time was over before the first sample: nothing is written".to_owned();
        return (Err(Failure::Failed(text)), rendered.rest);
    } else if let (Some(Ended::Enough(_)), 0) = (&rendered.ended, lowest) {
        console::warning(
            "the time was over before every pixel had a sample: those without any are black",
        );
    } else if let Some(Ended::Interrupted) = &rendered.ended {
        if tally.samples() == 0 {
            // A black picture would take the place of a former one.
            console::warning(interrupt::NOTHING);
            return (Err(Failure::Interrupted), rendered.rest);
        }
        console::warning(&format!(
            "interrupted: every pixel has at least {}",
            job.samples_told(lowest)
        ));
    }
    let stats = rendered.stats;
    for doubt in stats.doubts() {
        console::warning(&doubt.to_string());
    }
    let limit = rendered.ended.as_ref().and_then(|ended| match ended {
        Ended::Enough(limit) => Some(limit),
        Ended::Interrupted | Ended::Failed(_) => None,
    });
    let seen = match (&rendered.gathered, job.limits.flip) {
        (Gathered::Whole(film), Some(most)) if !rendered.is_preview => {
            limits::seen(film, view, most)
        }
        _ => None,
    };
    if !rendered.is_preview
        && let Some(summary) = limits::summary(job, limit, &tally, seen)
    {
        console::note(&summary);
    }
    let refined = (rendered.settings.iter())
        .find(|(name, _)| name == engine::fingerprint::REFINEMENT)
        .map(|(_, times)| times.as_str());
    if let Some(times) = refined {
        let times = if times == "1" {
            "once".to_owned()
        } else {
            format!("{times} times")
        };
        console::note(&format!(
            "rendered again {times} with finer records, for the brightness was off"
        ));
    }
    if let Some(audit) = &rendered.audit {
        let clamped = job.clamp.is_some();
        console::note(&limits::bias(audit, clamped, is_more_than_paths_find));
    }
    let look = job.look.as_deref();
    let mut origin = Origin::new(&rendered.device, &job.scene, look, rendered.settings);
    origin.names = rendered.names;
    let mut outcome = match rendered.gathered {
        Gathered::Pieces(pieces) => pieces.write(job, &origin, view),
        Gathered::Whole(film) => {
            let kept = rendered.kept.map(|(film, paths)| {
                let first = rendered.samples.start;
                let samples = first..first + film.sample_bounds().1;
                Part::new(film, samples, origin.clone()).under_way(paths)
            });
            let mut part = Part::new(film, rendered.samples, origin);
            if let Some(paths) = rendered.paths {
                part = part.under_way(paths);
            }
            write_part(job, &part, kept.as_ref(), view, denoiser)
        }
    };

    let mut rest = rendered.rest;
    if job.stats || job.stats_json.is_some() {
        let seconds = Seconds {
            load: load_seconds,
            prepare: rendered.prepare_seconds,
            render: rendered.render_seconds,
        };
        let textures = match &mut rest {
            Rest::Alone(session) => texture_costs(session),
            Rest::Together(_) | Rest::Nothing => Ok(TextureCosts::default()),
        };
        let textures = match textures {
            Ok(textures) => textures,
            Err(failure) => return (Err(failure), rest),
        };
        let (facts, shares) = (rendered.facts, rendered.shares);
        let report = Report::new(job, facts, shares, &tally, seconds, stats, textures);
        if job.stats {
            console::print(&report.table());
        }
        if let Some(path) = &job.stats_json {
            outcome = outcome.and(report.write_json(path).map_err(Failure::because));
        }
    }
    let outcome = match rendered.ended {
        None | Some(Ended::Enough(_)) => outcome,
        Some(Ended::Interrupted) => outcome.and(Err(Failure::Interrupted)),
        Some(Ended::Failed(reason)) => outcome.and(Err(Failure::Failed(reason))),
    };
    (outcome, rest)
}

/// Writes the files of a picture that is in memory.
fn write_part(
    job: &RenderJob,
    part: &Part,
    kept: Option<&Part>,
    view: &View,
    denoiser: Option<&Denoiser>,
) -> Result<(), Failure> {
    let mut results = Results {
        part,
        kept,
        layers: &job.shown_layers,
        denoised: None,
        transparent: job.transparent,
        form: &job.form,
        view,
        is_frame: job.motion.is_sequence(),
    };
    let denoised = denoiser.map(|denoiser| denoise::film(denoiser, &results.content()));
    let (denoised, given_up) = match denoised.transpose() {
        Ok(denoised) => (denoised, None),
        // With its noise a picture is better than none.
        Err(error) => (None, Some(error)),
    };
    results.denoised = denoised.as_ref();
    let outcome = output::write_or_keep(&job.outputs, &results);
    match given_up {
        None => outcome,
        Some(error) => {
            let text = format!("{error}; the picture was written with its noise");
            outcome.and(Err(Failure::Failed(text)))
        }
    }
}

/// Waits for threads that are still in a driver: the program's end would pull that away from under them. Whoever has interrupted
/// the program doesn't wait, and that end comes without cleaning up.
fn end(rest: Rest) {
    if let Rest::Together(fleet) = rest
        && !interrupt::requested()
    {
        fleet.join();
    }
}

/// Sets a marker for the time in which kernels are built for a device. If there is one of a process that is gone, the
/// textures are built one by one before.
///
/// # Errors
/// Names the textures that the driver doesn't survive.
fn mark(
    procedural: &Procedural,
    gpu: &Device,
    folder: Option<&Path>,
    bar: &Bar,
) -> Result<Option<crash::Marker>, Failure> {
    if procedural.is_empty() {
        return Ok(None);
    }
    let kernel = procedural.kernel().wgsl;
    let (marker, has_crashed) = crash::Marker::set(folder, &kernel, gpu.description());
    if has_crashed {
        bar.suspend(|| console::warning(crash::SUSPICION));
        let tell = |texture: &str| bar.stage(&format!("building {texture} alone"));
        crash::find(procedural, gpu.description().index, tell)?;
        bar.stage("preparing the device");
    }
    Ok(marker)
}

/// A session's failure, but that no look is kept when the device is lost: none was edited.
fn failure(error: SessionError) -> Failure {
    match error {
        SessionError::Lost(error) => Failure::because(error),
        other => other.into(),
    }
}

/// What textures cost, as far as that can be measured in a moment.
fn texture_costs(session: &mut Session) -> Result<TextureCosts, Failure> {
    let clock = Instant::now();
    loop {
        let costs = session.measure_costs().map_err(failure)?;
        if costs.is_done || clock.elapsed() > COSTS || interrupt::requested() {
            return Ok(costs.clone());
        }
    }
}

fn settings(
    job: &RenderJob,
    camera: &Camera,
    sight: &Sight,
    beside: Option<Arc<Beside>>,
) -> RenderSettings {
    RenderSettings {
        largest_wave: memory::largest_wave(job.memory),
        beside,
        max_depth: job.max_depth,
        seed: job.seed,
        energy_compensation: job.energy_compensation,
        first_sample: job.first_sample,
        filter: job.filter,
        clamp: job.clamp,
        estimator: job.estimator,
        roulette: job.roulette,
        sampler: job.sampler,
        // Both are of use where the error has to be known well; the second half begins late. All parts of a picture have to agree.
        halves: job.adaptive
            || job.limits.flip.is_some()
            || job.method != Method::Path
                && job.whole_spp >= engine::adaptive::GRAIN
                && job.motion.has_equal_halves(job.whole_spp),
        method: job.method,
        layers: job.layers.clone(),
        crop: job.crop,
        piece_of: job.piece_of,
        filter_width: job.filter_width,
        time: sight.moment.seconds as f32,
        frame_index: sight.frame_index,
        ..RenderSettings::new(job.width, job.height, camera)
    }
}
