//! The ball that materials are shown on: with a groove and a foot, so that creases and edges show what they do.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Quat, Vec2, Vec3};

use crate::CREASE;
use crate::gltf::{Place, Writer};
use crate::shapes::{circle, lathe, rounded, tube};
use crate::{Shape, pane};

/// Of the ball, metres.
const RADIUS: f32 = 0.5;
/// Height of its middle above the floor.
const MIDDLE: f32 = 0.6;

/// The ball on its foot, a floor, two lamps and a camera. All that has the material `Ball` is to be textured.
pub(crate) fn gallery() -> Writer {
    let mut out = Writer::default();
    let ball = out.material("Ball", [0.6, 0.6, 0.6], 0.0, 0.5);
    let floor = out.material("Floor", [0.26, 0.26, 0.27], 0.0, 0.6);
    let mut shape = lathe(&profile(), 128);
    let handle: Vec<Vec3> = circle(0.07, 48);
    let ring = tube(&handle, |_| 0.02, 16, true);
    shape.add(
        &ring,
        glam::Affine3A::from_translation(Vec3::Y * (MIDDLE + RADIUS + 0.005)),
    );
    let mesh = out.mesh("Ball", &shape.finish(CREASE), ball);
    out.node("Ball", Some(mesh), Place::at(0.0, 0.0, 0.0), None);
    let mut ground = Shape::default();
    let far = 14.0;
    ground.flat_face(&[
        Vec3::new(-far, 0.0, far),
        Vec3::new(far, 0.0, far),
        Vec3::new(far, 0.0, -far),
        Vec3::new(-far, 0.0, -far),
    ]);
    let ground = out.mesh("Floor", &ground.finish(CREASE), floor);
    out.node("Floor", Some(ground), Place::at(0.0, 0.0, 0.0), None);
    for (name, at, half, color, strength) in [
        (
            "Key",
            Vec3::new(-2.2, 2.9, 2.2),
            0.7,
            [1.0, 0.96, 0.9],
            13.0,
        ),
        ("Rim", Vec3::new(2.6, 2.0, -1.6), 0.6, [0.8, 0.9, 1.0], 11.0),
    ] {
        let light = out.light(name, color, strength);
        let lamp = out.mesh(name, &pane(half, half).finish(CREASE), light);
        let aim = (Vec3::Y * MIDDLE - at).normalize();
        let facing = Quat::from_rotation_arc(Vec3::NEG_Y, aim);
        out.node(
            name,
            Some(lamp),
            Place::at(at.x, at.y, at.z).turned(facing),
            None,
        );
    }
    out.camera(
        "Camera",
        Vec3::new(0.5, 1.35, 4.2),
        Vec3::new(0.0, 0.56, 0.0),
        18.0,
    );
    out
}

/// From the foot to the top: (radius, height).
fn profile() -> Vec<Vec2> {
    let foot = [
        (0.0, 0.0),
        (0.36, 0.0),
        (0.36, 0.045),
        (0.29, 0.075),
        (0.27, 0.16),
    ];
    let mut points = rounded(&foot, 0.012, 4);
    points.pop();
    const STEPS: usize = 72;
    // A groove around the upper half, with edges of its own.
    let (low, high, depth) = (0.50, 0.60, 0.03);
    let begin = -((0.27f32 / RADIUS).acos());
    let at = |angle: f32, radius: f32| {
        Vec2::new(angle.cos().max(0.0) * radius, MIDDLE + angle.sin() * radius)
    };
    let mut is_in = false;
    for step in 0..=STEPS {
        let angle = begin + (FRAC_PI_2 - begin) * step as f32 / STEPS as f32;
        let now = (low..high).contains(&angle);
        if now != is_in {
            let edge = if now { low } else { high };
            let (first, second) = match now {
                true => (RADIUS, RADIUS - depth),
                false => (RADIUS - depth, RADIUS),
            };
            points.push(at(edge, first));
            points.push(at(edge, second));
            is_in = now;
        }
        if (angle - low).abs() > TAU / 2000.0 && (angle - high).abs() > TAU / 2000.0 {
            points.push(at(angle, if now { RADIUS - depth } else { RADIUS }));
        }
    }
    points
}
