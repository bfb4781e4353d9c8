//! How rendering scales: with threads, with the size of the pieces that a picture is cut into, and with devices that render
//! one picture together.
//!
//! The questions are those of M. Jaroš et al., "Acceleration of Blender Cycles Path-Tracing Engine using Intel Many Integrated
//! Core Architecture" (2015), whose tables give times by threads, by sizes of tiles from 32x32 to 2048x2048 and by sizes of the
//! picture. There, too, two ways are compared to put threads to work: each on a tile of its own, or all of them on one.
//!
//! A piece of TxT is as many pixels, in the order of blocks of 8x8, row by row: a strip rather than a square. A *range* is
//! one sample of these pixels, a *tile* all of their samples.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use device::{Device, DeviceChoice, DeviceError};
use engine::film::Film;
use engine::fleet::{Fleet, Plan};
use engine::procedural::Procedural;
use engine::renderer::{RenderError, Renderer};
use engine::scene::{Camera, Scene};
use engine::settings::RenderSettings;
use engine::system::System;
use serde::Serialize;

use crate::spread::Spread;

/// Bytes of all films of a case at most, so that many threads on large pictures don't fill the memory.
const MOST_FILM_BYTES: u64 = 8 << 30;
/// Bytes of a pixel in a film.
const PIXEL_BYTES: u64 = 80;

/// Columns, and rows, of the picture from which the time of the first case is known: at most so many.
const MOST_TRIED_SIDE: u32 = 256;
/// How often it is asked whether devices that render together are to end.
const LOOK: Duration = Duration::from_millis(200);

/// Devices that are to begin together wait for each other no longer than this.
const PATIENCE: Duration = Duration::from_secs(120);

/// What is measured, and how.
#[derive(Debug, Clone)]
pub struct Setup {
    /// What is rendered.
    pub scene: Arc<Scene>,
    /// Its textures.
    pub procedural: Arc<Procedural>,
    /// From where.
    pub camera: Camera,
    /// Most scattering vertices of a path.
    pub max_depth: u32,
    /// Samples of each pixel.
    pub spp: u32,
    /// Columns, and rows, of the pictures: ascending.
    pub sides: Vec<u32>,
    /// Sides of the pieces: ascending, multiples of 8.
    pub tiles: Vec<u32>,
    /// Numbers of threads: ascending.
    pub threads: Vec<u32>,
    /// Devices that render together.
    pub devices: Vec<DeviceChoice>,
    /// Timed runs of each case, in turn; one more comes first and isn't counted.
    pub runs: u32,
    /// Cases that would be done later than this are left out.
    pub limit: Duration,
    /// Asked again and again whether to end with what there is.
    pub is_over: fn() -> bool,
}

/// How the pieces of a picture are put to work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Team {
    /// All threads on one piece, one piece after the other.
    Inside,
    /// Each thread on a piece of its own; who is done takes the next one.
    Beside,
}

impl Team {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Inside, Self::Beside];

    /// What it is called in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Inside => "threads inside a piece",
            Self::Beside => "a piece for each thread",
        }
    }
}

/// What a piece is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Piece {
    /// One sample of some pixels.
    Range,
    /// All samples of some pixels.
    Tile,
}

impl Piece {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Range, Self::Tile];

    /// What it is called in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Range => "range",
            Self::Tile => "tile",
        }
    }
}

/// A picture by some threads.
#[derive(Debug, Clone, Serialize)]
pub struct ThreadPoint {
    /// Side of the picture.
    pub side: u32,
    /// Threads.
    pub threads: u32,
    /// Wall time of a picture.
    pub seconds: Spread,
    /// Samples of pixels per second, median.
    pub samples_per_second: f64,
    /// How much faster than the fewest threads, run by run.
    pub speedup: Spread,
    /// That, per thread: 1 is perfect.
    pub efficiency: f64,
}

/// A picture in pieces, by the most threads.
#[derive(Debug, Clone, Serialize)]
pub struct PiecePoint {
    /// Side of the picture.
    pub side: u32,
    /// Side of a piece.
    pub tile: u32,
    /// What a piece is.
    pub piece: Piece,
    /// Who works on it.
    pub team: Team,
    /// Wall time of a picture.
    pub seconds: Spread,
    /// Samples of pixels per second, median.
    pub samples_per_second: f64,
}

