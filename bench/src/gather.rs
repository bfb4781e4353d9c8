//! Looking up photons: the renderer's octree of references against its grid of sorted photons and a kd-tree, which find the same photons for
//! the same places.
//!
//! Photons lie on a floor, many of them in one spot as below a lens, and on a ball; places that ask for them lie there too. All three ways test
//! photons by the same function and add up whole numbers, so that their sums must be equal. The device sorts photons into the grid, and builds the octree of
//! what is sorted, which is counted as its own; the tree is built by one thread of the program.

use std::fmt::Write as _;
use std::time::Instant;

use bytemuck::Zeroable;
use device::{BoundKernel, Device, DeviceError, Extent, Recording, Resources, Trust, Usage};
use engine::frame::Frame;
use engine::gpu_scene::SceneFeatures;
use engine::passes::pass::Pass;
use engine::passes::photons::{
    Each, GRID, OCTREE, PhotonSettings, bytes_of_cells, bytes_of_grid, bytes_of_photons,
};
use glam::{Vec2, Vec3};
use serde::Serialize;

use crate::spread::Spread;
use crate::wgsl::compose;

/// Radii that are measured, metres.
const RADII: [f32; 3] = [0.005, 0.01, 0.02];
/// References that there is room for, for each photon; cells of octree and grid.
const REFERENCES: u32 = 24;
const CELLS: u32 = 2;
/// Distances to the camera count as at least so much, metres: all radii are the same then.
const NEAREST: f32 = 1000.0;
/// Flux of a photon, a whole number.
const FLUX: u32 = 4096;

/// A way to find photons.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Finder {
    /// Leaves that know all photons which reach into them.
    Octree,
    /// Cells that photons are sorted by.
    Grid,
    /// A left-balanced tree of the photons.
    Tree,
}

impl Finder {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Octree, Self::Grid, Self::Tree];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Octree => "octree",
            Self::Grid => "grid",
            Self::Tree => "kd-tree",
        }
    }

    fn entry(self) -> &'static str {
        match self {
            Self::Octree => "by_octree",
            Self::Grid => "by_grid",
            Self::Tree => "by_tree",
        }
    }
}

/// A way at one radius.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Metres.
    pub radius: f32,
    /// Photons that a place finds, on average.
    pub photons: f64,
    /// Which.
    pub finder: Finder,
    /// Milliseconds in which it is built.
    pub build: Spread,
    /// Milliseconds in which all places ask.
    pub find: Spread,
    /// Of the octree's time, that of finding.
    pub over_octree: f64,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct GatherReport {
    /// The device.
    pub device: String,
    /// How many there are.
    pub photons: u32,
    /// Places that ask.
    pub places: u32,
    /// Timed runs.
    pub runs: u32,
    /// By radius and finder.
    pub rows: Vec<Row>,
}

/// Why nothing can be measured.
#[derive(Debug, thiserror::Error)]
pub enum GatherError {
    /// The device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// Two ways disagree.
    #[error("the {0} finds other photons than the octree for {1} of {2} places")]
    Differs(&'static str, usize, usize),
}

/// A photon as it lies in memory.
type Words = [u32; 8];

/// Random numbers by a counter.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(1);
        let v = (self.0 ^ (self.0 >> 16)).wrapping_mul(0x7feb_352d);
        let v = (v ^ (v >> 15)).wrapping_mul(0x846c_a68b);
        ((v ^ (v >> 16)) >> 8) as f32 / (1 << 24) as f32
    }

    fn disk(&mut self) -> Vec2 {
        let (radius, turn) = (self.next().sqrt(), self.next());
        Vec2::from_angle(turn * std::f32::consts::TAU) * radius
    }

    /// A place on the floor or on the ball, and the normal there. `spread` is the radius of the spot on the floor.
    fn place(&mut self, spread: f32) -> (Vec3, Vec3) {
        match self.next() {
            kind if kind < 0.5 => {
                let place = Vec3::new(self.next() * 4.0, 0.0, self.next() * 4.0);
                (place, Vec3::Y)
            }
            kind if kind < 0.8 => {
                let place = self.disk() * spread;
                (Vec3::new(1.0 + place.x, 0.0, 1.0 + place.y), Vec3::Y)
            }
            _ => {
                let height = 2.0 * self.next() - 1.0;
                let turn = Vec2::from_angle(self.next() * std::f32::consts::TAU);
                let around = turn * (1.0 - height * height).max(0.0).sqrt();
                let normal = Vec3::new(around.x, height, around.y);
                (Vec3::new(2.5, 0.8, 2.5) + 0.5 * normal, normal)
            }
        }
    }
}

