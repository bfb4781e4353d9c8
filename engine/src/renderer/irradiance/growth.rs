//! How what is known of the light grows with the picture.
//!
//! Noise of the records is frozen: all pixels around share it, and more samples of the picture don't take it away. So whenever the
//! samples of each pixel have become four times as many, more paths teach the cache of scattered light, and records are made anew at their
//! places, of rays that end in what is known better by then. Both keep a share of the work, and the error falls with the number of samples as
//! that of paths does, until what is left is the same with every seed. When that happens follows from a sample's number alone, so that all parts
//! of a picture have the same records for it, to the bit.
//!
//! What former rays have found isn't kept: most of the noise of records is that of the cache that their rays ended in.

use std::cmp::Ordering;

use device::{Device, Resources};

use super::{DISTANCES, Irradiance, Look, Phase};
use crate::renderer::{Purpose, RenderError, Renderer, light_cache};

/// Where there are records. They are to be better before their noise is much beside that of pixels, and making them anew takes as long as tens
/// of samples.
const WITH_RECORDS: Pace = Pace {
    first: 64,
    doublings: 2,
};
/// Where there are none, so that a picture of few samples doesn't wait for what only one of many is worth.
const WITHOUT_RECORDS: Pace = Pace {
    first: 16,
    doublings: 1,
};
/// Rays that all records are made of, for each pixel, over the samples that it has by then.
const RAYS_SHARE: f64 = 0.2;
/// The same of paths that teach the cache of scattered light, with records and without. The noise of records is least for the time where these are
/// about twice as many as rays.
const PATHS_SHARE: f64 = 0.5;
const PATHS_SHARE_WITHOUT_RECORDS: f64 = 0.25;
/// Paths that teach the cache of scattered light after which no more look where the sky is seen, about as many as the first ones of a picture of
/// 1280x720 pixels: more would find hardly anything, and what is counted has to fit into 32 bits.
const ENOUGH_LOOKED: u64 = 1 << 23;
/// Paths that teach it after which no more begin cells of their own. In a furnished room 1.8 million of them take 0.44 of the table, 7.4
/// million, as many as go ahead of a picture of 1280x720, 0.87 of it, and thirty million would want more than there is.
const ENOUGH_CELLS: u64 = 1 << 22;
/// Most paths that begin cells, of those of a step that begins before the former are enough: a very large picture has one path for each pixel at
/// least.
const MOST_CELLS: u64 = 1 << 23;
/// By how many times as many paths more must be known before it is worth the while.
const WORTH: u32 = 2;
/// Of so many paths that teach it one goes on to its end.
const WHOLE_PATHS: u32 = 4;
/// Where the numbers of samples begin that these paths belong to.
const FIRST_SAMPLE: u32 = 1 << 20;

/// When more is learned.
#[derive(Debug, Clone, Copy)]
struct Pace {
    /// Samples of each pixel before the first time, a power of two.
    first: u32,
    /// How often they double from one time to the next.
    doublings: u32,
}

impl Pace {
    fn of(cache: &Irradiance) -> Self {
        match cache.has_records() {
            true => WITH_RECORDS,
            false => WITHOUT_RECORDS,
        }
    }

    /// How often that has been before a sample.
    fn steps(self, sample: u32) -> u32 {
        match sample.checked_ilog2() {
            Some(power) => {
                (power + self.doublings).saturating_sub(self.first.ilog2()) / self.doublings
            }
            None => 0,
        }
    }

    /// The samples of each pixel after which it is for the so-manieth time, from 1 on.
    fn after(self, step: u32) -> u64 {
        u64::from(self.first) << (self.doublings * (step - 1))
    }
}

impl Renderer {
    /// The number of the sample that the next path belongs to, in a picture of many moments from the beginning of its own on.
    pub(in crate::renderer) fn sample_of_moment(&self) -> u32 {
        let done = self.position / u64::from(self.frame.padded_pixels);
        let sample = self.settings.first_sample + done as u32;
        sample.saturating_sub(self.settings.moment_since)
    }

