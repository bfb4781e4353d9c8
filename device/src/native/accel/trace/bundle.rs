//! Rays of a bundle on their way through both levels, all at once: from one place they meet the same nodes and the same triangles
//! if they are short, and much of the arithmetic is that place's.

use super::{
    super::{
        layout::{DEFERRED, EMPTY, LEAF, Node, TriangleBlock, WIDTH},
        scene::Scene,
    },
    Bundle, Met, Ray,
    lanes::{Isa, Lanes},
    nodes::Slabs,
    pending::Pending,
};

/// Some of the rays: the lowest bit of each byte, the first ray's in the lowest one. So masks of a node's children by each of the
/// rays lie side by side in a word, and become those of the rays by each of the children by a shift.
type Rays4 = u32;

/// Of each ray its bit.
const ALL: Rays4 = 0x0101_0101;

/// Which of the rays meet something, in all instances or in one.
#[inline(always)]
pub(super) fn trace<S: Isa>(isa: S, scene: &Scene, bundle: &Bundle, only: Option<u32>) -> Met {
    let mut search = Search {
        met: Met::default(),
        asked: [0, 1, 2, 3].into_iter().fold(0, |asked, number| {
            asked | (bundle.asked >> number & 1) << (8 * number)
        }) & finite(bundle),
    };
    // A limit that is NaN is within no limits.
    if search.asked == 0 || bundle.t_max.is_nan() || bundle.t_max <= 0.0 {
        return search.met;
    }
    let start = match only {
        Some(instance) => LEAF | (instance & !LEAF),
        None => scene.start,
    };
    let mut memory = Pending::NEW;
    let mut pending = Pending::new(&mut memory);
    if start & LEAF != 0 {
        // There is but one: no boxes to look at.
        if start != EMPTY {
            Instances { isa, scene, bundle }.visit(
                start & !LEAF,
                search.asked,
                &mut search,
                &mut pending,
            );
        }
        return search.met;
    }
    let asked = search.asked;
    let bundled = Bundled::<S>::new(isa, bundle);
    let mut leaves = Instances { isa, scene, bundle };
    // SAFETY: the builder has numbered the nodes, and they are at most `MAX_DEPTH` deep; the stack has room for two such
    // levels, and this is the first.
    unsafe {
        descend(
            &scene.top,
            start,
            asked,
            &bundled,
            &mut search,
            &mut pending,
            &mut leaves,
        )
    };
    search.met
}

/// What has been found.
struct Search {
    met: Met,
    /// The rays that may still find something that matters.
    asked: Rays4,
}

/// What is done at leaves. Not a closure, as in `nodes`.
trait Leaves {
    fn visit(&mut self, leaf: u32, rays: Rays4, search: &mut Search, pending: &mut Pending<'_>);
}

/// The leaves of the upper level.
struct Instances<'a, S> {
    isa: S,
    scene: &'a Scene,
    bundle: &'a Bundle,
}

impl<S: Isa> Leaves for Instances<'_, S> {
    #[inline(always)]
    fn visit(&mut self, index: u32, rays: Rays4, search: &mut Search, pending: &mut Pending<'_>) {
        // All that the hierarchy names are there, but a single one needn't be.
        let Some(instance) = self.scene.instances.get(index as usize) else {
            return;
        };
        let Some(mesh) = self.scene.meshes.get(instance.mesh as usize) else {
            return;
        };
        let bundle = self.bundle.in_object(&instance.object_from_world);
        // Through a map that can't be inverted, they may not be.
        let rays = rays & finite(&bundle);
        if mesh.level.nodes.is_empty() || rays == 0 {
            return;
        }
        let bundled = Bundled::<S>::new(self.isa, &bundle);
        let mut leaves = Blocks {
            bundled: &bundled,
            blocks: &mesh.level.leaves,
        };
        // SAFETY: the builder has numbered the nodes, and they are at most `MAX_DEPTH` deep; the stack has room for two such
        // levels, and this is the second.
        unsafe {
            descend(
                &mesh.level.nodes,
                0,
                rays,
                &bundled,
                search,
                pending,
                &mut leaves,
            );
        }
    }
}

/// The leaves of the lower level.
struct Blocks<'a, S: Isa> {
    bundled: &'a Bundled<S>,
    blocks: &'a [TriangleBlock],
}

impl<S: Isa> Leaves for Blocks<'_, S> {
    #[inline(always)]
    fn visit(&mut self, block: u32, rays: Rays4, search: &mut Search, _: &mut Pending<'_>) {
        debug_assert!((block as usize) < self.blocks.len());
        // SAFETY: leaves are numbered by the builder as they are made.
        let block = unsafe { self.blocks.get_unchecked(block as usize) };
        self.bundled.in_block(block, rays, search);
    }
}

