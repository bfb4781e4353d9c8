//! All image textures in the layers of one array texture, placed by shelves, and the table of where each lies.

use device::{Device, DeviceError, Format, Image, ImageUse, Limits, Resources};

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
            .map(|image| fit(image, limits.image_side))
            .collect();
        let full = fitted.iter().map(|image| (image.width, image.height));
        let (sizes, with_levels) = with_levels(full, reads);
        let (size, places) = place_all(&sizes, limits.image_side, limits.image_layers);
        let [width, height, layers] = size;
        if layers > limits.image_layers {
            return Err(DeviceError::TooLarge {
                what: "the image textures' array".to_owned(),
                needed: bytes_of(size),
                limit: bytes_of([width, height, limits.image_layers]),
                remedy: "use fewer or smaller images",
            });
        }
        let usage = ImageUse::ReadLayers;
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
            bytes: bytes_of(size),
        })
    }
}

/// Bytes of all layers on a device.
pub(super) fn bytes(limits: &Limits, scene: &Scene, reads: &TextureReads<'_>) -> u64 {
    let full = scene.images.iter();
    let full = full.map(|image| fitted_size(image, limits.image_side));
    let (sizes, _) = with_levels(full, reads);
    bytes_of(place_all(&sizes, limits.image_side, limits.image_layers).0)
}

/// Bytes of layers of a size, four a texel.
fn bytes_of(size: [u32; 3]) -> u64 {
    4 * size.map(u64::from).iter().product::<u64>()
}

/// Width and height.
type Size = (u32, u32);

/// Sizes of the images, then of the levels of each that has any; and the numbers of those images, each with that of its first level.
fn with_levels(
    full: impl Iterator<Item = Size>,
    reads: &TextureReads<'_>,
) -> (Vec<Size>, Vec<(usize, usize)>) {
    let mut sizes: Vec<Size> = full.collect();
    let mut with_levels = Vec::new();
    for &image in reads.with_levels {
        let full = sizes[image as usize];
        with_levels.push((image as usize, sizes.len()));
        sizes.extend((1..=levels::levels_below(full)).map(|l| levels::size_of_level(full, l)));
    }
    (sizes, with_levels)
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

/// Longest side of an image, which 16 bits of the table tell.
const LONGEST_SIDE: u32 = 1 << 15;

/// Width and height of an image, or of the smaller one that a device with this limit can hold.
fn fitted_size(image: &scene::Image, limit: u32) -> (u32, u32) {
    let limit = limit.min(LONGEST_SIDE);
    if image.width <= limit && image.height <= limit {
        return (image.width, image.height);
    }
    let scale = f64::from(limit) / f64::from(image.width.max(image.height));
    (
        ((f64::from(image.width) * scale) as u32).clamp(1, limit),
        ((f64::from(image.height) * scale) as u32).clamp(1, limit),
    )
}

/// The image itself, or a smaller one where the device can't hold it.
fn fit(image: &scene::Image, limit: u32) -> std::borrow::Cow<'_, scene::Image> {
    let (width, height) = fitted_size(image, limit);
    if (width, height) == (image.width, image.height) {
        return std::borrow::Cow::Borrowed(image);
    }
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

/// Sides of layers are multiples of this, as drivers lay them out.
const STEP: u32 = 64;

/// Width and height of a layer, number of layers and the place of each image, tallest first on shelves. A layer is no larger than the
/// largest images want it, unless there would be too many of them: one long image makes none that is as high.
fn place_all(sizes: &[(u32, u32)], max_side: u32, max_layers: u32) -> ([u32; 3], Vec<Place>) {
    let least = |side: fn(&(u32, u32)) -> u32| {
        let largest = sizes.iter().map(side).max().unwrap_or(1);
        largest.next_multiple_of(STEP).min(max_side)
    };
    let (mut width, mut height) = (least(|size| size.0), least(|size| size.1));
    loop {
        let (layers, places) = place_on(sizes, [width, height]);
        let is_largest = width >= max_side && height >= max_side;
        if layers <= max_layers.min(64) || is_largest {
            return ([width, height, layers], places);
        }
        let side = match width <= height {
            true => &mut width,
            false => &mut height,
        };
        *side = (*side * 2).min(max_side);
    }
}

/// Number of layers of a size and the place of each image.
fn place_on(sizes: &[(u32, u32)], layer_size: [u32; 2]) -> (u32, Vec<Place>) {
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
        if x + width > layer_size[0] {
            x = 0;
            y += shelf;
            shelf = 0;
        }
        if y + height > layer_size[1] {
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
        let ([columns, rows, layers], places) = place_all(&sizes, 8192, 256);
        for (i, (a, &(aw, ah))) in places.iter().zip(&sizes).enumerate() {
            assert!(a.layer < layers && a.x + aw <= columns && a.y + ah <= rows);
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
        let ([width, height, layers], _) = place_all(&vec![(1024, 1024); 300], 8192, 256);
        assert!(
            layers <= 64 && width <= 8192 && height <= 8192,
            "{layers} layers of {width} x {height}"
        );
    }

    #[test]
    fn a_long_image_makes_no_high_layers() {
        let size = |sizes: &[(u32, u32)]| place_all(sizes, 16384, 256).0;
        assert_eq!(size(&[(8200, 16)]), [8256, 64, 1]);
        assert_eq!(size(&[(16, 16384), (3, 3)]), [64, 16384, 1]);
        assert_eq!(size(&[(3000, 2000)]), [3008, 2048, 1]);
        assert_eq!(size(&[]), [64, 64, 1]);
    }
}
