//! What is seen of a difference, and of a picture's noise while its truth isn't known.
//!
//! A picture is *final* where FLIP is small on average and nowhere large over an area that one notices ([`Seen::is_below`] of
//! [`FINAL`]).

use rayon::prelude::*;

use crate::flip;
use crate::read::srgb_to_linear;

/// Largest mean of FLIP of a picture that is final.
pub const FINAL: f64 = 0.03;
/// FLIP of a pixel that one notices, as a multiple of the largest mean.
pub const NOTICED: f64 = 5.0;
/// Largest connected area of such pixels, of all of the picture.
pub const AREA: f64 = 0.001;
/// Pixels to either side over which a picture is blurred to stand for the one without noise.
const BLUR: usize = 2;
/// Rows beyond a band that its own depend on: those of the blur and of the eye's.
const MARGIN: usize = 16;
/// Pixels of a band, if its rows aren't too few for that.
const BAND_PIXELS: usize = 1 << 18;
const LEAST_BAND: usize = 64;
/// Memory of a pixel of a band: colours and noise, both pictures as they are shown and as the eye senses them, planes that are convolved.
const BYTES: u64 = 200;

/// How much of a difference is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Mean of FLIP, 0 to 1.
    pub flip: f64,
    /// Largest connected area of pixels that one notices, of all of the picture.
    pub area: f64,
}

impl Seen {
    /// Of a map of FLIP ([`flip::map`]) of this many columns, which is to have at most this mean.
    pub fn of(map: &[f32], width: usize, most: f64) -> Self {
        let sum: f64 = map.iter().copied().map(f64::from).sum();
        Self {
            flip: sum / map.len().max(1) as f64,
            area: largest_area(map, width, (NOTICED * most) as f32),
        }
    }

    /// Whether the mean is below that, and no area is too large.
    pub fn is_below(&self, most: f64) -> bool {
        self.flip < most && self.area <= AREA
    }
}

/// FLIP of each pixel between a picture and the one without its noise, which isn't known: noise of the same size is put upon the
/// picture, blurred. `pixel` gives the linear Rec.709 of one, counted row by row, and a difference as large as its noise, which pixels
/// share as they share that, such as half of what two halves of its samples differ by. `show` gives the sRGB codes that a screen shows of a colour.
///
/// Edges of the picture are blurred on both sides of the comparison, so that they neither count as noise nor hide any; what is left in
/// the blurred picture of the noise itself counts for little.
///
/// The picture is looked at in bands, so that memory is bounded ([`noise_bytes`]).
pub fn noise(
    [width, height]: [usize; 2],
    pixel: impl Fn(usize) -> [[f32; 3]; 2] + Sync,
    show: impl Fn([f32; 3]) -> [f32; 3] + Sync,
) -> Vec<f32> {
    let shown = |rgb: [f32; 3]| {
        show(rgb).map(|code| match code.is_nan() {
            true => 0.0,
            false => srgb_to_linear(code.clamp(0.0, 1.0)),
        })
    };
    let band = band(width);
    let mut map = Vec::with_capacity(width * height);
    for top in (0..height).step_by(band) {
        let own = top..height.min(top + band);
        let rows = own.start.saturating_sub(MARGIN)..height.min(own.end + MARGIN);
        let pixels = rows.start * width..rows.end * width;
        let (picture, noise): (Vec<_>, Vec<_>) = pixels
            .into_par_iter()
            .map(|at| {
                let [radiance, noise] = pixel(at);
                (radiance, noise)
            })
            .unzip();
        let size = [width, rows.len()];
        let blurred = blurred(size, &picture);
        let noisy = blurred.par_iter().zip(&noise);
        let noisy: Vec<_> = noisy
            .map(|(rgb, noise)| shown(std::array::from_fn(|c| rgb[c] + noise[c])))
            .collect();
        let clean: Vec<_> = blurred.par_iter().map(|&rgb| shown(rgb)).collect();
        let of_band = flip::map(size, &clean, &noisy);
        let inside = (own.start - rows.start) * width..(own.end - rows.start) * width;
        map.extend_from_slice(&of_band[inside]);
    }
    map
}

/// Rows of a band of a picture this wide.
fn band(width: usize) -> usize {
    (BAND_PIXELS / width.max(1)).max(LEAST_BAND)
}

/// Memory that [`noise`] takes, at most.
pub fn noise_bytes([width, height]: [u64; 2]) -> u64 {
    let rows = height.min((band(width as usize) + 2 * MARGIN) as u64);
    width * (rows * BYTES + height * size_of::<f32>() as u64)
}

