//! The paths that nobody renders yet, and how many of them a device gets at a time. Plain numbers: nothing here knows devices.
//!
//! Ranges are long while there is much to do, and shrink towards the end, so that all devices end at about the same time: a
//! device gets half of what would be its part of the rest, by its speed so far. That is guided self-scheduling (Polychronopoulos
//! and Kuck 1987) with the factor of factoring (Hummel et al. 1992); its last ranges are the sub-tiles of Jaroš et al. (2015).

use std::ops::Range;

/// Seconds of work in a range at most, so that little is lost with a device that fails.
const LONGEST: f64 = 1.0;
/// Seconds of work in a range at least: shorter ones cost more than they gain.
const SHORTEST: f64 = 0.02;
/// Paths of a range at least.
const FEWEST: u64 = 256;
/// Paths come in blocks of 8 x 8 pixels, which ranges don't cut.
pub(super) const BLOCK: u64 = 64;

/// Ranges of paths that are free: ascending and apart from each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Queue {
    free: Vec<Range<u64>>,
    /// What isn't wanted: the paths from here on.
    end: u64,
    /// Behind the last path that has been taken so far.
    reached: u64,
    /// Ranges end at multiples of this.
    grain: u64,
}

impl Queue {
    /// Of the paths from 0 to `end`, in ranges that end at multiples of `grain`, itself one of [`BLOCK`], as `end` is.
    pub(super) fn new(end: u64, grain: u64) -> Self {
        Self {
            free: match end {
                0 => Vec::new(),
                _ => vec![Range { start: 0, end }],
            },
            end,
            reached: 0,
            grain: grain.max(BLOCK),
        }
    }

    /// How many are wanted at all.
    pub(super) fn end(&self) -> u64 {
        self.end
    }

    /// Behind the last path that has ever been taken.
    pub(super) fn reached(&self) -> u64 {
        self.reached
    }

    /// How many are free.
    pub(super) fn left(&self) -> u64 {
        self.free.iter().map(|range| range.end - range.start).sum()
    }

    /// Takes up to `most` of them, the first ones, all next to each other. `None` where there are none.
    pub(super) fn take(&mut self, most: u64) -> Option<Range<u64>> {
        let first = self.free.first_mut()?;
        let end = first.start.saturating_add(most.max(BLOCK));
        let end = end.checked_next_multiple_of(self.grain).unwrap_or(u64::MAX);
        let taken = first.start..first.end.min(end);
        match taken.end == first.end {
            true => drop(self.free.remove(0)),
            false => first.start = taken.end,
        }
        self.reached = self.reached.max(taken.end);
        Some(taken)
    }

    /// Gives back what was taken and has not been rendered. What isn't wanted any more is forgotten.
    pub(super) fn give_back(&mut self, range: Range<u64>) {
        let range = range.start..range.end.min(self.end);
        if range.start >= range.end {
            return;
        }
        self.free.push(range);
        self.free = joined(std::mem::take(&mut self.free));
    }

    /// Nothing from this path on is wanted any more.
    pub(super) fn cut(&mut self, end: u64) {
        self.end = self.end.min(end);
        for range in std::mem::take(&mut self.free) {
            self.give_back(range);
        }
    }
}

/// Ranges in ascending order; those that touch are one.
pub(super) fn joined(mut ranges: Vec<Range<u64>>) -> Vec<Range<u64>> {
    ranges.sort_by_key(|range| range.start);
    let mut joined: Vec<Range<u64>> = Vec::new();
    for range in ranges {
        match joined.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => joined.push(range),
        }
    }
    joined
}

/// A device among others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    /// Paths per second so far; `None` before its first range.
    pub(super) rate: Option<f64>,
    /// Paths of its first range at most.
    pub(super) first: u64,
}

