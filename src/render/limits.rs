//! What ends a render before all samples are taken: the error of the picture is small enough, or the time is over.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use engine::adaptive::{FLIP_FALL, GRAIN};
use engine::audit::Audit;
use engine::film::{Film, Tally};
use engine::renderer::Progress;
use engine::scene::view::View;
use engine::view::ViewEncoder;
use pictures::seen::{self, Seen};

use crate::console;
use crate::job::{Limits, RenderJob};
use crate::progress::Reached;

/// Samples before the error is looked at: with fewer, light that is seldom met may not have been met at all.
const FEWEST: f64 = 16.0;
/// Samples before it is known what is seen: the second half begins late, and has at least half of the first one's from here on.
const FEWEST_SEEN: f64 = GRAIN as f64;
/// The error is looked at again after so many times the samples, at the least and at the most.
const SOONEST: f64 = 1.1;
const LATEST: f64 = 2.0;

/// What has ended a render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Limit {
    Noise(f64),
    Flip(f64),
    Time(Duration),
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Noise(limit) => write!(f, "--noise {limit}"),
            Self::Flip(limit) => write!(f, "--flip {limit}"),
            Self::Time(time) => write!(f, "--time {}", console::duration(*time)),
        }
    }
}

/// What is looked at of a picture under way, as far as it has a limit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    limits: Limits,
    /// How it is shown.
    view: View,
    /// Mean radiance of the picture of which this is a piece.
    brightness: Option<f64>,
}

/// How noisy a picture is, as far as is known and there is a limit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Noise {
    /// Its relative error.
    pub(super) error: Option<f64>,
    /// What is seen of it.
    pub(super) seen: Option<Seen>,
}

impl Look {
    /// At a film.
    pub(super) fn at(&self, film: &Film) -> Noise {
        let error = || {
            let tally = Tally::of(film);
            self.brightness.map_or_else(
                || tally.relative_error(),
                |brightness| tally.error_relative_to(brightness),
            )
        };
        Noise {
            error: self.limits.noise.map(|_| error()),
            seen: (self.limits.flip).and_then(|most| seen(film, &self.view, most)),
        }
    }

    /// FLIP of each pixel of a film's noise, and what its mean is to be, if that has a limit.
    pub(super) fn seen(&self, film: &Film) -> Option<(Vec<f32>, f64)> {
        let most = self.limits.flip?;
        Some((seen_map(film, &self.view)?, most))
    }
}

/// How much of a film's noise is seen where it is shown like that, against a limit. `None` where it isn't known: pixels have too few samples,
/// or they don't come in halves.
pub(super) fn seen(film: &Film, view: &View, most: f64) -> Option<Seen> {
    let map = seen_map(film, view)?;
    Some(Seen::of(&map, film.width as usize, most))
}

/// The same of each pixel.
fn seen_map(film: &Film, view: &View) -> Option<Vec<f32>> {
    if f64::from(film.sample_bounds().0) < FEWEST_SEEN {
        return None;
    }
    let is_unknown = AtomicBool::new(false);
    let pixel = |pixel: usize| {
        let halves = film.half_means(pixel);
        let halves = halves.zip(film.variance_by_halves(pixel));
        let Some(([first, second], variance)) = halves else {
            is_unknown.store(true, Ordering::Relaxed);
            return [[0.0; 3]; 2];
        };
        let n = f64::from(film.samples(pixel));
        // Half of what equal halves differ by strays as far as the mean of both does.
        let noise = |c: usize| variance[c].sqrt().copysign(first[c] - second[c]) as f32;
        [
            film.sum(pixel).map(|sum| (sum / n) as f32),
            std::array::from_fn(noise),
        ]
    };
    let encoder = ViewEncoder::new(view);
    let size = [film.width as usize, film.height as usize];
    let map = seen::noise(size, pixel, |rgb| encoder.encode(rgb));
    (!is_unknown.into_inner()).then_some(map)
}

/// Samples before there is anything to look at.
fn fewest(limits: &Limits) -> f64 {
    match limits.noise {
        Some(_) => FEWEST,
        None => FEWEST_SEEN,
    }
}

