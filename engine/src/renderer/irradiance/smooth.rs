//! Takes noise out of records by what their neighbours have found.
//!
//! Some hundred rays of a record that find a bright spot of the floor now and then leave it a few percent too bright or too dark, and
//! since all pixels around share that, it is seen as a blotch. Its neighbours have other rays. How the light changes from there to here their
//! gradients say, which are less noisy by far; so surfaces are laid through what neighbours say about the light here: a mean of the nearest, a plane, and
//! curved ones through more of them, for what gradients leave out (local regression: Cleveland, "Robust Locally Weighted Regression and
//! Smoothing Scatterplots", 1979, without its robust weights). How wrong each of these is follows from how well it foretells every neighbour from
//! all the others, beyond the noise that these are known to have, and from the noise that is left in it; the record becomes the mean of
//! itself and those that are likely to be less wrong, each by one over its expected square error.

use glam::Vec3;
use rayon::prelude::*;

use super::grid::Grid;
use super::records::Record;
use crate::gpu_scene::lights::luminance;

/// How far away neighbours are asked at most, over the lesser of both radii.
const REACH: f32 = 12.0;
/// Within how much of that noise is taken to be about the same.
const NEAR: f32 = 5.0;
/// Their normals are as near, as a cosine.
const LEAST_FACING: f32 = 0.9;
/// How high above each other they lie at most, over the distance that is asked.
const MOST_HEIGHT: f32 = 0.1;
/// Variance of a record over the square of its standard error, which neighbouring strata tell that differ by more than noise.
const NOISE: f32 = 0.9;
/// Where a surface is off at a record, over where it is off at its neighbours on average, squares of both.
const IN_THE_MIDDLE: f32 = 0.5;
/// Neighbours that a surface must have beside one for each of its numbers.
const SPARE: usize = 4;
/// By how much all but the height is drawn to nothing, of the weights, so that records in a row have a surface.
const RIDGE: f32 = 1e-3;

/// Makes records what surfaces through their neighbours say, as far as these are likely to be less wrong.
pub(super) fn smooth(records: &mut [Record], slots: u32, references: usize) {
    let grid = Grid::of(records, REACH, slots, references);
    let smoothed: Vec<Record> = records
        .par_iter()
        .map(|record| smoothed(record, records, &grid))
        .collect();
    records.copy_from_slice(&smoothed);
}

/// What a record becomes.
fn smoothed(record: &Record, records: &[Record], grid: &Grid) -> Record {
    let facing = record.facing();
    let tangents: [Vec3; 2] = facing.any_orthonormal_pair().into();
    let neighbours: Vec<Neighbour> = grid
        .at(record.position)
        .filter_map(|other| Neighbour::of(record, &records[other as usize], facing, tangents))
        .collect();
    let surfaces = [
        fitted::<FLAT>(&neighbours, 3.0),
        fitted::<PLANE>(&neighbours, NEAR),
        fitted::<CURVED>(&neighbours, 8.0),
        fitted::<CURVED>(&neighbours, REACH),
    ];
    let trust = |square_error: f32| 1.0 / square_error.max(1e-30);
    let own_trust = trust(noise_around(&neighbours));
    let more_trust = |surface: &Surface| (trust(surface.square_error) - own_trust).max(0.0);
    let surfaces = || surfaces.iter().flatten();
    let all = own_trust + surfaces().map(more_trust).sum::<f32>();
    let mixed = |own: Vec3, of: fn(&Surface) -> Vec3| {
        let others = surfaces().map(|surface| (more_trust(surface) / all) * of(surface));
        (own_trust / all) * own + others.sum::<Vec3>()
    };
    Record {
        irradiance: mixed(record.irradiance, |surface| surface.level),
        difference: mixed(record.difference, |surface| surface.difference),
        ..*record
    }
}

/// A record near another one, or this itself.
struct Neighbour {
    /// Where along the tangents, over the radius of the one in the middle.
    place: [f32; 2],
    /// How far away, over the lesser of both radii.
    apart: f32,
    /// What it says about the record in the middle, W/m2.
    irradiance: Vec3,
    /// By how much half of its rays find more, W/m2.
    difference: Vec3,
    /// Variance of its luminance.
    noise: f32,
}

impl Neighbour {
    /// None where it tells nothing of the record.
    fn of(record: &Record, other: &Record, facing: Vec3, tangents: [Vec3; 2]) -> Option<Self> {
        let offset = other.position - record.position;
        let apart = offset.length() / record.radius.min(other.radius);
        let is_beside = apart < REACH
            && other.facing().dot(facing) > LEAST_FACING
            && offset.dot(facing).abs() < MOST_HEIGHT * REACH * record.radius;
        // On the way the light changes by half of what either says, as where records are looked up.
        let change = [0, 1, 2].map(|colour| {
            let gradients = [record, other].map(|of| Vec3::from(of.gradients[colour]));
            0.5 * offset.dot(gradients[0] + gradients[1])
        });
        is_beside.then(|| Self {
            place: tangents.map(|tangent| offset.dot(tangent) / record.radius),
            apart,
            irradiance: other.irradiance - Vec3::from(change),
            difference: other.difference,
            noise: NOISE * other.error().powi(2),
        })
    }
}

