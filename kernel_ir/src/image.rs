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

/// Columns and rows of a tile. Texels lie tile by tile, in each row by row: of the four that an interpolation reads, most lie in one
/// line of a cache then, and not in two pages.
pub const TILE: u32 = 4;

/// The place of a texel among all of an image's: its width and height; column, row and layer.
pub fn texel_place([width, height]: [u32; 2], [x, y, layer]: [u32; 3]) -> u64 {
    let [across, down] = [width, height].map(|size| u64::from(size.div_ceil(TILE)));
    let tile_row = u64::from(layer) * down + u64::from(y / TILE);
    let tile = tile_row * across + u64::from(x / TILE);
    tile * u64::from(TILE * TILE) + u64::from(y % TILE * TILE + x % TILE)
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
    /// The first of them; the others as [`texel_place`] says.
    pub texels: *mut u32,
}
