//! Traversal on devices that run kernels in this program's memory: `trace_surfaces` of `shared/traversal.wgsl`, done by
//! SIMD code in a hierarchy of the device's own. All else of the kernels that trace rays is the WGSL's.

mod groups;

use std::{
    cell::Cell,
    collections::HashMap,
    fmt,
    ops::ControlFlow,
    sync::{Arc, OnceLock},
};

use device::{
    Activity, Buffer, HostFunction, Resources,
    native::accel::{
        BuildError, Bundle, Flags, Hit, Instance, Kernel, Mesh, Met, Ray, Scene as RayScene,
    },
};
use glam::Vec3;
use rayon::prelude::*;

use crate::{bvh::SceneBvh, scene::Scene, wave::RayHit};

use super::{RayRules, inverse, rows};
use groups::{Directory, Group, Member};

/// The functions of the text that this stands for.
pub const FUNCTIONS: [&str; 2] = ["trace_surfaces", "trace_bundle"];

/// The scene's geometry, ready for rays.
pub struct HostTraversal {
    scene: RayScene,
    /// What each instance of `scene` stands for; its mesh has the same number.
    groups: Vec<Group>,
    directories: Vec<Directory>,
    meshes: Vec<BuiltMesh>,
    /// Of each instance's mesh, the first triangle among all.
    first_triangles: Vec<u32>,
    /// The group of each instance.
    group_of: Vec<u32>,
    /// Whether every surface stops rays, so that of an occluder nobody asks which one it is.
    all_stop: bool,
    /// Instances that lie in one hierarchy with others, by themselves: made when a ray is to meet one of them alone.
    apart: Vec<OnceLock<RayScene>>,
}

impl HostTraversal {
    /// Builds the hierarchy over triangles and instances in the order in which they lie on the device; `rules` are those
    /// of each material, without and with vertex colours. Tells `activity` how far it is.
    ///
    /// # Errors
    /// A mesh of too many triangles, or no memory for the hierarchy.
    pub fn new(
        scene: &Scene,
        order: &SceneBvh,
        rules: &[[RayRules; 2]],
        activity: &Activity,
    ) -> Result<Self, BuildError> {
        Self::with(scene, order, rules, activity, None)
    }