/// As `octahedral_encode` of `geometry.wgsl`.
fn octahedral(v: Vec3) -> u32 {
    let mut e = Vec2::new(v.x, v.y) / (v.x.abs() + v.y.abs() + v.z.abs());
    if v.z < 0.0 {
        e = (Vec2::ONE - Vec2::new(e.y, e.x).abs())
            * Vec2::new(1.0_f32.copysign(e.x), 1.0_f32.copysign(e.y));
    }
    let word = |x: f32| u32::from((x * 32767.0).round() as i16 as u16);
    word(e.x) | word(e.y) << 16
}

fn photons(count: u32) -> Vec<Words> {
    let mut numbers = Numbers(0);
    (0..count)
        .map(|_| {
            let (place, normal) = numbers.place(0.15);
            let [x, y, z] = place.to_array().map(f32::to_bits);
            [x, y, z, octahedral(normal), FLUX, FLUX, FLUX, 1]
        })
        .collect()
}

fn places(count: u32) -> Vec<[u32; 4]> {
    let mut numbers = Numbers(0x5eed_0000);
    (0..count)
        .map(|_| {
            let (place, normal) = numbers.place(0.3);
            let [x, y, z] = place.to_array().map(f32::to_bits);
            [x, y, z, octahedral(normal)]
        })
        .collect()
}

fn position(photon: &Words) -> Vec3 {
    Vec3::new(
        f32::from_bits(photon[0]),
        f32::from_bits(photon[1]),
        f32::from_bits(photon[2]),
    )
}

/// Photons as a left-balanced tree (Jensen, "Realistic Image Synthesis Using Photon Mapping", 2001), each with its axis.
fn as_tree(mut photons: Vec<Words>) -> Vec<Words> {
    let mut tree = vec![[0; 8]; photons.len()];
    build_tree(&mut photons, 0, &mut tree);
    tree
}

fn build_tree(photons: &mut [Words], node: usize, tree: &mut [Words]) {
    if photons.is_empty() {
        return;
    }
    let low = photons
        .iter()
        .map(position)
        .reduce(Vec3::min)
        .unwrap_or_default();
    let high = photons
        .iter()
        .map(position)
        .reduce(Vec3::max)
        .unwrap_or_default();
    let axis = (high - low).max_position();
    let middle = left_half(photons.len());
    photons.select_nth_unstable_by(middle, |a, b| {
        position(a)[axis].total_cmp(&position(b)[axis])
    });
    tree[node] = photons[middle];
    tree[node][7] |= (axis as u32) << 30;
    let (left, right) = photons.split_at_mut(middle);
    build_tree(left, 2 * node + 1, tree);
    build_tree(&mut right[1..], 2 * node + 2, tree);
}

/// How many of so many nodes are left of the root of a left-balanced tree.
fn left_half(count: usize) -> usize {
    let last_row = 1 << count.ilog2();
    let in_last_row = count + 1 - last_row;
    (last_row - 1) / 2 + in_last_row.min(last_row / 2)
}

