//! Ways to render one picture, and how long each takes until it is good enough.
//!
//! Each method renders the picture anew with more and more samples per pixel, all of it timed, what it prepares before included. What comes
//! of it is compared with a converged picture by what people see (FLIP: Andersson et al., "FLIP: A Difference Evaluator for Alternating
//! Images", 2020). What is *final* says [`pictures::seen`].
//!
//! Methods take turns at each number of samples; one that is final is done.

use std::time::{Duration, Instant};

use device::Device;
use engine::adaptive::{GRAIN, Goal, next_round};
use engine::film::Film;
use engine::procedural::Procedural;
use engine::renderer::{RenderError, Renderer};
use engine::scene::Scene;
use engine::settings::{Method, RenderSettings};
use pictures::seen::{FINAL, Seen};
use pictures::{Distance, Layer};
use serde::Serialize;

use crate::spread::Spread;

/// A way to render.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum How {
    /// Paths, as many for each pixel.
    Path,
    /// Paths, more where the picture is noisier.
    Adaptive,
    /// Paths that end in a cache of scattered light.
    Draft,
    /// Records of irradiance.
    Cache,
    /// Paths, and photons for caustics.
    Photons,
    /// Records of irradiance, and photons for caustics.
    #[serde(rename = "cache+photons")]
    CachePhotons,
}

impl How {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Path,
        Self::Adaptive,
        Self::Draft,
        Self::Cache,
        Self::Photons,
        Self::CachePhotons,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Adaptive => "adaptive",
            Self::Draft => "draft",
            Self::Cache => "cache",
            Self::Photons => "photons",
            Self::CachePhotons => "cache+photons",
        }
    }

    fn method(self) -> Method {
        match self {
            Self::Path | Self::Adaptive => Method::Path,
            Self::Draft => Method::Draft,
            Self::Cache => Method::Cache,
            Self::Photons => Method::Photons,
            Self::CachePhotons => Method::CachePhotons,
        }
    }
}

/// What is measured, and how.
#[derive(Debug, Clone)]
pub struct Setup<'a> {
    /// What is rendered.
    pub scene: &'a Scene,
    /// Its textures.
    pub procedural: &'a Procedural,
    /// From where, and how large.
    pub settings: RenderSettings,
    /// The ways.
    pub methods: Vec<How>,
    /// Columns and rows of what they are compared with, and its colours; rendered by paths where there is none.
    pub reference: Option<([usize; 2], Vec<[f32; 3]>)>,
    /// Samples of each pixel of that.
    pub reference_spp: u32,
    /// Most samples of each pixel.
    pub most_spp: u32,
    /// Times that each is rendered.
    pub runs: u32,
    /// Brightness in stops by which pictures are compared.
    pub exposure: f32,
    /// Nothing begins that would be done later than this.
    pub limit: Duration,
    /// Asked again and again whether to end with what there is.
    pub is_over: fn() -> bool,
}

/// A picture of so many samples.
#[derive(Debug, Clone, Serialize)]
pub struct Point {
    /// Samples per pixel.
    pub spp: u32,
    /// Wall time.
    pub seconds: Spread,
    /// Mean FLIP, median over the runs.
    pub flip: f64,
    /// Largest connected area of pixels that one notices, of all of the picture, median.
    pub area: f64,
    /// Mean squared error over the squares of the reference, median.
    pub relative_mse: f64,
    /// Mean squared error, which is what adaptive sampling makes small, median.
    pub mse: f64,
}

impl Point {
    /// Whether the picture is good enough.
    pub fn is_final(&self) -> bool {
        let Self { flip, area, .. } = *self;
        Seen { flip, area }.is_below(FINAL)
    }
}

/// A method.
#[derive(Debug, Clone, Serialize)]
pub struct Curve {
    /// Which.
    pub how: How,
    /// With more and more samples.
    pub points: Vec<Point>,
    /// Seconds until its picture is final; `None` where that isn't reached.
    pub final_seconds: Option<f64>,
    /// Of paths, over its own; `None` where one of them isn't known.
    pub speedup: Option<f64>,
    /// The seconds in which paths reach the least mean squared error that both have reached, over its own.
    pub error_speedup: Option<f64>,
    /// Its last picture.
    #[serde(skip)]
    pub picture: Vec<[f32; 3]>,
}

/// What was found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct MethodsReport {
    /// By method.
    pub curves: Vec<Curve>,
    /// What they were compared with.
    #[serde(skip)]
    pub reference: Vec<[f32; 3]>,
    /// Why some were not taken as far as they might have been.
    pub left_out: Vec<String>,
}

impl MethodsReport {
    /// Whether any picture was measured.
    pub fn has_figures(&self) -> bool {
        self.curves.iter().any(|curve| !curve.points.is_empty())
    }
}

/// Why nothing can be measured.
#[derive(Debug, thiserror::Error)]
pub enum MethodsError {
    /// The scene can't be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The reference is another picture.
    #[error("the reference has {}x{} pixels, the picture {}x{}: they have to be of one size", .0[0], .0[1], .1[0], .1[1])]
    Reference([usize; 2], [usize; 2]),
}

