//! How large the picture is while something moves, and how often it is shown: decided by how long samples take.

use std::time::Duration;

/// A moving picture's first samples shall be there so soon. With the wave that is under way, the display and a frame of the
/// window, the picture is on screen within half a second.
const MOVING: Duration = Duration::from_millis(150);
/// Most that sides are divided by while moving.
const COARSEST: u32 = 8;

/// What a processor is thought to take for a path until it has been measured. Others are fast enough for any guess.
const SECONDS_ON_CPU: f64 = 2e-5;

/// What was measured.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pace {
    seconds_per_path: Option<f64>,
}

impl Pace {
    /// Before anything is measured.
    pub fn of(is_cpu: bool) -> Self {
        Self {
            seconds_per_path: is_cpu.then_some(SECONDS_ON_CPU),
        }
    }

    /// So many camera paths took so long.
    pub fn note(&mut self, paths: u64, took: Duration) {
        if paths == 0 {
            return;
        }
        let now = took.as_secs_f64() / paths as f64;
        // The first waves after a change may include the driver's compilation.
        let mean = self
            .seconds_per_path
            .map_or(now, |mean| 0.7 * mean + 0.3 * now);
        self.seconds_per_path = Some(mean);
    }

    /// Camera paths per second.
    pub fn paths_per_second(&self) -> Option<f64> {
        self.seconds_per_path.filter(|s| *s > 0.0).map(|s| 1.0 / s)
    }

    /// Size of the picture while something moves: the sides divided by a whole number.
    pub fn moving_size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let seconds =
            self.seconds_per_path.unwrap_or_default() * f64::from(width) * f64::from(height);
        let wanted = (seconds / MOVING.as_secs_f64()).sqrt().ceil();
        // `as` saturates.
        let divisor = (wanted as u32).clamp(1, COARSEST);
        [width, height].map(|side| (side / divisor).max(1))
    }
}

/// How long to wait before the picture is shown again, so long after it began: often at first, when it changes much.
pub fn interval(since_start: Duration) -> Duration {
    (since_start / 8).clamp(Duration::from_millis(50), Duration::from_secs(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_devices_get_smaller_pictures_while_moving() {
        let mut pace = Pace::default();
        assert_eq!(pace.moving_size([640, 360]), [640, 360]);
        assert_eq!(Pace::of(false).moving_size([640, 360]), [640, 360]);
        assert!(Pace::of(true).moving_size([640, 360])[0] < 160);
        // 100,000 paths per second: 2.3 s for all pixels, a sixteenth of them in time.
        pace.note(100_000, Duration::from_secs(1));
        let [width, height] = pace.moving_size([640, 360]);
        assert_eq!([width, height], [160, 90]);
        let seconds = f64::from(width * height) / pace.paths_per_second().unwrap();
        assert!(seconds <= MOVING.as_secs_f64());
        // A GPU needs no reduction, and nothing becomes smaller than a pixel.
        let mut fast = Pace::default();
        fast.note(100_000_000, Duration::from_secs(1));
        assert_eq!(fast.moving_size([1920, 1080]), [1920, 1080]);
        pace.note(1, Duration::from_secs(1000));
        assert_eq!(pace.moving_size([2, 2]), [1, 1]);
    }

    #[test]
    fn the_picture_is_shown_less_often_as_it_settles() {
        assert_eq!(interval(Duration::ZERO), Duration::from_millis(50));
        assert!(interval(Duration::from_secs(2)) < interval(Duration::from_secs(6)));
        assert_eq!(interval(Duration::from_secs(600)), Duration::from_secs(1));
    }
}
