//! The pictures of a folder side by side, each with its name: the sheet of `cargo xtask gallery`.
//!
//! `cargo run --example gallery_sheet -- FOLDER SHEET.jpg`

#[path = "../contact_sheet/label.rs"]
mod label;

use std::error::Error;
use std::path::PathBuf;

use image::codecs::jpeg::JpegEncoder;
use image::{Rgb, RgbImage};

const COLUMNS: u32 = 6;
/// Below each picture, for its name, pixels.
const STRIP: u32 = 12;
/// Largest file.
const MOST_BYTES: usize = 300_000;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [folder, sheet] = args.as_slice() else {
        return Err("usage: gallery_sheet FOLDER SHEET.jpg".into());
    };
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)?
        .map(|entry| Ok(entry?.path()))
        .collect::<std::io::Result<_>>()?;
    files.retain(|file| file.extension().is_some_and(|ending| ending == "png"));
    files.sort();
    let first = files.first().ok_or("there is no picture in the folder")?;
    let (width, height) = image::open(first)?.to_rgb8().dimensions();
    let rows = (files.len() as u32).div_ceil(COLUMNS);
    let size = (COLUMNS * width, rows * (height + STRIP));
    let mut picture = RgbImage::from_pixel(size.0, size.1, Rgb([38; 3]));
    for (i, file) in (0..).zip(&files) {
        let (x, y) = (i % COLUMNS * width, i / COLUMNS * (height + STRIP));
        let tile = image::open(file)?.to_rgb8();
        image::imageops::replace(&mut picture, &tile, x.into(), y.into());
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        label::write(&mut picture, x + 4, y + height + 3, &name);
    }
    for quality in (30..=92).rev().step_by(3) {
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, quality).encode_image(&picture)?;
        if bytes.len() <= MOST_BYTES {
            std::fs::write(sheet, bytes)?;
            return Ok(());
        }
    }
    Err("the picture is too large at any quality".into())
}
