//! A picture whose samples go where they help most: see [`engine::adaptive`].

use engine::adaptive::{Goal, SeenNoise, next_round};
use engine::film::Film;
use engine::renderer::Progress;
use engine::session::Session;
use pictures::seen::Seen;

use crate::failure::Failure;
use crate::interrupt;

use super::alone::Exposure;
use super::limits::{Limit, Noise};
use super::{Ended, failure};

/// What the film of such a picture says of how far it is: as many paths as if all pixels had the samples of that with the most.
pub(super) fn paths(film: &Film, session: &Session) -> u64 {
    let (_, most) = film.sample_bounds();
    u64::from(most) * session.paths_per_sample()
}

impl<F: FnOnce()> Exposure<'_, '_, F> {
    /// Renders round by round until the picture is good enough, its samples are taken, or something ends it before. What is kept
    /// of it meanwhile is as it is between two rounds, so that it is gone on with as if nothing had come between.
    pub(super) fn distribute(&mut self, session: &mut Session) -> Result<Option<Ended>, Failure> {
        let job = self.job;
        let pixels = f64::from(job.width) * f64::from(job.height);
        loop {
            let film = session.snapshot().map_err(failure)?.film;
            let seen = self.watch.look().seen(&film);
            let seen = seen
                .as_ref()
                .map(|(map, most)| SeenNoise { map, most: *most });
            let goal = Goal {
                error: job.limits.noise,
                brightness: self.watch.brightness(),
                spp: job.spp.get(),
                seen,
            };
            let round = next_round(&film, &goal);
            let noise = Noise {
                error: Some(round.error),
                seen: seen.map(|seen| Seen::of(seen.map, film.width as usize, seen.most)),
            };
            let reached = self.watch.knows(round.spp, noise);
            // Whether the error is small enough the round says itself, which knows what it needs for that.
            if let Some(limit @ Limit::Flip(_)) = reached {
                return Ok(Some(Ended::Enough(limit)));
            }
            if round.lots.is_empty() {
                let limit = goal.error.filter(|_| round.is_clean);
                return Ok(limit.map(|limit| Ended::Enough(Limit::Noise(limit))));
            }
            if let Some(writer) = self.writer.as_mut().filter(|writer| writer.is_due()) {
                writer.write(film.clone(), paths(&film, session));
            }
            // What ends within the first round is gone on with as it is: it doesn't matter where its samples are taken first.
            let is_first = film.sample_bounds().0 < goal.first();
            let between = (!is_first).then_some(film);
            let mut done = round.spp * pixels;
            for lot in &round.lots {
                let mut from = 0;
                while from < lot.blocks.len() {
                    let blocks = session.render_lot(lot, from).map_err(failure)?;
                    from += blocks;
                    self.first_is_done();
                    if interrupt::requested() {
                        self.between = between;
                        return Ok(Some(Ended::Interrupted));
                    }
                    done += lot.paths() as f64 * blocks as f64 / lot.blocks.len() as f64;
                    // The first round goes over all pixels, block by block: there are none everywhere until it is done.
                    if let Some(limit) = self.watch.time_is_over(round.spp) {
                        self.between = between;
                        return Ok(Some(Ended::Enough(limit)));
                    }
                    let progress = Progress {
                        samples_done: done as u64,
                        samples_total: (pixels * f64::from(job.spp.get())) as u64,
                    };
                    let reached = self.watch.reached_so_far(&progress, done / pixels);
                    self.bar.update(&reached, job.spp.get());
                }
            }
        }
    }
}
