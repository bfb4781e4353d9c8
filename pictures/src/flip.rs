//! FLIP: the difference that people see between two pictures that alternate on a screen, after Andersson, Nilsson, Akenine-Möller,
//! Oskarsson, Åström and Fairchild, "FLIP: A Difference Evaluator for Alternating Images", HPG 2020.
//!
//! The pictures are blurred as the eye blurs them from its distance, and their colours are compared; where edges and points of one
//! are not those of the other, the difference counts more. The result of each pixel is from 0 to 1.
//!
//! Their authors' program (`flip-evaluator` 1.7) gives the same numbers within 1e-3 of the mean; tests hold us to that.

use rayon::prelude::*;

/// How large pixels appear, per degree: a screen 0.7 m wide with 3840 pixels, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = 3840.0 * std::f32::consts::PI / 180.0;

/// Exponent of the colour difference.
const COLOR_EXPONENT: f32 = 0.7;
/// This share of the largest colour difference becomes [`COLOR_TURN`]; below and above it is linear.
const COLOR_SHARE: f32 = 0.4;
const COLOR_TURN: f32 = 0.95;
/// Width of the detectors of features, degrees.
const FEATURE_WIDTH: f32 = 0.082;
/// Exponent of the difference of features.
const FEATURE_EXPONENT: f32 = 0.5;

/// Contrast sensitivity as sums of Gaussians, weight and width (the paper's a and b): of luminance, red against green, blue against
/// yellow.
const SENSITIVITY: [[(f32, f32); 2]; 3] = [
    [(1.0, 0.0047), (0.0, 1e-5)],
    [(1.0, 0.0053), (0.0, 1e-5)],
    [(34.1, 0.04), (13.5, 0.025)],
];

/// White, as CIE XYZ (D65).
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];
/// Linear Rec.709 to XYZ, row by row.
const TO_XYZ: [[f32; 3]; 3] = [
    [0.412_386_57, 0.357_591_5, 0.180_450_48],
    [0.212_636_83, 0.715_183, 0.072_180_19],
    [0.019_330_62, 0.119_197_16, 0.950_372_6],
];
/// And back.
const FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_399, -0.498_615_86],
    [-0.969_224_3, 1.875_93, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];

/// A number of each pixel, row by row.
type Plane = Vec<f32>;

/// The difference of each pixel, row by row. Both pictures are linear Rec.709, 0 to 1, and as large as is said. Which of them is the
/// reference makes no difference.
///
/// # Panics
/// One of them has another number of pixels.
pub fn map(size: [usize; 2], reference: &[[f32; 3]], picture: &[[f32; 3]]) -> Vec<f32> {
    let pixels = size[0] * size[1];
    assert!(
        reference.len() == pixels && picture.len() == pixels,
        "both have width times height pixels"
    );
    let [there, here] = [reference, picture].map(Seen::of);
    let [colors_there, colors_here] = [&there, &here].map(|seen| seen.colors(size));
    let [features_there, features_here] = [&there, &here].map(|seen| seen.features(size));
    let most = largest_color_difference();
    (0..pixels)
        .into_par_iter()
        .map(|pixel| {
            let color = hyab(colors_there[pixel], colors_here[pixel]).powf(COLOR_EXPONENT);
            let ([edge, point], [other_edge, other_point]) =
                (features_there[pixel], features_here[pixel]);
            let feature = (edge - other_edge).abs().max((point - other_point).abs());
            let feature = (feature * std::f32::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT);
            stretched(color, most).powf(1.0 - feature)
        })
        .collect()
}

/// Colour differences from 0 to 1: small ones take most of the room.
fn stretched(color: f32, most: f32) -> f32 {
    let turn = COLOR_SHARE * most;
    match color < turn {
        true => color * COLOR_TURN / turn,
        false => COLOR_TURN + (color - turn) / (most - turn) * (1.0 - COLOR_TURN),
    }
}

/// That of pure green and pure blue.
fn largest_color_difference() -> f32 {
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(perceived);
    hyab(green, blue).powf(COLOR_EXPONENT)
}

/// A picture in the opponent space YCxCz, which is linear: luminance, red against green, blue against yellow.
struct Seen([Plane; 3]);

impl Seen {
    fn of(rgb: &[[f32; 3]]) -> Self {
        let opponents: Vec<[f32; 3]> = rgb.par_iter().map(|&rgb| opponents(rgb)).collect();
        Self(std::array::from_fn(|channel| {
            opponents.par_iter().map(|pixel| pixel[channel]).collect()
        }))
    }

    /// The colours that the eye makes of it: blurred, in CIELAB.
    fn colors(&self, size: [usize; 2]) -> Vec<[f32; 3]> {
        let blurred: [Plane; 3] =
            std::array::from_fn(|channel| sensed(&self.0[channel], size, SENSITIVITY[channel]));
        let [y, cx, cz] = &blurred;
        let pixels = (y.par_iter().zip(cx)).zip(cz);
        let shown = |value: f32| value.clamp(0.0, 1.0);
        pixels
            .map(|((&y, &cx), &cz)| perceived(rgb([y, cx, cz]).map(shown)))
            .collect()
    }

