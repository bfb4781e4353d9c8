//! Texture coordinates for triangles that have none of their own: flat pieces of the surface, side by side in the unit square.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

/// Cosine of the angle up to which triangles lean from the first one of their piece.
const LEAN: f32 = 0.6;

/// A piece: triangles by their place in the list, and the axes of the plane that they are laid into.
struct Piece {
    triangles: Vec<u32>,
    axes: [Vec3; 2],
    low: Vec2,
    size: Vec2,
}

/// Coordinates for the corners of each triangle, in which no two overlap unless a piece winds over itself; pieces have the
/// same scale, and `margin` between them.
pub(super) fn unwrap(triangles: &[[Vec3; 3]], margin: f32) -> Vec<[Vec2; 3]> {
    let pieces = pieces(triangles);
    let sizes: Vec<Vec2> = pieces.iter().map(|piece| piece.size).collect();
    let packed = [margin, 0.25 * margin, 0.0].map(|margin| (margin, pack(&sizes, margin)));
    let found = packed.into_iter().find(|(_, (scale, _))| *scale > 0.0);
    let (margin, (scale, places)) = found.unwrap_or((0.0, (0.0, vec![Vec2::ZERO; sizes.len()])));
    let mut uv = vec![[Vec2::ZERO; 3]; triangles.len()];
    for (piece, place) in pieces.iter().zip(places) {
        for &triangle in &piece.triangles {
            let flat = triangles[triangle as usize].map(|p| laid(p, piece.axes) - piece.low);
            uv[triangle as usize] = flat.map(|p| place + 0.5 * margin + p * scale);
        }
    }
    uv
}

fn laid(p: Vec3, [x, y]: [Vec3; 2]) -> Vec2 {
    Vec2::new(p.dot(x), p.dot(y))
}

