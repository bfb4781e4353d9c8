//! Where to split a set of references in two: the surface area heuristic over bins (Wald, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies", 2007), or over all places in small sets.

use rayon::prelude::*;
use wide::{f32x4, i32x4};

use super::super::bounds::{Bounds, Reference};

const MOST_BINS: usize = 32;
/// Sets up to this size are split at the best of all places.
const SMALL: usize = 8;
/// Sets above this size are looked at by several threads, in parts of this size.
const PARALLEL: usize = 1 << 16;

/// What is known of a set of references: the box around them, and that around their half centres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) bounds: Bounds,
    centres: Bounds,
}

impl Extent {
    const EMPTY: Self = Self {
        bounds: Bounds::EMPTY,
        centres: Bounds::EMPTY,
    };

    pub(super) fn of(references: &[Reference]) -> Self {
        references
            .par_chunks(PARALLEL)
            .map(|part| {
                let mut extent = Self::EMPTY;
                for reference in part {
                    extent.add(reference.bounds());
                }
                extent
            })
            .reduce(|| Self::EMPTY, Self::union)
    }

    #[inline(always)]
    fn add(&mut self, bounds: Bounds) {
        self.bounds = self.bounds.union(bounds);
        self.centres = self.centres.with(bounds.half_centre());
    }

    fn union(self, other: Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            centres: self.centres.union(other.centres),
        }
    }

    /// Adds a reference where the mask is set, all of it or nothing.
    #[inline(always)]
    fn add_where(&mut self, mask: f32x4, bounds: Bounds, centre: f32x4) {
        let or_empty = |low: f32x4, high: f32x4| Bounds {
            low: mask.bitselect(low, Bounds::EMPTY.low),
            high: mask.bitselect(high, Bounds::EMPTY.high),
        };
        self.bounds = self.bounds.union(or_empty(bounds.low, bounds.high));
        self.centres = self.centres.union(or_empty(centre, centre));
    }
}

/// By whether a reference is on the left side: lanes without bits, and with all.
const LEFT_MASKS: [f32x4; 2] = [
    f32x4::new([0.0; 4]),
    f32x4::new([f32::from_bits(u32::MAX); 4]),
];

/// Reorders at least two references so that those of the left side come first, and says how many they are. With
/// `is_balanced` the sides differ by at most one. `scale` is the unit of areas.
pub(super) fn split(
    references: &mut [Reference],
    extent: &Extent,
    scale: f32,
    is_balanced: bool,
) -> (usize, [Extent; 2]) {
    if !is_balanced {
        if references.len() <= SMALL {
            return split_small(references, scale);
        }
        let binning = Binning::new(extent, references.len());
        if let Some(place) = binning.best_place(references, scale) {
            return binning.partition(references, place);
        }
    }
    let middle = references.len() / 2;
    let axis = longest_axis(extent);
    // All in one place: any halves will do.
    let [low, high] = extent.centres.corners();
    if high[axis] > low[axis] {
        references.select_nth_unstable_by(middle, |a, b| {
            let centre = |r: &Reference| r.bounds().half_centre().to_array()[axis];
            centre(a)
                .total_cmp(&centre(b))
                .then(a.index().cmp(&b.index()))
        });
    }
    let (left, right) = references.split_at(middle);
    (middle, [Extent::of(left), Extent::of(right)])
}

fn longest_axis(extent: &Extent) -> usize {
    let [low, high] = extent.centres.corners();
    let length = |axis: usize| high[axis] - low[axis];
    (0..3)
        .max_by(|&a, &b| length(a).total_cmp(&length(b)))
        .unwrap_or(0)
}

/// Tries all places on all axes.
#[inline(never)]
fn split_small(references: &mut [Reference], scale: f32) -> (usize, [Extent; 2]) {
    let count = references.len();
    if count == 2 {
        // As half of all sets: nothing to choose.
        return (1, [0, 1].map(|i| small_extent(&references[i..=i])));
    }
    let mut centres = [[0.0; SMALL]; 3];
    for (i, reference) in references.iter().enumerate() {
        let [x, y, z, _] = reference.bounds().half_centre().to_array();
        (centres[0][i], centres[1][i], centres[2][i]) = (x, y, z);
    }
    let mut best: Option<(f32, usize, [u8; SMALL], usize)> = None;
    for centres in &centres {
        // Places in the order of their centres. Few: sorted by insertion.
        let mut order = [0u8; SMALL];
        for i in 0..count {
            let mut at = i;
            while at > 0 && centres[order[at - 1] as usize] > centres[i] {
                order[at] = order[at - 1];
                at -= 1;
            }
            order[at] = i as u8;
        }
        let mut right_cost = [0.0; SMALL];
        let mut side = Bounds::EMPTY;
        for i in (1..count).rev() {
            side = side.union(references[order[i] as usize].bounds());
            right_cost[i] = side.half_area(scale) * (count - i) as f32;
        }
        let mut side = Bounds::EMPTY;
        for left in 1..count {
            side = side.union(references[order[left - 1] as usize].bounds());
            let cost = side.half_area(scale) * left as f32 + right_cost[left];
            let imbalance = left.abs_diff(count - left);
            let is_better = best
                .as_ref()
                .is_none_or(|b| cost < b.0 || (cost == b.0 && imbalance < b.3));
            if is_better {
                best = Some((cost, left, order, imbalance));
            }
        }
    }
    let (left, order) = best.map_or((1, [0, 1, 2, 3, 4, 5, 6, 7]), |b| (b.1, b.2));
    let mut sorted = [references[0]; SMALL];
    for (to, &from) in sorted.iter_mut().zip(&order[..count]) {
        *to = references[from as usize];
    }
    references.copy_from_slice(&sorted[..count]);
    let (a, b) = references.split_at(left);
    (left, [a, b].map(small_extent))
}

