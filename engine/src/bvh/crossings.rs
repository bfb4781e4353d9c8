//! A hierarchy that is asked on the processor for all that a ray passes, not for what it meets first.

use glam::Vec3A;

use super::{
    binary::{Node, Tree},
    bounds::Bounds,
};

/// By so much of a distance the sides of boxes count as farther away: rounding must not hide what touches them.
const SLACK: f32 = 1e-5;
/// No component of a direction counts as less, so that distances to sides are numbers.
const LEAST: f32 = 1e-30;

/// Boxes that lie in each other.
#[derive(Debug)]
pub(crate) struct Crossings {
    nodes: Vec<Node>,
    /// Of each node; those that the tree was built by are scaled.
    bounds: Vec<Bounds>,
}

impl Crossings {
    /// Over boxes, of which there must be at least one.
    pub(crate) fn over(boxes: &[Bounds]) -> Self {
        let boxes: Vec<Bounds> = boxes.iter().map(Bounds::within_reach).collect();
        let nodes = Tree::build(&boxes).nodes;
        let mut bounds = vec![Bounds::EMPTY; nodes.len()];
        // Children lie behind their parents.
        for (i, node) in nodes.iter().enumerate().rev() {
            let first = node.first as usize;
            bounds[i] = match node.is_leaf {
                true => boxes[first],
                false => bounds[first].union(&bounds[first + 1]),
            };
        }
        Self { nodes, bounds }
    }

    /// Gives `met` the number of each box that a ray touches.
    pub(crate) fn visit(&self, origin: Vec3A, direction: Vec3A, mut met: impl FnMut(u32)) {
        let least = Vec3A::splat(LEAST).copysign(direction);
        let direction = Vec3A::select(direction.abs().cmplt(least.abs()), least, direction);
        let over = direction.recip();
        let mut open = vec![0];
        while let Some(at) = open.pop() {
            let Bounds { low, high } = self.bounds[at];
            let (a, b) = ((low - origin) * over, (high - origin) * over);
            let enters = a.min(b).max_element().max(0.0);
            let leaves = a.max(b).min_element();
            if enters > leaves * (1.0 + SLACK) {
                continue;
            }
            let node = &self.nodes[at];
            match node.is_leaf {
                true => met(node.first),
                false => open.extend([node.first as usize, node.first as usize + 1]),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_boxes_on_the_way_are_met_and_few_others() {
        // A lattice of flat boxes, as triangles along the axes have them.
        let corner = |i: u32| Vec3A::new((i % 16) as f32, (i / 16 % 16) as f32, (i / 256) as f32);
        let size = Vec3A::new(0.5, 0.0, 0.5);
        let boxes: Vec<Bounds> = (0..4096)
            .map(|i| Bounds::around([corner(i), corner(i) + size]))
            .collect();
        let crossings = Crossings::over(&boxes);
        let met = |origin: Vec3A, direction: Vec3A| {
            let mut all = Vec::new();
            crossings.visit(origin, direction, |number| all.push(number));
            all.sort_unstable();
            all
        };
        // Along y, through the middle of one of each layer that lies above.
        let above: Vec<u32> = (0..4096)
            .filter(|i| (i % 16, i / 256) == (3, 5) && i / 16 % 16 >= 2)
            .collect();
        assert_eq!(met(Vec3A::new(3.2, 1.5, 5.2), Vec3A::Y), above);
        assert!(met(Vec3A::new(3.7, 1.5, 5.2), Vec3A::Y).is_empty());
        // Askew: the same as one after the other.
        let (origin, direction) = (Vec3A::new(-1.0, 0.3, 0.7), Vec3A::new(1.0, 0.81, 0.63));
        let is_met = |i: &u32| {
            let b = &boxes[*i as usize];
            let t = (b.low.y - origin.y) / direction.y;
            let p = origin + direction * t;
            t >= 0.0 && (b.low.x..=b.high.x).contains(&p.x) && (b.low.z..=b.high.z).contains(&p.z)
        };
        let expected: Vec<u32> = (0..4096).filter(is_met).collect();
        assert!(!expected.is_empty());
        assert_eq!(met(origin, direction), expected);
    }
}
