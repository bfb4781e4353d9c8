//! Traversal on devices that run kernels in this program's memory: `trace_surfaces` of `shared/traversal.wgsl`, done by
//! SIMD code in a hierarchy of the device's own. All else of the kernels that trace rays is the WGSL's.

use std::{fmt, ops::ControlFlow, sync::Arc};

use device::{
    Activity, HostFunction,
    native::accel::{BuildError, Flags, Instance, Kernel, Mesh, Ray, Scene as RayScene},
};
use rayon::prelude::*;

use crate::{
    bvh::SceneBvh,
    scene::{self, Scene},
    wave::RayHit,
};

use super::{RayRules, inverse, rows};

/// The function of the text that this stands for.
pub const FUNCTION: &str = "trace_surfaces";

/// The scene's geometry, ready for rays.
pub struct HostTraversal {
    scene: RayScene,
    meshes: Vec<Arc<Mesh>>,
    /// Of each instance's mesh, the first triangle among all.
    first_triangles: Vec<u32>,
}

impl HostTraversal {
    /// Builds the hierarchy over triangles and instances in the order in which they lie on the device; `rules` are those
    /// of each material, without and with vertex colours. Tells `activity` how far it is.
    ///
    /// # Errors
    /// A mesh of too many triangles.
    pub fn new(
        scene: &Scene,
        order: &SceneBvh,
        rules: &[[RayRules; 2]],
        activity: &Activity,
    ) -> Result<Self, BuildError> {
        Self::with(scene, order, rules, activity, &|_| None)
    }

    /// The hierarchy of a mesh, by its number.
    pub(super) fn mesh(&self, mesh: usize) -> Option<Arc<Mesh>> {
        self.meshes.get(mesh).cloned()
    }

    /// As [`Self::new`], with hierarchies of meshes that there are already.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn with(
        scene: &Scene,
        order: &SceneBvh,
        rules: &[[RayRules; 2]],
        activity: &Activity,
        keep: &(dyn Fn(usize) -> Option<Arc<Mesh>> + Sync),
    ) -> Result<Self, BuildError> {
        let busy = activity.begin(|| "building the hierarchy of the geometry".to_owned());
        let total: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        let build = |(number, (mesh, order)): (usize, (&scene::Mesh, &Vec<u32>))| {
            if let Some(kept) = keep(number) {
                return Ok(kept);
            }
            let triangles: Vec<[u32; 3]> = (order.iter())
                .map(|&t| mesh.triangles[t as usize])
                .collect();
            let flags_of = |place: usize| {
                let material = mesh.triangle_materials[order[place] as usize];
                ray_flags(rules[material as usize][usize::from(!mesh.colors.is_empty())])
            };
            // Of a mesh that is much of the scene, people want to know.
            let is_large = triangles.len() > total / 2;
            let progress = |share: f32| {
                if is_large {
                    let percent = (100.0 * share) as u32;
                    busy.tell(|| format!("building the hierarchy of the geometry, {percent} %"));
                }
                ControlFlow::Continue(())
            };
            Mesh::build(&mesh.positions, &triangles, flags_of, &progress).map(Arc::new)
        };
        let meshes = (scene.meshes.par_iter())
            .zip(&order.triangle_order)
            .enumerate()
            .map(build)
            .collect::<Result<Vec<_>, _>>()?;
        let placed = || {
            let sources = order.instance_order.iter();
            sources.map(|&source| &scene.instances[source as usize])
        };
        let instances = placed().map(|instance| Instance {
            world_from_object: rows(&instance.transform),
            object_from_world: rows(&inverse(&instance.transform)),
            mesh: instance.mesh,
        });
        let first = |mesh: u32| order.mesh_first_triangle[mesh as usize];
        Ok(Self {
            scene: RayScene::new(meshes.clone(), instances.collect(), Kernel::best()),
            meshes,
            first_triangles: placed().map(|instance| first(instance.mesh)).collect(),
        })
    }
}

/// A material's rules as rays know them. The kernels judge what may be transparent and start again behind it.
fn ray_flags(rules: RayRules) -> Flags {
    let mut known = Flags::NONE;
    if rules.is_single_sided {
        known = known | Flags::SINGLE_SIDED;
    }
    if rules.may_let_pass {
        known = known | Flags::DEFERRED;
    }
    known
}

impl HostFunction for HostTraversal {
    /// Origin, direction, t_min, t_max, any, only_instance; `Hit` of `hit.wgsl`.
    fn words(&self) -> [usize; 2] {
        [10, 5]
    }

    fn call(&self, arguments: &[u32], result: &mut [u32]) {
        let numbers = |first: usize| [0, 1, 2].map(|i| f32::from_bits(arguments[first + i]));
        let ray = Ray {
            origin: numbers(0),
            direction: numbers(3),
            t_min: f32::from_bits(arguments[6]),
            t_max: f32::from_bits(arguments[7]),
        };
        let (any, only) = (arguments[8] != 0, arguments[9]);
        let only = (only != RayHit::MISS).then_some(only);
        let hit = match self.scene.trace(&ray, any, only) {
            Some(hit) => [
                hit.t.to_bits(),
                hit.u.to_bits(),
                hit.v.to_bits(),
                self.first_triangles[hit.instance as usize] + hit.triangle,
                hit.instance,
            ],
            None => [arguments[7], 0, 0, RayHit::MISS, 0],
        };
        result.copy_from_slice(&hit);
    }
}

impl fmt::Debug for HostTraversal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HostTraversal").finish_non_exhaustive()
    }
}
