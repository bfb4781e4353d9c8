//! Light from infinitely far away: which way round a picture is, and how much light comes from it.

use std::f64::consts::{PI, TAU};

use engine::scene::{Environment, FloatImage, Projection, Scene};
use glam::{DVec3, Vec3};

use crate::assert_shows;
use crate::support::device;
use crate::support::scenes::{Shot, camera, floor, from_above, lambert, quad, render, scene};

fn with_environment(mut scene: Scene, image: FloatImage, rotation: f32, intensity: f32) -> Scene {
    scene.environment = Environment::Image {
        image,
        rotation,
        intensity,
    };
    scene
}

/// A picture of 64 x 32 texels, a colour for each of the six directions around it.
fn compass() -> FloatImage {
    let (width, height) = (64, 32);
    let colors = [
        Vec3::new(1.0, 0.0, 0.0), // left and right edge: -Z
        Vec3::new(0.0, 1.0, 0.0), // 1/4: +X
        Vec3::new(0.0, 0.0, 1.0), // middle: +Z
        Vec3::new(1.0, 1.0, 0.0), // 3/4: -X
    ];
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let color = match y {
            0..4 => Vec3::new(0.0, 1.0, 1.0),
            28.. => Vec3::new(1.0, 0.0, 1.0),
            _ => colors[((x + width / 8) / (width / 4)) as usize % 4],
        };
        color.to_array()
    };
    FloatImage {
        width,
        height,
        rgb: (0..width * height).map(texel).collect(),
    }
}

#[test]
fn an_environment_picture_is_the_right_way_round() {
    let Some(gpu) = device::open() else { return };
    let [red, green, blue, yellow] = [
        Vec3::new(1.0, 0.0, 0.0),
        Vec3::new(0.0, 1.0, 0.0),
        Vec3::new(0.0, 0.0, 1.0),
        Vec3::new(1.0, 1.0, 0.0),
    ];
    // Seen along -Z, +X, +Z, -X. A turn of 90 degrees, counter-clockwise seen from above, brings what was at +X to -Z.
    for (rotation, around) in [
        (0.0, [red, green, blue, yellow]),
        (90.0, [green, blue, yellow, red]),
        (-90.0, [yellow, red, green, blue]),
    ] {
        let horizon = [Vec3::NEG_Z, Vec3::X, Vec3::Z, Vec3::NEG_X];
        let mut seen: Vec<(Vec3, Vec3)> = horizon.into_iter().zip(around).collect();
        seen.push((Vec3::Y, Vec3::new(0.0, 1.0, 1.0)));
        seen.push((Vec3::NEG_Y, Vec3::new(1.0, 0.0, 1.0)));
        for (direction, color) in seen {
            // A scene needs a surface; this one is behind the camera.
            let behind = quad(-5.0 * direction, Vec3::X * 0.01, Vec3::Y * 0.01);
            let empty = scene([(behind, lambert(Vec3::ONE))], Vec3::ZERO);
            let up = match direction.y.abs() > 0.5 {
                true => Vec3::Z,
                false => Vec3::Y,
            };
            let camera = camera(
                Vec3::ZERO,
                direction,
                up,
                Projection::Perspective { y_fov: 0.3 },
            );
            let shot = Shot {
                size: (8, 8),
                max_depth: 1,
                spp: 1,
            };
            let mut scene = with_environment(empty, compass(), rotation, 2.0);
            let film = render(&gpu, &mut scene, &camera, shot);
            let name = format!("environment turned by {rotation} degrees, along {direction}");
            assert_shows(&name, &film, |_| 2.0 * color);
        }
    }
}

/// A large dim picture with a small bright lamp at (`x`, `y`), `side` texels along each side.
fn sky_with_lamp(width: u32, x: u32, y: u32, side: u32) -> FloatImage {
    let texel = |i: u32| {
        let (column, row) = (i % width, i / width);
        let in_lamp = (x..x + side).contains(&column) && (y..y + side).contains(&row);
        match in_lamp {
            true => [3000.0, 2000.0, 1000.0],
            false => [0.2, 0.4, 0.6],
        }
    };
    FloatImage {
        width,
        height: width / 2,
        rgb: (0..width * width / 2).map(texel).collect(),
    }
}

/// Irradiance on a floor, texel by texel; a lamp loses to its neighbours by interpolation what it gains there.
fn irradiance(image: &FloatImage) -> DVec3 {
    let (width, height) = (f64::from(image.width), f64::from(image.height));
    let texel = TAU / width * PI / height;
    let terms = image.rgb.iter().enumerate().map(|(i, rgb)| {
        let row = (i as u32 / image.width) as f64 + 0.5;
        let theta = PI * row / height;
        let weight = (theta.sin() * theta.cos()).max(0.0) * texel;
        DVec3::from_array(rgb.map(f64::from)) * weight
    });
    terms.sum()
}

#[test]
fn a_small_bright_lamp_in_a_large_environment_is_sampled_as_often_as_it_should() {
    // Tables of half a million cells are where a random number runs out of bits.
    let Some(gpu) = device::open() else { return };
    let image = sky_with_lamp(1024, 300, 150, 6);
    let expected = (irradiance(&image) * 0.5 / PI).as_vec3();
    let ground = scene([(floor(5.0), lambert(Vec3::splat(0.5)))], Vec3::ZERO);
    let mut scene = with_environment(ground, image, 33.0, 1.0);
    let shot = Shot {
        size: (32, 32),
        max_depth: 1,
        spp: 128,
    };
    let film = render(&gpu, &mut scene, &from_above(1.0, 1.0), shot);
    assert_shows("lamp in the sky", &film, |_| expected);
}
