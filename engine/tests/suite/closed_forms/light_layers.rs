//! Layers that are parts of the light: they add up to the picture, and each is what it is called.

use engine::film::{Film, Layer, Layers};
use engine::renderer::Renderer;
use engine::scene::{
    Camera, Environment, LightKind, LightSource, Material, Projection, PunctualLight, Scene,
};
use engine::settings::RenderSettings;
use glam::Vec3;

use crate::support::device;
use crate::support::scenes::{
    Shot, add, camera, faceted_sphere, floor, from_above, lambert, lamp, no_textures, quad, scene,
    settings, unlit,
};

pub(crate) const SHOT: Shot = Shot {
    size: (32, 32),
    max_depth: 5,
    spp: 16,
};

const CLASSES: [&str; 3] = ["diffuse", "glossy", "transmission"];

fn film(device: &::device::Device, scene: &mut Scene, camera: &Camera, shot: Shot) -> Film {
    let procedural = no_textures(scene);
    let settings = RenderSettings {
        layers: Layers::all().of_scene(scene),
        ..settings(camera, shot)
    };
    let renderer = Renderer::new(device, scene, &procedural, &settings);
    let mut renderer = renderer.unwrap_or_else(|error| panic!("{error}"));
    let rendered = renderer.render(shot.spp).and_then(|()| renderer.film());
    rendered.unwrap_or_else(|error| panic!("{error}"))
}

fn values(film: &Film, name: &str) -> Vec<Vec3> {
    let layer = Layer::named(name).expect("there is such a layer");
    let values = film.values(layer).expect("it was asked for");
    values.into_iter().map(Vec3::from).collect()
}

fn mean(values: &[Vec3]) -> Vec3 {
    values.iter().sum::<Vec3>() / values.len() as f32
}

