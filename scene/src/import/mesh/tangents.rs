//! Tangents by MikkTSpace, which glTF prescribes where a normal map has none (glTF 2.0, section 3.7.2.1).

use super::split::{reorder, split_vertices};
use super::vertex_bytes;
use crate::Mesh;
use crate::import::budget::Budget;
use crate::import::error::Fault;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// MikkTSpace takes quadratic time, and recurses, in the number of triangles around a point. Up to this many corners
/// at one position it is used; beyond, which no ordinary model reaches, tangents are averaged.
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
/// without it they are some directions along the surface.
pub(in crate::import) fn make(
    mesh: &mut Mesh,
    uv_set: u32,
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
    budget.take(3 * mesh.triangles.len() as u64, vertex_bytes(mesh))?;
    let mut list = std::mem::take(&mut mesh.triangles);
    let (sources, tangents) = generate(&mesh.positions, &mesh.normals, uv, &mut list);
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
        let made = make(mesh, 0, &Budget::new(u64::MAX));
        debug_assert!(made.is_ok(), "nothing bounds the memory");
    }
}

/// Computes tangents and splits vertices where corners disagree. Returns, for each new vertex, the old vertex that it
/// is a copy of, and its tangent. `triangles` is rewritten to the new vertices.
fn generate(
    positions: &[Vec3],
    normals: &[Vec3],
    uv: &[Vec2],
    triangles: &mut [[u32; 3]],
) -> (Vec<u32>, Vec<Vec4>) {
    let mut corners = Corners {
        positions,
        normals,
        uv,
        triangles,
        tangents: vec![[Vec4::ZERO; 3]; triangles.len()],
    };
    if most_corners_at_a_point(positions, corners.triangles) > MAX_CORNERS_AT_A_POINT
        || generate_tangents(&mut corners).is_err()
    {
        average(&mut corners);
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

/// Tangents averaged over the triangles around each vertex (Lengyel).
fn average(corners: &mut Corners<'_>) {
    let mut sums = vec![(Vec3::ZERO, Vec3::ZERO); corners.positions.len()];
    for triangle in corners.triangles {
        let [a, b, c] = triangle.map(|v| v as usize);
        let (e1, e2) = (
            corners.positions[b] - corners.positions[a],
            corners.positions[c] - corners.positions[a],
        );
        let (d1, d2) = (corners.uv[b] - corners.uv[a], corners.uv[c] - corners.uv[a]);
        let area = d1.x * d2.y - d2.x * d1.y;
        if area == 0.0 {
            continue;
        }
        let along_u = ((e1 * d2.y - e2 * d1.y) / area).normalize_or_zero();
        let along_v = ((e2 * d1.x - e1 * d2.x) / area).normalize_or_zero();
        for v in [a, b, c] {
            sums[v].0 += along_u;
            sums[v].1 += along_v;
        }
    }
    for (face, triangle) in corners.triangles.iter().enumerate() {
        for (k, &vertex) in triangle.iter().enumerate() {
            let normal = corners.normals[vertex as usize];
            let (along_u, along_v) = sums[vertex as usize];
            let tangent = along_u - normal * normal.dot(along_u);
            let sign = if normal.cross(tangent).dot(along_v) < 0.0 {
                1.0
            } else {
                -1.0
            };
            corners.tangents[face][k] = sanitize(tangent.extend(sign), normal);
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
        let (sources, tangents) = generate(&positions, &normals, &uv, &mut triangles);
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
        average(&mut corners);
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
        let (_, tangents) = generate(&positions, &normals, &uv, &mut triangles);
        assert!(tangents.iter().all(|t| t.is_finite() && t.w.abs() == 1.0));
    }

    #[test]
    fn collapsed_texture_coordinates_still_give_unit_tangents() {
        let (positions, normals, _, mut triangles) = square();
        let (_, tangents) = generate(&positions, &normals, &[Vec2::ZERO; 4], &mut triangles);
        for tangent in tangents {
            assert!((tangent.truncate().length() - 1.0).abs() < 1e-5);
            assert!(tangent.truncate().dot(Vec3::Z).abs() < 1e-5);
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
        let (_, tangents) = generate(&positions, &normals, &uv, &mut triangles);
        assert!(tangents.iter().all(|t| t.truncate().is_normalized()));
    }
}