/// Visits the leaves that rays meet, until none is asked about any more.
///
/// # Safety
/// The children of `nodes` are in `nodes`, and no deeper than `MAX_DEPTH` below `start`; the stack has room for them.
#[inline(always)]
unsafe fn descend<S: Isa>(
    nodes: &[Node],
    start: u32,
    rays: Rays4,
    bundled: &Bundled<S>,
    search: &mut Search,
    pending: &mut Pending<'_>,
    leaves: &mut impl Leaves,
) {
    let floor = pending.height();
    let (mut current, mut those) = (start, rays);
    loop {
        if current & LEAF == 0 {
            debug_assert!((current as usize) < nodes.len());
            // SAFETY: the caller has made sure.
            let node = unsafe { nodes.get_unchecked(current as usize) };
            let entered = bundled.enter(node, those);
            let mut by = [0; 8];
            for (child, by) in by.iter_mut().enumerate() {
                *by = entered >> child & ALL;
            }
            let children = (entered | entered >> 8 | entered >> 16 | entered >> 24) & 0xff;
            // SAFETY: the caller has made sure.
            unsafe { pending.push(bundled.isa, &node.children, &by, children) };
        } else {
            leaves.visit(current & !LEAF, those, search, pending);
            if search.asked == 0 {
                return;
            }
        }
        loop {
            let Some((child, by)) = pending.pop(floor) else {
                return;
            };
            (current, those) = (child, by & search.asked);
            if those != 0 {
                break;
            }
        }
    }
}

/// A bundle as boxes and triangles want it.
struct Bundled<S: Isa> {
    isa: S,
    slabs: [Slabs<S::F8>; Bundle::RAYS],
    limit: S::F8,
    origin: [S::F8; 3],
    /// Of two rays at a time: four times the one's, four times the other's.
    directions: [[S::F8; 3]; Bundle::RAYS / 2],
}

impl<S: Isa> Bundled<S> {
    #[inline(always)]
    fn new(isa: S, bundle: &Bundle) -> Self {
        let [x, y, z] = bundle.origin;
        Self {
            isa,
            slabs: [
                Slabs::new(isa, &bundle.ray(0)).unforeseen(),
                Slabs::new(isa, &bundle.ray(1)).unforeseen(),
                Slabs::new(isa, &bundle.ray(2)).unforeseen(),
                Slabs::new(isa, &bundle.ray(3)).unforeseen(),
            ],
            limit: S::F8::splat(isa, bundle.t_max),
            origin: [
                S::F8::splat(isa, x),
                S::F8::splat(isa, y),
                S::F8::splat(isa, z),
            ],
            directions: [bundle.pair(isa, 0), bundle.pair(isa, 2)],
        }
    }

    /// The children of a node that each of `rays` enters, in its byte. All rays are looked at whether they are asked about or not: to choose
    /// among them takes longer.
    #[inline(always)]
    fn enter(&self, node: &Node, rays: Rays4) -> u32 {
        let planes = [
            self.planes(node, 0),
            self.planes(node, 1),
            self.planes(node, 2),
        ];
        let [a, b, c, d] = &self.slabs;
        let entered = a.enters(&planes, self.limit)
            | b.enters(&planes, self.limit) << 8
            | c.enters(&planes, self.limit) << 16
            | d.enters(&planes, self.limit) << 24;
        entered & (rays * 0xff)
    }

    /// The planes of a node's boxes across an axis, seen from the origin.
    #[inline(always)]
    fn planes(&self, node: &Node, axis: usize) -> [S::F8; 2] {
        let [least, most] = &node.bounds[axis];
        [
            S::F8::load(self.isa, least).sub(self.origin[axis]),
            S::F8::load(self.isa, most).sub(self.origin[axis]),
        ]
    }

    /// A corner of a block's triangles, seen from the origin, twice.
    #[inline(always)]
    fn corner(&self, corners: &[[f32; WIDTH]; 3]) -> [S::F8; 3] {
        [
            self.isa.twice(&corners[0]).sub(self.origin[0]),
            self.isa.twice(&corners[1]).sub(self.origin[1]),
            self.isa.twice(&corners[2]).sub(self.origin[2]),
        ]
    }

