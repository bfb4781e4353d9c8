//! The binary tree, and for each of its nodes how it is best joined to nodes of eight children.
//!
//! The tree lies in one array in pre-order: a node's left child follows it, and a subtree of n leaves takes 2n - 1 nodes.
//! So both sides of a split know their part of the array beforehand and are built by two threads, with the same result as
//! by one.
//!
//! How nodes are joined is found bottom-up by dynamic programming (Ylitie, Karras and Laine, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, section 3.1).

use bytemuck::Zeroable;

use super::{
    super::bounds::{Bounds, Reference},
    MAX_DEPTH,
    progress::{BuildError, Progress},
    split::{Extent, split},
};

/// Cost of a block of triangles where that of a node is 1.
pub(super) const LEAF_COST: f32 = 0.8;
/// What any node costs at least, in shares of the root: without it, boxes without area would become chains.
const LEAST_AREA: f32 = 1e-7;
/// Subtrees of up to this many references are built by one thread.
const TASK: usize = 1 << 12;

/// Most roots that a subtree has in the node above it.
const ROOTS: usize = 7;
/// Costs of a subtree with at most 1, 2, ... roots.
type Costs = [f32; ROOTS];

/// A node of the binary tree.
#[derive(Debug, Clone, Copy, Zeroable)]
#[repr(C)]
pub(super) struct BinaryNode {
    low: [f32; 3],
    /// The right child's place, or of a leaf the index of what it refers to.
    pub(super) right: u32,
    high: [f32; 3],
    choice: Choice,
}

impl BinaryNode {
    pub(super) fn bounds(&self) -> Bounds {
        let [low, high] = [self.low, self.high].map(|[x, y, z]| wide::f32x4::new([x, y, z, 0.0]));
        Bounds { low, high }
    }

    pub(super) fn choice(&self) -> Choice {
        self.choice
    }
}

/// How a subtree is best joined. Three bits for each number of roots, one to seven: how many of them the left child gets,
/// or 0 where it is best as with one root less; for one root, how many of its node's eight children. Then whether it is a
/// leaf where it has one root.
#[derive(Debug, Clone, Copy, Zeroable)]
#[repr(transparent)]
pub(super) struct Choice(u32);

impl Choice {
    const LEAF: u32 = 1 << 31;
    const SINGLE: u32 = 1 << 30;

    pub(super) fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// Whether this is a leaf of the binary tree.
    pub(super) fn is_single(self) -> bool {
        self.0 & Self::SINGLE != 0
    }

    /// Of `roots`, those of the left child.
    pub(super) fn left(self, roots: usize) -> usize {
        (self.0 >> (3 * (roots - 1))) as usize & 7
    }
}

/// The binary tree over a set of references.
pub(super) struct Tree {
    pub(super) nodes: Vec<BinaryNode>,
}

/// What a subtree is built of, and where its nodes go: `nodes`, which lie from `first` on in the whole array.
struct Side<'a> {
    references: &'a mut [Reference],
    extent: &'a Extent,
    nodes: &'a mut [BinaryNode],
    first: usize,
}

/// What all subtrees share.
struct Context<'a> {
    scale: f32,
    least_area: f32,
    most: usize,
    progress: &'a Progress<'a>,
}

impl Tree {
    /// Over at least one reference, which it reorders. Leaves of the joined tree may hold `most`.
    pub(super) fn build(
        references: &mut [Reference],
        most: usize,
        progress: &Progress<'_>,
    ) -> Result<Self, BuildError> {
        let extent = Extent::of(references);
        let scale = extent.bounds.unit_scale();
        let context = Context {
            scale,
            least_area: extent.bounds.half_area(scale) * LEAST_AREA,
            most,
            progress,
        };
        // Pages of zeros, which the threads that write to them find.
        let count = 2 * references.len() - 1;
        let nodes = bytemuck::try_zeroed_vec::<BinaryNode>(count);
        let mut nodes = nodes.map_err(|()| BuildError::no_room::<BinaryNode>(count))?;
        // A constant above the depth of a balanced tree, so that no input takes more than n log n steps.
        let levels = (2 * ceil_log2(references.len()) + 16).min(MAX_DEPTH);
        let mut whole = Side {
            references,
            extent: &extent,
            nodes: &mut nodes,
            first: 0,
        };
        context.build_reporting(&mut whole, levels);
        if progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        Ok(Self { nodes })
    }
}