/// How many of the paths that are left the device of this number among `all` should take next. `None` where it had better
/// wait: the others, of whom a faster one is among, will have done them before it had done its least.
pub(super) fn portion(left: u64, all: &[Pace], own: usize) -> Option<u64> {
    let Some(rate) = all[own].rate.filter(|&rate| rate > 0.0) else {
        let even = left / (2 * all.len() as u64);
        return Some(even.clamp(FEWEST, all[own].first.max(FEWEST)));
    };
    let others = || all.iter().enumerate().filter(|&(place, _)| place != own);
    let others_rate: f64 = others().filter_map(|(_, other)| other.rate).sum();
    let even = left as f64 * rate / (rate + others_rate) / 2.0;
    let least = (SHORTEST * rate).max(FEWEST as f64);
    // The fastest never waits, or nobody might do the rest.
    let is_faster = |(place, other): (usize, &Pace)| match other.rate {
        Some(other) => other > rate || (other == rate && place < own),
        None => false,
    };
    if even < least && others().any(is_faster) && least / rate > left as f64 / others_rate {
        return None;
    }
    Some(even.min(LONGEST * rate).max(least) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_path_is_taken_once() {
        let mut queue = Queue::new(64 * 100, BLOCK);
        let mut taken = Vec::new();
        let mut lost = Vec::new();
        let mut turn = 0;
        while let Some(range) = queue.take(1 + turn * 37 % 700) {
            assert!(range.start.is_multiple_of(BLOCK) && range.end.is_multiple_of(BLOCK));
            turn += 1;
            match turn % 5 {
                // A device fails, and later hands back what it had.
                3 => lost.push(range),
                _ => taken.push(range),
            }
            if turn % 11 == 0 {
                lost.drain(..).for_each(|range| queue.give_back(range));
            }
            if queue.left() == 0 {
                lost.drain(..).for_each(|range| queue.give_back(range));
            }
        }
        let total: u64 = taken.iter().map(|range| range.end - range.start).sum();
        assert_eq!(total, 6400);
        assert_eq!(
            joined(taken),
            [Range {
                start: 0,
                end: 6400
            }]
        );
        assert_eq!((queue.reached(), queue.left()), (6400, 0));
    }

    #[test]
    fn ranges_end_with_whole_samples_where_they_should() {
        let mut queue = Queue::new(640 * 5, 640);
        assert_eq!(queue.take(100), Some(0..640));
        let second = queue.take(700).expect("there are some");
        assert_eq!(second, 640..1920);
        // Of which a part was done.
        queue.give_back(704..1920);
        assert_eq!(queue.take(1), Some(704..1280));
        assert_eq!(queue.take(6400), Some(1280..3200));
    }

    #[test]
    fn what_is_not_wanted_is_not_handed_out() {
        let mut queue = Queue::new(6400, BLOCK);
        let first = queue.take(640).expect("there are some");
        let second = queue.take(640).expect("there are some");
        queue.cut(960);
        assert_eq!(queue.left(), 0);
        queue.give_back(first);
        queue.give_back(second);
        assert_eq!(queue.take(6400), Some(0..960));
        assert_eq!(queue.take(64), None);
        assert_eq!(queue.end(), 960);
    }

    /// The devices' times, and how many ranges each took, where they render so many paths per second.
    fn simulated(total: u64, rates: &[f64]) -> (Vec<f64>, Vec<u32>) {
        let mut queue = Queue::new(total, BLOCK);
        let mut paces: Vec<Pace> = (rates.iter())
            .map(|_| Pace {
                rate: None,
                first: 1 << 14,
            })
            .collect();
        let mut times = vec![0.0; rates.len()];
        let mut counts = vec![0; rates.len()];
        let mut waits = vec![false; rates.len()];
        while queue.left() > 0 {
            let ready = (0..rates.len()).filter(|&place| !waits[place]);
            let next = ready.min_by(|&a, &b| f64::total_cmp(&times[a], &times[b]));
            let next = next.expect("one of them never waits");
            match portion(queue.left(), &paces, next) {
                Some(paths) => {
                    let range = queue.take(paths).expect("some are left");
                    times[next] += (range.end - range.start) as f64 / rates[next];
                    paces[next].rate = Some(rates[next]);
                    counts[next] += 1;
                }
                None => waits[next] = true,
            }
        }
        (times, counts)
    }

    #[test]
    fn devices_end_together_whatever_their_speeds() {
        for rates in [
            &[1e6, 1e6][..],
            &[1e6, 3e5],
            &[5e7, 1e6, 1e5],
            &[1e6, 1e3],
            &[1e6],
        ] {
            let total = 64 * 2_000_000;
            let (times, counts) = simulated(total, rates);
            let longest = times.iter().copied().fold(0.0, f64::max);
            let ideal = total as f64 / rates.iter().sum::<f64>();
            assert!(
                longest < 1.02 * ideal + 0.5,
                "{rates:?}: {times:?}, {ideal}"
            );
            assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
        }
    }

    #[test]
    fn the_last_ranges_shrink() {
        let all = [Pace {
            rate: Some(1e6),
            first: 1 << 14,
        }; 2];
        let mut left = 64_000_000;
        let mut before = u64::MAX;
        while left > 0 {
            let paths = portion(left, &all, 0)
                .expect("the first of two equal ones")
                .min(left);
            assert!(paths <= before);
            before = paths;
            left -= paths;
        }
        assert!(before <= 20_000);
        // A slow device leaves the rest to a faster one, which doesn't wait.
        let all = [1e6, 1e3].map(|rate| Pace {
            rate: Some(rate),
            first: 1 << 14,
        });
        assert_eq!(portion(6_400, &all, 1), None);
        assert!(portion(6_400, &all, 0).is_some());
    }
}