/// Groups triangles that share edges and look about the same way.
fn pieces(triangles: &[[Vec3; 3]]) -> Vec<Piece> {
    let key = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    let edge = |a: Vec3, b: Vec3| {
        let (a, b) = (key(a), key(b));
        if a < b { [a, b] } else { [b, a] }
    };
    let edges = |t: &[Vec3; 3]| [edge(t[0], t[1]), edge(t[1], t[2]), edge(t[2], t[0])];
    let mut at_edge: HashMap<_, Vec<u32>> = HashMap::new();
    for (number, triangle) in (0u32..).zip(triangles) {
        for edge in edges(triangle) {
            at_edge.entry(edge).or_default().push(number);
        }
    }
    let normal = |t: &[Vec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero();
    let mut is_taken = vec![false; triangles.len()];
    let mut pieces = Vec::new();
    for first in 0..triangles.len() as u32 {
        if std::mem::replace(&mut is_taken[first as usize], true) {
            continue;
        }
        let facing = normal(&triangles[first as usize]);
        let mut members = vec![first];
        let mut next = 0;
        while next < members.len() {
            let triangle = &triangles[members[next] as usize];
            next += 1;
            for edge in edges(triangle) {
                let around = &at_edge[&edge];
                // Where many meet, each begins a piece of its own.
                if around.len() > 2 {
                    continue;
                }
                for &other in around {
                    let leans = normal(&triangles[other as usize]).dot(facing) < LEAN;
                    if !leans && !std::mem::replace(&mut is_taken[other as usize], true) {
                        members.push(other);
                    }
                }
            }
        }
        pieces.push(piece(triangles, members, facing));
    }
    pieces
}

fn piece(triangles: &[[Vec3; 3]], members: Vec<u32>, facing: Vec3) -> Piece {
    let x = match facing == Vec3::ZERO {
        true => Vec3::X,
        false => facing.any_orthonormal_vector(),
    };
    let axes = [x, facing.cross(x)];
    let corners = members.iter().flat_map(|&t| triangles[t as usize]);
    let (low, high) = corners
        .map(|p| laid(p, axes))
        .fold((Vec2::MAX, Vec2::MIN), |(low, high), p| {
            (low.min(p), high.max(p))
        });
    Piece {
        triangles: members,
        axes,
        low,
        size: high - low,
    }
}

/// The greatest scale at which boxes stand in rows within the unit square, and where; 0 where none is found.
fn pack(sizes: &[Vec2], margin: f32) -> (f32, Vec<Vec2>) {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by(|&a, &b| sizes[b].y.total_cmp(&sizes[a].y).then(a.cmp(&b)));
    let area: f32 = sizes.iter().map(|size| size.x * size.y).sum();
    let longest = sizes
        .iter()
        .map(|size| size.max_element())
        .fold(0.0, f32::max);
    if longest <= 0.0 {
        return (1.0, vec![Vec2::splat(0.25); sizes.len()]);
    }
    let (mut low, mut high) = (0.0, (1.0 / longest).min(1.0 / area.max(1e-30).sqrt()));
    let mut best = (0.0, vec![Vec2::ZERO; sizes.len()]);
    for step in 0..24 {
        // First the greatest that could be.
        let scale = if step == 0 { high } else { 0.5 * (low + high) };
        match rows(sizes, &order, scale, margin) {
            Some(places) => {
                low = scale;
                best = (scale, places);
            }
            None => high = scale,
        }
    }
    best
}

fn rows(sizes: &[Vec2], order: &[usize], scale: f32, margin: f32) -> Option<Vec<Vec2>> {
    let mut places = vec![Vec2::ZERO; sizes.len()];
    let (mut x, mut y, mut height) = (0.0f32, 0.0f32, 0.0f32);
    for &i in order {
        let size = sizes[i] * scale + margin;
        if x + size.x > 1.0 {
            (x, y, height) = (0.0, y + height, 0.0);
        }
        if size.x > 1.0 || y + size.y > 1.0 {
            return None;
        }
        places[i] = Vec2::new(x, y);
        x += size.x;
        height = height.max(size.y);
    }
    Some(places)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::cover::{Drawn, cover};

    /// The sides of a cube.
    fn cube() -> Vec<[Vec3; 3]> {
        let mut triangles = Vec::new();
        for axis in 0..3 {
            for side in [0.0, 1.0] {
                let at = |u: f32, v: f32| {
                    let mut p = [0.0; 3];
                    p[axis] = side;
                    p[(axis + 1) % 3] = u;
                    p[(axis + 2) % 3] = v;
                    Vec3::from(p)
                };
                let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        triangles
    }

    #[test]
    fn a_cube_falls_apart_into_its_sides() {
        let uv = unwrap(&cube(), 0.01);
        let drawn: Vec<Drawn> = (0..)
            .zip(&uv)
            .map(|(triangle, &uv)| Drawn { triangle, uv })
            .collect();
        let covered = cover(&drawn, 256, 1, 0..256);
        assert_eq!(covered.twice, 0);
        assert!(
            covered.samples.len() > 256 * 256 / 2,
            "{}",
            covered.samples.len()
        );
        let inside = |p: &Vec2| p.min_element() >= 0.0 && p.max_element() <= 1.0;
        assert!(uv.iter().flatten().all(inside));
    }

    #[test]
    fn nothing_and_points_are_no_trouble() {
        assert!(unwrap(&[], 0.01).is_empty());
        let points = [[Vec3::ONE; 3]; 5];
        assert!(
            unwrap(&points, 0.01)
                .iter()
                .flatten()
                .all(|p| p.is_finite())
        );
        let many: Vec<[Vec3; 3]> = (0..2000)
            .map(|i| [0.0, 1.0, 2.0].map(|k| Vec3::new(i as f32 * 9.0 + k, k * k, 0.0)))
            .collect();
        assert!(unwrap(&many, 0.1).iter().flatten().all(|p| p.is_finite()));
    }
}