/// What the kernels share: settings, frame, places and results.
fn shared(
    device: &Device,
    radius: f32,
    count: u32,
    places: &[[u32; 4]],
) -> Result<Resources, DeviceError> {
    let settings = PhotonSettings {
        photons: count,
        radius: radius / NEAREST,
        nearest: NEAREST,
        cell_mask: CELLS * count - 1,
        references: REFERENCES * count,
        ..PhotonSettings::zeroed()
    };
    let mut resources = Resources::default();
    let mut uniform = |name: &'static str, bytes: &[u8]| -> Result<(), DeviceError> {
        let buffer = device.filled_buffer(name, Usage::Uniform, bytes)?;
        resources.set_buffer(name, buffer);
        Ok(())
    };
    uniform("photon_settings", bytemuck::bytes_of(&settings))?;
    uniform("frame", bytemuck::bytes_of(&Frame::zeroed()))?;
    let asked = device.filled_buffer("places", Usage::Storage, bytemuck::cast_slice(places))?;
    resources.set_buffer("places", asked);
    let found = device.buffer("found", Usage::Storage, 16 * places.len() as u64)?;
    resources.set_buffer("found", found);
    for (name, bytes) in [
        ("photons", bytes_of_photons(count.into())),
        ("photons_arrived", bytes_of_photons(count.into())),
        ("photon_grid", bytes_of_grid((CELLS * count).into())),
        ("photon_cells", bytes_of_cells((CELLS * count).into())),
        ("photon_references", 4 * u64::from(REFERENCES * count)),
    ] {
        resources.set_buffer(name, device.buffer(name, Usage::Storage, bytes)?);
    }
    Ok(resources)
}

/// One way, ready to be asked.
struct Ready {
    finder: Finder,
    resources: Resources,
    kernel: BoundKernel,
    build: Vec<f64>,
    find: Vec<f64>,
}

fn write_photons(device: &Device, resources: &Resources, name: &str, photons: &[Words]) {
    let buffer = resources.buffer(name);
    let header = [photons.len() as u32, 0, 0, 0];
    device.write(buffer, 0, bytemuck::cast_slice(&header));
    device.write(buffer, 16, bytemuck::cast_slice(photons));
}

/// Dispatches of the renderer's passes.
fn record<'a>(
    device: &Device,
    resources: &Resources,
    count: u32,
    passes: impl IntoIterator<Item = &'a (&'static Pass, Each)>,
    recording: &mut Recording,
) -> Result<(), DeviceError> {
    for (pass, each) in passes {
        let kernel = pass.kernel(device, &SceneFeatures::default())?;
        let kernel = kernel.bind(device, resources);
        let threads = match each {
            Each::Photon => count,
            Each::Cell => CELLS * count,
        };
        recording.dispatch(&kernel, Extent::Threads(threads));
    }
    Ok(())
}

impl Ready {
    fn new(
        device: &Device,
        finder: Finder,
        radius: f32,
        photons: &[Words],
        places: &[[u32; 4]],
    ) -> Result<Self, DeviceError> {
        let resources = shared(device, radius, photons.len() as u32, places)?;
        let source = compose("gather/compare.wgsl");
        let kernel = source.compile(device, finder.entry(), Trust::All, &[])?;
        let kernel = kernel.bind(device, &resources);
        Ok(Self {
            finder,
            resources,
            kernel,
            build: Vec::new(),
            find: Vec::new(),
        })
    }

    /// Builds it; milliseconds.
    fn build(&mut self, device: &Device, photons: &[Words]) -> Result<(), DeviceError> {
        let milliseconds = |start: Instant| start.elapsed().as_secs_f64() * 1e3;
        let took = if self.finder == Finder::Tree {
            let start = Instant::now();
            let tree = as_tree(photons.to_vec());
            let took = milliseconds(start);
            write_photons(device, &self.resources, "photons", &tree);
            took
        } else {
            write_photons(device, &self.resources, "photons_arrived", photons);
            let octree = match self.finder {
                Finder::Octree => &OCTREE[..],
                _ => &[],
            };
            let mut recording = Recording::new("map of photons");
            recording.clear(self.resources.buffer("photon_grid"));
            let passes = GRID.iter().chain(octree);
            let count = photons.len() as u32;
            record(device, &self.resources, count, passes, &mut recording)?;
            device.wait()?;
            let start = Instant::now();
            device.play(&recording)?;
            milliseconds(start)
        };
        self.build.push(took);
        Ok(())
    }

