//! Images that kernels read texel by texel, and one that a window shows.

use crate::{Device, DeviceError, device::Kind, native};

/// How texels are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Four bytes, 0 to 1.
    Rgba8Unorm,
    /// Four floats.
    Rgba32Float,
    /// Four integers.
    Rgba32Uint,
}

impl Format {
    /// Bytes of a texel.
    pub fn texel_bytes(self) -> u32 {
        match self {
            Self::Rgba8Unorm => 4,
            Self::Rgba32Float | Self::Rgba32Uint => 16,
        }
    }
}

/// What an image is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageUse {
    /// Read by kernels, as `texture_2d`.
    Read,
    /// Its layers are read by kernels, as `texture_2d_array`; 8-bit texels as they are, or decoded from sRGB.
    ReadLayers,
    /// Written by kernels and shown in a window.
    Shown,
}

/// An image on a device. Clones share it.
#[derive(Debug, Clone)]
pub struct Image {
    pub(crate) size: [u32; 3],
    pub(crate) format: Format,
    pub(crate) texels: Texels,
}

#[derive(Debug, Clone)]
pub(crate) enum Texels {
    Gpu {
        texture: wgpu::Texture,
        view: wgpu::TextureView,
    },
    Native(native::image::Image),
}

impl Image {
    /// Columns, rows and layers.
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// How texels are stored.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The same texels, which kernels see decoded from sRGB.
    ///
    /// # Panics
    /// The image isn't one of 8-bit layers.
    pub fn as_srgb(&self) -> Self {
        assert_eq!(self.format, Format::Rgba8Unorm, "sRGB has 8 bits");
        let texels = match &self.texels {
            Texels::Gpu { texture, .. } => Texels::Gpu {
                texture: texture.clone(),
                view: texture.create_view(&wgpu::TextureViewDescriptor {
                    format: Some(wgpu::TextureFormat::Rgba8UnormSrgb),
                    dimension: Some(wgpu::TextureViewDimension::D2Array),
                    ..Default::default()
                }),
            },
            Texels::Native(image) => {
                Texels::Native(image.viewed_as(native::image::Format::Rgba8UnormSrgb))
            }
        };
        Self { texels, ..*self }
    }

    /// Writes a rectangle of texels, row by row: column, row and layer of its corner, columns and rows.
    pub fn write(&self, device: &Device, corner: [u32; 3], size: [u32; 2], texels: &[u8]) {
        let Texels::Native(image) = &self.texels else {
            if let Kind::Gpu(gpu) = &device.kind {
                gpu.write_image(self, corner, size, texels);
            }
            return;
        };
        let [x, y, layer] = corner;
        let row = (size[0] * self.format.texel_bytes()) as usize;
        for (y, texels) in (y..).zip(texels.chunks_exact(row)) {
            image.write_row([x, y, layer], texels);
        }
    }

    /// All texels of the first layer, row by row. Waits for the device.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn read(&self, device: &Device) -> Result<Vec<u8>, DeviceError> {
        match (&self.texels, &device.kind) {
            (Texels::Native(image), _) => Ok(image.read_rows()),
            (Texels::Gpu { .. }, Kind::Gpu(gpu)) => gpu.read_image(self),
            (Texels::Gpu { .. }, Kind::Native(_)) => {
                unreachable!("an image is used with the device that made it")
            }
        }
    }

    /// The texture, for a window of the same device. None where the processor renders.
    pub fn texture(&self) -> Option<&wgpu::Texture> {
        match &self.texels {
            Texels::Gpu { texture, .. } => Some(texture),
            Texels::Native(_) => None,
        }
    }

    /// The texels, for the processor.
    pub(crate) fn native(&self) -> Option<&native::image::Image> {
        match &self.texels {
            Texels::Native(image) => Some(image),
            Texels::Gpu { .. } => None,
        }
    }
}
