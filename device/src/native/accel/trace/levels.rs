//! A ray on its way through both levels.

use std::hint::black_box;

use super::{
    super::{
        build::Hierarchy,
        layout::{EMPTY, LEAF, TriangleBlock},
        scene::{Instance, Scene},
    },
    Candidate, Hit, Ray,
    lanes::Isa,
    nodes::{Visit, descend},
    stack::Stack,
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
    let ray = &ray.read_one_by_one();
    // A limit that is NaN is within no limits.
    if !(ray.is_finite() && ray.t_min < ray.t_max) {
        return None;
    }
    let start = match only {
        Some(instance) => LEAF | (instance & !LEAF),
        None => scene.start,
    };
    let mut memory = Stack::NEW;
    let mut stack = Stack::new(&mut memory);
    let mut instances = Instances::<S, ANY, _> {
        isa,
        scene,
        ray,
        hit: None,
        filter,
    };
    if start & LEAF != 0 {
        // There is but one: no boxes to look at.
        if start != EMPTY {
            instances.visit(start & !LEAF, ray.t_max, &mut stack);
        }
        return instances.hit.as_ref().map(Hit::read_one_by_one);
    }
    // SAFETY: the builder has numbered the nodes, and they are at most `MAX_DEPTH` deep; the stack has room for two such
    // levels, and this is the first.
    unsafe {
        descend::<S, ANY>(
            isa,
            &scene.top,
            start,
            ray,
            ray.t_max,
            &mut stack,
            &mut instances,
        )
    };
    instances.hit.as_ref().map(Hit::read_one_by_one)
}

/// The leaves of the upper level.
struct Instances<'a, S, const ANY: bool, F> {
    isa: S,
    scene: &'a Scene,
    ray: &'a Ray,
    hit: Option<Hit>,
    filter: &'a F,
}

impl<S: Isa, const ANY: bool, F: Fn(&Candidate) -> bool> Visit for Instances<'_, S, ANY, F> {
    #[inline(always)]
    fn visit(&mut self, index: u32, t_max: f32, stack: &mut Stack<'_>) -> Option<f32> {
        // All that the hierarchy names are there, but a single one needn't be.
        let Some(instance) = self.scene.instances.get(index as usize) else {
            return Some(t_max);
        };
        let Some(mesh) = self.scene.meshes.get(instance.mesh as usize) else {
            return Some(t_max);
        };
        let mesh = &mesh.level;
        let ray = instance.ray_in_object(self.ray);
        // Through a map that can't be inverted, it may not be.
        if mesh.nodes.is_empty() || !ray.is_finite() {
            return Some(t_max);
        }
        let (hit, filter) = (&mut self.hit, self.filter);
        self.isa
            .in_mesh::<ANY>(mesh, &ray, t_max, stack, index, hit, filter)
    }
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
    let mut blocks = Blocks::<S, ANY, _> {
        isa,
        line: Line::new(isa, ray),
        blocks: &mesh.leaves,
        instance,
        hit,
        filter,
    };
    // SAFETY: the builder has numbered the nodes, and they are at most `MAX_DEPTH` deep; the stack has room for two such
    // levels, and this is the second.
    unsafe { descend::<S, ANY>(isa, &mesh.nodes, 0, ray, t_max, stack, &mut blocks) }
}

/// The leaves of the lower level.
struct Blocks<'a, S: Isa, const ANY: bool, F> {
    isa: S,
    line: Line<S::F4>,
    blocks: &'a [TriangleBlock],
    instance: u32,
    hit: &'a mut Option<Hit>,
    filter: &'a F,
}

impl<S: Isa, const ANY: bool, F: Fn(&Candidate) -> bool> Visit for Blocks<'_, S, ANY, F> {
    #[inline(always)]
    fn visit(&mut self, block: u32, t_max: f32, _: &mut Stack<'_>) -> Option<f32> {
        debug_assert!((block as usize) < self.blocks.len());
        // SAFETY: leaves are numbered by the builder as they are made.
        let block = unsafe { self.blocks.get_unchecked(block as usize) };
        let (instance, hit, filter) = (self.instance, &mut *self.hit, self.filter);
        self.line
            .intersect::<ANY>(self.isa, block, instance, t_max, hit, filter)
    }
}

impl Hit {
    /// A copy, as [`Ray::read_one_by_one`] makes one.
    #[inline(always)]
    pub(super) fn read_one_by_one(&self) -> Self {
        Self {
            t: black_box(self.t),
            u: black_box(self.u),
            v: black_box(self.v),
            triangle: black_box(self.triangle),
            instance: black_box(self.instance),
        }
    }
}

impl Ray {
    /// A copy. Whoever calls has just written the numbers, one by one; where they are read two at a time, the processor waits until
    /// they have arrived in the cache, for it hands on what was written only where it is read likewise.
    #[inline(always)]
    fn read_one_by_one(&self) -> Self {
        let [a, b, c] = self.origin;
        let [d, e, f] = self.direction;
        Self {
            origin: [black_box(a), black_box(b), black_box(c)],
            direction: [black_box(d), black_box(e), black_box(f)],
            t_min: black_box(self.t_min),
            t_max: black_box(self.t_max),
        }
    }

    /// Whether its places are numbers, and finite.
    #[inline(always)]
    pub(super) fn is_finite(&self) -> bool {
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
        let [x, y, z] = &self.object_from_world;
        Ray {
            origin: [
                row(x, ray.origin, 1.0),
                row(y, ray.origin, 1.0),
                row(z, ray.origin, 1.0),
            ],
            direction: [
                row(x, ray.direction, 0.0),
                row(y, ray.direction, 0.0),
                row(z, ray.direction, 0.0),
            ],
            ..*ray
        }
    }
}

/// A row of a map times a point, or a vector where `w` is 0. Not by `f32::mul_add`: where there is no such instruction that is a
/// call.
#[inline(always)]
fn row(m: &[f32; 4], p: [f32; 3], w: f32) -> f32 {
    m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3] * w
}
