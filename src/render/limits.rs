//! What ends a render before all samples are taken: the error of the picture is small enough, or the time is over.

use std::fmt;
use std::time::{Duration, Instant};

use engine::audit::Audit;
use engine::film::{Film, Tally};
use engine::renderer::Progress;

use crate::console;
use crate::job::{Limits, RenderJob};
use crate::progress::Reached;

/// Samples before the error is looked at: with fewer, light that is seldom met may not have been met at all.
const FEWEST: f64 = 16.0;
/// The error is looked at again after so many times the samples, at the least and at the most.
const SOONEST: f64 = 1.1;
const LATEST: f64 = 2.0;

/// What has ended a render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Limit {
    Noise(f64),
    Time(Duration),
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Noise(limit) => write!(f, "--noise {limit}"),
            Self::Time(time) => write!(f, "--time {}", console::duration(*time)),
        }
    }
}

/// Watches a render.
#[derive(Debug)]
pub(super) struct Watch {
    limits: Limits,
    start: Instant,
    /// Samples per pixel at which the error is looked at next.
    next: f64,
    /// Samples per pixel when it was looked at last, and what it was.
    error: Option<(f64, f64)>,
    /// Mean radiance of the picture of which this is a piece.
    brightness: Option<f64>,
    /// Samples per pixel before the time may end it.
    least: f64,
}

impl Watch {
    /// Of a program that began then.
    pub(super) fn new(limits: Limits, start: Instant) -> Self {
        Self {
            limits,
            start,
            next: FEWEST,
            error: None,
            brightness: None,
            least: 0.0,
        }
    }

    /// Of a piece of a picture of this brightness, to which its error is relative. The time may end it once each pixel has a sample.
    pub(super) fn of_piece(limits: Limits, start: Instant, brightness: Option<f64>) -> Self {
        Self {
            brightness,
            least: 1.0,
            ..Self::new(limits, start)
        }
    }

    /// The brightness of the picture of which this is a piece.
    pub(super) fn brightness(&self) -> Option<f64> {
        self.brightness
    }

    /// The picture begins anew, but for the time that it has.
    pub(super) fn begin_anew(&mut self) {
        (self.next, self.error) = (FEWEST, None);
    }

    /// The error that is compared with the limit.
    pub(super) fn error_of(film: &Film, brightness: Option<f64>) -> f64 {
        let tally = Tally::of(film);
        brightness.map_or_else(
            || tally.relative_error(),
            |brightness| tally.error_relative_to(brightness),
        )
    }

    /// How far a render is that may end before all samples are taken, by the limit that will be reached first. `spp` are the samples of
    /// each pixel so far.
    pub(super) fn reached_so_far(&self, progress: &Progress, spp: f64) -> Reached {
        let elapsed = self.start.elapsed().as_secs_f64();
        let of_time = self.limits.time.map(|time| elapsed / time.as_secs_f64());
        let of_noise = match (self.limits.noise, self.error) {
            // The error of now is that of the last look, less what has come since.
            (Some(limit), Some((at, error))) => Some((limit / error).powi(2) * spp / at),
            (Some(_), None) => Some(0.0),
            (None, _) => None,
        };
        let of_samples = progress.samples_done as f64 / progress.samples_total.max(1) as f64;
        let share = [of_time, of_noise]
            .into_iter()
            .flatten()
            .fold(of_samples, f64::max);
        Reached {
            samples: spp,
            share: share.clamp(0.0, 1.0),
        }
    }

    /// What the error is found to be by others.
    pub(super) fn has_error(&mut self, spp: f64, error: f64) {
        self.error = Some((spp, error));
    }

    /// Whether the time is over, and so many samples per pixel are enough to end.
    pub(super) fn time_is_over(&self, spp: f64) -> Option<Limit> {
        let time = self.limits.time.filter(|_| spp >= self.least)?;
        (self.start.elapsed() >= time).then_some(Limit::Time(time))
    }

    /// The limit that is reached by so many samples per pixel, if one is. `error` finds out the error of the picture; it takes a
    /// moment, so it is asked for seldom. Where it can't be known yet, it gives nothing.
    ///
    /// # Errors
    /// Those of `error`.
    pub(super) fn reached<E>(
        &mut self,
        spp: f64,
        error: impl FnOnce() -> Result<Option<f64>, E>,
    ) -> Result<Option<Limit>, E> {
        if let Some(limit) = self.time_is_over(spp) {
            return Ok(Some(limit));
        }
        let Some(limit) = self.limits.noise.filter(|_| spp >= self.next) else {
            return Ok(None);
        };
        let Some(error) = error()? else {
            return Ok(None);
        };
        self.error = Some((spp, error));
        if error <= limit {
            return Ok(Some(Limit::Noise(limit)));
        }
        // It falls with the root of the number of samples, or faster.
        let wanted = spp * (error / limit).powi(2);
        self.next = wanted.clamp(SOONEST * spp, LATEST * spp);
        Ok(None)
    }
}

/// What is said of a render that had limits, when it has ended.
pub(super) fn summary(job: &RenderJob, reached: Option<&Limit>, tally: &Tally) -> Option<String> {
    if job.limits == Limits::default() && !job.adaptive {
        return None;
    }
    let (fewest, most) = tally.sample_bounds();
    let error = tally.relative_error();
    let error = match error.is_finite() {
        true => format!("relative error {}", console::significant(error)),
        false => "relative error unknown".to_owned(),
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

/// What is said of a picture that is biased, perhaps by a clamp as well.
pub(super) fn bias(audit: &Audit, has_clamp: bool) -> String {
    let percent = |share: f64| format!("{:.1}", 100.0 * share);
    let (whole, blocks) = (&audit.brightness, &audit.blocks);
    let middle = 0.5 * (whole.start + whole.end);
    format!(
        "biased: brightness off by {:+.1} % (± {}), blocks of 8 x 8 pixels by {} to {} % of the picture's mean{}, with 95 % certainty",
        100.0 * middle,
        percent(whole.end - middle),
        percent(blocks.start),
        percent(blocks.end),
        match has_clamp {
            true => " beside what --clamp takes away",
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
            time: None,
        };
        let mut watch = Watch::new(limits, Instant::now());
        let mut looks = Vec::new();
        let mut spp = 0.0;
        let ended = loop {
            spp += 1.0;
            let error = || {
                looks.push(spp);
                Ok::<_, ()>(Some(0.2 / f64::sqrt(spp)))
            };
            if let Some(limit) = watch.reached(spp, error).unwrap() {
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
            time: Some(Duration::ZERO),
        };
        let mut watch = Watch::new(limits, Instant::now());
        let reached = watch.reached(1.0, || Ok::<_, ()>(Some(1.0))).unwrap();
        assert_eq!(reached, Some(Limit::Time(Duration::ZERO)));
        assert_eq!(
            Watch::new(Limits::default(), Instant::now()).reached(1e6, || Err(())),
            Ok(None)
        );
    }
}