    /// As [`Self::new`], with what is the same as at another moment.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn with(
        scene: &Scene,
        order: &SceneBvh,
        rules: &[[RayRules; 2]],
        activity: &Activity,
        former: Option<&Former<'_>>,
    ) -> Result<Self, BuildError> {
        let busy = activity.begin(|| "building the hierarchy of the geometry".to_owned());
        let total: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        let placed = || {
            let sources = order.instance_order.iter();
            sources.map(|&source| &scene.instances[source as usize])
        };
        let triangles_of = |mesh: u32| -> Vec<[u32; 3]> {
            let (mesh, order) = (
                &scene.meshes[mesh as usize],
                &order.triangle_order[mesh as usize],
            );
            (order.iter())
                .map(|&t| mesh.triangles[t as usize])
                .collect()
        };
        let flags_of = |mesh: u32, place: u32| {
            let (mesh, order) = (
                &scene.meshes[mesh as usize],
                &order.triangle_order[mesh as usize],
            );
            let material = mesh.triangle_materials[order[place as usize] as usize];
            ray_flags(rules[material as usize][usize::from(!mesh.colors.is_empty())])
        };
        let build = |positions: &[Vec3],
                     triangles: &[[u32; 3]],
                     flags: &(dyn Fn(u32) -> Flags + Sync)| {
            // Of a mesh that is much of the scene, people want to know.
            let is_large = triangles.len() > total / 2;
            let progress = |share: f32| {
                if is_large {
                    let percent = (100.0 * share) as u32;
                    busy.tell(|| format!("building the hierarchy of the geometry, {percent} %"));
                }
                ControlFlow::Continue(())
            };
            Mesh::build(positions, triangles, |place| flags(place as u32), &progress).map(Arc::new)
        };
        let groups = groups::of(scene, placed());
        let build_group = |group: &Group| {
            let kept = former.map_or(Kept::Nothing, |former| former.kept(group));
            if let Kept::Whole(built) = kept {
                return Ok(built.clone());
            }
            let number = match group {
                Group::Alone { mesh, .. } => *mesh,
                Group::Joined(members) => {
                    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
                    for member in members {
                        let first = positions.len() as u32;
                        positions.extend(&scene.meshes[member.mesh as usize].positions);
                        let own = triangles_of(member.mesh).into_iter();
                        triangles.extend(own.map(|corners| corners.map(|corner| corner + first)));
                    }
                    let flags = |triangle: u32| {
                        let after = members.partition_point(|member| member.start <= triangle);
                        let member = &members[after - 1];
                        flags_of(member.mesh, triangle - member.start)
                    };
                    return Ok(BuiltMesh::alone(build(&positions, &triangles, &flags)?));
                }
            };
            let (mesh, triangles) = (&scene.meshes[number as usize], triangles_of(number));
            let flags = |place: u32| flags_of(number, place);
            let Some(unbent) = &mesh.unbent else {
                return Ok(BuiltMesh::alone(build(
                    &mesh.positions,
                    &triangles,
                    &flags,
                )?));
            };
            // Always from the mesh before it is bent, so that a picture doesn't depend on what was shown before.
            let base = match kept {
                Kept::Base(former) if former.is_base_of(unbent) => former.base.clone(),
                _ => Some((Arc::clone(unbent), build(unbent, &triangles, &flags)?)),
            };
            let refit = base
                .as_ref()
                .and_then(|(_, base)| base.refit(&mesh.positions, &triangles));
            Ok(BuiltMesh {
                mesh: match refit {
                    Some(refit) => Arc::new(refit),
                    None => build(&mesh.positions, &triangles, &flags)?,
                },
                base,
            })
        };
        // A mesh that is placed often is built once.
        let mut first_with: HashMap<u32, usize> = HashMap::new();
        let mut is_first = |(at, group): (usize, &Group)| match group {
            Group::Alone { mesh, .. } => *first_with.entry(*mesh).or_insert(at),
            Group::Joined(_) => at,
        };
        let builds: Vec<usize> = groups.iter().enumerate().map(&mut is_first).collect();
        let built = (groups.par_iter().zip(&builds).enumerate())
            .map(|(at, (group, &first))| (at == first).then(|| build_group(group)).transpose())
            .collect::<Result<Vec<_>, BuildError>>()?;
        let meshes: Vec<BuiltMesh> = (builds.iter())
            .filter_map(|&first| built[first].clone())
            .collect();

        let instances: Vec<_> = placed().collect();
        let placed_groups = (0..).zip(&groups).map(|(mesh, group)| {
            let transform = &instances[group.place() as usize].transform;
            Instance {
                world_from_object: rows(transform),
                object_from_world: rows(&inverse(transform)),
                mesh,
            }
        });
        let hierarchies = meshes.iter().map(|built| Arc::clone(&built.mesh)).collect();
        let mut group_of = vec![0; instances.len()];
        for (number, group) in (0..).zip(&groups) {
            match group {
                Group::Alone { place, .. } => group_of[*place as usize] = number,
                Group::Joined(members) => {
                    for member in members {
                        group_of[member.place as usize] = number;
                    }
                }
            }
        }
        let first = |mesh: u32| order.mesh_first_triangle[mesh as usize];
        Ok(Self {
            scene: RayScene::new(hierarchies, placed_groups.collect(), Kernel::best()),
            meshes,
            first_triangles: instances.iter().map(|i| first(i.mesh)).collect(),
            apart: instances.iter().map(|_| OnceLock::new()).collect(),
            directories: groups.iter().map(Group::directory).collect(),
            all_stop: !rules.iter().flatten().any(|rules| rules.may_let_pass),
            groups,
            group_of,
        })
    }

    /// The closest hit: its triangle in the mesh, its instance; or any, of which that is said only where it may matter. Of all
    /// instances, or of one.
    #[inline(always)] // a hit that is handed on in memory is waited for
    fn trace(&self, ray: &Ray, any: bool, only: Option<u32>) -> Option<Hit> {
        let Some(only) = only else {
            let hit = self.scene.trace(ray, any, None)?;
            if any && self.all_stop {
                // Any number that there is: finding the right one would take longer than some rays.
                return Some(Hit {
                    instance: 0,
                    triangle: 0,
                    ..hit
                });
            }
            let (instance, triangle) = {
                let group = hit.instance as usize;
                self.groups[group].find(&self.directories[group], hit.triangle)
            };
            return Some(Hit {
                instance,
                triangle,
                ..hit
            });
        };
        let group = *self.group_of.get(only as usize)?;
        let hit = match &self.groups[group as usize] {
            Group::Alone { .. } => self.scene.trace(ray, any, Some(group))?,
            Group::Joined(members) => self.apart(group, members, only).trace(ray, any, None)?,
        };
        Some(Hit {
            instance: only,
            ..hit
        })
    }

    /// What rays from one place meet, in all instances or in one.
    fn trace_bundle(&self, bundle: &Bundle, only: Option<u32>) -> Met {
        let Some(only) = only else {
            return self.scene.any_of_bundle(bundle, None);
        };
        let Some(&group) = self.group_of.get(only as usize) else {
            return Met::default();
        };
        match &self.groups[group as usize] {
            Group::Alone { .. } => self.scene.any_of_bundle(bundle, Some(group)),
            Group::Joined(members) => {
                (self.apart(group, members, only)).any_of_bundle(bundle, None)
            }
        }
    }

    /// Makes it what the kernels' functions do. The scene's triangles and vertices are among the resources.
    pub(super) fn set(self: &Arc<Self>, resources: &mut Resources) {
        let [surfaces, bundle] = FUNCTIONS;
        let triangles = resources.buffer("triangles").clone();
        let vertices = resources.buffer("vertices").clone();
        let traversal = Arc::clone(self);
        let found = Surfaces {
            traversal,
            triangles,
            vertices,
        };
        resources.set_function(surfaces, Arc::new(found));
        resources.set_function(bundle, Arc::new(Bundles(Arc::clone(self))));
    }

    /// An instance of a group, by itself.
    fn apart(&self, group: u32, members: &[Member], instance: u32) -> &RayScene {
        self.apart[instance as usize].get_or_init(|| {
            let at = members.partition_point(|member| member.place < instance);
            let joined = &self.meshes[group as usize].mesh;
            let end = (members.get(at + 1)).map_or(u32::MAX, |next| next.start);
            let mesh = joined.part(members[at].start..end);
            let placed = Instance {
                mesh: 0,
                ..self.scene.instances()[group as usize]
            };
            RayScene::new(vec![Arc::new(mesh)], vec![placed], Kernel::best())
        })
    }
}