/// Devices beside each other, and each alone.
#[derive(Debug, Clone, Serialize)]
pub struct TogetherPoint {
    /// Side of the picture.
    pub side: u32,
    /// The devices.
    pub devices: Vec<String>,
    /// Samples of pixels per second of each alone, median.
    pub alone: Vec<f64>,
    /// Of all together, median.
    pub together: f64,
    /// Together, over the sum of each alone, run by run.
    pub of_sum: Spread,
    /// Where all are the processor's: of one device with as many threads, median.
    pub one: Option<f64>,
    /// Together, over that, run by run.
    pub of_one: Option<Spread>,
    /// Each device's part of the samples in the last run, 0 to 1.
    pub shares: Vec<f64>,
}

/// A case without figures.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Which.
    pub case: String,
    /// Why.
    pub reason: String,
}

/// What was found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct ScalingReport {
    /// By side and threads.
    pub threads: Vec<ThreadPoint>,
    /// By side.
    pub together: Vec<TogetherPoint>,
    /// By side, size of the pieces, kind and team.
    pub pieces: Vec<PiecePoint>,
    /// What took too long, or too much.
    pub left_out: Vec<LeftOut>,
}

impl ScalingReport {
    /// Whether there is a row in any table.
    pub fn has_figures(&self) -> bool {
        !(self.threads.is_empty() && self.together.is_empty() && self.pieces.is_empty())
    }
}

/// Why nothing can be measured.
#[derive(Debug, thiserror::Error)]
pub enum ScalingError {
    /// A device can't be opened.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The scene can't be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A device has failed while several rendered.
    #[error("{device}: {reason}")]
    Lost {
        /// The device.
        device: String,
        /// What it said.
        reason: String,
    },
}

/// Measures everything; `progress` hears of each case that begins, and what there is by then.
///
/// # Errors
/// A device that can't be opened, or can't render the scene.
pub fn measure(
    setup: &Setup,
    mut progress: impl FnMut(&str, &ScalingReport),
) -> Result<ScalingReport, ScalingError> {
    let mut report = ScalingReport::default();
    let start = Instant::now();
    progress("how fast it is", &report);
    let mut budget = Budget {
        start,
        limit: setup.limit,
        rate: setup.rate()?,
        is_over: setup.is_over,
        was_over: false,
    };
    for &side in &setup.sides {
        measure_threads(setup, side, &mut budget, &mut report, &mut progress)?;
    }
    for &side in &setup.sides {
        measure_together(setup, side, &mut budget, &mut report, &mut progress)?;
    }
    for &side in &setup.sides {
        for &tile in setup.tiles.iter().filter(|&&tile| tile <= side) {
            measure_pieces(setup, (side, tile), &mut budget, &mut report, &mut progress)?;
        }
    }
    if budget.was_over {
        report.left_out.push(LeftOut {
            case: "all that isn't here".to_owned(),
            reason: "interrupted".to_owned(),
        });
    }
    Ok(report)
}

/// The time that may still be spent.
struct Budget {
    start: Instant,
    limit: Duration,
    /// Samples per second of a case like those to come.
    rate: f64,
    is_over: fn() -> bool,
    /// It was, before everything was measured.
    was_over: bool,
}

impl Budget {
    /// Whether nothing more is to be measured.
    fn is_over(&mut self) -> bool {
        self.was_over |= (self.is_over)();
        self.was_over
    }

