//! What is found out about the light before the picture begins, and anew as it [grows](self::growth): where the sky is seen, what
//! surfaces scatter ([`light_cache`](super::light_cache)), and, where the method has records of irradiance, how these are found and made.
//!
//! Light that surfaces scatter to a place changes slowly from place to place, so it is gathered at few of them with many rays, and
//! interpolated between those (Ward, Rubinstein and Clear, "A Ray Tracing Solution for Diffuse Interreflection", 1988). What the first
//! surfaces look like, and what lamps and the sky do to them, is sampled for each pixel as ever.
//!
//! All records of a pass are found and made at once, without one knowing of the other (after Frolov et al., "Implementing Irradiance Cache
//! in a GPU Realistic Renderer", 2013). Paths of one sample of each pixel end where a surface scatters diffusely. What no record
//! covers there are candidates; of these some are kept, at a distance that halves from pass to pass. From each of them rays go to all
//! sides, as a wave of paths. They end in the cache of scattered light that has been taught before, or go on as paths do.
//!
//! Radii follow the harmonic mean of the distances to what a record sees, and how steeply its light changes; they shrink where a
//! neighbour has found something closer, and where many records overlap. In the end what records differ by from their neighbours is taken out
//! of them as far as it is noise ([`smooth`](self::smooth)).
//!
//! Where the picture's samples come in halves, so do the rays of records, as what they end in does: a record knows what each half has found, and
//! gives either to the half of the samples that it is for. Else all samples would share its noise, and the picture wouldn't know of it.

mod grid;
mod growth;
mod openings;
mod records;
mod sky;
mod smooth;

use bytemuck::{Pod, Zeroable};
use device::{Device, DeviceError, Extent, Kernel, Recording, Resources, Usage};

use crate::{
    frame::BLOCK_PIXELS,
    gpu_scene::SceneFeatures,
    passes::irradiance,
    settings::{Method, RenderSettings},
};

use super::{Purpose, RenderError, Renderer, Work, clear_picture};

use self::grid::{Grid, Reference, Slot, sort_along_the_curve};
use self::records::{Candidate, REACH, Record, calm, settle, spread_out};
use self::sky::{Lamps, Sky};
use self::smooth::smooth;

/// Most records.
const RECORDS: u32 = 1 << 17;
/// Most candidates of a pass.
const CANDIDATES: u32 = 1 << 17;
/// Most slots of the grid, a power of two, and references.
const SLOTS: u32 = 1 << 19;
const REFERENCES: u32 = 1 << 21;
/// Rings and sectors of a record's gather rays at a time.
const STRATA: [u32; 2] = [12, 40];
/// The same where records are at most so many pixels apart: what one of them is wrong by is seen less than what a large one is.
const FEWER_STRATA: [u32; 2] = [8, 24];
const FEWER_BELOW: f32 = 5.0;
/// Both where turns come in halves, twice as many as else.
const STRATA_OF_HALVES: [u32; 2] = [8, 30];
const FEWER_STRATA_OF_HALVES: [u32; 2] = [6, 16];
/// How often they are gathered for each record, at most, and rays of all records for each pixel until which it is more than once.
const MOST_TURNS: u32 = 4;
const RAYS_OF_PIXEL: u64 = 64;
/// A smaller picture has rays as if it had so many pixels.
const LEAST_PIXELS: u64 = 1 << 15;
/// Records whose rays are gathered at once, on devices that want more paths in a wave for so many of these as one record.
const AT_ONCE: [u32; 2] = [2048, 8192];
const PATHS_OF_RECORD: u32 = 512;
/// Pixels between new records, pass by pass.
const DISTANCES: [f32; 7] = [24.0, 12.0, 6.0, 3.0, 2.0, 2.0, 2.0];
/// Samples of each pixel that teach the cache of scattered light in larger pictures, which have more rays for records: these share what it
/// is wrong by. So many times the usual paths at most.
const SAMPLES_AHEAD: u32 = 8;
/// The same where there are no records, and more is learned soon.
const SAMPLES_AHEAD_WITHOUT_RECORDS: u32 = 4;
/// Where there are no records one path goes ahead for so many with them: what cells are wrong about isn't seen as blotches.
const LESS_AHEAD: u32 = 4;
/// One path goes ahead to look where the sky is seen for so many that teach the cache of scattered light, which look for it, too.
const LOOKED_SHARE: u32 = 4;
/// Candidates within the distance of each other, about.
const CROWD: f32 = 12.0;
/// Added to the picture's seed: what makes the cache has other random numbers than what uses it.
const SEED: u32 = 0x1a2b_3c4d;
/// Radius of a record over the harmonic mean of the distances to what it sees: Ward's error bound of about as much (Ward and
/// Heckbert 1992), less where records are used up to twice as far.
const RADIUS_SHARE: f32 = 0.05;
/// The gradient may change the irradiance by so much of it within the radius.
const MOST_CHANGE: f32 = 0.1;