/// Samples per pixel of the first pictures.
pub const LEAST_SPP: u32 = 4;

/// What [`measure`] calls the picture that others are compared with.
pub const REFERENCE: &str = "the reference";

/// A method under way.
struct Runner {
    how: How,
    renderer: Renderer,
    points: Vec<Point>,
    picture: Vec<[f32; 3]>,
}

/// Measures everything; `progress` hears of each case that begins.
///
/// # Errors
/// The scene can't be rendered, or the reference is of another size.
pub fn measure(
    device: &Device,
    setup: &Setup<'_>,
    mut progress: impl FnMut(&str),
) -> Result<MethodsReport, MethodsError> {
    let (width, height) = (setup.settings.width, setup.settings.height);
    let size = [width as usize, height as usize];
    let reference = match &setup.reference {
        Some((other, _)) if *other != size => return Err(MethodsError::Reference(*other, size)),
        Some((_, reference)) => reference.clone(),
        None => {
            progress(REFERENCE);
            // Other random numbers than those of the pictures.
            let mut settings = setup.settings.clone();
            settings.seed = settings.seed.wrapping_add(0x5eed);
            let mut renderer = Renderer::new(device, setup.scene, setup.procedural, &settings)?;
            renderer.render(setup.reference_spp)?;
            renderer.film()?.mean()
        }
    };
    let truth = Layer::rgb("", size, &reference);
    let start = Instant::now();
    let mut runners = Vec::new();
    for &how in &setup.methods {
        let mut settings = setup.settings.clone();
        settings.method = how.method();
        settings.halves = how == How::Adaptive;
        let mut renderer = Renderer::new(device, setup.scene, setup.procedural, &settings)?;
        renderer.warm_up()?;
        runners.push(Runner {
            how,
            renderer,
            points: Vec::new(),
            picture: Vec::new(),
        });
    }
    let mut report = MethodsReport::default();
    'all: for spp in numbers(setup.most_spp) {
        let mut seconds = vec![Vec::new(); runners.len()];
        let mut distances = vec![Vec::new(); runners.len()];
        for _ in 0..setup.runs {
            for (at, runner) in runners.iter_mut().enumerate() {
                let expected = runner.expected(spp);
                if !runner.goes_on(spp)
                    || start.elapsed().as_secs_f64() + expected > setup.limit.as_secs_f64()
                {
                    continue;
                }
                progress(&format!("{}, {spp} samples per pixel", runner.how.name()));
                let Some((took, film)) = runner.render(spp, setup.is_over)? else {
                    report.left_out.push("interrupted".to_owned());
                    break 'all;
                };
                runner.picture = film.mean();
                let layer = Layer::rgb("", size, &runner.picture);
                // Sizes and channels are the same.
                if let Ok(distance) = Distance::between(&layer, &truth, setup.exposure) {
                    seconds[at].push(took);
                    distances[at].push(distance);
                }
            }
        }
        for ((runner, seconds), distances) in runners.iter_mut().zip(seconds).zip(distances) {
            if distances.len() < setup.runs as usize {
                continue;
            }
            let median =
                |of: &dyn Fn(&Distance) -> f64| Spread::of(distances.iter().map(of)).median;
            runner.points.push(Point {
                spp,
                seconds: Spread::of(seconds),
                flip: median(&|d| d.flip.unwrap_or(1.0)),
                area: median(&|d| Seen::of(&d.map, size[0], FINAL).area),
                relative_mse: median(&|d| d.relative_mse),
                mse: median(&|d| d.mse),
            });
        }
    }
    report.curves = runners.into_iter().map(Runner::finish).collect();
    let of_paths = report.curves.iter().find(|curve| curve.how == How::Path);
    let (of_paths, points_of_paths) = of_paths
        .map(|curve| (curve.final_seconds, curve.points.clone()))
        .unwrap_or_default();
    for curve in &mut report.curves {
        curve.speedup = of_paths.zip(curve.final_seconds).map(|(a, b)| a / b);
        curve.error_speedup = error_speedup(&points_of_paths, &curve.points);
        if curve.final_seconds.is_none() {
            let last = curve.points.last();
            let far = last.map_or("nothing".to_owned(), |point| {
                format!("FLIP {:.4} after {:.1} s", point.flip, point.seconds.median)
            });
            let name = curve.how.name();
            report
                .left_out
                .push(format!("{name} isn't final within the limits: {far}"));
        }
    }
    report.reference = reference;
    Ok(report)
}

/// 4, 6, 8, 12, 16 and so on.
fn numbers(most: u32) -> impl Iterator<Item = u32> {
    let powers = std::iter::successors(Some(LEAST_SPP), |spp| spp.checked_mul(2));
    let all = powers.flat_map(|spp| [spp, spp.saturating_add(spp / 2)]);
    all.take_while(move |&spp| spp <= most)
}

