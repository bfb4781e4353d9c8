//! Where the sky is seen from which places: what light samples need to know in a room that it lights through a window.
//!
//! Nearly all samples of such a sky end at a wall. Some paths go ahead, and count for each cell of space and each part of the sky how
//! many samples were sent there and how many arrived. From then on parts are chosen by what they send and how likely it is to arrive
//! (in the spirit of Bashford-Rogers, Debattista and Chalmers, "Importance Driven Environment Map Sampling", 2014). Each part that
//! emits keeps a share, so that the picture is the same on average; only its noise isn't.
//!
//! A part is wider than what is seen of it past the frame of a window, and where it is seen differs within a cell. So the first of these paths
//! find out by which [openings](super::openings) of the box around the scene the sky is seen, and the others how much light comes to a cell by way
//! of each. Most samples of what is known go through these.

use std::{borrow::Cow, collections::HashMap};

use device::{Device, DeviceError, Format, Image, ImageUse, Recording, Resources, Usage};
use rayon::prelude::*;

use glam::Vec3;

use crate::gpu_scene::{
    environment::GpuEnvironment,
    sky_parts::{Between, PARTS, push_row, received, solid_angles},
};

use super::openings::{self, ALL_SQUARES, OPENINGS, Openings};

/// Cells: as in `shared/sky_parts.wgsl`.
const CELLS: usize = 8192;
/// Steps of the grid of normals by which cells are told apart: as there.
const FACING_STEPS: u32 = 4;
/// What normals between those receive beyond them.
const BETWEEN: Between = Between {
    more: 0.1,
    down: 0.6,
};
/// What is counted for a cell: each part, and all lamps.
const COUNTS: usize = PARTS + 1;
/// Light that has arrived at a cell by way of no opening, and of each; with the number of samples after it words in pairs.
const SUMS: usize = OPENINGS + 1;
/// Pairs of words for a cell: with the wider cell around it and the facing.
const PAIRS: usize = COUNTS + 1 + SUMS.div_ceil(2);
/// Bytes of that in all cells, and of squares of the box.
const COUNTED: u64 = (CELLS * PAIRS * 8 + ALL_SQUARES * 4) as u64;
/// Texels of what is known of a cell, and floats: four parts or openings in each, then shares. The last ones say where openings are.
const TEXELS: u32 = ((PARTS + OPENINGS) / 4 + 1 + openings::COLUMNS) as u32;
const ROW: usize = 4 * TEXELS as usize;
/// Bytes of that for all cells.
const KNOWN: u64 = (CELLS * ROW * 4) as u64;
/// Share of the samples that are sent as if nothing were known.
const BLIND: f64 = 0.1;
/// Samples that what is seen from the wider cell counts for beside those of a cell itself, and what is seen from all together beside those
/// of the wider one.
const PRIOR: f64 = 4.0;
/// The same for how much light comes through openings, which is told by fewer.
const OPENINGS_PRIOR: f64 = 64.0;
/// Share of the samples that go through openings where all light comes through these.
const THROUGH_OPENINGS: f64 = 0.75;
/// Share of the light samples that what hardly ever arrives keeps beside what does: the sky, or all lamps.
const LEAST_SHARE: f64 = 0.15;
/// Of samples so many have to arrive for an equal share: in a cell much may be in shadow, and some of it in bright light.
const OFTEN: f64 = 0.02;

/// Of rays that a surface scatters diffusely, and that only have to find the sky, so many are enough beside light samples, over the root of
/// the noise that they have if all go on. Noise times work is least at one over the root of the rest's noise and of what they take beside the
/// rest, which both are about 0.4 (relative variance of a sample, and time).
const RAYS_SHARE: f64 = 2.5;
/// The least part of them.
const FEWEST_RAYS: f64 = 0.125;

/// What there is beside the sky.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lamps {
    /// Of the light samples, where it arrives as often as lamps do.
    pub(super) share_of_sky: f64,
    /// Whether all of them are infinitely far away, nothing else emits, and no shadow ray waits for a texture program: else rays may find
    /// what light samples of the sky don't, and all go on.
    pub(super) are_far: bool,
}

