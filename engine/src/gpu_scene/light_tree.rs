//! The light tree: a hierarchy over the lights that have a place, so that a point chooses among many by how bright they
//! may be there (Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", HPG 2018;
//! Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, section 12.6). This is its construction; the
//! kernels descend it in `light_tree.wgsl`.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};

/// Set in `child` of a leaf; the other bits are the number of its light.
const LEAF: u32 = 1 << 31;
/// Candidates for a split along each axis.
const BUCKETS: usize = 12;
/// Below this depth halves are made, so that no arrangement of lights makes the tree deep or its construction slow.
const SAH_DEPTH: u32 = 40;
/// Subtrees with more lights than this are built in parallel.
const PARALLEL: usize = 4096;

/// `LightNode` in `light_tree.wgsl`. The root is the first; from the third on nodes lie in pairs of siblings, so that the
/// sibling of node `i` is `i ^ 1`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct GpuLightNode {
    low: Vec3,
    child: u32,
    high: Vec3,
    parent: u32,
    axis: Vec3,
    intensity: f32,
    cos_spread: f32,
    cos_reach: f32,
    two_sided: u32,
    sin_spread: f32,
}

impl GpuLightNode {
    /// Byte offset of each member, for comparison with its WGSL twin.
    pub fn offsets() -> Vec<(&'static str, usize)> {
        macro_rules! offsets {
            ($($member:ident),* $(,)?) => { vec![$((stringify!($member), std::mem::offset_of!(GpuLightNode, $member))),*] };
        }
        offsets![
            low, child, high, parent, axis, intensity, cos_spread, cos_reach, two_sided, sin_spread
        ]
    }

    /// The light of a leaf.
    pub fn light(&self) -> Option<u32> {
        (self.child & LEAF != 0).then_some(self.child & !LEAF)
    }
}

/// Where some lights are, whereto they shine and how much.
#[derive(Debug, Clone, Copy)]
pub struct Emitter {
    /// Least corner, metres.
    pub low: Vec3,
    /// Greatest corner, metres.
    pub high: Vec3,
    /// Middle of the directions in which surfaces face.
    pub axis: Vec3,
    /// Cosine of the angle around `axis` in which all of them lie.
    pub cos_spread: f32,
    /// Cosine of the angle around each of them beyond which no light goes, at most 90°.
    pub cos_reach: f32,
    /// Greatest radiant intensity in any direction, W/sr.
    pub intensity: f32,
    /// The same goes for the opposite directions.
    pub two_sided: bool,
}

impl Emitter {
    /// A triangle by its corners, whose front is on the side of `normal`. `intensity` is radiance times area.
    pub fn triangle(corners: [Vec3; 3], normal: Vec3, intensity: f32, two_sided: bool) -> Self {
        let [a, b, c] = corners;
        Self {
            low: a.min(b).min(c),
            high: a.max(b).max(c),
            axis: normal,
            cos_spread: 1.0,
            cos_reach: 0.0,
            intensity,
            two_sided,
        }
    }

    /// A point that shines into a cone around `axis` of this half angle, radians; π for all directions.
    pub fn point(position: Vec3, axis: Vec3, angle: f32, intensity: f32) -> Self {
        /// Rounding must not put out a light at the rim of its cone.
        const SLACK: f32 = 0.02;
        Self {
            low: position,
            high: position,
            axis,
            cos_spread: angle.cos(),
            cos_reach: SLACK.cos(),
            intensity,
            two_sided: false,
        }
    }

    fn center(&self) -> Vec3 {
        0.5 * (self.low + self.high)
    }

    /// Both as one.
    pub fn union(&self, other: &Self) -> Self {
        let (axis, cos_spread) =
            cone_union((self.axis, self.cos_spread), (other.axis, other.cos_spread));
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            axis,
            cos_spread,
            cos_reach: self.cos_reach.min(other.cos_reach),
            intensity: self.intensity + other.intensity,
            two_sided: self.two_sided || other.two_sided,
        }
    }

    fn node(&self, child: u32, parent: u32) -> GpuLightNode {
        GpuLightNode {
            low: self.low,
            child,
            high: self.high,
            parent,
            axis: self.axis,
            intensity: self.intensity,
            cos_spread: self.cos_spread,
            cos_reach: self.cos_reach,
            two_sided: u32::from(self.two_sided),
            sin_spread: (1.0 - self.cos_spread * self.cos_spread).max(0.0).sqrt(),
        }
    }
}