    /// Renders a picture; false where it is ended before that.
    fn render(&mut self, renderer: &mut Renderer, spp: u32) -> Result<bool, RenderError> {
        while !self.is_over() {
            if renderer.step(spp)?.is_done() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Why so many samples, whose films take so many bytes, can't be rendered.
    fn refuses(&self, samples: f64, film_bytes: u64) -> Option<String> {
        if film_bytes > MOST_FILM_BYTES {
            return Some(format!("its films would take {} GiB", film_bytes >> 30));
        }
        let expected = samples / self.rate;
        let left = self.limit.as_secs_f64() - self.start.elapsed().as_secs_f64();
        (expected > left).then(|| {
            format!(
                "it would take about {expected:.0} s; a longer limit, fewer samples or fewer runs measure it"
            )
        })
    }
}

impl Setup {
    fn settings(&self, side: u32) -> RenderSettings {
        RenderSettings {
            max_depth: self.max_depth,
            ..RenderSettings::new(side, side, &self.camera)
        }
    }

    /// Samples of pixels of a picture.
    fn samples(&self, side: u32) -> f64 {
        f64::from(side) * f64::from(side) * f64::from(self.spp)
    }

    /// A renderer on so many threads of its own, all kernels of which have run.
    fn renderer(&self, threads: u32, side: u32) -> Result<Renderer, ScalingError> {
        let device = Device::open(&DeviceChoice::Native(threads))?;
        let (scene, procedural) = (&self.scene, &self.procedural);
        let mut renderer = Renderer::new(&device, scene, procedural, &self.settings(side))?;
        renderer.warm_up()?;
        Ok(renderer)
    }

    /// Samples of pixels per second of the most threads, as a small picture of one sample has it. What is compiled beside its use
    /// is awaited.
    fn rate(&self) -> Result<f64, ScalingError> {
        let smallest = self.sides.first().copied().unwrap_or(MOST_TRIED_SIDE);
        let side = smallest.min(MOST_TRIED_SIDE);
        let mut renderer = self.renderer(self.most_threads(), side)?;
        renderer.device().finish_compiling();
        let start = Instant::now();
        renderer.render(1)?;
        let seconds = start.elapsed().as_secs_f64();
        Ok(f64::from(side) * f64::from(side) / seconds.max(1e-9))
    }

    /// All rounds, the one that isn't counted, too.
    fn rounds(&self) -> f64 {
        f64::from(self.runs + 1)
    }

    fn most_threads(&self) -> u32 {
        self.threads.last().copied().unwrap_or(1)
    }
}

/// Bytes of so many films of a picture.
fn film_bytes(side: u32, films: u64) -> u64 {
    u64::from(side) * u64::from(side) * PIXEL_BYTES * films
}

fn ratios(of: &[f64], over: &[f64]) -> Spread {
    Spread::of(of.iter().zip(over).map(|(a, b)| a / b.max(1e-9)))
}

fn measure_threads(
    setup: &Setup,
    side: u32,
    budget: &mut Budget,
    report: &mut ScalingReport,
    progress: &mut impl FnMut(&str, &ScalingReport),
) -> Result<(), ScalingError> {
    if budget.is_over() {
        return Ok(());
    }
    let samples = setup.samples(side);
    let case = format!("threads, {side}x{side}");
    let first = setup.threads.first().copied().unwrap_or(1);
    // The rate is that of the most threads.
    let pictures: f64 = (setup.threads.iter())
        .map(|&count| f64::from(setup.most_threads()) / f64::from(count))
        .sum();
    let bytes = film_bytes(side, setup.threads.len() as u64);
    if let Some(reason) = budget.refuses(samples * pictures * setup.rounds(), bytes) {
        report.left_out.push(LeftOut { case, reason });
        return Ok(());
    }
    progress(&case, report);
    let renderers = setup
        .threads
        .iter()
        .map(|&count| setup.renderer(count, side));
    let mut renderers: Vec<Renderer> = renderers.collect::<Result<_, _>>()?;
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); renderers.len()];
    for round in 0..=setup.runs {
        for (renderer, times) in renderers.iter_mut().zip(&mut times) {
            renderer.restart();
            // Faster code of textures would else come in the midst of a run.
            renderer.device().finish_compiling();
            let start = Instant::now();
            if !budget.render(renderer, setup.spp)? {
                return Ok(());
            }
            if round > 0 {
                times.push(start.elapsed().as_secs_f64());
            }
        }
    }
    for (&threads, of) in setup.threads.iter().zip(&times) {
        let seconds = Spread::of(of.iter().copied());
        let speedup = ratios(&times[0], of);
        let samples_per_second = samples / seconds.median.max(1e-9);
        budget.rate = samples_per_second;
        report.threads.push(ThreadPoint {
            side,
            threads,
            seconds,
            samples_per_second,
            efficiency: speedup.median * f64::from(first) / f64::from(threads),
            speedup,
        });
    }
    Ok(())
}

