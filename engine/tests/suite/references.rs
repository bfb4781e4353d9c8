//! Whole pictures against references that another renderer (Mitsuba 3) converged, on scenes that any glTF renderer can
//! load: camera, geometry, materials, lights and the transport between them, judged as statistics.
//!
//! A short run renders with larger pixels and compares with the reference averaged down to them; with `PATINA_FULL`
//! the picture has the reference's own resolution.

use std::path::Path;

use ::device::Device;
use engine::load::load;
use engine::renderer::{RenderSettings, Renderer};
use glam::{Vec2, Vec3};

use crate::support::estimate::Estimate;
use crate::support::stats::{Comparison, ZTest};
use crate::support::{device, shared};

/// At most this many vertices scatter, as the references' READMEs say.
const MAX_DEPTH: u32 = 9;
/// Share of the pixels that must pass, in all of their channels. Chance alone lets 99.86 % pass.
const PASSING: f64 = 0.995;
/// How far the mean of a channel may be off, relative.
const MEAN_ERROR: f64 = 0.005;

/// The size of a run.
#[derive(Clone, Copy)]
struct Effort {
    /// So many pixels of the reference, along a side, become one.
    block: usize,
    /// Samples of each pixel.
    spp: u32,
}

/// Renders a reference's scene, with the first effort or in full runs the second, and compares the pixels that `counts`
/// accepts: given are a pixel's upper left corner and its side in units of the picture's height.
fn compare(
    name: &str,
    reference: &str,
    efforts: [Effort; 2],
    counts: impl Fn(Vec2, f32) -> bool,
) -> Option<Comparison> {
    let dir = shared::find(&format!("reference/{name}"))?;
    let device = device::open()?;
    let effort = efforts[usize::from(device::full_run())];
    let reference = Estimate::from_exr(
        &dir.join(format!("{reference}.exr")),
        &dir.join(format!("{reference}_stderr.exr")),
    )
    .downsampled(effort.block);
    let scene = ["scene.glb", "cornell.glb"].map(|file| dir.join(file));
    let scene = scene.iter().find(|file| file.exists());
    let scene = scene.expect("every reference has its scene beside it");
    let tested = render(
        &device,
        scene,
        (reference.width, reference.height),
        effort.spp,
    );
    let side = 1.0 / reference.height as f32;
    Some(ZTest::default().compare(tested, reference, |x, y| {
        counts(Vec2::new(x as f32, y as f32) * side, side)
    }))
}

fn render(device: &Device, scene: &Path, (width, height): (usize, usize), spp: u32) -> Estimate {
    let loaded = load(scene, None, &[]).unwrap_or_else(|error| panic!("{error}"));
    let settings = RenderSettings {
        max_depth: MAX_DEPTH,
        // The references have none.
        energy_compensation: false,
        ..RenderSettings::new(width as u32, height as u32, &loaded.camera)
    };
    let mut renderer = Renderer::new(device, &loaded.scene, &loaded.procedural, &settings)
        .unwrap_or_else(|error| panic!("{error}"));
    renderer
        .render(spp)
        .unwrap_or_else(|error| panic!("{error}"));
    let stats = renderer.stats().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(stats.invalid_samples, 0, "every sample is a number");
    Estimate::from_film(&renderer.film().unwrap_or_else(|error| panic!("{error}")))
}

#[test]
fn cornell_box() {
    // The metal sphere of this reference, and only of this one, has separable Smith masking. Ours is glTF's
    // height-correlated one, which reflects up to 3 % more at grazing angles: pixels that see the sphere don't count.
    // What it reflects onto the other objects differs by far less than the noise and does count.
    let efforts = [Effort { block: 8, spp: 512 }, Effort { block: 1, spp: 512 }];
    if let Some(comparison) = compare("cornell", "ref_mitsuba", efforts, |corner, side| {
        !sees_cornell_sphere(corner, side)
    }) {
        comparison.assert_matches("cornell", PASSING, MEAN_ERROR);
    }
}

