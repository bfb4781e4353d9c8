//! The bottom level: the triangles of a mesh.

use std::ops::{BitOr, ControlFlow, Range};

use glam::Vec3;
use rayon::prelude::*;

use super::{
    bounds::{Bounds, Reference},
    build::{BuildError, Hierarchy, Progress, Search},
    layout::{DEFERRED, FILTERED, INDEX, SINGLE_SIDED, TriangleBlock, WIDTH},
    refit,
};

/// What rays have to know of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flags(u32);

impl Flags {
    /// A triangle that stops every ray.
    pub const NONE: Self = Self(0);
    /// Rays that meet its back pass through. The back is where its corners turn clockwise.
    pub const SINGLE_SIDED: Self = Self(SINGLE_SIDED);
    /// The filter of the ray is asked whether a hit counts.
    pub const FILTERED: Self = Self(FILTERED);
    /// To an any-hit ray, a hit doesn't end the search and is reported only if it is the closest, so that the caller can
    /// judge it and start again behind it, with `t_min` the hit's `t`.
    pub const DEFERRED: Self = Self(DEFERRED);
}

impl BitOr for Flags {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// The triangles of a mesh, ready for rays.
#[derive(Debug)]
pub struct Mesh {
    pub(super) level: Hierarchy<TriangleBlock>,
}

impl Mesh {
    /// Builds the hierarchy over `triangles`, each of three indices of `positions`; a hit names a triangle by its place in
    /// `triangles`, and `flags` is asked by it. Runs on all threads of the current rayon pool.
    ///
    /// What no ray can hit is left out: triangles with a corner that isn't finite or isn't there, or with two corners in
    /// one place. There may be nothing left.
    ///
    /// `progress` is called now and then, by any of the threads, with the share of the work that is done, in [0, 1]; what
    /// it is given needn't be in order. It ends the build by [`ControlFlow::Break`].
    ///
    /// # Errors
    /// If `progress` ends the build, if there are more than 2^29 triangles, or if there is no memory for the hierarchy.
    pub fn build(
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        flags: impl Fn(usize) -> Flags + Sync,
        progress: &(dyn Fn(f32) -> ControlFlow<()> + Sync),
    ) -> Result<Self, BuildError> {
        let most = INDEX as usize + 1;
        if triangles.len() > most {
            let count = triangles.len();
            return Err(BuildError::TooMany { count, most });
        }
        let corners = |triangle: [u32; 3]| -> Option<[[f32; 3]; 3]> {
            let [a, b, c] = triangle;
            Some([
                positions.get(a as usize)?.to_array(),
                positions.get(b as usize)?.to_array(),
                positions.get(c as usize)?.to_array(),
            ])
        };
        let mut references: Vec<Reference> = Vec::new();
        (references.try_reserve_exact(triangles.len()))
            .map_err(|_| BuildError::no_room::<Reference>(triangles.len()))?;
        triangles
            .par_iter()
            .enumerate()
            .map(|(index, &triangle)| {
                let [a, b, c] = corners(triangle)?;
                let has_area = a != b && b != c && c != a;
                has_area.then(|| Reference::around(index as u32, &[a, b, c]))?
            })
            .map(|reference| reference.unwrap_or(Reference::NONE))
            .collect_into_vec(&mut references);
        references.retain(|reference| !reference.is_none());
        let progress = Progress::new(references.len(), progress);
        let block = |indices: &[u32]| {
            let mut block = TriangleBlock::EMPTY;
            for (lane, &index) in indices.iter().enumerate() {
                if let Some(corners) = corners(triangles[index as usize]) {
                    block.set(lane, corners, index | flags(index as usize).0);
                }
            }
            block
        };
        let level = Hierarchy::build(references, WIDTH, &progress, block, search)?;
        Ok(Self { level })
    }

    /// The same hierarchy around the same `triangles` with their corners elsewhere: a twentieth of the time that building one takes.
    /// `None` where its boxes would overlap so much more than they do now that rays would pay for it, or where there is no memory for it.
    ///
    /// Triangles that were left out stay so; none of the others may have a corner that isn't finite or isn't there.
    pub fn refit(&self, positions: &[Vec3], triangles: &[[u32; 3]]) -> Option<Self> {
        let corners = |triangle: usize| -> Option<[[f32; 3]; 3]> {
            let [a, b, c] = *triangles.get(triangle)?;
            Some([
                positions.get(a as usize)?.to_array(),
                positions.get(b as usize)?.to_array(),
                positions.get(c as usize)?.to_array(),
            ])
        };
        let level = refit::around(&self.level, corners)?;
        Some(Self { level })
    }

    /// Some of its triangles by themselves, numbered from the first of them. Those that were left out stay so.
    pub fn part(&self, triangles: Range<u32>) -> Self {
        let mut found = Vec::new();
        for block in self.level.leaves.iter() {
            for (lane, &word) in block.words.iter().enumerate() {
                let corner = |at: usize| [0, 1, 2].map(|axis| block.corners[at][axis][lane]);
                let corners = [0, 1, 2].map(corner);
                // Lanes without a triangle are named after the first.
                let is_there = corners[0] != corners[1];
                if is_there && triangles.contains(&(word & INDEX)) {
                    found.push((word, corners));
                }
            }
        }
        // So that the hierarchy doesn't depend on the other triangles.
        found.sort_unstable_by_key(|(word, _)| word & INDEX);
        let references = found.iter().enumerate();
        let references: Vec<_> = references
            .filter_map(|(at, (_, corners))| Reference::around(at as u32, corners))
            .collect();
        let endless = |_| ControlFlow::Continue(());
        let progress = Progress::new(references.len(), &endless);
        let block = |indices: &[u32]| {
            let mut block = TriangleBlock::EMPTY;
            for (lane, &index) in indices.iter().enumerate() {
                let (word, corners) = found[index as usize];
                let own = (word & INDEX) - triangles.start;
                block.set(lane, corners, own | (word & !INDEX));
            }
            block
        };
        let level = Hierarchy::build(references, WIDTH, &progress, block, search);
        let level = level.expect("nobody cancels");
        Self { level }
    }

    /// Corners of the box around its triangles, or `None` if there are none.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let is_there = !self.level.nodes.is_empty();
        is_there.then(|| self.level.bounds.corners().map(Vec3::from))
    }

    /// Levels of nodes, at most [`MAX_DEPTH`](super::MAX_DEPTH).
    pub fn depth(&self) -> usize {
        self.level.depth
    }

    /// Bytes of memory that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.level.nodes[..]) + size_of_val(&self.level.leaves[..])
    }
}

/// What an any-hit ray has to expect of a block of triangles in its box: a convex body is met by lines that meet the box as
/// its surface is to the box's, and both sides of a triangle are its surface. Triangles that are deferred end no search.
fn search(block: &TriangleBlock, bounds: Bounds) -> Search {
    let scale = bounds.unit_scale();
    let mut area = 0.0;
    for (lane, word) in block.words.iter().enumerate() {
        let corner =
            |at: usize| Vec3::from([0, 1, 2].map(|axis| block.corners[at][axis][lane])) * scale;
        if word & DEFERRED == 0 {
            area += 0.5
                * (corner(1) - corner(0))
                    .cross(corner(2) - corner(0))
                    .length();
        }
    }
    // A box without area is met by no line; what isn't a number doesn't count in the minimum.
    Search::in_leaf((area / bounds.half_area(scale)).min(1.0))
}
