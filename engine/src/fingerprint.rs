//! What a film was rendered from, as a list of named texts: films with different ones don't add up to a picture.

use std::path::Path;

use bytemuck::NoUninit;
use device::Device;

use crate::film::{HALVES, Hash, Origin};
use crate::procedural::Procedural;
use crate::scene::{Camera, Environment, Scene};
use crate::settings::{Method, PATHS_AHEAD, RenderSettings};

/// The setting that is said of pictures that have begun anew with finer records.
pub const REFINEMENT: &str = "refinement";

/// Everything that the samples of a picture depend on, but for the device and which samples they are: each setting by
/// name, and hashes of the scene and of its textures.
pub fn fingerprint(
    scene: &Scene,
    procedural: &Procedural,
    settings: &RenderSettings,
) -> Vec<(String, String)> {
    let mut hash = Contents(Hash::new());
    hash.scene(scene);
    let scene = hash.0.finish();
    let mut hash = Contents(Hash::new());
    // As it is rendered; where it can't be, a renderer says so.
    let shown = procedural.showing(settings.layers.nodes());
    hash.procedural(shown.as_ref().unwrap_or(procedural));
    let mut list = named(settings);
    list.push(("scene".to_owned(), scene));
    list.push(("textures".to_owned(), hash.0.finish()));
    // What is gathered beside the picture changes no sample of it, and the files of pictures alone say nothing of it.
    if !settings.layers.is_picture_alone() {
        list.push(("layers".to_owned(), settings.layers.asked().join(",")));
    }
    list
}

/// Where a picture of these settings comes from, for the headers of files that nothing is added to: without the hashes, which
/// take as long as reading the scene once more.
pub fn origin(
    device: &Device,
    settings: &RenderSettings,
    scene: &Path,
    look: Option<&Path>,
) -> Origin {
    Origin::new(&device.description().name, scene, look, named(settings))
}

/// The settings alone, by name.
fn named(settings: &RenderSettings) -> Vec<(String, String)> {
    // Without `..`, so that a new setting can't be forgotten here.
    let RenderSettings {
        width,
        height,
        crop,
        max_depth,
        seed,
        camera,
        energy_compensation,
        first_sample: _,
        moment_since: _,
        filter,
        filter_width,
        clamp,
        estimator,
        roulette,
        sampler,
        halves,
        method,
        piece_of: _,
        refinement,
        paths_ahead,
        largest_wave: _,
        layers: _,
        time,
        frame_index,
        beside,
    } = settings;
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
    let [columns, rows] = settings.whole();
    let mut list: Vec<(String, String)> = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("size", format!("{columns}x{rows}")),
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
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .into();
    let beside_text = beside.as_ref().map(|beside| {
        let mut hash = Contents(Hash::new());
        hash.text(beside);
        hash.0.finish()
    });
    // Of what is as usual nothing is said.
    let part = crop.map(|crop| crop.written(*width, *height));
    for (name, value, is_said) in [
        ("crop", part.clone().unwrap_or_default(), part.is_some()),
        ("time", time.to_string(), *time != 0.0),
        ("frame", frame_index.to_string(), *frame_index != 0),
        (
            "beside",
            beside_text.clone().unwrap_or_default(),
            beside_text.is_some(),
        ),
        (HALVES, halves.to_string(), *halves),
        ("method", method.name().to_owned(), *method != Method::Path),
        (REFINEMENT, refinement.to_string(), *refinement != 0),
        (
            "paths ahead",
            paths_ahead.to_string(),
            *paths_ahead != PATHS_AHEAD,
        ),
    ] {
        if is_said {
            list.push((name.to_owned(), value));
        }
    }
    list
}

/// A hash of plain data.
struct Contents(Hash);

impl Contents {
    fn list<T: NoUninit>(&mut self, list: &[T]) {
        self.0.bytes(bytemuck::cast_slice(list));
    }

    /// The text of plain data. Numbers are written with all the digits that tell them apart.
    fn text(&mut self, value: &impl std::fmt::Debug) {
        self.0.bytes(format!("{value:?}").as_bytes());
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
            self.0.bytes(&image.rgba8);
        }
        self.text(&(&scene.instances, &scene.materials, &scene.lights));
        self.text(&scene.light_groups);
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
        self.0.bytes(procedural.kernel().wgsl.as_bytes());
        self.list(procedural.args());
        self.list(procedural.programs());
        self.text(&(procedural.ao(), procedural.textures()));
    }
}