/// Watches a render.
#[derive(Debug)]
pub(super) struct Watch {
    look: Look,
    start: Instant,
    /// Samples per pixel at which the noise is looked at next.
    next: f64,
    /// Samples per pixel when it was looked at last, and what it was.
    noise: Option<(f64, Noise)>,
    /// Samples per pixel before the time may end it.
    least: f64,
}

impl Watch {
    /// Of a program that began then, and a picture that is shown so.
    pub(super) fn new(limits: Limits, view: View, start: Instant) -> Self {
        Self {
            look: Look {
                limits,
                view,
                brightness: None,
            },
            start,
            next: fewest(&limits),
            noise: None,
            least: 0.0,
        }
    }

    /// Of a piece of a picture of this brightness, to which its error is relative. The time may end it once each pixel has a sample.
    pub(super) fn of_piece(self, brightness: Option<f64>) -> Self {
        Self {
            look: Look {
                brightness,
                ..self.look
            },
            least: 1.0,
            ..self
        }
    }

    /// What it looks at.
    pub(super) fn look(&self) -> Look {
        self.look
    }

    /// The brightness of the picture of which this is a piece.
    pub(super) fn brightness(&self) -> Option<f64> {
        self.look.brightness
    }

    /// The picture begins anew, but for the time that it has.
    pub(super) fn begin_anew(&mut self) {
        (self.next, self.noise) = (fewest(&self.look.limits), None);
    }

    /// How far a render is that may end before all samples are taken, by the limit that will be reached first. `spp` are the samples of
    /// each pixel so far.
    pub(super) fn reached_so_far(&self, progress: &Progress, spp: f64) -> Reached {
        let elapsed = self.start.elapsed().as_secs_f64();
        let of_time = (self.look.limits.time).map(|time| elapsed / time.as_secs_f64());
        let of_noise = (self.noise).map_or(0.0, |(at, noise)| spp / self.wanted(at, &noise));
        let of_samples = progress.samples_done as f64 / progress.samples_total.max(1) as f64;
        let share = of_samples.max(of_noise).max(of_time.unwrap_or_default());
        Reached {
            samples: spp,
            share: share.clamp(0.0, 1.0),
        }
    }

    /// Samples per pixel at which the first limit will be reached, by what the noise is with so many; infinite where nothing says.
    fn wanted(&self, spp: f64, noise: &Noise) -> f64 {
        let Limits {
            noise: error, flip, ..
        } = self.look.limits;
        // The error falls with the root of the number of samples, or faster.
        let error = error.zip(noise.error).map(|(most, is)| (is / most).powi(2));
        let flip = (flip.zip(noise.seen)).map(|(most, is)| (is.flip / most).powf(1.0 / FLIP_FALL));
        [error, flip]
            .into_iter()
            .flatten()
            .fold(f64::INFINITY, |least, times| least.min(times * spp))
    }

    /// What the noise is found to be with so many samples per pixel: the limit that is reached by it, if one is.
    pub(super) fn knows(&mut self, spp: f64, noise: Noise) -> Option<Limit> {
        self.noise = Some((spp, noise));
        let wanted = self.wanted(spp, &noise);
        self.next = wanted.clamp(SOONEST * spp, LATEST * spp);
        let Limits {
            noise: error, flip, ..
        } = self.look.limits;
        let by_error = (error.zip(noise.error)).filter(|(most, is)| is <= most);
        let by_flip = (flip.zip(noise.seen)).filter(|(most, is)| is.is_below(*most));
        by_error
            .map(|(most, _)| Limit::Noise(most))
            .or(by_flip.map(|(most, _)| Limit::Flip(most)))
    }

    /// Whether the time is over, and so many samples per pixel are enough to end.
    pub(super) fn time_is_over(&self, spp: f64) -> Option<Limit> {
        let time = self.look.limits.time.filter(|_| spp >= self.least)?;
        (self.start.elapsed() >= time).then_some(Limit::Time(time))
    }