    /// How much of an edge and of a point each pixel is.
    fn features(&self, size: [usize; 2]) -> Vec<[f32; 2]> {
        let grey: Plane = self.0[0].par_iter().map(|y| (y + 16.0) / 116.0).collect();
        let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
        let radius = (3.0 * deviation).ceil() as i32;
        let gauss = |x: f32| (-x * x / (2.0 * deviation * deviation)).exp();
        let kernel = |of: &dyn Fn(f32) -> f32| -> Vec<f32> {
            (-radius..=radius).map(|x| of(x as f32)).collect()
        };
        let along = whole(kernel(&gauss));
        let edge = balanced(kernel(&|x| -x * gauss(x)));
        let point = balanced(kernel(&|x| {
            (x * x / (deviation * deviation) - 1.0) * gauss(x)
        }));
        let size_of = |across: &[f32]| -> Plane {
            let x = convolved(&grey, size, across, &along);
            let y = convolved(&grey, size, &along, across);
            let pixels = x.par_iter().zip(&y);
            pixels.map(|(x, y)| x.hypot(*y)).collect()
        };
        let (edges, points) = (size_of(&edge), size_of(&point));
        let pixels = edges.into_par_iter().zip(points);
        pixels.map(|(edge, point)| [edge, point]).collect()
    }
}

/// A channel as the eye senses it. The sum of two Gaussians falls apart into rows and columns, each Gaussian by itself.
fn sensed(plane: &[f32], size: [usize; 2], gaussians: [(f32, f32); 2]) -> Plane {
    use std::f32::consts::PI;
    // All channels are blurred within that of the widest one.
    let widest = SENSITIVITY.as_flattened().iter().map(|&(_, b)| b);
    let widest = widest.fold(0.0, f32::max);
    let deviation = (widest / (2.0 * PI * PI)).sqrt();
    let radius = (3.0 * deviation * PIXELS_PER_DEGREE).ceil() as i32;
    let parts = gaussians.map(|(a, b)| {
        let at = |x: i32| x as f32 / PIXELS_PER_DEGREE;
        let value = |x: i32| (-PI * PI * at(x) * at(x) / b).exp();
        let kernel: Vec<f32> = (-radius..=radius).map(value).collect();
        let sum: f32 = kernel.iter().sum();
        (a * (PI / b).sqrt() * sum * sum, whole(kernel))
    });
    let total: f32 = parts.iter().map(|(weight, _)| weight).sum();
    let mut sensed = vec![0.0; plane.len()];
    for (weight, kernel) in parts.iter().filter(|(weight, _)| *weight > 0.0) {
        let blurred = convolved(plane, size, kernel, kernel);
        let sums = sensed.par_iter_mut().zip(&blurred);
        sums.for_each(|(sum, value)| *sum += weight / total * value);
    }
    sensed
}

/// A kernel whose sum is 1.
fn whole(mut kernel: Vec<f32>) -> Vec<f32> {
    let sum: f32 = kernel.iter().sum();
    kernel.iter_mut().for_each(|value| *value /= sum);
    kernel
}

/// A kernel whose numbers above 0 have the sum 1, and those below it -1.
fn balanced(mut kernel: Vec<f32>) -> Vec<f32> {
    let above: f32 = kernel.iter().filter(|&&value| value > 0.0).sum();
    let below: f32 = kernel.iter().filter(|&&value| value < 0.0).sum();
    for value in &mut kernel {
        *value /= if *value > 0.0 { above } else { -below };
    }
    kernel
}

/// A plane convolved by one kernel in rows and by another one in columns; beyond the picture its border goes on.
fn convolved(plane: &[f32], [width, height]: [usize; 2], row: &[f32], column: &[f32]) -> Plane {
    let tap = |at: usize, tap: usize, kernel: &[f32], end: usize| {
        (at + tap).saturating_sub(kernel.len() / 2).min(end - 1)
    };
    let mut rows = vec![0.0; plane.len()];
    let lines = rows.par_chunks_mut(width).zip(plane.par_chunks(width));
    lines.for_each(|(line, source)| {
        for (x, sum) in line.iter_mut().enumerate() {
            let taps = row.iter().enumerate();
            *sum = taps
                .map(|(i, weight)| weight * source[tap(x, i, row, width)])
                .sum();
        }
    });
    let mut columns = vec![0.0; plane.len()];
    let lines = columns.par_chunks_mut(width).enumerate();
    lines.for_each(|(y, line)| {
        for (i, weight) in column.iter().enumerate() {
            let source = &rows[tap(y, i, column, height) * width..][..width];
            let sums = line.iter_mut().zip(source);
            sums.for_each(|(sum, value)| *sum += weight * value);
        }
    });
    columns
}

fn product(matrix: &[[f32; 3]; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * x + row[1] * y + row[2] * z)
}

/// Linear Rec.709 to CIE XYZ, where white is 1, 1, 1.
fn xyz(rgb: [f32; 3]) -> [f32; 3] {
    let xyz = product(&TO_XYZ, rgb);
    std::array::from_fn(|i| xyz[i] / WHITE[i])
}

/// Linear Rec.709 to YCxCz.
fn opponents(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// And back.
fn rgb([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    let xyz = [y + cx / 500.0, y, y - cz / 200.0];
    product(&FROM_XYZ, std::array::from_fn(|i| xyz[i] * WHITE[i]))
}

/// Linear Rec.709 to CIELAB, less colourful where it is dark (the Hunt effect).
fn perceived(rgb: [f32; 3]) -> [f32; 3] {
    const TURN: f32 = 6.0 / 29.0;
    let [x, y, z] = xyz(rgb).map(|value| match value > TURN * TURN * TURN {
        true => value.cbrt(),
        false => value / (3.0 * TURN * TURN) + 4.0 / 29.0,
    });
    let lightness = 116.0 * y - 16.0;
    let [a, b] = [500.0 * (x - y), 200.0 * (y - z)];
    [lightness, 0.01 * lightness * a, 0.01 * lightness * b]
}

/// The distance of large colour differences: that of lightness, and that of hue and chroma.
fn hyab(one: [f32; 3], other: [f32; 3]) -> f32 {
    (one[0] - other[0]).abs() + (one[1] - other[1]).hypot(one[2] - other[2])
}

#[cfg(test)]
mod tests;
