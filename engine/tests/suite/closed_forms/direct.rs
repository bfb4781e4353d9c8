//! Direct light on a matt floor: from a rectangular lamp by Lambert's formula, and from the lights of
//! KHR_lights_punctual by theirs. One vertex scatters.

use std::f32::consts::PI;

use ::device::Device;
use engine::film::Film;
use engine::procedural::TextureSources;
use engine::scene::{AlphaMode, LightKind, Material, PunctualLight, Scene};
use glam::{DVec3, Quat, Vec2, Vec3, Vec4};

use super::assert_shows;
use crate::support::device;
use crate::support::scenes::{
    Shot, floor, floor_point, from_above, lambert, lamp, quad, render, render_textured, scene,
    textured,
};

/// Half the side of the floor that is seen, metres.
const HALF: f32 = 1.0;
const ALBEDO: Vec3 = Vec3::new(0.8, 0.5, 0.2);
const RADIANCE: Vec3 = Vec3::new(3.0, 5.0, 9.0);
const SHOT: Shot = Shot {
    size: (32, 32),
    max_depth: 1,
    spp: 128,
};

/// Corners of a tilted lamp above the floor; its front looks down.
fn lamp_corners() -> [Vec3; 4] {
    let (corner, u, v) = lamp_edges();
    [corner, corner + u, corner + u + v, corner + v]
}

fn lamp_edges() -> (Vec3, Vec3, Vec3) {
    let corner = Vec3::new(-0.6, 0.9, -0.5);
    (corner, Vec3::new(0.9, 0.1, 0.0), Vec3::new(0.1, 0.3, 1.1))
}

/// The camera floats between floor and lamp.
fn view(device: &Device, scene: &mut Scene) -> Film {
    render(device, scene, &from_above(0.5, HALF), SHOT)
}

fn lamp_scene(material: Material, facing_up: bool) -> Scene {
    let (corner, u, v) = lamp_edges();
    let lamp = match facing_up {
        false => quad(corner, u, v),
        true => quad(corner, v, u),
    };
    scene(
        [(floor(5.0), lambert(ALBEDO)), (lamp, material)],
        Vec3::ZERO,
    )
}

/// What the lamp makes the floor show at a point: Lambert's formula of 1760 for the irradiance from a polygon.
fn under_the_lamp(picture: Vec2) -> Vec3 {
    let point = floor_point(HALF, picture).as_dvec3();
    let to = lamp_corners().map(|corner| (corner.as_dvec3() - point).normalize());
    let sum: f64 = (0..4)
        .map(|i| {
            let (a, b) = (to[i], to[(i + 1) % 4]);
            a.angle_between(b) * a.cross(b).normalize().dot(DVec3::Y)
        })
        .sum();
    ALBEDO * RADIANCE * (0.5 * sum.abs()) as f32 / PI
}

#[test]
fn a_lamp_lights_a_floor_by_its_form_factor() {
    let Some(device) = device::open() else { return };
    let film = view(&device, &mut lamp_scene(lamp(RADIANCE), false));
    assert_shows("form factor", &film, under_the_lamp);
}

#[test]
fn a_lamp_shines_from_its_back_only_if_it_has_two_sides() {
    let Some(device) = device::open() else { return };
    let film = view(&device, &mut lamp_scene(lamp(RADIANCE), true));
    assert!(film.mean().iter().all(|&mean| mean == [0.0; 3]));
    let two_sided = Material {
        double_sided: true,
        ..lamp(RADIANCE)
    };
    let film = view(&device, &mut lamp_scene(two_sided, true));
    assert_shows("form factor of the back", &film, under_the_lamp);
}

#[test]
fn a_blended_lamp_gives_as_much_light_as_is_seen_of_it() {
    let Some(device) = device::open() else { return };
    let half = Material {
        base_color: Vec4::new(0.0, 0.0, 0.0, 0.5),
        alpha_mode: AlphaMode::Blend,
        ..lamp(RADIANCE)
    };
    let film = view(&device, &mut lamp_scene(half, false));
    assert_shows("form factor of half a lamp", &film, |picture| {
        0.5 * under_the_lamp(picture)
    });
}

#[test]
fn light_that_only_chance_finds_is_as_bright() {
    // A lamp whose radiance a texture decides is in no table of lights: scattered rays have to hit it.
    let Some(device) = device::open() else { return };
    let mut sources = TextureSources::default();
    sources.insert(
        "glow",
        "/// @param radiance radiance = (0, 0, 0)\nfn userProc(radiance: vec3f) -> vec3f { return radiance; }",
    );
    let mut scene = lamp_scene(lambert(Vec3::ZERO), false);
    let look = format!(
        "[node.glow]\ntexture = \"glow\"\nradiance = {RADIANCE}\n[material.\"material 1\"]\nemission = \"glow\"\n"
    );
    let procedural = textured(&mut scene, &look, &sources);
    let shot = Shot { spp: 2048, ..SHOT };
    let film = render_textured(&device, &scene, &procedural, &from_above(0.5, HALF), shot);
    assert_shows("form factor by chance", &film, under_the_lamp);
}

