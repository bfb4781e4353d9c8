//! glTF meshes to [`Mesh`]: all triangle primitives of a mesh become one, with a material per triangle.
//!
//! Only vertices that a kept triangle uses are decoded, so primitives that share one large accessor cost what they
//! show. What the renderer cannot use (points, lines, degenerate triangles, NaN) ends here.

use super::attributes::Attributes;
use super::custom;
use super::deform::{self, Pose};
use super::document::Document;
use super::indices::Indices;
use crate::import::error::{At as _, Fault, ImportError, Warnings};
use crate::import::mesh::join::merge;
use crate::import::mesh::{Dropped, VERTEX_BYTES, normals, tangents, triangles};
use crate::{Material, Mesh};
use glam::{Vec2, Vec4};
use gltf::json;
use json::mesh::{Mode, Semantic};
use json::validation::Checked;
use rayon::prelude::*;

/// What all meshes are built from.
pub(super) struct Builder<'a> {
    pub(super) document: &'a Document,
    /// Materials of the file in its order; the last one stands in for primitives without one.
    pub(super) materials: &'a [Material],
}

/// A mesh and what was left out of it.
#[derive(Debug, Clone, Default)]
pub(super) struct Built {
    pub(super) mesh: Mesh,
    pub(super) dropped: Dropped,
    pub(super) warnings: Warnings,
}

