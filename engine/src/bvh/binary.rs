//! Binary hierarchies by parallel locally-ordered clustering (Meister and Bittner, "Parallel Locally-Ordered Clustering
//! for Bounding Volume Hierarchy Construction", TVCG 2018): boxes in Morton order are joined with the best of their
//! neighbours, round by round. Only the tree's shape is meant to be used: its boxes are scaled.
//!
//! Boxes that coincide or lie in one another all prefer the same neighbour, and a round joins next to none. Such a
//! round joins each box with the next one instead, so that the number of rounds, and with it the tree's depth, grows
//! with the logarithm of the number of boxes.

use std::ops::Range;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

use super::bounds::Bounds;
use crate::morton;

/// How many neighbours on each side are considered, after the first rounds.
const DISTANCE: usize = 14;
/// Rounds that look at the nearest neighbours alone, which is enough while nearly all of them are good.
const QUICK_ROUNDS: usize = 3;
/// A round has to join one of so many.
const LEAST_PROGRESS: usize = 16;
/// Boxes that are worth a thread of their own.
const CHUNK: usize = 2048;
/// The longest side of the scaled scene is between half of this and this: areas of boxes 2^-103 as long don't vanish,
/// and sums of areas don't overflow.
const SCALED_LOG2: i32 = 40;

/// A node, and a leaf if `first` is a primitive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) bounds: Bounds,
    /// The first of two children, which are neighbours, or the primitive.
    pub(super) first: u32,
    pub(super) is_leaf: bool,
}

/// A tree with one primitive a leaf.
#[derive(Debug)]
pub(super) struct Tree {
    /// The root first, siblings side by side: the first of them has an odd index.
    pub(super) nodes: Vec<Node>,
}

impl Tree {
    /// Joins boxes, of which there must be at least one.
    pub(super) fn build(boxes: &[Bounds]) -> Self {
        let mut current = in_morton_order(&scaled(boxes));
        let unset = current[0];
        let mut nodes = vec![unset; 2 * boxes.len() - 1];
        let mut free = nodes.len();
        let mut next = Vec::with_capacity(current.len());
        let mut best = vec![0u32; current.len()];
        let mut round = 0;
        while current.len() > 1 {
            let best = &mut best[..current.len()];
            let distance = if round < QUICK_ROUNDS { 1 } else { DISTANCE };
            find_best(&current, distance, best);
            let agree = |best: &[u32], i: usize| best[best[i] as usize] as usize == i;
            let agreeing = (0..best.len()).filter(|&i| agree(best, i)).count();
            if agreeing / 2 * LEAST_PROGRESS < best.len() {
                pair_neighbours(best);
            }
            for (i, node) in current.iter().enumerate() {
                let other = best[i] as usize;
                if other == i || !agree(best, i) {
                    next.push(*node);
                } else if i < other {
                    free -= 2;
                    nodes[free] = *node;
                    nodes[free + 1] = current[other];
                    next.push(Node {
                        bounds: node.bounds.union(&current[other].bounds),
                        first: free as u32,
                        is_leaf: false,
                    });
                }
            }
            std::mem::swap(&mut current, &mut next);
            next.clear();
            round += 1;
        }
        nodes[0] = current[0];
        Self { nodes }
    }

    /// All nodes, parents before their children.
    pub(super) fn parents_first(&self) -> Vec<u32> {
        let mut order = Vec::with_capacity(self.nodes.len());
        order.push(0);
        let mut next = 0;
        while next < order.len() {
            let node = &self.nodes[order[next] as usize];
            if !node.is_leaf {
                order.extend([node.first, node.first + 1]);
            }
            next += 1;
        }
        order
    }
}

/// The other child of a node's parent.
pub(super) fn sibling(node: usize) -> usize {
    if node % 2 == 1 { node + 1 } else { node - 1 }
}

/// Boxes about the origin in a unit in which neither areas nor sums of areas leave the range of single precision.
fn scaled(boxes: &[Bounds]) -> Vec<Bounds> {
    let total = boxes.iter().fold(Bounds::EMPTY, |a, b| a.union(b));
    let size = total.size().max_element();
    let scale = match size > 0.0 {
        true => f64::powi(2.0, SCALED_LOG2 - size.log2().ceil() as i32),
        false => 1.0,
    };
    let center = 0.5 * (total.low.as_dvec3() + total.high.as_dvec3());
    let place = |p: Vec3A| ((p.as_dvec3() - center) * scale).as_vec3a();
    (boxes.iter())
        .map(|b| Bounds {
            low: place(b.low),
            high: place(b.high),
        })
        .collect()
}

/// Leaves in the order of their centres along a Morton curve; where these are the same, small boxes first.
fn in_morton_order(boxes: &[Bounds]) -> Vec<Node> {
    let total = boxes.iter().fold(Bounds::EMPTY, |a, b| a.union(b));
    let size = total.size();
    let cells = DVec3::splat(f64::from((1u32 << 21) - 1));
    let scale = DVec3::select(size.cmpgt(DVec3::ZERO), cells / size, DVec3::ZERO);
    let key = |(index, b): (usize, &Bounds)| {
        let cell = (b.center().as_dvec3() - total.low.as_dvec3()) * scale;
        (
            morton::code(cell.as_uvec3()),
            b.half_area().to_bits(),
            index as u32,
        )
    };
    let mut keys: Vec<(u64, u32, u32)> = boxes.iter().enumerate().map(key).collect();
    if keys.len() > CHUNK {
        keys.par_sort_unstable();
    } else {
        keys.sort_unstable();
    }
    (keys.iter())
        .map(|&(_, _, index)| Node {
            bounds: boxes[index as usize],
            first: index,
            is_leaf: true,
        })
        .collect()
}

/// For each node the one with which its box grows least, among those at most `distance` away.
fn find_best(nodes: &[Node], distance: usize, best: &mut [u32]) {
    if nodes.len() <= CHUNK {
        find_best_of(nodes, distance, 0..nodes.len(), best);
        return;
    }
    (best.par_chunks_mut(CHUNK).enumerate()).for_each(|(chunk, best)| {
        let start = chunk * CHUNK;
        find_best_of(nodes, distance, start..start + best.len(), best);
    });
}

fn find_best_of(nodes: &[Node], distance: usize, range: Range<usize>, best: &mut [u32]) {
    let mut least = [f32::INFINITY; CHUNK];
    // A pair's cost is for both of them; those before the range are for its first ones.
    for i in range.start.saturating_sub(distance)..range.end {
        let last = (i + distance).min(nodes.len() - 1);
        for j in i + 1..=last {
            let cost = nodes[i].bounds.union(&nodes[j].bounds).half_area();
            for (a, b) in [(i, j), (j, i)] {
                if range.contains(&a) && cost <= least[a - range.start] {
                    least[a - range.start] = cost;
                    best[a - range.start] = b as u32;
                }
            }
        }
    }
}

/// Each with the next one; the last may be left alone.
fn pair_neighbours(best: &mut [u32]) {
    let last = best.len() - 1;
    for (i, other) in best.iter_mut().enumerate() {
        *other = (i ^ 1).min(last) as u32;
    }
}
