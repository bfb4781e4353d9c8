//! Images as compiled code finds them in memory.

/// How a texel is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Format {
    /// Four floats.
    Rgba32Float,
    /// Four unsigned integers.
    Rgba32Uint,
    /// A byte for each of red, green, blue, alpha, the first lowest: 255 is 1.
    Rgba8Unorm,
    /// The same, colours encoded as sRGB.
    Rgba8UnormSrgb,
}

impl Format {
    /// Bytes of a texel.
    pub fn texel_bytes(self) -> u32 {
        match self {
            Self::Rgba32Float | Self::Rgba32Uint => 16,
            Self::Rgba8Unorm | Self::Rgba8UnormSrgb => 4,
        }
    }

    /// Whether kernels see floats; else unsigned integers.
    pub fn is_float(self) -> bool {
        self != Self::Rgba32Uint
    }
}

/// What compiled code knows of an image.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct ImageHeader {
    /// Texels of a row.
    pub width: u32,
    /// Rows of a layer.
    pub height: u32,
    /// Layers.
    pub layers: u32,
    /// How a texel is stored.
    pub format: Format,
    /// The first of them.
    pub texels: *mut u32,
}