impl Context<'_> {
    /// As `build`, and tells of small subtrees that they are done: larger ones have told of each split.
    fn build_reporting(&self, side: &mut Side<'_>, levels: usize) -> Costs {
        let costs = self.build(side, levels);
        if side.references.len() <= TASK {
            self.progress.finish(side.references.len());
        }
        costs
    }

    /// Builds a subtree of at most `levels` levels below its root.
    fn build(&self, side: &mut Side<'_>, levels: usize) -> Costs {
        let Side {
            references,
            extent,
            nodes,
            first,
        } = side;
        let (node, below) = nodes
            .split_first_mut()
            .expect("2n - 1 nodes for n > 0 references");
        let area = extent.bounds.half_area(self.scale) + self.least_area;
        [node.low, node.high] = extent.bounds.corners();
        let count = references.len();
        if let [reference] = &**references {
            node.right = reference.index();
            node.choice = Choice(Choice::LEAF | Choice::SINGLE);
            return [area * LEAF_COST; ROOTS];
        }
        // From here on only halves fit into the levels that are left.
        let is_balanced = ceil_log2(count) >= levels;
        let (left, [left_extent, right_extent]) =
            split(references, extent, self.scale, is_balanced);
        let (left_references, right_references) = references.split_at_mut(left);
        let (left_nodes, right_nodes) = below.split_at_mut(2 * left - 1);
        let right_first = *first + 2 * left;
        node.right = right_first as u32;

        let mut left = Side {
            references: left_references,
            extent: &left_extent,
            nodes: left_nodes,
            first: *first + 1,
        };
        let mut right = Side {
            references: right_references,
            extent: &right_extent,
            nodes: right_nodes,
            first: right_first,
        };
        let (left_costs, right_costs) = if count <= TASK {
            (
                self.build(&mut left, levels - 1),
                self.build(&mut right, levels - 1),
            )
        } else {
            self.progress
                .split(left.references.len(), right.references.len());
            if self.progress.is_cancelled() {
                return [0.0; ROOTS];
            }
            rayon::join(
                || self.build_reporting(&mut left, levels - 1),
                || self.build_reporting(&mut right, levels - 1),
            )
        };
        let (choice, costs) = self.join(area, count, &left_costs, &right_costs);
        node.choice = choice;
        costs
    }

    /// How two subtrees are best joined.
    fn join(&self, area: f32, count: usize, left: &Costs, right: &Costs) -> (Choice, Costs) {
        // Least cost of `roots` roots below this node.
        let best = |roots: usize| {
            let mut best = (f32::INFINITY, 1);
            for k in 1.max(roots.saturating_sub(ROOTS))..=(roots - 1).min(ROOTS) {
                let cost = left[k - 1] + right[roots - k - 1];
                if cost < best.0 {
                    best = (cost, k as u32);
                }
            }
            best
        };
        let (below, k) = best(ROOTS + 1);
        let mut costs = [below + area; ROOTS];
        let mut choice = k;
        if count <= self.most && area * LEAF_COST <= costs[0] {
            costs[0] = area * LEAF_COST;
            choice |= Choice::LEAF;
        }
        for roots in 2..=ROOTS {
            let (cost, k) = best(roots);
            if cost <= costs[roots - 2] {
                costs[roots - 1] = cost;
                choice |= k << (3 * (roots - 1));
            } else {
                costs[roots - 1] = costs[roots - 2];
            }
        }
        (Choice(choice), costs)
    }
}

fn ceil_log2(count: usize) -> usize {
    count.next_power_of_two().trailing_zeros() as usize
}
