//! The picture of before, to be compared with: it is refined as the picture of now is, by a renderer of its own, which no edit
//! reaches.

use engine::display::DeviceFilm;
use engine::film::GroupFactors;
use engine::renderer::{RenderSettings, Renderer};
use engine::session::SessionError;

use super::denoise::{Subject, Version};
use super::{Render, lock_size};

/// What is compared with.
pub(super) struct Before {
    /// Another one with each that is kept.
    number: u64,
    renderer: Renderer,
    /// Shown until the renderer has a sample of each pixel: the picture that it had in another size.
    coarse: Option<DeviceFilm>,
    samples_done: u64,
    is_done: bool,
    /// How its lights were mixed.
    pub(super) factors: Option<GroupFactors>,
}

impl Before {
    /// As it is to be shown.
    pub(super) fn film(&mut self, guides: bool) -> Result<DeviceFilm, SessionError> {
        if let Some(coarse) = &self.coarse {
            return Ok(coarse.clone());
        }
        if guides {
            self.renderer.trace_guides()?;
        }
        Ok(self.renderer.device_film()?)
    }

    /// Begins anew in another size, behind what has been seen so far.
    fn resize(&mut self, [width, height]: [u32; 2]) -> Result<(), SessionError> {
        // What the renderer writes to from now on are other buffers.
        let seen = self.film(false)?;
        self.renderer.resize(width, height)?;
        self.coarse = Some(seen);
        (self.samples_done, self.is_done) = (0, false);
        Ok(())
    }

    fn size(&self) -> [u32; 2] {
        let settings = self.renderer.settings();
        [settings.width, settings.height]
    }

    /// Whether it has this size, and a sample of each pixel.
    pub(super) fn is_whole(&self, size: [u32; 2]) -> bool {
        self.coarse.is_none() && self.size() == size
    }

    /// Whether it gets no more samples.
    pub(super) fn is_done(&self) -> bool {
        self.is_done
    }

    /// As far as it is.
    pub(super) fn version(&self) -> Version {
        let [width, height] = self.size().map(f64::from);
        Version {
            subject: Subject::Before,
            generation: self.number,
            mix: 0,
            spp: self.samples_done as f64 / (width * height),
        }
    }
}

impl Render {
    /// Keeps what is shown, with the samples that it has. In the midst of a motion that is a small picture, which becomes whole when
    /// that of now does: nothing waits for it.
    pub(super) fn keep_before(&mut self) -> Result<(), SessionError> {
        let is_kept = self.run.is_seen && self.region.is_none();
        let full = *lock_size(&self.size);
        let small = full.map(|side| side / self.pace.moving_divisor(full));
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        let now = session.settings();
        let [width, height] = match is_kept {
            true => [now.width, now.height],
            false => small.map(|side| side.max(1)),
        };
        let settings = RenderSettings {
            width,
            height,
            ..now.clone()
        };
        let factors = self.mixing.factors(session.scene());
        let mut renderer = session.renderer_of(&settings)?;
        let samples_done = match is_kept {
            true => {
                let film = session.snapshot()?.film;
                renderer.resume(&film, session.paths_done())?;
                self.run.samples_done
            }
            // A sample of each pixel, to be seen at once.
            false => loop {
                let progress = renderer.step(1)?;
                if progress.is_done() {
                    break progress.samples_done;
                }
            },
        };
        self.kept += 1;
        self.before = Some(Before {
            number: self.kept,
            renderer,
            coarse: None,
            samples_done,
            is_done: false,
            factors,
        });
        Ok(())
    }

    /// Whether the picture of before may have more samples: as many as that of now.
    pub(super) fn refines_before(&self) -> bool {
        let is_at_rest = self.run.is_seen && !self.is_moving && self.divisor == 1;
        let is_behind = |before: &Before| {
            let has_less = before.samples_done <= self.run.samples_done;
            !before.is_done && (has_less || self.run.is_done)
        };
        is_at_rest && !self.is_paused && self.before.as_ref().is_some_and(is_behind)
    }

    pub(super) fn refine_before(&mut self) -> Result<(), SessionError> {
        let size = *lock_size(&self.size);
        let longest = self.longest_wave();
        let refines = self.refines_before();
        let Some(before) = &mut self.before else {
            return Ok(());
        };
        let may_grow = self.run.is_seen && !self.is_moving && self.divisor == 1;
        if before.size() != size && may_grow {
            before.resize(size)?;
        }
        if refines {
            before.renderer.set_longest_wave(longest);
            let progress = before.renderer.step(self.options.target_spp)?;
            before.samples_done = progress.samples_done;
            before.is_done = progress.is_done();
            let [width, height] = before.size().map(u64::from);
            let is_first = before.coarse.is_some() && progress.samples_done >= width * height;
            if is_first {
                before.coarse = None;
            }
            // That of now is shown again and again while it has more to come.
            if self.run.is_done || is_first {
                self.show()?;
                (self.wake)();
            }
        }
        Ok(())
    }
}
