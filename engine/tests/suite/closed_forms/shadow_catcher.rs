//! Shadows on shadow catchers: where everything is known, the layer is what is known.

use std::f32::consts::PI;

use ::device::Device;
use engine::film::{Film, Layer, Layers};
use engine::renderer::Renderer;
use engine::scene::{LightKind, Material, PunctualLight, Scene};
use engine::settings::{Estimator, Method, RenderSettings};
use glam::Vec3;

use crate::light_parts::methods;
use crate::support::device;
use crate::support::scenes::{
    Shot, faceted_sphere, floor, floor_point, from_above, lambert, no_textures, quad, scene,
    settings, unlit,
};

const SHOT: Shot = Shot {
    size: (32, 32),
    max_depth: 3,
    spp: 64,
};

/// Half of what the camera sees, metres.
const HALF: f32 = 1.0;

fn layers() -> Layers {
    Layers::named(["shadow_catcher", "environment", "alpha"]).expect("known")
}

fn film(device: &Device, scene: &mut Scene, first_sample: u32, spp: u32) -> Film {
    film_by(Method::Path, device, scene, first_sample, spp)
}

fn film_by(
    method: Method,
    device: &Device,
    scene: &mut Scene,
    first_sample: u32,
    spp: u32,
) -> Film {
    let settings = RenderSettings {
        layers: layers().of_scene(scene),
        first_sample,
        method,
        ..settings(&from_above(5.0, HALF), SHOT)
    };
    film_with(&settings, device, scene, spp)
}

fn film_with(settings: &RenderSettings, device: &Device, scene: &mut Scene, spp: u32) -> Film {
    let procedural = no_textures(scene);
    let renderer = Renderer::new(device, scene, &procedural, settings);
    let mut renderer = renderer.unwrap_or_else(|error| panic!("{error}"));
    let rendered = renderer.render(spp).and_then(|()| renderer.film());
    rendered.unwrap_or_else(|error| panic!("{error}"))
}

fn values(film: &Film, name: &str) -> Vec<Vec3> {
    let layer = Layer::named(name).expect("there is such a layer");
    let values = film.values(layer).expect("it was asked for");
    values.into_iter().map(Vec3::from).collect()
}

fn catcher() -> Material {
    Material {
        shadow_catcher: true,
        ..lambert(Vec3::new(0.5, 0.25, 0.75))
    }
}

fn lamp(kind: LightKind, intensity: Vec3, direction: Vec3) -> PunctualLight {
    PunctualLight {
        name: String::new(),
        intensity,
        position: Vec3::Y * 2.0,
        direction: direction.normalize(),
        range: f32::INFINITY,
        kind,
    }
}

fn place(film: &Film, pixel: usize) -> Vec3 {
    let at = |place: usize, of: u32| (place as f32 + 0.5) / of as f32;
    let (x, y) = (pixel % film.width as usize, pixel / film.width as usize);
    floor_point(HALF, glam::Vec2::new(at(x, film.width), at(y, film.height)))
}

#[test]
fn under_one_lamp_a_shadow_is_all_or_nothing() {
    let Some(device) = device::open() else { return };
    // A ball of a metre across that floats above the floor, smaller than it looks by its facets.
    let ball = |at: Vec3| {
        let mut mesh = faceted_sphere(16);
        for position in &mut mesh.positions {
            *position = *position * 0.25 + at;
        }
        mesh
    };
    let radius = ball(Vec3::ZERO)
        .positions
        .iter()
        .map(|p| p.length())
        .fold(0.0, f32::max);
    let center = Vec3::new(-0.4, 0.6, 0.1);
    // A sun that comes from the left, so that the ball's shadow lies beside it.
    let sun = Vec3::new(1.0, -1.0, 0.0);
    let objects = [
        (floor(4.0), catcher()),
        (ball(center), unlit(Vec3::ONE.extend(1.0))),
    ];
    let mut scene = scene(objects, Vec3::ZERO);
    scene.lights = vec![lamp(LightKind::Directional, Vec3::splat(2.0), sun)];
    for &method in [Method::Path].iter().chain(methods(&device)) {
        let film = film_by(method, &device, &mut scene, 0, SHOT.spp);
        check_shadow_of_ball(&film, center, radius, sun);
    }
}

/// Whether all that is in the ball's shadow has one, and nothing else.
fn check_shadow_of_ball(film: &Film, center: Vec3, radius: f32, sun: Vec3) {
    let factor = values(film, "shadow_catcher");
    let kept = values(film, "shadow_catcher_alpha");
    let (alpha, seen) = (
        film.alpha().expect("gathered"),
        film.foreground().expect("gathered"),
    );
    // A pixel's diagonal, and how far the facets may lie below the sphere.
    let edge = 2.0 * HALF / 32.0 * std::f32::consts::SQRT_2 + 0.06 * radius;
    let (mut in_shadow, mut in_light, mut of_ball) = (0, 0, 0);
    for pixel in 0..film.pixels() {
        let point = place(film, pixel);
        let below = Vec3::new(center.x, 0.0, center.z);
        if (point - below).length() < radius + edge {
            if (point - below).length() < radius - edge {
                assert_eq!(
                    (factor[pixel], kept[pixel].x, alpha[pixel]),
                    (Vec3::ONE, 0.0, 1.0)
                );
                of_ball += 1;
            }
            continue;
        }
        let to = point - center;
        let away = to.cross(sun.normalize()).length();
        if away < radius - edge {
            assert_eq!((factor[pixel], kept[pixel].x), (Vec3::ZERO, 1.0), "{point}");
            assert_eq!(
                (alpha[pixel], Vec3::from(seen[pixel])),
                (1.0, Vec3::ZERO),
                "{point}"
            );
            in_shadow += 1;
        } else if away > radius + edge {
            assert_eq!((factor[pixel], kept[pixel].x), (Vec3::ONE, 0.0), "{point}");
            assert!(
                alpha[pixel] == 0.0 && seen[pixel] == [0.0; 3],
                "{point} {:?}",
                seen[pixel]
            );
            in_light += 1;
        }
    }
    assert!(
        in_shadow > 10 && in_light > 300 && of_ball > 10,
        "{in_shadow} {in_light} {of_ball}"
    );
}

