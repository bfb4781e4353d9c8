//! Under which conditions figures were measured: what all reports begin with.

use std::time::{SystemTime, UNIX_EPOCH};

use engine::stats::DeviceFacts;
use serde::Serialize;

/// Under which conditions whole renders were measured.
#[derive(Debug, Clone, Serialize)]
pub struct Conditions {
    /// Version of the program.
    pub patina: &'static str,
    /// Commit that it was built from, with `-modified` where more was changed; `unknown` outside of a repository.
    pub commit: &'static str,
    /// When the report was made: UTC, ISO 8601. See [`date`].
    pub date: String,
    /// What was measured on.
    pub device: DeviceFacts,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Of each run.
    pub samples_per_pixel: u32,
    /// Most scattering vertices of a path.
    pub max_depth: u32,
    /// Timed runs of each case, in turn.
    pub runs: u32,
}

impl Conditions {
    /// The head of a table.
    pub fn text(&self) -> String {
        format!(
            "{}\n{}x{}, {} samples per pixel, depth {}; medians of {} runs in turn (lowest to highest)\n",
            self.device.title,
            self.width,
            self.height,
            self.samples_per_pixel,
            self.max_depth,
            self.runs
        )
    }
}

/// Now: UTC, ISO 8601.
pub fn date() -> String {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    utc(since.map_or(0, |since| since.as_secs()))
}

/// Seconds since 1970 as ISO 8601: years of the Gregorian calendar repeat every 400 years, and a year that begins in March
/// has its leap day last.
fn utc(seconds: u64) -> String {
    const DAYS_OF_400_YEARS: u64 = 146_097;
    // From 1 March of the year 0 to 1 January 1970.
    let days = seconds / 86_400 + 719_468;
    let (era, day) = (days / DAYS_OF_400_YEARS, days % DAYS_OF_400_YEARS);
    // Without the leap days: every 4 years, not every 100, but every 400.
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    // Lengths of months from March on repeat 31 30 31 30 31.
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, after) = if month < 10 {
        (month + 3, 0)
    } else {
        (month - 9, 1)
    };
    let year = era * 400 + year + after;
    let (hour, minute) = (seconds / 3_600 % 24, seconds / 60 % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}Z")
}

#[cfg(test)]
mod tests {
    use super::utc;

    #[test]
    fn dates_follow_the_calendar() {
        for (seconds, expected) in [
            (0, "1970-01-01T00:00Z"),
            (951_782_399, "2000-02-28T23:59Z"),
            (951_782_400, "2000-02-29T00:00Z"),
            (951_868_800, "2000-03-01T00:00Z"),
            (1_735_689_599, "2024-12-31T23:59Z"),
            (1_735_689_600, "2025-01-01T00:00Z"),
            (4_107_542_400, "2100-03-01T00:00Z"),
        ] {
            assert_eq!(utc(seconds), expected);
        }
    }
}
