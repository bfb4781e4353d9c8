//! The images of `sam2D` parameters: loaded once each into the scene.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::Vec3;

use crate::scene::{Image, Sampler, Scene, TextureRef};

/// Texels along one side of an image, at most.
const MAX_SIDE: u32 = 16_384;
/// Bytes that decoding one image may take.
const MAX_ALLOC: u64 = 2 << 30;

/// Loads images and hands out texture handles.
#[derive(Debug, Default)]
pub(super) struct Images {
    by_path: HashMap<(PathBuf, bool), u32>,
    pub(super) textures: Vec<TextureRef>,
}

impl Images {
    /// The handle of an image read in a certain way; the image is added to the scene where it isn't there yet.
    pub(super) fn handle(
        &mut self,
        scene: &mut Scene,
        path: &Path,
        srgb: bool,
        sampler: Sampler,
    ) -> Result<u32, image::ImageError> {
        let key = (path.to_owned(), srgb);
        let image = match self.by_path.get(&key) {
            Some(&image) => image,
            None => {
                let image = scene.images.len() as u32;
                scene.images.push(load(path, srgb)?);
                self.by_path.insert(key, image);
                image
            }
        };
        let texture = TextureRef {
            image,
            uv_set: 0,
            sampler,
            transform: [Vec3::X, Vec3::Y],
        };
        let known = self.textures.iter().position(|t| *t == texture);
        Ok(known.unwrap_or_else(|| {
            self.textures.push(texture);
            self.textures.len() - 1
        }) as u32)
    }
}

fn load(path: &Path, srgb: bool) -> Result<Image, image::ImageError> {
    let mut reader = image::ImageReader::open(path)?.with_guessed_format()?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_ALLOC);
    reader.limits(limits);
    let pixels = reader.decode()?.into_rgba8();
    Ok(Image {
        name: path.display().to_string(),
        width: pixels.width(),
        height: pixels.height(),
        rgba8: pixels.into_raw(),
        srgb,
    })
}
