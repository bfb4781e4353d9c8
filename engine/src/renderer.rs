//! The order of the passes: a wave of paths from raygen to the film, again and again.

mod bursts;
mod costs;
pub(crate) mod culprit;
mod edits;
mod figures;
mod irradiance;
mod lanes;
mod light_cache;
mod lots;
mod memory;
mod paths;
mod photons;
mod pipeline;
mod record;
mod reload;
mod update;
mod view;
mod whole;

use std::{sync::Arc, time::Duration};

use device::{Device, DeviceError, KernelText, Recording, Resources, Timer, Usage};

use crate::{
    film::{self, Film, MAX_SIDE, layers_wgsl},
    filter::FilterTable,
    frame::Frame,
    gpu_scene::{GpuScene, GpuSceneError, Views},
    procedural::{CompileError, EditError, Procedural},
    scene::Scene,
    schedule::{self, Aside, Errand, Schedule, ScheduleError, Upload, Wavefront},
    settings::Method,
    system::System,
    wave::{self, PathBytes},
};

use self::bursts::Burst;
use self::irradiance::Irradiance;
use self::lanes::{Lanes, Plan, Wave, Work, begin_wave};
use self::photons::Photons;
use self::pipeline::{Bound, Kernels};
use self::record::Recorder;
use self::whole::Known;

pub use crate::settings::RenderSettings;

pub(crate) use self::pipeline::compiling;
pub(crate) use self::update::Touched;
pub use self::{
    costs::{TextureCost, TextureCosts},
    culprit::{Culprit, culprits},
    edits::RenderEditError,
    lots::Lot,
    memory::{DeviceMemory, file_bytes, snapshot_bytes},
    reload::{Reload, ReloadError},
};

/// Waves are kept shorter than this, so that no dispatch comes near a desktop's watchdog and Ctrl-C is heard.
const LONGEST_WAVE: Duration = Duration::from_millis(1500);

/// Why rendering failed.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The picture's size can't be rendered.
    #[error("a picture of {width} x {height} can't be rendered: each side must be 1 to {MAX_SIDE}")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The part of a picture isn't in it.
    #[error("the part that is to be rendered reaches beyond the picture of {columns} x {rows}")]
    Crop {
        /// Columns of the whole.
        columns: u32,
        /// Rows of the whole.
        rows: u32,
    },
    /// The scene does not fit.
    #[error(transparent)]
    Scene(#[from] GpuSceneError),
    /// The device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The device can't play the schedule, or the schedule can't do this.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// A node whose values the film is to keep isn't there, or can't be shown.
    #[error("a layer of the film: {0}")]
    Node(EditError),
    /// The texture programs have no inlined form.
    #[error(transparent)]
    Programs(#[from] CompileError),
}

/// How far a render is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Camera paths finished.
    pub samples_done: u64,
    /// Camera paths wanted.
    pub samples_total: u64,
}

impl Progress {
    /// Whether nothing is left to do.
    pub fn is_done(&self) -> bool {
        self.samples_done >= self.samples_total
    }
}

/// Most paths of a wave: more than so many samples of a picture's pixels aren't wanted at once, nor memory for them.
fn most_paths(device: &Device, settings: &RenderSettings) -> u32 {
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let of_picture = (SAMPLES_OF_WAVE * pixels).clamp(1 << 20, 1 << 31);
    let wanted = device.traits().waves.most.min(of_picture as u32);
    wanted.min(settings.largest_wave)
}

/// Most samples of each pixel in a wave, if that isn't very small then.
const SAMPLES_OF_WAVE: u64 = 16;

/// Path slots that a device has memory for if it has for anything.
const LEAST_SLOTS: u32 = 1 << 18;

/// Allocates as many path slots as the device has memory for, these at the most.
fn while_it_fits<T>(
    mut most: u32,
    mut allocate: impl FnMut(u32) -> Result<T, ScheduleError>,
) -> Result<T, ScheduleError> {
    loop {
        let allocated = allocate(most);
        let is_too_much = matches!(
            allocated,
            Err(ScheduleError::Device(
                DeviceError::OutOfMemory
                    | DeviceError::NoRoom { .. }
                    | DeviceError::TooLarge { .. }
            ))
        );
        if !is_too_much || most <= LEAST_SLOTS {
            return allocated;
        }
        most /= 2;
    }
}

/// Fewer paths would take hardly less time.
const SMALLEST_WAVE: u32 = 256;

