//! Vertex data in a fixed pose: morph targets at their weights, skins at the transforms of their joints.
//!
//! What a file shows at a moment is baked into the vertices: kernels know neither joints nor targets.

use super::accessor::Accessor;
use super::document::Document;
use crate::import::error::Fault;
use glam::{Affine3A, Mat3A, Vec3, Vec4};
use gltf::json;
use json::mesh::{MorphTarget, Semantic};
use json::validation::Checked;

/// How a mesh is bent.
#[derive(Debug, Default)]
pub(super) struct Pose {
    /// Weights of the morph targets; missing ones are 0.
    pub(super) weights: Vec<f32>,
    /// Bind pose to world, per joint; empty for a mesh without a skin.
    pub(super) joints: Vec<Affine3A>,
    /// It is one of many: all of them have the same vertices.
    pub(super) bends: bool,
    /// Joints mirror the mesh: its triangles go round the other way then, so that their fronts stay outside.
    pub(super) is_mirrored: bool,
}

impl Pose {
    /// Whether most of some joints mirror.
    pub(super) fn mirror(joints: &[Affine3A]) -> bool {
        let mirroring = joints.iter().filter(|j| j.matrix3.determinant() < 0.0);
        2 * mirroring.count() > joints.len()
    }
}

/// Reads positions, normals and tangents of a primitive in a pose.
pub(super) struct PosedPrimitive<'a> {
    pub(super) document: &'a Document,
    pub(super) primitive: &'a json::mesh::Primitive,
    pub(super) pose: &'a Pose,
}

type Target = json::Index<json::Accessor>;

