//! How large the picture is while something moves, and how often it is shown: decided by how long samples take.

use std::time::Duration;

use device::Traits;

/// A moving picture's samples may take so long, where the device does nothing else. A change may have to wait until the
/// picture before it has been seen, and is on screen in time all the same.
const MOVING: Duration = Duration::from_millis(40);
/// Less than this would leave nothing to be seen.
const SHORTEST: Duration = Duration::from_millis(10);
/// More than this only seems to be needed: what samples take was measured while others took the device's time.
const LONGEST: Duration = Duration::from_millis(120);
/// A change is to be seen so soon. One that comes while a picture is under way waits for two: where that takes no longer, 15 pictures come
/// in a second.
const GOAL_ON_GPU: Duration = Duration::from_millis(100);
const GOAL_ON_CPU: Duration = Duration::from_millis(150);
/// Of the goal: with more than the first moving pictures become smaller, with less than the second larger.
const LATE: f64 = 0.75;
const EARLY: f64 = 0.6;
/// Most that sides are divided by while moving.
const COARSEST: u32 = 16;

/// What a processor is thought to take for a path until it has been measured, by itself and by a driver in software. Others are
/// fast enough for any guess.
const SECONDS_ON_CPU: f64 = 4e-6;
const SECONDS_BY_DRIVER: f64 = 2e-5;

/// What was measured.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    seconds_per_path: Option<f64>,
    /// For the samples of a moving picture: [`MOVING`] at first; less where other things, the window's frames for one, take
    /// the device's time.
    budget: Duration,
    /// From a change to its picture.
    goal: Duration,
}

impl Pace {
    /// Before anything is measured.
    pub fn of(device: Traits) -> Self {
        let (seconds_per_path, goal) = match (device.shares_the_processor, device.compiles_slowly) {
            (false, _) => (None, GOAL_ON_GPU),
            (true, false) => (Some(SECONDS_ON_CPU), GOAL_ON_CPU),
            (true, true) => (Some(SECONDS_BY_DRIVER), GOAL_ON_CPU),
        };
        Self {
            seconds_per_path,
            budget: MOVING,
            goal,
        }
    }

    /// So many camera paths took so long. While something moves, frames of the window lie between them: that counts only
    /// where nothing else is known.
    pub fn note(&mut self, paths: u64, took: Duration, is_moving: bool) {
        if paths == 0 || is_moving && self.seconds_per_path.is_some() {
            return;
        }
        let now = took.as_secs_f64() / paths as f64;
        // The first waves after a change may include the driver's compilation.
        let mean = self
            .seconds_per_path
            .map_or(now, |mean| 0.7 * mean + 0.3 * now);
        self.seconds_per_path = Some(mean);
    }

    /// So long after a change its moving picture was there.
    pub fn note_latency(&mut self, latency: Duration) {
        let factor = match latency.div_duration_f64(self.goal) {
            late if late > LATE => 0.8,
            early if early < EARLY => 1.1,
            _ => return,
        };
        self.budget = self.budget.mul_f64(factor).clamp(SHORTEST, LONGEST);
    }

    /// Camera paths per second.
    pub fn paths_per_second(&self) -> Option<f64> {
        self.seconds_per_path.filter(|s| *s > 0.0).map(|s| 1.0 / s)
    }

    /// What the sides of the picture are divided by while something moves.
    pub fn moving_divisor(&self, [width, height]: [u32; 2]) -> u32 {
        let seconds =
            self.seconds_per_path.unwrap_or_default() * f64::from(width) * f64::from(height);
        let wanted = (seconds / self.budget.as_secs_f64()).sqrt().ceil();
        // `as` saturates.
        (wanted as u32).clamp(1, COARSEST)
    }
}

/// How long to wait before the picture is shown again, so long after it began: often at first, when it changes much.
pub fn interval(since_start: Duration) -> Duration {
    (since_start / 8).clamp(Duration::from_millis(50), Duration::from_secs(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(shares_the_processor: bool) -> Traits {
        let processor = device::Device::open(&device::DeviceChoice::Native(1));
        Traits {
            shares_the_processor,
            ..processor.expect("the processor").traits()
        }
    }

    #[test]
    fn slow_devices_get_smaller_pictures_while_moving() {
        let mut pace = Pace::of(device(false));
        assert_eq!(pace.moving_divisor([640, 360]), 1);
        assert!(Pace::of(device(true)).moving_divisor([640, 360]) > 4);
        // 100,000 paths per second: 2.3 s for all pixels, a fifty-eighth of them in time.
        pace.note(100_000, Duration::from_secs(1), true);
        assert_eq!(pace.moving_divisor([640, 360]), 8);
        let seconds = f64::from(80 * 45) / pace.paths_per_second().unwrap();
        assert!(seconds <= MOVING.as_secs_f64());
        // A GPU needs no reduction, and there is an end to it.
        let mut fast = Pace::of(device(false));
        fast.note(100_000_000, Duration::from_secs(1), false);
        assert_eq!(fast.moving_divisor([1920, 1080]), 1);
        // What is measured while something moves counts only where there is nothing else.
        pace.note(1, Duration::from_secs(1000), true);
        assert_eq!(pace.moving_divisor([640, 360]), 8);
        pace.note(1, Duration::from_secs(1000), false);
        assert_eq!(pace.moving_divisor([1920, 1080]), COARSEST);
    }

    #[test]
    fn pictures_that_come_late_become_smaller() {
        let mut pace = Pace::of(device(true));
        let first = pace.moving_divisor([640, 360]);
        let late = Duration::from_millis(200);
        pace.note_latency(late);
        assert!(pace.moving_divisor([640, 360]) > first);
        for _ in 0..100 {
            pace.note_latency(late);
        }
        let least = pace.moving_divisor([640, 360]);
        assert!(least < COARSEST);
        // In time is neither late nor early.
        pace.note_latency(Duration::from_millis(80));
        assert_eq!(pace.moving_divisor([640, 360]), least);
        // What seemed to be slow is given more time than it was thought to need.
        for _ in 0..100 {
            pace.note_latency(Duration::from_millis(50));
        }
        let most = pace.moving_divisor([640, 360]);
        assert!(most > 1 && most < first, "{most} {first}");
    }

    #[test]
    fn the_picture_is_shown_less_often_as_it_settles() {
        assert_eq!(interval(Duration::ZERO), Duration::from_millis(50));
        assert!(interval(Duration::from_secs(2)) < interval(Duration::from_secs(6)));
        assert_eq!(interval(Duration::from_secs(600)), Duration::from_secs(1));
    }
}
