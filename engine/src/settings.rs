//! What is rendered and how: the settings of a render that are neither scene nor texture.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

use crate::film::{Crop, Layers};
use crate::filter::PixelFilter;
use crate::scene::Camera;

/// [`RenderSettings::paths_ahead`] unless something else is wanted: few light samples arrive through a small window, and of what cells are
/// wrong about all records are.
pub const PATHS_AHEAD: u32 = 1 << 20;

/// What is rendered and how. [`RenderSettings::new`] gives every setting a sensible value.
#[derive(Debug, Clone)]
pub struct RenderSettings {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Where these columns and rows lie in a larger picture, of which nothing else is rendered; `None` where they are all. They get
    /// the samples that they have there, by [`Method::Path`] to the last bit.
    pub crop: Option<Crop>,
    /// At most this many surface vertices scatter along a path; 1 is direct light only.
    pub max_depth: u32,
    /// Of the random numbers: same seed, same device, same picture.
    pub seed: u32,
    /// From where.
    pub camera: Camera,
    /// Rough surfaces give back the light that microfacets scatter more than once. Without it they are darker, as in
    /// renderers that leave it out.
    pub energy_compensation: bool,
    /// Where in the sequence of each pixel's samples the picture begins. A picture of samples 0 to 10 and one of
    /// samples 10 to 64 add up to that of samples 0 to 64: see [`crate::film::Film::add`].
    pub first_sample: u32,
    /// Number of the sample with which the moment of an open shutter begins that is shown: what is known of its light grows from there on.
    pub moment_since: u32,
    /// How a pixel weighs the light around its centre.
    pub filter: PixelFilter,
    /// Width of the filter from edge to edge, pixels.
    pub filter_width: f32,
    /// Most that one contribution of indirect light may add to a sample: the largest of red, green and blue; the colour is
    /// kept. Indirect is what has been scattered by two surfaces or more. Takes fireflies out of a picture and light with
    /// them: with it, rendering is *biased*.
    pub clamp: Option<f32>,
    /// How light is found. The picture is the same but for its noise.
    pub estimator: Estimator,
    /// Russian roulette: whether dark paths may end early. The picture is the same but for its noise.
    pub roulette: bool,
    /// Where random numbers come from.
    pub sampler: Sampler,
    /// Whether samples come in two halves whose random numbers have nothing in common, so that the film knows its error rightly
    /// instead of rather too large; where no samples are left out between them. A smooth picture has a little more noise for it. So does what
    /// caches know of the light, each half of the samples with its own.
    pub halves: bool,
    /// How light that is scattered more than once is found.
    pub method: Method,
    /// The picture that this one is a piece of, to be rendered one after the other by one renderer, where it is one. What is known of the
    /// light is found out as the camera sees the whole of it, and there are as many photons as it needs.
    pub piece_of: Option<Divided>,
    /// How often what records of irradiance may be wrong by is halved, for [`Method::Cache`].
    pub refinement: u32,
    /// Paths of which caches learn before a picture with records begins, about, and more in large pictures; a quarter for one without. With
    /// fewer it begins sooner, and records differ more from what they should be.
    pub paths_ahead: u32,
    /// Most paths that are under way at once, where the device would want more; each takes some hundred bytes. The picture doesn't depend on it.
    pub largest_wave: u32,
    /// What the film gathers; the picture doesn't depend on it.
    pub layers: Layers,
    /// Seconds, which textures read as `Time`.
    pub time: f32,
    /// Number of the picture in a sequence, which textures read as `FrameIndex`.
    pub frame_index: u32,
    /// How the scene is beside the picture's moment, for the film's layer `vector`; `None` where nothing moves.
    pub beside: Option<Arc<Beside>>,
}

/// A picture that is rendered in pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Divided {
    /// Columns and rows, pixels.
    pub size: [u32; 2],
    /// Where it lies, if it is a part of a picture itself.
    pub crop: Option<Crop>,
}

