//! All image textures in the layers of one array texture, placed by shelves, and the table of where each lies.

use crate::{
    gpu::{Gpu, GpuError},
    procedural::TextureReads,
    scene::{Image, Scene},
};

use super::{levels, materials::sampler_bits};

/// Entries in a row of the table; `IMAGE_TABLE_WIDTH` in `images.wgsl`.
const TABLE_WIDTH: u32 = 1024;

/// The textures and the views that kernels bind.
#[derive(Debug)]
pub struct GpuImages {
    /// `image_table`.
    pub table: wgpu::TextureView,
    /// `image_layers`.
    pub layers: wgpu::TextureView,
    /// `image_layers_srgb`.
    pub layers_srgb: wgpu::TextureView,
    /// Row of the table where the images of texture arguments begin.
    pub user_base: u32,
    /// Bytes of all layers.
    pub bytes: u64,
}

/// Where an image lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    layer: u32,
    x: u32,
    y: u32,
}

impl GpuImages {
    /// Uploads the scene's images and the table, with one more row per image argument of a texture, and the mip levels
    /// that textures read.
    ///
    /// # Errors
    /// If the images need more layers than the device has, or the driver is out of memory.
    pub fn new(gpu: &Gpu, scene: &Scene, reads: &TextureReads<'_>) -> Result<Self, GpuError> {
        let limits = gpu.device().limits();
        let fitted: Vec<std::borrow::Cow<'_, Image>> = scene
            .images
            .iter()
            .map(|image| fit(image, limits.max_texture_dimension_2d.min(32768)))
            .collect();
        // The images, then the levels of each that has any.
        let mut sizes: Vec<(u32, u32)> = fitted.iter().map(|i| (i.width, i.height)).collect();
        let mut with_levels = Vec::new();
        for &image in reads.with_levels {
            let full = sizes[image as usize];
            with_levels.push((image as usize, sizes.len()));
            sizes.extend((1..=levels::levels_below(full)).map(|l| levels::size_of_level(full, l)));
        }
        let (side, layers, places) = place_all(
            &sizes,
            limits.max_texture_dimension_2d,
            limits.max_texture_array_layers,
        );
        if layers > limits.max_texture_array_layers {
            return Err(GpuError::TooLarge {
                what: "the image textures' array".to_owned(),
                needed: u64::from(layers) * u64::from(side) * u64::from(side) * 4,
                limit: u64::from(limits.max_texture_array_layers)
                    * u64::from(side)
                    * u64::from(side)
                    * 4,
                remedy: "use fewer or smaller images",
            });
        }
        let scope = gpu
            .device()
            .push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
            label: Some("image layers"),
            size: wgpu::Extent3d {
                width: side,
                height: side,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[wgpu::TextureFormat::Rgba8UnormSrgb],
        });
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(GpuError::Driver(format!(
                "{layers} layers of {side} x {side} texels for images: {error}"
            )));
        }
        let send = |number: usize, bytes: &[u8]| {
            let (width, height) = sizes[number];
            upload(gpu, &texture, &places[number], width, height, 4, bytes);
            // Lets the driver take over the staged texels instead of keeping all images twice.
            gpu.queue().submit([]);
        };
        for (number, image) in fitted.iter().enumerate() {
            send(number, &image.rgba8);
        }
        for &(image, first) in &with_levels {
            for (number, bytes) in (first..).zip(levels::pyramid(&fitted[image])) {
                send(number, &bytes);
            }
        }

        let mut rows: Vec<[u32; 4]> = (fitted.iter().zip(&sizes).zip(&places))
            .map(|((image, &size), &place)| row(size, place, image.srgb))
            .collect();
        let user_base = rows.len() as u32;
        let levels_base = user_base + reads.images.len() as u32;
        for argument in reads.images {
            let image = argument.image as usize;
            let mut entry = rows[image];
            entry[3] = sampler_bits(&argument.sampler);
            if let Ok(found) = with_levels.binary_search_by_key(&image, |&(image, _)| image) {
                let first = with_levels[found].1 - fitted.len();
                entry[3] |= level_bits(levels::levels_below(sizes[image]), levels_base, first);
            }
            rows.push(entry);
        }
        for &(image, first) in &with_levels {
            let srgb = fitted[image].srgb;
            let below = levels::levels_below(sizes[image]) as usize;
            rows.extend((first..first + below).map(|n| row(sizes[n], places[n], srgb)));
        }
        let table = upload_table(gpu, &mut rows);
        let view = |format| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                format: Some(format),
                dimension: Some(wgpu::TextureViewDimension::D2Array),
                ..Default::default()
            })
        };
        Ok(Self {
            table,
            layers: view(wgpu::TextureFormat::Rgba8Unorm),
            layers_srgb: view(wgpu::TextureFormat::Rgba8UnormSrgb),
            user_base,
            bytes: u64::from(side) * u64::from(side) * u64::from(layers) * 4,
        })
    }
}

/// `ImageRect` in `images.wgsl`, packed.
fn row((width, height): (u32, u32), place: Place, srgb: bool) -> [u32; 4] {
    [
        place.x | place.y << 16,
        width | height << 16,
        place.layer | u32::from(srgb) << 31,
        0,
    ]
}

/// How many levels an image argument has below the full one, and the row of the first, above the sampler's bits. None
/// where the row can't be told in 21 bits, with two million images.
fn level_bits(below: u32, levels_base: u32, first: usize) -> u32 {
    let row = levels_base as usize + first;
    match row < 1 << 21 {
        true => below << 6 | (row as u32) << 11,
        false => 0,
    }
}