impl PosedPrimitive<'_> {
    /// Positions of the vertices `used`, possibly not finite.
    pub(super) fn positions(
        &self,
        accessor: &Accessor<'_>,
        used: &[u32],
    ) -> Result<Vec<Vec3>, Fault> {
        let mut positions = vectors(accessor, used);
        self.morph(&mut positions, accessor.count(), used, |target| {
            target.positions
        })?;
        for (position, matrix) in positions
            .iter_mut()
            .zip(self.skinning(accessor.count(), used)?)
        {
            *position = matrix.transform_point3(*position);
        }
        Ok(positions)
    }

    /// Normals, not normalized.
    pub(super) fn normals(
        &self,
        accessor: &Accessor<'_>,
        used: &[u32],
    ) -> Result<Vec<Vec3>, Fault> {
        let mut normals = vectors(accessor, used);
        self.morph(&mut normals, accessor.count(), used, |target| {
            target.normals
        })?;
        for (normal, matrix) in normals
            .iter_mut()
            .zip(self.skinning(accessor.count(), used)?)
        {
            *normal = cofactor(matrix.matrix3) * *normal;
            if self.pose.is_mirrored {
                // By its sign as well, it is the inverse transpose.
                *normal = -*normal;
            }
        }
        Ok(normals)
    }

    /// Tangents, not normalized.
    pub(super) fn tangents(
        &self,
        accessor: &Accessor<'_>,
        used: &[u32],
    ) -> Result<Vec<Vec4>, Fault> {
        let all = accessor.gather::<4>(used.iter().copied());
        let signs: Vec<f32> = all.iter().map(|t| t[3]).collect();
        let mut directions: Vec<Vec3> = all
            .into_iter()
            .map(|[x, y, z, _]| Vec3::new(x, y, z))
            .collect();
        self.morph(&mut directions, accessor.count(), used, |target| {
            target.tangents
        })?;
        for (direction, matrix) in directions
            .iter_mut()
            .zip(self.skinning(accessor.count(), used)?)
        {
            *direction = matrix.transform_vector3(*direction);
        }
        let handed = if self.pose.is_mirrored { -1.0 } else { 1.0 };
        Ok(directions
            .into_iter()
            .zip(signs)
            .map(|(d, sign)| d.extend(handed * sign))
            .collect())
    }

    fn morph(
        &self,
        values: &mut [Vec3],
        vertex_count: u32,
        used: &[u32],
        pick: impl Fn(&MorphTarget) -> Option<Target>,
    ) -> Result<(), Fault> {
        let targets = self.primitive.targets.iter().flatten();
        for (number, (target, &weight)) in targets.zip(&self.pose.weights).enumerate() {
            let Some(index) = pick(target).filter(|_| weight != 0.0) else {
                continue;
            };
            self.document.budget.take(used.len() as u64, 12)?;
            let deltas = self
                .document
                .accessor(index.value())
                .and_then(|accessor| fits(accessor, vertex_count, 3))
                .map_err(|fault| format!("morph target {number}: {fault}"))?;
            for (value, delta) in values.iter_mut().zip(vectors(&deltas, used)) {
                *value += delta * weight;
            }
        }
        Ok(())
    }

    /// A matrix per used vertex; none where the mesh is not skinned.
    fn skinning(&self, vertex_count: u32, used: &[u32]) -> Result<Vec<Affine3A>, Fault> {
        if self.pose.joints.is_empty() {
            return Ok(Vec::new());
        }
        let mut matrices = vec![Affine3A::ZERO; used.len()];
        let mut totals = vec![0.0; used.len()];
        for set in 0.. {
            let find = |semantic| self.primitive.attributes.get(&Checked::Valid(semantic));
            let (Some(joints), Some(weights)) =
                (find(Semantic::Joints(set)), find(Semantic::Weights(set)))
            else {
                break;
            };
            self.document.budget.take(used.len() as u64, 32)?;
            let read = |index: &Target, name: &str| {
                self.document
                    .accessor(index.value())
                    .and_then(|accessor| fits(accessor, vertex_count, 4))
                    .map(|accessor| accessor.gather::<4>(used.iter().copied()))
                    .map_err(|fault| format!("{name}_{set}: {fault}"))
            };
            let joints = read(joints, "JOINTS")?;
            let weights = read(weights, "WEIGHTS")?;
            for (vertex, (joints, weights)) in joints.into_iter().zip(weights).enumerate() {
                for (joint, weight) in joints.into_iter().zip(weights) {
                    if weight == 0.0 || !weight.is_finite() {
                        continue;
                    }
                    let matrix = self.pose.joints.get(joint as usize).ok_or_else(|| {
                        format!("JOINTS_{set}: joint {joint} of {}", self.pose.joints.len())
                    })?;
                    add_scaled(&mut matrices[vertex], matrix, weight);
                    totals[vertex] += weight;
                }
            }
        }
        for (matrix, total) in matrices.iter_mut().zip(totals) {
            *matrix = if total > 0.0 {
                let mut normalized = Affine3A::ZERO;
                add_scaled(&mut normalized, matrix, 1.0 / total);
                normalized
            } else {
                Affine3A::IDENTITY
            };
        }
        Ok(matrices)
    }
}

fn vectors(accessor: &Accessor<'_>, used: &[u32]) -> Vec<Vec3> {
    accessor
        .gather::<3>(used.iter().copied())
        .into_iter()
        .map(Vec3::from)
        .collect()
}

fn fits<'a>(
    accessor: Accessor<'a>,
    vertex_count: u32,
    components: usize,
) -> Result<Accessor<'a>, Fault> {
    if accessor.count() < vertex_count || accessor.components() != components {
        return Err(format!(
            "has {} elements of {} components, {vertex_count} of {components} are needed",
            accessor.count(),
            accessor.components()
        ));
    }
    Ok(accessor)
}

fn add_scaled(sum: &mut Affine3A, matrix: &Affine3A, weight: f32) {
    sum.matrix3 += matrix.matrix3 * weight;
    sum.translation += matrix.translation * weight;
}

/// Transforms normals like the inverse transpose does, up to length, and sign where it mirrors; exists for singular matrices too.
fn cofactor(m: Mat3A) -> Mat3A {
    Mat3A::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    )
}