    /// The limit that is reached by so many samples per pixel, if one is. `noise` looks at the picture; it takes a moment, so it is asked
    /// for seldom. Where there is none yet, it gives nothing.
    ///
    /// # Errors
    /// Those of `noise`.
    pub(super) fn reached<E>(
        &mut self,
        spp: f64,
        noise: impl FnOnce(&Look) -> Result<Option<Noise>, E>,
    ) -> Result<Option<Limit>, E> {
        if let Some(limit) = self.time_is_over(spp) {
            return Ok(Some(limit));
        }
        let Limits {
            noise: error, flip, ..
        } = self.look.limits;
        if error.is_none() && flip.is_none() || spp < self.next {
            return Ok(None);
        }
        let noise = noise(&self.look)?;
        Ok(noise.and_then(|noise| self.knows(spp, noise)))
    }
}

/// What is said of a render that had limits, when it has ended.
pub(super) fn summary(
    job: &RenderJob,
    reached: Option<&Limit>,
    tally: &Tally,
    seen: Option<Seen>,
) -> Option<String> {
    if job.limits == Limits::default() && !job.adaptive {
        return None;
    }
    let (fewest, most) = tally.sample_bounds();
    let error = tally.relative_error();
    let error = match error.is_finite() {
        true => format!("relative error {}", console::significant(error)),
        false => "relative error unknown".to_owned(),
    };
    let error = match seen {
        Some(seen) => {
            let flip = console::significant(seen.flip);
            format!("{flip} of the noise seen (FLIP), {error}")
        }
        None => error,
    };
    let whole = |samples: u32| console::grouped(u64::from(samples));
    let samples = match job.adaptive {
        true => format!(
            "{error} after {:.1} samples per pixel on average, {} to {}",
            tally.mean_samples(),
            whole(fewest),
            whole(most)
        ),
        false => format!("{error} after {} samples per pixel", whole(fewest)),
    };
    Some(match reached {
        Some(limit) => format!("{samples}, ended by {limit}"),
        None => samples,
    })
}

/// What is said of a picture that is biased, perhaps by a clamp as well, or seems to be for what paths can't find.
pub(super) fn bias(audit: &Audit, has_clamp: bool, is_more_than_paths_find: bool) -> String {
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let (whole, blocks) = (&audit.brightness, &audit.blocks);
    let middle = 0.5 * (whole.start + whole.end);
    format!(
        "biased: brightness off by {:+.1} % (± {}), blocks of 8 x 8 pixels by {} to {} % of the picture's mean{}, with 95 % certainty{}",
        100.0 * middle,
        percent(whole.end - middle),
        percent(blocks.start),
        percent(blocks.end),
        match has_clamp {
            true => " beside what --clamp takes away",
            false => "",
        },
        match is_more_than_paths_find {
            true =>
                "; the paths that tell this find nothing of what glass and mirrors throw of lamps without size, which photons bring",
            false => "",
        }
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_looked_at_seldom_and_not_too_late() {
        let limits = Limits {
            noise: Some(0.01),
            ..Limits::default()
        };
        let mut watch = Watch::new(limits, View::default(), Instant::now());
        let mut looks = Vec::new();
        let mut spp = 0.0;
        let ended = loop {
            spp += 1.0;
            let noise = |_: &Look| {
                looks.push(spp);
                Ok::<_, ()>(Some(Noise {
                    error: Some(0.2 / f64::sqrt(spp)),
                    seen: None,
                }))
            };
            if let Some(limit) = watch.reached(spp, noise).unwrap() {
                break limit;
            }
        };
        assert_eq!(ended, Limit::Noise(0.01));
        assert!((400.0..440.0).contains(&spp), "{spp}");
        assert_eq!(looks, [16.0, 32.0, 64.0, 128.0, 256.0, 400.0]);
    }

    #[test]
    fn time_ends_what_noise_does_not() {
        let limits = Limits {
            noise: Some(1e-9),
            flip: None,
            time: Some(Duration::ZERO),
        };
        let begun = |limits| Watch::new(limits, View::default(), Instant::now());
        let reached = begun(limits).reached(1.0, |_| Ok::<_, ()>(Some(Noise::default())));
        let reached = reached.unwrap();
        assert_eq!(reached, Some(Limit::Time(Duration::ZERO)));
        assert_eq!(begun(Limits::default()).reached(1e6, |_| Err(())), Ok(None));
    }
}
