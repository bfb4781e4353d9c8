//! What is the same for every thread of a wave; the twin of `frame.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Vec3};

use crate::{
    filter::{FilterTable, PixelFilter},
    gpu_scene::GpuScene,
    scene::Projection,
    settings::{Estimator, RenderSettings, Sampler},
    sobol,
};

/// `Frame` in `frame.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Frame {
    camera_right: Vec3,
    width: u32,
    camera_up: Vec3,
    height: u32,
    camera_back: Vec3,
    blocks_x: u32,
    camera_position: Vec3,
    capacity: u32,
    half_height: f32,
    orthographic: u32,
    aperture_radius: f32,
    focus_distance: f32,
    /// Padded pixel of slot 0.
    pub first_pixel: u32,
    /// Sample of slot 0.
    pub first_sample: u32,
    /// Paths in this wave.
    pub wave_size: u32,
    /// Pixels of all blocks of 8 x 8.
    pub padded_pixels: u32,
    seed: u32,
    max_depth: u32,
    light_count: u32,
    environment_probability: f32,
    environment_scale: [f32; 3],
    environment_turn: f32,
    environment_size: [u32; 2],
    distribution_size: [u32; 2],
    bounds_center: Vec3,
    bounds_radius: f32,
    pixel_spread: f32,
    time: f32,
    /// No path with this sample or a later one starts.
    pub sample_limit: u32,
    user_image_base: u32,
    bounds_min: Vec3,
    frame_index: u32,
    bounds_max: Vec3,
    directional_count: u32,
    filter_radius: f32,
    filter_positive: f32,
    filter_weight: f32,
    filter_is_box: u32,
    indirect_clamp: f32,
    estimator: u32,
    roulette_start: u32,
    sampler: u32,
    aperture_blades: u32,
    aperture_rotation: f32,
    /// Columns in the low half, rows in the high one: where paths start, and where that ends.
    pub region_min: u32,
    /// See `region_min`; exclusive.
    pub region_max: u32,
    environment_group: u32,
    has_halves: u32,
    lot_samples: u32,
    /// Of the whole that the picture is a part of: column in the low half, row in the high one.
    crop_min: u32,
    crop_whole: u32,
    crop_blocks_x: u32,
    sky_cell_scale: f32,
    caches: u32,
    camera_media: [u32; 4],
    sobol: [[u32; 4]; sobol::ROWS],
    lot: [[u32; 2]; LOT_BLOCKS],
}

impl Frame {
    /// Byte offset of each member, for comparison with its WGSL twin.
    pub fn offsets() -> Vec<(&'static str, usize)> {
        macro_rules! offsets {
            ($($member:ident),* $(,)?) => { vec![$((stringify!($member), std::mem::offset_of!(Frame, $member))),*] };
        }
        offsets![
            camera_right,
            width,
            camera_up,
            height,
            camera_back,
            blocks_x,
            camera_position,
            capacity,
            half_height,
            orthographic,
            aperture_radius,
            focus_distance,
            first_pixel,
            first_sample,
            wave_size,
            padded_pixels,
            seed,
            max_depth,
            light_count,
            environment_probability,
            environment_scale,
            environment_turn,
            environment_size,
            distribution_size,
            bounds_center,
            bounds_radius,
            pixel_spread,
            time,
            sample_limit,
            user_image_base,
            bounds_min,
            frame_index,
            bounds_max,
            directional_count,
            filter_radius,
            filter_positive,
            filter_weight,
            filter_is_box,
            indirect_clamp,
            estimator,
            roulette_start,
            sampler,
            aperture_blades,
            aperture_rotation,
            region_min,
            region_max,
            environment_group,
            has_halves,
            lot_samples,
            crop_min,
            crop_whole,
            crop_blocks_x,
            sky_cell_scale,
            caches,
            camera_media,
            sobol,
            lot
        ]
    }
}

