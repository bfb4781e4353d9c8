//! The grid that finds records of irradiance by where they are.

use bytemuck::{Pod, Zeroable};
use glam::{IVec3, UVec3, Vec3};
use rayon::prelude::*;

use super::records::Record;
use crate::morton;

/// Most levels: a query looks at one cell of each.
const MOST_LEVELS: i32 = 10;
/// Slots that are looked at for a cell: `GRID_PROBES` of `grid.wgsl`.
const PROBES: u32 = 64;
/// Cells of a block, whose slots stand together.
const BLOCK: u32 = 8;

/// Where a cell's list is: `irradiance_grid`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Slot {
    /// Of the cell's block; 0 where the slot is free.
    number: u32,
    /// First reference, and how many.
    first: u32,
    count: u32,
    /// The cell's coordinates and level as far as they fit: cells whose blocks share a number hardly share this, too.
    check: u32,
}

/// A record that reaches into a cell: what says how much it counts there, in units of the cell. `irradiance_references`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Reference {
    /// Position, from the corner of the cell before, over three sides: 65535 for 1.
    position: [u16; 3],
    /// How far it reaches, over a side, likewise.
    reach: u16,
    /// 10 bits for each coordinate, as [`coarse_normal`] packs them.
    normal: u32,
    /// Which one, in 24 bits, and above these [`Record::left_to_paths`], 255 for 1.
    record: u32,
}

/// The bits of [`Reference::record`] that say which one.
const NUMBER: u32 = 0xff_ffff;

/// A cell of a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Cell {
    level: u32,
    place: IVec3,
}

impl Cell {
    /// The number of its block, never 0, and the first slot that is looked at.
    fn number(self, mask: u32) -> (u32, u32) {
        let word = |x: i32| (x >> 1) as u32;
        let block = word(self.place.x).wrapping_mul(0x8da6_b343)
            ^ word(self.place.y).wrapping_mul(0xd816_3841)
            ^ word(self.place.z).wrapping_mul(0xcb1a_b31f)
            ^ self.level.wrapping_mul(0x9e37_79b9);
        let number = hash(block);
        let odd = (self.place & 1).as_uvec3();
        let of_block = odd.x | odd.y << 1 | odd.z << 2;
        // A plane has half of each block's cells: which ones come first is left to chance.
        let slot = (number & !(BLOCK - 1)) | (of_block ^ (number >> 29));
        (number.max(1), slot & mask)
    }

    /// By which cells stand in order: level by level along Morton's curve, but that far ones may share it.
    fn key(self) -> u64 {
        let code = morton::code(self.place.wrapping_add(IVec3::splat(1 << 19)).as_uvec3());
        u64::from(self.level) << LEVEL_SHIFT | code & ((1 << LEVEL_SHIFT) - 1)
    }

    /// What [`Slot::check`] says.
    fn check(self) -> u32 {
        let low = (self.place & 0x3ff).as_uvec3();
        low.x | low.y << 10 | low.z << 20 | self.level << 30
    }
}

/// A record in the list of a cell; there are hundreds of thousands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// [`Cell::key`], which is compared first.
    key: u64,
    place: [i32; 3],
    record: u32,
}

impl Entry {
    fn cell(&self) -> Cell {
        Cell {
            level: (self.key >> LEVEL_SHIFT) as u32,
            place: IVec3::from(self.place),
        }
    }
}

/// Where the level stands in a [`Cell::key`].
const LEVEL_SHIFT: u32 = 60;

/// Those of a box, its last corner among them.
pub(super) fn cells_between(low: IVec3, high: IVec3) -> impl Iterator<Item = IVec3> {
    let rows = (low.x..=high.x).flat_map(move |x| (low.y..=high.y).map(move |y| (x, y)));
    rows.flat_map(move |(x, y)| (low.z..=high.z).map(move |z| IVec3::new(x, y, z)))
}