/// What knows it.
#[derive(Debug)]
pub(super) struct Sky {
    known: Image,
    openings: Openings,
}

/// Bytes of its buffers.
pub(super) const BYTES: u64 = COUNTED + KNOWN;

impl Sky {
    /// Makes its buffers.
    pub(super) fn new(device: &Device, resources: &mut Resources) -> Result<Self, DeviceError> {
        let seen = device.buffer("sky_seen", Usage::Storage, COUNTED)?;
        resources.set_buffer("sky_seen", seen);
        let size = [TEXELS, CELLS as u32, 1];
        let known = device.image("known sky", ImageUse::Read, size, Format::Rgba32Float)?;
        resources.set_image("known_sky", known.clone());
        Ok(Self {
            known,
            openings: Openings::default(),
        })
    }

    /// Begins to count.
    pub(super) fn begin(
        &mut self,
        device: &Device,
        resources: &Resources,
    ) -> Result<(), DeviceError> {
        self.openings = Openings::default();
        let mut recording = Recording::new("forget the sky");
        recording.clear(resources.buffer("sky_seen"));
        device.start(&recording)
    }

    /// Finds the openings of a box around the scene by what has been counted.
    pub(super) fn find_openings(
        &mut self,
        device: &Device,
        resources: &Resources,
        bounds: [Vec3; 2],
    ) -> Result<(), DeviceError> {
        let bytes = 4 * ALL_SQUARES as u64;
        let bytes = device.read(resources.buffer("sky_seen"), COUNTED - bytes, bytes)?;
        self.openings = Openings::find(&bytemuck::pod_collect_to_vec(&bytes), bounds);
        Ok(())
    }

    /// Has light samples go by what has been counted.
    pub(super) fn learn(
        &self,
        device: &Device,
        resources: &Resources,
        environment: &GpuEnvironment,
        lamps: Lamps,
    ) -> Result<(), DeviceError> {
        let bytes = (CELLS * PAIRS * 8) as u64;
        let bytes = device.read(resources.buffer("sky_seen"), 0, bytes)?;
        // Without a copy wherever memory comes aligned, for there is much of it.
        let seen: Cow<'_, [[u32; 2]]> = match bytemuck::try_cast_slice(&bytes) {
            Ok(seen) => Cow::Borrowed(seen),
            Err(_) => Cow::Owned(bytemuck::pod_collect_to_vec(&bytes)),
        };
        let received = received(FACING_STEPS, environment.turn, BETWEEN);
        let mut rows = rows(&seen, &environment.parts, &received, &self.openings, lamps);
        self.openings.put_into(&mut rows, ROW);
        let size = [TEXELS, CELLS as u32];
        self.known
            .write(device, [0; 3], size, bytemuck::cast_slice(&rows));
        Ok(())
    }
}

