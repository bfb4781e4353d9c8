//! Images of the model, as small as they are shown, and as they are dragged to where they are to be read.

use egui::{ColorImage, Context, Id, TextureHandle, TextureOptions};
use engine::scene::Image;

/// Pixels of a small picture's longer side.
const SMALL: u32 = 48;

/// An image of the model, as small as it is shown.
#[derive(Debug, Clone)]
pub struct ModelImage {
    /// As a look calls it, behind `model:`.
    pub name: String,
    /// Of the image itself.
    pub size: [u32; 2],
    small: ColorImage,
}

/// An image of the model that is dragged from a material's maps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct DraggedImage {
    /// As [`ModelImage::name`].
    pub(crate) name: String,
    /// It holds numbers, not colours.
    pub(crate) is_data: bool,
}

impl ModelImage {
    /// Makes the small picture of an image.
    pub fn new(image: &Image) -> Self {
        let longer = image.width.max(image.height).max(1);
        let side = |of: u32| (of * SMALL / longer).clamp(1, SMALL);
        let [width, height] = [side(image.width), side(image.height)];
        let texel = |x: u32, y: u32| {
            let at = |i: u32, of: u32, among: u32| (2 * i + 1) * of / (2 * among);
            let place = at(y, image.height, height) * image.width + at(x, image.width, width);
            let bytes = image.rgba8.get(place as usize * 4..place as usize * 4 + 3);
            bytes.map_or([0; 3], |rgb| [rgb[0], rgb[1], rgb[2]])
        };
        let pixels = (0..width * height).flat_map(|i| texel(i % width, i / width));
        let pixels: Vec<u8> = pixels.collect();
        Self {
            name: image.short_name().to_owned(),
            size: [image.width, image.height],
            small: ColorImage::from_rgb([width as usize, height as usize], &pixels),
        }
    }

    /// The small picture as egui has it, made once for each image; `number` is its own.
    pub(crate) fn picture(&self, ctx: &Context, number: usize) -> TextureHandle {
        let id = Id::unique(("image of the model", number, &self.name, self.size));
        let known = ctx.data(|data| data.get_temp::<TextureHandle>(id));
        known.unwrap_or_else(|| {
            let options = TextureOptions::LINEAR;
            let handle = ctx.load_texture(&self.name, self.small.clone(), options);
            ctx.data_mut(|data| data.insert_temp(id, handle.clone()));
            handle
        })
    }
}
