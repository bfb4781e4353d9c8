//! The shapes of the demo scene: turned, swept, cut from blocks. All in metres around the origin, Y up.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};

use crate::mesh::Shape;

/// Rounds the corners of a line of points: each is cut back by at most `radius` and replaced by a parabola.
pub(crate) fn rounded(points: &[(f32, f32)], radius: f32, steps: usize) -> Vec<Vec2> {
    let points: Vec<Vec2> = points.iter().map(|&p| Vec2::from(p)).collect();
    let mut out = vec![points[0]];
    for i in 1..points.len() - 1 {
        let (before, corner, after) = (points[i - 1], points[i], points[i + 1]);
        let cut = |to: Vec2| {
            let way = to - corner;
            corner + way * (radius / way.length()).min(0.45)
        };
        let (from, to) = (cut(before), cut(after));
        for step in 0..=steps {
            let t = step as f32 / steps as f32;
            out.push(from.lerp(corner, t).lerp(corner.lerp(to, t), t));
        }
    }
    out.push(points[points.len() - 1]);
    out
}

/// Turns a profile of (radius, height) about Y. From bottom to top it faces outwards.
pub(crate) fn lathe(profile: &[Vec2], segments: usize) -> Shape {
    let mut shape = Shape::default();
    let length: Vec<f32> = profile
        .iter()
        .scan((0.0, profile[0]), |(sum, last), &p| {
            *sum += p.distance(*last);
            *last = p;
            Some(*sum)
        })
        .collect();
    let widest = profile.iter().fold(0.0f32, |r, p| r.max(p.x));
    let point = |i: usize, s: usize| {
        let angle = s as f32 / segments as f32 * TAU;
        let (sin, cos) = if s == segments {
            (0.0, 1.0)
        } else {
            angle.sin_cos()
        };
        let position = Vec3::new(profile[i].x * cos, profile[i].y, -profile[i].x * sin);
        (position, Vec2::new(angle * widest, length[i]))
    };
    for i in 0..profile.len() - 1 {
        for s in 0..segments {
            shape.face(&[
                point(i, s),
                point(i, s + 1),
                point(i + 1, s + 1),
                point(i + 1, s),
            ]);
        }
    }
    shape
}

/// A tube along a path whose radius may change; its ends are closed unless the path is.
pub(crate) fn tube(
    path: &[Vec3],
    radius: impl Fn(f32) -> f32,
    segments: usize,
    closed: bool,
) -> Shape {
    let count = path.len();
    let direction = |i: usize| {
        let (a, b) = if closed {
            (path[(i + count - 1) % count], path[(i + 1) % count])
        } else {
            (path[i.saturating_sub(1)], path[(i + 1).min(count - 1)])
        };
        (b - a).normalize()
    };
    // The frame is carried along by the smallest turn, so that it never twists by itself.
    let mut side = direction(0).any_orthonormal_vector();
    let mut rings: Vec<Vec<(Vec3, Vec2)>> = Vec::new();
    let mut length = 0.0;
    for i in 0..count {
        if i > 0 {
            side = Quat::from_rotation_arc(direction(i - 1), direction(i)) * side;
            length += path[i].distance(path[i - 1]);
        }
        let up = direction(i).cross(side);
        let r = radius(i as f32 / (count - 1) as f32);
        let ring = (0..=segments).map(|s| {
            let angle = (s % segments) as f32 / segments as f32 * TAU;
            let position = path[i] + (side * angle.cos() + up * angle.sin()) * r;
            (
                position,
                Vec2::new(s as f32 / segments as f32 * TAU * r, length),
            )
        });
        rings.push(ring.collect());
    }
    let mut shape = Shape::default();
    for i in 0..if closed { count } else { count - 1 } {
        let (a, b) = (&rings[i], &rings[(i + 1) % count]);
        for s in 0..segments {
            shape.face(&[a[s], a[s + 1], b[s + 1], b[s]]);
        }
    }
    if !closed {
        let first: Vec<_> = rings[0][..segments].iter().rev().map(|c| c.0).collect();
        let last: Vec<_> = rings[count - 1][..segments].iter().map(|c| c.0).collect();
        shape.flat_face(&first);
        shape.flat_face(&last);
    }
    shape
}

/// Points of a circle about Y.
pub(crate) fn circle(radius: f32, segments: usize) -> Vec<Vec3> {
    (0..segments)
        .map(|s| (s as f32 / segments as f32 * TAU).sin_cos())
        .map(|(sin, cos)| Vec3::new(cos * radius, 0.0, -sin * radius))
        .collect()
}

