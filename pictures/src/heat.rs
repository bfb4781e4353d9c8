//! Maps of differences as pictures: black where there is none, over violet and orange to nearly white. The colours are matplotlib's
//! "magma" (van der Walt and Smith, CC0), in which equal steps look equally large.

/// The colours at every sixteenth of the way; 8-bit sRGB.
const COLORS: [[u8; 3]; 17] = [
    [0, 0, 4],
    [10, 8, 34],
    [29, 17, 70],
    [54, 16, 106],
    [80, 18, 124],
    [105, 28, 129],
    [130, 38, 129],
    [156, 46, 127],
    [182, 55, 121],
    [207, 65, 112],
    [230, 81, 99],
    [245, 105, 92],
    [251, 135, 97],
    [254, 165, 113],
    [254, 195, 135],
    [253, 224, 162],
    [252, 253, 191],
];

/// A number from 0 to 1 as a colour; what lies beyond is as its end, and what is no number as 1.
pub fn color(value: f32) -> [u8; 3] {
    let value = match value.is_nan() {
        true => 1.0,
        false => value.clamp(0.0, 1.0),
    };
    let last = COLORS.len() - 1;
    let at = value * last as f32;
    let low = (at as usize).min(last - 1);
    let share = at - low as f32;
    std::array::from_fn(|c| {
        let [a, b] = [COLORS[low][c], COLORS[low + 1][c]].map(f32::from);
        (a + (b - a) * share).round() as u8
    })
}

/// A map as 8-bit RGBA.
pub fn rgba(map: &[f32]) -> Vec<u8> {
    let pixels = map.iter().map(|&value| color(value));
    pixels.flat_map(|[r, g, b]| [r, g, b, 255]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_brighter_colours() {
        assert_eq!(color(0.0), [0, 0, 4]);
        assert_eq!(color(1.0), [252, 253, 191]);
        assert_eq!((color(-1.0), color(2.0)), (color(0.0), color(1.0)));
        assert_eq!(color(f32::NAN), color(1.0));
        // Of the 256 colours the one in the middle is 0.716387, 0.214982, 0.475290.
        for (channel, wanted) in color(128.0 / 255.0).into_iter().zip([183, 55, 121]) {
            assert!(channel.abs_diff(wanted) <= 2, "{channel} {wanted}");
        }
        let brightness = |value: f32| color(value).map(u32::from).iter().sum::<u32>();
        let steps: Vec<_> = (0..=20).map(|i| brightness(i as f32 / 20.0)).collect();
        assert!(steps.is_sorted(), "{steps:?}");
        assert_eq!(rgba(&[0.0, 1.0]), [0, 0, 4, 255, 252, 253, 191, 255]);
    }
}
