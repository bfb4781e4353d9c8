//! What all reports of measurements begin with, and how they become files.

use std::io::Write as _;

use engine::gpu::Gpu;
use serde::Serialize;

use crate::exit::Failure;
use crate::output;
use crate::report::Device;

use super::job::Effort;

/// Under which conditions whole renders were measured.
#[derive(Debug, Serialize)]
pub(super) struct Conditions {
    /// Version of this program.
    patina: &'static str,
    device: Device,
    /// Pixels.
    width: u32,
    /// Pixels.
    height: u32,
    samples_per_pixel: u32,
    max_depth: u32,
    /// Timed runs of each case, in turn.
    runs: u32,
}

impl Conditions {
    pub(super) fn new(effort: &Effort, gpu: &Gpu) -> Self {
        Self {
            patina: env!("CARGO_PKG_VERSION"),
            device: Device::new(gpu.description()),
            width: effort.width,
            height: effort.height,
            samples_per_pixel: effort.spp,
            max_depth: effort.max_depth,
            runs: effort.runs,
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

/// Makes sure that the figures can be written before they are measured.
///
/// # Errors
/// As [`output::check`].
pub(super) fn check(effort: &Effort) -> Result<(), Failure> {
    match &effort.json {
        Some(path) => output::check(path).map_err(Failure::because),
        None => Ok(()),
    }
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
