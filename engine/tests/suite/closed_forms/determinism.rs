//! Same seed, same device, same picture: to the last bit, however the work is cut into waves. Another kind of device takes
//! the same paths, and differs in last bits only.

use ::device::{Device, DeviceChoice};
use engine::film::Film;
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

fn renderer(device: &Device, scene: &mut Scene, capacity: u32, seed: u32) -> Renderer {
    renderer_from(device, scene, capacity, seed, 0)
}

fn renderer_from(
    device: &Device,
    scene: &mut Scene,
    capacity: u32,
    seed: u32,
    first_sample: u32,
) -> Renderer {
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
    settings.first_sample = first_sample;
    let procedural = no_textures(scene);
    Renderer::with_capacity(device, scene, &procedural, &settings, capacity)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn film(renderer: &mut Renderer, spp: u32) -> Film {
    renderer
        .render(spp)
        .unwrap_or_else(|error| panic!("{error}"));
    renderer.film().unwrap_or_else(|error| panic!("{error}"))
}

fn is_same(a: &Film, b: &Film) -> bool {
    a == b
}

#[test]
fn the_picture_does_not_depend_on_how_the_work_is_cut() {
    let Some(device) = device::open() else { return };
    let mut scene = varied_scene();
    let whole = film(&mut renderer(&device, &mut scene, 1 << 16, 5), 20);
    assert!(whole.sample_bounds() == (20, 20));
    // Waves of less than a sample per pixel.
    let in_parts = film(&mut renderer(&device, &mut scene, 320, 5), 20);
    assert!(is_same(&whole, &in_parts), "smaller waves");

    let mut resumed = renderer(&device, &mut scene, 1 << 12, 5);
    film(&mut resumed, 7);
    assert!(is_same(&whole, &film(&mut resumed, 20)), "resumed");
    resumed.restart();
    assert!(is_same(&whole, &film(&mut resumed, 20)), "started anew");
}

#[test]
fn parts_add_up_to_exactly_the_whole() {
    let Some(device) = device::open() else { return };
    let mut scene = varied_scene();
    let whole = film(&mut renderer(&device, &mut scene, 1 << 16, 5), 64);
    // Uneven parts, in any order, in waves of any size.
    let parts = [
        (23, 41, 1 << 16),
        (0, 1, 1 << 12),
        (7, 16, 640),
        (1, 6, 1 << 14),
    ];
    let mut merged = Film::new(whole.width, whole.height);
    for (first, count, capacity) in parts {
        let part = film(
            &mut renderer_from(&device, &mut scene, capacity, 5, first),
            count,
        );
        assert!(!is_same(&merged, &whole));
        merged.add(&part);
    }
    assert!(is_same(&merged, &whole));
}

#[test]
fn processors_render_the_picture_of_a_driver() {
    let Some(device) = device::open_driver() else {
        return;
    };
    let native = DeviceChoice::Name("native".to_owned());
    let native = Device::open(&native).unwrap_or_else(|error| panic!("{error}"));
    let mut scene = varied_scene();
    let [one, other] = [&device, &native].map(|device| {
        let mut renderer = renderer(device, &mut scene, 1 << 14, 5);
        film(&mut renderer, 16)
    });
    let sum = |film: &Film| film.mean().as_flattened().iter().sum::<f32>();
    let apart: Vec<(f32, f32)> = (one.mean().into_iter().zip(other.mean()))
        .map(|(a, b)| {
            let apart = (0..3).map(|i| (a[i] - b[i]).abs()).sum::<f32>();
            (apart, a.iter().sum())
        })
        .collect();
    let same = apart.iter().filter(|(apart, of)| *apart <= 1e-3 * of);
    let same = same.count() as f64 / apart.len() as f64;
    let total = apart.iter().map(|(apart, _)| apart).sum::<f32>() / sum(&one);
    eprintln!("{same} of the pixels are the same, {total} of the light is elsewhere");
    // Where a number is next to a threshold, rounding sends a path another way.
    assert!(same > 0.99 && total < 1e-3, "{same}, {total}");
}

#[test]
fn another_seed_gives_other_noise() {
    let Some(device) = device::open() else { return };
    let mut scene = varied_scene();
    let one = film(&mut renderer(&device, &mut scene, 1 << 14, 1), 4);
    let other = film(&mut renderer(&device, &mut scene, 1 << 14, 2), 4);
    let different = (0..one.pixels()).filter(|&pixel| one.sum(pixel) != other.sum(pixel));
    assert!(different.count() > one.pixels() / 2);
}
