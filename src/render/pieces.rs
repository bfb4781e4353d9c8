//! A picture whose film doesn't fit the memory: rendered in pieces, one after the other, each to its end, by one renderer. What is done of
//! it lies on the disk. A piece is a band of whole rows, whose pixels have the random numbers that they have in the whole.

mod division;
mod gathered;
mod store;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use device::Device;
use engine::audit::{Audit, Comparison};
use engine::film::write::Format;
use engine::film::{Crop, Film, Origin, Tally};
use engine::scene::view::View;
use engine::session::Session;
use engine::settings::{Beside, Divided, Method};
use engine::stats::{DeviceFacts, Stats};

use crate::accuracy::{Accuracy, method_flag};
use crate::failure::Failure;
use crate::job::{Limits, RenderJob};
use crate::left;
use crate::memory::Need;
use crate::motion::Sight;
use crate::progress::Bar;
use crate::words::{MAX_PIXELS, Output};
use crate::{console, interrupt, memory};

pub(super) use self::division::Division;
use self::division::Piece;
pub(super) use self::gathered::Pieces;
use self::store::Store;

use super::alone::{self, Ready, Scene, Take};
use super::limits::{Limit, Watch};
use super::reel::{Reel, View as Seen};
use super::{
    Ended, Gathered, REFINEMENTS, REFINING, Rendered, Rest, Start, checkpoint, failure,
    is_as_wanted, settings,
};

/// Pixels of a piece where the memory allows it, about: enough to keep a device busy, and the same however large the picture is.
const PIXELS: u32 = 512 * 512;
/// The same where photons are sent out for each sample of each piece: as many as they are in a large picture.
const PIXELS_WITH_PHOTONS: u32 = 1024 * 1024;
/// Samples per pixel of the small picture that tells how bright the whole is.
const PREVIEW: u32 = 16;
/// Samples per pixel that light is found out about for, where their number isn't known.
const UNKNOWN_SAMPLES: u32 = 64;

/// Finds out whether a picture fits the memory as a whole, or else in which pieces, and tells what it will take.
///
/// # Errors
/// It doesn't fit, or can't be rendered in pieces; the text says what to do. What a former run has left can't be read.
pub(super) fn plan(
    job: &RenderJob,
    seen: &Seen,
    gpu: &Device,
    bar: &Bar,
) -> Result<Option<Division>, Failure> {
    let loaded = seen.opening.loaded();
    let need = |job: &RenderJob| {
        let settings = settings(job, &loaded.camera, &seen.sight, seen.beside.clone());
        let devices = std::slice::from_ref(gpu);
        Need::of(job, &settings, &loaded.scene, &loaded.procedural, devices)
    };
    let left = left::left();
    let fits = |job: &RenderJob, need: &Need| {
        let device = gpu.description();
        let most = device.max_storage_binding.min(device.max_buffer);
        is_bound([job.width, job.height], &device.name, most)?;
        need.check(job.memory, left)
    };
    // What was begun in pieces goes on in them.
    let begun = match job.checkpoints.as_ref().is_some_and(|c| c.resumes) {
        true => Store::division(job)?,
        false => None,
    };
    let whole = need(job);
    let at_once = is_one_film(job).and_then(|()| fits(job, &whole));
    let refused = match (at_once, begun) {
        (Ok(()), None) => {
            memory::tell(&whole.text(), bar);
            return Ok(None);
        }
        (refused, _) => refused.err(),
    };
    if let Some(because) = indivisible(job) {
        return Err(Failure::Failed(match refused {
            Some(failure) => {
                format!("{failure}; it can't be rendered in pieces instead: {because}")
            }
            None => format!(
                "pieces of the picture are there, which can't be gone on with: {because}, or render without --resume to begin anew"
            ),
        }));
    }
    let first = |division: &Division| job.piece(&division.piece(0));
    let division = begun.unwrap_or_else(|| {
        let pixels = match job.method.has_photons() {
            true => PIXELS_WITH_PHOTONS,
            false => PIXELS,
        };
        Division::fitting([job.width, job.height], pixels, |division| {
            let own = first(division);
            fits(&own, &need(&own)).is_ok()
        })
    });
    let own = first(&division);
    let needed = need(&own);
    fits(&own, &needed).map_err(|failure| Failure::Failed(format!("{failure}, in {division}")))?;
    memory::tell(&format!("{}, in {division}", needed.text()), bar);
    Ok(Some(division))
}

