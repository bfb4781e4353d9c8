//! What a member of a fleet does: it takes a range of paths, renders it, takes the next; and now and then what its device has
//! gathered goes to the common film.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

use crate::film::Film;
use crate::renderer::{RenderError, Renderer};
use crate::stats::Stats;
use crate::system::{Clock, said};

use super::state::{Next, Shared};

/// A film stays on its device for so long at least: what it holds has to be rendered again if the device fails.
const COLLECT: Duration = Duration::from_secs(10);
/// And for so many times as long as collecting it takes, so that this costs little.
const COLLECT_COST: u32 = 30;

/// What renders a part of a picture's paths. [`Renderer`] is the one that there is; another one may stand before it.
pub trait Worker {
    /// Renders some paths from the beginning of a range; how many that were, at least one. See [`Renderer::render_paths`].
    ///
    /// # Errors
    /// The device can't go on: all that hasn't been taken from its film is lost.
    fn render(&mut self, paths: Range<u64>) -> Result<u64, RenderError>;

    /// See [`Renderer::take_film`].
    ///
    /// # Errors
    /// As [`Self::render`].
    fn take_film(&mut self) -> Result<Film, RenderError>;

    /// Figures so far.
    ///
    /// # Errors
    /// As [`Self::render`].
    fn stats(&self) -> Result<Stats, RenderError>;
}

impl Worker for Renderer {
    fn render(&mut self, paths: Range<u64>) -> Result<u64, RenderError> {
        self.render_paths(paths)
    }

    fn take_film(&mut self) -> Result<Film, RenderError> {
        self.take_film()
    }

    fn stats(&self) -> Result<Stats, RenderError> {
        self.stats()
    }
}

/// Makes a device ready, on the thread that will work with it.
pub(super) type Make = Box<dyn FnOnce() -> Result<Box<dyn Worker>, RenderError> + Send>;

/// The life of a member, from before its device is ready until there is nothing to do.
pub(super) fn run(shared: &Arc<Shared>, own: usize, make: Make, clock: &dyn Clock) {
    let life = AssertUnwindSafe(|| live(shared, own, make, clock));
    let failure = match catch_unwind(life) {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(error.to_string()),
        Err(panic) => Some(said(&*panic)),
    };
    shared.ended(own, failure);
}

fn live(shared: &Shared, own: usize, make: Make, clock: &dyn Clock) -> Result<(), RenderError> {
    let mut worker = make()?;
    let mut collected = clock.now();
    shared.is_ready(own, collected);
    let mut cost = Duration::ZERO;
    loop {
        let mut is_due = true;
        match shared.next(own) {
            Next::Render(range) => {
                let start = clock.now();
                let mut at = range.start;
                while at < range.end && !shared.is_stopped() {
                    at += worker.render(at..range.end)?;
                    shared.reached(own, at);
                }
                let now = clock.now();
                shared.rendered(own, now - start);
                is_due = now - collected > COLLECT.max(COLLECT_COST * cost);
            }
            Next::Collect => {}
            Next::End => return Ok(()),
        }
        if is_due {
            let start = clock.now();
            let film = worker.take_film()?;
            let stats = worker.stats()?;
            shared.collected(own, film, stats);
            collected = clock.now();
            cost = collected - start;
        }
    }
}
