//! What all reports of measurements begin with, and how they become files.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use device::Device;
use engine::load;
use engine::scene::look::Look;
use serde::Serialize;

use crate::exit::Failure;
use crate::output;
use crate::report::DeviceFacts;

use super::job::{Amount, Effort};

/// Under which conditions whole renders were measured.
#[derive(Debug, Serialize)]
pub(super) struct Conditions {
    /// Version of this program.
    pub(super) patina: &'static str,
    /// Commit that it was built from, with `-modified` where more was changed; `unknown` outside of a repository.
    pub(super) commit: &'static str,
    /// When the report was made: UTC, ISO 8601.
    pub(super) date: String,
    pub(super) device: DeviceFacts,
    /// Pixels.
    pub(super) width: u32,
    /// Pixels.
    pub(super) height: u32,
    pub(super) samples_per_pixel: u32,
    pub(super) max_depth: u32,
    /// Timed runs of each case, in turn.
    pub(super) runs: u32,
}

impl Conditions {
    pub(super) fn new(effort: &Effort, amount: Amount, gpu: &Device) -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        Self {
            patina: env!("CARGO_PKG_VERSION"),
            commit: env!("PATINA_COMMIT"),
            date: utc(since.map_or(0, |since| since.as_secs())),
            device: DeviceFacts::new(gpu.description()),
            width: amount.width,
            height: amount.height,
            samples_per_pixel: amount.spp,
            max_depth: effort.max_depth,
            runs: amount.runs,
        }
    }

    /// The head of a table.
    pub(super) fn text(&self) -> String {
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

/// Makes sure, before anything is measured, that reports can be written, and over nothing that is read: scenes, a look, and
/// what these name.
///
/// # Errors
/// As [`output::check_all`], and a look that can't be read.
pub(super) fn check(
    written: &[PathBuf],
    scenes: &[&PathBuf],
    look: Option<&Path>,
) -> Result<(), Failure> {
    let mut read: Vec<PathBuf> = look.iter().map(|look| look.to_path_buf()).collect();
    let look = look.map(Look::load).transpose()?;
    for scene in scenes {
        read.extend(load::files(scene, look.as_ref()));
    }
    output::check_all(written, &read)
}

/// Writes the figures where they are wanted.
///
/// # Errors
/// A file that can't be written.
pub(super) fn write(effort: &Effort, report: &impl Serialize) -> Result<(), Failure> {
    let Some(path) = &effort.json else {
        return Ok(());
    };
    output::write_aside(path, |file| {
        serde_json::to_writer_pretty(&mut *file, report)?;
        file.write_all(b"\n")
    })
    .map_err(Failure::because)
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