/// Means over squares; at the border over what there is of them.
fn blurred([width, height]: [usize; 2], picture: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mean = |at: usize, end: usize, of: &dyn Fn(usize) -> [f32; 3]| {
        let range = at.saturating_sub(BLUR)..end.min(at + BLUR + 1);
        let count = range.len() as f32;
        let sum = range.map(of).fold([0.0; 3], |sum: [f32; 3], value| {
            std::array::from_fn(|c| sum[c] + value[c])
        });
        sum.map(|sum| sum / count)
    };
    let along = |of: &(dyn Fn(usize, usize) -> [f32; 3] + Sync)| -> Vec<[f32; 3]> {
        let pixels = (0..width * height).into_par_iter();
        pixels.map(|at| of(at % width, at / width)).collect()
    };
    let rows = along(&|x, y| mean(x, width, &|x| picture[y * width + x]));
    along(&|x, y| mean(y, height, &|y| rows[y * width + x]))
}

/// The largest area of pixels above a value that hang together by their sides, of all pixels.
fn largest_area(map: &[f32], width: usize, above: f32) -> f64 {
    let mut is_open: Vec<bool> = map.iter().map(|&flip| flip > above).collect();
    let mut largest = 0;
    let mut stack = Vec::new();
    for first in 0..map.len() {
        if !std::mem::take(&mut is_open[first]) {
            continue;
        }
        stack.push(first);
        let mut area = 0;
        while let Some(at) = stack.pop() {
            area += 1;
            let column = at % width;
            let neighbours = [
                (column > 0).then(|| at - 1),
                (column + 1 < width).then(|| at + 1),
                at.checked_sub(width),
                (at + width < map.len()).then(|| at + width),
            ];
            for neighbour in neighbours.into_iter().flatten() {
                if std::mem::take(&mut is_open[neighbour]) {
                    stack.push(neighbour);
                }
            }
        }
        largest = largest.max(area);
    }
    largest as f64 / map.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::linear_to_srgb;

    #[test]
    fn areas_hang_together_by_sides() {
        let rows = ["##..#", "#..##", "..#..", "....#"];
        let map: Vec<f32> = rows
            .iter()
            .flat_map(|row| row.chars().map(|c| f32::from(c == '#')))
            .collect();
        assert_eq!(largest_area(&map, 5, 0.15), 3.0 / 20.0);
        assert_eq!(largest_area(&[0.0; 20], 5, 0.15), 0.0);
    }

    #[test]
    fn bands_show_what_the_whole_does() {
        let size = [4096, 150];
        assert!(band(size[0]) < size[1]);
        let value = |at: usize| ((at * 7919 + at / 4096 * 104_729) % 1009) as f32 / 1009.0;
        let pixel = |at: usize| [[value(at); 3], [0.1 * value(at + 77) - 0.05; 3]];
        let codes = |rgb: [f32; 3]| rgb.map(linear_to_srgb);
        let map = noise(size, pixel, codes);
        // The last rows as a picture of their own, but for those near its upper edge.
        let from = 80 * size[0];
        let part = noise([size[0], 70], |at| pixel(at + from), codes);
        let inside = MARGIN * size[0];
        let largest = (map[from + inside..].iter().zip(&part[inside..]))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max);
        assert!(largest < 1e-5, "{largest}");
    }

    #[test]
    fn the_noise_that_is_seen_is_that_of_the_picture() {
        // A shadow's edge, and noise of a known spread; FLIP against the truth is what the estimate is to be.
        let size = [128, 96];
        let truth = |at: usize| if at % 128 < 60 { 0.15_f32 } else { 0.5 };
        let uniform = |at: usize, seed: u64| {
            // SplitMix64 (Steele, Lea and Flood 2014).
            let state = (seed << 32 | at as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (mixed >> 40) as f32 / 16_777_216.0 - 0.5
        };
        for spread in [0.02, 0.1] {
            let half = |at: usize, seed| truth(at) + spread * uniform(at, seed);
            let mean = |at: usize| 0.5 * (half(at, 1) + half(at, 2));
            let difference = |at: usize| 0.5 * (half(at, 1) - half(at, 2));
            let codes = |rgb: [f32; 3]| rgb.map(linear_to_srgb);
            let map = noise(size, |at| [[mean(at); 3], [difference(at); 3]], codes);
            let pixels = 0..size[0] * size[1];
            let [there, here]: [Vec<_>; 2] = [
                pixels.clone().map(|at| [truth(at); 3]).collect(),
                pixels.map(|at| [mean(at); 3]).collect(),
            ];
            let known = Seen::of(&flip::map(size, &there, &here), size[0], FINAL).flip;
            let guessed = Seen::of(&map, size[0], FINAL).flip;
            assert!((guessed / known - 1.0).abs() < 0.1, "{guessed} for {known}");
        }
    }

    #[test]
    fn a_picture_is_final_by_its_mean_and_by_its_spots() {
        let mut map = vec![0.02; 10_000];
        assert!(Seen::of(&map, 100, FINAL).is_below(FINAL));
        assert!(!Seen::of(&map, 100, 0.01).is_below(0.01));
        map[..11].fill(0.2);
        let seen = Seen::of(&map, 100, FINAL);
        assert!(!seen.is_below(FINAL), "{seen:?}");
        assert_eq!(seen.area, 0.0011);
        map[5] = 0.02;
        assert!(Seen::of(&map, 100, FINAL).is_below(FINAL));
    }
}
