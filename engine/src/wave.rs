//! The memory of a wave of paths, as `rays.wgsl`, `paths.wgsl`, `wave_memory.wgsl`, `queues.wgsl` and `accumulate.wgsl`
//! lay it out.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use serde::Serialize;

use device::{Device, DeviceError, Resources, Usage};

/// `vec4u` fields of a path in `paths.wgsl`, before the results of texture programs.
const PATH_FIELDS: u64 = 6;
/// Words of the fields that follow where the film keeps parts of the light apart: `SPLIT_FIELDS` of `paths.wgsl`.
pub const SPLIT_WORDS: u32 = 12;
/// Words of the fields before those where caches of light or photons want to know of surfaces: `shared/left.wgsl`.
pub const LEFT_WORDS: u32 = 16;
/// Words of the fields behind those where there are both: `GIVEN_FIELDS` of `paths.wgsl`.
pub const GIVEN_WORDS: u32 = 12;
/// Words of the fields behind the results that a path has for photons: `photons/settings.wgsl`.
pub const PHOTON_WORDS: u32 = 8;
/// Words of a path that are there besides where the film has shadow catchers.
pub const CATCH_WORDS: u32 = 4;
/// Words of the record behind the results that a path keeps for a cache of light: `light_cache/cells.wgsl`.
pub const LIGHT_RECORD_WORDS: u32 = 8;
/// Words before the lists in `queues.wgsl`.
pub const QUEUE_HEADER: u64 = 32;
/// Lists of `capacity` words behind the header: both halves of the active list, the shadow list, and two each for the
/// texture list, the AO list and the counts of occluded AO rays, which hold hits of the paths' and of the shadow rays.
const QUEUE_LISTS: u64 = 9;
/// Queues of `queues.wgsl`, which is also the order of the dispatch sizes.
pub const QUEUE_COUNT: u64 = 4;

/// A queue whose length decides a dispatch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Queue {
    /// Paths whose ray is to be traced or shaded.
    Active = 0,
    /// Shadow rays.
    Shadow = 1,
    /// Hits with a texture program.
    Proctex = 2,
    /// Hits that want ambient occlusion.
    Ao = 3,
}

impl Queue {
    /// Where the number of entries for its consumers lies in the buffer `queues`, in bytes.
    pub fn length_offset(self) -> u64 {
        (2 * self as u64 + 1) * 4
    }

    /// Where its dispatch size lies in the buffer `dispatch_sizes`.
    pub fn dispatch_offset(self) -> u64 {
        self as u64 * 12
    }
}

/// `RayHit` in `rays.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct RayHit {
    /// World position, metres.
    pub origin: Vec3,
    /// Nearest distance that counts.
    pub t_min: f32,
    /// Unit direction.
    pub direction: Vec3,
    /// Farthest distance that counts; the hit's distance once traced.
    pub t_max: f32,
    /// Weights of the triangle's second and third vertex.
    pub barycentrics: Vec2,
    /// Triangle in the hierarchy's order, or [`RayHit::MISS`].
    pub triangle: u32,
    /// Instance in the hierarchy's order.
    pub instance: u32,
}

impl RayHit {
    /// No triangle was hit.
    pub const MISS: u32 = u32::MAX;

    /// A ray to be traced.
    pub fn new(origin: Vec3, direction: Vec3, t_max: f32) -> Self {
        Self {
            origin,
            t_min: 0.0,
            direction,
            t_max,
            barycentrics: Vec2::ZERO,
            triangle: Self::MISS,
            instance: 0,
        }
    }
}

/// One AO table of `ao_tables.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct GpuAoTable {
    /// Metres.
    pub distance: f32,
    /// 0 outside, 1 inside, 2 both.
    pub direction: u32,
    /// Rays per hit; 0 for an unused table.
    pub samples: u32,
    /// 1: only the hit's own instance occludes.
    pub same_object: u32,
}