    /// As many of the next paths as the records that there are by now are made for.
    pub(in crate::renderer) fn until_more_rays(&self, paths: u64) -> u64 {
        let grows = !self.is_apart && !self.knows_whole();
        let Some(cache) = self.irradiance.as_ref().filter(|_| grows) else {
            return paths;
        };
        let pace = Pace::of(cache);
        let padded = u64::from(self.frame.padded_pixels);
        let next = pace.after(pace.steps(self.sample_of_moment()) + 1);
        let left =
            next + u64::from(self.settings.moment_since) - u64::from(self.settings.first_sample);
        paths.min(left * padded - self.position)
    }

    /// Begins to learn more, if a sample asks for that, or anew, if it is one that came before; none where it may begin.
    pub(super) fn grow(&mut self, sample: u32) -> Result<Option<Phase>, RenderError> {
        let Some(cache) = &mut self.irradiance else {
            return Ok(None);
        };
        let wanted = Pace::of(cache).steps(sample);
        Ok(match cache.steps.cmp(&wanted) {
            Ordering::Equal => None,
            Ordering::Less => {
                cache.steps += 1;
                let has_records = cache.has_records();
                // What went ahead of a small picture may be enough for more than its beginning.
                if !has_records && self.samples_to_learn(false).1 == 0 {
                    return self.grow(sample);
                }
                Some(Phase::Learning(false, 0))
            }
            // Another device has failed, and handed back what it was to render.
            Ordering::Greater => {
                light_cache::clear(&self.device, self.settings.method, &self.resources)?;
                self.forget_light();
                Some(Phase::Looking(Look::Openings, 0))
            }
        })
    }

    /// Whether paths that teach the cache of scattered light come after those before its first sample.
    pub(in crate::renderer) fn learns_more(&self) -> bool {
        self.irradiance
            .as_ref()
            .is_some_and(|cache| cache.steps > 0)
    }

    /// Paths that have taught the cache of scattered light before; `ends` as for [`Self::samples_to_learn`].
    fn learned_from(&self, ends: bool) -> u64 {
        let (first, _) = self.samples_to_learn(ends);
        u64::from(first % FIRST_SAMPLE) * u64::from(self.frame.padded_pixels)
    }

    /// Whether paths that teach the cache of scattered light also look where the sky is seen; `ends` as for [`Self::samples_to_learn`].
    pub(in crate::renderer) fn looks(&self, ends: bool) -> bool {
        self.scene.environment.emits && self.learned_from(ends) < ENOUGH_LOOKED
    }

    /// Of 2^32 paths of the next wave how many begin cells of that cache, where `u32::MAX` is all.
    pub(in crate::renderer) fn begins_cells(&self, purpose: Purpose) -> u32 {
        let Purpose::Learn { ends } = purpose else {
            return 0;
        };
        let before = self.learned_from(ends);
        if before >= ENOUGH_CELLS {
            return 0;
        }
        let (_, samples) = self.samples_to_learn(ends);
        let paths = u64::from(samples) * u64::from(self.frame.padded_pixels);
        share_of((MOST_CELLS - before).min(paths), paths)
    }

    /// What comes once the cache of scattered light has learned.
    pub(super) fn after_learning(&mut self, sample: u32) -> Result<Phase, RenderError> {
        let pixels = u64::from(self.frame.padded_pixels);
        let knows_more = self.samples_to_learn(false).1 > 0;
        if knows_more && self.looks(false) {
            self.learn_sky()?;
        }
        Ok(match &mut self.irradiance {
            Some(cache) if !cache.has_records() => Phase::Ready,
            Some(cache) if cache.steps == 0 => Phase::Finding(0, 0),
            Some(cache) => match cache.turns_again(pixels, knows_more) {
                None => Phase::Ready,
                // More will be learned before the next sample.
                Some(turns) if cache.steps < Pace::of(cache).steps(sample) => {
                    cache.leave_out(turns)
                }
                Some(turns) => cache.begin_again(turns, &self.device, &self.resources),
            },
            None => Phase::Ready,
        })
    }