#[test]
fn a_shadow_is_the_share_of_all_light_that_is_kept() {
    let Some(device) = device::open() else { return };
    // A small roof above what the camera sees, far too high to matter for the sky, keeps one of two suns away.
    let (size, height) = (3.0, 40.0);
    let roof = quad(
        Vec3::new(-1.5, height, 1.5),
        Vec3::X * size,
        Vec3::NEG_Z * size,
    );
    let sky = Vec3::new(0.2, 0.4, 0.8);
    let roof_material = Material {
        double_sided: true,
        ..lambert(Vec3::ZERO)
    };
    let mut scene = scene([(floor(400.0), catcher()), (roof, roof_material)], sky);
    let (above, beside) = (Vec3::new(3.0, 2.0, 1.0), Vec3::new(1.0, 2.0, 3.0));
    let slant = Vec3::new(1.0, -1.0, 0.0);
    scene.lights = vec![
        lamp(LightKind::Directional, above, Vec3::NEG_Y),
        lamp(LightKind::Directional, beside, slant),
    ];
    // Irradiance on the floor: of the sky the roof hides what lies straight above.
    let hidden = sky * (size * size / (height * height));
    let all = sky * PI + above + beside * (0.5_f32).sqrt();
    let expected = Vec3::ONE - (above + hidden) / all;
    let brightness = |c: Vec3| c.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    let expected_alpha = brightness(above + hidden) / brightness(all);
    for &method in [Method::Path].iter().chain(methods(&device)) {
        let film = film_by(method, &device, &mut scene, 0, 1024);
        let factor = values(&film, "shadow_catcher");
        let mean = factor.iter().sum::<Vec3>() / factor.len() as f32;
        // Half a million samples of three lights.
        assert!(
            (mean - expected).abs().max_element() < 3e-3,
            "{mean} {expected}"
        );
        for factor in factor {
            assert!(
                (factor - expected).abs().max_element() < 0.1,
                "{factor} {expected}"
            );
        }
        let alpha = film.alpha().expect("gathered");
        let alpha = alpha.iter().sum::<f32>() / alpha.len() as f32;
        assert!(
            (alpha - expected_alpha).abs() < 3e-3,
            "{alpha} {expected_alpha}"
        );
    }
}

#[test]
fn shadows_are_the_same_whoever_finds_the_light() {
    let Some(device) = device::open() else { return };
    // A roof close above the middle, under an even sky.
    let roof = quad(Vec3::new(-0.5, 0.4, 0.5), Vec3::X, Vec3::NEG_Z);
    let roof_material = Material {
        double_sided: true,
        ..lambert(Vec3::ZERO)
    };
    let objects = [(floor(4.0), catcher()), (roof, roof_material)];
    let mut scene = scene(objects, Vec3::ONE);
    let mut mean = |estimator| {
        let settings = RenderSettings {
            layers: layers().of_scene(&scene),
            estimator,
            ..settings(&from_above(0.3, HALF), SHOT)
        };
        let film = film_with(&settings, &device, &mut scene, 256);
        let factor = values(&film, "shadow_catcher");
        factor.iter().sum::<Vec3>() / factor.len() as f32
    };
    let expected = mean(Estimator::Mis);
    assert!(expected.max_element() < 0.9, "{expected}");
    for estimator in Estimator::ALL {
        let factor = mean(estimator);
        let off = (factor - expected).abs().max_element();
        assert!(off < 5e-3, "{estimator:?}: {factor}, not {expected}");
    }
}

#[test]
fn shadows_merge_to_exactly_the_whole_and_are_left_out_where_nothing_catches_them() {
    let Some(device) = device::open() else { return };
    let ball = faceted_sphere(8);
    let mut scene = scene(
        [(floor(4.0), catcher()), (ball, lambert(Vec3::ONE))],
        Vec3::ONE,
    );
    let whole = film(&device, &mut scene, 0, 12);
    let mut merged = film(&device, &mut scene, 5, 7);
    merged.add(&film(&device, &mut scene, 0, 5));
    assert!(merged == whole);
    scene.materials[0].shadow_catcher = false;
    let without = film(&device, &mut scene, 0, 12);
    assert_eq!(
        without.layers().asked(),
        ["combined", "environment", "alpha"]
    );
    assert_eq!(without.mean(), whole.mean());
}
