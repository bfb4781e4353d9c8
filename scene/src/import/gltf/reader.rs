//! What all materials of a file are read with: texture references, factors within their ranges, and the list of
//! pictures that is needed.

use crate::import::error::{Fault, Warnings};
use crate::{Filter, Sampler, TextureRef, Wrap};
use glam::{Vec3, Vec4};
use gltf::json;
use json::extensions::texture::TextureTransform;
use json::validation::Checked;
use serde_json::{Map, Value};
use std::collections::HashMap;

/// Pictures in the order in which they become `Scene::images`: index in the file, and whether RGB is sRGB-encoded.
pub(super) type ImageRequests = Vec<(usize, bool)>;

/// Scales of normal maps and angles are no larger: their squares would be no numbers any more.
pub(super) const MOST: f32 = 1e6;

pub(super) struct Reader<'a> {
    root: &'a json::Root,
    pub(super) requests: ImageRequests,
    found: HashMap<(usize, bool), u32>,
    /// For each image of the file the first one with the same bytes.
    first: Vec<usize>,
    warnings: &'a mut Warnings,
    /// What stands before each warning.
    pub(super) place: String,
}

impl<'a> Reader<'a> {
    /// `first` says of each image of the file which one is the first with the same bytes.
    pub(super) fn new(root: &'a json::Root, first: Vec<usize>, warnings: &'a mut Warnings) -> Self {
        Self {
            root,
            requests: Vec::new(),
            found: HashMap::new(),
            first,
            warnings,
            place: String::new(),
        }
    }

    pub(super) fn info(
        &mut self,
        info: &Option<json::texture::Info>,
        srgb: bool,
    ) -> Result<Option<TextureRef>, Fault> {
        let Some(info) = info else {
            return Ok(None);
        };
        let transform = info
            .extensions
            .as_ref()
            .and_then(|e| e.texture_transform.as_ref());
        self.texture(info.index.value(), info.tex_coord, transform, srgb)
    }

    pub(super) fn texture(
        &mut self,
        index: usize,
        uv_set: u32,
        transform: Option<&TextureTransform>,
        srgb: bool,
    ) -> Result<Option<TextureRef>, Fault> {
        let texture = self
            .root
            .textures
            .get(index)
            .ok_or_else(|| format!("texture {index} does not exist"))?;
        let Some(image) = self.image(index, texture)? else {
            return Ok(None);
        };
        let sampler = match texture.sampler {
            Some(sampler) => {
                let source = self.root.samplers.get(sampler.value()).ok_or_else(|| {
                    format!(
                        "texture {index}: sampler {} does not exist",
                        sampler.value()
                    )
                })?;
                self.sampler(source)
            }
            None => Sampler::default(),
        };
        let mut uv_set = transform.and_then(|t| t.tex_coord).unwrap_or(uv_set);
        if uv_set > 1 {
            self.warn(format!(
                "uses TEXCOORD_{uv_set}, only 0 and 1 are read; 0 is used"
            ));
            uv_set = 0;
        }
        let next = self.requests.len() as u32;
        let image = *self.found.entry((image, srgb)).or_insert_with(|| {
            self.requests.push((image, srgb));
            next
        });
        Ok(Some(TextureRef {
            image,
            uv_set,
            sampler,
            transform: match transform {
                Some(transform) => self.affine(transform),
                None => [Vec3::X, Vec3::Y],
            },
        }))
    }

    /// The picture of a texture: WebP where the file offers it, else the core source.
    fn image(&mut self, index: usize, texture: &json::Texture) -> Result<Option<usize>, Fault> {
        let webp = texture
            .extensions
            .as_ref()
            .and_then(|extensions| extensions.others.get("EXT_texture_webp"))
            .and_then(|webp| webp.get("source")?.as_u64());
        let image = match webp {
            Some(webp) => usize::try_from(webp).unwrap_or(usize::MAX),
            None => texture.source.value(),
        };
        // The JSON reader's way of saying that there is no source.
        if image == u32::MAX as usize {
            self.warn(format!(
                "texture {index} has no picture that can be read and is ignored"
            ));
            return Ok(None);
        }
        if image >= self.root.images.len() {
            return Err(format!("texture {index}: image {image} does not exist"));
        }
        Ok(Some(self.first[image]))
    }