fn measure_together(
    setup: &Setup,
    side: u32,
    budget: &mut Budget,
    report: &mut ScalingReport,
    progress: &mut impl FnMut(&str, &ScalingReport),
) -> Result<(), ScalingError> {
    if setup.devices.is_empty() || budget.is_over() {
        return Ok(());
    }
    let samples = setup.samples(side);
    let names: Vec<String> = setup.devices.iter().map(ToString::to_string).collect();
    let case = format!("{} together, {side}x{side}", names.join(" and "));
    // As if each were a thread of the processor's: others may take longer or shorter.
    let pictures = 2.0 + setup.devices.len() as f64 * f64::from(setup.most_threads());
    let bytes = film_bytes(side, setup.devices.len() as u64 + 2);
    if let Some(reason) = budget.refuses(samples * pictures * setup.rounds(), bytes) {
        report.left_out.push(LeftOut { case, reason });
        return Ok(());
    }
    progress(&case, report);
    let plan = Plan {
        scene: Arc::clone(&setup.scene),
        procedural: Arc::clone(&setup.procedural),
        settings: setup.settings(side),
        spp: setup.spp,
        times_passes: false,
        system: System::default(),
    };
    let opened = setup.devices.iter().map(Device::open);
    let devices: Vec<Device> = opened.collect::<Result<_, _>>()?;
    let native = setup.devices.iter().map(|choice| match choice {
        DeviceChoice::Native(threads) => Some(*threads),
        _ => None,
    });
    // As many threads in one device.
    let one = native.sum::<Option<u32>>();
    let one = one.map(|threads| Device::open(&DeviceChoice::Native(threads)));
    let one = one.transpose()?;
    let mut alone: Vec<Vec<f64>> = vec![Vec::new(); devices.len()];
    let (mut all, mut of_one) = (Vec::new(), Vec::new());
    let mut shares = Vec::new();
    for round in 0..=setup.runs {
        let mut rates = Vec::new();
        for device in &devices {
            rates.push(by_devices(&plan, std::slice::from_ref(device), budget)?.0);
        }
        let (rate, parts) = by_devices(&plan, &devices, budget)?;
        let reference = match &one {
            Some(one) => Some(by_devices(&plan, std::slice::from_ref(one), budget)?.0),
            None => None,
        };
        if budget.was_over {
            return Ok(());
        }
        if round > 0 {
            alone
                .iter_mut()
                .zip(rates)
                .for_each(|(of, rate)| of.push(rate));
            all.push(rate);
            of_one.extend(reference);
            shares = parts;
        }
    }
    let sums: Vec<f64> = (0..all.len())
        .map(|run| alone.iter().map(|of| of[run]).sum())
        .collect();
    let median = |of: &[f64]| Spread::of(of.iter().copied()).median;
    let named = setup.devices.iter().zip(&devices);
    let named = named.map(|(choice, device)| match choice {
        DeviceChoice::Native(_) => choice.to_string(),
        _ => device.description().name.clone(),
    });
    report.together.push(TogetherPoint {
        side,
        devices: named.collect(),
        alone: alone.iter().map(|of| median(of)).collect(),
        together: median(&all),
        of_sum: ratios(&all, &sums),
        one: one.is_some().then(|| median(&of_one)),
        of_one: one.is_some().then(|| ratios(&all, &of_one)),
        shares,
    });
    Ok(())
}

/// Samples per second of a picture by some devices, once all of them are ready, and the part of each; of as much of it as there is
/// where it is ended early.
fn by_devices(
    plan: &Plan,
    devices: &[Device],
    budget: &mut Budget,
) -> Result<(f64, Vec<f64>), ScalingError> {
    for device in devices {
        device.finish_compiling();
    }
    let missing = Arc::new(AtomicUsize::new(devices.len()));
    let recruits = devices.iter().map(|device| {
        let missing = Arc::clone(&missing);
        plan.recruit(device).wrapped(move |worker| {
            missing.fetch_sub(1, Ordering::Relaxed);
            let start = Instant::now();
            // One that fails before it is ready isn't waited for without end.
            while missing.load(Ordering::Relaxed) > 0 && start.elapsed() < PATIENCE {
                std::thread::sleep(Duration::from_millis(1));
            }
            worker
        })
    });
    let fleet = Fleet::start(plan, recruits);
    while !fleet.is_over() {
        if budget.is_over() {
            fleet.stop();
        }
        fleet.wait(LOOK);
    }
    let outcome = fleet.outcome();
    if let Some(loss) = fleet.losses().pop() {
        return Err(ScalingError::Lost {
            device: loss.device,
            reason: loss.reason,
        });
    }
    fleet.join();
    let shares = outcome.devices.iter().map(|share| share.share).collect();
    Ok((outcome.stats.samples_per_second, shares))
}