/// A hierarchy of the lower level.
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
        base.any(|(positions, _)| Arc::ptr_eq(positions, unbent) || positions == unbent)
    }
}

/// The hierarchies of another moment.
pub(super) struct Former<'a> {
    traversal: &'a HostTraversal,
    /// Whether a mesh, by its number, is the same.
    is_same: &'a (dyn Fn(u32) -> bool + Sync),
    /// Whether its triangles and materials are; it may be bent otherwise.
    has_same_triangles: &'a (dyn Fn(u32) -> bool + Sync),
    /// The first group with a mesh as its first one: it is alone, or in no other group.
    by_first: HashMap<u32, usize>,
}

/// What there is of a hierarchy from another moment.
enum Kept<'a> {
    Nothing,
    /// It is the same.
    Whole(&'a BuiltMesh),
    /// It may be bent otherwise; its triangles and materials are the same.
    Base(&'a BuiltMesh),
}

impl<'a> Former<'a> {
    /// Of a traversal; the others say of each mesh, by its number, what is as it was.
    pub(super) fn new(
        traversal: &'a HostTraversal,
        is_same: &'a (dyn Fn(u32) -> bool + Sync),
        has_same_triangles: &'a (dyn Fn(u32) -> bool + Sync),
    ) -> Self {
        let mut by_first = HashMap::new();
        for (at, group) in traversal.groups.iter().enumerate() {
            if let Some(mesh) = group.meshes().next() {
                by_first.entry(mesh).or_insert(at);
            }
        }
        Self {
            traversal,
            is_same,
            has_same_triangles,
            by_first,
        }
    }

    fn kept(&self, group: &Group) -> Kept<'a> {
        let first = group.meshes().next();
        let Some(&at) = first.and_then(|mesh| self.by_first.get(&mesh)) else {
            return Kept::Nothing;
        };
        if !self.traversal.groups[at].has_meshes_of(group) {
            return Kept::Nothing;
        }
        let built = &self.traversal.meshes[at];
        if group.meshes().all(self.is_same) {
            Kept::Whole(built)
        } else if group.meshes().all(self.has_same_triangles) {
            Kept::Base(built)
        } else {
            Kept::Nothing
        }
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

/// The surfaces that rays meet.
#[derive(Debug)]
struct Surfaces {
    traversal: Arc<HostTraversal>,
    /// What kernels ask of triangles.
    triangles: Buffer,
    vertices: Buffer,
}

thread_local! {
    /// The triangle that a path of this thread has met last; of which scene doesn't matter, for nothing is done but to fetch.
    static LATEST: Cell<u32> = const { Cell::new(u32::MAX) };
}

impl Surfaces {
    /// Begins to fetch what the next kernels ask of a triangle, each ray of another one: its vertices when the next ray has been traced,
    /// for then it is known which they are.
    #[inline]
    fn prefetch(&self, triangle: u32) {
        self.triangles.prefetch(16 * u64::from(triangle));
        let before = LATEST.replace(triangle);
        if let Some(corners) = self.triangles.peek::<3>(16 * u64::from(before)) {
            for corner in corners {
                self.vertices.prefetch(16 * u64::from(corner));
            }
        }
    }
}

impl HostFunction for Surfaces {
    /// Origin, direction, t_min, t_max, any, only_instance; `Hit` of `hit.wgsl`.
    fn words(&self) -> [usize; 2] {
        [10, 5]
    }

    fn call(&self, arguments: &[u32], result: &mut [u32]) {
        let ray: &Ray = bytemuck::from_bytes(bytemuck::cast_slice(&arguments[..8]));
        let (any, only) = (arguments[8] != 0, arguments[9]);
        let only = (only != RayHit::MISS).then_some(only);
        let hit = match self.traversal.trace(ray, any, only) {
            Some(hit) => {
                let first = self.traversal.first_triangles[hit.instance as usize];
                let triangle = first + hit.triangle;
                if !any {
                    self.prefetch(triangle);
                }
                [
                    hit.t.to_bits(),
                    hit.u.to_bits(),
                    hit.v.to_bits(),
                    triangle,
                    hit.instance,
                ]
            }
            None => [arguments[7], 0, 0, RayHit::MISS, 0],
        };
        for (word, found) in result.iter_mut().zip(hit) {
            *word = found;
        }
    }
}

/// Four rays of one place.
#[derive(Debug)]
struct Bundles(Arc<HostTraversal>);

impl HostFunction for Bundles {
    /// Origin, x, y and z of the directions, t_max, which of them, only_instance; a bit for each that is stopped, and four above
    /// for each that may be.
    fn words(&self) -> [usize; 2] {
        [18, 1]
    }

    fn call(&self, arguments: &[u32], result: &mut [u32]) {
        let number = |at: usize| f32::from_bits(arguments[at]);
        let four = |first: usize| [0, 1, 2, 3].map(|i| number(first + i));
        let bundle = Bundle {
            origin: [number(0), number(1), number(2)],
            directions: [four(3), four(7), four(11)],
            t_max: number(15),
            asked: arguments[16],
        };
        let only = (arguments[17] != RayHit::MISS).then_some(arguments[17]);
        let met = self.0.trace_bundle(&bundle, only);
        result[0] = met.opaque | (met.deferred & !met.opaque) << Bundle::RAYS;
    }
}

impl fmt::Debug for HostTraversal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HostTraversal").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::scene::{self, Material};

    /// A triangle that faces the ray, at this height.
    fn at_height(y: f32) -> scene::Mesh {
        scene::Mesh {
            positions: vec![
                Vec3::new(0.0, y, 0.0),
                Vec3::new(0.0, y, 1.0),
                Vec3::new(1.0, y, 0.0),
            ],
            triangles: vec![[0, 1, 2]],
            triangle_materials: vec![0],
            ..scene::Mesh::default()
        }
    }

    #[test]
    fn hits_name_meshes_that_lie_in_one_hierarchy() {
        let placed = |mesh: u32, x: f32| scene::Instance {
            name: String::new(),
            mesh,
            transform: Affine3A::from_translation(Vec3::X * x),
            asset: None,
        };
        let scene = Scene {
            meshes: vec![
                at_height(1.0),
                at_height(2.0),
                at_height(3.0),
                at_height(4.0),
            ],
            instances: vec![
                placed(0, 0.0),
                placed(2, 5.0),
                placed(3, 0.0),
                placed(1, 0.0),
            ],
            materials: vec![Material::default()],
            ..Scene::default()
        };
        let order = SceneBvh::in_scene_order(&scene).expect("there are triangles");
        let rule = RayRules {
            is_single_sided: false,
            may_let_pass: false,
        };
        let rules = [[rule; 2]];
        let busy = Activity::default();
        let traversal = HostTraversal::new(&scene, &order, &rules, &busy).expect("it is small");
        assert_eq!(traversal.groups.len(), 2);
        let ray = |x: f32| Ray {
            origin: [x + 0.2, 9.0, 0.2],
            direction: [0.0, -1.0, 0.0],
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        let found = |x: f32, only: Option<u32>| {
            let hit = traversal.trace(&ray(x), false, only)?;
            let triangle = traversal.first_triangles[hit.instance as usize] + hit.triangle;
            Some(((10.0 * hit.t).round() / 10.0, triangle, hit.instance))
        };
        assert_eq!(found(0.0, None), Some((5.0, 3, 2)));
        assert_eq!(found(0.0, Some(0)), Some((8.0, 0, 0)));
        assert_eq!(found(0.0, Some(3)), Some((7.0, 1, 3)));
        assert_eq!(found(0.0, Some(1)), None);
        assert_eq!(found(5.0, None), Some((6.0, 2, 1)));
        assert_eq!(found(5.0, Some(1)), Some((6.0, 2, 1)));
        // No instance has this number.
        assert_eq!(found(0.0, Some(9)), None);
    }
}
