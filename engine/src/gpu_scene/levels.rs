//! Mip levels of an image: each half as wide and high as the one before, averaged in linear light.

use std::sync::LazyLock;

use rayon::prelude::*;

use crate::scene::Image;

/// Width and height of level `level` of an image: halved and rounded down each time, at least one texel.
pub(super) fn size_of_level((width, height): (u32, u32), level: u32) -> (u32, u32) {
    let side = |side: u32| side.checked_shr(level).unwrap_or(0).max(1);
    (side(width), side(height))
}

/// How many levels an image has below the full one: the last is a single texel.
pub(super) fn levels_below((width, height): (u32, u32)) -> u32 {
    width.max(height).max(1).ilog2()
}

/// The levels of an image below the full one, as 8-bit RGBA in the image's own encoding.
///
/// A texel is the mean of the area it covers, texels on its border by their share, so that all levels of an image have
/// the same mean, whatever its size. Alpha is averaged like the colours and doesn't weigh them: images may hold
/// anything. Levels are made from unrounded ones.
pub(super) fn pyramid(image: &Image) -> impl Iterator<Item = Vec<u8>> {
    let full = (image.width, image.height);
    let mut above: Option<Vec<[f32; 4]>> = None;
    (1..=levels_below(full)).map(move |level| {
        let from = size_of_level(full, level - 1);
        let to = size_of_level(full, level);
        let texels = match &above {
            None => {
                let (bytes, _) = image.rgba8.as_chunks::<4>();
                reduce(from, to, |i| decode(bytes[i], image.srgb))
            }
            Some(above) => reduce(from, to, |i| above[i]),
        };
        let encoded = texels.iter().flat_map(|texel| encode(*texel, image.srgb));
        let encoded = encoded.collect();
        above = Some(texels);
        encoded
    })
}

/// Averages a picture of one size over the texels of a smaller one.
fn reduce(
    from: (u32, u32),
    to: (u32, u32),
    texel: impl Fn(usize) -> [f32; 4] + Sync,
) -> Vec<[f32; 4]> {
    let columns: Vec<Vec<(usize, f32)>> = (0..to.0).map(|x| shares(from.0, to.0, x)).collect();
    let row = |y: u32| {
        let rows = shares(from.1, to.1, y);
        let columns = &columns;
        let texel = &texel;
        columns.iter().map(move |columns| {
            let mut sum = [0.0; 4];
            for &(y, height) in &rows {
                for &(x, width) in columns {
                    let value = texel(y * from.0 as usize + x);
                    for (sum, value) in sum.iter_mut().zip(value) {
                        *sum += height * width * value;
                    }
                }
            }
            sum
        })
    };
    (0..to.1).into_par_iter().flat_map_iter(row).collect()
}

/// The texels of a row of `from` that texel `i` of `to` covers, and how much of it each is.
fn shares(from: u32, to: u32, i: u32) -> Vec<(usize, f32)> {
    // Where `to` is 1 unit wide, a texel of `from` is `to` wide and one of `to` is `from` wide.
    let (from, to, i) = (u64::from(from), u64::from(to), u64::from(i));
    let (start, end) = (i * from, (i + 1) * from);
    (start / to..end.div_ceil(to))
        .map(|k| {
            let covered = end.min((k + 1) * to) - start.max(k * to);
            (k as usize, covered as f32 / from as f32)
        })
        .collect()
}

fn decode(texel: [u8; 4], srgb: bool) -> [f32; 4] {
    static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
        std::array::from_fn(|i| {
            let value = i as f32 / 255.0;
            match value <= 0.04045 {
                true => value / 12.92,
                false => ((value + 0.055) / 1.055).powf(2.4),
            }
        })
    });
    let [r, g, b, a] = texel;
    let number = |byte: u8| f32::from(byte) / 255.0;
    match srgb {
        true => {
            let light = |byte: u8| LINEAR[usize::from(byte)];
            [light(r), light(g), light(b), number(a)]
        }
        false => [r, g, b, a].map(number),
    }
}

fn encode([r, g, b, a]: [f32; 4], srgb: bool) -> [u8; 4] {
    let light = |value: f32| match (srgb, value <= 0.003_130_8) {
        (false, _) => value,
        (true, true) => 12.92 * value,
        (true, false) => 1.055 * value.powf(1.0 / 2.4) - 0.055,
    };
    [light(r), light(g), light(b), a].map(|value| (value * 255.0 + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_levels_of_any_size_keep_the_mean() {
        for (width, height) in [(1, 1), (1, 9), (7, 5), (16, 4), (33, 1), (100, 37)] {
            let value = |i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8;
            let rgba8: Vec<u8> = (0..width * height * 4).map(value).collect();
            let image = Image {
                name: String::new(),
                width,
                height,
                rgba8: rgba8.clone().into(),
                srgb: false,
            };
            let mean = |bytes: &[u8]| -> [f32; 4] {
                let (texels, _) = bytes.as_chunks::<4>();
                let sum = |c: usize| texels.iter().map(|t| f32::from(t[c])).sum::<f32>();
                std::array::from_fn(|c| sum(c) / texels.len() as f32)
            };
            let mut size = (width, height);
            for (level, bytes) in (1..).zip(pyramid(&image)) {
                size = size_of_level((width, height), level);
                assert_eq!(bytes.len() as u32, size.0 * size.1 * 4);
                for (was, is) in mean(&rgba8).into_iter().zip(mean(&bytes)) {
                    // Each texel is rounded to 8 bits.
                    assert!((was - is).abs() <= 0.5, "{width} x {height}, level {level}");
                }
            }
            assert_eq!(size, (1, 1));
        }
    }

    #[test]
    fn texels_on_a_border_count_by_their_share() {
        assert_eq!(shares(4, 2, 1), [(2, 0.5), (3, 0.5)]);
        assert_eq!(
            shares(3, 1, 0),
            [(0, 1.0 / 3.0), (1, 1.0 / 3.0), (2, 1.0 / 3.0)]
        );
        assert_eq!(shares(5, 2, 0), [(0, 0.4), (1, 0.4), (2, 0.2)]);
        assert_eq!(shares(5, 2, 1), [(2, 0.2), (3, 0.4), (4, 0.4)]);
    }

    #[test]
    fn colours_are_averaged_as_light() {
        let image = Image {
            name: String::new(),
            width: 2,
            height: 1,
            rgba8: vec![255, 255, 255, 255, 0, 0, 0, 0].into(),
            srgb: true,
        };
        // Half of the light is 188 in sRGB, and alpha is no light.
        let last = pyramid(&image).last();
        assert_eq!(last, Some(vec![188, 188, 188, 128]));
    }

    #[test]
    fn every_byte_survives_decoding_and_encoding() {
        for byte in 0..=255 {
            for srgb in [false, true] {
                assert_eq!(encode(decode([byte; 4], srgb), srgb), [byte; 4]);
            }
        }
    }
}