/// A six-sided block by its corners (bit 0 of the index is x, bit 1 y, bit 2 z) with edges cut by `bevel`.
pub(crate) fn block(corners: &[Vec3; 8], bevel: f32) -> Shape {
    // Each face counter-clockwise from outside.
    const FACES: [[usize; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let inset = |face: &[usize; 4], corner: usize| {
        let at = face
            .iter()
            .position(|&c| c == corner)
            .expect("the corner is of this face");
        let c = corners[corner];
        let towards = |other: usize| (corners[other] - c).normalize() * bevel;
        c + towards(face[(at + 1) % 4]) + towards(face[(at + 3) % 4])
    };
    let mut shape = Shape::default();
    for face in &FACES {
        shape.flat_face(&face.map(|c| inset(face, c)));
        for i in 0..4 {
            let (a, b) = (face[i], face[(i + 1) % 4]);
            let other = FACES
                .iter()
                .find(|f| (0..4).any(|j| f[j] == b && f[(j + 1) % 4] == a))
                .expect("each edge of a block is of two faces");
            // Both faces see the edge; only one adds its bevel.
            if a < b {
                shape.flat_face(&[
                    inset(face, b),
                    inset(face, a),
                    inset(other, a),
                    inset(other, b),
                ]);
            }
        }
    }
    for corner in 0..8 {
        let mut around: Vec<Vec3> = FACES
            .iter()
            .filter(|f| f.contains(&corner))
            .map(|f| inset(f, corner))
            .collect();
        let outwards = corners[corner] - corners.iter().sum::<Vec3>() / 8.0;
        if (around[1] - around[0])
            .cross(around[2] - around[0])
            .dot(outwards)
            < 0.0
        {
            around.swap(1, 2);
        }
        shape.flat_face(&around);
    }
    shape
}

/// A block with right angles between two corners.
pub(crate) fn cuboid(min: Vec3, max: Vec3, bevel: f32) -> Shape {
    let corner = |i: usize| {
        Vec3::new(
            if i & 1 == 0 { min.x } else { max.x },
            if i & 2 == 0 { min.y } else { max.y },
            if i & 4 == 0 { min.z } else { max.z },
        )
    };
    block(&std::array::from_fn(corner), bevel)
}

/// A hexagonal prism with rounded top, standing on the origin; `width` across the corners.
pub(crate) fn hexagon_head(width: f32, height: f32) -> Shape {
    let r = width / 2.0;
    let profile = [
        (r, 0.0),
        (r, height * 0.8),
        (r * 0.82, height),
        (0.0, height),
    ];
    lathe(&profile.map(Vec2::from), 6)
}

/// A spur gear about Y with a hub and holes in its web seen as a recess, lying on the origin.
pub(crate) fn gear(radius: f32, teeth: usize, thickness: f32) -> Shape {
    let tooth = radius * 0.11;
    // A tooth is eight samples: root, flank, tip, flank.
    let outline = |s: usize, inset: f32| {
        const HEIGHT: [f32; 8] = [0.0, 0.0, 0.0, 0.55, 1.0, 1.0, 1.0, 0.55];
        const SHIFT: [f32; 8] = [0.0, 0.0, 0.0, 0.1, 0.15, 0.0, -0.15, -0.1];
        let angle = (s as f32 + SHIFT[s % 8]) / (8 * teeth) as f32 * TAU;
        let r = radius - tooth + HEIGHT[s % 8] * tooth - inset;
        Vec3::new(angle.cos() * r, 0.0, -angle.sin() * r)
    };
    let ring = |r: f32, y: f32| {
        move |s: usize| {
            let angle = s as f32 / (8 * teeth) as f32 * TAU;
            Vec3::new(angle.cos() * r, y, -angle.sin() * r)
        }
    };
    let edge = |inset: f32, y: f32| move |s: usize| outline(s, inset) + Vec3::Y * y;
    let bevel = thickness * 0.06;
    let rim = radius * 0.78;
    let (hub, bore) = (radius * 0.3, radius * 0.14);
    let web = thickness * 0.3;
    type Ring<'a> = Box<dyn Fn(usize) -> Vec3 + 'a>;
    let half: Vec<Ring<'_>> = vec![
        Box::new(edge(0.0, thickness / 2.0 - bevel)),
        Box::new(edge(bevel, thickness / 2.0)),
        Box::new(ring(rim, thickness / 2.0)),
        Box::new(ring(rim - bevel, thickness / 2.0 - bevel)),
        Box::new(ring(rim - 2.0 * bevel, web / 2.0)),
        Box::new(ring(hub + 2.0 * bevel, web / 2.0)),
        Box::new(ring(hub + bevel, thickness * 0.6 - bevel)),
        Box::new(ring(hub, thickness * 0.6)),
        Box::new(ring(bore + bevel, thickness * 0.6)),
        Box::new(ring(bore, thickness * 0.6 - bevel)),
    ];
    let mut upper = Shape::default();
    let count = 8 * teeth;
    for pair in half.windows(2) {
        for s in 0..count {
            let next = (s + 1) % count;
            upper.flat_face(&[pair[0](s), pair[0](next), pair[1](next), pair[1](s)]);
        }
    }
    let mirror = Affine3A::from_scale(Vec3::new(1.0, -1.0, 1.0));
    let mut shape = Shape::default();
    shape.add(&upper, Affine3A::IDENTITY).add(&upper, mirror);
    for s in 0..count {
        let next = (s + 1) % count;
        let flip = |p: Vec3| Vec3::new(p.x, -p.y, p.z);
        let (a, b) = (half[0](s), half[0](next));
        shape.flat_face(&[flip(a), flip(b), b, a]);
        let (a, b) = (half[9](s), half[9](next));
        shape.flat_face(&[a, b, flip(b), flip(a)]);
    }
    let mut lying = Shape::default();
    lying.add(
        &shape,
        Affine3A::from_translation(Vec3::Y * thickness * 0.6),
    );
    lying
}

/// A wall of `height` over a round arch of `radius` that springs from the floor of the shape, `width` wide and
/// `depth` thick (along Z, centred).
pub(crate) fn arch_wall(width: f32, height: f32, radius: f32, depth: f32) -> Shape {
    let half = width / 2.0;
    let corner = height.atan2(half);
    let mut angles: Vec<f32> = (0..=32).map(|i| PI * i as f32 / 32.0).collect();
    angles.extend([corner, PI - corner]);
    angles.sort_by(f32::total_cmp);
    let inner = |a: f32| Vec2::new(a.cos(), a.sin()) * radius;
    let outer = |a: f32| {
        let d = Vec2::new(a.cos(), a.sin());
        d * (half / d.x.abs().max(1e-6)).min(height / d.y.max(1e-6))
    };
    let at = |p: Vec2, z: f32| p.extend(z);
    let (front, back) = (depth / 2.0, -depth / 2.0);
    let mut shape = Shape::default();
    for pair in angles.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        shape.flat_face(&[
            at(inner(a), front),
            at(outer(a), front),
            at(outer(b), front),
            at(inner(b), front),
        ]);
        shape.flat_face(&[
            at(inner(b), back),
            at(outer(b), back),
            at(outer(a), back),
            at(inner(a), back),
        ]);
        shape.flat_face(&[
            at(inner(a), back),
            at(inner(a), front),
            at(inner(b), front),
            at(inner(b), back),
        ]);
        shape.flat_face(&[
            at(outer(b), back),
            at(outer(b), front),
            at(outer(a), front),
            at(outer(a), back),
        ]);
    }
    shape
}

/// The ring of wedge stones of an arch, `count` of them from `inner` to `outer` radius, `depth` thick.
pub(crate) fn voussoirs(inner: f32, outer: f32, depth: f32, count: usize) -> Shape {
    let mut shape = Shape::default();
    let gap = 0.004;
    for i in 0..count {
        let angle = |k: usize| PI * (i + k) as f32 / count as f32;
        let (a, b) = (angle(0) + gap, angle(1) - gap);
        // The keystone stands out.
        let proud = if 2 * i + 1 == count { 0.025 } else { 0.0 };
        let corner = |k: usize| {
            let angle = if k & 1 == 0 { b } else { a };
            let r = if k & 2 == 0 { inner } else { outer + proud };
            let z = (depth / 2.0 + proud) * if k & 4 == 0 { -1.0 } else { 1.0 };
            Vec3::new(angle.cos() * r, angle.sin() * r, z)
        };
        shape.add(
            &block(&std::array::from_fn(corner), 0.008),
            Affine3A::IDENTITY,
        );
    }
    shape
}

/// A quarter turn that lays Y along X.
pub(crate) fn lay_along_x() -> Affine3A {
    Affine3A::from_rotation_z(-FRAC_PI_2)
}
