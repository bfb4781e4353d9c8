//! The two-level compressed wide BVH, as the traversal kernel reads it: one bottom level per mesh over its triangles,
//! one top level over the instances. Here the levels are joined in one array of nodes; how one is built is in `wide`.
//! Devices that bring a hierarchy of their own only need the order of triangles and instances.

mod binary;
mod bounds;
mod crossings;
mod reinsertion;
#[cfg(test)]
mod tests;
mod wide;

use std::sync::Arc;

use glam::{DMat3, DVec3, Mat3, Vec3, Vec3A};
use rayon::prelude::*;

use crate::scene::{Instance, Mesh, Scene};

use self::wide::WideBvh;

pub(crate) use self::{bounds::Bounds, crossings::Crossings};

pub use self::wide::WideNode;

/// Levels of nodes in a hierarchy. Each leaves at most one group of nodes on the traversal's stack, and entering an
/// instance leaves two more: `STACK_SIZE` in `traversal.wgsl` has room for both hierarchies and these.
const LEVELS: u32 = 15;

/// The scene's hierarchy and the order in which it wants triangles and instances.
#[derive(Debug, Default)]
pub struct SceneBvh {
    /// All nodes: the top level first. Children and primitives are absolute indices.
    pub nodes: Vec<WideNode>,
    /// Root of each mesh's bottom level in `nodes`; `None` for a mesh without triangles.
    pub mesh_roots: Vec<Option<u32>>,
    /// For each mesh the index of its first triangle among all triangles in hierarchy order.
    pub mesh_first_triangle: Vec<u32>,
    /// For each mesh, the original triangle at each place of the hierarchy's order.
    pub triangle_order: Vec<Vec<u32>>,
    /// The scene's instance at each place of the hierarchy's order; instances of empty meshes are left out.
    pub instance_order: Vec<u32>,
}

/// Why no hierarchy could be built.
#[derive(Debug, thiserror::Error)]
pub enum BvhError {
    /// Nothing to render.
    #[error(
        "the scene holds no triangle that is placed in the world; check that its default scene refers to a mesh"
    )]
    Empty,
}

/// The bottom level of a mesh, which stays the same as long as the mesh does.
#[derive(Debug, Clone)]
pub struct MeshBvh(Arc<WideBvh>);

impl MeshBvh {
    /// Those of all meshes, built in parallel but for those that `keep` has already.
    pub fn build_all(scene: &Scene, keep: impl Fn(usize) -> Option<Self> + Sync) -> Vec<Self> {
        let meshes = scene.meshes.par_iter().enumerate();
        let build = |mesh| Self(Arc::new(build_mesh(mesh)));
        meshes
            .map(|(number, mesh)| keep(number).unwrap_or_else(|| build(mesh)))
            .collect()
    }
}

impl SceneBvh {
    /// Builds both levels, meshes in parallel.
    ///
    /// # Errors
    /// If the scene has no triangles.
    pub fn build(scene: &Scene) -> Result<Self, BvhError> {
        Self::join(scene, &MeshBvh::build_all(scene, |_| None))
    }

    /// Builds the top level over the bottom levels of the scene's meshes.
    ///
    /// # Errors
    /// If the scene has no triangles.
    pub fn join(scene: &Scene, blas: &[MeshBvh]) -> Result<Self, BvhError> {
        let placed = placed(scene)?;
        let boxes = placed.iter().map(|&i| {
            let instance = &scene.instances[i as usize];
            instance_bounds(instance, &blas[instance.mesh as usize].0.bounds)
        });
        let tlas = WideBvh::build(boxes, LEVELS);

        let mut result = Self {
            instance_order: (tlas.primitives.iter())
                .map(|&i| placed[i as usize])
                .collect(),
            ..Self::default()
        };
        result.append(&tlas, 0);
        let mut first_triangle = 0u32;
        for MeshBvh(bvh) in blas {
            result.mesh_first_triangle.push(first_triangle);
            let used = !bvh.primitives.is_empty();
            let root = used.then(|| result.append(bvh, first_triangle));
            result.mesh_roots.push(root);
            first_triangle += bvh.primitives.len() as u32;
            result.triangle_order.push(bvh.primitives.clone());
        }
        Ok(result)
    }

    /// Without nodes, in the order of the scene: for devices that have a hierarchy of their own.
    ///
    /// # Errors
    /// If the scene has no triangles.
    pub fn in_scene_order(scene: &Scene) -> Result<Self, BvhError> {
        let mut result = Self {
            instance_order: placed(scene)?,
            ..Self::default()
        };
        let mut first_triangle = 0u32;
        for mesh in &scene.meshes {
            let count = mesh.triangles.len() as u32;
            result.mesh_first_triangle.push(first_triangle);
            result.mesh_roots.push((count > 0).then_some(0));
            result.triangle_order.push((0..count).collect());
            first_triangle += count;
        }
        Ok(result)
    }

    fn append(&mut self, bvh: &WideBvh, first_primitive: u32) -> u32 {
        let root = self.nodes.len() as u32;
        self.nodes.extend(bvh.nodes.iter().map(|node| WideNode {
            first_child: node.first_child + root,
            first_primitive: node.first_primitive + first_primitive,
            ..*node
        }));
        root
    }
}

/// The instances of meshes that have triangles.
fn placed(scene: &Scene) -> Result<Vec<u32>, BvhError> {
    let mut placed: Vec<u32> = (0..scene.instances.len() as u32).collect();
    placed.retain(|&i| {
        let mesh = scene.instances[i as usize].mesh;
        !scene.meshes[mesh as usize].triangles.is_empty()
    });
    match placed.is_empty() {
        true => Err(BvhError::Empty),
        false => Ok(placed),
    }
}

fn build_mesh(mesh: &Mesh) -> WideBvh {
    let triangle = |t: &[u32; 3]| {
        let corner = |i: u32| Vec3A::from(mesh.positions[i as usize]);
        Bounds::around(t.map(corner))
    };
    WideBvh::build(mesh.triangles.iter().map(triangle), LEVELS)
}

/// World bounds of an instance, a little widened because the rays that enter it are rounded.
fn instance_bounds(instance: &Instance, object: &Bounds) -> Bounds {
    let axes: DMat3 = Mat3::from(instance.transform.matrix3).as_dmat3();
    let middle = 0.5 * (object.low.as_dvec3() + object.high.as_dvec3());
    let center = axes * middle + Vec3::from(instance.transform.translation).as_dvec3();
    let extent = DMat3::from_cols(axes.x_axis.abs(), axes.y_axis.abs(), axes.z_axis.abs())
        * (0.5 * object.size());
    let (low, high): (DVec3, DVec3) = (center - extent, center + extent);
    // Of the terms: where a node takes large coordinates nearly away, they are what is rounded.
    let corner = object.low.abs().max(object.high.abs()).as_dvec3();
    let terms = DMat3::from_cols(axes.x_axis.abs(), axes.y_axis.abs(), axes.z_axis.abs()) * corner;
    let slack = (terms + Vec3::from(instance.transform.translation).as_dvec3().abs()) * 1e-6;
    Bounds {
        low: (low - slack).as_vec3a(),
        high: (high + slack).as_vec3a(),
    }
}
