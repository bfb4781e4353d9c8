//! Normals: flat ones where a file has none, and unit length for those that it has.

use super::split::{reorder, split_vertices};
use super::{Dropped, triangles, vertex_bytes};
use crate::Mesh;
use crate::import::budget::Budget;
use crate::import::error::Fault;
use glam::Vec3;

/// Gives each triangle its own normal (glTF 2.0, section 3.7.2.1: without normals, shading is flat). In a mesh that `bends`
/// triangles share no vertices, however it is bent.
pub(in crate::import) fn make_flat(
    mesh: &mut Mesh,
    bends: bool,
    budget: &Budget,
) -> Result<(), Fault> {
    let normals: Vec<Vec3> = mesh
        .triangles
        .iter()
        .map(|&triangle| triangles::cross(triangle, &mesh.positions).normalize_or(Vec3::Z))
        .collect();
    budget.take(3 * normals.len() as u64, vertex_bytes(mesh))?;
    let mut list = std::mem::take(&mut mesh.triangles);
    let (sources, normals) = split_vertices(mesh.positions.len(), &mut list, |t, _| {
        (normals[t], if bends { t } else { 0 })
    });
    reorder(mesh, &sources);
    mesh.normals = normals.into_iter().map(|(normal, _)| normal).collect();
    mesh.triangles = list;
    Ok(())
}

/// Makes normals unit length; one that has no direction becomes that of the triangles around it.
pub(in crate::import) fn repair(mesh: &mut Mesh, dropped: &mut Dropped) {
    let mut bad = Vec::new();
    for (vertex, normal) in mesh.normals.iter_mut().enumerate() {
        *normal = normal.normalize_or_zero();
        if *normal == Vec3::ZERO {
            bad.push(vertex);
        }
    }
    if bad.is_empty() {
        return;
    }
    dropped.bad_values += bad.len() as u64;
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for &triangle in &mesh.triangles {
        let normal = triangles::cross(triangle, &mesh.positions).normalize_or_zero();
        for vertex in triangle {
            sums[vertex as usize] += normal;
        }
    }
    for vertex in bad {
        mesh.normals[vertex] = sums[vertex].normalize_or(Vec3::Z);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that share an edge and lie at a right angle.
    fn corner() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[0, 1, 2], [0, 3, 1]],
            ..Mesh::default()
        }
    }

    #[test]
    fn flat_triangles_share_no_vertices_across_an_edge() {
        let mut mesh = corner();
        make_flat(&mut mesh, false, &Budget::new(1 << 20)).unwrap();
        assert_eq!((mesh.positions.len(), mesh.normals.len()), (6, 6));
        for (triangle, normal) in mesh.triangles.iter().zip([Vec3::Z, Vec3::Y]) {
            assert!(triangle.iter().all(|&v| mesh.normals[v as usize] == normal));
        }
        make_flat(&mut corner(), false, &Budget::new(100)).unwrap_err();
    }

    #[test]
    fn triangles_that_bend_share_no_vertices_while_they_are_flat() {
        for (bends, vertices) in [(false, 4), (true, 6)] {
            let mut mesh = corner();
            mesh.positions[3] = -Vec3::Y;
            make_flat(&mut mesh, bends, &Budget::new(1 << 20)).unwrap();
            assert_eq!(mesh.normals, vec![Vec3::Z; vertices]);
        }
    }

    #[test]
    fn a_normal_without_direction_is_that_of_its_triangles() {
        let mut mesh = corner();
        mesh.normals = vec![Vec3::NAN, Vec3::X * 2.0, Vec3::ZERO, Vec3::Y];
        let mut dropped = Dropped::default();
        repair(&mut mesh, &mut dropped);
        assert_eq!(dropped.bad_values, 2);
        let between = (Vec3::Y + Vec3::Z).normalize();
        assert!(mesh.normals[0].abs_diff_eq(between, 1e-6));
        assert_eq!(mesh.normals[1..], [Vec3::X, Vec3::Z, Vec3::Y]);
    }
}