/// Variance of the records around, on average. A record's own goes with what it has found by chance: those that are too dark would claim to
/// be right, and be believed, and those that are too bright would not.
fn noise_around(neighbours: &[Neighbour]) -> f32 {
    let (mut noise, mut weights) = (0.0, 0.0);
    for neighbour in neighbours {
        let weight = weight(neighbour.apart / NEAR);
        noise += weight * neighbour.noise;
        weights += weight;
    }
    noise / weights
}

/// What counts less and less up to the distance 1.
fn weight(apart: f32) -> f32 {
    (1.0 - apart * apart).max(0.0).powi(2)
}

/// Numbers of a mean, of a plane, and of a surface of the second order.
const FLAT: usize = 1;
const PLANE: usize = 3;
const CURVED: usize = 6;

/// What a surface says in the middle.
struct Surface {
    /// W/m2.
    level: Vec3,
    /// By how much half of the rays of all find more, W/m2.
    difference: Vec3,
    /// Square of what its luminance is likely to be off by.
    square_error: f32,
}

/// A surface through all neighbours that are no farther away, by least squares; None where there are too few, or it says less than no light.
fn fitted<const N: usize>(neighbours: &[Neighbour], reach: f32) -> Option<Surface> {
    // Each with its weight, and what the surface's numbers are multiplied by there.
    let asked = || {
        neighbours.iter().filter_map(move |neighbour| {
            let apart = neighbour.apart / reach;
            let [u, v] = neighbour.place.map(|along| along / reach);
            let all = [1.0, u, v, u * u, u * v, v * v];
            let terms: [f32; N] = std::array::from_fn(|i| all[i]);
            (apart < 1.0).then(|| (neighbour, weight(apart), terms))
        })
    };
    if asked().count() < N + SPARE {
        return None;
    }
    let mut moments = [[0.0; N]; N];
    let mut sums = [Vec3::ZERO; N];
    for (neighbour, weight, terms) in asked() {
        for i in 0..N {
            for j in 0..=i {
                moments[i][j] += weight * terms[i] * terms[j];
            }
            sums[i] += weight * terms[i] * neighbour.irradiance;
        }
    }
    let weights = moments[0][0];
    for (i, row) in moments.iter_mut().enumerate().skip(1) {
        row[i] += RIDGE * weights;
    }
    let root = Root::of(moments);
    // By what the height is made of each neighbour, and the numbers of the surface.
    let of_height = root.solve(std::array::from_fn(|i| if i == 0 { 1.0 } else { 0.0 }));
    let colours = [0, 1, 2].map(|colour| root.solve(sums.map(|sum| sum[colour])));
    let numbers: [Vec3; N] = std::array::from_fn(|i| Vec3::from(colours.map(|of| of[i])));
    let (mut unlike, mut noise, mut left) = (0.0, 0.0, 0.0);
    let mut difference = Vec3::ZERO;
    for (neighbour, weight, terms) in asked() {
        let found: Vec3 = (terms.iter().zip(numbers))
            .map(|(term, of)| *term * of)
            .sum();
        // Without this neighbour it would be off there by so much more.
        let own_share = weight * root.half(terms).map(|x| x * x).iter().sum::<f32>();
        let off = luminance(neighbour.irradiance - found) / (1.0 - own_share).max(0.05);
        unlike += weight * off * off;
        noise += weight * neighbour.noise;
        let share: f32 = (terms.iter().zip(of_height)).map(|(a, b)| a * b).sum();
        left += (weight * share).powi(2) * neighbour.noise;
        difference += weight * share * neighbour.difference;
    }
    let bias = IN_THE_MIDDLE * (unlike - noise).max(0.0) / weights;
    let (level, square_error) = (numbers[0], bias + left);
    let says_something = level.is_finite() && level.min_element() >= 0.0;
    (says_something && square_error.is_finite()).then_some(Surface {
        level,
        difference,
        square_error,
    })
}

/// The lower half of a symmetric matrix, by its square root (Cholesky).
struct Root<const N: usize>([[f32; N]; N]);

impl<const N: usize> Root<N> {
    /// Of a matrix whose lower half this is.
    fn of(mut lower: [[f32; N]; N]) -> Self {
        for i in 0..N {
            for j in 0..=i {
                let before: f32 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
                let rest = lower[i][j] - before;
                lower[i][j] = match i == j {
                    true => rest.max(1e-30).sqrt(),
                    false => rest / lower[j][j],
                };
            }
        }
        Self(lower)
    }

    /// What the root takes to `x`.
    fn half(&self, mut x: [f32; N]) -> [f32; N] {
        for i in 0..N {
            let before: f32 = (0..i).map(|k| self.0[i][k] * x[k]).sum();
            x[i] = (x[i] - before) / self.0[i][i];
        }
        x
    }

