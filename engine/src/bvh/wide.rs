//! Eight-wide compressed hierarchies (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", HPG 2017): a binary tree is collapsed to the nodes of least cost by dynamic programming, and
//! the boxes of a node's children are rounded outwards to a grid of 256 steps along each side of the node.
//!
//! Two things are not in the paper. A node costs something however small it is, lest places without area become
//! chains of nodes. And a tree has no more levels than the traversal's stack can hold: a subtree that would need more
//! is dealt out evenly, in the order of its primitives.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3A};

use super::{binary::Tree, bounds::Bounds, reinsertion::improve};

/// Children of a node.
const WIDTH: usize = 8;
/// Triangles or instances of a leaf.
const LEAF_SIZE: usize = 3;
/// Cost of a primitive, where that of a node of the same size is 1.
const PRIMITIVE_COST: f32 = 0.3;
/// What any node costs in addition, as a share of the root.
const LEAST_COST: f32 = 1e-7;
/// Shortest side of a node's grid, metres: its reciprocal must not overflow.
const SHORTEST: f64 = 1e-20;
/// By how many steps a child's sides are moved outwards before they are rounded: four times what the kernel's single
/// precision may get wrong about a plane, which it reaches by up to 255 steps from the grid's least corner.
const MARGIN: f64 = 255.0 / (1 << 21) as f64;

/// A node as the kernel reads it: five `vec4u`.
#[repr(C)]
#[derive(Debug, Default, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct WideNode {
    /// Least corner of the grid.
    pub(super) origin: [f32; 3],
    /// Steps of the grid, as the exponent bits of a number.
    pub(super) exponents: [u8; 3],
    /// Which slots are nodes.
    pub(super) inner: u8,
    /// The first child that is a node; the others follow in the order of their slots.
    pub(super) first_child: u32,
    /// The first primitive of the leaves.
    pub(super) first_primitive: u32,
    /// Of each slot: 0 if it is empty; for a node, 0b001 and 24 + the slot; for a leaf, the number of its primitives in
    /// unary, and the place of the first of them after `first_primitive` in the lowest five bits.
    pub(super) meta: [u8; WIDTH],
    /// Least and greatest steps of each slot, by axis.
    pub(super) planes: [[[u8; WIDTH]; 2]; 3],
}

/// A hierarchy on its own; children and primitives count from 0.
#[derive(Debug)]
pub(super) struct WideBvh {
    /// The root first.
    pub(super) nodes: Vec<WideNode>,
    /// The box at each place of the leaves' order.
    pub(super) primitives: Vec<u32>,
    /// Around all boxes, as far as they are within reach.
    pub(super) bounds: Bounds,
}

impl WideBvh {
    /// A hierarchy over boxes, at most `levels` nodes deep.
    pub(super) fn build(boxes: impl IntoIterator<Item = Bounds>, levels: u32) -> Self {
        let boxes: Vec<Bounds> = boxes.into_iter().map(|b| b.within_reach()).collect();
        let mut result = Self {
            nodes: Vec::new(),
            primitives: Vec::with_capacity(boxes.len()),
            bounds: Bounds::EMPTY,
        };
        if boxes.is_empty() {
            return result;
        }
        let mut tree = Tree::build(&boxes);
        improve(&mut tree);
        let collapse = Collapse::new(tree, &boxes);
        result.bounds = collapse.bounds[0];
        result.nodes.push(WideNode::default());
        let mut waiting = vec![(0, Part::Subtree(0), levels)];
        while let Some((index, part, levels)) = waiting.pop() {
            let mut node = WideNode::new(&collapse.bounds_of(&part));
            node.first_child = result.nodes.len() as u32;
            node.first_primitive = result.primitives.len() as u32;
            let slots = in_slots(collapse.children(part, levels));
            for (slot, child) in slots.into_iter().enumerate() {
                let Some(child) = child else { continue };
                let primitives = result.primitives.len() as u32 - node.first_primitive;
                node.set_bounds(slot, &child.bounds);
                node.meta[slot] = match child.content {
                    Content::Node(part) => {
                        waiting.push((result.nodes.len(), part, levels - 1));
                        result.nodes.push(WideNode::default());
                        node.inner |= 1 << slot;
                        0b001 << 5 | (24 + slot as u8)
                    }
                    Content::Leaf {
                        primitives: leaf,
                        count,
                    } => {
                        result.primitives.extend(&leaf[..count]);
                        ((1 << count) - 1) << 5 | primitives as u8
                    }
                };
            }
            result.nodes[index] = node;
        }
        result
    }
}

/// What a node is made of.
enum Part {
    /// A node of the binary tree and what is below it.
    Subtree(u32),
    /// Primitives to be dealt out evenly.
    Evenly(Vec<u32>),
}

struct Child {
    bounds: Bounds,
    content: Content,
}

enum Content {
    Node(Part),
    Leaf {
        primitives: [u32; LEAF_SIZE],
        count: usize,
    },
}

