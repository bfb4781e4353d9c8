//! A light in the sky that has a size: as much light as without, soft shadows, and a disk in mirrors and for the camera.

use std::f32::consts::PI;

use engine::scene::{LightKind, Material, Projection, PunctualLight, Scene};
use glam::{Vec2, Vec3, Vec4};

use super::assert_shows;
use crate::support::device;
use crate::support::scenes::{
    Shot, camera, floor, floor_point, from_above, lambert, quad, render, scene, unlit,
};

const ALBEDO: Vec3 = Vec3::new(0.8, 0.5, 0.2);
const IRRADIANCE: Vec3 = Vec3::new(3.0, 2.0, 1.0);
const SHOT: Shot = Shot {
    size: (32, 32),
    max_depth: 1,
    spp: 256,
};

/// Angular radius in radians, and the direction in which it shines.
fn disk(radius: f32, direction: Vec3) -> PunctualLight {
    PunctualLight {
        name: "sun".to_owned(),
        intensity: IRRADIANCE,
        position: Vec3::ZERO,
        direction: direction.normalize(),
        range: f32::INFINITY,
        kind: LightKind::Disk {
            angular_diameter: 2.0 * radius,
        },
    }
}

fn radiance_of(radius: f32) -> Vec3 {
    IRRADIANCE / (PI * radius.sin().powi(2))
}

fn lit(mut scene: Scene, light: PunctualLight) -> Scene {
    scene.lights = vec![light];
    scene
}

#[test]
fn its_size_leaves_the_irradiance_as_it_is() {
    let Some(device) = device::open() else { return };
    let direction = Vec3::new(0.5, -1.0, 0.2);
    for radius in [0.004_75, 0.4] {
        let floor = scene([(floor(5.0), lambert(ALBEDO))], Vec3::ZERO);
        let mut scene = lit(floor, disk(radius, direction));
        let film = render(&device, &mut scene, &from_above(1.0, 1.0), SHOT);
        // All of the disk is above the horizon, and irradiance is a vector.
        let cosine = -direction.normalize().y;
        assert_shows(&format!("disk of radius {radius}"), &film, |_| {
            ALBEDO / PI * IRRADIANCE * cosine
        });
    }
}

#[test]
fn a_straight_edge_throws_a_shadow_as_soft_as_the_disk_is_wide() {
    let Some(device) = device::open() else { return };
    const RADIUS: f32 = 0.2;
    const EDGE: f32 = 1.0;
    // A roof over all of x < 0; unlit, so that it only casts a shadow.
    let roof = quad(
        Vec3::new(-20.0, EDGE, -20.0),
        Vec3::X * 20.0,
        Vec3::Z * 40.0,
    );
    let black = Material {
        double_sided: true,
        ..unlit(Vec4::W)
    };
    let objects = [(floor(30.0), lambert(ALBEDO)), (roof, black)];
    let mut scene = lit(scene(objects, Vec3::ZERO), disk(RADIUS, Vec3::NEG_Y));
    let half = 0.4;
    let film = render(&device, &mut scene, &from_above(0.5, half), SHOT);
    // Directions by their x and z, in which irradiance is even: the part of the circle that looks past the edge.
    let open_share = |x: f32| {
        const POINTS: i32 = 64;
        let at = |i: i32| (2.0 * (i as f32 + 0.5) / POINTS as f32 - 1.0) * RADIUS.sin();
        let (mut inside, mut open) = (0, 0);
        for (dx, dz) in (0..POINTS * POINTS).map(|i| (at(i % POINTS), at(i / POINTS))) {
            let squared = dx * dx + dz * dz;
            if squared <= RADIUS.sin().powi(2) {
                inside += 1;
                open += i32::from(x + dx / (1.0 - squared).sqrt() * EDGE > 0.0);
            }
        }
        open as f32 / inside as f32
    };
    // It depends on x alone.
    let table: Vec<f32> = (0..=2048)
        .map(|i| open_share((i as f32 / 1024.0 - 1.0) * half))
        .collect();
    assert!(table[0] == 0.0 && table[2048] == 1.0);
    assert_shows("penumbra", &film, |picture| {
        let x = floor_point(half, picture).x;
        let share = table[((x / half + 1.0) * 1024.0).round() as usize];
        ALBEDO / PI * IRRADIANCE * share
    });
}

#[test]
fn a_mirror_shows_its_radiance() {
    let Some(device) = device::open() else { return };
    const RADIUS: f32 = 0.3;
    for roughness in [0.0, 0.1] {
        let mirror = Material {
            base_color: Vec4::ONE,
            metallic: 1.0,
            roughness,
            ..Material::default()
        };
        let mut scene = lit(
            scene([(floor(5.0), mirror)], Vec3::ZERO),
            disk(RADIUS, Vec3::NEG_Y),
        );
        let film = render(&device, &mut scene, &from_above(1.0, 1.0), SHOT);
        // Every pixel sees the middle of the disk, blurred by much less than its size.
        assert_shows(&format!("a mirror of roughness {roughness}"), &film, |_| {
            radiance_of(RADIUS)
        });
    }
}

#[test]
fn the_camera_sees_a_disk() {
    let Some(device) = device::open() else { return };
    const RADIUS: f32 = 0.3;
    let mut scene = lit(
        scene([(floor(5.0), lambert(ALBEDO))], Vec3::ZERO),
        disk(RADIUS, Vec3::NEG_Y),
    );
    let y_fov = 0.8f32;
    let up = camera(
        Vec3::Y,
        Vec3::Y * 2.0,
        Vec3::NEG_Z,
        Projection::Perspective { y_fov },
    );
    let film = render(&device, &mut scene, &up, SHOT);
    assert_shows("the disk itself", &film, |picture: Vec2| {
        let from_middle = (2.0 * picture - 1.0) * (0.5 * y_fov).tan();
        match from_middle.length() < RADIUS.tan() {
            true => radiance_of(RADIUS),
            false => Vec3::ZERO,
        }
    });
}
