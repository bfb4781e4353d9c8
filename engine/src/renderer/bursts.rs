//! Several samples of each pixel at once: a thread that has paths of its own then finds what a few pixels show in its caches, and
//! touches their film once for all of them, instead of once for each. Of layers it may have sixty planes, which no cache of a processor
//! holds for a whole picture.
//!
//! A burst is that many samples of all pixels, block by block. Between two bursts all pixels have the same samples, as ever; within
//! one the film itself says which blocks have them already, so that a film can be gone on with at any time. The first sample of all
//! pixels goes alone, so that a picture that ends early is soon there as a whole.
//! Paths that go ahead of the picture come likewise.

use crate::film::Film;
use crate::frame::{BLOCK_PIXELS, LOT_BLOCKS};

use super::{Lot, RenderError, Renderer};

/// Most samples of a burst: more hardly save anything.
const MOST_SAMPLES: u32 = 16;
/// Most waves of a burst, so that no part of a picture is far ahead of the others for long.
const MOST_WAVES: u64 = 8;
/// One over the share of what all parts have already that a burst may be however many waves that takes.
const AHEAD: u64 = 4;

/// The burst that a renderer is in.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Burst {
    /// Paths before it.
    start: u64,
    /// Samples of each pixel; paths go sample by sample where there is one, or none.
    samples: u32,
}

impl Burst {
    /// That of a film with so many paths.
    pub(super) fn of(film: &Film, paths: u64, per_sample: u64) -> Self {
        let (first, last) = (film.samples(0), film.samples(film.pixels() - 1));
        let burst = Self {
            start: u64::from(last) * per_sample,
            samples: first.saturating_sub(last),
        };
        let is_whole = |paths: u64| paths.is_multiple_of(burst.block_paths().max(1));
        match paths.checked_sub(burst.start) {
            Some(inside) if is_whole(inside) => burst,
            _ => Self::default(),
        }
    }

    fn block_paths(self) -> u64 {
        u64::from(self.samples) * u64::from(BLOCK_PIXELS)
    }
}

impl Renderer {
    /// Whether samples may come in bursts: not where each sample of all pixels has photons of its own.
    pub(super) fn has_bursts(&self) -> bool {
        !self.lanes.is_empty() && !self.settings.method.has_photons()
    }

    /// Renders the next wave of a burst towards so many samples per pixel; false where the next paths are in none.
    pub(super) fn step_burst(&mut self, target_spp: u32) -> Result<bool, RenderError> {
        let padded = u64::from(self.frame.padded_pixels);
        let end = self.burst.start + u64::from(self.burst.samples) * padded;
        if self.position.is_multiple_of(padded) && !(self.burst.start..end).contains(&self.position)
        {
            self.burst = Burst {
                start: self.position,
                samples: self.next_burst(target_spp),
            };
        }
        let Burst { start, samples } = self.burst;
        if samples < 2 {
            return Ok(false);
        }
        let first_sample = self.settings.first_sample + (start / padded) as u32;
        let first_block = (self.position - start) / self.burst.block_paths();
        let blocks = (first_block..padded / u64::from(BLOCK_PIXELS)).take(LOT_BLOCKS);
        let lot = Lot {
            blocks: blocks.map(|block| [block as u32, first_sample]).collect(),
            samples,
            before: self.sample_of_moment(),
        };
        let done = self.render_lot(&lot, 0)?;
        self.position += done as u64 * self.burst.block_paths();
        Ok(true)
    }

    /// The next blocks of samples of all pixels that go ahead of the picture, of which so many paths are done, each with its first sample, and how
    /// many each gets; none where samples don't come in bursts.
    pub(super) fn burst_ahead(
        &self,
        done: u64,
        first_sample: u32,
        samples: u32,
    ) -> Option<(Vec<[u32; 2]>, u32)> {
        if self.lanes.is_empty() {
            return None;
        }
        let padded = u64::from(self.frame.padded_pixels);
        let most = MOST_SAMPLES.min(self.capacity / BLOCK_PIXELS).max(1);
        let before = (done / (u64::from(most) * padded)) as u32 * most;
        let at_once = most.min(samples - before);
        let block_paths = u64::from(at_once * BLOCK_PIXELS);
        let from = (done - u64::from(before) * padded) / block_paths;
        let count = (u64::from(self.next_wave_size()) / block_paths).clamp(1, LOT_BLOCKS as u64);
        let blocks = from..(padded / u64::from(BLOCK_PIXELS)).min(from + count);
        let blocks = blocks.map(|block| [block as u32, first_sample + before]);
        Some((blocks.collect(), at_once))
    }

    /// Samples of the burst that begins now.
    fn next_burst(&self, target_spp: u32) -> u32 {
        // Whoever ends a picture when its paths are as many as its pixels counts on it that each pixel has one then.
        if !self.has_bursts() || self.position == 0 {
            return 1;
        }
        let padded = u64::from(self.frame.padded_pixels);
        let left = u64::from(target_spp) * padded - self.position;
        let left = self.until_more_rays(left) / padded;
        // As many paths as so many waves have at the speed that is known by now.
        let room = (MOST_WAVES * u64::from(self.wave_size)).max(self.position / AHEAD) / padded;
        // They end at multiples of the most, after which the noise of a picture is looked at: all pixels have as many samples then.
        let most = u64::from(MOST_SAMPLES);
        let until_whole = most - self.position / padded % most;
        room.min(until_whole).min(left) as u32
    }
}
