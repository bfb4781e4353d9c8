//! Traversal on devices that run kernels in this program's memory: `trace_surfaces` of `shared/traversal.wgsl`, done by
//! SIMD code in a hierarchy of the device's own. All else of the kernels that trace rays is the WGSL's.

use std::{fmt, ops::ControlFlow, sync::Arc};

use device::{
    Activity, HostFunction,
    native::accel::{BuildError, Flags, Instance, Kernel, Mesh, Ray, Scene as RayScene},
};
use glam::Vec3;
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
    meshes: Vec<BuiltMesh>,
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
        Self::with(scene, order, rules, activity, &|_| Kept::Nothing)
    }

    /// The hierarchy of a mesh, by its number.
    pub(super) fn mesh(&self, mesh: usize) -> Option<&BuiltMesh> {
        self.meshes.get(mesh)
    }

    /// As [`Self::new`], with hierarchies of meshes that there are already.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn with<'k>(
        scene: &Scene,
        order: &SceneBvh,
        rules: &[[RayRules; 2]],
        activity: &Activity,
        keep: &(dyn Fn(usize) -> Kept<'k> + Sync),
    ) -> Result<Self, BuildError> {
        let busy = activity.begin(|| "building the hierarchy of the geometry".to_owned());
        let total: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        let build = |(number, (mesh, order)): (usize, (&scene::Mesh, &Vec<u32>))| {
            let kept = keep(number);
            if let Kept::Whole(mesh) = kept {
                return Ok(mesh.clone());
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
            let build = |positions: &[Vec3]| {
                Mesh::build(positions, &triangles, flags_of, &progress).map(Arc::new)
            };
            let Some(unbent) = &mesh.unbent else {
                return Ok(BuiltMesh::alone(build(&mesh.positions)?));
            };
            // Always from the mesh before it is bent, so that a picture doesn't depend on what was shown before.
            let base = match kept {
                Kept::Base(former) if former.is_base_of(unbent) => former.base.clone(),
                _ => Some((Arc::clone(unbent), build(unbent)?)),
            };
            let refit = base
                .as_ref()
                .and_then(|(_, base)| base.refit(&mesh.positions, &triangles));
            Ok(BuiltMesh {
                mesh: match refit {
                    Some(refit) => Arc::new(refit),
                    None => build(&mesh.positions)?,
                },
                base,
            })
        };
        let meshes = (scene.meshes.par_iter())
            .zip(&order.triangle_order)
            .enumerate()
            .map(build)
            .collect::<Result<Vec<_>, BuildError>>()?;
        let placed = || {
            let sources = order.instance_order.iter();
            sources.map(|&source| &scene.instances[source as usize])
        };
        let instances = placed().map(|instance| Instance {
            world_from_object: rows(&instance.transform),
            object_from_world: rows(&inverse(&instance.transform)),
            mesh: instance.mesh,
        });
        let hierarchies = meshes.iter().map(|built| Arc::clone(&built.mesh)).collect();
        let first = |mesh: u32| order.mesh_first_triangle[mesh as usize];
        Ok(Self {
            scene: RayScene::new(hierarchies, instances.collect(), Kernel::best()),
            meshes,
            first_triangles: placed().map(|instance| first(instance.mesh)).collect(),
        })
    }
}

/// The hierarchy of a mesh.
#[derive(Debug, Clone)]
pub(super) struct BuiltMesh {
    mesh: Arc<Mesh>,
    /// That of a mesh that bends, before it is bent, with the positions that it is of.
    base: Option<(Arc<Vec<Vec3>>, Arc<Mesh>)>,
}

impl BuiltMesh {
    fn alone(mesh: Arc<Mesh>) -> Self {
        Self { mesh, base: None }
    }

    fn is_base_of(&self, unbent: &Arc<Vec<Vec3>>) -> bool {
        let mut base = self.base.iter();
        base.any(|(positions, _)| Arc::ptr_eq(positions, unbent))
    }
}

/// What there is of a mesh from another moment.
pub(super) enum Kept<'a> {
    Nothing,
    /// It is the same.
    Whole(&'a BuiltMesh),
    /// It may be bent otherwise; its triangles and materials are the same.
    Base(&'a BuiltMesh),
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
