//! What a film was rendered from, as a list of named texts: films with different ones don't add up to a picture.

use bytemuck::NoUninit;

use crate::procedural::Procedural;
use crate::scene::{Camera, Environment, Scene};
use crate::settings::RenderSettings;

/// Everything that the samples of a picture depend on, but for the device and which samples they are: each setting by
/// name, and hashes of the scene and of its textures.
pub fn fingerprint(
    scene: &Scene,
    procedural: &Procedural,
    settings: &RenderSettings,
) -> Vec<(String, String)> {
    // Without `..`, so that a new setting can't be forgotten here.
    let RenderSettings {
        width,
        height,
        max_depth,
        seed,
        camera,
        energy_compensation,
        first_sample: _,
        filter,
        filter_width,
        clamp,
        estimator,
        roulette,
        sampler,
    } = settings;
    let mut hash = Hash::new();
    hash.scene(scene);
    let scene = hash.finish();
    let mut hash = Hash::new();
    hash.procedural(procedural);
    let Camera {
        name: _,
        transform,
        projection,
        aperture_radius,
        aperture_blades,
        aperture_rotation,
        focus_distance,
    } = camera;
    let camera = format!(
        "{transform:?}, {projection:?}, aperture of radius {aperture_radius} with {aperture_blades} blades turned by \
         {aperture_rotation}, focus distance {focus_distance}"
    );
    [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("size", format!("{width}x{height}")),
        ("max-depth", max_depth.to_string()),
        ("seed", seed.to_string()),
        ("camera", camera),
        ("energy-compensation", energy_compensation.to_string()),
        ("filter", format!("{} of {filter_width}", filter.name())),
        (
            "clamp",
            clamp.map_or("off".to_owned(), |most| most.to_string()),
        ),
        ("estimator", estimator.name().to_owned()),
        ("roulette", roulette.to_string()),
        ("sampler", sampler.name().to_owned()),
        ("scene", scene),
        ("textures", hash.finish()),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .into()
}

/// FNV-1a over words of 64 bits: eight times as fast as over bytes, and as good at telling accidents apart.
#[derive(Debug)]
pub(super) struct Hash(u64);

impl Hash {
    pub(super) fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        let mut add = |word: u64| {
            // The rotation lets the high bits of a word reach the low ones.
            self.0 = (self.0 ^ word)
                .wrapping_mul(0x0100_0000_01b3)
                .rotate_left(29);
        };
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| add(u64::from_le_bytes(*word)));
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        add(u64::from_le_bytes(last));
        add(bytes.len() as u64);
    }

    pub(super) fn value(&self) -> u64 {
        self.0
    }

    fn finish(&self) -> String {
        format!("{:016x}", self.0)
    }

    fn list<T: NoUninit>(&mut self, list: &[T]) {
        self.bytes(bytemuck::cast_slice(list));
    }

    /// The text of plain data. Numbers are written with all the digits that tell them apart.
    fn text(&mut self, value: &impl std::fmt::Debug) {
        self.bytes(format!("{value:?}").as_bytes());
    }

    fn scene(&mut self, scene: &Scene) {
        for mesh in &scene.meshes {
            self.list(&mesh.positions);
            self.list(&mesh.normals);
            self.list(&mesh.tangents);
            self.list(&mesh.uv0);
            self.list(&mesh.uv1);
            self.list(&mesh.colors);
            for attribute in &mesh.custom {
                self.text(&attribute.name);
                self.list(&attribute.values);
            }
            self.list(&mesh.triangles);
            self.list(&mesh.triangle_materials);
        }
        for image in &scene.images {
            self.text(&(image.width, image.height, image.srgb));
            self.bytes(&image.rgba8);
        }
        self.text(&(&scene.instances, &scene.materials, &scene.lights));
        match &scene.environment {
            Environment::Constant(radiance) => self.text(radiance),
            Environment::Image {
                image,
                rotation,
                intensity,
            } => {
                self.text(&(image.width, image.height, rotation, intensity));
                self.list(&image.rgb);
            }
        }
    }

    fn procedural(&mut self, procedural: &Procedural) {
        self.bytes(procedural.kernel().wgsl.as_bytes());
        self.list(procedural.args());
        self.list(procedural.programs());
        self.text(&(procedural.ao(), procedural.textures()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_tell_apart_what_differs() {
        let of = |pieces: &[&[u8]]| {
            let mut hash = Hash::new();
            pieces.iter().for_each(|piece| hash.bytes(piece));
            hash.value()
        };
        let all = [
            of(&[]),
            of(&[b""]),
            of(&[b"\0"]),
            of(&[b"a"]),
            of(&[b"abcdefgh"]),
            of(&[b"abcdefghi"]),
            of(&[b"abcdefgh", b"i"]),
            of(&[b"\x80bcdefgh"]),
        ];
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| a != b), "{i}");
        }
        assert_eq!(of(&[b"abcdefghi"]), of(&[b"abcdefghi"]));
    }
}
