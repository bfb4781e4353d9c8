//! The images of `sam2D` parameters: loaded once each into the scene.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use glam::Vec3;
use texgen::did_you_mean;

use crate::input::{FileId, Files};
use crate::scene::import::load_picture;
use crate::scene::{Image, Sampler, Scene, TextureRef};

/// How many of the model's images a message names.
const MAX_NAMED: usize = 20;

/// Loads images and hands out texture handles.
#[derive(Debug, Default)]
pub(super) struct Images {
    by_file: HashMap<(FileId, bool), u32>,
    pub(super) textures: Vec<TextureRef>,
    /// Of the scene's images: those whose mip levels a texture reads.
    pub(super) with_levels: BTreeSet<u32>,
    /// What files lost as they were loaded.
    pub(super) losses: Vec<String>,
}

impl Images {
    /// Some texture reads the mip levels of the image behind a handle.
    pub(super) fn read_levels(&mut self, handle: u32) {
        self.with_levels
            .insert(self.textures[handle as usize].image);
    }

    /// The handle of an image read in a certain way; the image is added to the scene where it isn't there yet.
    pub(super) fn handle(
        &mut self,
        files: &dyn Files,
        scene: &mut Scene,
        path: &Path,
        srgb: bool,
        sampler: Sampler,
    ) -> Result<u32, String> {
        let key = (files.id(path), srgb);
        let image = match self.by_file.get(&key) {
            Some(&image) => image,
            None => {
                let image = scene.images.len() as u32;
                let (picture, lost) = load_picture(files, path, srgb, &scene.images)?;
                scene.images.push(picture);
                self.losses.extend(lost);
                self.by_file.insert(key, image);
                image
            }
        };
        Ok(self.texture(image, sampler))
    }

    /// The handle of an image that the model brings, by its name there.
    pub(super) fn of_model(
        &mut self,
        scene: &mut Scene,
        name: &str,
        srgb: bool,
        sampler: Sampler,
    ) -> Result<u32, String> {
        let named = |image: &Image| image.short_name() == name;
        let Some(first) = scene.images.iter().position(named) else {
            let known = || scene.images.iter().map(Image::short_name);
            let mut message = "the model has no image of that name".to_owned();
            if let Some(near) = did_you_mean(name, known()) {
                message += &format!("; did you mean `{near}`?");
            } else if !scene.images.is_empty() {
                let names: BTreeSet<&str> = known().collect();
                let more = if names.len() > MAX_NAMED { ", ..." } else { "" };
                let names: Vec<&str> = names.into_iter().take(MAX_NAMED).collect();
                message += &format!("; it has: {}{more}", names.join(", "));
            }
            return Err(message);
        };
        let fits = |image: &Image| named(image) && image.srgb == srgb;
        let image = match scene.images.iter().position(fits) {
            Some(image) => image,
            // The pixels are shared.
            None => {
                let other = Image {
                    srgb,
                    ..scene.images[first].clone()
                };
                scene.images.push(other);
                scene.images.len() - 1
            }
        };
        Ok(self.texture(image as u32, sampler))
    }

    fn texture(&mut self, image: u32, sampler: Sampler) -> u32 {
        let texture = TextureRef {
            image,
            uv_set: 0,
            sampler,
            transform: [Vec3::X, Vec3::Y],
        };
        let known = self.textures.iter().position(|t| *t == texture);
        let place = known.unwrap_or_else(|| {
            self.textures.push(texture);
            self.textures.len() - 1
        });
        place as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_of_the_model_that_are_not_there_are_answered_with_those_that_are() {
        let image = |name: &str| Image {
            name: name.to_owned(),
            width: 1,
            height: 1,
            rgba8: vec![255; 4].into(),
            srgb: true,
        };
        let mut scene = Scene {
            images: vec![image("image 0"), image("image 1 \"paint.png\"")],
            ..Scene::default()
        };
        let mut of_model = |name: &str| {
            let sampler = Sampler::default();
            Images::default().of_model(&mut scene, name, true, sampler)
        };
        assert_eq!((of_model("0"), of_model("paint.png")), (Ok(0), Ok(0)));
        for (name, end) in [
            ("image 0", "; it has: 0, paint.png"),
            ("pant.png", "; did you mean `paint.png`?"),
        ] {
            let message = of_model(name).expect_err(name);
            assert!(message.ends_with(end), "{message}");
        }
    }
}
