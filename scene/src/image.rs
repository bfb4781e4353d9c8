//! Decoded pictures.

use std::sync::Arc;

/// A decoded picture, row 0 on top.
#[derive(Debug, Clone)]
pub struct Image {
    /// Where it came from, for messages.
    pub name: String,
    /// Texels along u.
    pub width: u32,
    /// Texels along v.
    pub height: u32,
    /// 8-bit RGBA, `width * height * 4` bytes, as stored in the file; scenes of several moments share them.
    pub rgba8: Arc<Vec<u8>>,
    /// RGB is sRGB-encoded (colour), not linear (data). An image used as both appears twice.
    pub srgb: bool,
}

impl Image {
    /// What the model calls it: the name or the path of its file, or its number where it has neither.
    pub fn short_name(&self) -> &str {
        let quoted = self
            .name
            .split_once('"')
            .and_then(|(_, rest)| rest.strip_suffix('"'));
        quoted.unwrap_or_else(|| self.name.trim_start_matches("image "))
    }
}

/// A linear floating-point picture, row 0 on top.
#[derive(Debug, Clone)]
pub struct FloatImage {
    /// Texels along u.
    pub width: u32,
    /// Texels along v.
    pub height: u32,
    /// Linear Rec.709 per texel, `width * height` of them; finite and not negative.
    pub rgb: Vec<[f32; 3]>,
}