/// The image itself, or a smaller one where the device can't hold it.
fn fit(image: &Image, limit: u32) -> std::borrow::Cow<'_, Image> {
    if image.width <= limit && image.height <= limit {
        return std::borrow::Cow::Borrowed(image);
    }
    let scale = f64::from(limit) / f64::from(image.width.max(image.height));
    let (width, height) = (
        ((f64::from(image.width) * scale) as u32).clamp(1, limit),
        ((f64::from(image.height) * scale) as u32).clamp(1, limit),
    );
    tracing::warn!(
        "image `{}` is larger than the device allows and is reduced to {width} x {height}",
        image.name
    );
    let Some(buffer) = image::RgbaImage::from_raw(image.width, image.height, image.rgba8.clone())
    else {
        return std::borrow::Cow::Borrowed(image);
    };
    let small = image::imageops::resize(
        &buffer,
        width,
        height,
        image::imageops::FilterType::Triangle,
    );
    std::borrow::Cow::Owned(Image {
        width,
        height,
        rgba8: small.into_raw(),
        ..image.clone()
    })
}

/// Side of a layer, number of layers and the place of each image, tallest first on shelves.
fn place_all(sizes: &[(u32, u32)], max_side: u32, max_layers: u32) -> (u32, u32, Vec<Place>) {
    let largest = sizes.iter().map(|&(w, h)| w.max(h)).max().unwrap_or(1);
    let mut side = largest.max(64).next_power_of_two().min(max_side);
    loop {
        let (layers, places) = place_on(sizes, side);
        if layers <= max_layers.min(64) || side >= max_side {
            return (side, layers.max(1), places);
        }
        side = (side * 2).min(max_side);
    }
}

fn place_on(sizes: &[(u32, u32)], side: u32) -> (u32, Vec<Place>) {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse((sizes[i].1, sizes[i].0)));
    let mut places = vec![
        Place {
            layer: 0,
            x: 0,
            y: 0
        };
        sizes.len()
    ];
    let (mut layer, mut x, mut y, mut shelf) = (0, 0, 0, 0);
    for i in order {
        let (width, height) = sizes[i];
        if x + width > side {
            x = 0;
            y += shelf;
            shelf = 0;
        }
        if y + height > side {
            layer += 1;
            x = 0;
            y = 0;
            shelf = 0;
        }
        places[i] = Place { layer, x, y };
        x += width;
        shelf = shelf.max(height);
    }
    (layer + 1, places)
}

fn upload(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    place: &Place,
    width: u32,
    height: u32,
    texel: u32,
    bytes: &[u8],
) {
    gpu.queue().write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d {
                x: place.x,
                y: place.y,
                z: place.layer,
            },
            aspect: wgpu::TextureAspect::All,
        },
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * texel),
            rows_per_image: Some(height),
        },
        wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
    );
}

fn upload_table(gpu: &Gpu, rows: &mut Vec<[u32; 4]>) -> wgpu::TextureView {
    let height = (rows.len() as u32).div_ceil(TABLE_WIDTH).max(1);
    rows.resize((height * TABLE_WIDTH) as usize, [0, 1 | 1 << 16, 0, 0]);
    let texture = flat_texture(
        gpu,
        "image table",
        TABLE_WIDTH,
        height,
        wgpu::TextureFormat::Rgba32Uint,
    );
    upload(
        gpu,
        &texture,
        &Place {
            layer: 0,
            x: 0,
            y: 0,
        },
        TABLE_WIDTH,
        height,
        16,
        bytemuck::cast_slice(rows),
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// A texture that kernels read texel by texel.
pub(super) fn flat_texture(
    gpu: &Gpu,
    label: &str,
    width: u32,
    height: u32,
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// A texture of 16-byte texels with contents.
pub(super) fn filled_texture(
    gpu: &Gpu,
    label: &str,
    width: u32,
    height: u32,
    format: wgpu::TextureFormat,
    texels: &[u8],
) -> wgpu::TextureView {
    let texture = flat_texture(gpu, label, width, height, format);
    upload(
        gpu,
        &texture,
        &Place {
            layer: 0,
            x: 0,
            y: 0,
        },
        width,
        height,
        16,
        texels,
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placed_images_lie_inside_their_layer_and_never_overlap() {
        let sizes: Vec<(u32, u32)> = (1..60u32)
            .map(|i| (1 + (i * 37) % 300, 1 + (i * 91) % 256))
            .collect();
        let (side, layers, places) = place_all(&sizes, 8192, 256);
        for (i, (a, &(aw, ah))) in places.iter().zip(&sizes).enumerate() {
            assert!(a.layer < layers && a.x + aw <= side && a.y + ah <= side);
            for (b, &(bw, bh)) in places.iter().zip(&sizes).skip(i + 1) {
                let apart = a.layer != b.layer
                    || a.x + aw <= b.x
                    || b.x + bw <= a.x
                    || a.y + ah <= b.y
                    || b.y + bh <= a.y;
                assert!(apart, "images overlap");
            }
        }
    }

    #[test]
    fn many_large_images_take_larger_layers_before_too_many() {
        let (side, layers, _) = place_all(&vec![(1024, 1024); 300], 8192, 256);
        assert!(layers <= 64 && side <= 8192, "{layers} layers of {side}");
    }
}