impl Content {
    fn leaf(of: &[u32]) -> Self {
        let mut primitives = [0; LEAF_SIZE];
        primitives[..of.len()].copy_from_slice(of);
        Self::Leaf {
            primitives,
            count: of.len(),
        }
    }
}

/// The cheapest way to make wide nodes of a binary node and what is below it.
#[derive(Clone, Copy)]
struct Choice {
    /// As at most so many roots, less one.
    cost: [f32; WIDTH],
    /// How many of them the first child gets; 0: it is best to have one root fewer.
    split: [u8; WIDTH],
    primitives: u32,
    /// As one root, it is a leaf.
    is_leaf: bool,
}

/// A binary tree and how it is best collapsed.
struct Collapse<'a> {
    boxes: &'a [Bounds],
    tree: Tree,
    choices: Vec<Choice>,
    /// Of the tree's nodes, in metres.
    bounds: Vec<Bounds>,
}

impl<'a> Collapse<'a> {
    fn new(tree: Tree, boxes: &'a [Bounds]) -> Self {
        // The tree's boxes are scaled so that 1 is tiny.
        let least = tree.nodes[0].bounds.half_area() * LEAST_COST + 1.0;
        let none = Choice {
            cost: [f32::INFINITY; WIDTH],
            split: [0; WIDTH],
            primitives: 1,
            is_leaf: true,
        };
        let mut choices = vec![none; tree.nodes.len()];
        let mut bounds = vec![Bounds::EMPTY; tree.nodes.len()];
        for &index in tree.parents_first().iter().rev() {
            let (index, node) = (index as usize, &tree.nodes[index as usize]);
            let area = node.bounds.half_area() + least;
            let first = node.first as usize;
            if node.is_leaf {
                bounds[index] = boxes[first];
                choices[index].cost = [area * PRIMITIVE_COST; WIDTH];
            } else {
                bounds[index] = bounds[first].union(&bounds[first + 1]);
                choices[index] = Choice::of(area, &choices[first], &choices[first + 1]);
            }
        }
        Self {
            boxes,
            tree,
            choices,
            bounds,
        }
    }

    fn bounds_of(&self, part: &Part) -> Bounds {
        match part {
            Part::Subtree(node) => self.bounds[*node as usize],
            Part::Evenly(primitives) => self.bounds_of_primitives(primitives),
        }
    }

    fn bounds_of_primitives(&self, primitives: &[u32]) -> Bounds {
        (primitives.iter())
            .map(|&p| self.boxes[p as usize])
            .fold(Bounds::EMPTY, |a, b| a.union(&b))
    }

    /// The children of a node below which, itself counted, there may be `levels` of nodes.
    fn children(&self, part: Part, levels: u32) -> Vec<Child> {
        match part {
            Part::Subtree(node) => {
                // What is left over for the children must hold all but one of the primitives.
                let most = (WIDTH as u64).saturating_pow(levels - 1);
                if u64::from(self.choices[node as usize].primitives) <= most {
                    self.cheapest(node)
                } else {
                    self.evenly(&self.primitives(node))
                }
            }
            Part::Evenly(primitives) => self.evenly(&primitives),
        }
    }

    fn cheapest(&self, node: u32) -> Vec<Child> {
        let mut children = Vec::with_capacity(WIDTH);
        // Forests that are still to be opened, and the number of their roots.
        let mut forests = vec![(node, WIDTH)];
        let opened = |node: u32| self.tree.nodes[node as usize].first;
        let choice = |node: u32| &self.choices[node as usize];
        if !choice(node).is_leaf {
            let split = usize::from(choice(node).split[0]);
            forests = vec![(opened(node) + 1, WIDTH - split), (opened(node), split)];
        }
        while let Some((node, mut roots)) = forests.pop() {
            while roots > 1 && choice(node).split[roots - 1] == 0 {
                roots -= 1;
            }
            if roots > 1 {
                let split = usize::from(choice(node).split[roots - 1]);
                forests.extend([(opened(node) + 1, roots - split), (opened(node), split)]);
                continue;
            }
            children.push(Child {
                bounds: self.bounds[node as usize],
                content: match choice(node).is_leaf {
                    true => Content::leaf(&self.primitives(node)),
                    false => Content::Node(Part::Subtree(node)),
                },
            });
        }
        children
    }

    fn evenly(&self, primitives: &[u32]) -> Vec<Child> {
        let child = |primitives: &[u32]| Child {
            bounds: self.bounds_of_primitives(primitives),
            content: match primitives.len() {
                ..=LEAF_SIZE => Content::leaf(primitives),
                _ => Content::Node(Part::Evenly(primitives.to_vec())),
            },
        };
        (primitives.chunks(primitives.len().div_ceil(WIDTH)))
            .map(child)
            .collect()
    }

