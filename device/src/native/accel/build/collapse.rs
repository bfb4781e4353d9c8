//! Joins the nodes of the binary tree to nodes of eight children, as its choices say.

use std::ops::Range;

use bytemuck::Pod;
use rayon::prelude::*;

use super::{
    super::{
        super::memory::Values,
        bounds::Bounds,
        layout::{EMPTY, LEAF, Node},
    },
    BuildError, Hierarchy,
    binary::Tree,
    order::{Search, sort_children},
};

/// Subtrees of up to this many nodes of the binary tree are joined by one thread.
const TASK: usize = 1 << 16;

/// A subtree whose root is to become a node; its place in the node above it; its level.
type Waiting = (Range<usize>, Option<(usize, usize)>, usize);

/// A part of the hierarchy: its nodes and leaves are numbered from 0.
struct Part<L> {
    nodes: Vec<Node>,
    leaves: Vec<L>,
    depth: usize,
    /// Of its root, if nothing is left to others.
    search: Search,
    /// What is left to others: subtree, the node and lane that it is for, and its level.
    rest: Vec<(Range<usize>, (usize, usize), usize)>,
}

/// Joins the whole tree; `leaf` makes what a leaf holds, and `search` says what to expect of that.
///
/// # Errors
/// There is no memory for it.
pub(super) fn collapse<L: Pod + Send + Sync>(
    tree: &Tree,
    leaf: &(impl Fn(&[u32]) -> L + Sync),
    search: &(impl Fn(&L, Bounds) -> Search + Sync),
) -> Result<Hierarchy<L>, BuildError> {
    let whole = 0..tree.nodes.len();
    let Part {
        mut nodes,
        leaves,
        mut depth,
        rest,
        search: mut of_root,
    } = part(tree, whole, TASK, leaf, search);
    let parts: Vec<Part<L>> = rest
        .par_iter()
        .map(|(subtree, _, _)| part(tree, subtree.clone(), 0, leaf, search))
        .collect();
    // All parts behind the first, each where it is to be, by all threads.
    let (first_nodes, first_leaves) = (nodes.len(), leaves.len());
    let of_parts = |length: fn(&Part<L>) -> usize| parts.iter().map(length).sum::<usize>();
    let mut all_nodes: Values<Node> = zeroed(first_nodes + of_parts(|part| part.nodes.len()))?;
    let mut all_leaves: Values<L> = zeroed(first_leaves + of_parts(|part| part.leaves.len()))?;
    let (mut next_node, mut next_leaf) = (first_nodes, first_leaves);
    let (head_of_nodes, mut rest_of_nodes) = all_nodes.split_at_mut(first_nodes);
    let (head_of_leaves, mut rest_of_leaves) = all_leaves.split_at_mut(first_leaves);
    let mut copies = Vec::with_capacity(parts.len());
    let mut roots = Vec::with_capacity(parts.len());
    for (part, (_, (parent, lane), level)) in parts.into_iter().zip(rest) {
        nodes[parent].children[lane] = next_node as u32;
        depth = depth.max(level + part.depth);
        let firsts = [next_node as u32, next_leaf as u32];
        roots.push((next_node as u32, part.search));
        next_node += part.nodes.len();
        next_leaf += part.leaves.len();
        let (own_nodes, others) = rest_of_nodes.split_at_mut(part.nodes.len());
        rest_of_nodes = others;
        let (own_leaves, others) = rest_of_leaves.split_at_mut(part.leaves.len());
        rest_of_leaves = others;
        copies.push((part, own_nodes, own_leaves, firsts));
    }
    if !roots.is_empty() {
        of_root = sort_children(&mut nodes, |child, bounds| match child & LEAF {
            0 => {
                let found = roots.binary_search_by_key(&child, |&(root, _)| root);
                roots[found.expect("all other nodes are roots of parts")].1
            }
            _ => search(&leaves[(child & !LEAF) as usize], bounds),
        });
    }
    head_of_nodes.copy_from_slice(&nodes);
    head_of_leaves.copy_from_slice(&leaves);
    copies
        .into_par_iter()
        .for_each(|(part, nodes, leaves, [first_node, first_leaf])| {
            for (to, mut node) in nodes.iter_mut().zip(part.nodes) {
                for child in &mut node.children {
                    if *child != EMPTY {
                        *child += if *child & LEAF == 0 {
                            first_node
                        } else {
                            first_leaf
                        };
                    }
                }
                *to = node;
            }
            leaves.copy_from_slice(&part.leaves);
        });
    Ok(Hierarchy {
        nodes: all_nodes,
        leaves: all_leaves,
        bounds: tree.nodes[0].bounds(),
        depth,
        search: of_root,
    })
}

