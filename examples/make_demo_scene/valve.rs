//! The gate valve: body, flanges, bonnet, yoke, stem, handwheel. Its flow runs along X; it stands on the origin.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};

use crate::gltf::{Place, Writer};
use crate::mesh::Shape;
use crate::shapes::{circle, cuboid, lathe, lay_along_x, rounded, tube};
use crate::{CREASE, bolt_head};

/// Height of the flow's axis.
const AXIS: f32 = 0.27;

/// Adds the valve at `place`.
pub(crate) fn valve(out: &mut Writer, place: Place) {
    let paint = out.material("ValvePaint", [0.025, 0.13, 0.10], 0.0, 0.32);
    let wheel_paint = out.material("WheelPaint", [0.42, 0.035, 0.02], 0.0, 0.3);
    let iron = out.material("BoltIron", [0.42, 0.41, 0.40], 1.0, 0.45);
    let root = out.node("Valve", None, place, None);
    let origin = Place::at(0.0, 0.0, 0.0);

    let body = out.mesh("Valve body", &body().finish(CREASE), paint);
    out.node("Valve body", Some(body), origin, Some(root));
    let bonnet = out.mesh("Bonnet", &bonnet().finish(CREASE), paint);
    out.node("Bonnet", Some(bonnet), origin, Some(root));
    let wheel = out.mesh("Handwheel", &handwheel().finish(CREASE), wheel_paint);
    let tilt = Quat::from_rotation_y(0.5);
    out.node(
        "Handwheel",
        Some(wheel),
        Place::at(0.0, 1.1, 0.0).turned(tilt),
        Some(root),
    );
    let stem = out.mesh("Stem", &stem().finish(1.2), iron);
    out.node("Stem", Some(stem), Place::at(0.0, 0.72, 0.0), Some(root));

    let bolt = out.mesh("Bolt", &bolt_head(0.05, 0.028).finish(0.9), iron);
    for side in [-1.0, 1.0] {
        for face in [-1.0, 1.0] {
            let x = side * 0.395 + face * 0.0265;
            let turn = Quat::from_rotation_z(-face * PI / 2.0);
            for at in circle(0.185, 8) {
                let place = Place::at(x, AXIS + at.x, at.z).turned(turn);
                out.node("Bolt", Some(bolt), place, Some(root));
            }
        }
    }
    for at in circle(0.168, 8) {
        let above = Place::at(at.x, 0.605, at.z);
        let below = Place::at(at.x, 0.52, at.z).turned(Quat::from_rotation_x(PI));
        out.node("Bolt", Some(bolt), above, Some(root));
        out.node("Bolt", Some(bolt), below, Some(root));
    }
}

/// The body: a bulged barrel with a pipe through it and a foot.
fn body() -> Shape {
    let barrel = rounded(
        &[
            (0.0, 0.07),
            (0.1, 0.075),
            (0.15, 0.13),
            (0.168, 0.27),
            (0.15, 0.42),
            (0.135, 0.46),
            (0.135, 0.515),
            (0.205, 0.52),
            (0.205, 0.56),
            (0.0, 0.56),
        ],
        0.03,
        5,
    );
    let mut shape = lathe(&barrel, 40);
    // One half of the pipe from the middle to the flange; a bore lets one look inside.
    let pipe = rounded(
        &[
            (0.15, 0.0),
            (0.14, 0.1),
            (0.118, 0.18),
            (0.118, 0.3),
            (0.135, 0.365),
            (0.228, 0.37),
            (0.228, 0.42),
            (0.15, 0.421),
            (0.146, 0.429),
            (0.1, 0.43),
            (0.098, 0.42),
            (0.098, 0.14),
            (0.0, 0.139),
        ],
        0.012,
        4,
    );
    let half = lathe(&pipe, 40);
    let axis = Affine3A::from_translation(Vec3::Y * AXIS);
    shape.add(&half, axis * lay_along_x());
    shape.add(&half, axis * Affine3A::from_rotation_y(PI) * lay_along_x());
    let foot = cuboid(
        Vec3::new(-0.13, 0.0, -0.1),
        Vec3::new(0.13, 0.035, 0.1),
        0.008,
    );
    let rib = cuboid(
        Vec3::new(-0.1, 0.03, -0.018),
        Vec3::new(0.1, 0.2, 0.018),
        0.006,
    );
    shape.add(&foot, Affine3A::IDENTITY);
    shape.add(&rib, Affine3A::IDENTITY);
    shape.add(&rib, Affine3A::from_rotation_y(PI / 2.0));
    shape
}

