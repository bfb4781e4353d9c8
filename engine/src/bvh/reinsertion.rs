//! Moves subtrees of a binary hierarchy to where they enlarge the boxes above them less (Meister and Bittner, "Parallel
//! Reinsertion for Bounding Volume Hierarchy Optimization", Computer Graphics Forum 37(2), 2018).
//!
//! A search ends after a fixed number of nodes: where boxes overlap, each of them would else look at all others.

use rayon::prelude::*;

use super::binary::{Node, Tree, sibling};

/// Passes, of which each looks at fewer nodes, further up in the tree.
const PASSES: usize = 16;
/// Share of the nodes that the first pass tries to move.
const SHARE: f32 = 0.05;
/// Nodes that one search may look at.
const MOST_VISITS: usize = 4096;
/// Searches that are worth a thread of their own.
const CHUNK: usize = 64;

/// A subtree's better place: beside `to`.
#[derive(Debug, Clone, Copy)]
struct Move {
    from: u32,
    to: u32,
    /// By how much the areas of all boxes become less.
    gain: f32,
}

/// Improves the tree; its boxes stay the unions of what is in them.
pub(super) fn improve(tree: &mut Tree) {
    let count = tree.nodes.len();
    if count < 5 {
        return;
    }
    let mut parents = parents(tree);
    let mut touched = vec![false; count];
    for pass in 0..PASSES {
        let share = SHARE / (2 * pass + 1) as f32;
        let batch = ((count as f32 * share) as usize).clamp(1, count - 1);
        let candidates = candidates(tree, batch);
        let search = |stack: &mut Vec<(f32, u32)>, &from: &u32| {
            find_move(tree, &parents, from as usize, stack)
        };
        let mut moves: Vec<Move> = if candidates.len() < CHUNK {
            let mut stack = Vec::new();
            (candidates.iter())
                .filter_map(|from| search(&mut stack, from))
                .collect()
        } else {
            (candidates.par_iter().with_min_len(CHUNK))
                .map_init(Vec::new, search)
                .flatten()
                .collect()
        };
        moves.sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.from.cmp(&b.from)));
        let mut marked = Vec::with_capacity(5 * moves.len());
        for m in moves {
            let (from, to) = (m.from as usize, m.to as usize);
            let involved = [
                from,
                to,
                sibling(from),
                parents[from] as usize,
                parents[to] as usize,
            ];
            // Earlier moves may have changed what this one counted on, and may even have brought `to` below `from`.
            if involved.iter().any(|&node| touched[node]) || is_below(&parents, to, from) {
                continue;
            }
            for node in involved {
                touched[node] = true;
                marked.push(node);
            }
            apply(tree, &mut parents, from, to);
        }
        for node in marked {
            touched[node] = false;
        }
    }
}

fn parents(tree: &Tree) -> Vec<u32> {
    let mut parents = vec![0; tree.nodes.len()];
    for (i, node) in tree.nodes.iter().enumerate() {
        if !node.is_leaf {
            parents[node.first as usize] = i as u32;
            parents[node.first as usize + 1] = i as u32;
        }
    }
    parents
}

/// The largest of the first nodes: those near the root come first in the array, or once did.
fn candidates(tree: &Tree, batch: usize) -> Vec<u32> {
    let area = |node: u32| tree.nodes[node as usize].bounds.half_area();
    let mut candidates: Vec<(f32, u32)> = (1..tree.nodes.len().min(2 * batch + 2) as u32)
        .map(|node| (area(node), node))
        .collect();
    let larger = |a: &(f32, u32), b: &(f32, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
    if batch < candidates.len() {
        candidates.select_nth_unstable_by(batch, larger);
        candidates.truncate(batch);
    }
    candidates.into_iter().map(|(_, node)| node).collect()
}

/// The place for a node that lessens areas most, if there is a better one than its own.
///
/// With the node, its parent goes too; its sibling takes that one's place, and all boxes above shrink to what is left.
/// `freed` is by how much, up to the ancestor from which the search goes down again into other subtrees. There each
/// box on the way grows by the node.
fn find_move(
    tree: &Tree,
    parents: &[u32],
    from: usize,
    stack: &mut Vec<(f32, u32)>,
) -> Option<Move> {
    let nodes = &tree.nodes;
    let bounds = nodes[from].bounds;
    let area = bounds.half_area();
    let parent = parents[from] as usize;
    let mut freed = nodes[parent].bounds.half_area();
    let mut beside = sibling(from);
    let mut left = nodes[beside].bounds;
    let mut pivot = parent;
    let (mut gain, mut to) = (0.0, None);
    let mut visits = 0;
    stack.clear();
    loop {
        stack.push((freed, beside as u32));
        while let Some((freed, node)) = stack.pop() {
            visits += 1;
            if freed - area <= gain || visits > MOST_VISITS {
                continue;
            }
            let below = &nodes[node as usize];
            let rest = freed - below.bounds.union(&bounds).half_area();
            if rest > gain {
                gain = rest;
                to = Some(node);
            }
            if !below.is_leaf {
                let rest = rest + below.bounds.half_area();
                stack.extend([(rest, below.first), (rest, below.first + 1)]);
            }
        }
        if pivot != parent {
            left = left.union(&nodes[beside].bounds);
            freed += nodes[pivot].bounds.half_area() - left.half_area();
        }
        if pivot == 0 || visits > MOST_VISITS {
            break;
        }
        beside = sibling(pivot);
        pivot = parents[pivot] as usize;
    }
    let to = to?;
    let is_there_already = to as usize == sibling(from) || to as usize == parent;
    (!is_there_already).then_some(Move {
        from: from as u32,
        to,
        gain,
    })
}

fn is_below(parents: &[u32], mut node: usize, ancestor: usize) -> bool {
    while node != 0 && node != ancestor {
        node = parents[node] as usize;
    }
    node == ancestor
}

/// Puts `from` beside `to`: the pair's slots become the children of `to`, whose content moves into the sibling's slot,
/// and that one's content into the parent's.
fn apply(tree: &mut Tree, parents: &mut [u32], from: usize, to: usize) {
    let (beside, parent) = (sibling(from), parents[from] as usize);
    let (moved, left) = (tree.nodes[to], tree.nodes[beside]);
    tree.nodes[to] = Node {
        bounds: moved.bounds.union(&tree.nodes[from].bounds),
        first: from.min(beside) as u32,
        is_leaf: false,
    };
    tree.nodes[beside] = moved;
    tree.nodes[parent] = left;
    for (node, place) in [(moved, beside), (left, parent)] {
        if !node.is_leaf {
            parents[node.first as usize] = place as u32;
            parents[node.first as usize + 1] = place as u32;
        }
    }
    parents[beside] = to as u32;
    parents[from] = to as u32;
    refit_above(tree, parents, to);
    refit_above(tree, parents, parent);
}

fn refit_above(tree: &mut Tree, parents: &[u32], mut node: usize) {
    while node != 0 {
        node = parents[node] as usize;
        let first = tree.nodes[node].first as usize;
        let bounds = tree.nodes[first]
            .bounds
            .union(&tree.nodes[first + 1].bounds);
        if bounds == tree.nodes[node].bounds {
            return;
        }
        tree.nodes[node].bounds = bounds;
    }
}