/// The least cone around two cones, each an axis and a cosine.
fn cone_union((a, cos_a): (Vec3, f32), (b, cos_b): (Vec3, f32)) -> (Vec3, f32) {
    let everything = (a, -1.0);
    let (spread_a, spread_b) = (cos_a.clamp(-1.0, 1.0).acos(), cos_b.clamp(-1.0, 1.0).acos());
    let across = a.cross(b);
    // Exact for small angles too, which the arc cosine isn't.
    let between = across.length().atan2(a.dot(b));
    if (between + spread_b).min(PI) <= spread_a {
        return (a, cos_a);
    }
    if (between + spread_a).min(PI) <= spread_b {
        return (b, cos_b);
    }
    let spread = 0.5 * (spread_a + between + spread_b);
    let Some(hinge) = across.try_normalize().filter(|_| spread < PI) else {
        return everything;
    };
    let axis = Quat::from_axis_angle(hinge, spread - spread_a) * a;
    (axis.normalize(), spread.cos())
}

/// The tree over lamps, none of which is without intensity, each with the number of its first light. Empty if there are none, or else two
/// records a light. Takes n log n steps for n lights, wherever they are.
pub fn build(emitters: &[(u32, Emitter)]) -> Vec<GpuLightNode> {
    if emitters.is_empty() {
        return Vec::new();
    }
    // Only ratios count, and those of extreme lights are not to be lost.
    let total: f64 = (emitters.iter())
        .map(|(_, emitter)| f64::from(emitter.intensity))
        .sum();
    let mut items: Vec<Item> = (emitters.iter())
        .map(|(light, emitter)| Item {
            light: *light,
            center: emitter.center(),
            emitter: Emitter {
                intensity: (f64::from(emitter.intensity) / total) as f32,
                ..*emitter
            },
        })
        .collect();
    let mut nodes = vec![GpuLightNode::zeroed(); 2 * items.len()];
    let (tops, below) = nodes.split_at_mut(2);
    let place = Place {
        own: 0,
        parent: 0,
        first: 2,
        depth: 0,
    };
    let root = subtree(&mut items, below, place);
    tops[0] = root.1;
    nodes
}

struct Item {
    light: u32,
    center: Vec3,
    emitter: Emitter,
}

/// Where a subtree goes: its root's number and that of its parent, and the number of the first node below it.
#[derive(Clone, Copy)]
struct Place {
    own: u32,
    parent: u32,
    first: u32,
    depth: u32,
}

/// Fills `below` with the nodes below the root of a subtree and returns the root itself.
fn subtree(
    items: &mut [Item],
    below: &mut [GpuLightNode],
    place: Place,
) -> (Emitter, GpuLightNode) {
    if let [item] = items {
        return (
            item.emitter,
            item.emitter.node(item.light | LEAF, place.parent),
        );
    }
    let is_large = items.len() > PARALLEL;
    let middle = split(items, place.depth);
    let (left, right) = items.split_at_mut(middle);
    let (pair, rest) = below.split_at_mut(2);
    let (left_below, right_below) = rest.split_at_mut(2 * (left.len() - 1));
    let left_place = Place {
        own: place.first,
        parent: place.own,
        first: place.first + 2,
        depth: place.depth + 1,
    };
    let right_place = Place {
        own: place.first + 1,
        first: left_place.first + left_below.len() as u32,
        ..left_place
    };
    let mut build_left = || subtree(left, left_below, left_place);
    let mut build_right = || subtree(right, right_below, right_place);
    let (l, r) = if is_large {
        rayon::join(build_left, build_right)
    } else {
        (build_left(), build_right())
    };
    pair[0] = l.1;
    pair[1] = r.1;
    let union = l.0.union(&r.0);
    (union, union.node(place.first, place.parent))
}

/// Sorts lights into two groups that are not empty; returns the length of the first.
fn split(items: &mut [Item], depth: u32) -> usize {
    let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
    for item in items.iter() {
        low = low.min(item.center);
        high = high.max(item.center);
    }
    let extent = high - low;
    if items.len() > 2
        && depth < SAH_DEPTH
        && let Some((axis, last)) = cheapest(items, low, extent)
    {
        let buckets = bucket_count(items);
        return partition(items, |item| {
            bucket(item.center[axis], low[axis], extent[axis], buckets) <= last
        });
    }
    let axis = extent.max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        a.center[axis]
            .total_cmp(&b.center[axis])
            .then(a.light.cmp(&b.light))
    });
    middle
}

fn bucket_count(items: &[Item]) -> usize {
    items.len().min(BUCKETS)
}

fn bucket(at: f32, low: f32, extent: f32, buckets: usize) -> usize {
    (((at - low) / extent * buckets as f32) as usize).min(buckets - 1)
}

