//! A ray on its way through the nodes of one level.

use std::hint::black_box;

use super::{
    super::layout::{EMPTY, LEAF, Node},
    Ray,
    lanes::{Isa, Lanes},
    stack::Stack,
};

/// A ray as boxes want it.
pub(super) struct Slabs<F> {
    origin: [F; 3],
    /// Reciprocals of the direction, by which the ray meets near planes, and far ones.
    inverse: [[F; 3]; 2],
    t_min: F,
    /// Which of a box's two planes the ray meets first, per axis.
    near: [usize; 3],
}

/// By how much far planes are moved away: by the rounding of a subtraction and a product (Ize, "Robust BVH Ray Traversal", JCGT
/// 2(2), 2013).
const WIDENING: f32 = 1.000_000_5;

impl<F: Lanes<8>> Slabs<F> {
    #[inline(always)]
    pub(super) fn new(isa: F::Isa, ray: &Ray) -> Self {
        let [x, y, z] = ray.direction;
        let x = 1.0 / bounded_away_from_zero(x);
        let y = 1.0 / bounded_away_from_zero(y);
        let z = 1.0 / bounded_away_from_zero(z);
        Self {
            origin: [
                F::splat(isa, ray.origin[0]),
                F::splat(isa, ray.origin[1]),
                F::splat(isa, ray.origin[2]),
            ],
            inverse: [
                [F::splat(isa, x), F::splat(isa, y), F::splat(isa, z)],
                [
                    F::splat(isa, x * WIDENING),
                    F::splat(isa, y * WIDENING),
                    F::splat(isa, z * WIDENING),
                ],
            ],
            // Not -0, whose bits are those of the least number.
            t_min: F::splat(isa, ray.t_min.max(0.0) + 0.0),
            near: [
                usize::from(x < 0.0),
                usize::from(y < 0.0),
                usize::from(z < 0.0),
            ],
        }
    }

    /// This ray, but so that the compiler doesn't know which planes are near. It makes a choice of two planes a branch, else, and
    /// rays of a bundle choose differently.
    #[inline(always)]
    pub(super) fn unforeseen(self) -> Self {
        let [x, y, z] = self.near;
        Self {
            near: [black_box(x), black_box(y), black_box(z)],
            ..self
        }
    }

    /// The mask of the children whose boxes the ray enters, by a node's planes as seen from its origin.
    #[inline(always)]
    pub(super) fn enters(&self, planes: &[[F; 2]; 3], t_max: F) -> u32 {
        let enter = [
            self.reach(planes, 0, 0),
            self.reach(planes, 1, 0),
            self.reach(planes, 2, 0),
        ];
        let leave = [
            self.reach(planes, 0, 1),
            self.reach(planes, 1, 1),
            self.reach(planes, 2, 1),
        ];
        let enter = enter[0].later(enter[1]).later(enter[2].later(self.t_min));
        let leave = leave[0].earlier(leave[1]).earlier(leave[2].earlier(t_max));
        enter.not_after(leave)
    }

    /// Where the ray meets the planes across an axis, the nearer ones or, with `is_far`, the others.
    #[inline(always)]
    fn reach(&self, planes: &[[F; 2]; 3], axis: usize, is_far: usize) -> F {
        planes[axis][(self.near[axis] ^ is_far) & 1].mul(self.inverse[is_far][axis])
    }

    /// Where the ray enters each child's box, and the mask of those that it enters.
    #[inline(always)]
    pub(super) fn intersect(&self, isa: F::Isa, node: &Node, t_max: F) -> (F, u32) {
        let near = [
            self.plane(isa, node, 0, 0),
            self.plane(isa, node, 1, 0),
            self.plane(isa, node, 2, 0),
        ];
        let far = [
            self.plane(isa, node, 0, 1),
            self.plane(isa, node, 1, 1),
            self.plane(isa, node, 2, 1),
        ];
        // Of two planes behind the origin it doesn't matter which: the ray begins before the near one, and ends before a far one.
        let enter = near[0].later(near[1]).later(near[2].later(self.t_min));
        let leave = far[0].earlier(far[1]).earlier(far[2].earlier(t_max));
        (enter, enter.not_after(leave))
    }

    /// Where the ray meets the children's planes across an axis, the nearer ones or, with `is_far`, the others.
    #[inline(always)]
    fn plane(&self, isa: F::Isa, node: &Node, axis: usize, is_far: usize) -> F {
        let plane = F::load(isa, &node.bounds[axis][(self.near[axis] ^ is_far) & 1]);
        // Subtracted before it is multiplied: rounded the other way round, near boxes far from the origin are missed.
        plane.sub(self.origin[axis]).mul(self.inverse[is_far][axis])
    }
}

/// A component of a direction whose reciprocal is finite.
#[inline(always)]
fn bounded_away_from_zero(d: f32) -> f32 {
    if d.abs() < 1e-18 {
        1e-18f32.copysign(d)
    } else {
        d
    }
}

/// What a ray does at leaves. Not a closure: those aren't always inlined, and where they aren't, they are compiled for another
/// instruction set.
pub(super) trait Visit {
    /// At a leaf, by a ray that goes as far as `t_max`: how far it goes from then on, or `None` to end the search.
    fn visit(&mut self, leaf: u32, t_max: f32, stack: &mut Stack<'_>) -> Option<f32>;
}

/// Visits the leaves that the ray meets, in about the order in which it meets them, or with `ANY` in that of the children of nodes. Returns how far the ray goes in the end, or
/// `None` if a visit has ended the search. `nodes` are those of a level,
/// `start` is its root or a leaf.
///
/// # Safety
/// The children of `nodes` are in `nodes`, and no deeper than `MAX_DEPTH` below `start`; the stack has room for them.
#[inline(always)]
pub(super) unsafe fn descend<S: Isa, const ANY: bool>(
    isa: S,
    nodes: &[Node],
    start: u32,
    ray: &Ray,
    t_max: f32,
    stack: &mut Stack<'_>,
    leaves: &mut impl Visit,
) -> Option<f32> {
    let slabs = Slabs::<S::F8>::new(isa, ray);
    let floor = stack.height();
    let mut t_max = t_max;
    let mut limit = S::F8::splat(isa, t_max);
    let mut current = start;
    loop {
        while current & LEAF == 0 {
            debug_assert!((current as usize) < nodes.len());
            // SAFETY: the caller has made sure.
            let node = unsafe { nodes.get_unchecked(current as usize) };
            let (enter, mask) = slabs.intersect(isa, node, limit);
            if mask & mask.wrapping_sub(1) != 0 {
                // SAFETY: the caller has made sure.
                current = unsafe {
                    match ANY {
                        true => stack.push_in_order(&node.children, &enter.to_array(), mask),
                        false => stack.push_sorted(&node.children, &enter.to_array(), mask),
                    }
                };
            } else if mask != 0 {
                current = node.children[mask.trailing_zeros() as usize & 7];
            } else {
                current = EMPTY;
            }
        }
        if current != EMPTY {
            let reached = leaves.visit(current & !LEAF, t_max, stack)?;
            if reached != t_max {
                t_max = reached;
                limit = S::F8::splat(isa, t_max);
            }
        }
        match stack.pop(floor, t_max) {
            Some(child) => current = child,
            None => return Some(t_max),
        }
    }
}