impl Builder<'_> {
    /// Builds mesh `index` in the given pose.
    pub(super) fn build(&self, index: usize, pose: &Pose) -> Result<Built, ImportError> {
        let path = &self.document.path;
        let source = self
            .document
            .root
            .meshes
            .get(index)
            .ok_or_else(|| "does not exist".to_owned())
            .at(path, || format!("mesh {index}"))?;
        let name = source.name.clone();
        let name = name.unwrap_or_else(|| format!("mesh {index}"));
        let parts = source
            .primitives
            .par_iter()
            .enumerate()
            .map(|(number, primitive)| {
                let place = || format!("mesh {index} \"{name}\", primitive {number}");
                let mut part = Built::default();
                let mesh = self
                    .part(primitive, pose, &place, &mut part)
                    .at(path, place)?;
                Ok((mesh, part))
            })
            .collect::<Result<Vec<_>, ImportError>>()?;
        let mut built = Built::default();
        let mut meshes = Vec::with_capacity(parts.len());
        for (mesh, part) in parts {
            meshes.extend(mesh);
            built.dropped.add(part.dropped);
            built.warnings.extend(part.warnings);
        }
        let place = || format!("mesh {index} \"{name}\"");
        self.complete_tangents(&mut meshes, pose).at(path, place)?;
        custom::take_joined(self.document, &meshes).at(path, place)?;
        built.mesh = merge(meshes);
        built.mesh.name = name;
        Ok(built)
    }

    /// One primitive, or `None` where there is nothing to show.
    fn part(
        &self,
        primitive: &json::mesh::Primitive,
        pose: &Pose,
        place: &dyn Fn() -> String,
        built: &mut Built,
    ) -> Result<Option<Mesh>, Fault> {
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                mode
            }
            Checked::Valid(_) => {
                built
                    .warnings
                    .push(format!("{}: points and lines are not rendered", place()));
                return Ok(None);
            }
            Checked::Invalid => return Err("has an unknown mode".into()),
        };
        let attributes = Attributes {
            document: self.document,
            primitive,
        };
        let Some(positions) = attributes.get(Semantic::Positions, &[3])? else {
            built
                .warnings
                .push(format!("{}: has no POSITION and is not rendered", place()));
            return Ok(None);
        };
        let vertex_count = positions.count();
        let indices = match primitive.indices {
            Some(accessor) => Indices::List(
                self.document
                    .accessor(accessor.value())?
                    .indices()
                    .map_err(|fault| format!("indices: accessor {} {fault}", accessor.value()))?,
            ),
            None => Indices::Sequence(vertex_count),
        };
        self.document
            .budget
            .take(indices.triangle_count(mode), 16)?;
        let mut list = indices.triangles(mode, vertex_count)?;
        if pose.is_mirrored {
            list.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        if indices.left_over(mode) {
            built
                .warnings
                .push(format!("{}: its last triangle is incomplete", place()));
        }

        let mut used = triangles::compact(&mut list, vertex_count);
        self.document.budget.take(used.len() as u64, VERTEX_BYTES)?;
        let source = deform::PosedPrimitive {
            document: self.document,
            primitive,
            pose,
        };
        let mut mesh = Mesh {
            positions: source.positions(&positions, &used)?,
            ..Mesh::default()
        };

        let kept = triangles::keep_usable(&mut list, &mesh.positions, &mut built.dropped);
        if list.is_empty() {
            return Ok(None);
        }
        if !kept {
            let still = triangles::compact(&mut list, used.len() as u32);
            used = still.iter().map(|&v| used[v as usize]).collect();
            mesh.positions = still.iter().map(|&v| mesh.positions[v as usize]).collect();
        }

        let material = match primitive.material {
            Some(material) if material.value() < self.document.root.materials.len() => {
                material.value()
            }
            Some(material) => return Err(format!("material {} does not exist", material.value())),
            None => self.materials.len() - 1,
        };
        mesh.triangle_materials = vec![material as u32; list.len()];
        mesh.triangles = list;
        read_attributes(&attributes, &used, &mut mesh, &mut built.dropped)?;
        self.read_normals(&attributes, &source, &used, &mut mesh, &mut built.dropped)?;
        self.make_tangents(material, pose, &mut mesh, place, &mut built.warnings)?;
        Ok(Some(mesh))
    }

    /// Normals and tangents of the file, or flat normals where it has none.
    fn read_normals(
        &self,
        attributes: &Attributes<'_>,
        source: &deform::PosedPrimitive<'_>,
        used: &[u32],
        mesh: &mut Mesh,
        dropped: &mut Dropped,
    ) -> Result<(), Fault> {
        let Some(given) = attributes.get(Semantic::Normals, &[3])? else {
            return normals::make_flat(mesh, source.pose.bends, &self.document.budget);
        };
        mesh.normals = source.normals(&given, used)?;
        normals::repair(mesh, dropped);
        if let Some(tangents) = attributes.get(Semantic::Tangents, &[4])? {
            mesh.tangents = source
                .tangents(&tangents, used)?
                .into_iter()
                .zip(&mesh.normals)
                .map(|(tangent, &normal)| tangents::sanitize(tangent, normal))
                .collect();
        }
        Ok(())
    }

    fn make_tangents(
        &self,
        material: usize,
        pose: &Pose,
        mesh: &mut Mesh,
        place: &dyn Fn() -> String,
        warnings: &mut Warnings,
    ) -> Result<(), Fault> {
        let normal_map = self.materials.get(material);
        let normal_map = normal_map
            .and_then(|m| (m.normal_texture.or(m.coat_normal_texture)).or(m.anisotropy_texture));
        let Some(texture) = normal_map.filter(|_| mesh.tangents.is_empty()) else {
            return Ok(());
        };
        if !tangents::make(mesh, texture.uv_set, pose.bends, &self.document.budget)? {
            warnings.push(format!(
                "{}: has a normal map but no TEXCOORD_{} to place it",
                place(),
                texture.uv_set
            ));
        }
        Ok(())
    }

    /// Where some of the primitives that become one mesh have tangents the others get theirs, by their first texture coordinates: the
    /// mesh has some then, and nobody makes them later for what reads them.
    fn complete_tangents(&self, parts: &mut [Mesh], pose: &Pose) -> Result<(), Fault> {
        if parts.iter().all(|part| part.tangents.is_empty()) {
            return Ok(());
        }
        let without = |part: &&mut Mesh| part.tangents.is_empty() && !part.uv0.is_empty();
        for part in parts.iter_mut().filter(without) {
            tangents::make(part, 0, pose.bends, &self.document.budget)?;
        }
        Ok(())
    }
}

