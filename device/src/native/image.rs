//! Pictures that kernels read texel by texel, and write.

use std::sync::LazyLock;

pub use kernel_ir::Format;

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
        let bytes = [width, height, layers]
            .iter()
            .try_fold(u64::from(format.texel_bytes()), |bytes, &size| {
                bytes.checked_mul(u64::from(size))
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

    /// The texels: row by row, layer by layer, nothing in between.
    pub fn texels(&self) -> &Buffer {
        &self.texels
    }

    /// The byte of a texel in [`Image::texels`].
    pub fn offset(&self, x: u32, y: u32, layer: u32) -> u64 {
        let row = u64::from(layer) * u64::from(self.height) + u64::from(y);
        (row * u64::from(self.width) + u64::from(x)) * u64::from(self.format.texel_bytes())
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
    fn images_that_cannot_be_are_errors() {
        assert!(Image::new(Format::Rgba8Unorm, u32::MAX, u32::MAX, 2).is_err());
        let image = Image::new(Format::Rgba8Unorm, 3, 2, 2).expect("memory");
        assert_eq!(image.offset(1, 1, 1), 4 * (1 + 3 * (1 + 2)));
        assert_eq!(image.texels().size(), 48);
    }
}
