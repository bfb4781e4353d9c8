//! The order of a node's children. Rays that look for the closest hit sort them by distance and don't mind. To those that
//! look for any hit it doesn't matter where it is: they take children as they come, so first come those where a hit is
//! likely for what it costs to look for it (Ize and Hansen, "RTSAH Traversal Order for Occlusion Rays", Computer Graphics
//! Forum 30(2), 2011).

use super::{
    super::{
        bounds::Bounds,
        layout::{EMPTY, LEAF, Node},
    },
    binary::LEAF_COST,
};

/// What to expect of an any-hit ray that has met a box and goes on inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in super::super) struct Search {
    /// How likely there is a hit.
    pub(in super::super) chance: f32,
    /// What it costs to find one, or that there is none, in nodes.
    pub(in super::super) cost: f32,
}

impl Search {
    /// Of a block of triangles, or of what a leaf of the upper level holds.
    pub(in super::super) fn in_leaf(chance: f32) -> Self {
        Self {
            chance,
            cost: LEAF_COST,
        }
    }
}

/// Puts the children of each node in order, and says what to expect of the first node. A node stands behind the one above it.
/// `elsewhere` is asked about children that are leaves, or that `nodes` doesn't reach to, with their boxes.
pub(super) fn sort_children(
    nodes: &mut [Node],
    elsewhere: impl Fn(u32, Bounds) -> Search,
) -> Search {
    let mut known = vec![Search::in_leaf(0.0); nodes.len()];
    for place in (0..nodes.len()).rev() {
        let node = &nodes[place];
        let mut children = [(0, Bounds::EMPTY, Search::in_leaf(0.0)); 8];
        let (mut count, mut whole) = (0, Bounds::EMPTY);
        for (lane, &child) in node.children.iter().enumerate() {
            if child == EMPTY {
                continue;
            }
            let bounds = node.bounds_of(lane);
            let search = match known.get(child as usize) {
                Some(&search) if child & LEAF == 0 => search,
                _ => elsewhere(child, bounds),
            };
            children[count] = (child, bounds, search);
            (count, whole) = (count + 1, whole.union(bounds));
        }
        let children = &mut children[..count];
        // The least expected cost of all orders: what is exchanged in any other one gains.
        let gain = |search: &Search| search.chance / search.cost;
        children.sort_by(|(_, _, a), (_, _, b)| gain(b).total_cmp(&gain(a)));
        let scale = whole.unit_scale();
        let whole = whole.half_area(scale);
        let (mut free, mut cost) = (1.0, 1.0);
        let mut sorted = Node::EMPTY;
        for (lane, &(child, bounds, search)) in children.iter().enumerate() {
            sorted.put(lane, bounds, child);
            // Of the lines through a box, those through a box inside are as their surfaces.
            let share = (bounds.half_area(scale) / whole).min(1.0);
            cost += free * share * search.cost;
            free *= 1.0 - share * search.chance;
        }
        nodes[place] = sorted;
        known[place] = Search {
            chance: 1.0 - free,
            cost,
        };
    }
    known.first().copied().unwrap_or(Search::in_leaf(0.0))
}

#[cfg(test)]
mod tests {
    use wide::f32x4;

    use super::*;

    fn cube(low: f32, size: f32) -> Bounds {
        Bounds {
            low: f32x4::splat(low),
            high: f32x4::splat(low + size),
        }
    }

    #[test]
    fn children_with_likely_hits_come_first() {
        let mut nodes = [Node::EMPTY; 2];
        // Two leaves, the second of which is nearly full, and a node with one more that is full, but dearer to reach.
        nodes[0].set(0, cube(0.0, 1.0), LEAF);
        nodes[0].set(3, cube(1.0, 1.0), LEAF | 1);
        nodes[0].set(5, cube(2.0, 1.0), 1);
        nodes[1].set(7, cube(2.0, 1.0), LEAF | 2);
        let chances = [0.25, 0.75, 1.0];
        let search = sort_children(&mut nodes, |leaf, _| {
            Search::in_leaf(chances[(leaf & !LEAF) as usize])
        });
        assert_eq!(nodes[0].children[..4], [LEAF | 1, 1, LEAF, EMPTY]);
        assert_eq!(nodes[1].children[..2], [LEAF | 2, EMPTY]);
        // Each is a ninth of the surface around all three.
        let free = (1.0 - 0.75 / 9.0) * (1.0 - 1.0 / 9.0) * (1.0 - 0.25 / 9.0);
        assert!(
            (search.chance - (1.0 - free)).abs() < 1e-4,
            "{search:?}, {free}"
        );
    }

    #[test]
    fn boxes_without_area_and_at_the_end_of_floats_are_sorted() {
        let mut nodes = [Node::EMPTY];
        nodes[0].set(0, cube(-3e38, 1e-20), LEAF);
        nodes[0].set(1, cube(3e38, 1e-20), LEAF | 1);
        nodes[0].set(2, cube(0.0, 0.0), LEAF | 2);
        let search = sort_children(&mut nodes, |_, _| Search::in_leaf(1.0));
        assert!(nodes[0].children[2] != EMPTY && nodes[0].children[3] == EMPTY);
        assert!((0.0..=1.0).contains(&search.chance), "{search:?}");
    }
}