/// Texture coordinates, colours and custom attributes of the vertices `used`.
fn read_attributes(
    attributes: &Attributes<'_>,
    used: &[u32],
    mesh: &mut Mesh,
    dropped: &mut Dropped,
) -> Result<(), Fault> {
    let vertices = || used.iter().copied();
    for (set, target) in [(0, &mut mesh.uv0), (1, &mut mesh.uv1)] {
        if let Some(accessor) = attributes.get(Semantic::TexCoords(set), &[2])? {
            *target = accessor
                .gather::<2>(vertices())
                .into_iter()
                .map(Vec2::from)
                .collect();
            for uv in target.iter_mut().filter(|uv| !uv.is_finite()) {
                *uv = Vec2::ZERO;
                dropped.bad_values += 1;
            }
        }
    }
    if let Some(accessor) = attributes.get(Semantic::Colors(0), &[3, 4])? {
        let opaque = accessor.components() == 3;
        mesh.colors = accessor
            .gather::<4>(vertices())
            .into_iter()
            .map(Vec4::from)
            .collect();
        for color in &mut mesh.colors {
            if opaque {
                color.w = 1.0;
            }
            if !color.is_finite() {
                *color = Vec4::ONE;
                dropped.bad_values += 1;
            }
            *color = color.max(Vec4::ZERO);
        }
    }
    mesh.custom = custom::read(attributes, used, dropped)?;
    Ok(())
}

/// Whether a primitive is made of triangles, which are all that is rendered.
pub(super) fn has_triangles(primitive: &json::mesh::Primitive) -> bool {
    matches!(
        primitive.mode,
        Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
    )
}

#[cfg(test)]
mod tests {
    use super::super::tests::{floats, import, square};
    use glam::Vec3;
    use serde_json::json;

    /// One primitive has tangents, the other has none, and texture coordinates that go down the square.
    #[test]
    fn a_primitive_joined_with_one_that_has_tangents_gets_its_own() {
        let mut tree = square();
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let normals = [[0.0f32, 0.0, 1.0]; 4].concat();
        let tangents = [[1.0f32, 0.0, 0.0, 1.0]; 4].concat();
        let uv = corners.map(|[x, y]: [f32; 2]| [1.0 - y, x]).concat();
        for (numbers, kind) in [(normals, "VEC3"), (tangents, "VEC4"), (uv, "VEC2")] {
            let number = tree["buffers"].as_array().unwrap().len();
            let mut push = |list: &str, item| tree[list].as_array_mut().unwrap().push(item);
            push("buffers", floats(&numbers));
            push(
                "bufferViews",
                json!({ "buffer": number, "byteLength": numbers.len() * 4 }),
            );
            push(
                "accessors",
                json!({ "bufferView": number + 1, "componentType": 5126, "count": 4, "type": kind }),
            );
        }
        let with = json!({ "POSITION": 1, "NORMAL": 2, "TANGENT": 3 });
        let without = json!({ "POSITION": 1, "NORMAL": 2, "TEXCOORD_0": 4 });
        tree["meshes"][0]["primitives"] = json!([
            { "attributes": with, "indices": 0 },
            { "attributes": without, "indices": 0 },
        ]);
        let scene = import(tree).unwrap_or_else(|e| panic!("{e}")).scene;
        let tangents = &scene.meshes[0].tangents;
        assert_eq!(tangents.len(), 8);
        let along = |tangent: Vec3, wanted: Vec3| tangent.abs_diff_eq(wanted, 1e-5);
        assert!(tangents[..4].iter().all(|t| along(t.truncate(), Vec3::X)));
        assert!(
            (tangents[4..].iter()).all(|t| along(t.truncate(), Vec3::NEG_Y)),
            "{tangents:?}"
        );
    }
}
