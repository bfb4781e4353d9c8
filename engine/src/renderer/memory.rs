//! What a render will take, known before anything is allocated.

use device::Device;

use crate::{
    film::{self, Layers},
    gpu_scene::{self, SceneFeatures},
    procedural::{Procedural, node_words},
    scene::Scene,
    schedule::Wavefront,
    settings::RenderSettings,
    wave::{PathBytes, QUEUE_HEADER},
};

use super::lanes::Lanes;
use super::{irradiance, light_cache, most_paths, photons};

/// Bytes on a device.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DeviceMemory {
    /// The picture's sums.
    pub film: u64,
    /// The layers beside it.
    pub layers: u64,
    /// Geometry, materials, lights, images: about so much.
    pub scene: u64,
    /// The paths of a wave, and a cache of light where they end in one.
    pub paths: u64,
}

impl DeviceMemory {
    /// What a render takes on a device.
    pub fn of(
        device: &Device,
        scene: &Scene,
        procedural: &Procedural,
        settings: &RenderSettings,
    ) -> Self {
        let (picture, layers) = film_bytes(settings);
        Self {
            film: picture,
            layers,
            scene: gpu_scene::bytes(device, scene, &procedural.reads(), |m| procedural.traits(m)),
            paths: paths(device, procedural, settings) + caches(device, settings),
        }
    }

    /// All of it.
    pub fn total(&self) -> u64 {
        self.film + self.layers + self.scene + self.paths
    }
}

/// Bytes of what knows light from before.
fn caches(device: &Device, settings: &RenderSettings) -> u64 {
    let method = settings.method;
    light_cache::bytes(settings)
        + irradiance::bytes(device, method)
        + photons::bytes(device, settings)
}

/// Bytes of a film as it is gathered: the picture's, and those of its layers.
fn film_bytes(settings: &RenderSettings) -> (u64, u64) {
    let plane = 16 * u64::from(settings.width) * u64::from(settings.height);
    let planes = settings.layers.buffers().len() as u64;
    let of_picture = film::PICTURE_PLANES.len() as u64;
    (plane * of_picture, plane * (planes - of_picture))
}

/// Bytes of a film's copy in the program, which is what files are written from.
pub fn snapshot_bytes(settings: &RenderSettings) -> u64 {
    let (picture, layers) = film_bytes(settings);
    picture + layers
}

/// Bytes of what an EXR file of these layers is packed from.
pub fn file_bytes(settings: &RenderSettings, layers: &Layers) -> u64 {
    let written = layers.iter().filter(|layer| !layer.is_kept_back());
    let channels: usize = written.map(|layer| layer.channel_count()).sum();
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    // The numbers as they are, and as they are packed; and those of the layer that is being worked out.
    let single = size_of::<f32>() as u64;
    pixels * single * (2 * channels as u64 + 2 * film::layers::MAX_CHANNELS as u64)
}

/// What a scene uses, and what is asked for besides.
pub(super) fn with_settings(scene: SceneFeatures, settings: &RenderSettings) -> SceneFeatures {
    let (layers, method) = (&settings.layers, settings.method);
    SceneFeatures {
        energy_compensation: settings.energy_compensation,
        film_layers: layers.record_words() > 0,
        splits_light: layers.split_light(),
        catches_shadows: layers.catch_shadows(),
        node_layers: layers.nodes().len() as u32,
        light_cache: method.has_light_cache(),
        irradiance_cache: method.has_records(),
        photons: method.has_photons(),
        ..scene
    }
}

/// Bytes of the paths under way: a device with lanes has as much for each of them, and once more for what runs beside.
fn paths(device: &Device, procedural: &Procedural, settings: &RenderSettings) -> u64 {
    let layers = &settings.layers;
    let schedule = Wavefront;
    let capacity = Lanes::capacity(device, &schedule, most_paths(device, settings));
    let asked = with_settings(SceneFeatures::default(), settings);
    let results = procedural
        .result_words()
        .max(node_words(layers.nodes().len()));
    let path = PathBytes::new(results + asked.path_words()).total();
    let recorded = 4 * u64::from(layers.record_words());
    let wave = u64::from(capacity) * (path + recorded) + 4 * QUEUE_HEADER;
    wave * (1 + Lanes::number(device, &schedule))
}