    /// What the matrix takes to `x`.
    fn solve(&self, x: [f32; N]) -> [f32; N] {
        let mut x = self.half(x);
        for i in (0..N).rev() {
            let after: f32 = (i + 1..N).map(|k| self.0[k][i] * x[k]).sum();
            x[i] = (x[i] - after) / self.0[i][i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records on a floor, 0.1 apart, of radius 0.06, whose light is this at (x, y), with its slope, and which claim to be right to a tenth.
    fn floor(light: impl Fn(f32, f32) -> f32, slope: [f32; 2]) -> Vec<Record> {
        let at = |i: usize| (i % 20) as f32 * 0.1;
        (0..400)
            .map(|i| Record {
                radius: 0.06,
                irradiance: Vec3::splat(light(at(i), at(i / 20))),
                gradients: [[slope[0], slope[1], 0.0]; 3],
                ..Record::begun(Vec3::new(at(i), at(i / 20), 0.0), 0, 0.01).with_error(0.1)
            })
            .collect()
    }

    fn made_smooth(mut records: Vec<Record>) -> Vec<Record> {
        smooth(&mut records, 1 << 12, 1 << 16);
        records
    }

    /// Between -0.05 and 0.05, a pattern that no surface fits.
    fn noise(x: f32, y: f32) -> f32 {
        ((x * 91.7 + y * 57.3).sin() * 4_375.5).fract() * 0.05
    }

    /// Root of the mean square of what they are off by.
    fn deviation(records: &[Record], light: impl Fn(f32, f32) -> f32) -> f32 {
        let squares = records.iter().map(|record| {
            let truth = light(record.position.x, record.position.y);
            (record.irradiance.x - truth).powi(2)
        });
        (squares.sum::<f32>() / records.len() as f32).sqrt()
    }

    #[test]
    fn a_slope_stays() {
        let slope = |x: f32, y: f32| 1.0 + 0.3 * x - 0.1 * y;
        for record in made_smooth(floor(slope, [0.3, -0.1])) {
            let truth = slope(record.position.x, record.position.y);
            assert!((record.irradiance.y - truth).abs() < 1e-5, "{record:?}");
        }
    }

    #[test]
    fn light_that_bends_stays_with_gradients_that_know_nothing_of_it() {
        let bent = |x: f32, y: f32| 2.0 - (x - 0.8).powi(2) + 0.5 * (x - 1.0) * (y - 1.0);
        let records = made_smooth(floor(bent, [0.0; 2]));
        let off = deviation(&records, bent);
        // They claim to be right to 0.2.
        assert!(off < 0.01, "{off}");
    }

    #[test]
    fn noise_goes() {
        let slope = |x: f32, y: f32| 1.0 + 0.3 * x - 0.1 * y;
        let noisy = floor(|x, y| slope(x, y) + noise(x, y), [0.3, -0.1]);
        let before = deviation(&noisy, slope);
        let after = deviation(&made_smooth(noisy), slope);
        assert!(after < 0.3 * before, "{before} became {after}");
    }

    #[test]
    fn a_step_stays() {
        // Between sun and shadow: by a small part of what they claim to be right to, on either side.
        let step = |x: f32, _: f32| if x < 0.95 { 1.0 } else { 3.0 };
        for record in made_smooth(floor(step, [0.0; 2])) {
            let truth = step(record.position.x, 0.0);
            let off = (record.irradiance.x - truth).abs();
            assert!(off < 0.015 * truth, "{off}: {record:?}");
        }
    }

    #[test]
    fn records_in_a_row_have_a_surface_too() {
        let mut row = floor(|x, _| 1.0 + x, [1.0, 0.0]);
        row.retain(|record| record.position.y == 0.0);
        for record in made_smooth(row) {
            let truth = 1.0 + record.position.x;
            assert!((record.irradiance.x - truth).abs() < 1e-3, "{record:?}");
        }
    }

    #[test]
    fn what_knows_nothing_of_others_stays() {
        let records = floor(noise, [0.0; 2]);
        let few = records[..4].to_vec();
        assert_eq!(made_smooth(few.clone()), few);
    }

    #[test]
    fn a_root_solves() {
        // Of these the lower half: [4, 2, 1; 2, 5, 3; 1, 3, 6].
        let root = Root::of([[4.0, 0.0, 0.0], [2.0, 5.0, 0.0], [1.0, 3.0, 6.0]]);
        let found = root.solve([9.0, 18.0, 25.0]);
        let product = [
            4.0 * found[0] + 2.0 * found[1] + found[2],
            2.0 * found[0] + 5.0 * found[1] + 3.0 * found[2],
            found[0] + 3.0 * found[1] + 6.0 * found[2],
        ];
        for (product, wanted) in product.into_iter().zip([9.0, 18.0, 25.0]) {
            assert!((product - wanted).abs() < 1e-5);
        }
    }
}
