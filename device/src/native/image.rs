//! Pictures that kernels read texel by texel, and write.

use std::sync::LazyLock;

pub use kernel_ir::Format;
use kernel_ir::{TILE, texel_place};

use super::buffer::{Buffer, OutOfMemory};

/// A two-dimensional image, or several layers of the same size. Clones share the texels.
#[derive(Debug, Clone)]
pub struct Image {
    format: Format,
    width: u32,
    height: u32,
    layers: u32,
    texels: Buffer,
}

impl Image {
    /// An image of zeros. Sizes of zero count as one.
    ///
    /// # Errors
    /// If there is no memory for it.
    pub fn new(format: Format, width: u32, height: u32, layers: u32) -> Result<Self, OutOfMemory> {
        let [width, height, layers] = [width, height, layers].map(|size| size.max(1));
        let whole_tiles = |size: u32| u64::from(size).next_multiple_of(u64::from(TILE));
        let bytes = [whole_tiles(width), whole_tiles(height), u64::from(layers)]
            .iter()
            .try_fold(u64::from(format.texel_bytes()), |bytes, &size| {
                bytes.checked_mul(size)
            })
            .ok_or(OutOfMemory { bytes: u64::MAX })?;
        // A kernel counts texels with 32 bits.
        if bytes / u64::from(format.texel_bytes()) > u64::from(u32::MAX) {
            return Err(OutOfMemory { bytes });
        }
        Ok(Self {
            format,
            width,
            height,
            layers,
            texels: Buffer::new(bytes)?,
        })
    }

    /// The same texels, read as another format of the same size.
    ///
    /// # Panics
    /// If a texel of that format has another size.
    pub fn viewed_as(&self, format: Format) -> Self {
        assert_eq!(self.format.texel_bytes(), format.texel_bytes());
        Self {
            format,
            ..self.clone()
        }
    }

    /// How its texels are stored.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Width, height, layers, in texels.
    pub fn size(&self) -> [u32; 3] {
        [self.width, self.height, self.layers]
    }

    /// The texels, as [`texel_place`] says, layer by layer.
    pub fn texels(&self) -> &Buffer {
        &self.texels
    }

    /// The byte of a texel in [`Image::texels`].
    pub fn offset(&self, x: u32, y: u32, layer: u32) -> u64 {
        let place = texel_place([self.width, self.height], [x, y, layer]);
        place * u64::from(self.format.texel_bytes())
    }

    /// Writes texels of a row, from the one at column `x` on.
    pub fn write_row(&self, [x, y, layer]: [u32; 3], texels: &[u8]) {
        let bytes = self.format.texel_bytes();
        let (mut x, mut rest) = (x, texels);
        while !rest.is_empty() {
            // As far as the tile goes.
            let columns = TILE - x % TILE;
            let (part, others) = rest.split_at(rest.len().min((columns * bytes) as usize));
            self.texels.write(self.offset(x, y, layer), part);
            (x, rest) = (x + columns, others);
        }
    }

    /// All texels of the first layer, row by row.
    pub fn read_rows(&self) -> Vec<u8> {
        let bytes = self.format.texel_bytes();
        let size = [self.width, self.height];
        let last = texel_place(size, [self.width - 1, self.height - 1, 0]);
        let words = (last + 1) * u64::from(bytes / 4);
        let tiles = self.texels.read::<[u8; 4]>(0, words as usize);
        let tiles = tiles.into_flattened();
        let mut rows = Vec::with_capacity(tiles.len());
        for y in 0..self.height {
            for x in (0..self.width).step_by(TILE as usize) {
                let columns = TILE.min(self.width - x);
                let start = self.offset(x, y, 0) as usize;
                rows.extend_from_slice(&tiles[start..start + (columns * bytes) as usize]);
            }
        }
        rows
    }
}

/// Light of each byte that is encoded as sRGB.
pub(super) static SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let encoded = byte as f32 / 255.0;
        match encoded <= 0.04045 {
            true => encoded / 12.92,
            false => libm::powf((encoded + 0.055) / 1.055, 2.4),
        }
    })
});

/// The byte of a fraction between 0 and 1; what isn't a number is 0.
pub(super) fn unorm8(value: f32) -> u32 {
    // The nearest, ties to even, as processors round.
    libm::rintf(value.clamp(0.0, 1.0) * 255.0) as u32
}

/// The byte that encodes light as sRGB.
pub(super) fn srgb8(light: f32) -> u32 {
    let light = light.clamp(0.0, 1.0);
    unorm8(match light <= 0.003_130_8 {
        true => light * 12.92,
        false => 1.055 * libm::powf(light, 1.0 / 2.4) - 0.055,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_srgb() {
        for byte in 0..256u32 {
            assert_eq!(srgb8(SRGB[byte as usize]), byte);
        }
        assert_eq!(unorm8(f32::NAN), 0);
        assert_eq!(unorm8(7.0), 255);
    }

    #[test]
    fn rows_are_read_as_they_were_written() {
        let image = Image::new(Format::Rgba8Unorm, 11, 6, 2).expect("memory");
        let row = |y: u32, columns: u32| -> Vec<u8> {
            (0..4 * columns).map(|byte| (byte + 50 * y) as u8).collect()
        };
        for y in 0..6 {
            image.write_row([0, y, 0], &row(y, 11));
            image.write_row([3, y, 1], &row(9, 8));
        }
        let rows: Vec<u8> = (0..6).flat_map(|y| row(y, 11)).collect();
        assert_eq!(image.read_rows(), rows);
        let mut texel = [0; 4];
        texel.copy_from_slice(&row(9, 8)[20..24]);
        assert_eq!(
            image.texels().read::<[u8; 4]>(image.offset(8, 5, 1), 1),
            [texel]
        );
    }

    #[test]
    fn images_that_cannot_be_are_errors() {
        assert!(Image::new(Format::Rgba8Unorm, u32::MAX, u32::MAX, 2).is_err());
        let image = Image::new(Format::Rgba8Unorm, 3, 2, 2).expect("memory");
        // A tile for each layer.
        assert_eq!(image.offset(1, 1, 1), 4 * (16 + 4 + 1));
        assert_eq!(image.texels().size(), 4 * 32);
    }
}
