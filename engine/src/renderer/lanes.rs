//! Devices whose threads each take paths of their own. A wave is cut into slices; a lane takes one from the camera to the film,
//! then the next one that is left. Lanes share the scene, the programs and the film, of which no two of them touch the same
//! pixel; the memory of the paths under way is each lane's own, so that threads neither wait for each other after each pass, nor
//! count in the same words, nor write to the same cache lines.

use std::ops::Range;
use std::sync::{
    Arc,
    atomic::{AtomicUsize, Ordering},
};

use device::{Device, DeviceError, Resources, Timer, Usage};

use crate::{
    frame::{BLOCK_PIXELS, Frame},
    schedule::{Schedule, ScheduleError, Upload},
    wave::{self, Queue, Totals},
};

use super::pipeline::{Bound, Kernels};
use super::record::Recorder;

/// Most paths that a lane takes at once: what they need stays in the caches of its core.
const MOST_PATHS: u32 = 4096;
/// Slots between the end of a field of all paths and the begin of the next one: where the same slot of all fields lies a power of two
/// apart, they fight for the same few places of a cache.
const APART: u32 = 16;
/// Fewer take hardly less time, for each pass has to be begun.
const FEWEST_PATHS: u32 = 512;
/// What is left of a wave is enough for so many slices of each lane: they shrink towards its end, so that lanes end at about the same
/// time.
const SLICES: u32 = 2;
/// Rounds that are added at once for rays that texture programs let pass, and the most of them: a path that meets more
/// such surfaces ends there.
const PASSAGES: u32 = 4;
const MOST_PASSAGES: u32 = 2048;

/// Resources that a lane doesn't share.
const OWN: [&str; 6] = [
    "frame",
    "queues",
    "paths",
    "rays",
    "dispatch_sizes",
    "layer_samples",
];

/// Records passes and plays them.
type Submit<'a> = dyn FnMut(&Record<'_>) -> Result<(), DeviceError> + 'a;
/// What is recorded.
type Record<'a> = dyn Fn(&mut Recorder<'_>) + 'a;

/// How a wave goes, whoever plays it.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub(super) schedule: Arc<dyn Schedule>,
    pub(super) max_depth: u32,
    /// Rays that pass surfaces, because a texture program says so, through clear walls or inside overlapping bodies, take rounds
    /// in which nothing scatters: as many follow as there is work for.
    pub(super) may_take_longer: bool,
}

impl Plan {
    /// Takes the paths of a wave that has begun to the film. `submit` plays what it records.
    pub(super) fn play(
        &self,
        device: &Device,
        resources: &Resources,
        submit: &mut Submit<'_>,
    ) -> Result<(), DeviceError> {
        let schedule = &*self.schedule;
        if !schedule.goes_in_rounds() {
            return submit(&|wave| schedule.end(wave));
        }
        submit(&|wave| {
            schedule.start(wave);
            // One round more than vertices that scatter: the last one finds emission only.
            for _ in 0..=self.max_depth {
                schedule.round(wave);
            }
            if !self.may_take_longer {
                schedule.end(wave);
            }
        })?;
        if !self.may_take_longer {
            return Ok(());
        }
        for _ in 0..MOST_PASSAGES / PASSAGES {
            let queues = resources.buffer("queues");
            let active = device.read(queues, Queue::Active.length_offset(), 4)?;
            if active.iter().all(|&byte| byte == 0) {
                break;
            }
            submit(&|wave| {
                for _ in 0..PASSAGES {
                    schedule.round(wave);
                }
            })?;
        }
        submit(&|wave| schedule.end(wave))
    }
}

/// Writes what a wave begins with.
pub(super) fn begin_wave(device: &Device, resources: &Resources, frame: &Frame) {
    let write = |name: &str, bytes: &[u8]| device.write(resources.buffer(name), 0, bytes);
    write("frame", bytemuck::bytes_of(frame));
    write("queues", bytemuck::cast_slice(&wave::fresh_queues()));
}

/// A thread's memory for paths.
#[derive(Debug)]
struct Lane {
    /// What it doesn't share.
    own: Resources,
    bound: Bound,
    timer: Timer,
}

/// The lanes of a renderer; none on a device that spreads each dispatch over all that it has.
#[derive(Debug, Default)]
pub(super) struct Lanes {
    list: Vec<Lane>,
}