fn measure_pieces(
    setup: &Setup,
    (side, tile): (u32, u32),
    budget: &mut Budget,
    report: &mut ScalingReport,
    progress: &mut impl FnMut(&str, &ScalingReport),
) -> Result<(), ScalingError> {
    if budget.is_over() {
        return Ok(());
    }
    let samples = setup.samples(side);
    let threads = setup.most_threads();
    let case = format!("pieces of {tile}x{tile}, {side}x{side}");
    let pictures = (Team::ALL.len() * Piece::ALL.len()) as f64;
    let bytes = film_bytes(side, u64::from(threads) + 2);
    if let Some(reason) = budget.refuses(samples * pictures * setup.rounds(), bytes) {
        report.left_out.push(LeftOut { case, reason });
        return Ok(());
    }
    progress(&case, report);
    let mut inside = [setup.renderer(threads, side)?];
    let beside = (0..threads).map(|_| setup.renderer(1, side));
    let mut beside: Vec<Renderer> = beside.collect::<Result<_, _>>()?;
    let cases = Piece::ALL.map(|piece| Team::ALL.map(|team| (piece, team)));
    let cases = cases.as_flattened();
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); cases.len()];
    for round in 0..=setup.runs {
        for (&(piece, team), times) in cases.iter().zip(&mut times) {
            let renderers = match team {
                Team::Inside => &mut inside[..],
                Team::Beside => &mut beside[..],
            };
            let pieces = pieces(renderers[0].paths_per_sample(), tile, setup.spp, piece);
            for renderer in renderers.iter() {
                renderer.device().finish_compiling();
            }
            let start = Instant::now();
            in_pieces(renderers, &pieces, setup.is_over)?;
            if budget.is_over() {
                return Ok(());
            }
            if round > 0 {
                times.push(start.elapsed().as_secs_f64());
            }
        }
    }
    for (&(piece, team), times) in cases.iter().zip(&times) {
        let seconds = Spread::of(times.iter().copied());
        report.pieces.push(PiecePoint {
            side,
            tile,
            piece,
            team,
            samples_per_second: samples / seconds.median.max(1e-9),
            seconds,
        });
    }
    Ok(())
}

/// The pieces of a picture of so many paths per sample: ranges of paths, which one renderer does one after the other.
fn pieces(per_sample: u64, tile: u32, spp: u32, piece: Piece) -> Vec<Vec<Range<u64>>> {
    let length = u64::from(tile) * u64::from(tile);
    let starts = || (0..per_sample).step_by(length as usize);
    let of_sample = |sample: u32, start: u64| {
        let first = u64::from(sample) * per_sample;
        first + start..first + (start + length).min(per_sample)
    };
    match piece {
        Piece::Range => (0..spp)
            .flat_map(|sample| starts().map(move |start| vec![of_sample(sample, start)]))
            .collect(),
        Piece::Tile => starts()
            .map(|start| (0..spp).map(|sample| of_sample(sample, start)).collect())
            .collect(),
    }
}