/// What is known of each cell: the probability of each part and those before it, of samples that were sent and arrived, and likewise of each
/// opening; then the share of the sky, that of openings, and of rays those that are enough beside light samples. `received` says for each facing
/// how much of what a part sends is received.
fn rows(
    seen: &[[u32; 2]],
    parts: &[f64],
    received: &[[f64; PARTS]],
    openings: &Openings,
    lamps: Lamps,
) -> Vec<f32> {
    let mut anywhere = [[0; 2]; COUNTS];
    for cell in seen.chunks_exact(PAIRS) {
        for (sum, counts) in anywhere.iter_mut().zip(cell) {
            *sum = [sum[0] + u64::from(counts[0]), sum[1] + u64::from(counts[1])];
        }
    }
    // What nothing was sent to may be seen.
    let anywhere = anywhere.map(|[sent, arrived]| (arrived as f64 + 1.0) / (sent as f64 + 1.0));
    let wider_sums = sums_of_wider(seen, openings);
    let mut all_sums = [0; SUMS + 1];
    for sums in wider_sums.values() {
        add(&mut all_sums, sums);
    }
    let brought_anywhere = match all_sums[SUMS] {
        0 => openings.shares(),
        samples => std::array::from_fn(|i| all_sums[i] as f64 / samples as f64),
    };
    let ones = [1.0; OPENINGS];
    let angles = solid_angles();
    let row = |cell: &[[u32; 2]]| {
        let wider = match cell[COUNTS][0] as usize {
            0 => None,
            row => seen.chunks_exact(PAIRS).nth(row - 1),
        };
        let around = wider.map_or(anywhere, |wider| arrives(wider, &anywhere));
        let arrives = arrives(cell, &around);
        let arriving: f64 = arrives.iter().zip(parts).map(|(a, part)| a * part).sum();
        let facing = (cell[COUNTS][1] as usize)
            .checked_sub(1)
            .and_then(|facing| received.get(facing));
        let weights: Vec<f64> = (0..PARTS)
            .map(|i| arrives[i] * facing.map_or(1.0, |received| received[i]))
            .collect();
        let mut row = Vec::with_capacity(ROW);
        push_row(&mut row, parts, &weights, BLIND);
        let mut through = 0.0;
        if openings.is_empty() {
            row.extend([1.0; OPENINGS]);
        } else {
            let around = wider_sums.get(&cell[COUNTS][0]);
            let around = around.map_or(brought_anywhere, |sums| brings(sums, &brought_anywhere));
            let brings = brings(&sums(cell), &around);
            let by_openings: f64 = brings[1..].iter().sum();
            let all = by_openings + brings[0];
            through = THROUGH_OPENINGS * by_openings / all.max(f64::MIN_POSITIVE);
            push_row(&mut row, &brings[1..], &ones, 0.0);
        }
        let of_sky = share_of_sky(lamps.share_of_sky, arriving, arrives[PARTS]);
        let shares = [of_sky, through];
        let rays = match lamps.are_far {
            true => rays_share(&arrives, facing, parts, &weights, &angles, shares),
            false => 1.0,
        };
        row.extend([of_sky as f32, through as f32, rays as f32]);
        row.resize(ROW, 0.0);
        row
    };
    // Most cells lie nowhere.
    let nowhere = row(&[[0; 2]; PAIRS]);
    let mut rows = vec![0.0; seen.len() / PAIRS * ROW];
    let cells = seen.par_chunks_exact(PAIRS);
    rows.par_chunks_exact_mut(ROW)
        .zip(cells)
        .for_each(|(to, cell)| match cell[COUNTS] {
            [0, 0] => to.copy_from_slice(&nowhere),
            _ => to.copy_from_slice(&row(cell)),
        });
    rows
}

/// Of a cell how much light has arrived by way of no opening, and of each; then of how many samples.
fn sums(cell: &[[u32; 2]]) -> [u64; SUMS + 1] {
    let words = cell[COUNTS + 1..].as_flattened();
    std::array::from_fn(|i| words[i].into())
}

fn add(to: &mut [u64; SUMS + 1], sums: &[u64; SUMS + 1]) {
    for (to, sum) in to.iter_mut().zip(sums) {
        *to += sum;
    }
}

/// The same of all cells in each wider one, by the word that says which that is.
fn sums_of_wider(seen: &[[u32; 2]], openings: &Openings) -> HashMap<u32, [u64; SUMS + 1]> {
    let mut wider = HashMap::new();
    if !openings.is_empty() {
        for cell in seen.chunks_exact(PAIRS) {
            let of_wider = wider.entry(cell[COUNTS][0]).or_insert([0; SUMS + 1]);
            add(of_wider, &sums(cell));
        }
    }
    wider
}

/// How much light a sample brings by way of no opening, and of each, of which so much is supposed to without having counted.
fn brings(sums: &[u64; SUMS + 1], supposed: &[f64; SUMS]) -> [f64; SUMS] {
    let samples = sums[SUMS] as f64;
    std::array::from_fn(|i| {
        (sums[i] as f64 + OPENINGS_PRIOR * supposed[i]) / (samples + OPENINGS_PRIOR)
    })
}

