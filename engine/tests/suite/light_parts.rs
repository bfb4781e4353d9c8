//! Where caches and photons bring light, its parts are told apart as those of paths are, and a clamp takes away what it should.

use ::device::Device;
use engine::film::{Film, Layer, Layers};
use engine::scene::{LightGroups, Material, Scene};
use engine::settings::{Method, RenderSettings};
use glam::Vec3;

use crate::closed_forms::light_layers::{SHOT, everything};
use crate::irradiance::{room_with_window, seen_in_room};
use crate::light_cache::{film, mean};
use crate::support::device;
use crate::support::scenes::settings;

const PARTS: [&str; 8] = [
    "diffuse_direct",
    "diffuse_indirect",
    "glossy_direct",
    "glossy_indirect",
    "transmission_direct",
    "transmission_indirect",
    "emission",
    "environment",
];

const BIASED: [Method; 4] = [
    Method::Draft,
    Method::Cache,
    Method::Photons,
    Method::CachePhotons,
];

/// All that are biased; on drivers, which take long to compile kernels, the one that has something of each.
pub(crate) fn methods(device: &Device) -> &'static [Method] {
    match device.traits().runs_threads_in_turn {
        true => &BIASED,
        false => &BIASED[3..],
    }
}

/// The parts, and the one group of lights where nothing is in any.
fn layers(scene: &Scene) -> Layers {
    let names = PARTS.into_iter().chain(["light_groups"]);
    let layers = Layers::named(names).expect("there are such layers");
    layers.of_scene(scene)
}

/// A part's light, with the colour that files have it divided by.
fn part(film: &Film, name: &str) -> Vec<Vec3> {
    let values = |name: &str| -> Vec<Vec3> {
        let layer = Layer::named(name).expect("there is such a layer");
        let values = film.values(layer).expect("it was asked for");
        values.into_iter().map(Vec3::from).collect()
    };
    match name.split_once('_') {
        Some((class, _)) if class != "light" => {
            let colors = values(&format!("{class}_color"));
            values(name)
                .iter()
                .zip(colors)
                .map(|(a, b)| a * b)
                .collect()
        }
        _ => values(name),
    }
}

fn mean_of(values: &[Vec3]) -> Vec3 {
    values.iter().sum::<Vec3>() / values.len() as f32
}

/// Everything with mirrors that throw caustics, and nothing in groups.
fn shiny() -> (Scene, RenderSettings) {
    let (mut scene, camera) = everything();
    for material in &mut scene.materials {
        if material.metallic == 1.0 {
            material.roughness = 0.15;
        }
    }
    scene.light_groups = LightGroups::default();
    let wanted = RenderSettings {
        layers: layers(&scene),
        paths_ahead: 1 << 16,
        ..settings(&camera, SHOT)
    };
    (scene, wanted)
}

/// A window's light on walls of which some are a little polished.
fn polished() -> (Scene, RenderSettings) {
    let mut scene = room_with_window(3.0, 3.0);
    for (number, material) in scene.materials.iter_mut().enumerate() {
        let polish = Material {
            roughness: [0.3, 0.75][number % 2],
            specular: 1.0,
            ..material.clone()
        };
        *material = polish;
    }
    let wanted = RenderSettings {
        layers: layers(&scene),
        ..seen_in_room(4)
    };
    (scene, wanted)
}

/// Parts are those of paths, but for so much of the whole picture; and add up to it.
fn compare(
    device: &Device,
    (scene, wanted): &(Scene, RenderSettings),
    methods: &[Method],
    most: f32,
) {
    let reference = film(&device::open_for_reference(), scene.clone(), wanted, 1024);
    let whole = mean(&reference).max_element();
    for &method in methods {
        let settings = RenderSettings {
            method,
            ..wanted.clone()
        };
        let found = film(device, scene.clone(), &settings, 256);
        let mut sum = vec![Vec3::ZERO; found.pixels()];
        for name in PARTS {
            let light = part(&found, name);
            for (sum, light) in sum.iter_mut().zip(&light) {
                *sum += *light;
            }
            let (found, right) = (mean_of(&light), mean_of(&part(&reference, name)));
            let off = (found - right).abs().max_element() / whole;
            println!("{}: {name} {found}, {right}: {off:.4}", method.name());
            assert!(
                off < most,
                "{}: {name} is {found} instead of {right}",
                method.name()
            );
        }
        let group = part(&found, "light_group_0");
        for (pixel, &all) in found.mean().iter().enumerate() {
            let all = Vec3::from(all);
            for (sum, what) in [(sum[pixel], "parts"), (group[pixel], "the group")] {
                let off = (sum - all).abs().max_element();
                assert!(
                    off <= 1e-5 * all.max_element().max(1e-3),
                    "{}, pixel {pixel}: {what} {sum}, the picture {all}",
                    method.name()
                );
            }
        }
    }
}

#[test]
fn parts_of_the_light_are_those_of_paths() {
    let Some(device) = device::open() else { return };
    compare(&device, &shiny(), methods(&device), 0.012);
}

#[test]
fn few_rays_to_the_sky_are_told_apart_too() {
    let Some(device) = device::open() else { return };
    compare(&device, &polished(), &[Method::Draft, Method::Cache], 0.012);
}

#[test]
fn light_that_was_scattered_once_is_not_clamped() {
    let Some(device) = device::open() else { return };
    let (scene, wanted) = shiny();
    let (window, in_room) = polished();
    for (scene, wanted, methods) in [
        (scene, wanted, methods(&device)),
        (window, in_room, &BIASED[..2]),
    ] {
        // Without layers, which would have it all computed another way.
        let plain = RenderSettings {
            layers: Layers::default(),
            ..wanted
        };
        let once = RenderSettings {
            max_depth: 1,
            ..plain.clone()
        };
        let right = mean(&film(
            &device::open_for_reference(),
            scene.clone(),
            &once,
            1024,
        ));
        for &method in methods {
            let clamped = RenderSettings {
                method,
                clamp: Some(1e-6),
                ..plain.clone()
            };
            let found = mean(&film(&device, scene.clone(), &clamped, 256));
            let off = (found / right - 1.0).abs().max_element();
            println!("{}: {found}, {right}: {off:.4}", method.name());
            assert!(off < 0.02, "{}: {found} is not {right}", method.name());
        }
    }
}