impl Lanes {
    /// Path slots of each lane, of a device where waves have at most `most` paths; `most` where there are no lanes.
    pub(super) fn capacity(device: &Device, schedule: &dyn Schedule, most: u32) -> u32 {
        match Self::count(device, schedule) {
            0 => most,
            _ => most.min(MOST_PATHS + APART),
        }
    }

    /// How many there are.
    pub(super) fn number(device: &Device, schedule: &dyn Schedule) -> u64 {
        u64::from(Self::count(device, schedule))
    }

    fn count(device: &Device, schedule: &dyn Schedule) -> u32 {
        match schedule.goes_in_rounds() {
            true => device.traits().lanes,
            false => 0,
        }
    }

    /// Makes their buffers, for `record_words` of each path for the film's layers.
    pub(super) fn new(
        schedule: &mut dyn Schedule,
        upload: Upload<'_>,
        record_words: u32,
    ) -> Result<Self, ScheduleError> {
        let device = upload.device;
        let count = Self::count(device, schedule);
        let lane = |_| {
            let mut own = Resources::default();
            let frame = device.buffer("frame", Usage::Uniform, size_of::<Frame>() as u64)?;
            own.set_buffer("frame", frame);
            schedule.allocate(upload, &mut own)?;
            wave::allocate_layer_samples(device, upload.capacity, record_words, &mut own)?;
            Ok(Lane {
                own: own.only(&OWN),
                bound: Bound::default(),
                timer: Timer::counting(),
            })
        };
        let list = (0..count).map(lane).collect::<Result<_, ScheduleError>>()?;
        Ok(Self { list })
    }

    /// What the first of them doesn't share.
    pub(super) fn first_resources(&self) -> Option<&Resources> {
        self.list.first().map(|lane| &lane.own)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Binds kernels to what lanes share with the renderer, and to what they don't.
    pub(super) fn bind(&mut self, device: &Device, kernels: &Kernels, shared: &Resources) {
        for lane in &mut self.list {
            lane.bound = kernels.bind(device, &shared.clone().overlaid(&lane.own));
        }
    }

    /// Makes room for results of so many words; [`Self::bind`] has to follow where there was too little.
    pub(super) fn grow_results(
        &mut self,
        device: &Device,
        schedule: &dyn Schedule,
        capacity: u32,
        words: u32,
    ) -> Result<(), DeviceError> {
        for lane in &mut self.list {
            schedule.grow_results(device, capacity, words, &mut lane.own)?;
        }
        Ok(())
    }

    /// Times each pass from now on.
    pub(super) fn time_passes(&mut self, device: &Device) -> Result<(), DeviceError> {
        for lane in &mut self.list {
            lane.timer = Timer::timing(device)?;
        }
        Ok(())
    }

    /// Forgets what was wrong with the picture.
    pub(super) fn clear_faults(&self, device: &Device) {
        for lane in &self.list {
            wave::clear_faults(device, &lane.own);
        }
    }

    /// What the kernels have counted on all of them.
    pub(super) fn totals(&self, device: &Device) -> Result<Totals, DeviceError> {
        let mut totals = Totals::default();
        for lane in &self.list {
            totals.add(&Totals::read(device, &lane.own)?);
        }
        Ok(totals)
    }

    /// Milliseconds of a pass and its dispatches: of lanes that work at the same time, as if one did after the other what they
    /// take on average.
    pub(super) fn times(&self, label: &str) -> (f64, u64) {
        let of = |lane: &Lane| lane.timer.totals().get(label).copied().unwrap_or_default();
        let sum = |(a, b): (f64, u64), (c, d): (f64, u64)| (a + c, b + d);
        let (milliseconds, dispatches) = self.list.iter().map(of).fold((0.0, 0), sum);
        (milliseconds / self.list.len().max(1) as f64, dispatches)
    }

    /// Bytes of each buffer that they don't share, by name.
    pub(super) fn buffer_sizes(&self) -> impl Iterator<Item = (&'static str, u64)> {
        self.list.iter().flat_map(|lane| lane.own.buffer_sizes())
    }

    /// Takes the paths of a wave to the film.
    pub(super) fn render(
        &mut self,
        device: &Device,
        plan: &Plan,
        wave: &Wave<'_>,
    ) -> Result<(), DeviceError> {
        let slices = wave.slices(self.list.len() as u32);
        let next = AtomicUsize::new(0);
        device.side_by_side(&mut self.list, |lane| {
            while let Some(slice) = slices.get(next.fetch_add(1, Ordering::Relaxed)) {
                let (first, paths) = (slice.start, slice.end - slice.start);
                let frame = wave.slice(first, paths);
                begin_wave(device, &lane.own, &frame);
                let sizes = lane.own.buffer("dispatch_sizes");
                plan.play(device, &lane.own, &mut |record| {
                    let mut recorder = Recorder::new(&lane.bound, sizes, paths);
                    record(&mut recorder);
                    device.play_alone(&recorder.finish(), &mut lane.timer)
                })?;
            }
            Ok(())
        })
    }
}

/// A wave that is cut into slices.
#[derive(Debug)]
pub(super) struct Wave<'a> {
    pub(super) frame: &'a Frame,
    pub(super) paths: u32,
    pub(super) work: Work<'a>,
    /// Path slots of a lane.
    pub(super) capacity: u32,
}

