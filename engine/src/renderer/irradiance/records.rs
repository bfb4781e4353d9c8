//! Records of irradiance as the host sees them, and the grid that finds them.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use glam::{IVec3, Vec2, Vec3};

use crate::gpu_scene::lights::luminance;

/// A record of `irradiance/records.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Record {
    /// Where, metres.
    pub(super) position: Vec3,
    /// Metres.
    pub(super) radius: f32,
    /// W/m2, red, green, blue.
    pub(super) irradiance: Vec3,
    /// Octahedral.
    pub(super) normal: u32,
    /// How each colour changes from place to place, W/m3.
    pub(super) gradients: [[f32; 3]; 3],
    /// What only the kernels read, relative to the irradiance; and its standard error in the last 16 bits.
    pub(super) inner: [u32; 14],
    /// Of a pixel there, metres.
    pub(super) width: f32,
}

impl Record {
    /// One whose irradiance isn't known yet.
    pub(super) fn begun(position: Vec3, normal: u32, width: f32) -> Self {
        Self {
            position,
            normal,
            width,
            ..Self::zeroed()
        }
    }

    /// Makes it so many times as bright.
    fn scale(&mut self, factor: f32) {
        self.irradiance *= factor;
        for number in self.gradients.iter_mut().flatten() {
            *number *= factor;
        }
    }

    /// Standard error of the irradiance's luminance, W/m2.
    pub(super) fn error(&self) -> f32 {
        luminance(self.irradiance) * (self.inner[13] >> 16) as f32 / 65535.0
    }

    /// With such an error.
    #[cfg(test)]
    pub(super) fn with_error(mut self, relative: f32) -> Self {
        self.inner[13] = ((relative * 65535.0) as u32) << 16;
        self
    }

    /// Its normal, of length 1.
    pub(super) fn facing(&self) -> Vec3 {
        octahedral_decode(self.normal)
    }
}

/// A unit vector of two numbers of 16 bits: as `octahedral_decode` of `geometry.wgsl`.
pub(super) fn octahedral_decode(packed: u32) -> Vec3 {
    let signed = |bits: u32| f32::from(bits as u16 as i16) / 32767.0;
    let p = Vec2::new(signed(packed), signed(packed >> 16)).max(Vec2::NEG_ONE);
    let mut v = Vec3::new(p.x, p.y, 1.0 - p.x.abs() - p.y.abs());
    let below = (-v.z).max(0.0);
    v.x -= below.copysign(v.x);
    v.y -= below.copysign(v.y);
    v.normalize()
}

/// The twin of `hash.wgsl`.
fn hash(x: u32) -> u32 {
    let v = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let v = (v ^ (v >> 15)).wrapping_mul(0x846c_a68b);
    v ^ (v >> 16)
}

fn hash2(x: u32, y: u32) -> u32 {
    hash(x ^ hash(y).wrapping_add(0x9e37_79b9))
}

/// Most levels: a query looks at one cell of each.
const MOST_LEVELS: i32 = 10;
/// Slots that are looked at for a cell: `GRID_PROBES` of `look_up.wgsl`.
const PROBES: u32 = 64;

/// The cells of a grid that records reach into. Records of about the same reach share a level, whose cells are once to twice as wide as
/// that: a record is in some 13 of them, and a quarter of what a cell names reaches a place in it.
#[derive(Debug)]
pub(super) struct Grid {
    /// `irradiance_grid`.
    pub(super) slots: Vec<[u32; 4]>,
    /// `irradiance_references`.
    pub(super) references: Vec<u32>,
    /// The finest cells have sides of two to this power, metres.
    pub(super) first_level: i32,
    /// How many there are.
    pub(super) levels: u32,
}

impl Grid {
    /// The number by which a cell is known.
    fn number(cell: IVec3, level: u32) -> u32 {
        let word = |x: i32| x as u32;
        let place = hash2(hash2(hash(level), word(cell.x)), word(cell.y));
        hash2(place, word(cell.z)).max(1)
    }

