//! The data that traversal reads.

use bytemuck::{Pod, Zeroable};

use super::bounds::Bounds;

/// Triangles in a block.
pub(super) const WIDTH: usize = 4;
/// In a child: it is a leaf, and the rest is the index of a block of triangles or of an instance.
pub(super) const LEAF: u32 = 1 << 31;
/// A child that is not there.
pub(super) const EMPTY: u32 = u32::MAX;

/// In a triangle's word: its back lets rays through.
pub(super) const SINGLE_SIDED: u32 = 1 << 31;
/// In a triangle's word: the ray's filter is asked whether a hit counts.
pub(super) const FILTERED: u32 = 1 << 30;
/// In a triangle's word: to an any-hit ray, a hit counts only if it is the closest.
pub(super) const DEFERRED: u32 = 1 << 29;
/// A triangle's word without flags.
pub(super) const INDEX: u32 = DEFERRED - 1;

/// Eight boxes in four cache lines.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Per axis, the least and the greatest coordinate of each child. Of a child that is not there, they are inside out.
    pub(super) bounds: [[[f32; 8]; 2]; 3],
    /// Index of a node, `LEAF` and the index of what the leaf holds, or `EMPTY`.
    pub(super) children: [u32; 8],
    pub(super) unused: [u32; 8],
}

impl Node {
    pub(super) const EMPTY: Self = Self {
        bounds: [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3],
        children: [EMPTY; 8],
        unused: [0; 8],
    };

    /// Puts a child into a lane. Its box becomes an ulp larger, for rays in the plane of a side.
    pub(super) fn set(&mut self, lane: usize, bounds: Bounds, child: u32) {
        let [low, high] = bounds.corners();
        for axis in 0..3 {
            self.bounds[axis][0][lane] = low[axis] - low[axis].abs() * f32::EPSILON;
            self.bounds[axis][1][lane] = high[axis] + high[axis].abs() * f32::EPSILON;
        }
        self.children[lane] = child;
    }

    /// The box of a child.
    pub(super) fn bounds_of(&self, lane: usize) -> Bounds {
        let corner = |side: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| self.bounds[axis][side][lane]);
            wide::f32x4::new([x, y, z, 0.0])
        };
        Bounds {
            low: corner(0),
            high: corner(1),
        }
    }

    /// Puts a child of another node into a lane.
    pub(super) fn put(&mut self, lane: usize, bounds: Bounds, child: u32) {
        let [low, high] = bounds.corners();
        for axis in 0..3 {
            self.bounds[axis][0][lane] = low[axis];
            self.bounds[axis][1][lane] = high[axis];
        }
        self.children[lane] = child;
    }
}

/// Triangles of a leaf, side by side.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(32))]
pub(super) struct TriangleBlock {
    /// Coordinates by corner and axis.
    pub(super) corners: [[[f32; WIDTH]; 3]; 3],
    /// Index and flags. Lanes without a triangle have their corners in one place, and so no hit.
    pub(super) words: [u32; WIDTH],
}

impl TriangleBlock {
    pub(super) const EMPTY: Self = Self {
        corners: [[[0.0; WIDTH]; 3]; 3],
        words: [0; WIDTH],
    };

    /// Puts a triangle into a lane; `word` is its index with its flags.
    pub(super) fn set(&mut self, lane: usize, corners: [[f32; 3]; 3], word: u32) {
        for (to, from) in self.corners.iter_mut().zip(corners) {
            for (row, coordinate) in to.iter_mut().zip(from) {
                row[lane] = coordinate;
            }
        }
        self.words[lane] = word;
    }
}