fn zeroed<T: Pod>(length: usize) -> Result<Values<T>, BuildError> {
    Values::zeroed(length).ok_or_else(|| BuildError::no_room::<T>(length))
}

/// Joins the subtree that lies in `subtree`, but leaves those of up to `task` nodes to others.
fn part<L>(
    tree: &Tree,
    subtree: Range<usize>,
    task: usize,
    leaf: &impl Fn(&[u32]) -> L,
    search: &impl Fn(&L, Bounds) -> Search,
) -> Part<L> {
    let mut part = Part {
        nodes: vec![],
        leaves: vec![],
        depth: 0,
        search: Search::in_leaf(0.0),
        rest: vec![],
    };
    let mut references = vec![];
    let mut children: Vec<Range<usize>> = vec![];
    // Depth first, so that a node's first inner child follows it.
    let mut waiting: Vec<Waiting> = vec![(subtree, None, 1)];
    while let Some((subtree, parent, level)) = waiting.pop() {
        let index = part.nodes.len();
        if let Some((parent, lane)) = parent {
            part.nodes[parent].children[lane] = index as u32;
        }
        part.depth = part.depth.max(level);
        children.clear();
        open(tree, subtree, &mut children);
        let mut node = Node::EMPTY;
        for (lane, child) in children.iter().enumerate().rev() {
            let root = &tree.nodes[child.start];
            node.set(lane, root.bounds(), EMPTY);
            if root.choice().is_leaf() {
                references.clear();
                let leaves = tree.nodes[child.clone()].iter().enumerate();
                references.extend(
                    leaves
                        .filter(|(_, n)| n.choice().is_single())
                        .map(|(_, n)| n.right),
                );
                node.children[lane] = LEAF | part.leaves.len() as u32;
                part.leaves.push(leaf(&references));
            } else if child.len() <= task {
                part.rest.push((child.clone(), (index, lane), level));
            } else {
                waiting.push((child.clone(), Some((index, lane)), level + 1));
            }
        }
        part.nodes.push(node);
    }
    // Else the roots of others aren't known yet.
    if part.rest.is_empty() {
        let leaves = &part.leaves;
        part.search = sort_children(&mut part.nodes, |leaf, bounds| {
            search(&leaves[(leaf & !LEAF) as usize], bounds)
        });
    }
    part
}

/// The subtrees that become the children of a subtree's root: forests are opened until each is one root.
fn open(tree: &Tree, subtree: Range<usize>, children: &mut Vec<Range<usize>>) {
    let root = &tree.nodes[subtree.start];
    if root.choice().is_leaf() {
        children.push(subtree); // a tree of one leaf
        return;
    }
    let halves = |subtree: &Range<usize>| {
        let right = tree.nodes[subtree.start].right as usize;
        (subtree.start + 1..right, right..subtree.end)
    };
    let (left, right) = halves(&subtree);
    let to_left = root.choice().left(1);
    let mut forests = vec![(right, 8 - to_left), (left, to_left)];
    while let Some((subtree, mut roots)) = forests.pop() {
        let choice = tree.nodes[subtree.start].choice();
        while roots > 1 && choice.left(roots) == 0 {
            roots -= 1;
        }
        if roots == 1 {
            children.push(subtree);
        } else {
            let (left, right) = halves(&subtree);
            let to_left = choice.left(roots);
            forests.extend([(right, roots - to_left), (left, to_left)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hierarchy_that_has_no_room_is_an_error() {
        let refused = zeroed::<Node>(1 << 54).err();
        assert_eq!(refused, Some(BuildError::NoRoom { bytes: 1 << 62 }));
        let said = refused.map(|error| error.to_string()).unwrap_or_default();
        assert!(said.contains("take a smaller scene"), "{said}");
    }
}