    /// Of records that reach `reach` times as far as their radius. At most so many slots, a power of two, and references: what
    /// there is no room for isn't found. It has twice as many slots as cells, so that what is looked at stays in the caches.
    pub(super) fn of(records: &[Record], reach: f32, slots: u32, references: usize) -> Self {
        let level = |record: &Record| (reach * record.radius).log2().ceil() as i32;
        let last = records.iter().map(level).max().unwrap_or_default();
        let first = records.iter().map(level).min().unwrap_or_default();
        let first_level = first.max(last - MOST_LEVELS + 1);
        let mut cells = HashMap::<u32, Vec<u32>>::new();
        let mut count = 0;
        for (index, record) in (0..).zip(records) {
            let level = level(record).max(first_level) - first_level;
            let side = 2.0_f32.powi(first_level + level);
            let radius = reach * record.radius;
            let corner = |offset: f32| ((record.position + offset) / side).floor().as_ivec3();
            let (low, high) = (corner(-radius), corner(radius));
            for x in low.x..=high.x {
                for y in low.y..=high.y {
                    for z in low.z..=high.z {
                        let cell = IVec3::new(x, y, z);
                        let least = cell.as_vec3() * side;
                        let nearest = record.position.clamp(least, least + side);
                        if nearest.distance(record.position) <= radius && count < references {
                            let number = Self::number(cell, level as u32);
                            let list = cells.entry(number).or_default();
                            // Cells that share a number share their list.
                            if list.last() != Some(&index) {
                                list.push(index);
                                count += 1;
                            }
                        }
                    }
                }
            }
        }
        let mut numbers: Vec<u32> = cells.keys().copied().collect();
        numbers.sort_unstable();
        let slots = slots.min((2 * numbers.len().max(1)).next_power_of_two() as u32);
        let mut grid = Self {
            slots: vec![[0; 4]; slots as usize],
            references: Vec::with_capacity(count),
            first_level,
            levels: if records.is_empty() {
                0
            } else {
                (last - first_level + 1) as u32
            },
        };
        for number in numbers {
            let free = (0..PROBES)
                .map(|i| (number.wrapping_add(i) & (slots - 1)) as usize)
                .find(|&slot| grid.slots[slot][0] == 0);
            if let Some(slot) = free {
                let list = &cells[&number];
                grid.slots[slot] = [number, grid.references.len() as u32, list.len() as u32, 0];
                grid.references.extend(list);
            }
        }
        grid
    }

    /// Records that may reach a place.
    pub(super) fn at(&self, position: Vec3) -> impl Iterator<Item = u32> {
        let mask = self.slots.len() as u32 - 1;
        (0..self.levels).flat_map(move |level| {
            let side = 2.0_f32.powi(self.first_level + level as i32);
            let number = Self::number((position / side).floor().as_ivec3(), level);
            let slot = (0..PROBES)
                .map(|i| self.slots[(number.wrapping_add(i) & mask) as usize])
                .take_while(|slot| slot[0] != 0)
                .find(|slot| slot[0] == number);
            let [_, first, count, _] = slot.unwrap_or_default();
            self.references[first as usize..][..count as usize]
                .iter()
                .copied()
        })
    }
}

/// A place that no record covers.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Candidate {
    /// Metres.
    pub(super) position: Vec3,
    /// Octahedral.
    pub(super) normal: u32,
    /// Of a pixel there, metres.
    pub(super) width: f32,
    /// Random.
    pub(super) number: u32,
    unused: [u32; 2],
}