    /// Has all places ask; what they find.
    fn find(&mut self, device: &Device, places: u32) -> Result<Vec<[u32; 4]>, DeviceError> {
        device.wait()?;
        let mut recording = Recording::new("gathering");
        recording.dispatch(&self.kernel, Extent::Threads(places));
        let start = Instant::now();
        device.play(&recording)?;
        self.find.push(start.elapsed().as_secs_f64() * 1e3);
        let bytes = device.read(self.resources.buffer("found"), 0, 16 * u64::from(places))?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}

/// Measures all ways; `progress` hears of each case that begins.
///
/// # Errors
/// The device has no room for so many, or two ways disagree.
pub fn measure(
    device: &Device,
    count: u32,
    runs: u32,
    mut progress: impl FnMut(&str),
) -> Result<GatherReport, GatherError> {
    let count = count.next_power_of_two();
    let (photons, places) = (photons(count), places(count));
    let mut rows = Vec::new();
    for radius in RADII {
        let ways = Finder::ALL.map(|finder| Ready::new(device, finder, radius, &photons, &places));
        let mut ways = ways.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut found = 0.0;
        for run in 0..=runs {
            progress(&format!("radius {radius} m, run {run} of {runs}"));
            let mut right: Option<Vec<[u32; 4]>> = None;
            for way in &mut ways {
                way.build(device, &photons)?;
                let sums = way.find(device, count)?;
                match &right {
                    None => {
                        let all: f64 = sums.iter().map(|sum| f64::from(sum[0])).sum();
                        found = all / f64::from(FLUX) / f64::from(count);
                        right = Some(sums);
                    }
                    Some(right) => {
                        let differ = right.iter().zip(&sums).filter(|(a, b)| a != b).count();
                        if differ > 0 {
                            let name = way.finder.name();
                            return Err(GatherError::Differs(name, differ, sums.len()));
                        }
                    }
                }
                if run == 0 {
                    // Kernels are compiled, and the octree doesn't know yet which cells to split.
                    (way.build, way.find) = (Vec::new(), Vec::new());
                }
            }
        }
        let of_octree = Spread::of(ways[0].find.clone()).median;
        rows.extend(ways.into_iter().map(|way| {
            let find = Spread::of(way.find);
            Row {
                radius,
                photons: found,
                finder: way.finder,
                build: Spread::of(way.build),
                find,
                over_octree: find.median / of_octree.max(1e-9),
            }
        }));
    }
    Ok(GatherReport {
        device: device.description().title(),
        photons: count,
        places: count,
        runs,
        rows,
    })
}

impl GatherReport {
    /// For people, on a terminal.
    pub fn table(&self) -> String {
        let mut text = format!(
            "{}\n{} photons, {} places that ask; medians of {} runs in turn\n\n",
            self.device, self.photons, self.places, self.runs
        );
        let _ = writeln!(
            text,
            "{:>8}  {:>8}  {:<8}  {:>9}  {:>9}  {:>11}",
            "radius", "found", "", "build ms", "find ms", "over octree"
        );
        for row in &self.rows {
            let _ = writeln!(
                text,
                "{:>8}  {:>8.1}  {:<8}  {:>9.1}  {:>9.1}  {:>11.2}",
                row.radius,
                row.photons,
                row.finder.name(),
                row.build.median,
                row.find.median,
                row.over_octree
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use device::DeviceChoice;

    #[test]
    fn trees_are_balanced_to_the_left() {
        assert_eq!(
            [1, 2, 3, 4, 5, 6, 7, 8].map(left_half),
            [0, 1, 1, 2, 3, 3, 3, 4]
        );
        let tree = as_tree(photons(100));
        // Nothing left of a node lies behind it along its axis.
        for (node, photon) in tree.iter().enumerate().skip(1) {
            let parent = (node - 1) / 2;
            let axis = (tree[parent][7] >> 30) as usize;
            let (own, other) = (position(photon)[axis], position(&tree[parent])[axis]);
            assert!(if node % 2 == 1 {
                own <= other
            } else {
                own >= other
            });
        }
    }

    #[test]
    fn all_ways_find_the_same() {
        let device = Device::open(&DeviceChoice::Native(2)).expect("the processor is there");
        let report = measure(&device, 1 << 12, 1, |_| {}).expect("they agree");
        assert_eq!(report.rows.len(), RADII.len() * Finder::ALL.len());
        assert!(report.rows[6].photons > report.rows[0].photons);
        assert!(report.table().contains("kd-tree"));
    }
}
