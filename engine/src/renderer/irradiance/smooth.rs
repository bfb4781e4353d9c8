//! Takes noise out of records by what their neighbours have found.
//!
//! Some hundred rays of a record that find a bright spot of the floor now and then leave it a few percent too bright or too dark, and
//! since all pixels around share that, it is seen as a blotch. Its neighbours have other rays. So a plane is laid through what they say
//! about the light there, and where they differ from it by no more than their noise, the plane is right rather than the record (a local
//! linear regression: Cleveland, "Robust Locally Weighted Regression and Smoothing Scatterplots", 1979, without its robust weights).

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use super::grid::Grid;
use super::records::Record;
use crate::gpu_scene::lights::luminance;

/// How far away neighbours are asked, over the radius.
const REACH: f32 = 5.0;
/// Records that must be there, one's own among them: three of them any plane would fit.
const LEAST: usize = 8;
/// Their normals are as near, as a cosine.
const LEAST_FACING: f32 = 0.98;
/// How high above each other they lie at most, over the distance that is asked.
const MOST_HEIGHT: f32 = 0.1;
/// Mean square of what they differ by, over that of their standard errors, which are too large, since neighbouring strata differ by more than
/// noise: the plane counts alone up to the first, and from the second on not at all.
const NOISE: [f32; 2] = [0.5, 1.0];
/// By how much slopes are drawn to nothing, of the weights, so that records in a row have a plane.
const RIDGE: f32 = 1e-3;

/// Makes records what a plane through their neighbours says, as far as these differ from it by noise.
pub(super) fn smooth(records: &mut [Record], slots: u32, references: usize) {
    let grid = Grid::of(records, REACH, slots, references);
    let smoothed: Vec<Record> = records
        .par_iter()
        .map(|record| smoothed(record, records, &grid).unwrap_or(*record))
        .collect();
    records.copy_from_slice(&smoothed);
}

/// What a record becomes; `None` if it stays as it is.
fn smoothed(record: &Record, records: &[Record], grid: &Grid) -> Option<Record> {
    let facing = record.facing();
    let (across, along) = facing.any_orthonormal_pair();
    let reach = REACH * record.radius;
    // Each with its place on the plane, 1 and the two offsets, and its weight.
    let neighbours: Vec<(&Record, Vec3, f32)> = grid
        .at(record.position)
        .map(|other| &records[other as usize])
        .filter_map(|other| {
            let offset = other.position - record.position;
            let apart = offset.length() / reach;
            let is_beside = other.facing().dot(facing) > LEAST_FACING
                && offset.dot(facing).abs() < MOST_HEIGHT * reach;
            let place = Vec3::new(1.0, offset.dot(across) / reach, offset.dot(along) / reach);
            let weight = (1.0 - apart * apart).max(0.0).powi(2);
            (is_beside && weight > 0.0).then_some((other, place, weight))
        })
        .collect();
    if neighbours.len() < LEAST {
        return None;
    }
    let mut moments = Mat3::ZERO;
    // Of red, green and blue.
    let mut sums = Mat3::ZERO;
    for &(other, place, weight) in &neighbours {
        moments += weight * outer(place, place);
        sums += weight * outer(place, other.irradiance);
    }
    let ridge = RIDGE * moments.x_axis.x;
    let moments = moments + Mat3::from_diagonal(Vec3::new(0.0, ridge, ridge));
    // Height and slopes of each colour.
    let plane = moments.inverse() * sums;
    let of_place = plane.transpose();
    let (mut unlike, mut noise) = (0.0, 0.0);
    for &(other, place, weight) in &neighbours {
        let difference = luminance(other.irradiance - of_place * place);
        unlike += weight * difference * difference;
        noise += weight * other.error().powi(2);
    }
    let share = ((NOISE[1] - unlike / noise.max(1e-30)) / (NOISE[1] - NOISE[0])).clamp(0.0, 1.0);
    let level = of_place.x_axis;
    if !(share > 0.0 && plane.is_finite() && level.min_element() >= 0.0) {
        return None;
    }
    let slopes = [0, 1, 2].map(|colour| {
        let [_, u, v] = plane.col(colour).to_array();
        (across * u + along * v) / reach
    });
    let mut gradients = record.gradients;
    for (gradient, slope) in gradients.iter_mut().zip(slopes) {
        *gradient = Vec3::from(*gradient).lerp(slope, share).to_array();
    }
    Some(Record {
        irradiance: record.irradiance.lerp(level, share),
        gradients,
        ..*record
    })
}

/// The matrix of all products: column c is `a` times the component c of `b`.
fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records on a floor, 0.1 apart, of radius 0.06, whose light is this at (x, y) and which claim to be right to a tenth.
    fn floor(light: impl Fn(f32, f32) -> f32) -> Vec<Record> {
        let at = |i: usize| (i % 20) as f32 * 0.1;
        (0..400)
            .map(|i| Record {
                radius: 0.06,
                irradiance: Vec3::splat(light(at(i), at(i / 20))),
                ..Record::begun(Vec3::new(at(i), at(i / 20), 0.0), 0, 0.01).with_error(0.1)
            })
            .collect()
    }

    fn smoothed_floor(light: impl Fn(f32, f32) -> f32) -> Vec<Record> {
        let mut records = floor(light);
        smooth(&mut records, 1 << 12, 1 << 16);
        records
    }

    /// Between -0.05 and 0.05, a pattern that no plane fits.
    fn noise(x: f32, y: f32) -> f32 {
        ((x * 91.7 + y * 57.3).sin() * 4_375.5).fract() * 0.05
    }

    #[test]
    fn a_slope_stays_and_becomes_the_gradient() {
        for record in smoothed_floor(|x, y| 1.0 + 0.3 * x - 0.1 * y) {
            let truth = 1.0 + 0.3 * record.position.x - 0.1 * record.position.y;
            assert!((record.irradiance.y - truth).abs() < 2e-3, "{record:?}");
            let [x, y, z] = record.gradients[1];
            assert!((x - 0.3).abs() < 0.02 && (y + 0.1).abs() < 0.02 && z.abs() < 1e-6);
        }
    }

    #[test]
    fn noise_goes() {
        let deviation = |records: &[Record]| -> f32 {
            let squares = records.iter().map(|r| (r.irradiance.x - 1.0).powi(2));
            (squares.sum::<f32>() / records.len() as f32).sqrt()
        };
        let before = deviation(&floor(|x, y| 1.0 + noise(x, y)));
        let after = deviation(&smoothed_floor(|x, y| 1.0 + noise(x, y)));
        assert!(after < 0.5 * before, "{before} became {after}");
    }

    #[test]
    fn a_step_stays() {
        let step = |x: f32, _: f32| if x < 0.95 { 1.0 } else { 3.0 };
        for (smoothed, before) in smoothed_floor(step).iter().zip(floor(step)) {
            assert!(
                (smoothed.irradiance - before.irradiance)
                    .abs()
                    .max_element()
                    < 1e-3
            );
        }
    }

    #[test]
    fn records_in_a_row_have_a_plane_too() {
        let mut row = floor(|x, _| 1.0 + x);
        row.retain(|record| record.position.y == 0.0);
        smooth(&mut row, 1 << 8, 1 << 12);
        for record in &row {
            let truth = 1.0 + record.position.x;
            assert!((record.irradiance.x - truth).abs() < 0.02, "{record:?}");
        }
    }
}