fn small_extent(references: &[Reference]) -> Extent {
    let mut extent = Extent::EMPTY;
    for reference in references {
        extent.add(reference.bounds());
    }
    extent
}

/// Where centres fall among equal bins, on all axes at once.
struct Binning {
    base: f32x4,
    per_unit: f32x4,
    last: i32x4,
    count: usize,
}

/// A place between two bins.
#[derive(Clone, Copy)]
struct Place {
    axis: usize,
    first_right: i32,
}

#[derive(Clone)]
struct Bins {
    bounds: [[Bounds; MOST_BINS]; 3],
    counts: [[u32; MOST_BINS]; 3],
}

impl Binning {
    fn new(extent: &Extent, references: usize) -> Self {
        // Few references don't fill many bins.
        let count = (4 + references / 8).min(MOST_BINS);
        let [low, high] = extent.centres.corners();
        let per_unit = [0, 1, 2].map(|axis| {
            let per_unit = count as f32 * 0.99999 / (high[axis] - low[axis]);
            if per_unit.is_finite() { per_unit } else { 0.0 }
        });
        Self {
            base: f32x4::new([low[0], low[1], low[2], 0.0]),
            per_unit: f32x4::new([per_unit[0], per_unit[1], per_unit[2], 0.0]),
            last: i32x4::splat(count as i32 - 1),
            count,
        }
    }

    #[inline(always)]
    fn bins(&self, centre: f32x4) -> [i32; 4] {
        let place = ((centre - self.base) * self.per_unit).fast_trunc_int();
        place.min(self.last).to_array()
    }

    fn fill(&self, references: &[Reference]) -> Bins {
        let mut bins = Bins {
            bounds: [[Bounds::EMPTY; MOST_BINS]; 3],
            counts: [[0; MOST_BINS]; 3],
        };
        for reference in references {
            let bounds = reference.bounds();
            let [x, y, z, _] = self.bins(bounds.half_centre());
            for (axis, bin) in [x, y, z].into_iter().enumerate() {
                let bin = bin as usize & (MOST_BINS - 1);
                bins.bounds[axis][bin] = bins.bounds[axis][bin].union(bounds);
                bins.counts[axis][bin] += 1;
            }
        }
        bins
    }

    /// The place of least cost; `None` where all centres fall in one bin.
    fn best_place(&self, references: &[Reference], scale: f32) -> Option<Place> {
        let bins = if references.len() <= PARALLEL {
            self.fill(references)
        } else {
            references
                .par_chunks(PARALLEL)
                .map(|part| self.fill(part))
                .reduce_with(Bins::union)?
        };
        let total = references.len() as u32;
        let mut best: Option<(f32, u32, Place)> = None;
        for axis in 0..3 {
            let (bounds, counts) = (&bins.bounds[axis], &bins.counts[axis]);
            if counts[0] == total {
                continue; // no extent along this axis
            }
            let mut right_cost = [0.0; MOST_BINS];
            let (mut side, mut held) = (Bounds::EMPTY, 0);
            for i in (1..self.count).rev() {
                if counts[i] != 0 {
                    side = side.union(bounds[i]);
                    held += counts[i];
                }
                right_cost[i] = cost(side, held, scale);
            }
            let (mut side, mut held) = (Bounds::EMPTY, 0);
            for i in 1..self.count {
                if counts[i - 1] == 0 {
                    continue; // the same sides as at the place before
                }
                side = side.union(bounds[i - 1]);
                held += counts[i - 1];
                if held == total {
                    break;
                }
                let cost = cost(side, held, scale) + right_cost[i];
                // Equal costs are those of boxes without area: balance keeps them from becoming chains.
                let imbalance = held.abs_diff(total - held);
                if best.is_none_or(|b| cost < b.0 || (cost == b.0 && imbalance < b.1)) {
                    let first_right = i as i32;
                    best = Some((cost, imbalance, Place { axis, first_right }));
                }
            }
        }
        best.map(|(_, _, place)| place)
    }

    fn partition(&self, references: &mut [Reference], place: Place) -> (usize, [Extent; 2]) {
        let first_right = f32x4::splat(place.first_right as f32);
        let [mut left_extent, mut right_extent] = [Extent::EMPTY; 2];
        let mut left = 0;
        // Without branches: which side is next can't be foretold.
        for i in 0..references.len() {
            let bounds = references[i].bounds();
            let centre = bounds.half_centre();
            let sides = ((centre - self.base) * self.per_unit).simd_lt(first_right);
            let is_left = sides.to_bitmask() as usize >> place.axis & 1;
            let mask = LEFT_MASKS[is_left];
            left_extent.add_where(mask, bounds, centre);
            right_extent.add_where(!mask, bounds, centre);
            references.swap(left, i);
            left += is_left;
        }
        (left, [left_extent, right_extent])
    }
}

impl Bins {
    fn union(mut self, other: Self) -> Self {
        for axis in 0..3 {
            for i in 0..MOST_BINS {
                self.bounds[axis][i] = self.bounds[axis][i].union(other.bounds[axis][i]);
                self.counts[axis][i] += other.counts[axis][i];
            }
        }
        self
    }
}

/// Of a side, up to a factor: triangles are tested four at a time.
fn cost(bounds: Bounds, count: u32, scale: f32) -> f32 {
    if count == 0 {
        return 0.0;
    }
    bounds.half_area(scale) * count.div_ceil(4) as f32
}