/// Bits of `caches`, as in `frame.wgsl`.
const CACHE_SKY: u32 = 1;
const CACHE_IRRADIANCE: u32 = 2;
const CACHE_GIVES: u32 = 4;
const CACHE_LEARNS: u32 = 8;
/// Vertices that scatter before Russian roulette begins.
const ROULETTE_START: u32 = 1;
/// Side of a cell in which the sky is known over its distance to the camera, before it is rounded down to a power of two: in a room,
/// half a metre.
const SKY_CELL_SCALE: f32 = 0.25;
/// Pixels along the side of a block.
pub(crate) const BLOCK: u32 = 8;
/// Pixels of a block.
pub(crate) const BLOCK_PIXELS: u32 = BLOCK * BLOCK;
/// Most blocks of a lot, so that the frame stays within the 64 KiB that every device can bind as a uniform.
pub(crate) const LOT_BLOCKS: usize = 4096;

/// Paths of one sample of every pixel of a picture, with those that fill up blocks at its border.
pub(crate) fn paths_per_sample(width: u32, height: u32) -> u64 {
    let blocks = |side: u32| u64::from(side.div_ceil(BLOCK));
    blocks(width) * blocks(height) * u64::from(BLOCK * BLOCK)
}

impl Frame {
    /// Whether light samples of the sky go where it is known to be seen.
    pub fn set_known_sky(&mut self, is_known: bool) {
        match is_known {
            true => self.caches |= CACHE_SKY,
            false => self.caches &= !CACHE_SKY,
        }
    }

    /// Whether it is known where the sky is seen.
    pub(crate) fn knows_sky(&self) -> bool {
        self.caches & CACHE_SKY != 0
    }

    /// Corners of a box around the scene.
    pub(crate) fn bounds(&self) -> [Vec3; 2] {
        [self.bounds_min, self.bounds_max]
    }

    /// Whether records of irradiance are there for the paths of a wave.
    pub(crate) fn set_records_given(&mut self, are_given: bool) {
        match are_given {
            true => self.caches |= CACHE_GIVES,
            false => self.caches &= !CACHE_GIVES,
        }
    }

    /// Whether nothing is made in a wave of what the first surface scatters.
    pub(crate) fn set_learns(&mut self, learns: bool) {
        match learns {
            true => self.caches |= CACHE_LEARNS,
            false => self.caches &= !CACHE_LEARNS,
        }
    }

    /// Share of the light samples that the environment gets where nothing is known.
    pub(crate) fn environment_probability(&self) -> f32 {
        self.environment_probability
    }

    /// Without a lens.
    pub(crate) fn set_pinhole(&mut self) {
        self.aperture_radius = 0.0;
    }

    /// Textures are seen as finely as in another picture.
    pub(crate) fn set_footprint(&mut self, of: &Self) {
        self.pixel_spread = of.pixel_spread;
    }

    /// Of the random numbers.
    pub(crate) fn seed(&self) -> u32 {
        self.seed
    }

    /// Other random numbers.
    pub(crate) fn set_seed(&mut self, seed: u32) {
        self.seed = seed;
    }

    /// Side of a pixel over its distance to the camera; 0 for parallel rays.
    pub(crate) fn pixel_side(&self) -> f32 {
        self.pixel_spread
    }

    /// Height of a pixel where rays are parallel, metres.
    pub(crate) fn pixel_height(&self) -> f32 {
        2.0 * self.half_height / (self.crop_whole >> 16).max(1) as f32
    }

    /// Nothing samples lights, no path ends by chance, and no light is taken away.
    pub(crate) fn without_lights(mut self) -> Self {
        (self.light_count, self.directional_count) = (0, 0);
        self.environment_probability = 0.0;
        self.roulette_start = u32::MAX;
        self.indirect_clamp = f32::MAX;
        self
    }

    /// Columns times rows.
    pub(crate) fn pixels(&self) -> u32 {
        self.width * self.height
    }