/// The twin of `hash.wgsl`.
pub(super) fn hash(x: u32) -> u32 {
    let v = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let v = (v ^ (v >> 15)).wrapping_mul(0x846c_a68b);
    v ^ (v >> 16)
}

/// The cells of a grid that records reach into. Records of about the same reach share a level, whose cells are once to twice as wide as
/// that: a record is in some 13 of them, and a quarter of what a cell names reaches a place in it.
#[derive(Debug)]
pub(super) struct Grid {
    /// A power of two of them.
    pub(super) slots: Vec<Slot>,
    pub(super) references: Vec<Reference>,
    /// The finest cells have sides of two to this power, metres.
    pub(super) first_level: i32,
    /// How many there are.
    pub(super) levels: u32,
}

impl Grid {
    /// Of records that reach `reach` times as far as their radius. At most so many slots, a power of two, and references: what
    /// there is no room for isn't found. It has twice as many slots as cells, so that what is looked at stays in the caches.
    pub(super) fn of(records: &[Record], reach: f32, slots: u32, references: usize) -> Self {
        let level = |record: &Record| (reach * record.radius).log2().ceil() as i32;
        let last = records.iter().map(level).max().unwrap_or_default();
        let first = records.iter().map(level).min().unwrap_or_default();
        let first_level = first.max(last - MOST_LEVELS + 1);
        let side = |level: u32| 2.0_f32.powi(first_level + level as i32);
        let mut entries: Vec<Entry> = records
            .par_iter()
            .zip(0..records.len() as u32)
            .flat_map_iter(|(of, record)| {
                let level = (level(of).max(first_level) - first_level) as u32;
                let side = side(level);
                let radius = reach * of.radius;
                let corner = |offset: f32| ((of.position + offset) / side).floor().as_ivec3();
                cells_between(corner(-radius), corner(radius)).filter_map(move |place| {
                    let least = place.as_vec3() * side;
                    let nearest = of.position.clamp(least, least + side);
                    let is_reached = nearest.distance(of.position) <= radius;
                    is_reached.then(|| Entry {
                        key: Cell { level, place }.key(),
                        place: place.to_array(),
                        record,
                    })
                })
            })
            .collect();
        entries.truncate(references);
        entries.par_sort_unstable();
        let lists = || entries.chunk_by(|a, b| a.key == b.key && a.place == b.place);
        let wanted = (2 * lists().count() as u32).next_power_of_two().max(BLOCK);
        let slots = slots.min(wanted);
        let mut grid = Self {
            slots: vec![Slot::zeroed(); slots as usize],
            references: (entries.par_iter())
                .map(|entry| {
                    let Cell { level, place } = entry.cell();
                    let (side, of) = (side(level), &records[entry.record as usize]);
                    let corner = place.as_vec3() * side;
                    reference(entry.record, of, corner, side, reach * of.radius)
                })
                .collect(),
            first_level,
            levels: match records {
                [] => 0,
                _ => (last - first_level + 1) as u32,
            },
        };
        let mut first = 0;
        for list in lists() {
            let cell = list[0].cell();
            let (number, slot) = cell.number(slots - 1);
            let free = probes(slot, slots).find(|&slot| grid.slots[slot].number == 0);
            let count = list.len() as u32;
            if let Some(slot) = free {
                grid.slots[slot] = Slot {
                    number,
                    first,
                    count,
                    check: cell.check(),
                };
            }
            first += count;
        }
        grid
    }

    /// Records that may reach a place.
    pub(super) fn at(&self, position: Vec3) -> impl Iterator<Item = u32> {
        let slots = self.slots.len() as u32;
        (0..self.levels).flat_map(move |level| {
            let side = 2.0_f32.powi(self.first_level + level as i32);
            let place = (position / side).floor().as_ivec3();
            let cell = Cell { level, place };
            let (number, slot) = cell.number(slots - 1);
            let slot = probes(slot, slots)
                .map(|slot| self.slots[slot])
                .take_while(|slot| slot.number != 0)
                .find(|slot| slot.number == number && slot.check == cell.check())
                .unwrap_or(Slot::zeroed());
            (self.references[slot.first as usize..][..slot.count as usize].iter())
                .map(|reference| reference.record & NUMBER)
        })
    }
}

