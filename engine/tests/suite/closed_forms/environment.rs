//! Light from infinitely far away: which way round a picture is, and how much light comes from it.

use std::f64::consts::{PI, TAU};

use engine::scene::import::load_environment_image;
use engine::scene::{Environment, FloatImage, Projection, Scene};
use glam::{DVec3, Vec3};

use super::assert_shows;
use crate::support::scenes::{Shot, camera, floor, from_above, lambert, quad, render, scene};
use crate::support::{device, shared};

const FLOOR_SHOT: Shot = Shot {
    size: (32, 32),
    max_depth: 1,
    spp: 512,
};

fn with_environment(mut scene: Scene, image: FloatImage, rotation: f32, intensity: f32) -> Scene {
    scene.environment = Environment::Image {
        image: std::sync::Arc::new(image),
        rotation,
        intensity,
    };
    scene
}

/// A picture of 64 x 32 texels, a colour for each of the six directions around it.
fn compass() -> FloatImage {
    let (width, height) = (64, 32);
    let colors = [
        Vec3::new(1.0, 0.25, 0.25), // left and right edge: -Z
        Vec3::new(0.25, 1.0, 0.25), // 1/4: +X
        Vec3::new(0.25, 0.25, 1.0), // middle: +Z
        Vec3::new(1.0, 1.0, 0.25),  // 3/4: -X
    ];
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let color = match y {
            0..4 => Vec3::new(0.25, 1.0, 1.0),
            28.. => Vec3::new(1.0, 0.25, 1.0),
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
    let Some(device) = device::open() else { return };
    let [red, green, blue, yellow] = [
        Vec3::new(1.0, 0.25, 0.25),
        Vec3::new(0.25, 1.0, 0.25),
        Vec3::new(0.25, 0.25, 1.0),
        Vec3::new(1.0, 1.0, 0.25),
    ];
    // Seen along -Z, +X, +Z, -X. A turn of 90 degrees, counter-clockwise seen from above, brings what was at +X to -Z.
    for (rotation, around) in [
        (0.0, [red, green, blue, yellow]),
        (90.0, [green, blue, yellow, red]),
        (-90.0, [yellow, red, green, blue]),
    ] {
        let horizon = [Vec3::NEG_Z, Vec3::X, Vec3::Z, Vec3::NEG_X];
        let mut seen: Vec<(Vec3, Vec3)> = horizon.into_iter().zip(around).collect();
        seen.push((Vec3::Y, Vec3::new(0.25, 1.0, 1.0)));
        seen.push((Vec3::NEG_Y, Vec3::new(1.0, 0.25, 1.0)));
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
                spp: 4,
            };
            let mut scene = with_environment(empty, compass(), rotation, 2.0);
            let film = render(&device, &mut scene, &camera, shot);
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

/// Irradiance on a floor from a picture that is interpolated bilinearly, by the midpoint rule with 4 x 4 points in each
/// texel.
fn irradiance(image: &FloatImage) -> DVec3 {
    const POINTS: u32 = 4;
    let (width, height) = (image.width as i32, image.height as i32);
    let texel = |x: i32, y: i32| {
        let at = y.clamp(0, height - 1) * width + x.rem_euclid(width);
        DVec3::from_array(image.rgb[at as usize].map(f64::from))
    };
    let (columns, rows) = (image.width * POINTS, image.height * POINTS);
    let point = |i: u32| (f64::from(i) + 0.5) / f64::from(POINTS) - 0.5;
    let mut sum = DVec3::ZERO;
    // The lower half lies below the floor.
    for row in 0..rows / 2 {
        let theta = PI * (f64::from(row) + 0.5) / f64::from(rows);
        let y = point(row);
        let (y0, ty) = (y.floor() as i32, y - y.floor());
        for column in 0..columns {
            let x = point(column);
            let (x0, tx) = (x.floor() as i32, x - x.floor());
            let upper = texel(x0, y0).lerp(texel(x0 + 1, y0), tx);
            let lower = texel(x0, y0 + 1).lerp(texel(x0 + 1, y0 + 1), tx);
            sum += upper.lerp(lower, ty) * theta.sin() * theta.cos();
        }
    }
    sum * TAU / f64::from(columns) * PI / f64::from(rows)
}

#[test]
fn a_small_bright_lamp_in_a_large_environment_is_sampled_as_often_as_it_should() {
    // Tables of half a million cells are where a random number runs out of bits.
    let Some(device) = device::open() else { return };
    let image = sky_with_lamp(1024, 300, 150, 6);
    let expected = (irradiance(&image) * 0.5 / PI).as_vec3();
    let ground = scene([(floor(5.0), lambert(Vec3::splat(0.5)))], Vec3::ZERO);
    let mut scene = with_environment(ground, image, 33.0, 1.0);
    let film = render(&device, &mut scene, &from_above(1.0, 1.0), FLOOR_SHOT);
    assert_shows("lamp in the sky", &film, |_| expected);
}

#[test]
fn a_real_environment_lights_a_floor_as_its_integral_says() {
    let Some(file) = shared::find("reference/envlit/env.hdr") else {
        return;
    };
    let Some(device) = device::open() else { return };
    let (image, _) = load_environment_image(&engine::input::Disk, &file)
        .unwrap_or_else(|error| panic!("{error}"));
    let expected = (irradiance(&image) * 0.5 / PI).as_vec3();
    let ground = scene([(floor(5.0), lambert(Vec3::splat(0.5)))], Vec3::ZERO);
    let mut scene = with_environment(ground, image, -70.0, 1.0);
    let film = render(&device, &mut scene, &from_above(1.0, 1.0), FLOOR_SHOT);
    assert_shows("real environment", &film, |_| expected);
}

#[test]
fn directions_are_found_in_a_picture_to_a_hundredth_of_a_mrad() {
    let Some(device) = device::open() else { return };
    // Each row shows its number.
    const ROWS: u32 = 4096;
    let image = FloatImage {
        width: 1,
        height: ROWS,
        rgb: (0..ROWS).map(|row| [row as f32; 3]).collect(),
    };
    let behind = quad(Vec3::splat(-5.0), Vec3::X * 0.01, Vec3::Z * 0.01);
    let empty = scene([(behind, lambert(Vec3::ONE))], Vec3::ZERO);
    let mut scene = with_environment(empty, image, 0.0, 1.0);
    let shot = Shot {
        size: (8, 8),
        max_depth: 1,
        spp: 4,
    };
    let error = |degrees: u32| {
        let polar = f64::from(degrees).to_radians();
        let direction = DVec3::new(0.6 * polar.sin(), polar.cos(), 0.8 * polar.sin());
        // So narrow that the mean is that of the middle.
        let projection = Projection::Perspective { y_fov: 1e-3 };
        let camera = camera(Vec3::ZERO, direction.as_vec3(), Vec3::Y, projection);
        let film = render(&device, &mut scene, &camera, shot);
        let rows = film.mean().iter().map(|rgb| f64::from(rgb[0])).sum::<f64>() / 64.0;
        ((rows + 0.5) / f64::from(ROWS) * PI - polar).abs()
    };
    let errors: Vec<f64> = (5..180).step_by(10).map(error).collect();
    println!("{errors:.7?}");
    // Functions of drivers are this exact, but for acos.
    assert!(errors.iter().all(|&error| error < 3e-5), "{errors:.7?}");
}
