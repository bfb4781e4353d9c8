//! A furnished room against the picture that its gallery shows: the same layout, the same level of light.
//!
//! The gallery's picture is made for looking at: its highlights are compressed by a curve that nobody states, so pixels
//! can't be compared one by one. What must agree is where it is bright and dark, and the level of its middle tones.

use engine::load::load;
use engine::renderer::{RenderSettings, Renderer};

use crate::support::{device, shared};

/// Cells in which both pictures are averaged.
const COLUMNS: usize = 16;
const ROWS: usize = 9;
/// Pixels of a cell in our picture, each way.
const CELL: usize = 4;

fn luminance([r, g, b]: [f32; 3]) -> f64 {
    f64::from(0.2126 * r + 0.7152 * g + 0.0722 * b)
}

/// IEC 61966-2-1.
fn decode(v: u8) -> f32 {
    let v = f32::from(v) / 255.0;
    if v <= 0.04045 {
        v / 12.92
    } else {
        ((v + 0.055) / 1.055).powf(2.4)
    }
}

/// Mean luminance of each cell of a picture, what is brighter than white counted as white.
fn cells(width: usize, height: usize, pixel: impl Fn(usize, usize) -> [f32; 3]) -> Vec<f64> {
    let mut cells = Vec::new();
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let mut sum = 0.0;
            let mut count = 0.0;
            for y in row * height / ROWS..(row + 1) * height / ROWS {
                for x in column * width / COLUMNS..(column + 1) * width / COLUMNS {
                    sum += luminance(pixel(x, y).map(|v| v.min(1.0)));
                    count += 1.0;
                }
            }
            cells.push(sum / count);
        }
    }
    cells
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let moment = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        a.iter().zip(b).map(|(&a, &b)| f(a - ma, b - mb)).sum()
    };
    moment(&|a, b| a * b) / (moment(&|a, _| a * a) * moment(&|_, b| b * b)).sqrt()
}

#[test]
fn the_living_room_is_laid_out_and_lit_as_in_its_gallery() {
    let Some(folder) = shared::find("scenes/interior-living-room") else {
        return;
    };
    let Some(device) = device::open() else { return };
    let picture = folder.join("original/mitsuba3-gallery-living-room.png");
    let picture = image::open(picture)
        .expect("the gallery's picture")
        .to_rgb8();
    let (width, height) = picture.dimensions();
    let theirs = cells(width as usize, height as usize, |x, y| {
        picture.get_pixel(x as u32, y as u32).0.map(decode)
    });

    let file = folder.join("living-room.gltf");
    let loaded = load(&file, None, &[]).unwrap_or_else(|error| panic!("{error}"));
    let (width, height) = (COLUMNS * CELL, ROWS * CELL);
    let settings = RenderSettings::new(width as u32, height as u32, &loaded.camera);
    let mut renderer = Renderer::new(&device, &loaded.scene, &loaded.procedural, &settings)
        .unwrap_or_else(|error| panic!("{error}"));
    renderer
        .render(64)
        .unwrap_or_else(|error| panic!("{error}"));
    let stats = renderer.stats().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(stats.invalid_samples, 0);
    let mean = renderer
        .film()
        .unwrap_or_else(|error| panic!("{error}"))
        .mean();
    let ours = cells(width, height, |x, y| mean[y * width + x]);

    let layout = correlation(&ours, &theirs);
    // Cells that are neither shadow nor highlight, where any curve is gentle.
    let mut ratios: Vec<f64> = ours
        .iter()
        .zip(&theirs)
        .filter(|(_, theirs)| (0.05..0.5).contains(*theirs))
        .map(|(ours, theirs)| ours / theirs)
        .collect();
    ratios.sort_by(f64::total_cmp);
    let level = ratios[ratios.len() / 2];
    eprintln!(
        "correlation {layout:.3}, level {level:.2} of {} cells",
        ratios.len()
    );
    // A room turned round or without its windows gives less than 0.6.
    assert!(layout > 0.92, "correlation {layout}");
    // A curve takes a third of a stop from middle tones, not a whole one.
    assert!((0.8..1.7).contains(&level), "level {level}");
}
