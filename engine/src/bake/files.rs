//! Pictures of numbers as files hold them.

use std::io::{self, Seek, Write};

use exr::prelude::{Image, SpecificChannels, WritableImage};

use super::images::{linear8, srgb8};

/// Numbers in eight bits: `is_color` encodes RGB by sRGB.
pub fn shown(rgba: &[[f32; 4]], is_color: bool) -> Vec<u8> {
    let texel = |&[r, g, b, a]: &[f32; 4]| {
        let [r, g, b] = match is_color {
            true => [r, g, b].map(srgb8),
            false => [r, g, b].map(linear8),
        };
        [r, g, b, linear8(a)]
    };
    rgba.iter().flat_map(texel).collect()
}

/// Writes a square picture of linear numbers as OpenEXR in 32-bit floats.
///
/// # Errors
/// What the system says.
pub fn write_exr(file: impl Write + Seek, size: u32, rgba: &[[f32; 4]]) -> io::Result<()> {
    let side = size as usize;
    let texel = |at: exr::math::Vec2<usize>| {
        let [r, g, b, a] = rgba[at.y() * side + at.x()];
        (r, g, b, a)
    };
    let image = Image::from_channels((side, side), SpecificChannels::rgba(texel));
    let written = image.write().to_buffered(io::BufWriter::new(file));
    written.map_err(|error| io::Error::other(error.to_string()))
}