/// Paths of the first wave, whose speed nobody knows.
fn first_wave(device: &Device, capacity: u32) -> u32 {
    capacity.min(device.traits().waves.first)
}

/// Paths of the wave after one that took so long: longer waves keep the device busy, shorter ones keep each dispatch short.
fn next_wave(wave_size: u32, capacity: u32, took: Duration, longest: Duration) -> u32 {
    // What a wave takes whatever its size, so that twice the paths take less than twice as long, is no reason to stay small.
    let room = longest.as_secs_f64() / took.as_secs_f64().max(1e-6);
    let factor = match room {
        room if room < 1.0 => room.max(0.5),
        room if room > 1.4 => (0.9 * room).min(2.0),
        _ => return wave_size,
    };
    let paths = (f64::from(wave_size) * factor) as u32;
    paths.next_multiple_of(64).max(SMALLEST_WAVE).min(capacity)
}

/// Whether a picture of this size can be rendered.
fn check_size(settings: &RenderSettings) -> Result<(), RenderError> {
    let (width, height) = (settings.width, settings.height);
    let [columns, rows] = settings.whole();
    if width == 0 || height == 0 || columns > MAX_SIDE || rows > MAX_SIDE {
        return Err(RenderError::Size { width, height });
    }
    match settings.crop.is_some_and(|crop| !crop.holds(width, height)) {
        true => Err(RenderError::Crop { columns, rows }),
        false => Ok(()),
    }
}

/// Creates the film, the table of the pixel filter and the frame's uniform.
fn allocate_picture(
    device: &Device,
    settings: &RenderSettings,
    resources: &mut Resources,
) -> Result<(), RenderError> {
    check_size(settings)?;
    let (width, height) = (settings.width, settings.height);
    view::allocate_film(device, width, height, &settings.layers, resources)?;
    let filter = &FilterTable::of(settings.filter).distances;
    resources.set_buffer(
        "filter_table",
        device.filled_buffer(
            "the pixel filter",
            Usage::Storage,
            bytemuck::cast_slice(filter),
        )?,
    );
    let bytes = size_of::<Frame>() as u64;
    resources.set_buffer("frame", device.buffer("frame", Usage::Uniform, bytes)?);
    Ok(())
}

/// The film as it is now.
fn read_picture(
    device: &Device,
    settings: &RenderSettings,
    resources: &Resources,
) -> Result<Film, DeviceError> {
    let (width, height) = (settings.width, settings.height);
    let bytes = u64::from(width) * u64::from(height) * 16;
    let read = |name| {
        let bytes = device.read(resources.buffer(name), 0, bytes)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    };
    let layers = settings.layers.clone();
    let planes: Result<_, DeviceError> = layers.buffers().into_iter().map(read).collect();
    Ok(Film::from_planes(width, height, layers, planes?))
}

/// Starts the film anew.
fn clear_picture(
    device: &Device,
    settings: &RenderSettings,
    resources: &Resources,
) -> Result<(), DeviceError> {
    let mut recording = Recording::new("restart");
    for name in settings.layers.buffers() {
        recording.clear(resources.buffer(name));
    }
    device.start(&recording)
}

/// Tells kernels what moves, where the film has a layer of it.
fn show_motion(
    device: &Device,
    gpu_scene: &GpuScene,
    scene: &Scene,
    settings: &RenderSettings,
    resources: &mut Resources,
) -> Result<(), RenderError> {
    let Some(beside) = settings
        .beside
        .as_ref()
        .filter(|_| settings.layers.have_motion())
    else {
        return Ok(());
    };
    let views = Views {
        cameras: beside.cameras.each_ref(),
        transforms: beside.transforms.each_ref().map(Vec::as_slice),
        positions: beside.positions.each_ref().map(Vec::as_slice),
    };
    gpu_scene.show_motion(device, scene, &settings.camera, views, resources)?;
    Ok(())
}

/// What a wave is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    /// The picture.
    Picture,
    /// The cache of scattered light learns from it; paths end in what it knows already, or in none.
    Learn { ends: bool },
    /// Paths end in no cache, and none learns from them.
    Apart,
    /// Light samples of the sky are counted.
    Look,
    /// Candidates for records of irradiance, of this pass.
    Find(usize),
    /// Rays of the records from the first to before the end, which have been gathered for so many turns before.
    Gather { first: u32, end: u32, turn: u32 },
    /// Photons.
    Photons,
}

