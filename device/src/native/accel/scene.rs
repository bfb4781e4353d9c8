//! The top level: meshes, placed in the world.

use std::{ops::ControlFlow, sync::Arc};

use glam::{Affine3A, Vec3};

use super::{
    super::memory::Values,
    bounds::Reference,
    build::{Hierarchy, Progress, Search},
    layout::{EMPTY, LEAF, Node},
    mesh::Mesh,
    trace::{Bundle, Candidate, Hit, Kernel, Met, Ray},
};

/// A mesh, placed in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Rows of the affine map from the mesh to the world.
    pub world_from_object: [[f32; 4]; 3],
    /// Rows of its inverse, by which rays go to the mesh.
    pub object_from_world: [[f32; 4]; 3],
    /// Index of the mesh in the scene.
    pub mesh: u32,
}

impl Instance {
    /// Places mesh `mesh` of a scene.
    pub fn new(world_from_object: Affine3A, mesh: u32) -> Self {
        Self {
            world_from_object: rows(world_from_object),
            object_from_world: rows(world_from_object.inverse()),
            mesh,
        }
    }

    /// Corners of a box in the world around a box of the mesh, a little wider because the corners are rounded.
    fn world_box(&self, object: [Vec3; 2]) -> [[f32; 3]; 2] {
        let mut world = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for corner in 0..8 {
            let p = [0, 1, 2].map(|axis| object[corner >> axis & 1][axis]);
            for (axis, row) in self.world_from_object.iter().enumerate() {
                let at = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
                // Of the terms: what is rounded may be larger than the sum.
                let size = (row[0] * p[0]).abs()
                    + (row[1] * p[1]).abs()
                    + (row[2] * p[2]).abs()
                    + row[3].abs();
                let slack = size * 1e-6;
                // What reaches to the end of the numbers ends there.
                world[0][axis] = world[0][axis].min((at - slack).max(-f32::MAX));
                world[1][axis] = world[1][axis].max((at + slack).min(f32::MAX));
                // Else a NaN would be lost by `min` and `max`.
                if !at.is_finite() {
                    world[0][axis] = f32::NAN;
                    return world;
                }
            }
        }
        world
    }
}

fn rows(map: Affine3A) -> [[f32; 4]; 3] {
    let columns = map.to_cols_array_2d();
    [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| columns[column][row]))
}

/// Meshes and their instances, ready for rays.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(super) meshes: Vec<Arc<Mesh>>,
    pub(super) instances: Vec<Instance>,
    /// Leaves are instances, by their indices.
    pub(super) top: Values<Node>,
    /// Where rays begin: at the root, or at the leaf if there is only one; `EMPTY` if there is none.
    pub(super) start: u32,
    kernel: Kernel,
}

impl Scene {
    /// Places meshes. An instance can't be hit if its mesh is empty or isn't there, or if it lies beyond what floats reach.
    pub fn new(meshes: Vec<Arc<Mesh>>, instances: Vec<Instance>, kernel: Kernel) -> Self {
        let mut scene = Self {
            meshes,
            instances: vec![],
            top: Values::default(),
            start: EMPTY,
            kernel,
        };
        scene.place(instances);
        scene
    }

    /// Places the meshes anew. The hierarchy over the instances is built again: it takes less than a microsecond for each of
    /// them, and an adapted one would be worse.
    pub fn place(&mut self, instances: Vec<Instance>) {
        let level = top_level(&self.meshes, &instances);
        self.start = match level.leaves[..] {
            [] => EMPTY,
            [instance] => LEAF | instance,
            _ => 0,
        };
        self.top = level.nodes;
        for child in self.top.iter_mut().flat_map(|node| &mut node.children) {
            if *child != EMPTY && *child & LEAF != 0 {
                *child = LEAF | level.leaves[(*child & !LEAF) as usize];
            }
        }
        self.instances = instances;
    }

    /// The instances, by their numbers in hits.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The closest hit. `filter` says whether a hit of a triangle with [`Flags::FILTERED`](super::Flags::FILTERED) counts;
    /// it may be asked about hits that others hide.
    #[inline]
    pub fn closest(&self, ray: &Ray, filter: impl Fn(&Candidate) -> bool) -> Option<Hit> {
        self.kernel.trace::<false>(self, ray, None, &filter)
    }

    /// Some hit, if there is one: see [`Flags::DEFERRED`](super::Flags::DEFERRED).
    #[inline]
    pub fn any(&self, ray: &Ray, filter: impl Fn(&Candidate) -> bool) -> Option<Hit> {
        self.kernel.trace::<true>(self, ray, None, &filter)
    }

    /// [`closest`](Self::closest), or [`any`](Self::any), of all instances or of one, without a filter: each hit counts.
    #[inline]
    pub fn trace(&self, ray: &Ray, any: bool, only: Option<u32>) -> Option<Hit> {
        match any {
            true => self.kernel.trace::<true>(self, ray, only, &|_| true),
            false => self.kernel.trace::<false>(self, ray, only, &|_| true),
        }
    }

    /// What rays of a bundle meet, of all instances or of one, without a filter. The same as [`any`](Self::any) for each, but
    /// where a ray passes a triangle's edge within rounding.
    pub fn any_of_bundle(&self, bundle: &Bundle, only: Option<u32>) -> Met {
        self.kernel.trace_bundle(self, bundle, only)
    }

    /// As [`any`](Self::any), but only one instance can be hit.
    #[inline]
    pub fn any_of_instance(
        &self,
        ray: &Ray,
        instance: u32,
        filter: impl Fn(&Candidate) -> bool,
    ) -> Option<Hit> {
        self.kernel
            .trace::<true>(self, ray, Some(instance), &filter)
    }
}

/// The hierarchy over the instances; a leaf holds the index of one.
fn top_level(meshes: &[Arc<Mesh>], instances: &[Instance]) -> Hierarchy<u32> {
    let references: Vec<Reference> = instances
        .iter()
        .enumerate()
        .filter_map(|(index, instance)| {
            let bounds = meshes.get(instance.mesh as usize)?.bounds()?;
            Reference::around(index as u32, &instance.world_box(bounds))
        })
        .collect();
    let endless = |_| ControlFlow::Continue(());
    let progress = Progress::new(references.len(), &endless);
    let search = |&instance: &u32, _| {
        let mesh = &meshes[instances[instance as usize].mesh as usize];
        let inside = mesh.level.search;
        // The way there is another node.
        Search {
            cost: inside.cost + 1.0,
            ..inside
        }
    };
    Hierarchy::build(references, 1, &progress, |indices| indices[0], search)
        .expect("nobody cancels")
}
