//! A hierarchy whose triangles have moved: the same tree with other boxes.

use rayon::prelude::*;
use wide::f32x4;

use super::{
    bounds::Bounds,
    build::Hierarchy,
    layout::{EMPTY, INDEX, LEAF, Node, TriangleBlock, WIDTH},
};

/// How many times as large the boxes may become, beside the one around them. Of a grid that was bent, twisted and torn, rays took 4 %
/// longer at 1.9 and 8 % at 3.7 than through a hierarchy of its own; of one that was dealt out anew it is 3,000.
const LOOSEST: f64 = 4.0;

/// `level` around triangles whose corners are elsewhere; `corners` gives them by the triangle's index. `None` where it has become
/// much looser, or a corner isn't there, or no memory for it.
pub(super) fn around(
    level: &Hierarchy<TriangleBlock>,
    corners: impl Fn(usize) -> Option<[[f32; 3]; 3]> + Sync,
) -> Option<Hierarchy<TriangleBlock>> {
    let mut leaves = level.leaves.copied()?;
    leaves
        .par_iter_mut()
        .try_for_each(|block| move_block(block, &corners))?;
    let mut nodes = level.nodes.copied()?;
    let mut bounds = vec![Bounds::EMPTY; nodes.len()];
    // A node stands behind the one above it.
    for place in (0..nodes.len()).rev() {
        let node = &mut nodes[place];
        for lane in 0..node.children.len() {
            let child = node.children[lane];
            if child == EMPTY {
                continue;
            }
            let inner = match child & LEAF {
                0 => bounds[child as usize],
                _ => around_block(&leaves[(child & !LEAF) as usize]),
            };
            node.set(lane, inner, child);
            bounds[place] = bounds[place].union(inner);
        }
    }
    let whole = *bounds.first()?;
    let is_tight = looseness(&nodes, whole) <= LOOSEST * looseness(&level.nodes, level.bounds);
    is_tight.then_some(Hierarchy {
        nodes,
        leaves,
        bounds: whole,
        depth: level.depth,
        search: level.search,
    })
}

/// Whether there is a triangle in a lane: none that is there has two corners in one place where the hierarchy was built.
fn is_used(block: &TriangleBlock, lane: usize) -> bool {
    (0..3).any(|axis| block.corners[0][axis][lane] != block.corners[1][axis][lane])
}

fn move_block(
    block: &mut TriangleBlock,
    corners: &impl Fn(usize) -> Option<[[f32; 3]; 3]>,
) -> Option<()> {
    for lane in 0..WIDTH {
        if is_used(block, lane) {
            let word = block.words[lane];
            let corners = corners((word & INDEX) as usize)?;
            if !corners.as_flattened().iter().all(|x| x.is_finite()) {
                return None;
            }
            // One that has lost its area would be taken for none.
            if corners[0] == corners[1] {
                return None;
            }
            block.set(lane, corners, word);
        }
    }
    Some(())
}

fn around_block(block: &TriangleBlock) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for lane in (0..WIDTH).filter(|&lane| is_used(block, lane)) {
        for corner in &block.corners {
            let [x, y, z] = [0, 1, 2].map(|axis| corner[axis][lane] + 0.0);
            bounds = bounds.with(f32x4::new([x, y, z, 0.0]));
        }
    }
    bounds
}

/// The surface of all boxes over that of the one around them: what a ray through it meets on average.
fn looseness(nodes: &[Node], whole: Bounds) -> f64 {
    let scale = whole.unit_scale();
    let of = |node: &Node| -> f64 {
        let lanes = (0..node.children.len()).filter(|&lane| node.children[lane] != EMPTY);
        lanes
            .map(|lane| {
                let side = |axis: usize| {
                    let [low, high] = node.bounds[axis].map(|side| f64::from(side[lane] * scale));
                    high - low
                };
                let [x, y, z] = [0, 1, 2].map(side);
                x * y + y * z + z * x
            })
            .sum()
    };
    nodes.iter().map(of).sum::<f64>() / f64::from(whole.half_area(scale))
}
