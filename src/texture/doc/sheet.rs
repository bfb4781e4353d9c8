//! Sheets: the swatches of a group in rows.

use std::f32::consts::TAU;
use std::path::Path;

use device::{Device, DeviceChoice};
use engine::film::write::{Format, save_shown};
use engine::procedural::TextureSources;

use crate::console;
use crate::failure::Failure;
use crate::output::OutputError;
use crate::progress::Bar;

use super::swatch::{SIDE, swatch};
use super::{Group, page};

/// Swatches in a row.
const COLUMNS: usize = 7;
/// Between swatches, pixels.
const GAP: usize = 6;
/// Side of the picture that image parameters show, pixels.
const CARD: usize = 128;

/// Writes the sheets of all groups into a folder.
///
/// # Errors
/// The device refuses, or a file can't be written.
pub(super) fn write_all(
    groups: &[Group],
    sources: &TextureSources,
    folder: &Path,
    device: &DeviceChoice,
) -> Result<(), Failure> {
    let bar = Bar::new("preparing the device");
    let device = Device::open(device).map_err(Failure::because)?;
    bar.follow(&device);
    let scratch = tempfile::tempdir().map_err(Failure::because)?;
    let card = scratch.path().join("card.png");
    save(&card, [CARD; 2], &test_card())?;
    let mut written = Vec::new();
    for group in groups {
        let count = group.textures.len();
        let rows = count.div_ceil(COLUMNS);
        let size = [
            COLUMNS.min(count) * (SIDE + GAP) + GAP,
            rows * (SIDE + GAP) + GAP,
        ];
        let mut pixels = vec![[255u8; 3]; size[0] * size[1]];
        for (place, texture) in group.textures.iter().enumerate() {
            let shown = swatch(&device, sources, texture, &card.display().to_string())?;
            let left = GAP + place % COLUMNS * (SIDE + GAP);
            let top = GAP + place / COLUMNS * (SIDE + GAP);
            for (i, pixel) in shown.iter().enumerate() {
                let at = (top + i / SIDE) * size[0] + left + i % SIDE;
                pixels[at] = pixel.map(encoded);
            }
        }
        let path = folder.join(page::file_name(&group.name));
        save(&path, size, &pixels)?;
        written.push(path.display().to_string());
    }
    bar.finish();
    console::note(&format!("wrote {}", written.join(", ")));
    Ok(())
}

fn save(path: &Path, size: [usize; 2], rgb: &[[u8; 3]]) -> Result<(), Failure> {
    let rgba: Vec<u8> = rgb.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
    let format = Format::of(path).unwrap_or(Format::Png);
    // Sides are some thousands of pixels at most.
    let size = size.map(|side| side as u32);
    save_shown(path, format, size, &rgba)
        .map_err(|error| Failure::because(OutputError::new(path, error)))
}

/// A linear value as sRGB.
fn encoded(value: f32) -> u8 {
    let v = value.clamp(0.0, 1.0);
    // IEC 61966-2-1.
    let encoded = match v <= 0.003_130_8 {
        true => 12.92 * v,
        false => 1.055 * v.powf(1.0 / 2.4) - 0.055,
    };
    (encoded * 255.0).round() as u8
}

/// Discs on a gradient, which repeats at its borders.
fn test_card() -> Vec<[u8; 3]> {
    let colors = [
        [214u8, 90, 60],
        [240, 190, 80],
        [60, 110, 140],
        [235, 230, 215],
    ];
    (0..CARD * CARD)
        .map(|i| {
            let [x, y] = [i % CARD, i / CARD].map(|n| (n as f32 + 0.5) / CARD as f32);
            let cell = |v: f32| (v * 4.0).floor() as usize;
            let number = cell(x) * 7 + cell(y) * 3;
            let [dx, dy] = [x, y].map(|v| (v * 4.0).fract() - 0.5);
            let radius = 0.2 + 0.06 * (number % 5) as f32;
            match (dx * dx + dy * dy).sqrt() < radius {
                true => colors[number % colors.len()],
                false => [
                    (70.0 + 60.0 * (x * TAU).cos()) as u8,
                    90,
                    (90.0 + 50.0 * (y * TAU).cos()) as u8,
                ],
            }
        })
        .collect()
}