/// Brings the items of the first group to the front; returns how many there are.
fn partition(items: &mut [Item], is_first: impl Fn(&Item) -> bool) -> usize {
    let mut first = 0;
    for i in 0..items.len() {
        if is_first(&items[i]) {
            items.swap(first, i);
            first += 1;
        }
    }
    first
}

/// Lights of a bucket, with their orientation as the sum of their axes: its length tells how much they agree.
#[derive(Clone, Copy)]
struct Bucket {
    low: Vec3,
    high: Vec3,
    axes: Vec3,
    count: f32,
    intensity: f32,
    cos_reach: f32,
}

impl Bucket {
    const EMPTY: Self = Self {
        low: Vec3::MAX,
        high: Vec3::MIN,
        axes: Vec3::ZERO,
        count: 0.0,
        intensity: 0.0,
        cos_reach: 1.0,
    };

    fn of(emitter: &Emitter) -> Self {
        // The mean direction in a cone is so long, and that of two opposite ones vanishes.
        let length = match emitter.two_sided {
            false => 0.5 * (1.0 + emitter.cos_spread),
            true => 0.0,
        };
        Self {
            low: emitter.low,
            high: emitter.high,
            axes: emitter.axis * length,
            count: 1.0,
            intensity: emitter.intensity,
            cos_reach: emitter.cos_reach,
        }
    }

    fn union(&self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            axes: self.axes + other.axes,
            count: self.count + other.count,
            intensity: self.intensity + other.intensity,
            cos_reach: self.cos_reach.min(other.cos_reach),
        }
    }

    /// Intensity times surface times the solid angle lit (Conty Estevez and Kulla, section 4.4): how much a sample wastes
    /// by not knowing where in the node the light is.
    fn cost(&self) -> f32 {
        if self.count == 0.0 {
            return 0.0;
        }
        let size = self.high - self.low;
        // Lights along a line have no surface, but a place.
        let surface = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x)
            + 0.01 * size.length_squared();
        let cos_spread = (2.0 * self.axes.length() / self.count - 1.0).clamp(-1.0, 1.0);
        self.intensity * surface * lit_angle(cos_spread, self.cos_reach)
    }
}

/// The solid angle that a cone of normals lights, weighted by the cosine beyond the cone.
fn lit_angle(cos_spread: f32, cos_reach: f32) -> f32 {
    let spread = cos_spread.acos();
    let rim = (spread + cos_reach.clamp(-1.0, 1.0).acos()).min(PI);
    let sin_spread = (1.0 - cos_spread * cos_spread).max(0.0).sqrt();
    TAU * (1.0 - cos_spread)
        + FRAC_PI_2
            * (2.0 * rim * sin_spread - (spread - 2.0 * rim).cos() - 2.0 * spread * sin_spread
                + cos_spread)
}