/// The slots that are looked at, from this one on.
fn probes(slot: u32, slots: u32) -> impl Iterator<Item = usize> {
    (0..PROBES).map(move |i| (slot.wrapping_add(BLOCK * i) & (slots - 1)) as usize)
}

/// A record as a cell of such a corner and side names it.
fn reference(index: u32, record: &Record, corner: Vec3, side: f32, reach: f32) -> Reference {
    let share = |x: f32| (x.clamp(0.0, 1.0) * 65535.0).round() as u16;
    let position = (record.position - corner + side) / (3.0 * side);
    Reference {
        position: position.to_array().map(share),
        reach: share(reach / side),
        normal: coarse_normal(record.facing()),
        record: (index & NUMBER) | ((255.0 * record.left_to_paths()).round() as u32) << 24,
    }
}

/// A unit vector in 30 bits: each coordinate in 511ths, 512 for 0.
fn coarse_normal(normal: Vec3) -> u32 {
    let words = (normal * 511.0 + 512.0).round().as_uvec3();
    words.x | words.y << 10 | words.z << 20
}

/// Puts records into an order in which neighbours in space are near each other in memory.
pub(super) fn sort_along_the_curve(records: &mut [Record]) {
    let low = records
        .iter()
        .fold(Vec3::INFINITY, |low, record| low.min(record.position));
    let high = records
        .iter()
        .fold(Vec3::NEG_INFINITY, |high, record| high.max(record.position));
    let cells = ((1 << 20) as f32 / (high - low).max_element()).min(f32::MAX);
    let cell = |record: &Record| -> UVec3 { ((record.position - low) * cells).as_uvec3() };
    records.sort_by_key(|record| morton::code(cell(record)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_finds_all_that_reach_a_place() {
        let mut records = Vec::new();
        for i in 0..400_u32 {
            let [x, y, z, r] = [1, 2, 3, 4].map(|s| hash(i * 7 + s) as f32 / u32::MAX as f32);
            let radius = 0.002 * 2.0_f32.powf(r * 9.0);
            let position = Vec3::new(x, y, z) * 4.0 - 2.0;
            records.push(Record {
                radius,
                ..Record::begun(position, 0, 0.01)
            });
        }
        sort_along_the_curve(&mut records);
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
    fn cells_know_where_their_records_are() {
        let at = Vec3::new(-0.7, 3.1, 0.05);
        let record = Record {
            radius: 0.4,
            ..Record::begun(at, 0x7fff, 0.01)
        };
        let grid = Grid::of(&[record], 2.0, 1 << 10, 1 << 10);
        assert!(grid.references.len() >= 8);
        for slot in grid.slots.iter().filter(|slot| slot.number != 0) {
            assert_eq!(slot.count, 1);
            let found = grid.references[slot.first as usize];
            let x = 1023 | 512 << 10 | 512 << 20;
            assert_eq!((found.normal, found.record & NUMBER), (x, 0));
            assert!(
                (f32::from(found.reach) / 65535.0 - 0.8).abs() < 1e-4,
                "{found:?}"
            );
            // The same place, whichever cell it is seen from.
            let low = [0, 10, 20].map(|shift| ((slot.check >> shift & 0x3ff) as i32) << 22 >> 22);
            let within = Vec3::from(found.position.map(|x| f32::from(x) / 65535.0 * 3.0 - 1.0));
            let place = IVec3::from(low).as_vec3() + within;
            assert!(place.distance(at) < 1e-3, "{found:?}: {place}");
        }
    }
}