/// Whether a ray through a pixel of the Cornell box meets the bounding sphere of the metal sphere (which is a mesh
/// inside it): numbers from the reference's README.
fn sees_cornell_sphere(corner: Vec2, side: f32) -> bool {
    let (eye, half_height) = (Vec3::new(0.0, 0.0, 3.9), (0.5 * 0.686_048_8_f32).tan());
    let (center, radius) = (Vec3::new(0.52, -0.65, 0.35), 0.35);
    points(corner, side).any(|point| {
        let plane = (2.0 * point - 1.0) * half_height;
        let direction = Vec3::new(plane.x, -plane.y, -1.0).normalize();
        (center - eye).cross(direction).length() <= radius
    })
}

/// Corners of a pixel, middles of its sides and its centre: what is seen is far larger.
fn points(corner: Vec2, side: f32) -> impl Iterator<Item = Vec2> {
    (0..9).map(move |i| corner + 0.5 * side * Vec2::new((i % 3) as f32, (i / 3) as f32))
}

fn whole_picture(name: &str, block: usize, spp: u32) {
    whole_picture_of(name, "ref_mitsuba", block, spp);
}

fn whole_picture_of(name: &str, reference: &str, block: usize, spp: u32) {
    let efforts = [Effort { block, spp }, Effort { block: 1, spp: 512 }];
    if let Some(comparison) = compare(name, reference, efforts, |_, _| true) {
        comparison.assert_matches(name, PASSING, MEAN_ERROR);
    }
}

#[test]
fn image_based_light() {
    let efforts = [Effort { block: 2, spp: 256 }, Effort { block: 1, spp: 512 }];
    if let Some(whole) = compare("envlit", "ref_mitsuba", efforts, |_, _| true) {
        whole.assert_matches("envlit", PASSING, MEAN_ERROR);
        // The surroundings, sharp details without any other noise.
        let (tested, reference) = (whole.tested().clone(), whole.reference().clone());
        let side = 1.0 / reference.height as f32;
        let background = ZTest::default().compare(tested, reference, |x, y| {
            sees_environment(Vec2::new(x as f32, y as f32) * side, side)
        });
        background.assert_matches("envlit's background", PASSING, MEAN_ERROR);
    }
}

/// Whether nothing but the environment is seen through a pixel of `envlit`: numbers from the reference's README.
fn sees_environment(corner: Vec2, side: f32) -> bool {
    let eye = Vec3::new(0.4, 1.7, 5.2);
    let back = (eye - Vec3::new(0.0, 0.62, 0.0)).normalize();
    let right = Vec3::Y.cross(back).normalize();
    let half_height = 25_f32.to_radians().tan();
    let spheres = [
        Vec3::new(-1.6, 0.7, 0.0),
        Vec3::new(0.0, 0.7, 0.5),
        Vec3::new(1.6, 0.7, 0.0),
    ];
    points(corner, side).all(|point| {
        let plane = (2.0 * point - 1.0) * half_height;
        let direction = right * plane.x - back.cross(right) * plane.y - back;
        let ground = eye - direction * (eye.y / direction.y);
        let meets_floor = direction.y < 0.0 && ground.x.abs().max(ground.z.abs()) <= 4.0;
        let direction = direction.normalize();
        let meets = |center: &Vec3| (*center - eye).cross(direction).length() <= 0.7;
        !meets_floor && !spheres.iter().any(meets)
    })
}

#[test]
fn glass_that_refracts() {
    // Fresnel's equations in Schlick's approximation, as glTF has it.
    whole_picture_of("glass", "ref_mitsuba_schlick", 4, 256);
}

#[test]
fn instances_with_any_transform() {
    whole_picture("instances", 4, 256);
}

#[test]
fn cut_out_leaves_and_normal_maps() {
    whole_picture("cutout", 4, 256);
}

#[test]
fn punctual_lights() {
    whole_picture("punctual", 4, 256);
}
