//! A picture whose error is known: mean and standard error of every pixel and channel.

use std::path::Path;

use engine::film::Film;
use glam::{DVec3, Vec2, Vec3};

/// Mean and standard error per pixel, linear RGB, row 0 on top.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    /// Pixels.
    pub(crate) width: usize,
    /// Pixels.
    pub(crate) height: usize,
    /// Estimated radiance.
    pub(crate) mean: Vec<[f32; 3]>,
    /// Its standard error.
    pub(crate) error: Vec<[f32; 3]>,
}

impl Estimate {
    /// What a film has gathered.
    pub(crate) fn from_film(film: &Film) -> Self {
        Self {
            width: film.width as usize,
            height: film.height as usize,
            mean: film.mean(),
            error: film.standard_error(),
        }
    }

    /// A picture that is known: `radiance` at points of the picture, in 0 to 1 from its upper left corner, averaged
    /// over 8 x 8 points in each pixel. It has no error.
    pub(crate) fn exact((width, height): (u32, u32), radiance: impl Fn(Vec2) -> Vec3) -> Self {
        const POINTS: u32 = 8;
        let size = Vec2::new(width as f32, height as f32);
        let pixel = |i: u32| -> [f32; 3] {
            let corner = Vec2::new((i % width) as f32, (i / width) as f32);
            let sum = (0..POINTS * POINTS).fold(DVec3::ZERO, |sum, k| {
                let inside = Vec2::new((k % POINTS) as f32, (k / POINTS) as f32) + 0.5;
                sum + radiance((corner + inside / POINTS as f32) / size).as_dvec3()
            });
            (sum / f64::from(POINTS * POINTS)).as_vec3().to_array()
        };
        Self {
            width: width as usize,
            height: height as usize,
            mean: (0..width * height).map(pixel).collect(),
            error: vec![[0.0; 3]; (width * height) as usize],
        }
    }

    /// A reference kept as two EXR files.
    ///
    /// # Panics
    /// A file is missing, has no R, G and B, or the sizes differ: the test data is broken.
    pub(crate) fn from_exr(mean: &Path, error: &Path) -> Self {
        let (width, height, mean) = read_exr(mean);
        let (error_width, error_height, error) = read_exr(error);
        assert_eq!((width, height), (error_width, error_height));
        Self {
            width,
            height,
            mean,
            error,
        }
    }

    /// Blocks of `side` x `side` pixels averaged into one: with a box filter of one pixel in both, exactly what a
    /// render with fewer and larger pixels estimates. The pixels' errors are independent.
    ///
    /// # Panics
    /// The sides are no multiples of `side`.
    pub(crate) fn downsampled(&self, side: usize) -> Self {
        assert_eq!((self.width % side, self.height % side), (0, 0));
        let (width, height) = (self.width / side, self.height / side);
        let count = (side * side) as f64;
        let block = |i: usize, c: usize, values: &[[f32; 3]], power: i32| -> f64 {
            let (x, y) = (i % width * side, i / width * side);
            let pixels = (0..side * side).map(|k| (y + k / side) * self.width + x + k % side);
            pixels.map(|p| f64::from(values[p][c]).powi(power)).sum()
        };
        let pixels = 0..width * height;
        Self {
            width,
            height,
            mean: pixels
                .clone()
                .map(|i| std::array::from_fn(|c| (block(i, c, &self.mean, 1) / count) as f32))
                .collect(),
            error: pixels
                .map(|i| {
                    std::array::from_fn(|c| (block(i, c, &self.error, 2).sqrt() / count) as f32)
                })
                .collect(),
        }
    }
}

/// Width, height and RGB of an EXR file's first layer.
///
/// # Panics
/// The file can't be read or has no R, G and B.
pub(crate) fn read_exr(path: &Path) -> (usize, usize, Vec<[f32; 3]>) {
    let picture = exr::prelude::read_first_flat_layer_from_file(path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let layer = picture.layer_data;
    let channel = |name: &str| {
        layer
            .channel_data
            .list
            .iter()
            .find(|channel| channel.name.eq_case_insensitive(name))
            .unwrap_or_else(|| panic!("{}: no channel {name}", path.display()))
            .sample_data
            .values_as_f32()
    };
    let rgb = channel("R").zip(channel("G")).zip(channel("B"));
    let rgb = rgb.map(|((r, g), b)| [r, g, b]).collect();
    (layer.size.0, layer.size.1, rgb)
}
