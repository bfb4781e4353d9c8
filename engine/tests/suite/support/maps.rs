//! What to look at when a comparison fails: both pictures, where they differ and how unlikely that is by chance.

use std::fs;
use std::path::{Path, PathBuf};

use image::{ImageError, Rgb, RgbImage};

use super::estimate::Estimate;
use super::stats::Comparison;

/// Writes the maps of a comparison into a folder of its own under `target/test-failures/` and returns that:
///
/// - `tested.png`, `reference.png`: the pictures, exposed alike;
/// - `error.png`: red where too bright, blue where too dark, full at ten combined standard errors;
/// - `p-value.png`: white for 1, black for 1e-6 and less, on a logarithmic scale; failing pixels in red.
///
/// # Errors
/// The files can't be written.
pub(crate) fn write(comparison: &Comparison, name: &str) -> Result<PathBuf, ImageError> {
    // Cargo gives tests `target/tmp`; its neighbour outlives `cargo test` runs as well and is easier to find.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let dir = target
        .parent()
        .unwrap_or(target)
        .join("test-failures")
        .join(name);
    fs::create_dir_all(&dir)?;
    let reference = comparison.reference();
    let exposure = 0.5 / average(reference).max(1.0e-6);
    view(comparison.tested(), exposure).save(dir.join("tested.png"))?;
    view(reference, exposure).save(dir.join("reference.png"))?;
    map(reference, |i| {
        let z: f64 = comparison.z(i).iter().sum::<f64>() / 3.0;
        let strength = code(z.abs() / 10.0);
        if z > 0.0 {
            [strength, 0, 0]
        } else {
            [0, 0, strength]
        }
    })
    .save(dir.join("error.png"))?;
    map(reference, |i| {
        let level = code(1.0 + comparison.p_value(i).max(1.0e-6).log10() / 6.0);
        if comparison.passes(i) {
            [level; 3]
        } else {
            [255, level, level]
        }
    })
    .save(dir.join("p-value.png"))?;
    Ok(dir)
}

fn view(picture: &Estimate, exposure: f64) -> RgbImage {
    // A plain power of 2.2 is close enough to sRGB for looking.
    map(picture, |i| {
        picture.mean[i].map(|value| code((f64::from(value) * exposure).max(0.0).powf(1.0 / 2.2)))
    })
}

fn map(size: &Estimate, color: impl Fn(usize) -> [u8; 3]) -> RgbImage {
    RgbImage::from_fn(size.width as u32, size.height as u32, |x, y| {
        Rgb(color(y as usize * size.width + x as usize))
    })
}

fn average(picture: &Estimate) -> f64 {
    let values = picture.mean.iter().flatten().map(|&value| f64::from(value));
    values.filter(|value| value.is_finite()).sum::<f64>() / (picture.mean.len() * 3) as f64
}

/// A value in [0, 1] as a byte; what lies outside is clamped and NaN is 0.
fn code(value: f64) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}
