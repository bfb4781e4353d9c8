//! Photons: how the map of caustics is made for each sample of the picture.
//!
//! What mirrors and bodies of glass throw on other surfaces is found by paths from the camera only by luck, the smaller the lamp the
//! less; from the lamp it is easily found. So light that comes to a surface which scatters it diffusely is told apart (after Jensen,
//! "Global Illumination using Photon Maps", 1996): what *casters* alone have scattered since the lamp is brought by photons, all else by
//! paths. `brdf/leave.wgsl` says what a caster is, the same for both sides, so that no light counts twice and none is missing.
//!
//! Each sample of the picture has photons of its own. They start at lamps by how much light these send to casters, towards those
//! alone, and are kept where they arrive from one. Each path asks for those around its own places, within a radius that shrinks from
//! sample to sample, so that noise and bias vanish together (Hachisuka and Jensen, "Stochastic Progressive Photon Mapping", 2009; Knaus
//! and Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", 2011, whose radii need no statistics).
//!
//! Beside a cache of irradiance there is a map ahead of all samples, of which the cache learns what caustics light: what glass throws on a wall
//! that lights another one.
//!
//! A sample's photons follow from its number and the seed. Their flux is added up in whole numbers, so that the picture depends
//! neither on the order in which they come nor on how work is cut.

use device::{Device, DeviceError, Extent, Kernel, Recording, Resources, Usage};
use glam::Vec4;

use crate::{
    frame::paths_per_sample,
    gpu_scene::{MOST_TARGETS, SceneFeatures},
    passes::{
        pass::Pass,
        photons::{self as passes, Each, GRID, OCTREE, PhotonSettings},
    },
    settings::RenderSettings,
    wave,
};

use super::{Purpose, RenderError, Renderer, Work};

/// Photons of a sample: about as many as pixels, but no fewer and no more.
const FEWEST: u64 = 1 << 14;
const MOST: u64 = 1 << 20;
/// Cells of the grid, or of the octree, for each photon, and references.
const CELLS: u64 = 2;
const REFERENCES: u64 = 24;
/// Radius of the first sample's photons in widths of a pixel.
const FIRST_RADIUS: f64 = 3.0;
/// How much of the photons within the radius the next sample keeps: as the error falls fastest (Kaplanyan and Dachsbacher,
/// "Adaptive Progressive Photon Mapping", 2013).
const KEPT: f64 = 2.0 / 3.0;
/// Largest radius over the distance to the camera.
const WIDEST: f32 = 0.1;
/// Least distance to the camera that counts, over the radius of the scene.
const NEAREST: f32 = 0.01;
/// Added to the picture's seed.
const SEED: u32 = 0x7c0f_2e11;

/// What paths do with photons: as in `settings.wgsl`.
const IDLE: u32 = 0;
const USED: u32 = 1;

/// What is being done.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// Nothing is known of the lamps.
    Begun,
    /// Photons of a map fly; so many have.
    Flying(Map, u64),
    /// A map is there.
    Ready(Map),
}

/// What a map is for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Map {
    /// For a cache that is made before the picture.
    Ahead,
    /// For a sample of the picture.
    Sample(u32),
}

/// The photons of a renderer.
#[derive(Debug)]
pub(super) struct Photons {
    phase: Phase,
    sizes: Sizes,
    kernels: Vec<Kernel>,
}

/// How much room there is.
#[derive(Debug, Clone, Copy)]
struct Sizes {
    photons: u64,
    cells: u64,
    /// None where there is no octree.
    references: u64,
}

impl Sizes {
    fn of(device: &Device, settings: &RenderSettings) -> Self {
        let [width, height] = settings
            .piece_of
            .map_or([settings.width, settings.height], |whole| whole.size);
        let paths = paths_per_sample(width, height);
        // A power of two, which their sample points fill evenly.
        let photons = (1 << paths.max(1).ilog2()).clamp(FEWEST, MOST);
        Self {
            photons,
            cells: CELLS * photons,
            references: match passes::are_found_by_grid(device) {
                true => 0,
                false => REFERENCES * photons,
            },
        }
    }

    fn has_octree(&self) -> bool {
        self.references > 0
    }