/// How much of what is sent to a cell arrives, of which so much is supposed to without having counted.
fn arrives(cell: &[[u32; 2]], supposed: &[f64; COUNTS]) -> [f64; COUNTS] {
    std::array::from_fn(|i| {
        let [sent, arrived] = cell[i].map(f64::from);
        (arrived + PRIOR * supposed[i]) / (sent + PRIOR)
    })
}

/// The share of the light samples that the sky gets, where so much of its light arrives and so many samples of lamps do.
fn share_of_sky(share: f64, sky: f64, lamps: f64) -> f64 {
    if share >= 1.0 {
        return 1.0;
    }
    let of_sky = share * (sky / OFTEN).min(1.0);
    let of_lamps = (1.0 - share) * (lamps / OFTEN).min(1.0);
    (of_sky / (of_sky + of_lamps).max(f64::MIN_POSITIVE)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
}

/// Of rays that a surface scatters diffusely the part that is enough beside light samples, of which the sky gets the first share, and openings
/// the second one of these; others are sent to each part by `weights`. `angles` has how much of a sphere each part is. Where little of the sky is seen light samples are far denser
/// there, and what a ray finds hardly counts.
fn rays_share(
    arrives: &[f64; COUNTS],
    received: Option<&[f64; PARTS]>,
    parts: &[f64],
    weights: &[f64],
    angles: &[f64; PARTS],
    [of_sky, through]: [f64; 2],
) -> f64 {
    let total: f64 = weights.iter().zip(parts).map(|(w, part)| w * part).sum();
    // What openings are uniform over, about.
    let seen: f64 = (arrives.iter().zip(angles).zip(parts))
        .map(|((a, angle), &part)| if part > 0.0 { a * angle } else { 0.0 })
        .sum();
    let (mut found, mut squares) = (0.0, 0.0);
    for (i, angle) in angles.iter().enumerate() {
        let radiance = parts[i] / angle;
        let known = weights[i] * radiance / total.max(f64::MIN_POSITIVE);
        let by_parts = BLIND * radiance + (1.0 - BLIND) * known;
        let by_light =
            of_sky * ((1.0 - through) * by_parts + through / seen.max(f64::MIN_POSITIVE));
        let by_ray = 4.0 * received.map_or(1.0, |received| received[i]);
        // The power heuristic's.
        let weight =
            by_ray * by_ray / (by_ray * by_ray + by_light * by_light).max(f64::MIN_POSITIVE);
        let rays = arrives[i] * angle * by_ray;
        found += rays * radiance;
        squares += rays * (radiance * weight).powi(2);
    }
    let noise = squares / (found * found).max(f64::MIN_POSITIVE);
    (RAYS_SHARE * noise.sqrt()).clamp(FEWEST_RAYS, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamps(share_of_sky: f64) -> Lamps {
        Lamps {
            share_of_sky,
            are_far: share_of_sky == 1.0,
        }
    }

    #[test]
    fn rays_are_many_where_much_of_the_sky_is_seen() {
        let parts = solid_angles();
        let share = |seen: usize| {
            let arrives: [f64; COUNTS] = std::array::from_fn(|i| if i < seen { 1.0 } else { 0.0 });
            let up: [f64; PARTS] = std::array::from_fn(|i| if i < PARTS / 2 { 0.5 } else { 0.0 });
            let weights: Vec<_> = arrives.iter().zip(up).map(|(a, b)| a * b).collect();
            rays_share(&arrives, Some(&up), &parts, &weights, &parts, [1.0, 0.0])
        };
        assert_eq!(share(PARTS / 2), 1.0);
        assert!(
            (0.3..1.0).contains(&share(PARTS / 4)),
            "{}",
            share(PARTS / 4)
        );
        assert_eq!(share(PARTS / 16), FEWEST_RAYS);
        assert_eq!(share(0), FEWEST_RAYS);
    }

    #[test]
    fn samples_go_where_they_arrive_and_everywhere_else_too() {
        let parts: Vec<f64> = (0..PARTS)
            .map(|i| {
                if i % 4 == 3 {
                    0.0
                } else {
                    1.0 / (0.75 * PARTS as f64)
                }
            })
            .collect();
        // The first cell sees part 5 and no lamp, the second has seen nothing yet. The third lies in the first.
        let mut seen = vec![[100, 0]; PAIRS];
        seen[5] = [100, 90];
        seen[COUNTS] = [0, 1];
        seen.extend(vec![[0, 0]; 2 * PAIRS]);
        seen[2 * PAIRS + COUNTS] = [1, 0];
        let rows = rows(&seen, &parts, &[], &Openings::default(), lamps(0.5));
        let probability = |cell: usize, part: usize| {
            let before = match part {
                0 => 0.0,
                _ => rows[cell * ROW + part - 1],
            };
            rows[cell * ROW + part] - before
        };
        assert!(probability(0, 5) > 0.6, "{}", probability(0, 5));
        for cell in 0..3 {
            for (part, &sends) in parts.iter().enumerate() {
                let least = BLIND * sends * 0.999;
                assert!(f64::from(probability(cell, part)) >= least, "{cell} {part}");
                assert!(
                    sends > 0.0 || probability(cell, part) == 0.0,
                    "{cell} {part}"
                );
            }
            assert_eq!(rows[cell * ROW + PARTS - 1], 1.0);
        }
        // What others see is a hint.
        assert!(probability(1, 5) > 10.0 * probability(1, 6));
        assert!(probability(2, 5) > 0.6);
    }

    #[test]
    fn samples_go_through_openings_by_what_these_bring() {
        let mut arrived = vec![0; ALL_SQUARES];
        arrived[100] = 10;
        arrived[ALL_SQUARES / 2] = 30;
        let openings = Openings::find(&arrived, [Vec3::ZERO, Vec3::ONE]);
        let shares = openings.shares();
        let first = if shares[1] < 0.5 { 0 } else { 1 };
        // The first cell gets nothing by way of the opening by which most arrives; the second has seen nothing yet, and lies in the first.
        let mut seen = vec![[0, 0]; 2 * PAIRS];
        let word = |i: usize| (COUNTS + 1 + i / 2, i % 2);
        for (i, value) in [(0, 2000), (first + 1, 6000), (SUMS, 10_000)] {
            let (pair, half) = word(i);
            seen[pair][half] = value;
        }
        seen[COUNTS] = [1, 0];
        seen[PAIRS + COUNTS] = [1, 0];
        let parts = [1.0 / PARTS as f64; PARTS];
        let rows = rows(&seen, &parts, &[], &openings, lamps(1.0));
        for row in rows.chunks_exact(ROW) {
            let of_first = match first {
                0 => row[PARTS],
                _ => row[PARTS + 1] - row[PARTS],
            };
            assert!((of_first - 1.0).abs() < 0.01, "{of_first}");
            assert_eq!(row[PARTS + OPENINGS - 1], 1.0);
            let through = f64::from(row[PARTS + OPENINGS + 1]);
            assert!(
                (through - 0.75 * THROUGH_OPENINGS).abs() < 0.01,
                "{through}"
            );
        }
    }

    #[test]
    fn what_arrives_gets_most_of_the_samples() {
        assert_eq!(share_of_sky(1.0, 0.0, 0.0), 1.0);
        assert_eq!(share_of_sky(0.5, 0.3, 0.9), 0.5);
        assert_eq!(share_of_sky(0.5, 0.3, 0.0), 1.0 - LEAST_SHARE);
        assert_eq!(share_of_sky(1.0 / 3.0, 0.0, 0.5), LEAST_SHARE);
        assert!((0.5..0.6).contains(&share_of_sky(0.5, 1.0, 0.016)));
    }
}