/// GPU memory of one path of a wave, bytes by what it is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct PathBytes {
    /// Throughput, radiance, waiting light and what else is kept from vertex to vertex.
    pub state: u64,
    /// Results of its texture program.
    pub results: u64,
    /// Its own ray and its shadow ray, each with what it hit.
    pub rays: u64,
    /// Its places in the queues.
    pub queues: u64,
}

impl PathBytes {
    /// With room for so many words of results.
    pub fn new(result_words: u32) -> Self {
        Self {
            state: 16 * PATH_FIELDS,
            results: 16 * u64::from(result_words.div_ceil(4)),
            rays: 2 * size_of::<RayHit>() as u64,
            queues: 4 * QUEUE_LISTS,
        }
    }

    /// All of it.
    pub fn total(&self) -> u64 {
        self.state + self.results + self.rays + self.queues
    }
}

/// Bytes of the paths' state.
fn path_bytes(capacity: u32, result_words: u32) -> u64 {
    let path = PathBytes::new(result_words);
    u64::from(capacity) * (path.state + path.results)
}

/// Makes room for results of so many words where there is too little; true if there was.
///
/// # Errors
/// If it exceeds what the device can bind.
pub fn grow_results(
    device: &Device,
    capacity: u32,
    result_words: u32,
    resources: &mut Resources,
) -> Result<bool, DeviceError> {
    let bytes = path_bytes(capacity, result_words);
    if resources.buffer("paths").size() >= bytes {
        return Ok(false);
    }
    let paths = device.buffer("paths", Usage::Storage, bytes)?;
    resources.set_buffer("paths", paths);
    Ok(true)
}

/// Creates the buffers of a wave of `capacity` paths, each with `result_words` for the results of texture programs.
///
/// # Errors
/// If they exceed what the device can bind.
pub fn allocate(
    device: &Device,
    capacity: u32,
    result_words: u32,
    resources: &mut Resources,
) -> Result<(), DeviceError> {
    let paths = path_bytes(capacity, result_words);
    let paths = device.buffer("paths", Usage::Storage, paths)?;
    resources.set_buffer("paths", paths);
    let capacity = u64::from(capacity);
    let rays = 2 * capacity * size_of::<RayHit>() as u64;
    resources.set_buffer("rays", device.buffer("rays", Usage::Storage, rays)?);
    let queues = (QUEUE_HEADER + capacity * QUEUE_LISTS) * 4;
    resources.set_buffer("queues", device.buffer("queues", Usage::Storage, queues)?);
    let sizes = device.buffer("dispatch sizes", Usage::Indirect, QUEUE_COUNT * 12)?;
    resources.set_buffer("dispatch_sizes", sizes);
    allocate_ao_tables(device, resources)
}

/// Creates what is recorded of each path of a wave for the film's layers: so many words, as `film_layers/samples.wgsl` lays
/// them out. Nothing where there are none.
///
/// # Errors
/// If they exceed what the device can bind.
pub fn allocate_layer_samples(
    device: &Device,
    capacity: u32,
    words: u32,
    resources: &mut Resources,
) -> Result<(), DeviceError> {
    if words > 0 {
        let bytes = 4 * u64::from(capacity) * u64::from(words);
        let samples = device.buffer("layers of a wave", Usage::Storage, bytes)?;
        resources.set_buffer("layer_samples", samples);
    }
    Ok(())
}

/// Creates the uniform that says where the values of layers lie among these words.
///
/// # Errors
/// The device.
pub fn allocate_layer_words(
    device: &Device,
    words: &[u32],
    resources: &mut Resources,
) -> Result<(), DeviceError> {
    let bytes = bytemuck::cast_slice(words);
    let words = device.filled_buffer("words of layers", Usage::Uniform, bytes)?;
    resources.set_buffer("layer_words", words);
    Ok(())
}