    fn buffers(&self) -> [(&'static str, u64); 5] {
        let octree_cells = if self.has_octree() { self.cells } else { 0 };
        [
            ("photons_arrived", passes::bytes_of_photons(self.photons)),
            ("photons", passes::bytes_of_photons(self.photons)),
            ("photon_grid", passes::bytes_of_grid(self.cells)),
            ("photon_cells", passes::bytes_of_cells(octree_cells)),
            ("photon_references", 4 * self.references.max(1)),
        ]
    }
}

/// Bytes of the buffers.
pub(super) fn bytes(device: &Device, settings: &RenderSettings) -> u64 {
    match settings.method.has_photons() {
        true => {
            let buffers = Sizes::of(device, settings).buffers();
            buffers.iter().map(|(_, bytes)| bytes).sum()
        }
        false => 0,
    }
}

/// Radius of a sample's photons in widths of a pixel; the first sample is number 0.
fn radius(sample: u32) -> f64 {
    // The product of (i + a) / (i + 1) over i from 1 to n is nearly n^(a-1) times a constant.
    const EXACT: u32 = 256;
    let exact: f64 = (1..=sample.min(EXACT))
        .map(|i| (f64::from(i) + KEPT) / (f64::from(i) + 1.0))
        .product();
    let rest = (f64::from(sample.max(EXACT)) / f64::from(EXACT)).powf(KEPT - 1.0);
    FIRST_RADIUS * (exact * rest).sqrt()
}

/// Those that belong to no wave.
fn kernels(device: &Device, features: &SceneFeatures) -> Result<Vec<Kernel>, DeviceError> {
    let passes = passes::APART.iter();
    passes.map(|pass| pass.kernel(device, features)).collect()
}

impl Photons {
    /// Makes their buffers; nothing where the method has none.
    pub(super) fn new(
        device: &Device,
        settings: &RenderSettings,
        features: &SceneFeatures,
        resources: &mut Resources,
    ) -> Result<Option<Self>, DeviceError> {
        if !settings.method.has_photons() {
            return Ok(None);
        }
        let sizes = Sizes::of(device, settings);
        for (name, bytes) in sizes.buffers() {
            resources.set_buffer(name, device.buffer(name, Usage::Storage, bytes)?);
        }
        let lights = device.buffer("photon lights", Usage::Storage, 8)?;
        resources.set_buffer("photon_lights", lights);
        let bytes = size_of::<PhotonSettings>() as u64;
        let uniform = device.buffer("photon settings", Usage::Uniform, bytes)?;
        resources.set_buffer("photon_settings", uniform);
        Ok(Some(Self {
            phase: Phase::Begun,
            sizes,
            kernels: kernels(device, features)?,
        }))
    }

    /// Has the kernels of a scene with other features.
    pub(super) fn compile(
        &mut self,
        device: &Device,
        features: &SceneFeatures,
    ) -> Result<(), DeviceError> {
        self.kernels = kernels(device, features)?;
        Ok(())
    }

    /// Forgets the map.
    pub(super) fn restart(&mut self) {
        self.phase = Phase::Begun;
    }
}

impl Renderer {
    /// Takes a step towards the map for the next path; false where it is there, or isn't needed.
    pub(super) fn prepare_photons(&mut self) -> Result<bool, RenderError> {
        let Some(photons) = &self.photons else {
            return Ok(false);
        };
        if self.is_apart || !self.casts_caustics() {
            return Ok(false);
        }
        let map = self.next_map();
        let total = photons.sizes.photons;
        let done = match photons.phase {
            Phase::Ready(of) if of == map => return Ok(false),
            Phase::Flying(of, done) if of == map => done,
            phase => {
                if phase == Phase::Begun {
                    self.weigh_lights()?;
                }
                let mut recording = Recording::new("no photons");
                recording.clear(self.resources.buffer("photons_arrived"));
                self.device.start(&recording)?;
                0
            }
        };
        let paths = u64::from(self.next_wave_size()).min(total - done);
        let mut frame = self.frame_of_whole().without_lights();
        frame.set_seed(self.photon_seed(map));
        frame.set_wave(done, paths as u32, 0, u32::MAX);
        let work = Work::Range {
            position: done,
            first_sample: 0,
            spp: u32::MAX,
        };
        self.play_wave(&frame, work, Purpose::Photons)?;
        let mut phase = Phase::Flying(map, done + paths);
        if done + paths == total {
            self.build_map()?;
            phase = Phase::Ready(map);
        }
        if let Some(photons) = &mut self.photons {
            photons.phase = phase;
        }
        Ok(true)
    }

