//! What all reports of measurements begin with, and how they become files.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use device::Device;
use engine::load;
use engine::scene::look::Look;
use engine::stats::DeviceFacts;
use patina_bench::report::conditions::{self, Conditions};
use serde::Serialize;

use crate::failure::Failure;
use crate::{library, output};

use super::job::{Amount, Effort};

/// Under which conditions whole renders are measured.
pub(super) fn conditions(effort: &Effort, amount: Amount, device: &Device) -> Conditions {
    Conditions {
        patina: env!("CARGO_PKG_VERSION"),
        commit: env!("PATINA_COMMIT"),
        date: conditions::date(),
        device: DeviceFacts::new(device.description()),
        width: amount.width,
        height: amount.height,
        samples_per_pixel: amount.spp,
        max_depth: effort.max_depth,
        runs: amount.runs,
    }
}

/// Makes sure, before anything is measured, that reports can be written, and over nothing that is read: scenes, a look, what
/// these name, and textures.
///
/// # Errors
/// As [`output::check_all`] and [`library::texture_dirs`], and a look that can't be read.
pub(super) fn check(
    written: &[PathBuf],
    scenes: &[&PathBuf],
    look: Option<&Path>,
    texture_dirs: &[PathBuf],
) -> Result<(), Failure> {
    let mut read = library::files(&library::texture_dirs(texture_dirs, look)?);
    read.extend(look.map(Path::to_owned));
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
