//! Paths of a picture by their numbers, so that several devices can each render some of them.

use std::ops::Range;

use crate::film::Film;

use super::{Burst, RenderError, Renderer, clear_picture};

/// Paths of a wave that only makes drivers compile what they compile late: from the middle of the picture, where rays are
/// likely to meet something.
const WARM_UP: u32 = 1024;

impl Renderer {
    /// Paths of one sample of every pixel, with those that fill up blocks at the picture's border: a multiple of 64. Paths are
    /// numbered sample by sample, from the picture's first sample on, and within a sample block by block, row by row of blocks.
    pub fn paths_per_sample(&self) -> u64 {
        u64::from(self.frame.padded_pixels)
    }

    /// How many paths of the picture [`Self::step`] has rendered, padding included: those of the lowest numbers.
    pub fn paths_done(&self) -> u64 {
        self.position
    }

    /// Goes on with a picture of which so many paths are in `film`, as [`Self::film`] and [`Self::paths_done`] gave them: what comes of
    /// it is the picture as if nothing had come between.
    ///
    /// # Errors
    /// The device.
    ///
    /// # Panics
    /// The film has another size or other layers than the picture.
    pub fn resume(&mut self, film: &Film, paths: u64) -> Result<(), RenderError> {
        let (width, height) = (self.settings.width, self.settings.height);
        assert!(
            (film.width, film.height) == (width, height) && *film.layers() == self.settings.layers,
            "a picture goes on with its own film"
        );
        self.restart();
        self.clear_stale_film()?;
        for (name, plane) in film.planes_by_name() {
            let buffer = self.resources.buffer(name);
            self.device.write(buffer, 0, bytemuck::cast_slice(plane));
        }
        self.position = paths;
        self.burst = Burst::of(film, paths, self.paths_per_sample());
        self.device.check()?;
        Ok(())
    }

    /// Renders the first wave of a range of paths into the film; how many paths that were. Both bounds are multiples of 64. Each
    /// path may be rendered once; the film doesn't depend on the order.
    ///
    /// # Errors
    /// What the driver reports; then it isn't known what of the wave is in the film.
    pub fn render_paths(&mut self, paths: Range<u64>) -> Result<u64, RenderError> {
        let left = paths.end.saturating_sub(paths.start);
        if left == 0 {
            return Ok(0);
        }
        // Waves of about the same size: a small one at the end takes hardly less time.
        let most = u64::from(self.next_wave_size());
        let wave = left.div_ceil(left.div_ceil(most)).next_multiple_of(64);
        let wave = wave.min(left);
        self.position = paths.start;
        while self.prepare_light()? {}
        let wave = self.until_more_rays(self.until_next_photons(wave));
        let spp = paths.end.div_ceil(self.paths_per_sample());
        self.wave_at(paths.start, wave as u32, spp as u32)?;
        Ok(wave)
    }

    /// Makes what is to be known of the light before the picture begins: nothing where paths find all of it by themselves.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn prepare(&mut self) -> Result<(), RenderError> {
        while self.records_awaited().is_some() {
            self.prepare_light()?;
        }
        Ok(())
    }

    /// Takes a step towards what the next path has to know of the light; false where that is there.
    pub(super) fn prepare_light(&mut self) -> Result<bool, RenderError> {
        Ok(self.prepare_photons()? || self.prepare_irradiance(self.sample_of_moment())?)
    }

    /// Forgets what is known of the light beside the picture.
    pub(super) fn forget_light(&mut self) {
        self.frame.set_known_sky(false);
        if let Some(irradiance) = &mut self.irradiance {
            irradiance.restart();
        }
        if let Some(photons) = &mut self.photons {
            photons.restart();
        }
    }

    /// Runs all kernels once, of which nothing stays but a picture that begins anew: what a driver compiles when it is first
    /// used is compiled then.
    ///
    /// # Errors
    /// What the driver reports, of kernels that it refuses only now, too.
    pub fn warm_up(&mut self) -> Result<(), RenderError> {
        let usual = self.wave_size;
        let middle = self.paths_per_sample() / 2 / 64 * 64;
        self.wave_at(middle, WARM_UP.min(self.capacity), 1)?;
        self.restart();
        self.wave_size = usual;
        self.seconds = 0.0;
        Ok(())
    }

    /// What has been gathered so far, which the film on the device then no longer holds. The figures go on.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn take_film(&mut self) -> Result<Film, RenderError> {
        let film = self.film()?;
        clear_picture(&self.device, &self.settings, &self.resources)?;
        Ok(film)
    }
}