    /// Looks which rays meet the triangles of a block: on which sides of the planes through their origin and an edge they go, as
    /// [`Line`](super::triangles::Line) does it where its space isn't turned for each of them. What two triangles share they
    /// compute alike, so that no ray passes between them.
    #[inline(always)]
    fn in_block(&self, block: &TriangleBlock, rays: Rays4, search: &mut Search) {
        let isa = self.isa;
        let a = self.corner(&block.corners[0]);
        let b = self.corner(&block.corners[1]);
        let c = self.corner(&block.corners[2]);
        let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        let volume = dot(a, u);
        let words = isa.twice(bytemuck::cast_ref(&block.words));
        let zero = S::F8::splat(isa, 0.0);
        // Of each ray which of the four triangles it meets.
        let mut meets = 0;
        for (pair, &direction) in self.directions.iter().enumerate() {
            let (u, v, w) = (dot(direction, u), dot(direction, v), dot(direction, w));
            let determinant = u.add(v).add(w);
            let sign = determinant.and(S::F8::splat(isa, -0.0));
            let size = determinant.xor(sign);
            let t = volume.xor(sign);
            let is_inside = S::F8::both(
                zero.le(u.xor(sign)),
                S::F8::both(zero.le(v.xor(sign)), zero.le(w.xor(sign))),
            );
            let is_between = S::F8::both(zero.lt(t), t.lt(size.mul(self.limit)));
            // The flag of single-sided triangles is the highest bit, as is a sign.
            let is_culled = sign.and(words).sign_bits();
            let those = S::F8::mask_bits(S::F8::both(is_inside, is_between)) & !is_culled;
            meets |= those << (2 * WIDTH * pair);
        }
        while meets != 0 {
            let (number, lane) = (
                meets.trailing_zeros() as usize / WIDTH,
                meets.trailing_zeros() as usize % WIDTH,
            );
            meets &= meets - 1;
            if rays >> (8 * number) & 1 == 0 {
                continue;
            }
            if block.words[lane] & DEFERRED != 0 {
                search.met.deferred |= 1 << number;
            } else {
                search.met.opaque |= 1 << number;
                search.asked &= !(1 << (8 * number));
            }
        }
    }
}

/// Of corners p and q: the same but for the sign if they change places, which it wouldn't be if one product were not rounded.
#[inline(always)]
fn cross<F: Lanes<8>>(p: [F; 3], q: [F; 3]) -> [F; 3] {
    [
        p[1].mul(q[2]).sub(p[2].mul(q[1])),
        p[2].mul(q[0]).sub(p[0].mul(q[2])),
        p[0].mul(q[1]).sub(p[1].mul(q[0])),
    ]
}

#[inline(always)]
fn dot<F: Lanes<8>>(p: [F; 3], q: [F; 3]) -> F {
    p[0].mul_add(q[0], p[1].mul_add(q[1], p[2].mul(q[2])))
}

#[inline(always)]
fn halves<S: Isa>(isa: S, a: f32, b: f32) -> S::F8 {
    S::F8::load(isa, &[a, a, a, a, b, b, b, b])
}

/// The rays whose places are numbers, and finite.
#[inline(always)]
fn finite(bundle: &Bundle) -> Rays4 {
    (u32::from(bundle.ray(0).is_finite()))
        | (u32::from(bundle.ray(1).is_finite()) << 8)
        | (u32::from(bundle.ray(2).is_finite()) << 16)
        | (u32::from(bundle.ray(3).is_finite()) << 24)
}

impl Bundle {
    #[inline(always)]
    fn ray(&self, number: usize) -> Ray {
        Ray {
            origin: self.origin,
            direction: self.direction(number),
            t_min: 0.0,
            t_max: self.t_max,
        }
    }

    #[inline(always)]
    fn direction(&self, number: usize) -> [f32; 3] {
        let [x, y, z] = &self.directions;
        [x[number], y[number], z[number]]
    }

    /// The directions of two rays, along each axis: the one's in four lanes, the other's in the other four.
    #[inline(always)]
    fn pair<S: Isa>(&self, isa: S, first: usize) -> [S::F8; 3] {
        let [x, y, z] = &self.directions;
        [
            halves(isa, x[first], x[first + 1]),
            halves(isa, y[first], y[first + 1]),
            halves(isa, z[first], z[first + 1]),
        ]
    }

    /// As the mesh sees it; distances stay the same.
    #[inline(always)]
    fn in_object(&self, object_from_world: &[[f32; 4]; 3]) -> Self {
        let mut object = *self;
        for (axis, m) in object_from_world.iter().enumerate() {
            let [x, y, z] = self.origin;
            object.origin[axis] = m[0] * x + m[1] * y + m[2] * z + m[3];
            for number in 0..Self::RAYS {
                let [x, y, z] = self.direction(number);
                object.directions[axis][number] = m[0] * x + m[1] * y + m[2] * z;
            }
        }
        object
    }
}