/// One of each kind of surface and light.
pub(crate) fn everything() -> (Scene, Camera) {
    let base = lambert(Vec3::new(0.6, 0.3, 0.2));
    let surfaces = [
        base.clone(),
        Material {
            metallic: 1.0,
            roughness: 0.3,
            ..base.clone()
        },
        Material {
            transmission: 1.0,
            roughness: 0.1,
            is_solid: true,
            ..Material::default()
        },
        Material {
            diffuse_transmission: 0.6,
            diffuse_transmission_color: Vec3::new(0.2, 0.7, 0.4),
            double_sided: true,
            ..base.clone()
        },
        Material {
            coat: 1.0,
            sheen_color: Vec3::splat(0.5),
            sheen_roughness: 0.4,
            specular: 1.0,
            ..base.clone()
        },
        Material {
            transmission: 1.0,
            roughness: 0.0,
            metallic: 0.0,
            double_sided: true,
            ..Material::default()
        },
    ];
    let ground = (floor(6.0), lambert(Vec3::splat(0.5)));
    let mut scene = scene([ground], Vec3::new(0.2, 0.3, 0.5));
    for (at, surface) in surfaces.into_iter().enumerate() {
        let mut ball = faceted_sphere(10);
        let place = Vec3::new(
            2.4 * (at % 3) as f32 - 2.4,
            1.0,
            1.2 - 2.4 * (at / 3) as f32,
        );
        for position in &mut ball.positions {
            *position += place;
        }
        add(&mut scene, ball, surface);
    }
    let sheet = Material {
        transmission: 1.0,
        roughness: 0.4,
        metallic: 0.0,
        double_sided: true,
        ..Material::default()
    };
    let shape = quad(Vec3::new(-4.5, 0.0, 2.5), Vec3::X * 2.0, Vec3::Y * 2.0);
    let lamp_shape = quad(Vec3::new(-1.0, 4.0, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0);
    add(&mut scene, lamp_shape, lamp(Vec3::new(6.0, 5.0, 3.0)));
    let sign = quad(Vec3::new(-4.0, 0.0, -3.0), Vec3::X * 8.0, Vec3::Y * 3.0);
    add(
        &mut scene,
        sign,
        unlit(Vec3::new(0.3, 0.1, 0.2).extend(1.0)),
    );
    add(&mut scene, shape, sheet);
    let light = |name: &str, kind| PunctualLight {
        name: name.to_owned(),
        intensity: Vec3::splat(3.0),
        position: Vec3::new(3.0, 3.0, 3.0),
        direction: Vec3::new(-0.5, -1.0, -0.3).normalize(),
        range: f32::INFINITY,
        kind,
    };
    let angular_diameter = 0.3;
    scene.lights.push(light("bulb", LightKind::Point));
    scene
        .lights
        .push(light("sun", LightKind::Disk { angular_diameter }));
    let emitter = scene.materials[7].name.clone();
    for (source, group) in [
        (LightSource::Light("sun"), "day"),
        (LightSource::Environment, "day"),
        (LightSource::Light("bulb"), "bulbs"),
        (LightSource::Material(&emitter), "lamp"),
    ] {
        scene.light_groups.assign(source, group).expect("room");
    }
    let eye = Vec3::new(0.0, 3.0, 9.0);
    let perspective = Projection::Perspective { y_fov: 0.9 };
    (scene, camera(eye, Vec3::Y, Vec3::Y, perspective))
}

#[test]
fn parts_of_the_light_add_up_to_the_picture() {
    let Some(device) = device::open() else { return };
    let (mut scene, camera) = everything();
    for max_depth in [0, 1, 5] {
        let film = film(&device, &mut scene, &camera, Shot { max_depth, ..SHOT });
        let combined = film.mean();
        let check = |parts: Vec<Vec3>, what: &str| {
            for (at, (sum, &whole)) in parts.iter().zip(&combined).enumerate() {
                let whole = Vec3::from(whole);
                let off = (*sum - whole).abs().max_element();
                assert!(
                    off <= 1e-5 * whole.max_element().max(1e-3),
                    "{what}, pixel {at} at depth {max_depth}: {sum} {whole}"
                );
            }
        };
        let mut parts = values(&film, "emission");
        for class in CLASSES {
            let of = |what: &str| values(&film, &format!("{class}_{what}"));
            let light = of("direct").into_iter().zip(of("indirect"));
            for ((sum, color), (direct, indirect)) in parts.iter_mut().zip(of("color")).zip(light) {
                *sum += color * (direct + indirect);
            }
        }
        for (sum, environment) in parts.iter_mut().zip(values(&film, "environment")) {
            *sum += environment;
        }
        check(parts, "kinds of scattering");
        let mut groups = values(&film, "light_group_0");
        for number in 1..=3 {
            let group = values(&film, &format!("light_group_{number}"));
            if max_depth > 1 {
                assert!(
                    mean(&group).min_element() > 1e-3,
                    "group {number} has light"
                );
            }
            for (sum, group) in groups.iter_mut().zip(group) {
                *sum += group;
            }
        }
        check(groups, "groups");
        assert!(
            mean(&values(&film, "light_group_0")).max_element() > 0.0,
            "the sign"
        );
        if max_depth > 1 {
            for class in CLASSES {
                for what in ["direct", "indirect", "color"] {
                    let name = format!("{class}_{what}");
                    assert!(mean(&values(&film, &name)).max_element() > 1e-3, "{name}");
                }
            }
        }
    }
}

#[test]
fn a_floor_is_lit_diffusely_and_a_mirror_glossily() {
    let Some(device) = device::open() else { return };
    let color = Vec3::new(0.2, 0.4, 0.8);
    let sky = Vec3::new(0.5, 1.0, 2.0);
    let mirror = Material {
        base_color: color.extend(1.0),
        metallic: 1.0,
        roughness: 0.0,
        ..Material::default()
    };
    for (surface, class) in [(lambert(color), "diffuse"), (mirror, "glossy")] {
        let mut scene = scene([(floor(1.0), surface)], sky);
        // Half of the picture sees the floor.
        let film = film(&device, &mut scene, &from_above(3.0, 2.0), SHOT);
        let picture = film.mean();
        for (at, &alpha) in film.alpha().expect("gathered").iter().enumerate() {
            if alpha == 0.0 {
                assert_eq!(values(&film, "environment")[at], Vec3::from(picture[at]));
                assert_eq!(film.foreground().expect("gathered")[at], [0.0; 3]);
            } else if alpha == 1.0 {
                assert_eq!(values(&film, "environment")[at], Vec3::ZERO);
                let tint = values(&film, &format!("{class}_color"))[at];
                assert!((tint - color).length() < 1e-5, "{tint}");
            }
        }
        let inside: Vec<usize> = (0..film.pixels())
            .filter(|&at| film.alpha().expect("gathered")[at] == 1.0)
            .collect();
        assert!(inside.len() > 200);
        for other in CLASSES {
            let light = values(&film, &format!("{other}_direct"));
            let light: Vec<_> = inside.iter().map(|&at| light[at]).collect();
            let expected = if other == class { sky } else { Vec3::ZERO };
            assert!(
                (mean(&light) - expected).length() < 0.02,
                "{other}: {}",
                mean(&light)
            );
            let detours = values(&film, &format!("{other}_indirect"));
            assert_eq!(mean(&detours), Vec3::ZERO, "there is nothing else");
        }
    }
}

#[test]
fn a_group_is_the_picture_of_its_lights_alone() {
    let Some(device) = device::open() else { return };
    let shot = Shot { spp: 1024, ..SHOT };
    let (mut whole, camera) = everything();
    let film = |scene: &mut Scene| film(&device, scene, &camera, shot);
    let grouped = film(&mut whole);
    // Without the others, and without the sign, which belongs to none.
    let (mut alone, _) = everything();
    alone.lights.retain(|light| light.name == "bulb");
    alone.environment = Environment::Constant(Vec3::ZERO);
    alone.materials[7].emission = Vec3::ZERO;
    alone.materials[8].base_color = Vec3::ZERO.extend(1.0);
    let expected = film(&mut alone);
    let number = whole.light_groups.of(LightSource::Light("bulb"));
    let group = mean(&values(&grouped, &format!("light_group_{number}")));
    let expected = mean(&values(&expected, "combined"));
    let off = ((group - expected) / expected).abs().max_element();
    assert!(off < 0.03, "{group} {expected}");
}
