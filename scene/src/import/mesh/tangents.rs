//! Tangents by MikkTSpace, which glTF prescribes where a normal map has none (glTF 2.0, section 3.7.2.1).
//!
//! MikkTSpace parts corners that lie at one vertex by how the mesh lies. Of one that bends, that would be other vertices at each
//! moment, and neither motion nor hierarchies of another moment would fit: its corners are parted by the side of the texture.

use super::split::{reorder, split_vertices};
use super::vertex_bytes;
use crate::Mesh;
use crate::import::budget::Budget;
use crate::import::error::Fault;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// MikkTSpace takes quadratic time, and recurses, in the number of triangles around a point. Up to this many corners
/// at one position it is used; beyond, which no ordinary model reaches, tangents are averaged by vertices.
const MAX_CORNERS_AT_A_POINT: u32 = 1024;

struct Corners<'a> {
    positions: &'a [Vec3],
    normals: &'a [Vec3],
    uv: &'a [Vec2],
    triangles: &'a [[u32; 3]],
    tangents: Vec<[Vec4; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[self.vertex(face, corner)].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uv[self.vertex(face, corner)].to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let normal = self.normals[self.vertex(face, corner)];
        self.tangents[face][corner] = match space {
            // glTF's v axis points down the image and its bitangent up, hence the opposite sign.
            Some(space) => {
                let sign = if space.is_orientation_preserving() {
                    -1.0
                } else {
                    1.0
                };
                sanitize(Vec3::from(space.tangent()).extend(sign), normal)
            }
            None => sanitize(Vec4::ZERO, normal),
        };
    }
}

/// Gives a mesh with a normal map on set `uv_set` of its texture coordinates tangents. Returns whether it has that set;
/// without it they are some directions along the surface. One that `bends` has the same vertices however it is bent.
pub(in crate::import) fn make(
    mesh: &mut Mesh,
    uv_set: u32,
    bends: bool,
    budget: &Budget,
) -> Result<bool, Fault> {
    let uv = match uv_set {
        0 => &mesh.uv0,
        _ => &mesh.uv1,
    };
    if uv.is_empty() {
        let along = |&normal: &Vec3| sanitize(Vec4::ZERO, normal);
        mesh.tangents = mesh.normals.iter().map(along).collect();
        return Ok(false);
    }
    // Of corners first; then of the vertices that are made of them, few more than there were.
    budget.take(3 * mesh.triangles.len() as u64, size_of::<Vec4>() as u64)?;
    let mut list = std::mem::take(&mut mesh.triangles);
    let (sources, tangents) = generate(&mesh.positions, &mesh.normals, uv, bends, &mut list);
    budget.take(sources.len() as u64, vertex_bytes(mesh))?;
    reorder(mesh, &sources);
    mesh.tangents = tangents;
    mesh.triangles = list;
    Ok(true)
}

/// Gives a mesh tangents by its first texture coordinates, where it has none; vertices are split where these need it, the
/// triangles stay in their order. Without texture coordinates they are some directions along the surface.
pub fn give_tangents(mesh: &mut Mesh) {
    if mesh.tangents.is_empty() {
        // What is in memory already may be three times as much: as many vertices as there are corners.
        let made = make(mesh, 0, mesh.unbent.is_some(), &Budget::new(u64::MAX));
        debug_assert!(made.is_ok(), "nothing bounds the memory");
    }
}

/// Computes tangents and splits vertices where corners disagree. Returns, for each new vertex, the old vertex that it
/// is a copy of, and its tangent. `triangles` is rewritten to the new vertices.
fn generate(
    positions: &[Vec3],
    normals: &[Vec3],
    uv: &[Vec2],
    bends: bool,
    triangles: &mut [[u32; 3]],
) -> (Vec<u32>, Vec<Vec4>) {
    let mut corners = Corners {
        positions,
        normals,
        uv,
        triangles,
        tangents: vec![[Vec4::ZERO; 3]; triangles.len()],
    };
    if bends
        || most_corners_at_a_point(positions, corners.triangles) > MAX_CORNERS_AT_A_POINT
        || generate_tangents(&mut corners).is_err()
    {
        average_by_sides(&mut corners);
    }
    let tangents = corners.tangents;
    split_vertices(positions.len(), triangles, |face, corner| {
        tangents[face][corner]
    })
}