/// Renders all pieces, or as many as there is time for: each renderer takes the next one as soon as it is done with its last. The sum
/// of their films.
fn in_pieces(
    renderers: &mut [Renderer],
    pieces: &[Vec<Range<u64>>],
    is_over: fn() -> bool,
) -> Result<Option<Film>, RenderError> {
    let next = AtomicUsize::new(0);
    let work = |renderer: &mut Renderer| {
        while let Some(piece) = pieces.get(next.fetch_add(1, Ordering::Relaxed)) {
            for range in piece {
                let mut at = range.start;
                while at < range.end && !is_over() {
                    at += renderer.render_paths(at..range.end)?;
                }
            }
        }
        renderer.take_film()
    };
    let films: Vec<Result<Film, RenderError>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (renderers.iter_mut())
            .map(|renderer| scope.spawn(|| work(renderer)))
            .collect();
        let joined = threads.into_iter().map(|thread| thread.join());
        joined
            .map(|film| film.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    let mut sum: Option<Film> = None;
    for film in films {
        let film = film?;
        match &mut sum {
            Some(sum) => sum.add(&film),
            None => sum = Some(film),
        }
    }
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes;
    use engine::procedural::TextureSources;
    use engine::scene::look::Look;
    use std::path::Path;

    fn setup() -> Setup {
        let mut scene = scenes::cornell_box();
        let nothing = Look::parse(Path::new(""), "").unwrap_or_else(|error| panic!("{error}"));
        let procedural = Procedural::build(&nothing, &mut scene, &TextureSources::default());
        Setup {
            camera: scene.cameras[0].clone(),
            procedural: Arc::new(procedural.unwrap_or_else(|error| panic!("{error}"))),
            scene: Arc::new(scene),
            max_depth: 3,
            spp: 3,
            sides: vec![40, 64],
            tiles: vec![16, 32, 64],
            threads: vec![1, 2],
            devices: vec![DeviceChoice::Native(1); 2],
            runs: 1,
            limit: Duration::from_secs(3600),
            is_over: || false,
        }
    }

    #[test]
    fn pieces_cover_the_picture_once() {
        for piece in Piece::ALL {
            let mut all: Vec<Range<u64>> = pieces(40 * 40, 16, 3, piece).concat();
            all.sort_by_key(|range| range.start);
            let mut at = 0;
            for range in all {
                assert_eq!(range.start, at);
                at = range.end;
            }
            assert_eq!(at, 3 * 40 * 40);
        }
    }

    #[test]
    fn a_picture_in_pieces_is_the_whole_picture() {
        let setup = setup();
        let mut whole = setup
            .renderer(2, 40)
            .unwrap_or_else(|error| panic!("{error}"));
        whole.render(3).unwrap_or_else(|error| panic!("{error}"));
        let whole = whole.film().unwrap_or_else(|error| panic!("{error}"));
        for piece in Piece::ALL {
            let mut renderers = [1, 1].map(|threads| {
                let renderer = setup.renderer(threads, 40);
                renderer.unwrap_or_else(|error| panic!("{error}"))
            });
            let pieces = pieces(40 * 40, 16, 3, piece);
            let film = in_pieces(&mut renderers, &pieces, || false);
            let film = film.unwrap_or_else(|error| panic!("{error}"));
            assert!(film.as_ref() == Some(&whole), "{piece:?}");
        }
    }

    #[test]
    fn all_tables_are_filled_and_a_limit_is_kept() {
        let setup = setup();
        let mut had_figures = Vec::new();
        let report = measure(&setup, |_, report| had_figures.push(report.has_figures()));
        let report = report.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(had_figures[..3], [false, false, true]);
        assert_eq!(report.threads.len(), 4);
        assert_eq!(report.together.len(), 2);
        // Pieces of 16 and 32 in both pictures, of 64 in one.
        assert_eq!(report.pieces.len(), 5 * 4);
        assert_eq!(report.left_out, []);
        assert!(report.pieces.iter().all(|point| point.seconds.median > 0.0));
        let none = Setup {
            limit: Duration::ZERO,
            ..setup
        };
        let report = measure(&none, |_, _| ()).unwrap_or_else(|error| panic!("{error}"));
        assert!(!report.has_figures(), "the first case, too, has a limit");
        assert_eq!(report.left_out.len(), 2 + 2 + 5);
    }

    #[test]
    fn what_is_ended_early_says_so_and_gives_what_there_is() {
        let ended = Setup {
            is_over: || true,
            ..setup()
        };
        let report = measure(&ended, |_, _| ()).unwrap_or_else(|error| panic!("{error}"));
        assert!(!report.has_figures());
        let reasons: Vec<&str> = (report.left_out.iter())
            .map(|left_out| left_out.reason.as_str())
            .collect();
        assert_eq!(reasons, ["interrupted"]);
        // Within the second case: what the first has stays.
        static ASKED: AtomicUsize = AtomicUsize::new(0);
        static LIMIT: AtomicUsize = AtomicUsize::new(usize::MAX);
        let later = Setup {
            is_over: || ASKED.fetch_add(1, Ordering::Relaxed) > LIMIT.load(Ordering::Relaxed),
            ..setup()
        };
        let report = measure(&later, |_, report| {
            if report.has_figures() {
                LIMIT.store(0, Ordering::Relaxed);
            }
        });
        let report = report.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((report.threads.len(), report.together.len()), (2, 0));
        assert_eq!(report.left_out.len(), 1);
    }
}