    /// As many of the next paths as are of one sample, where each has its own photons.
    pub(super) fn until_next_photons(&self, paths: u64) -> u64 {
        let padded = u64::from(self.frame.padded_pixels);
        match self.photons {
            Some(_) => paths.min(padded - self.position % padded),
            None => paths,
        }
    }

    /// Whether there is something that throws caustics, and light that it could throw.
    pub fn casts_caustics(&self) -> bool {
        let lights = self.scene.light_count + self.scene.directional_count;
        let is_lit = lights > 0 || self.sky_has_photons();
        is_lit && !self.scene.casters.is_empty() && self.scene.features.energy_compensation
    }

    /// Whether photons come from the environment. An even one is left to paths, which find its light by chance alone as easily.
    fn sky_has_photons(&self) -> bool {
        self.scene.environment.emits && !self.scene.environment.is_even
    }

    /// The map that the next path needs.
    fn next_map(&self) -> Map {
        if self.records_awaited().is_some() {
            return Map::Ahead;
        }
        let done = self.position / u64::from(self.frame.padded_pixels);
        Map::Sample(self.settings.first_sample + done as u32)
    }

    /// Whether the next wave asks for photons.
    fn uses_photons(&self, purpose: Purpose) -> bool {
        let photons = self.photons.as_ref();
        let is_there =
            photons.is_some_and(|photons| photons.phase == Phase::Ready(self.next_map()));
        let asks = matches!(
            purpose,
            Purpose::Picture | Purpose::Learn { .. } | Purpose::Gather { .. }
        );
        is_there && asks
    }

    /// The field of a path's state that is the photons' own, 0 where the next wave asks for none.
    pub(super) fn photon_field(&self, purpose: Purpose) -> u32 {
        match self.uses_photons(purpose) {
            true => self.photon_record(),
            false => 0,
        }
    }

    fn photon_record(&self) -> u32 {
        let record = match self.settings.method.has_light_cache() {
            true => wave::LIGHT_RECORD_WORDS,
            false => 0,
        };
        self.fields_from_last(wave::PHOTON_WORDS + record)
    }

    fn photon_seed(&self, map: Map) -> u32 {
        let seed = self.frame.seed().wrapping_add(SEED);
        let number = match map {
            Map::Ahead => u32::MAX,
            Map::Sample(sample) => sample,
        };
        // Neighbouring numbers must not give neighbouring seeds.
        seed.wrapping_add(number.wrapping_mul(0x9e37_79b9))
    }

    /// Finds out how many photons are to start at each lamp.
    fn weigh_lights(&mut self) -> Result<(), RenderError> {
        let lights = u64::from(self.scene.light_count + self.scene.directional_count) + 1;
        let bytes = 8 * lights + size_of_val(self.scene.media_of_lamps()) as u64;
        if self.resources.buffer("photon_lights").size() < bytes {
            let buffer = (self.device).buffer("photon lights", Usage::Storage, bytes)?;
            self.resources.set_buffer("photon_lights", buffer);
            self.bind();
        }
        let media = self.scene.media_of_lamps();
        let buffer = self.resources.buffer("photon_lights");
        if !media.is_empty() {
            (self.device).write(buffer, 8 * lights, bytemuck::cast_slice(media));
        }
        self.set_photons(Purpose::Photons);
        let frame = self.resources.buffer("frame");
        self.device.write(frame, 0, bytemuck::bytes_of(&self.frame));
        let threads = lights as u32;
        let steps = [
            (&passes::WEIGH, Extent::Threads(threads)),
            (&passes::SUM, Extent::One),
        ];
        self.play_apart("weights of lights", steps)
    }

