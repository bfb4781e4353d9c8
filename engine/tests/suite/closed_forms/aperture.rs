//! Thin-lens cameras: a point out of focus has the shape of the aperture, evenly filled.

use std::f32::consts::{PI, TAU};

use engine::scene::Scene;
use glam::{Vec2, Vec3, Vec4};

use super::PASSING;
use crate::support::device;
use crate::support::estimate::Estimate;
use crate::support::scenes::{Shot, add, floor, from_above, render, unlit};
use crate::support::stats::ZTest;

/// Pixels along a side of the picture, and metres from its centre to its edge.
const SIDE: u32 = 24;
const HALF: f32 = 1.5;
/// Half the side of the square that is seen, metres.
const SQUARE: f32 = 0.15;
/// How far means may be off, relative: some five thousand samples meet the square, a standard error of 0.014.
const MEAN_ERROR: f64 = 0.05;

/// How far a point is inside the aperture of radius 1, metres; negative outside.
fn depth_inside(blades: u32, rotation: f32, p: Vec2) -> f32 {
    if blades < 3 {
        return 1.0 - p.length();
    }
    let apothem = (PI / blades as f32).cos();
    let side = |k: u32| {
        let angle = rotation + TAU * (k as f32 + 0.5) / blades as f32;
        apothem - p.dot(Vec2::from_angle(angle))
    };
    (0..blades).map(side).fold(f32::INFINITY, f32::min)
}

#[test]
fn a_point_out_of_focus_has_the_shape_of_the_aperture() {
    let Some(device) = device::open() else { return };
    for (blades, rotation) in [(0, 0.0), (3, 0.3), (6, 0.0), (5, 1.2)] {
        // In focus is what lies halfway: a ray through the middle of the lens's picture meets the floor as far on the other
        // side, so that a pixel sees the square through the part of the lens that lies where the pixel does.
        let mut camera = from_above(2.0, HALF);
        camera.aperture_radius = 1.0;
        camera.aperture_blades = blades;
        camera.aperture_rotation = rotation;
        camera.focus_distance = 1.0;
        let mut scene = Scene::default();
        add(&mut scene, floor(SQUARE), unlit(Vec4::ONE));
        let shot = Shot {
            size: (SIDE, SIDE),
            max_depth: 1,
            spp: 2048,
        };
        let film = render(&device, &mut scene, &camera, shot);
        let area = match blades {
            0 => PI,
            n => 0.5 * n as f32 * (TAU / n as f32).sin(),
        };
        let inside = 4.0 * SQUARE * SQUARE / area;
        let pixel = 2.0 * HALF / SIDE as f32;
        let depth = |x: usize, y: usize| {
            let place = Vec2::new(x as f32 + 0.5, SIDE as f32 - y as f32 - 0.5) * pixel - HALF;
            depth_inside(blades, rotation, place)
        };
        let picture = |at: Vec2| {
            let (x, y) = (at.x * SIDE as f32, at.y * SIDE as f32);
            match depth(x as usize, y as usize) {
                d if d > 0.0 => Vec3::splat(inside),
                _ => Vec3::ZERO,
            }
        };
        let exact = Estimate::exact((SIDE, SIDE), picture);
        // What a pixel sees through is as wide as itself and the square.
        let margin = 0.5 * pixel * 1.5 + SQUARE * 1.5;
        let compared = ZTest::default().compare(Estimate::from_film(&film), exact, |x, y| {
            depth(x, y).abs() > margin
        });
        compared.assert_matches(&format!("{blades} blades"), PASSING, MEAN_ERROR);
        // All that enters the lens is somewhere.
        let all: f32 = film.mean().iter().map(|mean| mean[0]).sum::<f32>() * pixel * pixel;
        let expected = 4.0 * SQUARE * SQUARE;
        assert!(
            f64::from(all / expected - 1.0).abs() < MEAN_ERROR,
            "{blades} blades: {all}"
        );
    }
}
