//! A cache of scattered light: the memory of it, and what paths do with it.
//!
//! Before a picture begins, and as it [grows](super::irradiance), paths teach the cache what surfaces scatter: each tells one cell what
//! it found after the first place where it could have ended. Then the cache is left as it is, and paths of the picture end in it.
//! What they find there is a mean over the cell and over the directions from which paths came, so the picture is *biased*: light varies
//! within a cell, and smooth surfaces scatter differently to different sides. At the first surface that the camera sees nothing of
//! that shows, for everything there is sampled as ever; paths end one vertex later at the earliest, and only where they have spread
//! wider than a cell.
//!
//! Most paths that teach it end in it, too, at the next place where they could: what lies beyond
//! is known better by those together that went before and on to their end than by one. They have scattered once more than these had by then, so
//! cells also know what they would be told if light could go on once less.
//!
//! Where the picture's samples come in halves, so does what is known: half of the paths teach cells of which the first half of the samples is
//! made, the rest those of the second, so that what the halves differ by is all the noise that there is, that of the cache as well.
//!
//! The sums of cells are whole numbers, so that what a cell holds doesn't depend on the order of the paths, and the picture not on
//! how it was cut. (Where so many cells are needed that the table is full, which ones are there does depend on it. So only the
//! first paths begin cells: what they don't come by, few others do.)

use std::ops::RangeInclusive;

use bytemuck::{Pod, Zeroable};
use device::{Device, DeviceError, Recording, Resources, Usage};

use crate::{
    film::Film,
    settings::{Method, RenderSettings},
    wave,
};

use super::{Purpose, RenderError, Renderer};

/// Cells of the table, 32 bytes each, of each half where the picture's samples come in halves.
const CELLS: u32 = 1 << 20;
/// Bytes of a cell.
const CELL_BYTES: u64 = 32;
/// Paths that must have gone on from a cell before others end there.
const LEAST_COUNT: u32 = 8;
/// Side of a cell over that of a pixel at its distance, before it is rounded down to a power of two: cells are met by some
/// hundred paths that are learned from, whatever the picture's size.
const SIDE: f32 = 8.0;
/// Least and most that it is over the distance: rays that have spread wider see nothing of a cell, and as many paths teach the cells of a
/// large picture as of a small one.
const SIDES: RangeInclusive<f32> = 0.04..=0.08;

/// What paths do with the cache: as in `cells.wgsl`.
const ENDS: u32 = 0;
const LEARNS: u32 = 1;
const IDLE: u32 = 2;

/// `LightCacheSettings` of `cells.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Settings {
    mode: u32,
    mask: u32,
    record: u32,
    least_count: u32,
    scale: f32,
    least_side: f32,
    photons: u32,
    lesser: u32,
    ends: u32,
    begins: u32,
    half: u32,
    unused: u32,
}

/// To which half of what is known of the light a path belongs: as in `cells.wgsl`.
const HALF_ONE: u32 = 0;
const HALF_OF_SAMPLE: u32 = 2;
const HALF_BY_TURNS: u32 = 3;

/// Cells of its table.
fn cells(settings: &RenderSettings) -> u32 {
    CELLS << u32::from(settings.halves)
}

/// Bytes of its table: what cells know, and what they know of light that goes on once less.
pub(super) fn bytes(settings: &RenderSettings) -> u64 {
    match settings.method.has_light_cache() {
        true => 2 * u64::from(cells(settings)) * CELL_BYTES,
        false => 0,
    }
}

/// Makes its buffers, where the method needs them.
pub(super) fn allocate(
    device: &Device,
    render: &RenderSettings,
    resources: &mut Resources,
) -> Result<(), DeviceError> {
    if !render.method.has_light_cache() {
        return Ok(());
    }
    let cells = device.buffer("light cache", Usage::Storage, bytes(render))?;
    resources.set_buffer("light_cache", cells);
    let bytes = size_of::<Settings>() as u64;
    let settings = device.buffer("light cache settings", Usage::Uniform, bytes)?;
    resources.set_buffer("light_cache_settings", settings);
    Ok(())
}

/// Forgets what it has learned.
pub(super) fn clear(
    device: &Device,
    method: Method,
    resources: &Resources,
) -> Result<(), DeviceError> {
    if !method.has_light_cache() {
        return Ok(());
    }
    let mut recording = Recording::new("forget");
    recording.clear(resources.buffer("light_cache"));
    device.start(&recording)
}

impl Renderer {
    /// A picture by other random numbers than this one's, so many samples per pixel of paths that end in no cache and lose to a clamp
    /// what paths do, to compare with. What has been gathered so far is gone after that, and the picture begins anew; what is known
    /// of [the whole](Self::learn_of_whole) stays.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn trace_apart(&mut self, seed: u32, spp: u32) -> Result<Film, RenderError> {
        let begin_anew = match self.knows_whole() {
            true => Self::begin_anew,
            false => Self::restart,
        };
        begin_anew(self);
        let own = self.frame;
        self.frame.set_seed(own.seed().wrapping_add(seed));
        self.frame.set_known_sky(false);
        self.is_apart = true;
        let film = self.render(spp).and_then(|()| self.film());
        self.is_apart = false;
        self.frame = own;
        begin_anew(self);
        film
    }

    /// The field of a path's state where its record for the cache begins: behind the results of its texture program.
    pub(super) fn light_record(&self) -> u32 {
        self.fields_from_last(wave::LIGHT_RECORD_WORDS)
    }

    /// The first of the last fields of a path's state, of so many words.
    pub(super) fn fields_from_last(&self, words: u32) -> u32 {
        let paths = match self.lanes.first_resources() {
            Some(own) => own.buffer("paths").size(),
            None => self.resources.buffer("paths").size(),
        };
        let fields = paths / 16 / u64::from(self.capacity);
        fields as u32 - words / 4
    }

    /// Says what the next wave does with the cache.
    pub(super) fn set_light_cache(&self, purpose: Purpose) {
        if !self.settings.method.has_light_cache() {
            return;
        }
        let mode = match purpose {
            Purpose::Learn { .. } => LEARNS,
            Purpose::Gather { .. } | Purpose::Picture => ENDS,
            _ => IDLE,
        };
        let cells = cells(&self.settings);
        let half = match purpose {
            _ if !self.settings.halves => HALF_ONE,
            Purpose::Learn { .. } => HALF_BY_TURNS,
            Purpose::Gather { turn, .. } => self.half_of_turn(turn),
            _ => HALF_OF_SAMPLE,
        };
        let words = Settings {
            mode,
            mask: cells - 1,
            record: self.light_record(),
            least_count: LEAST_COUNT,
            scale: (SIDE * self.frame.pixel_side()).clamp(*SIDES.start(), *SIDES.end()),
            least_side: (1e-4 * self.scene.radius).max(1e-6),
            photons: self.photon_field(purpose),
            lesser: cells * (CELL_BYTES / 4) as u32,
            ends: u32::from(purpose == Purpose::Learn { ends: true }),
            begins: self.begins_cells(purpose),
            half,
            unused: 0,
        };
        let uniform = self.resources.buffer("light_cache_settings");
        self.device.write(uniform, 0, bytemuck::bytes_of(&words));
    }
}
