//! Samples for some blocks of the picture, so that work can go where it is needed.

use crate::frame::{BLOCK_PIXELS, LOT_BLOCKS};

use super::lanes::Work;
use super::{RenderError, Renderer};

/// Blocks of 8 x 8 pixels that get the same number of further samples.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Lot {
    /// Of each, once: its place in the picture, row by row of blocks from the upper left one, and the number of its first sample.
    pub blocks: Vec<[u32; 2]>,
    /// Samples of each pixel.
    pub samples: u32,
    /// Samples per pixel that the picture has already, on average: with them grows what is known of the light.
    pub before: u32,
}

impl Lot {
    /// Its paths, those among them that stand for pixels beyond the picture's border.
    pub fn paths(&self) -> u64 {
        self.blocks.len() as u64 * u64::from(BLOCK_PIXELS) * u64::from(self.samples)
    }
}

impl Renderer {
    /// Renders the first wave of a lot, or of what is left of it from a block on; how many blocks that were, none while it is still found
    /// out what is to be known of the light before. The picture depends on which samples blocks get, and on what is known of the light
    /// by then, not on how they are cut into lots and waves. Samples are counted as if the picture began with sample 0.
    ///
    /// # Errors
    /// What the driver reports; then it isn't known what of the wave is in the film.
    pub fn render_lot(&mut self, lot: &Lot, from: usize) -> Result<usize, RenderError> {
        let left = lot.blocks.get(from..).unwrap_or_default();
        if left.is_empty() || lot.samples == 0 {
            return Ok(left.len());
        }
        if self.prepare_irradiance(lot.before)? {
            return Ok(0);
        }
        // As many samples as there are slots for, of one block at the least.
        let at_once = lot.samples.min(self.capacity / BLOCK_PIXELS);
        let most = self.wave_size.max(self.smallest_wave).min(self.most_paths);
        let count = (most / (at_once * BLOCK_PIXELS)).max(1) as usize;
        let blocks = &left[..count.min(LOT_BLOCKS).min(left.len())];
        let mut frame = self.frame;
        let mut done = 0;
        while done < lot.samples {
            let samples = at_once.min(lot.samples - done);
            let from_here: Vec<_> = blocks
                .iter()
                .map(|&[at, first]| [at, first + done])
                .collect();
            frame.set_lot(&from_here, samples);
            let work = Work::Lot {
                blocks: &from_here,
                samples,
            };
            self.play_wave(&frame, work, self.purpose())?;
            done += samples;
        }
        Ok(blocks.len())
    }
}
