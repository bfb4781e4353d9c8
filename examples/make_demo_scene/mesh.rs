//! Polygons in, a triangle mesh with sensible normals out. Shapes are elsewhere.

use std::collections::HashMap;

use glam::{Affine3A, Vec2, Vec3, Vec3Swizzles};

/// Faces that share corners by position; normals are made by [`Shape::finish`].
#[derive(Default, Clone)]
pub(crate) struct Shape {
    faces: Vec<Vec<(Vec3, Vec2)>>,
}

/// A mesh as glTF stores it.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) uvs: Vec<Vec2>,
    pub(crate) indices: Vec<u16>,
}

impl Shape {
    /// Adds a convex polygon, counter-clockwise seen from outside. Corners that coincide are left out.
    pub(crate) fn face(&mut self, corners: &[(Vec3, Vec2)]) {
        let mut face: Vec<(Vec3, Vec2)> = Vec::new();
        for &corner in corners {
            if face.iter().all(|c| c.0.distance(corner.0) > 1e-6) {
                face.push(corner);
            }
        }
        if face.len() >= 3 {
            self.faces.push(face);
        }
    }

    /// Adds a polygon whose texture coordinates are metres seen from above.
    pub(crate) fn flat_face(&mut self, corners: &[Vec3]) {
        let with_uv: Vec<_> = corners.iter().map(|&c| (c, c.xz())).collect();
        self.face(&with_uv);
    }

    /// Adds everything of another shape, placed.
    pub(crate) fn add(&mut self, other: &Self, transform: Affine3A) -> &mut Self {
        let mirrored = transform.matrix3.determinant() < 0.0;
        for face in &other.faces {
            let mut face: Vec<_> = face
                .iter()
                .map(|&(p, uv)| (transform.transform_point3(p), uv))
                .collect();
            if mirrored {
                face.reverse();
            }
            self.faces.push(face);
        }
        self
    }

    /// Triangles with normals averaged over the faces around a corner that meet at less than `crease` radians, by
    /// area: large faces stay flat and narrow bevels between them look round.
    pub(crate) fn finish(&self, crease: f32) -> Mesh {
        let key = |p: Vec3| (p * 1e5).round().as_ivec3();
        let area_normals: Vec<Vec3> = self.faces.iter().map(|f| area_normal(f)).collect();
        let mut around: HashMap<_, Vec<usize>> = HashMap::new();
        for (index, face) in self.faces.iter().enumerate() {
            for corner in face {
                around.entry(key(corner.0)).or_default().push(index);
            }
        }
        let mut mesh = Mesh::default();
        let mut known = HashMap::new();
        for (face, own) in self.faces.iter().zip(&area_normals) {
            let direction = own.normalize_or_zero();
            let corners: Vec<u16> = face
                .iter()
                .map(|&(position, uv)| {
                    let normal: Vec3 = around[&key(position)]
                        .iter()
                        .map(|&other| area_normals[other])
                        .filter(|n| n.normalize_or_zero().dot(direction) > crease.cos())
                        .sum();
                    let normal = normal.normalize_or(Vec3::Y);
                    let id = (key(position), key(normal), (uv * 1e4).round().as_ivec2());
                    *known
                        .entry(id)
                        .or_insert_with(|| mesh.push(position, normal, uv))
                })
                .collect();
            for i in 1..corners.len() - 1 {
                let triangle = [corners[0], corners[i], corners[i + 1]];
                if triangle[0] != triangle[1]
                    && triangle[1] != triangle[2]
                    && triangle[0] != triangle[2]
                {
                    mesh.indices.extend(triangle);
                }
            }
        }
        mesh
    }
}

impl Mesh {
    fn push(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u16 {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        u16::try_from(self.positions.len() - 1)
            .expect("meshes of the demo are small: split this one")
    }
}

/// Newell's normal: its length is twice the area.
fn area_normal(face: &[(Vec3, Vec2)]) -> Vec3 {
    (0..face.len())
        .map(|i| (face[i].0 - face[0].0).cross(face[(i + 1) % face.len()].0 - face[0].0))
        .sum()
}