/// Whether a picture may be one film, wherever that fits.
///
/// # Errors
/// It has more pixels than films may have.
pub(super) fn is_one_film(job: &RenderJob) -> Result<(), Failure> {
    let pixels = u64::from(job.width) * u64::from(job.height);
    match pixels > MAX_PIXELS {
        true => Err(Failure::Failed(format!(
            "{pixels} pixels are more than the {MAX_PIXELS} that are rendered at once"
        ))),
        false => Ok(()),
    }
}

/// Bytes of a pixel in each of the buffers that hold a film on a device.
const BUFFER_PIXEL: u64 = 16;

/// Whether a film of so many columns and rows can be bound by a device, which binds so many bytes of a buffer at most.
///
/// # Errors
/// It can't.
fn is_bound(size: [u32; 2], device: &str, most: u64) -> Result<(), Failure> {
    let pixels: u64 = size.map(u64::from).iter().product();
    match pixels.saturating_mul(BUFFER_PIXEL) {
        bytes if bytes > most => Err(Failure::Failed(format!(
            "each buffer of the picture takes {bytes} bytes, but {device} binds at most {most}: \
             render a part (--crop) or a smaller picture (--scale)"
        ))),
        _ => Ok(()),
    }
}

/// Why a picture can't be rendered in pieces, if it can't.
fn indivisible(job: &RenderJob) -> Option<String> {
    let outputs = &job.outputs;
    let is_jpeg = |output: &Output| output.format == Format::Jpeg;
    if job.denoise {
        return Some("--denoise looks at the whole picture at once; leave it out".to_owned());
    }
    if !outputs.films.is_empty() {
        return Some("a .patina-film is written as a whole; write EXR or PNG".to_owned());
    }
    if outputs.pictures.iter().any(is_jpeg) {
        return Some("a JPEG file is written as a whole; write PNG or EXR".to_owned());
    }
    if job.checkpoints.as_ref().is_some_and(|c| c.with_pictures) {
        return Some("--refresh writes the whole picture again and again; leave it out".to_owned());
    }
    let flag = job.accuracy.map_or(method_flag(job.method), |a| a.flag());
    let is_learned = match job.method {
        Method::Path | Method::Photons => false,
        Method::Draft | Method::Cache | Method::CachePhotons => true,
    };
    (is_learned && job.motion.shutter.is_some()).then(|| {
        format!(
            "with {flag} light would be found out about anew for each moment of each piece; render with --method path"
        )
    })
}

impl RenderJob {
    /// The same of a piece. What is kept of it while it is under way is the business of whoever renders all.
    fn piece(&self, piece: &Piece) -> Self {
        let here = self.crop.unwrap_or(Crop {
            left: 0,
            top: 0,
            whole: [self.width, self.height],
        });
        Self {
            height: piece.rows,
            piece_of: Some(Divided {
                size: [self.width, self.height],
                crop: self.crop,
            }),
            crop: Some(Crop {
                top: here.top + piece.top,
                ..here
            }),
            checkpoints: None,
            ..self.clone()
        }
    }
}

/// Renders all pieces.
///
/// # Errors
/// What the device refuses; a piece that can't be kept, or a former one that can't be gone on with.
pub(super) fn render(
    job: &RenderJob,
    division: Division,
    start: Start<'_>,
    gpu: &Device,
    view: &View,
    bar: &Bar,
) -> Result<Rendered, Failure> {
    let Start {
        scene,
        sights,
        reel,
        clock,
    } = start;
    let (seen, session) = match scene {
        Scene::New(seen) => (seen, None),
        Scene::Next(seen, session) => (seen, Some(session)),
        Scene::Same(_) => {
            let what = "a picture in pieces begins with its scene";
            return Err(Failure::Failed(what.to_owned()));
        }
    };
    let Described {
        written,
        names,
        beside,
    } = Described::new(job, &seen);
    let device = gpu.description().name.clone();
    let mut origin = Origin::new(&device, &job.scene, job.look.as_deref(), written);
    origin.names.clone_from(&names);
    let mut pieces = Pieces::new(division, Store::open(job)?);
    let mut refined = match job.accuracy {
        Some(Accuracy::Final) => pieces.store().refined(&division)?,
        _ => 0,
    };
    let mut work = Work {
        job,
        gpu,
        view,
        bar,
        clock,
        renderer: Renderer {
            seen: Some(seen),
            session,
            beside,
            sights,
            reel,
            refined,
        },
        brightness: None,
        resumed: 0,
        prepare_seconds: 0.0,
        render_seconds: 0.0,
    };
    let (found, audit) = loop {
        checkpoint::tell_refined(&mut origin.settings, refined);
        let (found, audit) = work.all(&mut pieces, &origin)?;
        let is_wrong = audit.as_ref().is_some_and(Audit::is_wrong);
        if !is_wrong || job.accuracy != Some(Accuracy::Final) || refined == REFINEMENTS {
            break (found, audit);
        }
        refined += 1;
        bar.stage(REFINING);
        pieces.begin_anew()?;
        work.renderer.refine(refined);
    };
    interrupt::writes_results();
    let mut session = work.renderer.session;
    if let (Some(session), false) = (&mut session, job.stats || job.stats_json.is_some()) {
        // The film of the last piece is on the disk, and files take as much.
        session.resize(1, 1).map_err(failure)?;
    }
    if work.resumed > 0 {
        let (resumed, count) = (work.resumed, division.count());
        bar.suspend(|| {
            let were = if resumed == 1 { "was" } else { "were" };
            console::note(&format!("{resumed} of {count} pieces {were} there already"));
        });
    }
    let mut stats = found.stats;
    stats.samples_per_second = match stats.seconds > 0.0 {
        true => pieces.tally().samples() as f64 / stats.seconds,
        false => 0.0,
    };
    let (_, most) = pieces.tally().sample_bounds();
    Ok(Rendered {
        gathered: Gathered::Pieces(pieces),
        samples: job.first_sample..job.first_sample + most,
        names,
        paths: None,
        kept: None,
        ended: found.ended,
        is_preview: false,
        facts: DeviceFacts::new(gpu.description()),
        device,
        shares: Vec::new(),
        settings: origin.settings,
        audit,
        stats,
        prepare_seconds: work.prepare_seconds,
        render_seconds: work.render_seconds,
        rest: session.map_or(Rest::Nothing, Rest::Alone),
    })
}

