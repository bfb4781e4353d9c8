//! Khronos PBR Neutral (Khronos PBR Neutral Tone Mapper, specification 1.0): colours up to 0.8 keep hue and saturation, brighter
//! ones are compressed and lose colour.

use glam::Vec3;

/// Where compression starts, with the offset taken off.
const START: f32 = 0.8 - OFFSET;
/// What a dielectric's reflection of 4 % adds to its base colour.
const OFFSET: f32 = 0.04;
/// How fast highlights lose their colour.
const DESATURATION: f32 = 0.15;

/// From scene-linear to display-linear, 0 to 1. Negative components, of which the specification says nothing, are 0.
pub(super) fn apply(linear: Vec3) -> Vec3 {
    let linear = linear.max(Vec3::ZERO);
    let least = linear.min_element();
    let offset = match least < 2.0 * OFFSET {
        true => least - least * least / (4.0 * OFFSET),
        false => OFFSET,
    };
    let color = linear - offset;
    let peak = color.max_element();
    if peak < START {
        return color;
    }
    let room = 1.0 - START;
    let compressed = 1.0 - room * room / (peak + room - START);
    let faded = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    (color * (compressed / peak)).lerp(Vec3::splat(compressed), faded)
}
