//! Pictures of different seeds are independent estimates, and so are the pixels of one.

use std::sync::Arc;

use ::device::Device;
use engine::scene::{Environment, FloatImage, Scene};
use engine::settings::Sampler;
use glam::Vec3;

use crate::support::device;
use crate::support::scenes::{
    Shot, floor, from_above, lambert, no_textures, render_with, scene, settings,
};

const SIDE: usize = 256;
const SEEDS: usize = 8;

/// A floor under a sky that is brighter at one side: every pixel shows the same radiance, and every sample errs.
fn even_floor() -> Scene {
    let (width, height) = (16, 8);
    let texel = |i: u32| [(1.0 + (i % width) as f32) / (1.0 + (i / width) as f32); 3];
    let mut scene = scene([(floor(3.0), lambert(Vec3::splat(0.8)))], Vec3::ZERO);
    scene.environment = Environment::Image {
        image: Arc::new(FloatImage {
            width,
            height,
            rgb: (0..width * height).map(texel).collect(),
        }),
        rotation: 0.0,
        intensity: 1.0,
    };
    scene
}

/// Errors of each pixel under consecutive seeds.
fn errors(device: &Device, sampler: Sampler) -> Vec<Vec<f64>> {
    let camera = from_above(2.0, 1.0);
    let shot = Shot {
        size: (SIDE as u32, SIDE as u32),
        max_depth: 1,
        spp: 2,
    };
    let mut scene = even_floor();
    let procedural = no_textures(&mut scene);
    let mut settings = settings(&camera, shot);
    settings.sampler = sampler;
    let mut pictures: Vec<Vec<f64>> = (0..SEEDS as u32)
        .map(|seed| {
            settings.seed = seed;
            let film = render_with(device, &scene, &procedural, &settings, shot.spp);
            film.mean().iter().map(|rgb| f64::from(rgb[0])).collect()
        })
        .collect();
    let mean = mean(&pictures.concat());
    pictures.iter_mut().flatten().for_each(|x| *x -= mean);
    pictures
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn squares(values: &[f64]) -> Vec<f64> {
    values.iter().map(|x| x * x).collect()
}

/// Standard error of the mean, relative to it.
fn relative_error(values: &[f64]) -> f64 {
    let mean = mean(values);
    let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64;
    (variance / values.len() as f64).sqrt() / mean
}

/// Correlation of a picture with another one whose pixels are swapped: `swap` is a mask of the pixels' numbers.
fn correlation(a: &[f64], b: &[f64], swap: usize) -> f64 {
    let products = (0..a.len()).map(|i| a[i] * b[i ^ swap]);
    let norm = (mean(&squares(a)) * mean(&squares(b))).sqrt();
    products.sum::<f64>() / a.len() as f64 / norm
}

#[test]
fn seeds_and_pixels_are_independent() {
    let Some(device) = device::open() else { return };
    for sampler in [Sampler::Sobol, Sampler::Independent] {
        let errors = errors(&device, sampler);
        // A bit of a column or a row is a bit of the number by which kernels know a pixel, too.
        let bits = (SIDE * SIDE).ilog2();
        let swaps: Vec<usize> = (0..bits).map(|bit| 1 << bit).chain([0]).collect();
        let mut largest: f64 = 0.0;
        for (i, a) in errors.iter().enumerate() {
            for (j, b) in errors.iter().enumerate().skip(i) {
                for &swap in swaps.iter().filter(|&&swap| i != j || swap != 0) {
                    let r = correlation(a, b, swap);
                    largest = largest.max(r.abs());
                    // Of 65,536 pixels chance makes it 0.004, and 0.02 in one of three million.
                    assert!(
                        r.abs() < 0.02,
                        "{sampler:?}: seeds {i}, {j}, {swap:#x}: {r}"
                    );
                }
            }
        }
        let average: Vec<f64> = (0..SIDE * SIDE)
            .map(|pixel| errors.iter().map(|e| e[pixel]).sum::<f64>() / SEEDS as f64)
            .collect();
        let (one, eight) = (squares(&errors.concat()), squares(&average));
        let gain = (mean(&one) / mean(&eight)).sqrt();
        let noise = 0.5 * relative_error(&one).hypot(relative_error(&eight));
        println!("{sampler:?}: largest correlation {largest:.4}, eight seeds gain {gain:.4}");
        let expected = (SEEDS as f64).sqrt();
        assert!(
            (gain / expected - 1.0).abs() < 4.0 * noise,
            "{sampler:?}: {gain}, expected {expected} within {noise} times it"
        );
    }
}
