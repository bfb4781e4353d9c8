//! Records of irradiance as the host sees them.

use std::sync::atomic::{AtomicU32, Ordering};

use bytemuck::{Pod, Zeroable};
use glam::{IVec3, Vec2, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::grid::{Grid, cells_between};
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
    /// By how much half of its rays find more than all, W/m2; the other half finds as much less.
    pub(super) difference: Vec3,
    /// Standard error of the irradiance's luminance, of itself.
    pub(super) relative_error: f32,
    /// How each colour changes from place to place, W/m3.
    pub(super) gradients: [[f32; 3]; 3],
    /// What only the kernels read, relative to the irradiance.
    pub(super) inner: [u32; 14],
    /// Of a pixel there, metres, but for the last eight bits: see [`Record::fits`].
    pub(super) width: f32,
}

/// Of what a record says, all is left to paths where it reaches so many times as far as what it has found allows or more, and nothing where it
/// reaches less than the second times as far.
const TOO_FAR: [f32; 2] = [8.0, 2.0];

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
        self.difference *= factor;
        for number in self.gradients.iter_mut().flatten() {
            *number *= factor;
        }
    }

    /// Standard error of the irradiance's luminance, W/m2.
    pub(super) fn error(&self) -> f32 {
        luminance(self.irradiance) * self.relative_error
    }

    /// How far it would reach if it might be smaller than it may, over how far it does; 1 where it is as small as that.
    fn fits(&self) -> f32 {
        (self.width.to_bits() & 0xff) as f32 / 255.0
    }

    /// Takes that out of its width: what is found out anew must not depend on it.
    pub(super) fn forget_fits(&mut self) {
        self.width = f32::from_bits(self.width.to_bits() & !0xff);
    }

    /// How much of the light around it is better left to paths: in a corner or on a strip that is narrower than the smallest record, light
    /// changes within it.
    pub(super) fn left_to_paths(&self) -> f32 {
        let [all, nothing] = TOO_FAR.map(|times| 1.0 / times);
        ((nothing - self.fits()) / (nothing - all)).clamp(0.0, 1.0)
    }

    /// With such an error.
    #[cfg(test)]
    pub(super) fn with_error(self, relative_error: f32) -> Self {
        Self {
            relative_error,
            ..self
        }
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
    let mut kept_in = FxHashMap::<(i32, IVec3), Vec<usize>>::default();
    for candidate in candidates {
        let distance = pixels * candidate.width;
        if !(distance > 0.0 && distance.is_finite() && candidate.position.is_finite()) {
            continue;
        }
        let level = distance.log2().ceil() as i32;
        let record = Record::begun(candidate.position, candidate.normal, candidate.width);
        let cell = |level: i32, offset: f32| {
            let place = (record.position + offset) / 2.0_f32.powi(level);
            place.floor().as_ivec3()
        };
        let is_near = |other: &Record| {
            other.position.distance(record.position) < distance
                && other.facing().dot(record.facing()) > 0.8
        };
        // Pixels of neighbours may be twice as wide.
        let mut around = (level - 1..=level + 1).flat_map(|level| {
            let middle = cell(level, 0.0);
            let low = cell(level, -distance).max(middle - 1);
            let high = cell(level, distance).min(middle + 1);
            cells_between(low, high).map(move |place| (level, place))
        });
        let is_taken = around.any(|key| {
            let list = kept_in.get(&key).map_or(&[][..], Vec::as_slice);
            list.iter().any(|&at| is_near(&kept[at]))
        });
        if !is_taken {
            kept_in
                .entry((level, cell(level, 0.0)))
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

/// How high above each other records lie at most that know something of each other's place, over how far they reach: as `STEEPNESS` of
/// `look_up.wgsl` has it.
const STEEPNESS: f32 = 12.0;

/// Makes radii smaller where a neighbour knows of something near that the record's own rays have missed (Křivánek et al., "Making
/// Radiance and Irradiance Caching Practical", 2006), and where more records overlap than are of use.
pub(super) fn settle(records: &mut [Record], slots: u32, references: usize) {
    // Radii only shrink, so whoever reaches a place in the end is among these.
    let grid = Grid::of(records, 1.0, slots, references);
    for _ in 0..2 {
        let settled: Vec<f32> = records
            .par_iter()
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
    stop_short(records, slots, references);
}

/// Makes radii smaller where a record would reach as far over a place as one there does that knows of something near: into a crease, where the
/// many on both sides of it would be heard beside the few in it.
fn stop_short(records: &mut [Record], slots: u32, references: usize) {
    let grid = Grid::of(records, REACH, slots, references);
    // The bits of positive numbers have their order.
    let radii: Vec<AtomicU32> = (records.iter())
        .map(|record| AtomicU32::new(record.radius.to_bits()))
        .collect();
    records.par_iter().for_each(|one| {
        let facing = one.facing();
        for index in grid.at(one.position) {
            let other = &records[index as usize];
            let offset = one.position - other.position;
            let apart = offset.length();
            let height = 0.5 * offset.dot(facing + other.facing()).abs();
            let is_reached = apart.max(STEEPNESS * height) < REACH * other.radius;
            if is_reached && other.facing().dot(facing) > 0.8 {
                let radius = one.radius + apart / REACH;
                let radius = radius.max(LEAST_WIDTHS * other.width);
                radii[index as usize].fetch_min(radius.to_bits(), Ordering::Relaxed);
            }
        }
    });
    for (record, radius) in records.iter_mut().zip(radii) {
        record.radius = record.radius.min(f32::from_bits(radius.into_inner()));
    }
}

/// How far records reach when they are used, over their radius, and when they are asked for their opinion of another one.
pub(super) const REACH: f32 = 2.0;
/// Records that must have one.
const LEAST_NEIGHBOURS: usize = 3;
/// Of all of them it may be so many times the brightest.
const MOST_ABOVE: f32 = 1.25;

/// Makes records that stand out among all their neighbours as bright as the brightest of these: irradiance has no such peaks, but one of
/// the rays that a record was made of may have found what hardly any does, and then a spot as large as its radius would be seen. The grid
/// is theirs for [`REACH`].
pub(super) fn calm(records: &mut [Record], grid: &Grid) {
    let brightness = |record: &Record| record.irradiance.element_sum();
    let factors: Vec<f32> = (0..records.len() as u32)
        .into_par_iter()
        .map(|index| {
            let record = &records[index as usize];
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
    use super::super::grid::hash;
    use super::*;

    fn record(position: Vec3, radius: f32) -> Record {
        Record {
            radius,
            ..Record::begun(position, 0, 0.01)
        }
    }

    #[test]
    fn what_a_record_is_too_large_for_is_left_to_paths() {
        let left = |fits: u32| {
            let width = f32::from_bits(0.01_f32.to_bits() & !0xff | fits);
            Record::begun(Vec3::ZERO, 0, width).left_to_paths()
        };
        assert_eq!([0, 31, 128, 255].map(left), [1.0, 1.0, 0.0, 0.0]);
        assert!((left(80) - 0.5).abs() < 0.01, "{}", left(80));
    }

    #[test]
    fn normals_are_those_of_the_kernels() {
        assert_eq!(octahedral_decode(0), Vec3::Z);
        assert_eq!(octahedral_decode(0x7fff), Vec3::X);
        let below = octahedral_decode(0x7fff_7fff);
        assert!(below.distance(Vec3::NEG_Z) < 1e-6, "{below}");
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
        assert!((records[0].radius - 0.125).abs() < 1e-6, "{records:?}");
    }

    #[test]
    fn a_record_reaches_no_farther_over_a_small_one_than_that() {
        let wall = |at: f32, radius: f32| record(Vec3::X * at, radius);
        let mut records = [wall(0.0, 1.0), wall(1.6, 0.1), wall(9.0, 1.0)];
        settle(&mut records, 1 << 8, 1 << 8);
        let reach = REACH * records[0].radius;
        assert!((reach - 1.8).abs() < 1e-5, "{records:?}");
        assert_eq!([records[1].radius, records[2].radius], [0.1, 1.0]);
        // On another plane it knows nothing of this one.
        let mut step = [wall(0.0, 1.0), wall(1.6, 0.1)];
        step[1].position.z += 0.3;
        settle(&mut step, 1 << 8, 1 << 8);
        assert_eq!(step[0].radius, 1.0);
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
        let grid = Grid::of(&records, REACH, 1 << 8, 1 << 8);
        calm(&mut records, &grid);
        assert_eq!(records[2].irradiance, Vec3::splat(1.6));
        assert!((records[2].gradients[2][1] - 1.6).abs() < 1e-6);
        for i in [0, 1, 3, 4] {
            assert_eq!(records[i], before[i]);
        }
    }
}
