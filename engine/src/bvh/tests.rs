//! Hierarchies over boxes as nasty as files can hold.

use glam::{Affine3A, DVec3, Vec3, Vec3A};

use super::{
    LEVELS,
    bounds::Bounds,
    instance_bounds,
    wide::{WideBvh, WideNode},
};
use crate::scene::Instance;

/// Random numbers by xorshift (Marsaglia 2003).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) as u32
    }

    /// In [0, 1).
    fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }

    fn vector(&mut self, mut component: impl FnMut(&mut Self) -> f32) -> Vec3A {
        Vec3A::from_array([(); 3].map(|()| component(self)))
    }
}

/// Checks that the tree holds every box once, in each node above it, and is no deeper than it may be.
fn check(boxes: &[Bounds], levels: u32) {
    let bvh = WideBvh::build(boxes.iter().copied(), levels);
    let mut found = vec![false; boxes.len()];
    let mut reached = vec![false; bvh.nodes.len()];
    let everywhere = [DVec3::NEG_INFINITY, DVec3::INFINITY];
    let mut waiting = vec![(0u32, 1, everywhere)];
    while let Some((index, level, within)) = waiting.pop() {
        assert!(!std::mem::replace(&mut reached[index as usize], true));
        assert!(level <= levels, "deeper than {levels} levels");
        let node = &bvh.nodes[index as usize];
        for (slot, child, leaf) in slots(node) {
            let [low, high] = node.bounds(slot);
            let within = [within[0].max(low), within[1].min(high)];
            if let Some(child) = child {
                waiting.push((child, level + 1, within));
            }
            for place in leaf {
                let primitive = bvh.primitives[place as usize] as usize;
                assert!(!std::mem::replace(&mut found[primitive], true));
                let inner = boxes[primitive].within_reach();
                let (low, high) = (inner.low.as_dvec3(), inner.high.as_dvec3());
                assert!(
                    low.cmpge(within[0]).all() && high.cmple(within[1]).all(),
                    "{inner:?} leaves {within:?}"
                );
            }
        }
    }
    assert!(found.iter().all(|&found| found), "a primitive is missing");
    assert!(reached.iter().all(|&reached| reached), "a node is lost");
}

/// Of each slot in use its number, its node, and the places of its primitives.
fn slots(node: &WideNode) -> Vec<(usize, Option<u32>, Vec<u32>)> {
    let mut nodes = node.first_child..;
    (node.meta.iter().enumerate())
        .filter(|&(_, &meta)| meta != 0)
        .map(|(slot, &meta)| match node.inner >> slot & 1 {
            1 => {
                assert_eq!(meta, 0b001 << 5 | (24 + slot as u8));
                (slot, nodes.next(), Vec::new())
            }
            _ => {
                let first = node.first_primitive + u32::from(meta & 0x1f);
                let count = u32::from(meta >> 5).count_ones();
                (slot, None, (first..first + count).collect())
            }
        })
        .collect()
}

fn cube(center: Vec3A, half: f32) -> Bounds {
    Bounds {
        low: center - half,
        high: center + half,
    }
}

#[test]
fn coincident_and_concentric_boxes_make_shallow_trees() {
    // Were one pair joined a round, this would take hours.
    let many = 100_000;
    let coincident = vec![cube(Vec3A::ONE, 2.0); many];
    let points = vec![cube(Vec3A::ZERO, 0.0); many];
    let concentric: Vec<Bounds> = (0..many)
        .map(|i| cube(Vec3A::ZERO, 1.0 + i as f32))
        .collect();
    let shuffled: Vec<Bounds> = (0..many).map(|i| concentric[i * 7919 % many]).collect();
    let flat: Vec<Bounds> = (0..many)
        .map(|i| Bounds {
            low: Vec3A::ZERO,
            high: Vec3A::new(i as f32, 0.0, 0.0),
        })
        .collect();
    let doubling: Vec<Bounds> = (0..many)
        .map(|i| cube(Vec3A::ZERO, f32::from_bits((i as u32 % 250 + 1) << 23)))
        .collect();
    let grid: Vec<Bounds> = (0..many)
        .map(|i| cube(Vec3A::new((i % 316) as f32, 0.0, (i / 316) as f32), 0.5))
        .collect();
    for boxes in [
        coincident, points, concentric, shuffled, flat, doubling, grid,
    ] {
        check(&boxes, LEVELS);
    }
}

#[test]
fn every_number_of_boxes_fits_into_the_levels_it_needs() {
    let mut random = Random(7);
    for levels in 1..=3 {
        let most = 8usize.pow(levels);
        for count in [0, 1, 2, 3, 4, 7, 8, 9, most - 1, most] {
            if count > most {
                continue;
            }
            let chain: Vec<Bounds> = (0..count as i32)
                .map(|i| cube(random.vector(Random::unit), 0.5f32.powi(i % 100)))
                .collect();
            if count > 0 {
                check(&chain, levels);
            } else {
                assert!(WideBvh::build(chain, levels).nodes.is_empty());
            }
        }
    }
}

#[test]
fn every_box_is_within_all_nodes_above_it_whatever_the_numbers() {
    let mut random = Random(1);
    let extremes = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        1e-45,
        -1e-45,
        f32::MIN_POSITIVE,
        1e-20,
        1e19,
        -3.7e19,
        1.7e38,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    for round in 0..300 {
        let count = 1 + random.bits() as usize % 300;
        let kind = round % 6;
        let mut component = |random: &mut Random| match kind {
            0 => random.unit(),
            1 => f32::from_bits(random.bits()),
            2 => extremes[random.bits() as usize % extremes.len()],
            3 => (random.unit() - 0.5) * 10.0f32.powi(random.bits() as i32 % 30),
            // A few far away from the others.
            4 if random.bits().is_multiple_of(100) => 1e30 * random.unit(),
            // Steps of a single bit, far from the origin.
            5 => 1e6 + (random.bits() % 4) as f32 * 0.0625,
            _ => random.unit(),
        };
        let boxes: Vec<Bounds> = (0..count)
            .map(|_| Bounds::around([(); 2].map(|()| random.vector(&mut component))))
            .collect();
        check(&boxes, LEVELS);
    }
}

#[test]
fn an_instance_is_within_its_bounds() {
    let mut random = Random(3);
    for _ in 0..1000 {
        let mut component = |random: &mut Random| (random.unit() - 0.5) * 20.0;
        let object = Bounds::around([(); 3].map(|()| random.vector(&mut component)));
        let transform = Affine3A::from_cols(
            random.vector(&mut component),
            random.vector(&mut component),
            random.vector(&mut component),
            random.vector(&mut component) * 1e3,
        );
        let instance = Instance {
            name: String::new(),
            mesh: 0,
            transform,
            asset: None,
        };
        let bounds = instance_bounds(&instance, &object);
        for corner in 0..8 {
            let pick = |axis: usize| match corner >> axis & 1 {
                0 => object.low[axis],
                _ => object.high[axis],
            };
            let p = transform.transform_point3(Vec3::new(pick(0), pick(1), pick(2)));
            let p = Vec3A::from(p);
            assert!(p.cmpge(bounds.low).all() && p.cmple(bounds.high).all());
        }
    }
}
