//! Images of the model, as small as they are shown, and as they are dragged to where they are to be read.

use std::sync::{Arc, OnceLock, Weak};

use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use engine::scene::Image;

/// Pixels of a small picture's longer side.
const SMALL: u32 = 48;

/// An image of the model, as small as it is shown.
#[derive(Clone)]
pub struct ModelImage {
    /// As a look calls it, behind `model:`.
    pub name: String,
    /// Of the image itself.
    pub size: [u32; 2],
    small: ColorImage,
    /// The small picture as egui has it, once it has been shown: egui forgets it when the image is gone.
    shown: Arc<OnceLock<TextureHandle>>,
    /// The image without its pixels.
    frame: Image,
    /// They go with the scene.
    pixels: Weak<Vec<u8>>,
    stamp: u64,
}

impl std::fmt::Debug for ModelImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ModelImage")
            .field("name", &self.name)
            .field("size", &self.size)
            .finish_non_exhaustive()
    }
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
            shown: Arc::default(),
            frame: Image {
                rgba8: Arc::default(),
                ..image.clone()
            },
            pixels: Arc::downgrade(&image.rgba8),
            stamp: stamp_of(image),
        }
    }

    /// The small picture as egui has it, made once for each image, in the one window that shows it.
    pub(crate) fn picture(&self, ctx: &Context) -> TextureHandle {
        let make = || {
            let options = TextureOptions::LINEAR;
            ctx.load_texture(&self.name, self.small.clone(), options)
        };
        self.shown.get_or_init(make).clone()
    }

    /// The image itself, while its scene is there.
    pub(crate) fn whole(&self) -> Option<Image> {
        Some(Image {
            rgba8: self.pixels.upgrade()?,
            ..self.frame.clone()
        })
    }

    /// Another one for other pixels.
    pub(crate) fn stamp(&self) -> u64 {
        self.stamp
    }
}

/// Of all that is seen of an image. It only has to tell changes, so it is a simple one that takes no time: some gigabytes a second.
fn stamp_of(image: &Image) -> u64 {
    let mix =
        |hash: u64, word: u64| (hash.rotate_left(5) ^ word).wrapping_mul(0x517c_c1b7_2722_0a95);
    let size = (u64::from(image.width) << 32) | u64::from(image.height);
    let first = mix(u64::from(image.srgb), size);
    let words = image.rgba8.chunks(8).map(|bytes| {
        let mut word = [0; 8];
        word[..bytes.len()].copy_from_slice(bytes);
        u64::from_le_bytes(word)
    });
    words.fold(first, mix)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(red: u8) -> Image {
        Image {
            name: "image \"t.png\"".to_owned(),
            width: 1,
            height: 3,
            rgba8: Arc::new([red, 0, 0, 255].repeat(3)),
            srgb: true,
        }
    }

    #[test]
    fn other_pixels_of_the_same_name_have_a_picture_of_their_own() {
        let ctx = Context::default();
        let [first, same, other] = [9, 9, 8].map(|red| ModelImage::new(&image(red)));
        assert_eq!(first.stamp(), same.stamp());
        assert_ne!(first.stamp(), other.stamp());
        let turned = Image {
            width: 3,
            height: 1,
            ..image(9)
        };
        assert_ne!(first.stamp(), ModelImage::new(&turned).stamp());
        let shown = first.picture(&ctx).id();
        assert_eq!(first.clone().picture(&ctx).id(), shown);
        assert_ne!(other.picture(&ctx).id(), shown);
    }

    #[test]
    fn pictures_and_pixels_go_with_the_image() {
        let ctx = Context::default();
        let whole = image(9);
        let small = ModelImage::new(&whole);
        let known = || ctx.tex_manager().read().num_allocated();
        let before = known();
        drop(small.picture(&ctx));
        assert_eq!(known(), before + 1);
        let again = small.whole().expect("its scene is there");
        assert!(Arc::ptr_eq(&again.rgba8, &whole.rgba8));
        assert_eq!(
            (again.width, again.height, &again.name),
            (1, 3, &whole.name)
        );
        drop((whole, again));
        assert!(small.whole().is_none());
        drop(small);
        assert_eq!(known(), before);
    }
}
