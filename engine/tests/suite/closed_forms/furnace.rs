//! White furnaces: where light comes from everywhere, a surface that loses none can't be seen.

use engine::scene::{Material, Projection, Scene};
use glam::{Affine3A, Vec2, Vec3};

use super::assert_shows;
use crate::support::device;
use crate::support::scenes::{
    Shot, camera, faceted_sphere, from_above, lambert, quad, render, scene,
};

/// A sphere that fills the picture up to where its surface leans by 81 degrees at the corners.
fn sphere(device: &::device::Device, albedo: Vec3, max_depth: u32) -> engine::film::Film {
    let mut scene = scene([(faceted_sphere(24), lambert(albedo))], Vec3::ONE);
    let camera = camera(
        Vec3::Z * 3.0,
        Vec3::ZERO,
        Vec3::Y,
        Projection::Orthographic { y_mag: 0.7 },
    );
    let shot = Shot {
        size: (32, 32),
        max_depth,
        spp: 64,
    };
    render(device, &mut scene, &camera, shot)
}

#[test]
fn a_white_sphere_vanishes() {
    let Some(device) = device::open() else { return };
    assert_shows("white furnace", &sphere(&device, Vec3::ONE, 1), |_| {
        Vec3::ONE
    });
}

#[test]
fn a_coloured_sphere_has_its_colour_at_any_depth() {
    // It is convex: what leaves it never comes back, however many bounces are allowed.
    let Some(device) = device::open() else { return };
    let color = Vec3::new(0.5, 0.18, 0.9);
    for depth in [1, 8] {
        let name = format!("coloured furnace, depth {depth}");
        assert_shows(&name, &sphere(&device, color, depth), |_| color);
    }
}

/// A cube seen from inside, all of whose walls reflect `albedo` and shine with radiance 1.
fn glowing_room(albedo: f32) -> Scene {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let walls = (0..6).map(|i| {
        let normal = axes[i % 3] * if i < 3 { 1.0 } else { -1.0 };
        let u = axes[(i + 1) % 3] * 2.0;
        let v = normal.cross(u);
        let mut wall = lambert(Vec3::splat(albedo));
        wall.emission = Vec3::ONE;
        (quad(-normal - 0.5 * (u + v), u, v), wall)
    });
    scene(walls, Vec3::ZERO)
}

#[test]
fn a_glowing_room_sums_the_series_of_its_bounces() {
    // Each vertex that scatters adds a term: 1 + albedo + ... + albedo^depth, with Russian roulette in the longer one.
    let Some(device) = device::open() else { return };
    for (albedo, max_depth) in [(0.5_f32, 1), (0.5, 3), (0.8, 9)] {
        let camera = camera(
            Vec3::new(0.3, -0.2, 0.5),
            Vec3::new(-0.6, 0.1, -1.0),
            Vec3::Y,
            Projection::Perspective { y_fov: 1.2 },
        );
        let shot = Shot {
            size: (16, 16),
            max_depth,
            spp: 256,
        };
        let film = render(&device, &mut glowing_room(albedo), &camera, shot);
        let sum: f32 = (0..=max_depth).map(|n| albedo.powi(n as i32)).sum();
        let name = format!("glowing room, albedo {albedo}, depth {max_depth}");
        assert_shows(&name, &film, |_: Vec2| Vec3::splat(sum));
    }
}

/// As models have it that were surveyed, and whose nodes take them to the origin: their coordinates are rounded to a tenth of a
/// millimetre, in which a ray must not meet the surface that it leaves.
#[test]
fn surfaces_whose_nodes_take_large_coordinates_away_do_not_shadow_themselves() {
    let Some(device) = device::open() else { return };
    let shot = Shot {
        size: (16, 16),
        max_depth: 2,
        spp: 16,
    };
    let mean = |away: Vec3| {
        let corner = Vec3::new(-2.0, -0.7, 2.0);
        let mut plane = quad(corner, Vec3::new(4.0, 1.3, 0.4), Vec3::new(0.3, 0.9, -4.0));
        for position in &mut plane.positions {
            *position += away;
        }
        let material = Material {
            double_sided: true,
            ..lambert(Vec3::splat(0.5))
        };
        let mut scene = scene([(plane, material)], Vec3::ONE);
        scene.instances[0].transform = Affine3A::from_translation(-away);
        let film = render(&device, &mut scene, &from_above(5.0, 0.8), shot);
        let pixels = film.mean();
        let sum: f64 = pixels.iter().map(|rgb| f64::from(rgb[0])).sum();
        sum / pixels.len() as f64
    };
    let near = mean(Vec3::ZERO);
    assert!((near - 0.5).abs() < 0.01, "{near}");
    for distance in [100.0, 1e3, 1e4] {
        let far = mean(distance * Vec3::new(1.0, 0.37, 0.61));
        assert!((far / near - 1.0).abs() < 2e-3, "{far} at {distance} m");
    }
}