/// The bonnet with its flange, the gland, and the yoke that carries the wheel.
fn bonnet() -> Shape {
    let profile = rounded(
        &[
            (0.0, 0.566),
            (0.205, 0.566),
            (0.205, 0.605),
            (0.13, 0.61),
            (0.118, 0.65),
            (0.07, 0.74),
            (0.065, 0.77),
            (0.09, 0.775),
            (0.09, 0.8),
            (0.05, 0.805),
            (0.045, 0.83),
            (0.0, 0.832),
        ],
        0.016,
        4,
    );
    let mut shape = lathe(&profile, 40);
    let arm: Vec<Vec3> = (0..=20)
        .map(|i| i as f32 / 20.0)
        .map(|t| {
            let bulge = (t * PI).sin().powf(0.7);
            Vec3::new(0.075 + 0.075 * bulge - 0.03 * t, 0.66 + 0.39 * t, 0.0)
        })
        .collect();
    let arm = tube(&arm, |t| 0.024 - 0.004 * t, 16, false);
    shape.add(&arm, Affine3A::IDENTITY);
    shape.add(&arm, Affine3A::from_rotation_y(PI));
    let head = rounded(
        &[
            (0.0, 1.01),
            (0.05, 1.01),
            (0.062, 1.03),
            (0.062, 1.065),
            (0.045, 1.08),
            (0.0, 1.08),
        ],
        0.01,
        3,
    );
    shape.add(&lathe(&head, 40), Affine3A::IDENTITY);
    shape
}

/// The wheel about the origin: a rim, five bent spokes, a hub.
fn handwheel() -> Shape {
    let rim = circle(0.27, 72);
    let mut shape = tube(&rim, |_| 0.02, 16, true);
    let hub = rounded(
        &[
            (0.0, -0.02),
            (0.05, -0.02),
            (0.055, 0.0),
            (0.05, 0.04),
            (0.035, 0.05),
            (0.0, 0.05),
        ],
        0.008,
        3,
    );
    shape.add(&lathe(&hub, 32), Affine3A::IDENTITY);
    let spoke: Vec<Vec3> = (0..=12)
        .map(|i| i as f32 / 12.0)
        .map(|t| {
            Vec3::new(
                0.04 + 0.228 * t,
                0.012 - 0.035 * (t * PI).sin(),
                0.03 * (t * PI).sin(),
            )
        })
        .collect();
    let spoke = tube(&spoke, |t| 0.016 - 0.003 * (t * PI).sin(), 12, false);
    for i in 0..5 {
        shape.add(&spoke, Affine3A::from_rotation_y(TAU * i as f32 / 5.0));
    }
    shape
}

/// The threaded stem from the gland through the wheel, with its nut.
fn stem() -> Shape {
    let (from, to, pitch) = (0.08, 0.5, 0.011);
    let turns = ((to - from) / pitch) as usize;
    let mut profile = vec![
        Vec2::new(0.0, 0.0),
        Vec2::new(0.021, 0.0),
        Vec2::new(0.021, from),
    ];
    for i in 0..turns {
        let y = from + i as f32 * pitch;
        profile.push(Vec2::new(0.0235, y + pitch * 0.25));
        profile.push(Vec2::new(0.0235, y + pitch * 0.5));
        profile.push(Vec2::new(0.0195, y + pitch * 0.75));
        profile.push(Vec2::new(0.0195, y + pitch));
    }
    profile.extend([Vec2::new(0.019, to + 0.008), Vec2::new(0.0, to + 0.01)]);
    let mut shape = lathe(&profile, 14);
    shape.add(
        &bolt_head(0.075, 0.035),
        Affine3A::from_translation(Vec3::Y * 0.43),
    );
    shape
}
