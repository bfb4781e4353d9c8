//! All ways to find light agree: scattered rays alone, light samples alone and both balanced, with and without Russian
//! roulette, one render and merged parts, path length by path length; and a clamp takes away indirect light only.

use ::device::Device;
use engine::film::Film;
use engine::renderer::RenderSettings;
use engine::scene::{Projection, Scene};
use engine::settings::Estimator;
use glam::Vec3;

use super::{MEAN_ERROR, PASSING};
use crate::support::device;
use crate::support::estimate::Estimate;
use crate::support::scenes::{
    Shot, add, camera, faceted_sphere, floor, lambert, lamp, no_textures, quad, render_with, scene,
    settings,
};
use crate::support::stats::ZTest;

/// A box with a large lamp under a grey sky, and a glossy ball.
fn room() -> Scene {
    let wall = |corner, u, v, color| (quad(corner, u, v), lambert(color));
    let mut room = scene(
        [
            (floor(2.0), lambert(Vec3::splat(0.7))),
            wall(
                Vec3::new(-2.0, 0.0, -2.0),
                Vec3::X * 4.0,
                Vec3::Y * 3.0,
                Vec3::new(0.8, 0.5, 0.5),
            ),
            wall(
                Vec3::new(-2.0, 0.0, 2.0),
                Vec3::NEG_Z * 4.0,
                Vec3::Y * 3.0,
                Vec3::new(0.5, 0.8, 0.5),
            ),
            (
                quad(Vec3::new(-1.0, 2.9, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0),
                lamp(Vec3::new(4.0, 3.0, 2.0)),
            ),
        ],
        Vec3::splat(0.4),
    );
    let mut ball = faceted_sphere(10);
    for p in &mut ball.positions {
        *p = *p * 0.6 + Vec3::new(0.3, 0.6, 0.0);
    }
    let glossy = engine::scene::Material {
        roughness: 0.5,
        metallic: 0.0,
        base_color: Vec3::new(0.6, 0.6, 0.9).extend(1.0),
        ..Default::default()
    };
    add(&mut room, ball, glossy);
    room
}

fn view(
    device: &Device,
    scene: &mut Scene,
    max_depth: u32,
    spp: u32,
    change: impl Fn(&mut RenderSettings),
) -> Film {
    let camera = camera(
        Vec3::new(3.0, 2.0, 4.0),
        Vec3::new(0.0, 0.9, 0.0),
        Vec3::Y,
        Projection::Perspective { y_fov: 0.8 },
    );
    let shot = Shot {
        size: (24, 16),
        max_depth,
        spp,
    };
    let mut settings = settings(&camera, shot);
    change(&mut settings);
    let procedural = no_textures(scene);
    render_with(device, scene, &procedural, &settings, spp)
}

fn assert_agree(name: &str, tested: &Film, reference: &Film) {
    ZTest::default()
        .compare(
            Estimate::from_film(tested),
            Estimate::from_film(reference),
            |_, _| true,
        )
        // The pictures have noise of their own: two of a thousand pixels may differ by chance in one of three channels.
        .assert_matches(name, PASSING - 0.005, 2.0 * MEAN_ERROR);
}

#[test]
fn estimators_agree_path_length_by_path_length() {
    let Some(device) = device::open() else { return };
    let mut room = room();
    for max_depth in 1..=4 {
        let reference = view(&device, &mut room, max_depth, 256, |_| {});
        for (estimator, spp) in [(Estimator::Bsdf, 512), (Estimator::Lights, 512)] {
            let film = view(&device, &mut room, max_depth, spp, |settings| {
                settings.estimator = estimator;
                settings.seed = 1;
            });
            let name = format!("estimator {} at depth {max_depth}", estimator.name());
            assert_agree(&name, &film, &reference);
        }
    }
}

#[test]
fn roulette_changes_nothing_but_noise() {
    let Some(device) = device::open() else { return };
    let mut room = room();
    // It begins at the fifth vertex.
    for max_depth in [5, 9] {
        let with = view(&device, &mut room, max_depth, 256, |_| {});
        let without = view(&device, &mut room, max_depth, 256, |settings| {
            settings.roulette = false;
            settings.seed = 1;
        });
        assert!(with != without);
        assert_agree(&format!("roulette at depth {max_depth}"), &with, &without);
    }
}

#[test]
fn merged_parts_are_the_whole_for_every_estimator() {
    let Some(device) = device::open() else { return };
    let mut room = room();
    for estimator in Estimator::ALL {
        let part = |room: &mut Scene, first: u32, count: u32| {
            view(&device, room, 4, count, |settings| {
                settings.estimator = estimator;
                settings.first_sample = first;
            })
        };
        let whole = part(&mut room, 0, 24);
        let mut merged = part(&mut room, 17, 7);
        merged.add(&part(&mut room, 0, 17));
        assert!(merged == whole, "{estimator:?}");
    }
}

#[test]
fn a_clamp_darkens_indirect_light_alone() {
    let Some(device) = device::open() else { return };
    let mut room = room();
    let clamp = |most| move |settings: &mut RenderSettings| settings.clamp = Some(most);
    let direct = view(&device, &mut room, 1, 64, |_| {});
    assert!(direct == view(&device, &mut room, 1, 64, clamp(1e-3)));
    let free = view(&device, &mut room, 4, 64, |_| {});
    assert!(free == view(&device, &mut room, 4, 64, clamp(1e6)));
    let clamped = view(&device, &mut room, 4, 64, clamp(0.05));
    let sum = |film: &Film| -> f64 { film.mean().iter().flatten().map(|&v| f64::from(v)).sum() };
    let [direct, clamped, free] = [&direct, &clamped, &free].map(sum);
    assert!(
        direct < clamped && clamped < 0.99 * free,
        "{direct} {clamped} {free}"
    );
}