/// Renders one scene progressively.
#[derive(Debug)]
pub struct Renderer {
    device: Device,
    system: System,
    settings: RenderSettings,
    procedural: Procedural,
    schedule: Arc<dyn Schedule>,
    scene: GpuScene,
    resources: Resources,
    kernels: Kernels,
    bound: Bound,
    lanes: Lanes,
    frame: Frame,
    /// Path slots.
    capacity: u32,
    /// Most paths of a wave: on a device with lanes more than there are slots.
    most_paths: u32,
    /// Paths of the next wave: adapted to the device's speed.
    wave_size: u32,
    /// Paths started, padding included, in the order sample by sample.
    position: u64,
    /// Samples that come several at once.
    burst: Burst,
    /// Paths that are in the film, padding included.
    rendered: u64,
    timer: Timer,
    seconds: f64,
    longest_wave: Duration,
    smallest_wave: u32,
    /// Pixels that the film's buffers have room for, where these are more than the picture has.
    film_pixels: u64,
    /// Pixels that get samples, where not all do.
    region: Option<[u32; 4]>,
    guides: Option<view::Guides>,
    survey: Option<costs::Survey>,
    /// The film is to be cleared before anything is added to it or seen of it.
    is_stale: bool,
    /// No path ends in a cache.
    is_apart: bool,
    /// Records of irradiance, where the picture is made with them.
    irradiance: Option<Irradiance>,
    /// A map of photons, where they bring caustics.
    photons: Option<Photons>,
    /// What is known of the light of the picture of which parts are rendered, if that is so.
    whole: Option<Known>,
    /// How often the picture has begun anew.
    restarts: u64,
    /// All kernels have run, so that drivers that compile them then have done so.
    is_warm: bool,
}

impl Renderer {
    /// Uploads the scene and compiles the kernels.
    ///
    /// # Errors
    /// If the scene is empty, too large for the device, or a kernel (a user's texture) does not build.
    pub fn new(
        device: &Device,
        scene: &Scene,
        procedural: &Procedural,
        settings: &RenderSettings,
    ) -> Result<Self, RenderError> {
        Self::with_schedule(device, scene, procedural, settings, Box::new(Wavefront))
    }

    /// As [`Self::new`] by another schedule than the usual one. The picture does not depend on it.
    ///
    /// # Errors
    /// As [`Self::new`]; a device that can't run its kernels.
    pub fn with_schedule(
        device: &Device,
        scene: &Scene,
        procedural: &Procedural,
        settings: &RenderSettings,
        schedule: Box<dyn Schedule>,
    ) -> Result<Self, RenderError> {
        let most = most_paths(device, settings);
        Self::build(device, scene, procedural, settings, most, schedule)
    }

