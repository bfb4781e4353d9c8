//! Same seed, same device, same picture: to the last bit, however the work is cut into waves.

use engine::film::Film;
use engine::gpu::Gpu;
use engine::renderer::Renderer;
use engine::scene::{AlphaMode, Material, Scene};
use glam::Vec3;

use crate::support::device;
use crate::support::scenes::{
    Shot, camera, faceted_sphere, floor, lambert, lamp, no_textures, quad, scene, settings,
};

/// A bit of everything that draws random numbers.
fn varied_scene() -> Scene {
    let veil = Material {
        alpha_mode: AlphaMode::Blend,
        base_color: Vec3::new(0.9, 0.3, 0.1).extend(0.5),
        ..lambert(Vec3::ONE)
    };
    let metal = Material {
        roughness: 0.3,
        ..Material::default()
    };
    let lamp_above = quad(Vec3::new(-0.5, 3.0, -0.5), Vec3::X, Vec3::Z);
    scene(
        [
            (floor(4.0), lambert(Vec3::splat(0.7))),
            (faceted_sphere(12), metal),
            (lamp_above, lamp(Vec3::splat(6.0))),
            (
                quad(Vec3::new(-2.0, 0.0, 1.5), Vec3::X * 2.0, Vec3::Y),
                veil,
            ),
        ],
        Vec3::new(0.1, 0.2, 0.3),
    )
}

fn renderer(gpu: &Gpu, scene: &mut Scene, capacity: u32, seed: u32) -> Renderer {
    let camera = camera(
        Vec3::new(0.5, 2.0, 5.0),
        Vec3::Y * 0.3,
        Vec3::Y,
        engine::scene::Projection::Perspective { y_fov: 0.9 },
    );
    // No multiple of the blocks of eight pixels.
    let shot = Shot {
        size: (37, 21),
        max_depth: 6,
        spp: 0,
    };
    let mut settings = settings(&camera, shot);
    settings.seed = seed;
    let procedural = no_textures(scene);
    Renderer::with_capacity(gpu, scene, &procedural, &settings, capacity)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn film(renderer: &mut Renderer, spp: u32) -> Film {
    renderer
        .render(spp)
        .unwrap_or_else(|error| panic!("{error}"));
    renderer.film().unwrap_or_else(|error| panic!("{error}"))
}

fn is_same(a: &Film, b: &Film) -> bool {
    a.samples == b.samples && a.sum == b.sum && a.sum_squares == b.sum_squares
}

#[test]
fn the_picture_does_not_depend_on_how_the_work_is_cut() {
    let Some(gpu) = device::open() else { return };
    let mut scene = varied_scene();
    let whole = film(&mut renderer(&gpu, &mut scene, 1 << 16, 5), 20);
    assert!(whole.samples.iter().all(|&samples| samples == 20));
    // Waves of less than a sample per pixel.
    let in_parts = film(&mut renderer(&gpu, &mut scene, 320, 5), 20);
    assert!(is_same(&whole, &in_parts), "smaller waves");

    let mut resumed = renderer(&gpu, &mut scene, 1 << 12, 5);
    film(&mut resumed, 7);
    assert!(is_same(&whole, &film(&mut resumed, 20)), "resumed");
    resumed.restart();
    assert!(is_same(&whole, &film(&mut resumed, 20)), "started anew");
}

#[test]
fn another_seed_gives_other_noise() {
    let Some(gpu) = device::open() else { return };
    let mut scene = varied_scene();
    let one = film(&mut renderer(&gpu, &mut scene, 1 << 14, 1), 4);
    let other = film(&mut renderer(&gpu, &mut scene, 1 << 14, 2), 4);
    let different = one.sum.iter().zip(&other.sum).filter(|(a, b)| a != b);
    assert!(different.count() > one.sum.len() / 2);
}