    fn sampler(&mut self, source: &json::texture::Sampler) -> Sampler {
        use json::texture::{MagFilter, WrappingMode};
        let mut wrap = |mode: Checked<WrappingMode>| match mode {
            Checked::Valid(WrappingMode::Repeat) => Wrap::Repeat,
            Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
            Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
            Checked::Invalid => {
                self.warn("a sampler has an unknown wrap mode; it repeats".into());
                Wrap::Repeat
            }
        };
        Sampler {
            wrap_u: wrap(source.wrap_s),
            wrap_v: wrap(source.wrap_t),
            filter: match source.mag_filter {
                Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
                _ => Filter::Linear,
            },
        }
    }

    fn affine(&mut self, transform: &TextureTransform) -> [Vec3; 2] {
        let values = [
            transform.offset.0[0],
            transform.offset.0[1],
            transform.rotation.0,
            transform.scale.0[0],
            transform.scale.0[1],
        ];
        if values.iter().any(|value| !value.is_finite()) {
            self.warn("a texture transform is not finite and is ignored".into());
            return [Vec3::X, Vec3::Y];
        }
        texture_transform(values)
    }

    pub(super) fn unit(&mut self, what: &str, value: f32) -> f32 {
        self.within(what, value, 0.0, 1.0, 1.0)
    }

    pub(super) fn unit4(&mut self, what: &str, value: [f32; 4]) -> Vec4 {
        Vec4::from(value.map(|value| self.unit(what, value)))
    }

    pub(super) fn positive3(&mut self, what: &str, value: [f32; 3]) -> Vec3 {
        Vec3::from(value.map(|value| self.within(what, value, 0.0, f32::MAX, 0.0)))
    }

    /// Clamps, with a warning where that changes something; `default` stands in for infinity and NaN.
    pub(super) fn within(
        &mut self,
        what: &str,
        value: f32,
        least: f32,
        most: f32,
        default: f32,
    ) -> f32 {
        let valid = if value.is_finite() {
            value.clamp(least, most)
        } else {
            default
        };
        if valid != value {
            self.warn(format!("{what} is {value}; {valid} is used"));
        }
        valid
    }

    fn warn(&mut self, what: String) {
        self.warnings.push(format!("{}: {what}", self.place));
    }
}

pub(super) fn other_transform(
    others: Option<&Map<String, Value>>,
) -> Result<Option<TextureTransform>, Fault> {
    match others.and_then(|others| others.get("KHR_texture_transform")) {
        None => Ok(None),
        Some(value) => serde_json::from_value(value.clone())
            .map(Some)
            .map_err(|error| format!("KHR_texture_transform: {error}")),
    }
}

/// Rows of translation · rotation · scale. The rotation is counter-clockwise as the picture is seen, with v pointing
/// down: what the extension's text and its implementations agree on (its listing has had the sign both ways).
fn texture_transform([offset_u, offset_v, rotation, scale_u, scale_v]: [f32; 5]) -> [Vec3; 2] {
    let (sin, cos) = rotation.sin_cos();
    [
        Vec3::new(cos * scale_u, sin * scale_v, offset_u),
        Vec3::new(-sin * scale_u, cos * scale_v, offset_v),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_is_counter_clockwise_on_the_picture() {
        let rows = texture_transform([0.5, 0.25, std::f32::consts::FRAC_PI_2, 2.0, 3.0]);
        let map = |u: f32, v: f32| rows.map(|row| row.dot(Vec3::new(u, v, 1.0)));
        let close = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-5;
        assert!(close(map(0.0, 0.0), [0.5, 0.25]));
        assert!(close(map(1.0, 0.0), [0.5, 0.25 - 2.0]), "right turns up");
        assert!(close(map(0.0, 1.0), [0.5 + 3.0, 0.25]), "down turns right");
    }
}