    /// As [`Self::new`] with waves of at most `capacity` paths. The picture does not depend on it.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_capacity(
        device: &Device,
        scene: &Scene,
        procedural: &Procedural,
        settings: &RenderSettings,
        capacity: u32,
    ) -> Result<Self, RenderError> {
        let schedule = Box::new(Wavefront);
        Self::build(device, scene, procedural, settings, capacity, schedule)
    }

    fn build(
        device: &Device,
        scene: &Scene,
        procedural: &Procedural,
        settings: &RenderSettings,
        most_paths: u32,
        mut schedule: Box<dyn Schedule>,
    ) -> Result<Self, RenderError> {
        let layers = &settings.layers;
        let procedural = &procedural
            .showing(layers.nodes())
            .map_err(RenderError::Node)?;
        let most_paths = most_paths.next_multiple_of(64).max(64);
        let mut resources = Resources::default();
        allocate_picture(device, settings, &mut resources)?;
        let mut gpu_scene = GpuScene::new(
            device,
            scene,
            &procedural.reads(),
            |m| procedural.traits(m),
            &mut resources,
        )?;
        show_motion(device, &gpu_scene, scene, settings, &mut resources)?;
        gpu_scene.features = memory::with_settings(gpu_scene.features, settings);
        let record_words = layers.record_words();
        if record_words > 0 && !schedule::records_layers(&*schedule) {
            let reason = "this schedule gathers no layers beside the picture";
            return Err(ScheduleError::Unsupported(reason).into());
        }
        if settings.method != Method::Path {
            if !schedule::has_light_cache(&*schedule) {
                let reason = "this schedule has no cache of light";
                return Err(ScheduleError::Unsupported(reason).into());
            }
            if layers.have_light_groups() {
                let reason = "caches of light don't know from which lamps it comes, so there are no layers of light groups";
                return Err(ScheduleError::Unsupported(reason).into());
            }
        }
        light_cache::allocate(device, settings, &mut resources)?;
        let features = &gpu_scene.features;
        let irradiance = Irradiance::new(device, settings, features, &mut resources)?;
        let photons = Photons::new(device, settings, features, &mut resources)?;
        wave::allocate_layer_words(device, &layers_wgsl::record_words(layers), &mut resources)?;
        // What was refused so far isn't the paths' fault.
        device.check()?;
        let (most_paths, capacity, own, mut lanes) = while_it_fits(most_paths, |most| {
            // What was allocated for more of them is free once the device is idle.
            device.wait()?;
            let capacity = Lanes::capacity(device, &*schedule, most);
            let upload = Upload {
                device,
                scene,
                gpu_scene: &gpu_scene,
                procedural,
                capacity,
            };
            let mut own = Resources::default();
            schedule.allocate(upload, &mut own)?;
            wave::allocate_layer_samples(device, capacity, record_words, &mut own)?;
            let lanes = Lanes::new(&mut *schedule, upload, record_words)?;
            device.check()?;
            Ok((most, capacity, own, lanes))
        })?;
        let mut resources = resources.overlaid(&own);
        edits::allocate(device, procedural, &*schedule, &mut resources)?;
        let features = &gpu_scene.features;
        let kernels = Kernels::new(device, features, layers, procedural, &*schedule)?;
        let bound = kernels.bind(device, &resources);
        lanes.bind(device, &kernels, &resources);
        device.check()?;
        Ok(Self {
            device: device.clone(),
            system: System::default(),
            settings: settings.clone(),
            procedural: procedural.clone(),
            schedule: schedule.into(),
            frame: Frame::new(settings, capacity, &gpu_scene),
            scene: gpu_scene,
            resources,
            kernels,
            bound,
            lanes,
            capacity,
            most_paths,
            wave_size: first_wave(device, most_paths),
            position: 0,
            burst: Burst::default(),
            rendered: 0,
            timer: Timer::counting(),
            seconds: 0.0,
            longest_wave: LONGEST_WAVE,
            smallest_wave: SMALLEST_WAVE,
            film_pixels: 0,
            region: None,
            guides: None,
            survey: None,
            is_stale: false,
            is_apart: false,
            irradiance,
            photons,
            whole: None,
            restarts: 0,
            is_warm: false,
        })
    }

    /// With the time and the threads of another system than the operating system.
    #[must_use]
    pub fn in_system(mut self, system: &System) -> Self {
        self.system = system.clone();
        self
    }

    /// Times each pass from now on; costs a read-back per wave.
    ///
    /// # Errors
    /// If the device is out of memory.
    pub fn time_passes(&mut self) -> Result<(), RenderError> {
        self.timer = Timer::timing(&self.device)?;
        self.lanes.time_passes(&self.device)?;
        Ok(())
    }

    /// Whether passes are timed.
    pub fn is_timing(&self) -> bool {
        self.timer.is_timing()
    }

    /// Renders one wave towards `target_spp` samples per pixel, at most [`film::MAX_SAMPLES`]. Call it until the progress
    /// is done.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn step(&mut self, target_spp: u32) -> Result<Progress, RenderError> {
        let first = self.settings.first_sample;
        // More would leave the range of the film's sums, or that of the samples' numbers.
        let target_spp = target_spp.min(film::MAX_SAMPLES).min(u32::MAX - first);
        let padded = u64::from(self.frame.padded_pixels);
        let total = padded * u64::from(target_spp);
        let is_preparing = self.position < total && self.prepare_light()?;
        if self.position < total && !is_preparing && !self.step_burst(target_spp)? {
            let wave = u64::from(self.next_wave_size()).min(total - self.position);
            let wave = self.until_more_rays(self.until_next_photons(wave));
            // Bursts begin with whole samples.
            let wave = match self.has_bursts() {
                true => wave.min(padded - self.position % padded),
                false => wave,
            };
            self.wave_at(self.position, wave as u32, target_spp)?;
            self.position += wave;
        }
        let pixels = u64::from(self.settings.width) * u64::from(self.settings.height);
        let done =
            |paths: u64| (u128::from(paths) * u128::from(pixels) / u128::from(padded)) as u64;
        Ok(Progress {
            samples_done: done(self.position.min(total)),
            samples_total: done(total),
        })
    }

    /// Most paths of the next wave.
    fn next_wave_size(&self) -> u32 {
        let paths = (self.wave_size.max(self.smallest_wave)).min(self.most_paths);
        match self.lanes.is_empty() {
            true => paths,
            // Lanes may not meet at a pixel.
            false => paths.min(self.frame.padded_pixels),
        }
    }

    /// Renders a wave from a path on, of a picture of so many samples per pixel.
    fn wave_at(&mut self, position: u64, paths: u32, spp: u32) -> Result<(), RenderError> {
        let first_sample = self.settings.first_sample;
        self.frame.set_wave(position, paths, first_sample, spp);
        let frame = self.frame;
        let work = Work::Range {
            position,
            first_sample,
            spp,
        };
        self.play_wave(&frame, work, self.purpose())
    }

    /// Of waves whose samples are the picture's.
    fn purpose(&self) -> Purpose {
        match self.is_apart {
            true => Purpose::Apart,
            false => Purpose::Picture,
        }
    }

    /// Renders the wave of a frame.
    fn play_wave(
        &mut self,
        frame: &Frame,
        work: Work<'_>,
        purpose: Purpose,
    ) -> Result<(), RenderError> {
        // A window that shares the device may have a frame under way: that is no time of the wave's.
        self.device.wait()?;
        let start = self.system.clock.now();
        self.clear_stale_film()?;
        self.set_light_cache(purpose);
        self.set_irradiance(purpose);
        self.set_photons(purpose);
        let mut frame = *frame;
        frame.set_records_given(purpose == Purpose::Picture && self.settings.method.has_records());
        frame.set_learns(self.only_learns(purpose));
        let paths = frame.wave_size;
        match self.lanes.is_empty() {
            true => self.render_wave(&frame, purpose)?,
            false => {
                let wave = Wave {
                    frame: &frame,
                    paths,
                    work,
                    capacity: self.capacity,
                };
                let plan = self.plan(purpose);
                self.lanes.render(&self.device, &plan, &wave)?;
            }
        }
        self.is_warm = true;
        if purpose != Purpose::Photons && self.records_awaited().is_none() {
            self.rendered += u64::from(paths);
        }
        let took = self.system.clock.now() - start;
        self.wave_size = next_wave(self.wave_size, self.most_paths, took, self.longest_wave);
        self.seconds += took.as_secs_f64();
        Ok(())
    }

    /// Renders up to `target_spp` samples per pixel.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn render(&mut self, target_spp: u32) -> Result<(), RenderError> {
        while !self.step(target_spp)?.is_done() {}
        Ok(())
    }

    /// Whether paths that teach the cache of scattered light are a first picture: one that goes on has its samples, a whole of which
    /// parts are rendered has no film, and what teaches more shows less.
    fn learning_is_seen(&self) -> bool {
        !self.is_begun() && self.whole.is_none() && !self.learns_more()
    }

    /// Whether a wave does nothing but teach that cache, which is told nothing of what the surface that the camera sees scatters at once. It
    /// mustn't depend on whether the picture has begun: what is learned has to be the same, to the bit.
    fn only_learns(&self, purpose: Purpose) -> bool {
        match purpose {
            Purpose::Learn { ends } => self.learns_more() && !self.looks(ends),
            _ => false,
        }
    }

    /// How waves go.
    fn plan(&self, purpose: Purpose) -> Plan {
        let errand = match purpose {
            Purpose::Gather { .. } => Some(Errand::Gather),
            Purpose::Photons => Some(Errand::Emit),
            Purpose::Look => Some(Errand::Look),
            Purpose::Find(_) => Some(Errand::Unseen),
            Purpose::Learn { ends } => {
                let is_seen = self.learning_is_seen();
                match self.looks(ends) {
                    true => Some(Errand::Learn { is_seen }),
                    false => (!is_seen).then_some(Errand::Unseen),
                }
            }
            Purpose::Picture | Purpose::Apart => None,
        };
        let schedule = Arc::clone(&self.schedule);
        Plan {
            schedule: match errand {
                Some(errand) => Arc::new(Aside { schedule, errand }),
                None => schedule,
            },
            max_depth: self.settings.max_depth,
            may_take_longer: self.scene.features.passages,
        }
    }

    /// Takes the paths of the frame to the film, all at once.
    fn render_wave(&mut self, frame: &Frame, purpose: Purpose) -> Result<(), DeviceError> {
        begin_wave(&self.device, &self.resources, frame);
        let paths = frame.wave_size;
        let (device, resources) = (self.device.clone(), self.resources.clone());
        let plan = self.plan(purpose);
        plan.play(&device, &resources, &mut |record| {
            self.submit(paths, |wave| record(wave))
        })
    }

    /// Records passes, and waits until they have run.
    fn submit(
        &mut self,
        paths: u32,
        record: impl FnOnce(&mut Recorder<'_>),
    ) -> Result<(), DeviceError> {
        let sizes = self.resources.buffer("dispatch_sizes");
        let mut recorder = Recorder::new(&self.bound, sizes, paths);
        record(&mut recorder);
        let recording = recorder.finish();
        if self.is_warm {
            return self.device.play_timed(&recording, &mut self.timer);
        }
        let procedural = &self.procedural;
        let textures = self.schedule.texture_pass().name;
        let say = |label: &str| match label == textures {
            true => pipeline::compiling(procedural),
            false => format!("compiling the kernel {label}"),
        };
        self.device.play_apart(&recording, &mut self.timer, say)
    }

    fn clear_stale_film(&mut self) -> Result<(), DeviceError> {
        if std::mem::take(&mut self.is_stale) {
            clear_picture(&self.device, &self.settings, &self.resources)?;
            if !self.knows_whole() {
                light_cache::clear(&self.device, self.settings.method, &self.resources)?;
            }
            wave::clear_faults(&self.device, &self.resources);
            self.lanes.clear_faults(&self.device);
        }
        Ok(())
    }

    /// What has been gathered so far.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn film(&self) -> Result<Film, RenderError> {
        if self.is_stale {
            let (width, height) = (self.settings.width, self.settings.height);
            return Ok(Film::with_layers(
                width,
                height,
                self.settings.layers.clone(),
            ));
        }
        Ok(read_picture(&self.device, &self.settings, &self.resources)?)
    }

    /// The text of the texture kernel, for tools. None where there is no such kernel.
    ///
    /// # Errors
    /// Programs that can't be in the schedule's form.
    pub fn texture_kernel_text(&self) -> Result<Option<KernelText>, RenderError> {
        if !self.kernels.has_texture() {
            return Ok(None);
        }
        let features = &self.scene.features;
        let schedule = &self.schedule;
        Ok(schedule.texture_kernel(features, &self.procedural)?)
    }

    /// GPU memory of one path.
    pub fn path_bytes(&self) -> PathBytes {
        PathBytes::new(self.procedural.result_words() + self.scene.features.path_words())
    }

    /// Binds the kernels to the resources, after either has changed.
    fn bind(&mut self) {
        self.bound = self.kernels.bind(&self.device, &self.resources);
        self.lanes
            .bind(&self.device, &self.kernels, &self.resources);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where waves end up whose time is `fixed` milliseconds and some nanoseconds per path.
    fn settled(fixed: f64, per_path: f64, longest: f64) -> (u32, f64) {
        let time = |paths: u32| fixed * 1e-3 + f64::from(paths) * per_path * 1e-9;
        let mut paths = 1 << 14;
        for _ in 0..50 {
            let took = Duration::from_secs_f64(time(paths));
            paths = next_wave(
                paths,
                1 << 16,
                took,
                Duration::from_secs_f64(longest * 1e-3),
            );
        }
        (paths, time(paths) * 1e3)
    }

    #[test]
    fn waves_are_as_large_as_the_memory_allows() {
        let fitting = |room: u32| {
            while_it_fits(1 << 22, |slots| match slots > room {
                true => Err(DeviceError::OutOfMemory.into()),
                false => Ok(slots),
            })
        };
        assert_eq!(fitting(1 << 22).ok(), Some(1 << 22));
        assert_eq!(fitting(3 << 19).ok(), Some(1 << 20));
        let refused = fitting(1000);
        assert!(matches!(
            refused,
            Err(ScheduleError::Device(DeviceError::OutOfMemory))
        ));
    }

    #[test]
    fn waves_become_as_long_as_they_may() {
        for (fixed, per_path) in [(0.0, 7e3), (40.0, 7e3), (0.0, 1e5), (90.0, 100.0)] {
            let (paths, took) = settled(fixed, per_path, 100.0);
            let is_fitting = (60.0..=115.0).contains(&took) || paths == 1 << 16;
            assert!(is_fitting, "{fixed} {per_path}: {paths} paths, {took} ms");
        }
        // There is a smallest and a largest one.
        assert_eq!(settled(500.0, 7e3, 100.0).0, SMALLEST_WAVE);
        assert_eq!(settled(0.0, 1.0, 100.0).0, 1 << 16);
    }
}