/// The axis and the last bucket of the first group of the split that costs least; none if all lights are in one place.
fn cheapest(items: &[Item], low: Vec3, extent: Vec3) -> Option<(usize, usize)> {
    let buckets = bucket_count(items);
    let mut filled = [[Bucket::EMPTY; BUCKETS]; 3];
    for item in items {
        let one = Bucket::of(&item.emitter);
        for axis in 0..3 {
            if extent[axis] > 0.0 {
                let b = bucket(item.center[axis], low[axis], extent[axis], buckets);
                filled[axis][b] = filled[axis][b].union(&one);
            }
        }
    }
    let mut best = None;
    let mut least = f32::INFINITY;
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        let filled = &filled[axis][..buckets];
        let mut behind = [Bucket::EMPTY; BUCKETS];
        for i in (0..buckets - 1).rev() {
            behind[i] = behind[i + 1].union(&filled[i + 1]);
        }
        // Thin slices are avoided.
        let slenderness = extent.max_element() / extent[axis];
        let mut before = Bucket::EMPTY;
        for last in 0..buckets - 1 {
            before = before.union(&filled[last]);
            if filled[last].count == 0.0 || behind[last].count == 0.0 {
                continue;
            }
            let cost = slenderness * (before.cost() + behind[last].cost());
            // Costs that overflow are worth no less than the median.
            if cost < least {
                least = cost;
                best = Some((axis, last));
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [0, 1) without pattern.
    fn random(i: u32) -> f32 {
        let mut v = i.wrapping_mul(0x9e37_79b9).wrapping_add(0x7f4a_7c15);
        v = (v ^ (v >> 16)).wrapping_mul(0x7feb_352d);
        v = (v ^ (v >> 15)).wrapping_mul(0x846c_a68b);
        ((v ^ (v >> 16)) >> 8) as f32 / (1 << 24) as f32
    }

    fn scattered(count: u32, place: impl Fn(u32) -> Vec3) -> Vec<Emitter> {
        (0..count)
            .map(|i| {
                let axis = Vec3::new(random(4 * i) - 0.5, random(4 * i + 1) - 0.5, 0.3).normalize();
                let size = Vec3::splat(0.01);
                Emitter {
                    low: place(i) - size,
                    high: place(i) + size,
                    ..Emitter::triangle([Vec3::ZERO; 3], axis, 0.1 + random(4 * i + 2), i % 7 == 0)
                }
            })
            .collect()
    }

    /// Every light is in one leaf, relations hold, and a node bounds what is below it. Returns the depth.
    fn check(emitters: &[Emitter]) -> u32 {
        let numbered: Vec<_> = (0..).zip(emitters.iter().copied()).collect();
        let nodes = build(&numbered);
        assert_eq!(nodes.len(), 2 * emitters.len());
        let mut seen = vec![false; emitters.len()];
        let mut deepest = 0;
        let mut stack = vec![(0u32, 0u32)];
        while let Some((index, depth)) = stack.pop() {
            deepest = deepest.max(depth);
            let node = &nodes[index as usize];
            if let Some(light) = node.light() {
                assert!(!std::mem::replace(&mut seen[light as usize], true));
                continue;
            }
            let mut intensity = 0.0;
            for child in [node.child, node.child + 1] {
                assert_eq!(node.child % 2, 0);
                let below = &nodes[child as usize];
                assert_eq!(below.parent, index);
                assert!(below.low.cmpge(node.low).all() && below.high.cmple(node.high).all());
                assert!(below.two_sided <= node.two_sided && below.cos_reach >= node.cos_reach);
                let angle = |c: f32| c.clamp(-1.0, 1.0).acos();
                let turned = below
                    .axis
                    .cross(node.axis)
                    .length()
                    .atan2(below.axis.dot(node.axis));
                assert!(
                    node.cos_spread <= -1.0
                        || turned + angle(below.cos_spread) <= angle(node.cos_spread) + 2e-3
                );
                intensity += below.intensity;
                stack.push((child, depth + 1));
            }
            assert!((intensity - node.intensity).abs() <= 1e-5 * intensity);
        }
        assert!(seen.iter().all(|&s| s));
        deepest
    }

    #[test]
    fn every_light_has_a_leaf_below_nodes_that_bound_it() {
        for count in [1, 2, 3, 7, 1000, 20_000] {
            let cube = |i| Vec3::new(random(i), random(i + 77_777), random(i + 99_999)) * 10.0;
            let depth = check(&scattered(count, cube));
            assert!(depth < 40, "{count} lights, {depth} levels");
        }
    }

    #[test]
    fn no_arrangement_makes_the_tree_deep() {
        for place in [
            (|_| Vec3::ONE) as fn(u32) -> Vec3,
            |i| Vec3::X * i as f32,
            |i| Vec3::X * 1.1f32.powi((i % 800) as i32),
            |i| Vec3::new(random(i), 0.0, 1e-30 * random(i + 9)),
        ] {
            let depth = check(&scattered(20_000, place));
            assert!(depth < SAH_DEPTH + 20, "{depth} levels");
        }
    }

    /// Long, so it runs only where `PATINA_FULL` is set.
    #[test]
    fn a_million_lights_have_a_shallow_tree() {
        if std::env::var_os("PATINA_FULL").is_none() {
            return;
        }
        let cube = |i| Vec3::new(random(i), random(i + 777), random(i + 999)) * 10.0;
        assert!(check(&scattered(1_000_000, cube)) < 60);
        check(&scattered(1_000_000, |i| {
            Vec3::X * 1.1f32.powi((i % 800) as i32)
        }));
    }

    #[test]
    fn lights_of_any_strength_keep_their_share() {
        let mut lights = scattered(50, |i| Vec3::X * i as f32);
        lights[3].intensity = 1e30;
        lights[4].intensity = 1e-30;
        check(&lights);
    }

    #[test]
    fn cones_contain_what_they_are_made_of() {
        let (axis, cosine) = cone_union((Vec3::X, 1.0), (Vec3::Y, 1.0));
        assert!((axis - Vec3::new(0.5, 0.5, 0.0).normalize()).length() < 1e-5);
        assert!((cosine - 0.5f32.sqrt()).abs() < 1e-5);
        assert_eq!(cone_union((Vec3::X, 1.0), (Vec3::NEG_X, 1.0)).1, -1.0);
        assert_eq!(cone_union((Vec3::X, -1.0), (Vec3::Y, 0.5)), (Vec3::X, -1.0));
    }
}