/// `IrradianceSettings` of `settings.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Settings {
    mode: u32,
    first_record: u32,
    end_record: u32,
    candidates: u32,
    mask: u32,
    first_level: i32,
    levels: u32,
    falloff: f32,
    share: f32,
    gather: u32,
    radius_share: f32,
    most_change: f32,
    photons: u32,
    turn: u32,
    turns: u32,
    rings: u32,
    sectors: u32,
    points: u32,
    left: f32,
    solved: u32,
}

/// How often what a record says that is better left to paths is left to them, by how often more has been learned: their noise is the larger error
/// in a short picture, what lies between records in a long one.
const LEFT_TO_PATHS: [f32; 4] = [0.0, 0.0, 0.5, 1.0];

/// What has been gathered when records are made: as in `settings.wgsl`.
const SOLVE_WHOLE: u32 = 0;
const SOLVE_FIRST_HALF: u32 = 1;
const SOLVE_HALVES: u32 = 2;

/// What paths do with the cache: as in `settings.wgsl`.
const IDLE: u32 = 0;
const FIND: u32 = 1;
const USE: u32 = 2;

/// What is being done.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// It is found out where the sky is seen: by which openings, then how much of it through each. Paths of one of both so far.
    Looking(Look, u64),
    /// The cache of scattered light learns; whether from paths that end in what it has learned before, and how many so far.
    Learning(bool, u64),
    /// Candidates of a pass are found; paths so far.
    Finding(usize, u64),
    /// Rays of a pass's records are gathered: those of the ones from here on are left, of which so many are done.
    Gathering(u32, u64),
    /// The picture may begin.
    Ready,
}

/// What paths look for that go ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Look {
    Openings,
    Sky,
}

/// What is known of the records of a pass.
#[derive(Debug, Clone, Copy, Default)]
struct Pass {
    /// Behind the last of them.
    end: u32,
    /// How often rays have been gathered for them, former ones among these.
    turns: u32,
}

/// What a renderer knows.
#[derive(Debug)]
pub(super) struct Irradiance {
    phase: Phase,
    /// In the order of their passes, with the noise of their rays.
    records: Vec<Record>,
    passes: [Pass; DISTANCES.len()],
    /// The one whose rays are gathered, how often that is, and the rays that all records so far are made of.
    pass: usize,
    turns: u32,
    rays: u64,
    /// Records whose rays are gathered at once.
    at_once: u32,
    /// How often more has been learned since the picture began.
    steps: u32,
    first_level: i32,
    levels: u32,
    /// Slots of the grid less one.
    mask: u32,
    falloff: f32,
    /// Whether the rays of records come in two halves, as the picture's samples do.
    has_halves: bool,
    sky: Sky,
    /// None where the method has no records.
    solve: Option<Kernel>,
}

/// Records whose rays are gathered at once on a device. What they find doesn't depend on it.
fn at_once(device: &Device) -> u32 {
    let [least, most] = AT_ONCE;
    (device.traits().waves.most / PATHS_OF_RECORD).clamp(least, most)
}