fn punctual(kind: LightKind, intensity: Vec3, position: Vec3, direction: Vec3) -> PunctualLight {
    PunctualLight {
        name: String::new(),
        intensity,
        position,
        direction: direction.normalize(),
        range: f32::INFINITY,
        kind,
    }
}

fn punctual_lights() -> Vec<PunctualLight> {
    let spot = LightKind::Spot {
        inner_angle: 0.2,
        outer_angle: 0.5,
    };
    vec![
        punctual(
            LightKind::Point,
            Vec3::new(2.0, 0.5, 0.1),
            Vec3::new(-0.7, 0.6, 0.2),
            Vec3::NEG_Y,
        ),
        punctual(
            spot,
            Vec3::new(0.5, 4.0, 1.0),
            Vec3::new(0.9, 1.5, 0.8),
            Vec3::new(-0.4, -1.0, -0.5),
        ),
        punctual(
            LightKind::Directional,
            Vec3::new(0.2, 0.3, 1.5),
            Vec3::ZERO,
            Vec3::new(0.7, -1.0, 0.3),
        ),
        PunctualLight {
            range: 1.2,
            ..punctual(
                LightKind::Point,
                Vec3::splat(1.5),
                Vec3::new(0.5, 0.8, -0.4),
                Vec3::NEG_Y,
            )
        },
    ]
}

/// KHR_lights_punctual: irradiance on the floor, and from it the radiance of a matt surface.
fn under_a_light(light: &PunctualLight, picture: Vec2) -> Vec3 {
    let to = light.position - floor_point(HALF, picture);
    let irradiance = match light.kind {
        LightKind::Directional | LightKind::Disk { .. } => light.intensity * -light.direction.y,
        LightKind::Point | LightKind::Spot { .. } => {
            let distance = to.length();
            let window = (1.0 - (distance / light.range).powi(4)).clamp(0.0, 1.0);
            let cone = match light.kind {
                LightKind::Spot {
                    inner_angle,
                    outer_angle,
                } => {
                    let cosine = light.direction.dot(-to / distance);
                    let edge = outer_angle.cos();
                    ((cosine - edge) / (inner_angle.cos() - edge)).clamp(0.0, 1.0)
                }
                _ => 1.0,
            };
            light.intensity * window * cone * cone * to.y / distance.powi(3)
        }
    };
    ALBEDO / PI * irradiance
}

#[test]
fn punctual_lights_light_a_floor_by_their_formulas() {
    let Some(device) = device::open() else { return };
    let all = punctual_lights();
    // Each alone, and all together, so that their shares of the samples show as well.
    for lights in all.chunks(1).chain([all.as_slice()]) {
        let mut scene = scene([(floor(5.0), lambert(ALBEDO))], Vec3::ZERO);
        scene.lights = lights.to_vec();
        let film = view(&device, &mut scene);
        let name = match lights {
            [light] => format!("one light, {:?}, range {}", light.kind, light.range),
            _ => "four lights".to_owned(),
        };
        assert_shows(&name, &film, |picture| {
            lights.iter().map(|l| under_a_light(l, picture)).sum()
        });
    }
}

#[test]
fn wide_triangles_do_not_shadow_themselves() {
    let Some(device) = device::open() else { return };
    // A slope a kilometre wide, lit aslant: where rays meet it is rounded as its corners are, 500 m away.
    let turn = Quat::from_rotation_z(0.21) * Quat::from_rotation_x(0.3);
    let (u, v) = (turn * Vec3::X * 1000.0, turn * Vec3::NEG_Z * 1000.0);
    let (sine, cosine) = 0.7_f32.sin_cos();
    let to_sun = Vec3::new(cosine * 0.87, sine, cosine * 0.5).normalize();
    let slope = Material {
        double_sided: true,
        ..lambert(ALBEDO)
    };
    let mut scene = scene([(quad(-0.5 * (u + v), u, v), slope)], Vec3::ZERO);
    let sun = punctual(LightKind::Directional, RADIANCE, Vec3::ZERO, -to_sun);
    scene.lights = vec![sun];
    let lit = ALBEDO / PI * RADIANCE * to_sun.dot(turn * Vec3::Y);
    let film = render(&device, &mut scene, &from_above(5.0, HALF), SHOT);
    // There is no noise, and the normal is rounded.
    for pixel in film.mean() {
        let off = (Vec3::from(pixel) / lit - 1.0).abs().max_element();
        assert!(off < 1e-3, "{pixel:?} instead of {lit}");
    }
}
