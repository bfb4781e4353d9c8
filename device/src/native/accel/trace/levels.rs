//! A ray on its way through both levels.

use super::{
    super::{
        build::Hierarchy,
        layout::{LEAF, TriangleBlock},
        scene::{Instance, Scene},
    },
    Candidate, Hit, Ray,
    lanes::Isa,
    nodes::descend,
    stack::{Memory, Stack},
    triangles::Line,
};

/// The closest hit, or with `ANY` some hit; of one instance if `only` names it. With `ANY`, a deferred triangle is reported
/// only if it is the closest.
#[inline(always)]
pub(super) fn trace<S: Isa, const ANY: bool>(
    isa: S,
    scene: &Scene,
    ray: &Ray,
    only: Option<u32>,
    filter: &impl Fn(&Candidate) -> bool,
) -> Option<Hit> {
    // A limit that is NaN is within no limits.
    if !(ray.is_finite() && ray.t_min < ray.t_max) {
        return None;
    }
    let start = match only {
        Some(instance) => LEAF | (instance & !LEAF),
        None => scene.start,
    };
    let mut hit = None;
    let mut memory = Memory::uninit();
    let mut stack = Stack::new(&mut memory);
    let in_instance = |index: u32, t_max: f32, stack: &mut Stack<'_>| {
        // All that the hierarchy names are there, but `only` needn't be.
        let Some(instance) = scene.instances.get(index as usize) else {
            return Some(t_max);
        };
        let Some(mesh) = scene.meshes.get(instance.mesh as usize) else {
            return Some(t_max);
        };
        let mesh = &mesh.level;
        let ray = instance.ray_in_object(ray);
        // Through a map that can't be inverted, it may not be.
        if mesh.nodes.is_empty() || !ray.is_finite() {
            return Some(t_max);
        }
        isa.in_mesh::<ANY>(mesh, &ray, t_max, stack, index, &mut hit, filter)
    };
    // SAFETY: the builder has numbered the nodes, and they are at most `MAX_DEPTH` deep; the stack has room for two such
    // levels, and this is the first.
    unsafe {
        descend(
            isa,
            &scene.top,
            start,
            ray,
            ray.t_max,
            &mut stack,
            in_instance,
        )
    };
    hit
}

/// The part of [`trace`] that goes through a mesh, which isn't empty, by a ray as the mesh sees it. `t_max` and what is returned
/// are as in [`descend`]. Each instruction set has it as a function of its own ([`Isa::in_mesh`]): inlined into the other level,
/// its loop had not enough registers.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "it stands for a closure")]
pub(super) fn in_mesh<S: Isa, const ANY: bool>(
    isa: S,
    mesh: &Hierarchy<TriangleBlock>,
    ray: &Ray,
    t_max: f32,
    stack: &mut Stack<'_>,
    instance: u32,
    hit: &mut Option<Hit>,
    filter: &impl Fn(&Candidate) -> bool,
) -> Option<f32> {
    let line = Line::<S::F4>::new(isa, ray);
    let in_block = |block: u32, t_max: f32, _: &mut Stack<'_>| {
        debug_assert!((block as usize) < mesh.leaves.len());
        // SAFETY: leaves are numbered by the builder as they are made.
        let block = unsafe { mesh.leaves.get_unchecked(block as usize) };
        line.intersect::<ANY>(isa, block, instance, t_max, hit, filter)
    };
    // SAFETY: the builder has numbered the nodes, and they are at most `MAX_DEPTH` deep; the stack has room for two such
    // levels, and this is the second.
    unsafe { descend(isa, &mesh.nodes, 0, ray, t_max, stack, in_block) }
}

impl Ray {
    /// Whether its places are numbers, and finite.
    #[inline(always)]
    fn is_finite(&self) -> bool {
        let [a, b, c] = self.origin;
        let [d, e, f] = self.direction;
        let sum = (a * 0.0 + b * 0.0) + (c * 0.0 + d * 0.0) + (e * 0.0 + f * 0.0);
        sum == 0.0
    }
}

impl Instance {
    /// The ray as the mesh sees it; distances stay the same.
    #[inline(always)]
    fn ray_in_object(&self, ray: &Ray) -> Ray {
        // Not `f32::mul_add`: where there is no such instruction that is a call.
        let row =
            |m: [f32; 4], p: [f32; 3], w: f32| m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3] * w;
        Ray {
            origin: self.object_from_world.map(|m| row(m, ray.origin, 1.0)),
            direction: self.object_from_world.map(|m| row(m, ray.direction, 0.0)),
            ..*ray
        }
    }
}