/// What all pieces are rendered by, one after the other.
struct Renderer<'a> {
    /// What is seen first, where it isn't on the device yet.
    seen: Option<Seen>,
    session: Option<Box<Session>>,
    beside: Option<Arc<Beside>>,
    /// The moments of an open shutter, and where they come from.
    sights: &'a [Sight],
    reel: Option<&'a mut Reel>,
    /// How often the picture has begun anew with finer records.
    refined: u32,
}

impl Renderer<'_> {
    /// Goes to a piece.
    fn ready(&mut self, own: &RenderJob, gpu: &Device, bar: &Bar) -> Result<Ready, Failure> {
        let is_begun = self.seen.is_none();
        let scene = match (self.seen.take(), self.session.take(), &mut self.reel) {
            (Some(seen), None, _) => Scene::New(seen),
            (Some(seen), Some(session), _) => Scene::Next(seen, session),
            // Back to the moment at which the shutter opens.
            (None, Some(session), Some(reel)) if self.sights.len() > 1 => {
                let mut seen = reel.at(&self.sights[0])?;
                seen.beside.clone_from(&self.beside);
                Scene::Next(seen, session)
            }
            (None, Some(session), _) => Scene::Same(session),
            (None, None, _) => {
                let what = "the renderer of the piece before is gone";
                return Err(Failure::Failed(what.to_owned()));
            }
        };
        let mut ready = alone::prepare(own, scene, gpu, bar)?;
        if !is_begun {
            // A former run may have begun anew.
            (0..self.refined).for_each(|_| ready.session.refine());
        }
        Ok(ready)
    }

    /// The next pieces have finer records.
    fn refine(&mut self, refined: u32) {
        self.refined = refined;
        if let Some(session) = &mut self.session {
            session.refine();
        }
    }
}

/// A picture that is rendered in pieces.
struct Work<'a> {
    job: &'a RenderJob,
    gpu: &'a Device,
    view: &'a View,
    bar: &'a Bar,
    clock: Instant,
    renderer: Renderer<'a>,
    /// Mean radiance of the whole, where pieces have to know it and do.
    brightness: Option<f64>,
    /// Pieces that were there already.
    resumed: u32,
    prepare_seconds: f64,
    render_seconds: f64,
}

