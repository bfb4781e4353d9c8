//! How fast pictures get better: Sobol points against random numbers, and against the number of samples.

use ::device::Device;
use engine::scene::{Material, Projection, Scene};
use engine::settings::Sampler;
use glam::Vec3;

use crate::support::device::{self, full_run};
use crate::support::scenes::{
    Shot, camera, floor, lambert, lamp, no_textures, quad, render_with, scene, settings,
};

/// A floor under a lamp that a board half hides.
fn soft_shadow() -> Scene {
    scene(
        [
            (floor(3.0), lambert(Vec3::splat(0.8))),
            (
                quad(Vec3::new(-0.6, 2.5, -0.6), Vec3::X * 1.2, Vec3::Z * 1.2),
                lamp(Vec3::splat(8.0)),
            ),
            (
                quad(Vec3::new(-0.5, 1.0, 0.5), Vec3::X, Vec3::NEG_Z),
                Material {
                    double_sided: true,
                    ..lambert(Vec3::splat(0.5))
                },
            ),
        ],
        Vec3::ZERO,
    )
}

fn picture(
    device: &Device,
    sampler: Sampler,
    max_depth: u32,
    spp: u32,
    seed: u32,
) -> Vec<[f32; 3]> {
    let camera = camera(
        Vec3::new(0.0, 2.0, 4.0),
        Vec3::new(0.0, 0.2, 0.0),
        Vec3::Y,
        Projection::Perspective { y_fov: 0.7 },
    );
    let shot = Shot {
        size: (24, 16),
        max_depth,
        spp,
    };
    let mut settings = settings(&camera, shot);
    settings.sampler = sampler;
    settings.seed = seed;
    let mut scene = soft_shadow();
    let procedural = no_textures(&mut scene);
    render_with(device, &scene, &procedural, &settings, spp).mean()
}

fn rmse(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let squares = a.iter().flatten().zip(b.iter().flatten());
    let sum: f64 = squares.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / (3 * a.len()) as f64).sqrt()
}

/// Error against a reference of another seed at 4, 16, 64 and 256 samples, and the slope of its logarithm.
fn errors(
    device: &Device,
    sampler: Sampler,
    max_depth: u32,
    reference: &[[f32; 3]],
) -> ([f64; 4], f64) {
    let errors =
        [4, 16, 64, 256].map(|spp| rmse(&picture(device, sampler, max_depth, spp, 0), reference));
    // Least squares over equal steps of the logarithm of 4.
    let logs = errors.map(|error| error.ln() / 4.0_f64.ln());
    let slope = (-1.5 * logs[0] - 0.5 * logs[1] + 0.5 * logs[2] + 1.5 * logs[3]) / 5.0;
    println!("{sampler:?}, depth {max_depth}: {errors:.6?}, N^{slope:.3}");
    (errors, slope)
}

#[test]
fn sobol_points_halve_the_noise_of_random_numbers() {
    let Some(device) = device::open() else { return };
    let depths = if full_run() { 1..=4 } else { 1..=1 };
    for max_depth in depths {
        let reference = picture(&device, Sampler::Sobol, max_depth, 2048, 7);
        let (sobol, slope) = errors(&device, Sampler::Sobol, max_depth, &reference);
        let (independent, plain_slope) =
            errors(&device, Sampler::Independent, max_depth, &reference);
        // Over a thousand values: chance moves an error by three hundredths, and a slope by less.
        assert!(slope <= -0.5, "N^{slope}");
        assert!((-0.55..=-0.45).contains(&plain_slope), "N^{plain_slope}");
        assert!(sobol[3] < independent[3], "{sobol:?} {independent:?}");
        if max_depth == 1 {
            assert!(
                sobol[3] <= 0.5 * independent[3],
                "{sobol:?} {independent:?}"
            );
        }
    }
}