    /// For a picture of a scene. `capacity` is the number of path slots of a wave.
    pub fn new(settings: &RenderSettings, capacity: u32, scene: &GpuScene) -> Self {
        let (width, height) = (settings.width, settings.height);
        let [columns, rows] = settings.whole();
        let camera = &settings.camera;
        let filter = FilterTable::of(settings.filter);
        let blocks = (width.div_ceil(BLOCK), height.div_ceil(BLOCK));
        let axes = Mat3::from(camera.transform.matrix3);
        let (half_height, orthographic, pixel_spread) = match camera.projection {
            Projection::Perspective { y_fov } => {
                let half = (0.5 * y_fov).tan();
                (half, 0, 2.0 * half / rows as f32)
            }
            Projection::Orthographic { y_mag } => (y_mag, 1, 0.0),
        };
        let environment = &scene.environment;
        // An equal share of the samples for each kind of light that there is, as in `light_groups`.
        let others = u8::from(scene.light_count > 0) + u8::from(scene.directional_count > 0);
        let environment_probability = match environment.emits {
            false => 0.0,
            true => 1.0 / f32::from(1 + others),
        };
        Self {
            camera_right: axes.x_axis,
            width,
            camera_up: axes.y_axis,
            height,
            camera_back: axes.z_axis,
            blocks_x: blocks.0,
            camera_position: camera.transform.translation.into(),
            capacity,
            half_height,
            orthographic,
            aperture_radius: camera.aperture_radius,
            focus_distance: camera.focus_distance,
            first_pixel: 0,
            first_sample: 0,
            wave_size: 0,
            padded_pixels: paths_per_sample(width, height) as u32,
            seed: settings.seed,
            max_depth: settings.max_depth,
            light_count: scene.light_count,
            environment_probability,
            environment_scale: environment.scale,
            environment_turn: environment.turn,
            environment_size: environment.size,
            distribution_size: environment.table_size,
            bounds_center: scene.center,
            bounds_radius: scene.radius,
            pixel_spread,
            time: settings.time,
            sample_limit: 0,
            user_image_base: scene.user_image_base,
            bounds_min: scene.bounds[0],
            frame_index: settings.frame_index,
            bounds_max: scene.bounds[1],
            directional_count: scene.directional_count,
            filter_radius: 0.5 * settings.filter_width,
            filter_positive: filter.positive,
            filter_weight: filter.weight * filter.weight,
            filter_is_box: u32::from(settings.filter == PixelFilter::Box),
            indirect_clamp: settings.clamp.unwrap_or(f32::MAX),
            estimator: match settings.estimator {
                Estimator::Mis => 0,
                Estimator::Bsdf => 1,
                Estimator::Lights => 2,
            },
            roulette_start: match settings.roulette {
                true => ROULETTE_START,
                false => u32::MAX,
            },
            sampler: match settings.sampler {
                Sampler::Sobol => 0,
                Sampler::Independent => 1,
            },
            aperture_blades: camera.aperture_blades,
            aperture_rotation: camera.aperture_rotation,
            region_min: 0,
            region_max: u32::MAX,
            environment_group: scene.environment_group,
            has_halves: u32::from(settings.halves),
            lot_samples: 0,
            crop_min: settings.crop.map_or(0, |crop| crop.left | crop.top << 16),
            crop_whole: columns | rows << 16,
            crop_blocks_x: settings.crop.map_or(0, |_| columns.div_ceil(BLOCK)),
            sky_cell_scale: SKY_CELL_SCALE,
            camera_media: scene.bodies.around(camera.transform.translation.into()),
            caches: match settings.method.has_records() {
                true => CACHE_IRRADIANCE,
                false => 0,
            },
            sobol: sobol::nibbles(),
            lot: [[0; 2]; LOT_BLOCKS],
        }
    }

    /// Sets what a wave renders: `paths` paths of a picture whose first `position` ones are done, sample after sample from
    /// `first_sample` on, until each pixel has `spp`.
    pub fn set_wave(&mut self, position: u64, paths: u32, first_sample: u32, spp: u32) {
        let padded = u64::from(self.padded_pixels);
        self.first_pixel = (position % padded) as u32;
        self.first_sample = first_sample + (position / padded) as u32;
        self.wave_size = paths;
        self.sample_limit = first_sample + spp;
        self.lot_samples = 0;
    }

    /// Sets what a wave renders: so many samples of each of these blocks, at most [`LOT_BLOCKS`]; a block is its place in the
    /// picture, row by row, and the number of its first sample.
    pub(crate) fn set_lot(&mut self, blocks: &[[u32; 2]], samples: u32) {
        self.first_pixel = 0;
        self.first_sample = 0;
        self.padded_pixels = blocks.len() as u32 * BLOCK_PIXELS;
        self.wave_size = self.padded_pixels * samples;
        self.sample_limit = u32::MAX;
        self.lot_samples = samples;
        self.lot[..blocks.len()].copy_from_slice(blocks);
    }
}