impl Work<'_> {
    /// Renders all pieces that aren't there, and looks how right all are.
    fn all(
        &mut self,
        pieces: &mut Pieces,
        origin: &Origin,
    ) -> Result<(Found, Option<Audit>), Failure> {
        let job = self.job;
        let mut found = Found::default();
        let is_judged = job.method != Method::Path && self.renderer.sights.len() == 1;
        let mut comparison = is_judged.then(Comparison::default);
        for piece in pieces.division().pieces() {
            let origin = origin_of(origin, job, &piece);
            let own = job.piece(&piece);
            if let Some(film) = pieces.store().former(&piece, &origin)? {
                check_film(&film, job, &piece)?;
                if interrupt::requested() {
                    comparison = None;
                }
                if let Some(comparison) = &mut comparison {
                    let mut ready = self.renderer.ready(&own, self.gpu, self.bar)?;
                    comparison.add(&film, alone::truth(&mut ready.session)?.each_ref());
                    self.renderer.session = Some(ready.into_session());
                }
                pieces.add(job, &film);
                self.resumed += 1;
                continue;
            }
            if found.ended_early() || interrupt::requested() {
                found.ended = Some(Ended::Interrupted);
                pieces.misses(&piece);
                continue;
            }
            let rendered = self.piece(&piece, &own, &origin, &pieces.division())?;
            let Gathered::Whole(film) = rendered.gathered else {
                continue; // there are no pieces of pieces
            };
            let mut session = match rendered.rest {
                Rest::Alone(session) => Some(session),
                Rest::Together(_) | Rest::Nothing => None,
            };
            match (&mut comparison, &mut session) {
                (Some(comparison), Some(session)) if is_as_wanted(rendered.ended.as_ref()) => {
                    comparison.add(&film, alone::truth(session)?.each_ref());
                }
                _ => comparison = None,
            }
            self.renderer.session = session;
            if let Some(Ended::Interrupted) = rendered.ended {
                pieces.misses(&piece);
            } else {
                pieces.add(job, &film);
                pieces.keep(&piece, film, rendered.samples, origin)?;
            }
            found.add(job, rendered.ended, rendered.stats);
            self.prepare_seconds += rendered.prepare_seconds;
            self.render_seconds += rendered.render_seconds;
        }
        let comparison = comparison.filter(|_| is_as_wanted(found.ended.as_ref()));
        Ok((found, comparison.and_then(|comparison| comparison.audit())))
    }

    /// Renders one.
    fn piece(
        &mut self,
        piece: &Piece,
        own: &RenderJob,
        origin: &Origin,
        division: &Division,
    ) -> Result<Rendered, Failure> {
        let (job, bar) = (self.job, self.bar);
        let mut ready = self.renderer.ready(own, self.gpu, bar)?;
        learn(job, &mut ready.session, bar)?;
        if job.limits.noise.is_some() && self.brightness.is_none() {
            bar.stage("finding out how bright the picture is");
            self.brightness = Some(preview(job, own, &mut ready.session)?);
        }
        bar.piece(piece.number, division.count());
        let limits = Limits {
            time: time_of_piece(
                job.limits.time,
                &self.clock,
                division.count() - piece.number,
            ),
            ..job.limits
        };
        let known = self.brightness.filter(|&brightness| brightness > 0.0);
        let renderer = &mut self.renderer;
        let take = Take {
            ready,
            sights: renderer.sights,
            reel: renderer.reel.as_deref_mut(),
            written: Some(origin.settings.clone()),
            is_piece: true,
        };
        let watch = Watch::new(limits, *self.view, self.clock).of_piece(known);
        alone::render(own, take, self.gpu, self.view, bar, watch)
    }
}

/// What is told of the picture.
struct Described {
    written: Vec<(String, String)>,
    /// Of what layers of ids show.
    names: BTreeMap<String, Vec<String>>,
    beside: Option<Arc<Beside>>,
}

impl Described {
    fn new(job: &RenderJob, seen: &Seen) -> Self {
        let loaded = seen.opening.loaded();
        let settings = settings(job, &loaded.camera, &seen.sight, seen.beside.clone());
        Self {
            written: alone::written(job, &loaded.scene, &loaded.procedural, &settings),
            names: job.layers.names(&loaded.scene),
            beside: seen.beside.clone(),
        }
    }
}

/// Where a piece comes from: another division of the picture, or other limits, make other pieces.
fn origin_of(origin: &Origin, job: &RenderJob, piece: &Piece) -> Origin {
    let Piece {
        top, width, rows, ..
    } = piece;
    let place = format!("{width}x{rows} from row {top} on");
    let mut end = format!("after {} samples from {} on", job.spp, job.first_sample);
    if job.adaptive {
        end += " on average, adaptively";
    }
    if let Some(noise) = job.limits.noise {
        end += &format!(", or at an error of {noise}");
    }
    if let Some(flip) = job.limits.flip {
        end += &format!(", or where {flip} of noise is seen");
    }
    if let Some(time) = job.limits.time {
        end += &format!(", or after {} s of the picture", time.as_secs_f64());
    }
    let mut origin = origin.clone();
    let own = [("piece", place), ("end", end)];
    let own = own.map(|(name, value)| (name.to_owned(), value));
    origin.settings.extend(own);
    origin
}

