//! Against the numbers of `flip-evaluator` 1.7 (PyPI), the authors' program: `evaluate(a, b, "LDR", True, False)` of pictures that are
//! made by the same formulas.

use super::*;

const SIZE: [usize; 2] = [61, 43];

/// 8-bit sRGB of a column, row and channel; more than 255 begins anew.
type Formula = fn(u64, u64, u64) -> u64;

const RAMP: Formula = |x, y, c| x * 4 + y * (c + 1) / 2;
const WAVES: Formula = |x, y, c| x * x / 7 + y * 5 * c + c * 60;
const NOISE: Formula =
    |x, y, c| (x * 7919 + y * 104_729 + c * 1_299_709) * (x + 3 * y + c + 1) / 64;
const BLOCKS: Formula = |x, y, c| blocks(x, y, c);
const SHIFTED: Formula = |x, y, c| blocks(x + 2, y, c);

fn blocks(x: u64, y: u64, c: u64) -> u64 {
    match (x / 9 + y / 7).is_multiple_of(2) {
        true => 230,
        false => 20 + 40 * c,
    }
}

fn picture(formula: Formula) -> Vec<[f32; 3]> {
    let linear = |code: u64| {
        let encoded = (code % 256) as f32 / 255.0;
        match encoded <= 0.04045 {
            true => encoded / 12.92,
            false => ((encoded + 0.055) / 1.055).powf(2.4),
        }
    };
    let [width, height] = SIZE.map(|side| side as u64);
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    places
        .map(|(x, y)| std::array::from_fn(|c| linear(formula(x, y, c as u64))))
        .collect()
}

#[test]
fn numbers_are_those_of_the_authors_program() {
    // Means, and pixels in the upper left corner and in the middle.
    for (name, a, b, mean, corner, middle) in [
        ("ramp, waves", RAMP, WAVES, 0.872_283, 0.776_537, 0.936_827),
        ("ramp, noise", RAMP, NOISE, 0.703_63, 0.965_542, 0.227_166),
        (
            "waves, noise",
            WAVES,
            NOISE,
            0.814_835,
            0.770_093,
            0.954_875,
        ),
        (
            "blocks, shifted",
            BLOCKS,
            SHIFTED,
            0.348_875,
            0.015_441,
            0.0,
        ),
        (
            "noise, blocks",
            NOISE,
            BLOCKS,
            0.759_164,
            0.781_766,
            0.678_463,
        ),
        (
            "black, white",
            (|_, _, _| 0) as Formula,
            (|_, _, _| 255) as Formula,
            0.967_379,
            0.967_388,
            0.967_388,
        ),
        (
            "green, blue",
            (|_, _, c| if c == 1 { 255 } else { 0 }) as Formula,
            (|_, _, c| if c == 2 { 255 } else { 0 }) as Formula,
            1.0,
            1.0,
            1.0,
        ),
    ] {
        let (a, b) = (picture(a), picture(b));
        let found = map(SIZE, &a, &b);
        let of_all = found.iter().sum::<f32>() / found.len() as f32;
        let middle_at = 21 * SIZE[0] + 30;
        for (what, found, wanted) in [
            ("mean", of_all, mean),
            ("corner", found[0], corner),
            ("middle", found[middle_at], middle),
        ] {
            // What single precision leaves of a pixel, whose differences are taken to the power of 0.7 and of a half.
            let tolerance = if what == "mean" { 1e-4 } else { 1e-3 };
            let difference = f32::abs(found - wanted);
            assert!(difference < tolerance, "{name}, {what}: {found}, {wanted}");
        }
        let backwards = map(SIZE, &b, &a);
        let pairs = found.iter().zip(&backwards);
        let most = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(most < 1e-5, "{name}: {most}");
    }
}

#[test]
fn the_same_picture_has_no_difference_and_small_ones_are_compared_too() {
    let noise = picture(NOISE);
    assert!(map(SIZE, &noise, &noise).iter().all(|&value| value == 0.0));
    // Smaller than the kernels.
    for size in [[1, 1], [1, 5], [4, 1]] {
        let count = size[0] * size[1];
        let found = map(size, &noise[..count], &noise[100..100 + count]);
        assert!(found.iter().all(|value| (0.0..=1.0).contains(value)));
    }
}
