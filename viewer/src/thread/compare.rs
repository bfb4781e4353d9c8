//! The picture of before, to be compared with: it is refined as the picture of now is, by a renderer of its own, which no edit
//! reaches.

use engine::display::DeviceFilm;
use engine::renderer::{RenderSettings, Renderer};
use engine::session::SessionError;

use super::{Render, lock_size};

/// What is compared with.
pub(super) struct Before {
    renderer: Renderer,
    samples_done: u64,
    is_done: bool,
}

impl Before {
    /// As it is to be shown.
    pub(super) fn film(&mut self, guides: bool) -> Result<DeviceFilm, SessionError> {
        if guides {
            self.renderer.trace_guides()?;
        }
        Ok(self.renderer.device_film()?)
    }
}

impl Render {
    /// Keeps what is shown, with the samples that it has.
    pub(super) fn keep_before(&mut self) -> Result<(), SessionError> {
        let is_whole = self.is_whole();
        let [width, height] = *lock_size(&self.size);
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        let settings = RenderSettings {
            width,
            height,
            ..session.settings().clone()
        };
        let mut renderer = session.renderer_of(&settings)?;
        let samples_done = match is_whole {
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
        self.before = Some(Before {
            renderer,
            samples_done,
            is_done: false,
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
        let settings = before.renderer.settings();
        let is_other = [settings.width, settings.height] != size;
        if is_other && !self.is_moving {
            before.renderer.resize(size[0], size[1])?;
            (before.samples_done, before.is_done) = (0, false);
        }
        if refines {
            before.renderer.set_longest_wave(longest);
            let progress = before.renderer.step(self.options.target_spp)?;
            before.samples_done = progress.samples_done;
            before.is_done = progress.is_done();
            // That of now is shown again and again while it has more to come.
            if self.run.is_done {
                self.show()?;
                (self.wake)();
            }
        }
        Ok(())
    }
}