/// Of candidates at random those that are so many pixels apart, which become records: whatever the order they come in.
pub(super) fn spread_out(mut candidates: Vec<Candidate>, pixels: f32) -> Vec<Record> {
    candidates.sort_by_key(|c| (c.number, c.position.to_array().map(f32::to_bits)));
    let mut kept = Vec::<Record>::new();
    let mut cells = HashMap::<(i32, IVec3), Vec<usize>>::new();
    for candidate in candidates {
        let distance = pixels * candidate.width;
        if !(distance > 0.0 && distance.is_finite() && candidate.position.is_finite()) {
            continue;
        }
        let level = distance.log2().ceil() as i32;
        let record = Record::begun(candidate.position, candidate.normal, candidate.width);
        let cell = |level: i32| (record.position / 2.0_f32.powi(level)).floor().as_ivec3();
        let is_near = |other: &Record| {
            other.position.distance(record.position) < distance
                && other.facing().dot(record.facing()) > 0.8
        };
        // Pixels of neighbours may be twice as wide.
        let mut around = (level - 1..=level + 1).flat_map(|level| {
            let middle = cell(level);
            (0..27).map(move |i| {
                let offset = IVec3::new(i % 3, i / 3 % 3, i / 9) - 1;
                (level, middle + offset)
            })
        });
        let is_taken = around.any(|key| {
            let list = cells.get(&key).map_or(&[][..], Vec::as_slice);
            list.iter().any(|&at| is_near(&kept[at]))
        });
        if !is_taken {
            cells
                .entry((level, cell(level)))
                .or_default()
                .push(kept.len());
            kept.push(record);
        }
    }
    kept
}

/// Most records that may cover another one before their radii shrink.
const MOST_OVERLAP: f32 = 4.0;
/// Least radius in widths of a pixel: `LEAST_WIDTHS` of `solve.wgsl`.
const LEAST_WIDTHS: f32 = 1.5;

/// Makes radii smaller where a neighbour knows of something near that the record's own rays have missed (Křivánek et al., "Making
/// Radiance and Irradiance Caching Practical", 2006), and where more records overlap than are of use.
pub(super) fn settle(records: &mut [Record], slots: u32, references: usize) {
    for _ in 0..2 {
        let grid = Grid::of(records, 1.0, slots, references);
        let settled: Vec<f32> = records
            .iter()
            .map(|record| {
                let facing = record.facing();
                let (mut radius, mut covering) = (record.radius, 0.0);
                for other in grid.at(record.position) {
                    let other = &records[other as usize];
                    let apart = other.position.distance(record.position);
                    if apart < other.radius && other.facing().dot(facing) > 0.8 {
                        radius = radius.min(other.radius + apart);
                        covering += 1.0;
                    }
                }
                if covering > MOST_OVERLAP {
                    radius *= (MOST_OVERLAP / covering).sqrt();
                }
                radius.max(LEAST_WIDTHS * record.width).min(record.radius)
            })
            .collect();
        for (record, radius) in records.iter_mut().zip(settled) {
            record.radius = radius;
        }
    }
}

/// How far records are asked for their opinion of another one, over their radius.
const REACH: f32 = 2.0;
/// Records that must have one.
const LEAST_NEIGHBOURS: usize = 3;
/// Of all of them it may be so many times the brightest.
const MOST_ABOVE: f32 = 1.25;