    /// The primitives below a node, neighbours beside one another.
    fn primitives(&self, node: u32) -> Vec<u32> {
        let mut primitives = Vec::with_capacity(self.choices[node as usize].primitives as usize);
        let mut waiting = vec![node];
        while let Some(node) = waiting.pop() {
            let node = &self.tree.nodes[node as usize];
            match node.is_leaf {
                true => primitives.push(node.first),
                false => waiting.extend([node.first + 1, node.first]),
            }
        }
        primitives
    }
}

impl Choice {
    fn of(area: f32, left: &Self, right: &Self) -> Self {
        // So many roots in all, at least one on each side.
        let best = |roots: usize| {
            (1..roots)
                .map(|split| (left.cost[split - 1] + right.cost[roots - split - 1], split))
                .fold((f32::INFINITY, 1), |a, b| if b.0 < a.0 { b } else { a })
        };
        let primitives = left.primitives + right.primitives;
        let (below, split) = best(WIDTH);
        let as_node = below + area;
        let as_leaf = match primitives as usize {
            ..=LEAF_SIZE => area * primitives as f32 * PRIMITIVE_COST,
            _ => f32::INFINITY,
        };
        let mut choice = Self {
            cost: [as_node.min(as_leaf); WIDTH],
            split: [0; WIDTH],
            primitives,
            is_leaf: as_leaf < as_node,
        };
        choice.split[0] = split as u8;
        for roots in 2..WIDTH {
            let (cost, split) = best(roots);
            choice.cost[roots - 1] = choice.cost[roots - 2].min(cost);
            if cost < choice.cost[roots - 2] {
                choice.split[roots - 1] = split as u8;
            }
        }
        choice.cost[WIDTH - 1] = choice.cost[WIDTH - 2];
        choice
    }
}

/// Children in the slots where rays of most directions come across them in order of distance: a slot's bits are the
/// octant, seen from the node's middle, in which a child should lie. Greedily, the child that gains most comes first.
fn in_slots(children: Vec<Child>) -> [Option<Child>; WIDTH] {
    let all = children
        .iter()
        .fold(Bounds::EMPTY, |a, b| a.union(&b.bounds));
    let offsets: Vec<Vec3A> = (children.iter())
        .map(|child| child.bounds.center() - all.center())
        .collect();
    let direction = |slot: usize| {
        let side = |bit: usize| if slot & bit == 0 { 1.0 } else { -1.0 };
        Vec3A::new(side(4), side(2), side(1))
    };
    let mut costs = [[0.0; WIDTH]; WIDTH];
    for (costs, offset) in costs.iter_mut().zip(&offsets) {
        for (slot, cost) in costs.iter_mut().enumerate() {
            *cost = direction(slot).dot(*offset);
        }
    }
    let mut slots = [const { None }; WIDTH];
    let mut left: Vec<Option<Child>> = children.into_iter().map(Some).collect();
    for _ in 0..left.len() {
        let mut best = (f32::INFINITY, 0, 0);
        for (child, costs) in costs.iter().enumerate().take(left.len()) {
            for (slot, &cost) in costs.iter().enumerate() {
                if left[child].is_some() && slots[slot].is_none() && cost < best.0 {
                    best = (cost, child, slot);
                }
            }
        }
        slots[best.2] = left[best.1].take();
    }
    slots
}

impl WideNode {
    /// A node without children whose grid reaches around a box.
    fn new(bounds: &Bounds) -> Self {
        let exponent = |size: f64| {
            let steps = f64::from(u8::MAX) - MARGIN;
            let mut exponent = (size.max(SHORTEST) / steps).log2().ceil() as i32;
            while steps * f64::powi(2.0, exponent) < size {
                exponent += 1;
            }
            (exponent + 127) as u8
        };
        Self {
            origin: bounds.low.to_array(),
            exponents: bounds.size().to_array().map(exponent),
            ..Self::default()
        }
    }

    /// Rounds a child's box outwards to the grid. Its least corner itself is exact.
    fn set_bounds(&mut self, slot: usize, bounds: &Bounds) {
        let origin = DVec3::from_array(self.origin.map(f64::from));
        let step = self.step();
        let least = ((bounds.low.as_dvec3() - origin) / step - MARGIN).floor();
        let greatest = ((bounds.high.as_dvec3() - origin) / step + MARGIN).ceil();
        for axis in 0..3 {
            // A negative number becomes 0.
            self.planes[axis][0][slot] = least[axis] as u8;
            self.planes[axis][1][slot] = greatest[axis] as u8;
        }
    }

    fn step(&self) -> DVec3 {
        let step = |exponent: u8| f64::from(f32::from_bits(u32::from(exponent) << 23));
        DVec3::from_array(self.exponents.map(step))
    }

    /// The box of a slot, as the grid has it.
    #[cfg(test)]
    pub(super) fn bounds(&self, slot: usize) -> [DVec3; 2] {
        let origin = DVec3::from_array(self.origin.map(f64::from));
        let steps = |side: usize| DVec3::from_array(self.planes.map(|p| f64::from(p[side][slot])));
        [
            origin + steps(0) * self.step(),
            origin + steps(1) * self.step(),
        ]
    }
}