    /// Samples of each pixel that teach the cache of scattered light in a step, the first and how many: those whose paths go on to
    /// their end, or those whose paths end in what it has learned by then.
    pub(super) fn samples_to_learn(&self, ends: bool) -> (u32, u32) {
        let ahead = self.samples_ahead();
        let Some(cache) = &self.irradiance else {
            return (0, 0);
        };
        let pace = Pace::of(cache);
        let share = match cache.has_records() {
            true => PATHS_SHARE,
            false => PATHS_SHARE_WITHOUT_RECORDS,
        };
        let until = |step: u32| match step {
            0 => ahead,
            _ => match (share * pace.after(step) as f64) as u32 {
                // A small picture has had more to begin with.
                few if few < WORTH.saturating_mul(ahead) => ahead,
                samples => samples,
            },
        };
        let (first, samples) = match cache.steps {
            0 => (0, ahead),
            step => (
                FIRST_SAMPLE + until(step - 1),
                until(step) - until(step - 1),
            ),
        };
        let whole = samples.div_ceil(WHOLE_PATHS);
        match ends {
            false => (first, whole),
            true => (first + whole, samples - whole),
        }
    }
}

/// So many of some paths, of 2^32; `u32::MAX` is all.
fn share_of(some: u64, paths: u64) -> u32 {
    match some < paths {
        true => (some as f64 / paths as f64 * f64::from(u32::MAX)) as u32,
        false => u32::MAX,
    }
}

impl Irradiance {
    /// How often rays of all records are to be gathered anew by now; none where that isn't worth it. `knows_more`: whether what they end in
    /// has become better.
    fn turns_again(&self, pixels: u64, knows_more: bool) -> Option<u32> {
        let once: u64 = (0..DISTANCES.len()).map(|pass| self.rays_once(pass)).sum();
        let wanted = (RAYS_SHARE * (Pace::of(self).after(self.steps) * pixels) as f64) as u64;
        let is_worth_it = once > 0 && (knows_more || wanted >= self.rays);
        // The nearest number of turns, by halves.
        let nearest = wanted + u64::from(self.halves()) * once / 2;
        is_worth_it.then(|| self.turns_for(nearest, once))
    }

    /// Has all records made anew.
    fn begin_again(&mut self, turns: u32, device: &Device, resources: &Resources) -> Phase {
        (self.turns, self.rays) = (turns, 0);
        for record in &mut self.records {
            record.forget_fits();
        }
        let records = resources.buffer("irradiance_records");
        device.write(records, 0, bytemuck::cast_slice(&self.records));
        self.gather_again(0, device, resources)
    }

    /// Goes on as if records had been made anew, which no sample would see: the next ones are the same to the bit.
    fn leave_out(&mut self, turns: u32) -> Phase {
        self.rays = 0;
        for pass in 0..DISTANCES.len() {
            let once = self.rays_once(pass);
            if once > 0 {
                self.rays += once * u64::from(turns);
                self.passes[pass].turns += turns;
            }
        }
        Phase::Ready
    }

    /// Has the records from a pass on made anew.
    pub(super) fn gather_again(
        &mut self,
        pass: usize,
        device: &Device,
        resources: &Resources,
    ) -> Phase {
        match (pass..DISTANCES.len()).find(|&pass| self.rays_once(pass) > 0) {
            Some(pass) => self.begin_gathering(pass, self.turns),
            None => self.finish(device, resources),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_or_some_begin_cells() {
        let large = 16_384 * 16_384;
        let many = (u64::from(share_of(MOST_CELLS, large)) * large) >> 32;
        assert!(many.abs_diff(MOST_CELLS) < 1000, "{many}");
        assert_eq!([share_of(7, 7), share_of(0, 7)], [u32::MAX, 0]);
        assert_eq!(share_of(0, 0), u32::MAX);
    }

    #[test]
    fn more_is_learned_at_powers_of_two() {
        let with = [0, 1, 63, 64, 255, 256, 1023, 1024].map(|sample| WITH_RECORDS.steps(sample));
        assert_eq!(with, [0, 0, 0, 1, 1, 2, 2, 3]);
        let without = [15, 16, 31, 32, 64].map(|sample| WITHOUT_RECORDS.steps(sample));
        assert_eq!(without, [0, 1, 1, 2, 3]);
        let first = |first, doublings| Pace { first, doublings };
        for pace in [WITH_RECORDS, WITHOUT_RECORDS, first(1, 1), first(2, 3)] {
            for step in 1..=9 {
                assert_eq!(pace.steps(pace.after(step) as u32), step);
                assert_eq!(pace.steps(pace.after(step) as u32 - 1), step - 1);
            }
        }
    }
}