impl Runner {
    /// Whether a picture of so many samples is still of interest.
    fn goes_on(&self, spp: u32) -> bool {
        let is_done = self.points.last().is_some_and(Point::is_final);
        // Adaptive sampling needs some samples before it knows where to send others.
        !is_done && (self.how != How::Adaptive || spp >= 2 * GRAIN)
    }

    /// Seconds that it will take, about.
    fn expected(&self, spp: u32) -> f64 {
        self.points.last().map_or(0.0, |last| {
            last.seconds.median * f64::from(spp) / f64::from(last.spp)
        })
    }

    /// A picture, and the seconds that it took; `None` where it is ended before that.
    fn render(
        &mut self,
        spp: u32,
        is_over: fn() -> bool,
    ) -> Result<Option<(f64, Film)>, RenderError> {
        self.renderer.restart();
        // Faster code of textures would else come in the midst of a run.
        self.renderer.device().finish_compiling();
        let start = Instant::now();
        if self.how == How::Adaptive {
            let goal = Goal::of_samples(spp);
            loop {
                let round = next_round(&self.renderer.film()?, &goal);
                if round.lots.is_empty() {
                    break;
                }
                for lot in &round.lots {
                    let mut from = 0;
                    while from < lot.blocks.len() {
                        if is_over() {
                            return Ok(None);
                        }
                        from += self.renderer.render_lot(lot, from)?;
                    }
                }
            }
        } else {
            while !self.renderer.step(spp)?.is_done() {
                if is_over() {
                    return Ok(None);
                }
            }
        }
        let film = self.renderer.film()?;
        Ok(Some((start.elapsed().as_secs_f64(), film)))
    }

    fn finish(self) -> Curve {
        Curve {
            how: self.how,
            final_seconds: final_seconds(&self.points),
            points: self.points,
            speedup: None,
            error_speedup: None,
            picture: self.picture,
        }
    }
}

/// When a picture became final: between the last that wasn't and the first that was, where its FLIP went below the limit on the line
/// between the logarithms; there if it was the area that was too large.
fn final_seconds(points: &[Point]) -> Option<f64> {
    let at = points.iter().position(Point::is_final)?;
    let last = &points[at];
    let before = at.checked_sub(1).map(|at| &points[at]);
    let Some(before) = before.filter(|before| before.flip > FINAL) else {
        return Some(last.seconds.median);
    };
    Some(seconds_between([before, last], |point| point.flip, FINAL))
}

/// When something that falls reached a value, on the line between the logarithms of two points.
fn seconds_between(points: [&Point; 2], of: impl Fn(&Point) -> f64, value: f64) -> f64 {
    let [from, to] = points.map(|point| of(point).max(1e-30).ln());
    let place = ((from - value.max(1e-30).ln()) / (from - to)).clamp(0.0, 1.0);
    let [from, to] = points.map(|point| point.seconds.median.max(1e-9).ln());
    (from + place * (to - from)).exp()
}

/// The seconds of some points over those of others until the least error that both have reached.
fn error_speedup(paths: &[Point], own: &[Point]) -> Option<f64> {
    let least = |points: &[Point]| points.iter().map(|point| point.mse).reduce(f64::min);
    let level = least(paths)?.max(least(own)?);
    let seconds = |points: &[Point]| {
        let at = points.iter().position(|point| point.mse <= level)?;
        let last = &points[at];
        let before = at.checked_sub(1).map(|at| &points[at]);
        Some(before.map_or(last.seconds.median, |before| {
            seconds_between([before, last], |point| point.mse, level)
        }))
    };
    Some(seconds(paths)? / seconds(own)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(spp: u32, seconds: f64, flip: f64, area: f64) -> Point {
        Point {
            spp,
            seconds: Spread::of([seconds]),
            flip,
            area,
            relative_mse: 0.0,
            mse: flip * flip,
        }
    }

    #[test]
    fn a_picture_becomes_final_between_two_points() {
        let points = [point(4, 1.0, 0.06, 0.0), point(16, 4.0, 0.015, 0.0)];
        let seconds = final_seconds(&points).expect("the last one is final");
        assert!((seconds - 2.0).abs() < 1e-9, "{seconds}");
        let spotted = [point(4, 1.0, 0.02, 0.1), point(16, 4.0, 0.015, 0.0)];
        assert_eq!(final_seconds(&spotted), Some(4.0));
        assert_eq!(final_seconds(&points[..1]), None);
        // The others come to 0.02 when these do in three seconds, on the line between 1 and 4.
        let others = [point(4, 0.5, 0.04, 0.0), point(16, 1.0, 0.02, 0.0)];
        let of_points = seconds_between([&points[0], &points[1]], |point| point.mse, 0.0004);
        let speedup = error_speedup(&points, &others).expect("both reach it");
        assert!((speedup - of_points / 1.0).abs() < 1e-9, "{speedup}");
        assert_eq!(error_speedup(&points, &[]), None);
    }

    #[test]
    fn numbers_grow_by_less_than_two() {
        let all: Vec<u32> = numbers(40).collect();
        assert_eq!(all, [4, 6, 8, 12, 16, 24, 32]);
    }
}