/// What a wave holds of a picture.
#[derive(Debug, Clone, Copy)]
pub(super) enum Work<'a> {
    /// Paths in the order sample by sample, at most one for each pixel.
    Range {
        /// The first of them, of all of the picture.
        position: u64,
        /// First sample of the picture.
        first_sample: u32,
        /// Samples of each pixel.
        spp: u32,
    },
    /// So many samples of each of these blocks, as for [`Frame::set_lot`].
    Lot {
        blocks: &'a [[u32; 2]],
        samples: u32,
    },
}

impl Work<'_> {
    /// Paths that stay together, so that no two slices meet at a pixel.
    fn together(&self) -> u32 {
        match *self {
            Self::Range { .. } => BLOCK_PIXELS,
            Self::Lot { samples, .. } => samples * BLOCK_PIXELS,
        }
    }
}

impl Wave<'_> {
    /// What so many lanes take one after the other, as each has time.
    fn slices(&self, lanes: u32) -> Vec<Range<u32>> {
        let together = self.work.together();
        let whole = |paths: u32| (paths / together).max(1) * together;
        let most = MOST_PATHS.min(self.capacity);
        let mut slices = Vec::new();
        let mut first = 0;
        while first < self.paths {
            let left = self.paths - first;
            let paths = whole((left / (lanes * SLICES)).clamp(FEWEST_PATHS.min(most), most));
            slices.push(first..first + paths.min(left));
            first += paths.min(left);
        }
        slices
    }

    fn slice(&self, first: u32, paths: u32) -> Frame {
        let mut frame = *self.frame;
        match self.work {
            Work::Range {
                position,
                first_sample,
                spp,
            } => frame.set_wave(position + u64::from(first), paths, first_sample, spp),
            Work::Lot { blocks, samples } => {
                let block = samples * BLOCK_PIXELS;
                let (first, count) = ((first / block) as usize, (paths / block) as usize);
                frame.set_lot(&blocks[first..][..count], samples);
            }
        }
        frame
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn slices_shrink_towards_the_end_and_leave_nothing_out() {
        let range = Work::Range {
            position: 0,
            first_sample: 0,
            spp: 1,
        };
        let lot = Work::Lot {
            blocks: &[],
            samples: 16,
        };
        let frame = Frame::zeroed();
        for (work, together) in [(range, 64), (lot, 1024)] {
            for (blocks, lanes) in [(1, 2), (7, 2), (57, 2), (900, 16)] {
                let wave = Wave {
                    frame: &frame,
                    paths: blocks * together,
                    work,
                    capacity: MOST_PATHS + APART,
                };
                let slices = wave.slices(lanes);
                let mut end = 0;
                let mut former = u32::MAX;
                for slice in slices {
                    assert_eq!(slice.start, end);
                    end = slice.end;
                    let paths = end - slice.start;
                    assert!(paths <= former.min(MOST_PATHS), "{paths} after {former}");
                    assert!(paths.is_multiple_of(together), "{paths}");
                    former = paths;
                }
                assert_eq!(end, wave.paths);
            }
        }
    }
}
