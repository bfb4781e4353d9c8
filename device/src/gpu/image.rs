//! Images as textures of a driver's.

use crate::{DeviceError, Format, Image, ImageUse, image::Texels};

use super::Gpu;

fn texture_format(format: Format) -> wgpu::TextureFormat {
    match format {
        Format::Rgba8Unorm => wgpu::TextureFormat::Rgba8Unorm,
        Format::Rgba32Float => wgpu::TextureFormat::Rgba32Float,
        Format::Rgba32Uint => wgpu::TextureFormat::Rgba32Uint,
    }
}

impl Gpu {
    pub(crate) fn image(
        &self,
        label: &str,
        usage: ImageUse,
        size: [u32; 3],
        format: Format,
    ) -> Result<Image, DeviceError> {
        let [width, height, layers] = size;
        let bound = wgpu::TextureUsages::TEXTURE_BINDING;
        let (usages, dimension) = match usage {
            ImageUse::Read => (
                bound | wgpu::TextureUsages::COPY_DST,
                wgpu::TextureViewDimension::D2,
            ),
            ImageUse::ReadLayers => (
                bound | wgpu::TextureUsages::COPY_DST,
                wgpu::TextureViewDimension::D2Array,
            ),
            ImageUse::Shown => (
                bound | wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC,
                wgpu::TextureViewDimension::D2,
            ),
        };
        let srgb = [wgpu::TextureFormat::Rgba8UnormSrgb];
        let has_srgb = usage == ImageUse::ReadLayers && format == Format::Rgba8Unorm;
        let scope = self
            .device()
            .push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let texture = self.device().create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: texture_format(format),
            usage: usages,
            view_formats: if has_srgb { &srgb } else { &[] },
        });
        if pollster::block_on(scope.pop()).is_some() {
            return Err(DeviceError::OutOfMemory);
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(dimension),
            ..Default::default()
        });
        Ok(Image {
            size,
            format,
            texels: Texels::Gpu { texture, view },
        })
    }

    pub(crate) fn write_image(
        &self,
        image: &Image,
        corner: [u32; 3],
        size: [u32; 2],
        texels: &[u8],
    ) {
        let Some(texture) = image.texture() else {
            return;
        };
        let [x, y, z] = corner;
        let [width, height] = size;
        self.queue().write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x, y, z },
                aspect: wgpu::TextureAspect::All,
            },
            texels,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * image.format.texel_bytes()),
                rows_per_image: Some(height),
            },
            wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
        );
    }

    pub(crate) fn read_image(&self, image: &Image) -> Result<Vec<u8>, DeviceError> {
        let Some(texture) = image.texture() else {
            return Ok(Vec::new());
        };
        let [width, height, _] = image.size;
        let row = width * image.format.texel_bytes();
        // Rows of a copy begin at multiples of this.
        let stride = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(stride) * u64::from(height);
        let buffer = self.plain_buffer("an image", wgpu::BufferUsages::empty(), bytes);
        let mut encoder = self.encoder("an image");
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(stride),
                    rows_per_image: None,
                },
            },
            texture.size(),
        );
        self.queue().submit([encoder.finish()]);
        let padded = self.read(&buffer, 0, bytes)?;
        let rows = padded.chunks(stride as usize);
        Ok(rows.flat_map(|r| &r[..row as usize]).copied().collect())
    }
}