    /// Makes the map of the photons that have arrived.
    fn build_map(&mut self) -> Result<(), RenderError> {
        let Some(sizes) = self.photons.as_ref().map(|photons| photons.sizes) else {
            return Ok(());
        };
        let threads = |of| match of {
            Each::Photon => Extent::Threads(sizes.photons as u32),
            Each::Cell => Extent::Threads(sizes.cells as u32),
        };
        let mut recording = Recording::new("no grid");
        recording.clear(self.resources.buffer("photon_grid"));
        self.device.start(&recording)?;
        let frame = self.resources.buffer("frame");
        self.device.write(frame, 0, bytemuck::bytes_of(&self.frame));
        self.play_apart(
            "grid of photons",
            GRID.map(|(pass, of)| (pass, threads(of))),
        )?;
        if !sizes.has_octree() {
            return Ok(());
        }
        // Roots of another size: those of before are of no use.
        let is_as_before = match self.next_map() {
            Map::Sample(sample) if sample > 0 && self.position > 0 => {
                radius(sample).log2().floor() == radius(sample - 1).log2().floor()
            }
            _ => false,
        };
        if !is_as_before {
            let mut recording = Recording::new("no octree");
            recording.clear(self.resources.buffer("photon_cells"));
            self.device.start(&recording)?;
        }
        self.play_apart(
            "octree of photons",
            OCTREE.map(|(pass, of)| (pass, threads(of))),
        )
    }

    /// Runs kernels that belong to no wave.
    fn play_apart<const N: usize>(
        &self,
        name: &'static str,
        steps: [(&'static Pass, Extent); N],
    ) -> Result<(), RenderError> {
        let Some(photons) = &self.photons else {
            return Ok(());
        };
        let mut recording = Recording::new(name);
        for (pass, extent) in steps {
            let at = passes::APART.iter().position(|one| one.name == pass.name);
            if let Some(kernel) = at.and_then(|at| photons.kernels.get(at)) {
                let bound = kernel.bind(&self.device, &self.resources);
                recording.dispatch(&bound, extent);
            }
        }
        Ok(self.device.play(&recording)?)
    }

    /// Says what the next wave does with photons.
    pub(super) fn set_photons(&self, purpose: Purpose) {
        let Some(photons) = &self.photons else {
            return;
        };
        let map = self.next_map();
        let pixel = match self.frame.pixel_side() {
            // Of parallel rays.
            0.0 => self.frame.pixel_height(),
            side => side,
        };
        let radius = match map {
            Map::Ahead => radius(0),
            Map::Sample(sample) => radius(sample),
        };
        let radius = radius as f32 * pixel;
        let mut targets = [Vec4::ZERO; MOST_TARGETS];
        targets[..self.scene.casters.len()].copy_from_slice(&self.scene.casters);
        let words = PhotonSettings {
            mode: match self.uses_photons(purpose) {
                true => USED,
                false => IDLE,
            },
            photons: photons.sizes.photons as u32,
            field: self.photon_record(),
            seed: self.photon_seed(map),
            radius: match self.frame.pixel_side() {
                0.0 => radius,
                _ => radius.min(WIDEST),
            },
            nearest: NEAREST * self.scene.radius,
            cell_mask: photons.sizes.cells as u32 - 1,
            references: photons.sizes.references as u32,
            light_count: self.scene.light_count,
            directional_count: self.scene.directional_count,
            environment: u32::from(self.sky_has_photons()),
            target_count: self.scene.casters.len() as u32,
            targets,
        };
        let uniform = self.resources.buffer("photon_settings");
        self.device.write(uniform, 0, bytemuck::bytes_of(&words));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_shrink_as_they_should() {
        assert_eq!(radius(0), FIRST_RADIUS);
        // Knaus and Zwicker, equation 17.
        let squared = |sample: u32| radius(sample).powi(2);
        for sample in [1, 7, 255, 256, 300, 5000] {
            let wanted = (f64::from(sample) + KEPT) / (f64::from(sample) + 1.0);
            let found = squared(sample) / squared(sample - 1);
            assert!((found - wanted).abs() < 1e-5, "{sample}: {found}");
        }
    }
}