/// Its buffers, and their bytes.
fn buffers(at_once: u32) -> [(&'static str, u64); 5] {
    let references = u64::from(REFERENCES) * size_of::<Reference>() as u64;
    [
        (
            "irradiance_records",
            u64::from(RECORDS) * size_of::<Record>() as u64,
        ),
        (
            "irradiance_grid",
            u64::from(SLOTS) * size_of::<Slot>() as u64,
        ),
        ("irradiance_references", references),
        ("irradiance_candidates", 32 * (u64::from(CANDIDATES) + 1)),
        (
            "irradiance_gathered",
            16 * u64::from(at_once * rays_of(STRATA)),
        ),
    ]
}

/// Rays of so many rings and sectors.
fn rays_of([rings, sectors]: [u32; 2]) -> u32 {
    rings * sectors
}

/// Bytes of its buffers.
pub(super) fn bytes(device: &Device, method: Method) -> u64 {
    let buffers = buffers(at_once(device));
    let of_records = buffers.iter().map(|(_, bytes)| bytes).sum::<u64>();
    match (method.has_light_cache(), method.has_records()) {
        (false, _) => 0,
        (true, false) => sky::BYTES,
        (true, true) => sky::BYTES + of_records,
    }
}

impl Irradiance {
    /// Makes its buffers; nothing where the method needs none.
    pub(super) fn new(
        device: &Device,
        render: &RenderSettings,
        features: &SceneFeatures,
        resources: &mut Resources,
    ) -> Result<Option<Self>, DeviceError> {
        let method = render.method;
        if !method.has_light_cache() {
            return Ok(None);
        }
        let at_once = at_once(device);
        let mut solve = None;
        if method.has_records() {
            for (name, bytes) in buffers(at_once) {
                resources.set_buffer(name, device.buffer(name, Usage::Storage, bytes)?);
            }
            let bytes = size_of::<Settings>() as u64;
            let settings = device.buffer("irradiance settings", Usage::Uniform, bytes)?;
            resources.set_buffer("irradiance_settings", settings);
            solve = Some(irradiance::SOLVE.kernel(device, features)?);
        }
        Ok(Some(Self {
            phase: Phase::Looking(Look::Openings, 0),
            records: Vec::new(),
            passes: [Pass::default(); DISTANCES.len()],
            pass: 0,
            turns: 1,
            rays: 0,
            at_once,
            steps: 0,
            first_level: 0,
            levels: 0,
            mask: 0,
            falloff: 1.0,
            has_halves: render.halves,
            sky: Sky::new(device, resources)?,
            solve,
        }))
    }

    /// Whether there are records of irradiance, or only what they would be made of.
    fn has_records(&self) -> bool {
        self.solve.is_some()
    }

    /// Forgets all of it.
    pub(super) fn restart(&mut self) {
        self.phase = Phase::Looking(Look::Openings, 0);
        self.records.clear();
        self.passes = [Pass::default(); DISTANCES.len()];
        self.levels = 0;
        self.rays = 0;
        self.steps = 0;
    }

    /// Where the records of a pass begin.
    fn first(&self, pass: usize) -> u32 {
        pass.checked_sub(1)
            .map_or(0, |before| self.passes[before].end)
    }

    /// Rays of all records of a pass, each gathered once.
    fn rays_once(&self, pass: usize) -> u64 {
        let records = self.passes[pass].end - self.first(pass);
        u64::from(rays_of(self.strata(pass))) * u64::from(records)
    }

    /// Rings and sectors of the records of a pass.
    fn strata(&self, pass: usize) -> [u32; 2] {
        match (DISTANCES[pass] > FEWER_BELOW, self.has_halves) {
            (true, false) => STRATA,
            (true, true) => STRATA_OF_HALVES,
            (false, false) => FEWER_STRATA,
            (false, true) => FEWER_STRATA_OF_HALVES,
        }
    }

    /// Halves that the rays of a record come in.
    fn halves(&self) -> u32 {
        1 + u32::from(self.has_halves)
    }

    /// How often rays are gathered, as often for either half, where there is one after all; `once`: rays of one turn.
    fn turns_for(&self, rays: u64, once: u64) -> u32 {
        let halves = self.halves();
        let of_half = rays / (u64::from(halves) * once);
        halves * of_half.clamp(1, 1 << 20) as u32
    }

    /// Has rays of a pass's records gathered, so many times.
    fn begin_gathering(&mut self, pass: usize, turns: u32) -> Phase {
        (self.pass, self.turns) = (pass, turns);
        self.rays += self.rays_once(pass) * u64::from(turns);
        Phase::Gathering(self.first(pass), 0)
    }

    /// Has the picture made with the records as they are now, but for their noise.
    fn finish(&mut self, device: &Device, resources: &Resources) -> Phase {
        let mut records = self.records.clone();
        sort_along_the_curve(&mut records);
        let grid = Grid::of(&records, REACH, SLOTS, REFERENCES as usize);
        calm(&mut records, &grid);
        smooth(&mut records, SLOTS, REFERENCES as usize);
        self.find_by(device, resources, &records, &grid, 1.0 / REACH);
        Phase::Ready
    }

    /// Has the device find records by a grid of them; `falloff` is one over how far they reach in it.
    fn find_by(
        &mut self,
        device: &Device,
        resources: &Resources,
        records: &[Record],
        grid: &Grid,
        falloff: f32,
    ) {
        let write = |name: &str, bytes: &[u8]| device.write(resources.buffer(name), 0, bytes);
        write("irradiance_records", bytemuck::cast_slice(records));
        write("irradiance_grid", bytemuck::cast_slice(&grid.slots));
        if !grid.references.is_empty() {
            write(
                "irradiance_references",
                bytemuck::cast_slice(&grid.references),
            );
        }
        (self.first_level, self.levels) = (grid.first_level, grid.levels);
        self.mask = grid.slots.len() as u32 - 1;
        self.falloff = falloff;
    }
}

impl Renderer {
    /// Records of irradiance that there are, or are being made, while the picture waits for what is found out about the light; None while
    /// it goes on.
    pub fn records_awaited(&self) -> Option<usize> {
        let cache = self.irradiance.as_ref().filter(|_| !self.is_apart)?;
        (cache.phase != Phase::Ready).then_some(cache.records.len())
    }

    /// Whether the film has none of the picture's samples yet, but those that go ahead of it: to be looked at, not to be gone on with.
    pub fn is_preview(&self) -> bool {
        self.records_awaited().is_some() && !self.is_begun()
    }

    /// Whether the film has samples of the picture already.
    pub(super) fn is_begun(&self) -> bool {
        self.position > 0 || self.rendered > 0
    }

    /// To which half of the rays those of a turn belong.
    pub(super) fn half_of_turn(&self, turn: u32) -> u32 {
        let turns = self.irradiance.as_ref().map_or(0, |cache| cache.turns);
        u32::from(2 * turn >= turns)
    }

    /// Takes a step towards what a sample of the picture is made with; false where it is there, or isn't needed.
    pub(super) fn prepare_irradiance(&mut self, sample: u32) -> Result<bool, RenderError> {
        let Some(phase) = self.irradiance.as_ref().map(|cache| cache.phase) else {
            return Ok(false);
        };
        if self.is_apart || self.knows_whole() {
            return Ok(false);
        }
        let next = match phase {
            Phase::Ready => match self.grow(sample)? {
                Some(phase) => phase,
                None => return Ok(false),
            },
            Phase::Looking(look, done) => self.look_for_sky(look, done)?,
            Phase::Learning(ends, done) => {
                let (first_sample, samples) = self.samples_to_learn(ends);
                let (done, is_last) = match samples {
                    0 => (0, true),
                    _ => self.prepare_wave(Purpose::Learn { ends }, done, first_sample, samples)?,
                };
                match (is_last, ends) {
                    (false, _) => Phase::Learning(ends, done),
                    (true, false) => Phase::Learning(true, 0),
                    (true, true) => self.after_learning(sample)?,
                }
            }
            Phase::Finding(pass, done) => {
                if done == 0 {
                    let candidates = self.resources.buffer("irradiance_candidates");
                    self.device.write(candidates, 0, &[0; 4]);
                }
                let first_sample = self.samples_ahead() + pass as u32;
                let (done, is_last) =
                    self.prepare_wave(Purpose::Find(pass), done, first_sample, 1)?;
                match is_last {
                    false => Phase::Finding(pass, done),
                    true => self.begin_records(pass)?,
                }
            }
            Phase::Gathering(from, done) => self.gather(from, done)?,
        };
        if next == Phase::Ready && !self.is_begun() {
            clear_picture(&self.device, &self.settings, &self.resources)?;
        }
        if let Some(cache) = &mut self.irradiance {
            cache.phase = next;
        }
        Ok(true)
    }

    /// Samples of each pixel of which the caches learn, and by which it is found out where the sky is seen.
    fn samples_ahead(&self) -> u32 {
        let pixels = self.frame.padded_pixels;
        let paths_ahead = self.settings.paths_ahead;
        let (usual, samples) = match self.settings.method.has_records() {
            true => (paths_ahead, SAMPLES_AHEAD),
            false => (paths_ahead / LESS_AHEAD, SAMPLES_AHEAD_WITHOUT_RECORDS),
        };
        let paths = usual.max(samples.saturating_mul(usual.min(pixels)));
        paths.div_ceil(pixels).max(1)
    }

    /// Finds out where the sky is seen, of which so many paths are done.
    fn look_for_sky(&mut self, look: Look, done: u64) -> Result<Phase, RenderError> {
        if !self.scene.environment.emits {
            return Ok(Phase::Learning(false, 0));
        }
        let Some(cache) = &mut self.irradiance else {
            return Ok(Phase::Ready);
        };
        if (look, done) == (Look::Openings, 0) {
            cache.sky.begin(&self.device, &self.resources)?;
        }
        let all = self.samples_ahead().div_ceil(LOOKED_SHARE);
        let for_openings = all.div_ceil(2);
        let first_sample = self.samples_ahead() + DISTANCES.len() as u32;
        let (first_sample, samples) = match look {
            Look::Openings => (first_sample, for_openings),
            Look::Sky => (first_sample + for_openings, all - for_openings),
        };
        let (done, is_last) = match samples {
            0 => (0, true),
            _ => self.prepare_wave(Purpose::Look, done, first_sample, samples)?,
        };
        if !is_last {
            return Ok(Phase::Looking(look, done));
        }
        if look == Look::Openings
            && let Some(cache) = &mut self.irradiance
        {
            let bounds = self.frame.bounds();
            cache
                .sky
                .find_openings(&self.device, &self.resources, bounds)?;
        }
        self.learn_sky()?;
        self.frame.set_known_sky(true);
        Ok(match look {
            Look::Openings => Phase::Looking(Look::Sky, 0),
            Look::Sky => Phase::Learning(false, 0),
        })
    }

    /// Has light samples of the sky go by what has been counted so far.
    fn learn_sky(&self) -> Result<(), RenderError> {
        let environment = &self.scene.environment;
        if let Some(cache) = self.irradiance.as_ref().filter(|_| environment.emits) {
            let lamps = Lamps {
                share_of_sky: self.frame.environment_probability().into(),
                are_far: self.scene.is_lit_from_afar(),
            };
            cache
                .sky
                .learn(&self.device, &self.resources, environment, lamps)?;
        }
        Ok(())
    }

    /// Renders a wave of samples of all pixels, of which so many paths are done; how many are done then, and whether these are all.
    fn prepare_wave(
        &mut self,
        purpose: Purpose,
        done: u64,
        first_sample: u32,
        samples: u32,
    ) -> Result<(u64, bool), RenderError> {
        let mut frame = self.frame;
        frame.set_seed(frame.seed().wrapping_add(SEED));
        let total = u64::from(samples) * u64::from(self.frame.padded_pixels);
        if let Some((blocks, samples)) = self.burst_ahead(done, first_sample, samples) {
            frame.set_lot(&blocks, samples);
            let work = Work::Lot {
                blocks: &blocks,
                samples,
            };
            self.play_wave(&frame, work, purpose)?;
            let done = done + blocks.len() as u64 * u64::from(samples * BLOCK_PIXELS);
            return Ok((done, done == total));
        }
        let paths = u64::from(self.next_wave_size()).min(total - done);
        frame.set_wave(done, paths as u32, first_sample, samples);
        let work = Work::Range {
            position: done,
            first_sample,
            spp: samples,
        };
        self.play_wave(&frame, work, purpose)?;
        Ok((done + paths, done + paths == total))
    }

    /// Makes records of a pass's candidates, whose rays are to be gathered next.
    fn begin_records(&mut self, pass: usize) -> Result<Phase, RenderError> {
        let buffer = self.resources.buffer("irradiance_candidates");
        let count: u32 = bytemuck::pod_read_unaligned(&self.device.read(buffer, 0, 4)?);
        let count = count.min(CANDIDATES);
        let candidates: Vec<Candidate> = match count {
            0 => Vec::new(),
            _ => bytemuck::pod_collect_to_vec(&self.device.read(
                buffer,
                32,
                32 * u64::from(count),
            )?),
        };
        let Some(cache) = &mut self.irradiance else {
            return Ok(Phase::Ready);
        };
        let first = cache.records.len() as u32;
        let room = (RECORDS - first) as usize;
        let mut begun = spread_out(candidates, DISTANCES[pass]);
        begun.truncate(room);
        sort_along_the_curve(&mut begun);
        cache.records.extend(begun);
        cache.passes[pass].end = cache.records.len() as u32;
        if cache.records.len() as u32 == first {
            return Ok(self.next_pass(pass));
        }
        let once = cache.rays_once(pass);
        let pixels = u64::from(self.frame.padded_pixels).max(LEAST_PIXELS);
        let left = (RAYS_OF_PIXEL * pixels).saturating_sub(cache.rays);
        let turns = cache.turns_for(left, once).min(MOST_TURNS * cache.halves());
        let records = self.resources.buffer("irradiance_records");
        self.device
            .write(records, 0, bytemuck::cast_slice(&cache.records));
        Ok(cache.begin_gathering(pass, turns))
    }

    /// What comes after a pass.
    fn next_pass(&mut self, pass: usize) -> Phase {
        let Some(cache) = &mut self.irradiance else {
            return Phase::Ready;
        };
        let is_last = pass + 1 == DISTANCES.len() || cache.records.len() as u32 == RECORDS;
        settle(&mut cache.records, SLOTS, REFERENCES as usize);
        for later in &mut cache.passes[pass..] {
            later.end = cache.records.len() as u32;
        }
        if is_last {
            return cache.finish(&self.device, &self.resources);
        }
        let records = std::mem::take(&mut cache.records);
        let grid = Grid::of(&records, 1.0, SLOTS, REFERENCES as usize);
        cache.find_by(&self.device, &self.resources, &records, &grid, 1.0);
        cache.records = records;
        Phase::Finding(pass + 1, 0)
    }

    /// Gathers rays of the records from `from` on, turn after turn, of which so many are done.
    fn gather(&mut self, from: u32, done: u64) -> Result<Phase, RenderError> {
        let Some(cache) = &self.irradiance else {
            return Ok(Phase::Ready);
        };
        let pass = cache.pass;
        let known = &cache.passes[pass];
        let last = known.end;
        let end = last.min(from + cache.at_once);
        let turns = u64::from(cache.turns);
        let of_record = u64::from(rays_of(cache.strata(pass)));
        let of_turn = of_record * u64::from(end - from);
        let (turn, position) = ((done / of_turn) as u32, done % of_turn);
        let half_of_turns = cache.has_halves.then_some(of_turn * turns / 2);
        let rays = u64::from(self.next_wave_size()).min(of_turn - position);
        let mut frame = self.frame;
        let number = (known.turns + turn).wrapping_mul(0x9e37_79b9);
        let number = number.wrapping_add(1);
        frame.set_seed(frame.seed().wrapping_add(SEED ^ number));
        // Numbered among those of all records, so that random numbers don't depend on how many are made at once.
        let position = of_record * u64::from(from) + position;
        frame.set_wave(position, rays as u32, 0, u32::MAX);
        let work = Work::Range {
            position,
            first_sample: 0,
            spp: u32::MAX,
        };
        let purpose = Purpose::Gather {
            first: from,
            end,
            turn,
        };
        self.play_wave(&frame, work, purpose)?;
        let done = done + rays;
        if half_of_turns == Some(done) {
            self.play_solve(from, end, turn)?;
        }
        if done < of_turn * turns {
            return Ok(Phase::Gathering(from, done));
        }
        self.solve(from, end)?;
        if end < last {
            return Ok(Phase::Gathering(end, 0));
        }
        let Some(cache) = &mut self.irradiance else {
            return Ok(Phase::Ready);
        };
        cache.passes[pass].turns += cache.turns;
        Ok(match cache.steps {
            0 => self.next_pass(pass),
            _ => cache.gather_again(pass + 1, &self.device, &self.resources),
        })
    }

    /// Has the device make records of what has been gathered for them in so many turns: of the first half of them only what the records will
    /// know of that.
    fn play_solve(&self, first: u32, end: u32, turn: u32) -> Result<(), RenderError> {
        self.set_irradiance(Purpose::Gather { first, end, turn });
        let Some(kernel) = self
            .irradiance
            .as_ref()
            .and_then(|cache| cache.solve.as_ref())
        else {
            return Ok(());
        };
        let kernel = kernel.bind(&self.device, &self.resources);
        let mut recording = Recording::new("records of irradiance");
        recording.dispatch(&kernel, Extent::Threads(end - first));
        Ok(self.device.play(&recording)?)
    }

    /// Makes records of what has been gathered for them.
    fn solve(&mut self, first: u32, end: u32) -> Result<(), RenderError> {
        let Some(turns) = self.irradiance.as_ref().map(|cache| cache.turns) else {
            return Ok(());
        };
        self.play_solve(first, end, turns)?;
        let Some(cache) = &mut self.irradiance else {
            return Ok(());
        };
        let size = size_of::<Record>() as u64;
        let buffer = self.resources.buffer("irradiance_records");
        let bytes = u64::from(end - first) * size;
        let bytes = self.device.read(buffer, u64::from(first) * size, bytes)?;
        let mut solved: Vec<Record> = bytemuck::pod_collect_to_vec(&bytes);
        let records = &mut cache.records[first as usize..end as usize];
        if cache.steps > 0 {
            // How far they reach is settled.
            for (solved, former) in solved.iter_mut().zip(&*records) {
                solved.radius = former.radius;
            }
        }
        records.copy_from_slice(&solved);
        Ok(())
    }

    /// Says what the next wave does with the cache.
    pub(super) fn set_irradiance(&self, purpose: Purpose) {
        let Some(cache) = self.irradiance.as_ref().filter(|cache| cache.has_records()) else {
            return;
        };
        let (mode, share) = match purpose {
            Purpose::Picture => (USE, 0.0),
            Purpose::Find(pass) => (FIND, self.share_of(DISTANCES[pass])),
            _ => (IDLE, 0.0),
        };
        let [first_record, end_record, turn] = match purpose {
            Purpose::Gather { first, end, turn } => [first, end, turn],
            _ => [0; 3],
        };
        let solved = match (cache.has_halves, turn < cache.turns) {
            (false, _) => SOLVE_WHOLE,
            (true, true) => SOLVE_FIRST_HALF,
            (true, false) => SOLVE_HALVES,
        };
        // What is wrong between records grows with the square of their radii.
        let finer = 0.5_f32.sqrt().powi(self.settings.refinement.min(20) as i32);
        let words = Settings {
            mode,
            first_record,
            end_record,
            candidates: CANDIDATES,
            mask: cache.mask,
            first_level: cache.first_level,
            levels: cache.levels,
            falloff: cache.falloff,
            share,
            gather: self.light_record(),
            radius_share: RADIUS_SHARE * finer,
            most_change: MOST_CHANGE * finer,
            photons: self.photon_field(purpose),
            turn,
            turns: cache.turns,
            rings: cache.strata(cache.pass)[0],
            sectors: cache.strata(cache.pass)[1],
            points: self.frame.seed() ^ grid::hash(cache.passes[cache.pass].turns),
            left: LEFT_TO_PATHS[(cache.steps as usize).min(LEFT_TO_PATHS.len() - 1)],
            solved,
        };
        let uniform = self.resources.buffer("irradiance_settings");
        self.device.write(uniform, 0, bytemuck::bytes_of(&words));
    }

    /// Of the places that no record covers, those that become candidates, where new records are to be so many pixels apart: a few for
    /// each record, and no more than there is room for.
    fn share_of(&self, distance: f32) -> f32 {
        let pixels = self.frame.pixels() as f32;
        (CROWD / (distance * distance))
            .min(0.9 * CANDIDATES as f32 / pixels)
            .min(1.0)
    }

    /// Has the picture begin anew with finer records, by [`RenderSettings::refinement`](crate::settings::RenderSettings::refinement).
    pub fn refine(&mut self) {
        self.settings.refinement += 1;
        self.restart();
    }

    /// How many records of irradiance there are.
    pub fn irradiance_records(&self) -> usize {
        self.irradiance
            .as_ref()
            .map_or(0, |cache| cache.records.len())
    }
}
