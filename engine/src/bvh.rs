//! The two-level compressed wide BVH, as the traversal kernel reads it: one bottom level per mesh over its triangles,
//! one top level over the instances. Built by `obvhs`; here the levels are joined in one array of nodes.

use std::time::Duration;

use glam::{Vec3, Vec3A};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    cwbvh::{CwBvh, builder::build_cwbvh, node::CwBvhNode},
    triangle::Triangle,
};
use rayon::prelude::*;

use crate::scene::{Instance, Mesh, Scene};

/// Entries of the traversal kernel's stack; `STACK_SIZE` in `traversal.wgsl`.
const STACK_SIZE: usize = 32;

/// The scene's hierarchy and the order in which it wants triangles and instances.
#[derive(Debug, Default)]
pub struct SceneBvh {
    /// All nodes: the top level first. Children and primitives are absolute indices.
    pub nodes: Vec<CwBvhNode>,
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
    /// Deeper than the traversal kernel's stack.
    #[error(
        "the geometry needs a hierarchy of {depth} levels, more than the {STACK_SIZE} that can be traversed; merge or split meshes whose triangles differ extremely in size"
    )]
    TooDeep {
        /// Levels.
        depth: usize,
    },
}

impl SceneBvh {
    /// Builds both levels, meshes in parallel.
    ///
    /// # Errors
    /// If the scene has no triangles or needs too deep a hierarchy.
    pub fn build(scene: &Scene) -> Result<Self, BvhError> {
        let blas: Vec<CwBvh> = scene.meshes.par_iter().map(build_mesh).collect();
        let placed: Vec<u32> = (0..scene.instances.len() as u32)
            .filter(|&i| {
                !scene.meshes[scene.instances[i as usize].mesh as usize]
                    .triangles
                    .is_empty()
            })
            .collect();
        if placed.is_empty() {
            return Err(BvhError::Empty);
        }
        let boxes: Vec<Aabb> = placed
            .iter()
            .map(|&i| {
                let instance = &scene.instances[i as usize];
                instance_bounds(instance, &blas[instance.mesh as usize].total_aabb)
            })
            .collect();
        let tlas = build_cwbvh(
            &boxes,
            BvhBuildParams::medium_build(),
            &mut Duration::default(),
        );

        let mut result = Self {
            instance_order: tlas
                .primitive_indices
                .iter()
                .map(|&i| placed[i as usize])
                .collect(),
            ..Self::default()
        };
        result.append(&tlas, 0);
        let mut first_triangle = 0u32;
        let mut deepest = 0;
        for bvh in blas {
            result.mesh_first_triangle.push(first_triangle);
            let used = !bvh.primitive_indices.is_empty();
            let root = used.then(|| result.append(&bvh, first_triangle));
            result.mesh_roots.push(root);
            deepest = deepest.max(depth(&bvh));
            first_triangle += bvh.primitive_indices.len() as u32;
            result.triangle_order.push(bvh.primitive_indices);
        }
        // Each level leaves at most one group of nodes on the stack; entering an instance leaves two more.
        let depth = depth(&tlas) + 2 + deepest;
        if depth > STACK_SIZE {
            return Err(BvhError::TooDeep { depth });
        }
        Ok(result)
    }

    fn append(&mut self, bvh: &CwBvh, first_primitive: u32) -> u32 {
        let root = self.nodes.len() as u32;
        self.nodes.extend(bvh.nodes.iter().map(|node| CwBvhNode {
            child_base_idx: node.child_base_idx + root,
            primitive_base_idx: node.primitive_base_idx + first_primitive,
            ..*node
        }));
        root
    }
}

fn build_mesh(mesh: &Mesh) -> CwBvh {
    let triangles: Vec<Triangle> = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| Vec3A::from(mesh.positions[i as usize]));
            Triangle {
                v0: a,
                v1: b,
                v2: c,
            }
        })
        .collect();
    if triangles.is_empty() {
        return CwBvh::default();
    }
    build_cwbvh(
        &triangles,
        BvhBuildParams::medium_build(),
        &mut Duration::default(),
    )
}

/// World bounds of an instance, a little widened because its corners are rounded.
fn instance_bounds(instance: &Instance, object: &Aabb) -> Aabb {
    let (lo, hi) = (Vec3::from(object.min), Vec3::from(object.max));
    let mut bounds = Aabb::empty();
    for corner in 0..8 {
        let pick = |axis: usize, bit: usize| {
            if corner & bit == 0 {
                lo[axis]
            } else {
                hi[axis]
            }
        };
        let p =
            instance
                .transform
                .transform_point3a(Vec3A::new(pick(0, 1), pick(1, 2), pick(2, 4)));
        bounds.extend(p);
    }
    let slack = (bounds.max.abs().max(bounds.min.abs())) * 1e-6;
    Aabb {
        min: bounds.min - slack,
        max: bounds.max + slack,
    }
}

/// Levels of nodes below and including the root.
fn depth(bvh: &CwBvh) -> usize {
    let mut deepest = 0;
    let mut stack = if bvh.nodes.is_empty() {
        vec![]
    } else {
        vec![(0u32, 1usize)]
    };
    while let Some((index, level)) = stack.pop() {
        deepest = deepest.max(level);
        let node = &bvh.nodes[index as usize];
        for child in 0..node.imask.count_ones() {
            stack.push((node.child_base_idx + child, level + 1));
        }
    }
    deepest
}