/// A unit tangent with a handedness of ±1; where the given one is useless, some direction perpendicular to the normal.
pub(in crate::import) fn sanitize(tangent: Vec4, normal: Vec3) -> Vec4 {
    let sign = if tangent.w < 0.0 { -1.0 } else { 1.0 };
    let direction = tangent.truncate().normalize_or_zero();
    if direction == Vec3::ZERO {
        return normal.any_orthonormal_vector().extend(sign);
    }
    direction.extend(sign)
}

fn most_corners_at_a_point(positions: &[Vec3], triangles: &[[u32; 3]]) -> u32 {
    let mut per_vertex = vec![0u32; positions.len()];
    for &vertex in triangles.iter().flatten() {
        per_vertex[vertex as usize] += 1;
    }
    let mut per_point: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    for (position, corners) in positions.iter().zip(per_vertex) {
        // Adding zero makes -0 and 0 the same point.
        let key = (*position + Vec3::ZERO).to_array().map(f32::to_bits);
        *per_point.entry(key).or_default() += corners;
    }
    per_point.values().copied().max().unwrap_or(0)
}

/// As MikkTSpace has them, tangents of triangles weighted by their angles at the vertex; but averaged over all of them there that
/// show the same side of the texture. How vertices are split follows from triangles and texture coordinates alone.
fn average_by_sides(corners: &mut Corners<'_>) {
    // Of those whose texture coordinates go round as the triangle does, and of the mirrored ones.
    let mut sums = vec![[None; 2]; corners.positions.len()];
    for triangle in corners.triangles {
        let [a, b, c] = triangle.map(|v| v as usize);
        let (d1, d2) = (corners.uv[b] - corners.uv[a], corners.uv[c] - corners.uv[a]);
        let area = d1.perp_dot(d2);
        if area == 0.0 {
            continue;
        }
        let side = usize::from(area < 0.0);
        let e1 = corners.positions[b] - corners.positions[a];
        let e2 = corners.positions[c] - corners.positions[a];
        let along_u = (e1 * d2.y - e2 * d1.y) * area.signum();
        for [v, next, last] in [[a, b, c], [b, c, a], [c, a, b]] {
            let normal = corners.normals[v];
            let flat = |along: Vec3| (along - normal * normal.dot(along)).normalize_or_zero();
            let at = corners.positions[v];
            let (to_next, to_last) = (
                flat(corners.positions[next] - at),
                flat(corners.positions[last] - at),
            );
            let angle = to_next.dot(to_last).clamp(-1.0, 1.0).acos();
            *sums[v][side].get_or_insert(Vec3::ZERO) += flat(along_u) * angle;
        }
    }
    for (face, triangle) in corners.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| corners.uv[v as usize]);
        let area = (b - a).perp_dot(c - a);
        for (k, &vertex) in triangle.iter().enumerate() {
            let sums = &sums[vertex as usize];
            // A triangle without area in the texture takes what is there.
            let is_mirrored = area < 0.0 || (area == 0.0 && sums[0].is_none());
            let along = sums[usize::from(is_mirrored)].unwrap_or_default();
            // glTF's v axis points down the image and its bitangent up.
            let sign = if is_mirrored { 1.0 } else { -1.0 };
            let normal = corners.normals[vertex as usize];
            corners.tangents[face][k] = sanitize(along.extend(sign), normal);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square in XY facing +Z, its texture upright: u to the right, v down.
    fn square() -> ([Vec3; 4], [Vec3; 4], [Vec2; 4], [[u32; 3]; 2]) {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        (
            corners.map(|[x, y]| Vec3::new(x, y, 0.0)),
            [Vec3::Z; 4],
            corners.map(|[x, y]| Vec2::new(x, 1.0 - y)),
            [[0, 1, 2], [0, 2, 3]],
        )
    }

    #[test]
    fn an_upright_texture_has_its_bitangent_pointing_up() {
        let (positions, normals, uv, mut triangles) = square();
        let (sources, tangents) = generate(&positions, &normals, &uv, false, &mut triangles);
        assert_eq!(sources, [0, 1, 2, 3], "a smooth square needs no split");
        for tangent in tangents {
            assert!(
                tangent.abs_diff_eq(Vec4::new(1.0, 0.0, 0.0, 1.0), 1e-5),
                "{tangent}"
            );
            let bitangent = Vec3::Z.cross(tangent.truncate()) * tangent.w;
            assert!(bitangent.abs_diff_eq(Vec3::Y, 1e-5));
        }
    }

    #[test]
    fn averaging_agrees_with_mikktspace_on_a_flat_square() {
        let (positions, normals, uv, triangles) = square();
        let mut corners = Corners {
            positions: &positions,
            normals: &normals,
            uv: &uv,
            triangles: &triangles,
            tangents: vec![[Vec4::ZERO; 3]; 2],
        };
        average_by_sides(&mut corners);
        for tangent in corners.tangents.into_iter().flatten() {
            assert!(
                tangent.abs_diff_eq(Vec4::new(1.0, 0.0, 0.0, 1.0), 1e-5),
                "{tangent}"
            );
        }
    }

    #[test]
    fn mirrored_textures_part_at_the_seam() {
        let (positions, normals, mut uv, mut triangles) = square();
        // The second triangle is mirrored in u.
        uv[3] = Vec2::new(2.0, 0.0);
        uv[2] = Vec2::new(1.0, 0.0);
        uv[0] = Vec2::new(0.0, 1.0);
        triangles[1] = [0, 2, 3];
        let (_, tangents) = generate(&positions, &normals, &uv, false, &mut triangles);
        assert!(tangents.iter().all(|t| t.is_finite() && t.w.abs() == 1.0));
    }

    /// A piece of a sphere in twelve by twelve squares, mirrored in the middle, and one that is bent.
    #[test]
    fn what_bends_keeps_its_vertices_and_has_nearly_the_tangents_of_mikktspace() {
        const SIDE: u32 = 12;
        let number = |i: u32, j: u32| i * (SIDE + 1) + j;
        let grid = || (0..=SIDE).flat_map(|i| (0..=SIDE).map(move |j| (i, j)));
        let squares = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j)));
        let triangles: Vec<[u32; 3]> = squares
            .flat_map(|(i, j)| {
                let [a, b] = [number(i, j), number(i + 1, j)];
                [[a, b, b + 1], [a, b + 1, a + 1]]
            })
            .collect();
        let part = |n: u32| n as f32 / SIDE as f32;
        let uv: Vec<Vec2> = grid()
            .map(|(i, j)| Vec2::new((part(i) - 0.5).abs(), part(j)))
            .collect();
        let mut splits = Vec::new();
        for bent in [0.0, 0.7] {
            let normals: Vec<Vec3> = grid()
                .map(|(i, j)| {
                    let (around, up) = (2.0 * part(i) + bent * part(j), part(j) - 0.5);
                    let flat = Vec3::new(around.cos(), around.sin(), 0.0);
                    flat * up.cos() + Vec3::Z * up.sin()
                })
                .collect();
            let tangents = |bends: bool| {
                let mut list = triangles.clone();
                let (sources, tangents) = generate(&normals, &normals, &uv, bends, &mut list);
                let corners: Vec<Vec4> = (list.iter().flatten())
                    .map(|&vertex| tangents[vertex as usize])
                    .collect();
                (sources, corners)
            };
            let (sources, found) = tangents(true);
            for (found, expected) in found.iter().zip(tangents(false).1) {
                assert_eq!(found.w, expected.w);
                let cosine = found.truncate().dot(expected.truncate());
                assert!(cosine > 0.9999, "{found} {expected}");
            }
            splits.push(sources);
        }
        let seam = SIDE + 1;
        assert_eq!(splits[0].len() as u32, (SIDE + 1) * (SIDE + 1) + seam);
        assert_eq!(splits[0], splits[1]);
    }

    #[test]
    fn collapsed_texture_coordinates_still_give_unit_tangents() {
        let (positions, normals, _, mut triangles) = square();
        for bends in [false, true] {
            let uv = [Vec2::ZERO; 4];
            let (_, tangents) = generate(&positions, &normals, &uv, bends, &mut triangles);
            for tangent in tangents {
                assert!((tangent.truncate().length() - 1.0).abs() < 1e-5);
                assert!(tangent.truncate().dot(Vec3::Z).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn a_huge_fan_is_bounded_in_time_and_stack() {
        let n = 50_000u32;
        let mut positions = vec![Vec3::ZERO];
        let mut uv = vec![Vec2::ZERO];
        for i in 0..=n {
            let angle = i as f32 / n as f32 * 6.0;
            positions.push(Vec3::new(angle.cos(), angle.sin(), 0.0));
            uv.push(Vec2::new(angle.cos(), angle.sin()));
        }
        let normals = vec![Vec3::Z; positions.len()];
        let mut triangles: Vec<[u32; 3]> = (1..=n).map(|i| [0, i, i + 1]).collect();
        let (_, tangents) = generate(&positions, &normals, &uv, false, &mut triangles);
        assert!(tangents.iter().all(|t| t.truncate().is_normalized()));
    }
}