/// A scene one frame before, and one frame after.
#[derive(Debug, Clone)]
pub struct Beside {
    /// From where it is seen then. What the camera shows of it, its projection, is that of the picture.
    pub cameras: [Camera; 2],
    /// Where its instances are then, in the order of the scene's.
    pub transforms: [Vec<Affine3A>; 2],
    /// Where the vertices of meshes that bend are then, object space, metres; nothing of other meshes. In the order of the scene's.
    pub positions: [Vec<Vec<Vec3>>; 2],
}

/// Where random numbers come from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Sampler {
    /// Owen-scrambled Sobol points, which fill each pixel's domain evenly however many there are.
    #[default]
    Sobol,
    /// Independent random numbers: more noise, and no order that an integrand could be at odds with.
    Independent,
}

impl Sampler {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Sobol, Self::Independent];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sobol => "sobol",
            Self::Independent => "independent",
        }
    }
}

/// How light that is scattered more than once is found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Method {
    /// By paths that go on until they end by chance: right on average.
    #[default]
    Path,
    /// By paths that end in a cache of what surfaces scatter, which others have taught before: faster, with less noise, and *biased*.
    Draft,
    /// Where surfaces scatter it diffusely, from a cache of irradiance that is made before the picture begins: with hardly any noise, and
    /// *biased*. Else by paths.
    Cache,
    /// Where mirrors and bodies of glass throw it on surfaces that scatter it diffusely, by photons from the lamps, with radii that shrink
    /// from sample to sample: *biased*, but less and less. Else by paths.
    Photons,
    /// Both: what is scattered diffusely from the cache, to which photons bring caustics, seen by way of other surfaces; those on the first
    /// ones are brought by photons of each sample.
    CachePhotons,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Path,
        Self::Draft,
        Self::Cache,
        Self::Photons,
        Self::CachePhotons,
    ];

    /// Whether paths end in a cache of the light that surfaces scatter.
    pub fn has_light_cache(self) -> bool {
        self == Self::Draft || self.has_records()
    }

    /// Whether there are records of irradiance.
    pub fn has_records(self) -> bool {
        matches!(self, Self::Cache | Self::CachePhotons)
    }

    /// Whether photons bring caustics.
    pub fn has_photons(self) -> bool {
        matches!(self, Self::Photons | Self::CachePhotons)
    }

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Draft => "draft",
            Self::Cache => "cache",
            Self::Photons => "photons",
            Self::CachePhotons => "cache+photons",
        }
    }
}

/// How light is found at a surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Estimator {
    /// By samples of lights and by scattered rays, balanced by multiple importance sampling (Veach 1997).
    #[default]
    Mis,
    /// By scattered rays alone, but for lights that have no extent.
    Bsdf,
    /// By samples of lights alone, as far as they can be sampled.
    Lights,
}

impl Estimator {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Mis, Self::Bsdf, Self::Lights];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mis => "mis",
            Self::Bsdf => "bsdf",
            Self::Lights => "lights",
        }
    }
}

impl RenderSettings {
    /// Columns and rows of the picture that the camera sees.
    pub fn whole(&self) -> [u32; 2] {
        self.crop
            .map_or([self.width, self.height], |crop| crop.whole)
    }

    /// A picture of `width` x `height` pixels: nine vertices at most, seed 0, from the first sample on,
    /// a box of one pixel as filter, no layers beside it.
    pub fn new(width: u32, height: u32, camera: &Camera) -> Self {
        Self {
            width,
            height,
            crop: None,
            max_depth: 9,
            seed: 0,
            camera: camera.clone(),
            energy_compensation: true,
            first_sample: 0,
            moment_since: 0,
            filter: PixelFilter::Box,
            filter_width: PixelFilter::Box.default_width(),
            clamp: None,
            estimator: Estimator::Mis,
            roulette: true,
            sampler: Sampler::Sobol,
            halves: false,
            method: Method::Path,
            piece_of: None,
            refinement: 0,
            paths_ahead: PATHS_AHEAD,
            largest_wave: u32::MAX,
            layers: Layers::default(),
            time: 0.0,
            frame_index: 0,
            beside: None,
        }
    }
}