/// Refuses a film that isn't what its header says.
fn check_film(film: &Film, job: &RenderJob, piece: &Piece) -> Result<(), Failure> {
    let is_its = (film.width, film.height) == (piece.width, piece.rows);
    match is_its && *film.layers() == job.layers {
        true => Ok(()),
        false => Err(Failure::Failed(format!(
            "piece {} has another size, or other layers; render without --resume to begin anew",
            piece.number
        ))),
    }
}

/// When the time is over for a piece: it has its share of what is left of the picture's.
fn time_of_piece(time: Option<Duration>, clock: &Instant, left: u32) -> Option<Duration> {
    let elapsed = clock.elapsed();
    time.map(|time| elapsed + time.saturating_sub(elapsed) / left.max(1))
}

/// Has it found out what all pieces have to know of the light, where paths don't find all of it by themselves.
fn learn(job: &RenderJob, session: &mut Session, bar: &Bar) -> Result<(), Failure> {
    let samples = match job.limits == Limits::default() {
        true => job.first_sample.saturating_add(job.spp.get()),
        false => UNKNOWN_SAMPLES,
    };
    while session.learn_of_whole(samples).map_err(failure)? && !interrupt::requested() {
        alone::awaits(bar, session.records_awaited().unwrap_or(0));
    }
    Ok(())
}

/// How bright the whole picture is, by a small one that takes no more memory than a piece.
fn preview(job: &RenderJob, piece: &RenderJob, session: &mut Session) -> Result<f64, Failure> {
    let pixels = |job: &RenderJob| f64::from(job.width) * f64::from(job.height);
    let scale = (pixels(piece) / pixels(job)).sqrt();
    let scaled = |side: u32| ((f64::from(side) * scale) as u32).max(1);
    let size = [scaled(job.width), scaled(job.height)];
    let crop = job.crop.map(|crop| {
        let (left, top) = (scaled(crop.left), scaled(crop.top));
        let [columns, rows] = crop.whole.map(scaled);
        Crop {
            left,
            top,
            whole: [columns.max(left + size[0]), rows.max(top + size[1])],
        }
    });
    session.set_part(size, crop).map_err(failure)?;
    while !session.step(PREVIEW).map_err(failure)?.is_done() && !interrupt::requested() {}
    let film = session.snapshot().map_err(failure)?.film;
    let here = [piece.width, piece.height];
    session.set_part(here, piece.crop).map_err(failure)?;
    Ok(Tally::of(&film).brightness())
}

/// What is found out on the way.
#[derive(Default)]
struct Found {
    ended: Option<Ended>,
    stats: Stats,
}

impl Found {
    fn ended_early(&self) -> bool {
        matches!(self.ended, Some(Ended::Interrupted | Ended::Failed(_)))
    }

    /// Adds what a piece has found out, whose renderer goes on counting but for what is wrong with the samples.
    fn add(&mut self, job: &RenderJob, ended: Option<Ended>, mut stats: Stats) {
        stats.invalid_samples += self.stats.invalid_samples;
        stats.clamped_samples += self.stats.clamped_samples;
        stats.non_finite_hits += self.stats.non_finite_hits;
        stats.endless_texture = stats.endless_texture.or(self.stats.endless_texture.take());
        stats.non_finite_node = stats.non_finite_node.or(self.stats.non_finite_node.take());
        self.stats = stats;
        // The time is that of all, and what it has ended counts more than what was good enough.
        let ended = match (ended, job.limits.time) {
            (Some(Ended::Enough(Limit::Time(_))), Some(time)) => {
                Some(Ended::Enough(Limit::Time(time)))
            }
            (ended, _) => ended,
        };
        let is_of_time = matches!(self.ended, Some(Ended::Enough(Limit::Time(_))));
        if !is_of_time || matches!(ended, Some(Ended::Interrupted)) {
            self.ended = ended.or(self.ended.take());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_that_a_device_does_not_bind_is_refused_before_it_is_made() {
        let said = |size| match is_bound(size, "A", 128 << 20) {
            Ok(()) => String::new(),
            Err(failure) => failure.to_string(),
        };
        assert_eq!(said([4096, 2048]), "");
        let refused = said([4200, 3000]);
        for word in ["201600000 bytes", "A binds at most 134217728"] {
            assert!(refused.contains(word), "{refused}");
        }
        // Nor does it fit in pieces that are too large.
        let division = Division::fitting([16384, 4096], 1 << 26, |division| {
            let piece = division.piece(0);
            is_bound([piece.width, piece.rows], "A", 128 << 20).is_ok()
        });
        assert_eq!(division.to_string(), "8 pieces of 16384x512");
    }
}
