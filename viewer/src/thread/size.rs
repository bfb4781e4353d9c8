//! How large the picture is and how long its waves are: what keeps the window answering.

use std::time::Duration;

use engine::display::DeviceFilm;
use engine::session::SessionError;

use crate::link::lock;

use super::{Render, lock_size};

/// Motion is over when nothing has moved for so long while a button or a key is held, and the user is at work until so long after his
/// last input.
const STILL: Duration = Duration::from_millis(250);
/// The same once nothing is held any more: a wheel's steps and what is played come one by one, but sharpness is waited for.
const LET_GO: Duration = Duration::from_millis(50);
/// Longest waves on a GPU: the window's frames wait for them.
const GPU_WAVE: Duration = Duration::from_millis(15);
/// The same where the processor renders, while the user is at work and while nothing needs the window.
const CPU_WAVE_TOUCHED: Duration = Duration::from_millis(20);
const CPU_WAVE: Duration = Duration::from_millis(50);

/// A moving picture comes after so many waves: a frame of the window may lie between any two of them.
const MOVING_WAVES: u32 = 2;

impl Render {
    /// A small picture while something moves; when nothing does, larger ones until it is whole.
    pub(super) fn fit_size(&mut self) -> Result<(), SessionError> {
        let full = *lock_size(&self.size);
        let still = match lock(&self.board).is_held {
            true => STILL,
            false => LET_GO,
        };
        // What has begun small is seen small first, however long a driver compiles before.
        let is_awaited = self.is_moving && !self.run.is_seen && self.has_work();
        self.is_moving = is_awaited || self.motion.is_some_and(|motion| motion.elapsed() < still);
        // Another size would begin it anew.
        let keeps_size = is_awaited && full == self.full;
        self.full = full;
        self.divisor = match self.is_moving {
            true if keeps_size => self.divisor,
            true => self.pace.moving_divisor(full),
            false => finer(self.divisor, self.run.is_seen),
        };
        let size = full.map(|side| (side / self.divisor).max(1));
        let longest = self.longest_wave();
        let seen = self.picture_size();
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        session.set_longest_wave(longest);
        session.set_smallest_wave(match self.is_moving {
            true => size[0] * size[1] / MOVING_WAVES,
            false => 0,
        });
        if size != seen {
            self.beside = None;
        }
        session.resize(size[0], size[1])?;
        // What lies beside it has a sample of each pixel first: it would be black.
        let has_all = self.beside.is_some() || !self.is_moving && self.run.is_seen;
        let region = self.region.filter(|_| has_all);
        session.set_region(region.map(|corners| pixels(corners, size)));
        Ok(())
    }

    /// With a region, only that follows what is about to be changed: what lies beside it is kept. Another view is another picture, and
    /// so is another moment.
    pub(super) fn keep_beside(&mut self) -> Result<(), SessionError> {
        let is_other = self.pending.view.is_some() || self.pending.moment.is_some();
        if is_other || self.region.is_none() {
            self.beside = None;
            return Ok(());
        }
        if let Some(film) = self.copy_beside()? {
            self.beside = Some(film);
        }
        Ok(())
    }

    /// A copy of the picture, where that is to stay beside the region and isn't kept yet.
    pub(super) fn copy_beside(&mut self) -> Result<Option<DeviceFilm>, SessionError> {
        // A fast device's pictures are whole while something moves, too.
        let is_whole = self.run.is_seen && self.divisor == 1;
        let is_wanted = is_whole && self.region.is_some() && self.beside.is_none();
        match &mut self.session {
            Some(session) if is_wanted => {
                let film = session.keep_film(self.settings.channel.needs_guides());
                film.map(Some)
            }
            _ => Ok(None),
        }
    }

    /// The user is at work.
    pub(super) fn is_touched(&self) -> bool {
        let touched = lock(&self.board).touched;
        touched.is_some_and(|at| at.elapsed() < STILL)
    }

    pub(super) fn longest_wave(&self) -> Duration {
        match (
            self.device.traits().shares_the_processor,
            self.is_moving || self.is_touched(),
        ) {
            (false, _) => GPU_WAVE,
            (true, true) => CPU_WAVE_TOUCHED,
            (true, false) => CPU_WAVE,
        }
    }
}

/// Step by step, each once the one before has been seen: what the sides are divided by next, while nothing moves. A step that gains
/// less than twice the pixels of a side isn't worth the time that it takes from the next.
fn finer(divisor: u32, is_seen: bool) -> u32 {
    match is_seen {
        true => (divisor / 2).max(1),
        false => divisor,
    }
}

/// The pixels between corners of 0 to 1, at least one.
fn pixels([left, top, right, bottom]: [f32; 4], [width, height]: [u32; 2]) -> [u32; 4] {
    let span = |a: f32, b: f32, size: u32| {
        let at = |x: f32| x.clamp(0.0, 1.0) * size as f32;
        let low = (at(a.min(b)).floor() as u32).min(size - 1);
        (low, (at(a.max(b)).ceil() as u32).clamp(low + 1, size))
    };
    let ((left, right), (top, bottom)) = (span(left, right, width), span(top, bottom, height));
    [left, top, right, bottom]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_at_rest_become_finer_in_few_steps() {
        assert_eq!(finer(16, false), 16);
        for (coarse, steps) in [(1, 0), (2, 1), (3, 1), (7, 2), (16, 4)] {
            let mut divisor = coarse;
            for _ in 0..steps {
                assert_ne!(divisor, 1);
                divisor = finer(divisor, true);
            }
            assert_eq!(divisor, 1, "from {coarse}");
        }
        assert_eq!(finer(1, true), 1);
    }

    #[test]
    fn regions_become_whole_pixels() {
        assert_eq!(pixels([0.0, 0.0, 1.0, 1.0], [640, 360]), [0, 0, 640, 360]);
        assert_eq!(pixels([0.75, 0.5, 0.25, 0.0], [100, 10]), [25, 0, 75, 5]);
        assert_eq!(pixels([2.0, 2.0, 2.0, 2.0], [8, 8]), [7, 7, 8, 8]);
        assert_eq!(pixels([0.5, f32::NAN, 0.5, 0.5], [8, 8])[0], 4);
    }
}
