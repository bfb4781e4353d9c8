//! A ray against the triangles of a block.

use super::{
    super::layout::{DEFERRED, FILTERED, INDEX, TriangleBlock, WIDTH},
    Candidate, Hit, Ray,
    lanes::Lanes,
};

/// A ray as triangles want it: turned and sheared so that it goes along the z axis, where a triangle is met if the origin is
/// in its projection.
pub(super) struct Line<F> {
    /// The axes in their new order, the ray's longest last: a permutation of 0, 1, 2.
    axes: [usize; 3],
    origin: [F; 3],
    /// What is added to x and y for each unit of z, and the length of that in units of the ray.
    shear: [F; 3],
    t_min: f32,
}

impl<F: Lanes<WIDTH>> Line<F> {
    #[inline(always)]
    pub(super) fn new(isa: F::Isa, ray: &Ray) -> Self {
        let d = ray.direction;
        let [x, y, z] = [d[0].abs(), d[1].abs(), d[2].abs()];
        let longest = if x > y {
            if x > z { 0 } else { 2 }
        } else if y > z {
            1
        } else {
            2
        };
        let (next, last) = [(1, 2), (2, 0), (0, 1)][longest];
        // So that triangles turn as they did.
        let axes = if d[longest] < 0.0 {
            [last, next, longest]
        } else {
            [next, last, longest]
        };
        let per_unit = 1.0 / d[longest];
        let shear = [-d[axes[0]] * per_unit, -d[axes[1]] * per_unit, per_unit];
        Self {
            axes,
            origin: [
                F::splat(isa, ray.origin[axes[0]]),
                F::splat(isa, ray.origin[axes[1]]),
                F::splat(isa, ray.origin[axes[2]]),
            ],
            shear: [
                F::splat(isa, shear[0]),
                F::splat(isa, shear[1]),
                F::splat(isa, shear[2]),
            ],
            t_min: ray.t_min,
        }
    }

    /// Corners of the block's triangles as the ray sees them.
    #[inline(always)]
    fn sheared(&self, isa: F::Isa, corners: &[[f32; WIDTH]; 3]) -> [F; 3] {
        let z = self.along(isa, corners, 2);
        [
            z.mul_add(self.shear[0], self.along(isa, corners, 0)),
            z.mul_add(self.shear[1], self.along(isa, corners, 1)),
            z,
        ]
    }

    /// Their coordinates from the origin, along one of its axes.
    #[inline(always)]
    fn along(&self, isa: F::Isa, corners: &[[f32; WIDTH]; 3], i: usize) -> F {
        // SAFETY: `axes` holds 0, 1 and 2.
        let row = unsafe { corners.get_unchecked(self.axes[i]) };
        F::load(isa, row).sub(self.origin[i])
    }

    /// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, without its fallback to double
    /// precision and without the division until there is a hit. What two triangles share they compute alike, so that no ray
    /// passes between them.
    ///
    /// `hit` becomes the closest of those that are closer than `t_max`, which is returned, or `None` if the search is over:
    /// with `ANY`, at a triangle that isn't deferred.
    #[inline(always)]
    pub(super) fn intersect<const ANY: bool>(
        &self,
        isa: F::Isa,
        block: &TriangleBlock,
        instance: u32,
        mut t_max: f32,
        hit: &mut Option<Hit>,
        filter: &impl Fn(&Candidate) -> bool,
    ) -> Option<f32> {
        let a = self.sheared(isa, &block.corners[0]);
        let b = self.sheared(isa, &block.corners[1]);
        let c = self.sheared(isa, &block.corners[2]);
        let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
        // Negative where the ray meets the back. A degenerate triangle has none, and no hit by the strict comparisons of t.
        let determinant = u.add(v).add(w);
        let sign = determinant.and(F::splat(isa, -0.0));
        let size = determinant.xor(sign);
        let t = u
            .mul_add(a[2], v.mul_add(b[2], w.mul(c[2])))
            .mul(self.shear[2])
            .xor(sign);
        let (u, v, w) = (u.xor(sign), v.xor(sign), w.xor(sign));
        let zero = F::splat(isa, 0.0);
        let is_inside = F::both(zero.le(u), F::both(zero.le(v), zero.le(w)));
        let is_behind = size.mul(F::splat(isa, self.t_min)).lt(t);
        let is_before = t.lt(size.mul(F::splat(isa, t_max)));
        // The flag of single-sided triangles is the highest bit, as is a sign.
        let is_culled = sign.and(F::load_bits(isa, &block.words)).sign_bits();
        let mut mask = F::mask_bits(F::both(is_inside, F::both(is_behind, is_before))) & !is_culled;
        if mask == 0 {
            return Some(t_max);
        }
        let (size, t) = (size.to_array(), t.to_array());
        let (v, w) = (v.to_array(), w.to_array());
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize & (WIDTH - 1);
            mask &= mask - 1;
            let inverse = 1.0 / size[lane];
            let word = block.words[lane];
            let found = Hit {
                t: t[lane] * inverse,
                u: v[lane] * inverse,
                v: w[lane] * inverse,
                triangle: word & INDEX,
                instance,
            };
            // Again after the division: a ray that starts anew at a hit must not find it once more.
            if found.t > self.t_min && found.t < t_max && (word & FILTERED == 0 || filter(&found)) {
                *hit = Some(found);
                t_max = found.t;
                if ANY && word & DEFERRED == 0 {
                    return None;
                }
            }
        }
        Some(t_max)
    }
}

/// The side of an edge on which the ray is. The same but for the sign if the corners change places, which it wouldn't be if one
/// product were not rounded.
#[inline(always)]
fn edge<F: Lanes<WIDTH>>(p: [F; 3], q: [F; 3]) -> F {
    p[0].mul(q[1]).sub(p[1].mul(q[0]))
}