/// Creates the uniform with the AO tables.
///
/// # Errors
/// The device.
pub fn allocate_ao_tables(device: &Device, resources: &mut Resources) -> Result<(), DeviceError> {
    let bytes = 4 * size_of::<GpuAoTable>() as u64;
    let tables = device.buffer("AO tables", Usage::Uniform, bytes)?;
    resources.set_buffer("ao_tables", tables);
    Ok(())
}

/// Words that start a wave: all queues empty, and the bounce before the first.
pub fn fresh_queues() -> [u32; 9] {
    let mut words = [0; 9];
    words[8] = u32::MAX;
    words
}

/// Words of the header that tell what is wrong with a picture, by ranges: they begin anew with each.
const FAULTS: [std::ops::Range<u64>; 3] = [11..13, 15..16, 20..23];

/// Forgets what was wrong with the picture.
pub fn clear_faults(device: &Device, resources: &Resources) {
    for words in FAULTS {
        let zeros = vec![0_u32; (words.end - words.start) as usize];
        let queues = resources.buffer("queues");
        device.write(queues, 4 * words.start, bytemuck::cast_slice(&zeros));
    }
}

/// Words of the header from the first total on: what [`Totals`] is made of.
pub const TOTALS: std::ops::Range<u64> = 9..QUEUE_HEADER;

/// Where the list of hits with a texture program begins in the buffer `queues`, in bytes.
pub fn proctex_list(capacity: u32) -> u64 {
    4 * (QUEUE_HEADER + 3 * u64::from(capacity))
}

/// Where the states of the paths begin in the buffer `paths`, in bytes: `PATH_STATE`, whose first word is the material after
/// blends.
pub fn state_field(capacity: u32) -> u64 {
    16 * 3 * u64::from(capacity)
}

/// Totals that the kernels keep in the header of the queues.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Totals {
    /// Path and shadow rays.
    pub rays: u64,
    /// Of these, shadow rays.
    pub shadow_rays: u64,
    /// Ambient-occlusion rays.
    pub ao_rays: u64,
    /// Samples that were not finite.
    pub invalid: u64,
    /// Samples beyond the film's range.
    pub clamped: u64,
    /// Type number of a texture whose loops were ended early.
    pub overrun: Option<u32>,
    /// Hits whose texture program drove something by a value that was not finite.
    pub non_finite: u64,
    /// Where the arguments of a node that gave one begin in the fake stack.
    pub non_finite_node: Option<u32>,
}

impl Totals {
    /// From the header's words.
    pub fn new(words: &[u32]) -> Self {
        let pair = |i: usize| u64::from(words[i]) | u64::from(words[i + 1]) << 32;
        Self {
            rays: pair(9),
            shadow_rays: pair(16),
            // Asked for, less those that needn't be traced.
            ao_rays: pair(13).saturating_sub(pair(18)),
            invalid: u64::from(words[15]),
            clamped: u64::from(words[12]),
            overrun: words[11].checked_sub(1),
            non_finite: pair(20),
            non_finite_node: words[22].checked_sub(1),
        }
    }

    /// Of a wave's memory.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn read(device: &Device, resources: &Resources) -> Result<Self, DeviceError> {
        let bytes = device.read(resources.buffer("queues"), 0, QUEUE_HEADER * 4)?;
        Ok(Self::new(&bytemuck::pod_collect_to_vec::<_, u32>(&bytes)))
    }

    /// Adds those of another wave's memory.
    pub fn add(&mut self, other: &Self) {
        self.rays += other.rays;
        self.shadow_rays += other.shadow_rays;
        self.ao_rays += other.ao_rays;
        self.invalid += other.invalid;
        self.clamped += other.clamped;
        self.overrun = self.overrun.or(other.overrun);
        self.non_finite += other.non_finite;
        self.non_finite_node = self.non_finite_node.or(other.non_finite_node);
    }

    /// Without what is wrong with a picture.
    pub fn without_faults(self) -> Self {
        Self {
            rays: self.rays,
            shadow_rays: self.shadow_rays,
            ao_rays: self.ao_rays,
            ..Self::new(&[0; QUEUE_HEADER as usize])
        }
    }
}
