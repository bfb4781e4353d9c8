//! All image textures in the layers of one array texture, placed by shelves, and the table of where each lies.

use device::{Device, DeviceError, Format, Image, ImageUse, Resources};

use crate::{
    scene::{self, Scene},
    texturing::TextureReads,
};

use super::{levels, materials::sampler_bits};

/// Entries in a row of the table; `IMAGE_TABLE_WIDTH` in `images.wgsl`.
const TABLE_WIDTH: u32 = 1024;

/// The textures and the views that kernels bind.
#[derive(Debug)]
pub struct GpuImages {
    /// `image_table`.
    pub table: Image,
    /// `image_layers`.
    pub layers: Image,
    /// `image_layers_srgb`.
    pub layers_srgb: Image,
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
    pub fn new(
        device: &Device,
        scene: &Scene,
        reads: &TextureReads<'_>,
    ) -> Result<Self, DeviceError> {
        let limits = device.limits();
        let fitted: Vec<std::borrow::Cow<'_, scene::Image>> = scene
            .images
            .iter()
            .map(|image| fit(image, limits.image_side.min(32768)))
            .collect();
        // The images, then the levels of each that has any.
        let mut sizes: Vec<(u32, u32)> = fitted.iter().map(|i| (i.width, i.height)).collect();
        let mut with_levels = Vec::new();
        for &image in reads.with_levels {
            let full = sizes[image as usize];
            with_levels.push((image as usize, sizes.len()));
            sizes.extend((1..=levels::levels_below(full)).map(|l| levels::size_of_level(full, l)));
        }
        let (side, layers, places) = place_all(&sizes, limits.image_side, limits.image_layers);
        if layers > limits.image_layers {
            return Err(DeviceError::TooLarge {
                what: "the image textures' array".to_owned(),
                needed: u64::from(layers) * u64::from(side) * u64::from(side) * 4,
                limit: u64::from(limits.image_layers) * u64::from(side) * u64::from(side) * 4,
                remedy: "use fewer or smaller images",
            });
        }
        let (usage, size) = (ImageUse::ReadLayers, [side, side, layers]);
        let layered = device.image("image layers", usage, size, Format::Rgba8Unorm)?;
        let send = |number: usize, bytes: &[u8]| {
            let (width, height) = sizes[number];
            let Place { layer, x, y } = places[number];
            layered.write(device, [x, y, layer], [width, height], bytes);
            // Lets the driver take over the staged texels instead of keeping all images twice.
            device.flush();
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
        let table = upload_table(device, &mut rows)?;
        Ok(Self {
            table,
            layers_srgb: layered.as_srgb(),
            layers: layered,
            user_base,
            bytes: u64::from(side) * u64::from(side) * u64::from(layers) * 4,
        })
    }
}

impl GpuImages {
    /// Gives them the names by which kernels know them.
    pub(super) fn name(&self, resources: &mut Resources) {
        resources.set_image("image_table", self.table.clone());
        resources.set_image("image_layers", self.layers.clone());
        resources.set_image("image_layers_srgb", self.layers_srgb.clone());
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
fn fit(image: &scene::Image, limit: u32) -> std::borrow::Cow<'_, scene::Image> {
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
    let Some(buffer) = image::RgbaImage::from_raw(image.width, image.height, image.rgba8.to_vec())
    else {
        return std::borrow::Cow::Borrowed(image);
    };
    let small = image::imageops::resize(
        &buffer,
        width,
        height,
        image::imageops::FilterType::Triangle,
    );
    std::borrow::Cow::Owned(scene::Image {
        width,
        height,
        rgba8: small.into_raw().into(),
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

fn upload_table(device: &Device, rows: &mut Vec<[u32; 4]>) -> Result<Image, DeviceError> {
    let height = (rows.len() as u32).div_ceil(TABLE_WIDTH).max(1);
    rows.resize((height * TABLE_WIDTH) as usize, [0, 1 | 1 << 16, 0, 0]);
    filled_image(
        device,
        "image table",
        [TABLE_WIDTH, height],
        Format::Rgba32Uint,
        bytemuck::cast_slice(rows),
    )
}

/// An image that kernels read texel by texel, with contents.
pub(super) fn filled_image(
    device: &Device,
    label: &str,
    size: [u32; 2],
    format: Format,
    texels: &[u8],
) -> Result<Image, DeviceError> {
    let [width, height] = size;
    let image = device.image(label, ImageUse::Read, [width, height, 1], format)?;
    image.write(device, [0; 3], size, texels);
    Ok(image)
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