/// Makes records that stand out among all their neighbours as bright as the brightest of these: irradiance has no such peaks, but one of
/// the rays that a record was made of may have found what hardly any does, and then a spot as large as its radius would be seen.
pub(super) fn calm(records: &mut [Record], slots: u32, references: usize) {
    let grid = Grid::of(records, REACH, slots, references);
    let brightness = |record: &Record| record.irradiance.element_sum();
    let factors: Vec<f32> = (0..)
        .zip(&*records)
        .map(|(index, record)| {
            let others: Vec<f32> = (grid.at(record.position).filter(|&other| other != index))
                .map(|other| &records[other as usize])
                .filter(|other| {
                    let apart = other.position.distance(record.position);
                    apart < REACH * other.radius && other.facing().dot(record.facing()) > 0.9
                })
                .map(brightness)
                .collect();
            let brightest = others.iter().fold(0.0, |most: f32, &other| most.max(other));
            let stands_out = brightness(record) > MOST_ABOVE * brightest;
            match others.len() >= LEAST_NEIGHBOURS && stands_out {
                true => brightest / brightness(record),
                false => 1.0,
            }
        })
        .collect();
    for (record, factor) in records.iter_mut().zip(factors) {
        record.scale(factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(position: Vec3, radius: f32) -> Record {
        Record {
            radius,
            ..Record::begun(position, 0, 0.01)
        }
    }

    #[test]
    fn normals_are_those_of_the_kernels() {
        assert_eq!(octahedral_decode(0), Vec3::Z);
        assert_eq!(octahedral_decode(0x7fff), Vec3::X);
        let below = octahedral_decode(0x7fff_7fff);
        assert!(below.distance(Vec3::NEG_Z) < 1e-6, "{below}");
    }

    #[test]
    fn a_grid_finds_all_that_reach_a_place() {
        let mut records = Vec::new();
        for i in 0..400_u32 {
            let [x, y, z, r] = [1, 2, 3, 4].map(|s| hash(i * 7 + s) as f32 / u32::MAX as f32);
            let radius = 0.002 * 2.0_f32.powf(r * 9.0);
            records.push(record(Vec3::new(x, y, z) * 4.0 - 2.0, radius));
        }
        let grid = Grid::of(&records, 2.0, 1 << 14, 1 << 16);
        for i in 0..500_u32 {
            let [x, y, z] = [1, 2, 3].map(|s| hash(i * 5 + s + 9999) as f32 / u32::MAX as f32);
            let place = Vec3::new(x, y, z) * 4.0 - 2.0;
            let found: Vec<u32> = grid.at(place).collect();
            for (index, record) in (0..).zip(&records) {
                let reaches = record.position.distance(place) <= 2.0 * record.radius;
                assert!(!reaches || found.contains(&index), "{record:?}");
            }
        }
    }

    #[test]
    fn candidates_keep_their_distance() {
        let candidates: Vec<Candidate> = (0..2000)
            .map(|i| Candidate {
                position: Vec3::new((i % 50) as f32, (i / 50) as f32, 0.0) * 0.01,
                normal: 0,
                width: 0.01,
                number: hash(i),
                unused: [0; 2],
            })
            .collect();
        let mut other_order = candidates.clone();
        other_order.reverse();
        let kept = spread_out(candidates, 6.0);
        assert_eq!(kept, spread_out(other_order, 6.0));
        assert!((20..100).contains(&kept.len()), "{}", kept.len());
        for (i, a) in kept.iter().enumerate() {
            for b in &kept[..i] {
                assert!(a.position.distance(b.position) >= 0.06);
            }
        }
    }

    #[test]
    fn a_record_shrinks_where_its_neighbour_is_small() {
        let mut records = [record(Vec3::ZERO, 1.0), record(Vec3::X * 0.05, 0.1)];
        settle(&mut records, 1 << 8, 1 << 8);
        assert!((records[0].radius - 0.15).abs() < 1e-6, "{records:?}");
    }

    #[test]
    fn a_record_that_stands_out_is_calmed() {
        let at = |x: f32, light: f32| Record {
            irradiance: Vec3::splat(light),
            gradients: [[light; 3]; 3],
            ..record(Vec3::X * x, 1.0)
        };
        // Four in the light of a lamp that comes nearer, and one that is alone.
        let mut records = [
            at(0.0, 1.0),
            at(0.3, 1.2),
            at(0.6, 9.0),
            at(0.9, 1.6),
            at(50.0, 9.0),
        ];
        let before = records;
        calm(&mut records, 1 << 8, 1 << 8);
        assert_eq!(records[2].irradiance, Vec3::splat(1.6));
        assert!((records[2].gradients[2][1] - 1.6).abs() < 1e-6);
        for i in [0, 1, 3, 4] {
            assert_eq!(records[i], before[i]);
        }
    }
}
