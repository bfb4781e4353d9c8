//! The order of the passes. A wave takes paths from the camera to the film; a round takes each path that is under way to its
//! next surface, and its shadow ray to the light.
//!
//! A renderer plays a [`Schedule`]: [`Wavefront`] is the one that pictures are made with. Others cut the same work into other
//! kernels, to be compared with it; they stand outside of this crate.

use std::borrow::Cow;
use std::fmt;
use std::sync::Arc;

use device::{Device, DeviceError, KernelText, Resources};

use crate::gpu_scene::{GpuScene, SceneFeatures};
use crate::passes::{
    accumulate, advance, ao, brdf, classify, film_layers, irradiance, light_cache, pass::Pass,
    photons, proctex, raygen, traverse,
};
use crate::procedural::{CompileError, Procedural};
use crate::scene::Scene;
use crate::wave;

/// The passes of a wave, in the order in which they first run. Those of textures exist only where a
/// material has a program, those of layers where the film has more than the picture.
pub static WAVE: [&Pass; 33] = [
    &raygen::PASS,
    &advance::AFTER_RAYGEN,
    &traverse::CLOSEST,
    &light_cache::LOOK_UP,
    &classify::PASS,
    &advance::AFTER_CLASSIFY,
    &ao::PASS,
    &proctex::PASS,
    &film_layers::RECORD,
    &film_layers::LIGHT,
    &brdf::PASS,
    &irradiance::LOOK_UP,
    &photons::GATHER,
    &light_cache::NOTE,
    &advance::AFTER_BRDF,
    &traverse::OCCLUSION,
    &irradiance::LOOK,
    &irradiance::START,
    &irradiance::FIRST_HIT,
    &advance::AFTER_FIRST_HIT,
    &irradiance::NOTE,
    &irradiance::END,
    &photons::START,
    &photons::EMIT,
    &photons::ARRIVE,
    &photons::FOLLOW,
    &light_cache::LEARN,
    &film_layers::LAST_LIGHT,
    &accumulate::PASS,
    &film_layers::MEAN,
    &film_layers::MEANS,
    &film_layers::FIRST,
    &film_layers::IDS,
];

/// What runs passes, or notes that they are to be run. A pass that the scene doesn't need is left out.
pub trait Run {
    /// Runs a pass.
    fn run(&mut self, pass: &'static Pass);
}

/// Paths start at the camera.
pub fn start(wave: &mut dyn Run) {
    wave.run(&raygen::PASS);
    wave.run(&advance::AFTER_RAYGEN);
}

/// What rays meet, and what the texture programs say about it.
pub fn find_hits(wave: &mut dyn Run) {
    wave.run(&traverse::CLOSEST);
    wave.run(&light_cache::LOOK_UP);
    shade_hits(wave);
}

/// What the texture programs say about hits.
fn shade_hits(wave: &mut dyn Run) {
    wave.run(&classify::PASS);
    wave.run(&advance::AFTER_CLASSIFY);
    wave.run(&ao::PASS);
    wave.run(&proctex::PASS);
}

/// Each path goes on to its next surface.
pub fn round(wave: &mut dyn Run) {
    find_hits(wave);
    wave.run(&film_layers::RECORD);
    wave.run(&film_layers::LIGHT);
    wave.run(&brdf::PASS);
    wave.run(&irradiance::LOOK_UP);
    wave.run(&photons::GATHER);
    wave.run(&light_cache::NOTE);
    wave.run(&advance::AFTER_BRDF);
    wave.run(&traverse::OCCLUSION);
}

/// What the paths have gathered goes to the film.
pub fn end(wave: &mut dyn Run) {
    wave.run(&light_cache::LEARN);
    wave.run(&film_layers::LAST_LIGHT);
    wave.run(&accumulate::PASS);
    wave.run(&film_layers::MEAN);
    wave.run(&film_layers::MEANS);
    wave.run(&film_layers::FIRST);
    wave.run(&film_layers::IDS);
}

/// Whether what the film's layers show is recorded: where [`film_layers::RECORD`] is among the passes. The renderer makes the
/// buffers for it.
pub(crate) fn records_layers(schedule: &dyn Schedule) -> bool {
    let mut passes = schedule.passes().iter();
    passes.any(|pass| pass.name == film_layers::RECORD.name)
}

/// Whether paths may end in a cache of light: where [`light_cache::LOOK_UP`] is among the passes.
pub(crate) fn has_light_cache(schedule: &dyn Schedule) -> bool {
    let mut passes = schedule.passes().iter();
    passes.any(|pass| pass.name == light_cache::LOOK_UP.name)
}

/// Why a schedule can't be played on a device.
#[derive(Debug, thiserror::Error)]
pub enum ScheduleError {
    /// It has no room for the buffers.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// It lacks what the kernels need.
    #[error("{0}")]
    Unsupported(&'static str),
}

/// What a schedule makes its buffers for.
#[derive(Debug, Clone, Copy)]
pub struct Upload<'a> {
    /// Where they are made.
    pub device: &'a Device,
    /// What is rendered.
    pub scene: &'a Scene,
    /// The same on the device.
    pub gpu_scene: &'a GpuScene,
    /// Its texture programs.
    pub procedural: &'a Procedural,
    /// Most paths of a wave.
    pub capacity: u32,
}

/// How the work of a wave is cut into kernels. The picture doesn't depend on it. What isn't said otherwise is as in
/// [`Wavefront`].
pub trait Schedule: fmt::Debug + Send + Sync {
    /// Its passes, in the order in which they first run.
    fn passes(&self) -> &'static [&'static Pass] {
        &WAVE
    }

    /// The one of them that the users' functions are in.
    fn texture_pass(&self) -> &'static Pass {
        &proctex::PASS
    }

    /// The kernel of that pass; `None` where it isn't needed.
    ///
    /// # Errors
    /// Programs that can't be in this form.
    fn texture_kernel(
        &self,
        features: &SceneFeatures,
        procedural: &Procedural,
    ) -> Result<Option<KernelText>, CompileError>;

    /// The words of the buffer `programs`.
    ///
    /// # Errors
    /// Programs that can't be in this form.
    fn program_words<'a>(&self, procedural: &'a Procedural)
    -> Result<Cow<'a, [u32]>, CompileError>;

    /// Whether the texture kernel holds the programs themselves, so that any edit of them builds it again.
    fn edits_are_code(&self) -> bool {
        false
    }

    /// Makes the buffers that the passes share, besides those of scene and film.
    ///
    /// # Errors
    /// The device has no room for them, or can't run these kernels.
    fn allocate(&mut self, upload: Upload<'_>, to: &mut Resources) -> Result<(), ScheduleError> {
        let words = upload.procedural.result_words() + upload.gpu_scene.features.path_words();
        Ok(wave::allocate(upload.device, upload.capacity, words, to)?)
    }

    /// Makes room for results of so many words where there is too little; true if there was.
    ///
    /// # Errors
    /// The device has none.
    fn grow_results(
        &self,
        device: &Device,
        capacity: u32,
        words: u32,
        resources: &mut Resources,
    ) -> Result<bool, DeviceError> {
        wave::grow_results(device, capacity, words, resources)
    }

    /// Whether paths go on in rounds, between whose passes others may look at the wave: what the camera sees first, which
    /// textures take how long. Else [`Self::end`] is the whole wave.
    fn goes_in_rounds(&self) -> bool {
        true
    }

    /// [`start`].
    fn start(&self, wave: &mut dyn Run) {
        start(wave);
    }

    /// [`round`].
    fn round(&self, wave: &mut dyn Run) {
        round(wave);
    }

    /// [`end`].
    fn end(&self, wave: &mut dyn Run) {
        end(wave);
    }
}

/// What waves are for that show nothing of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Errand {
    /// Rays start at records of irradiance instead of the camera, and end in a list instead of the film.
    Gather,
    /// Photons start at lamps, and end in a list as well.
    Emit,
    /// Paths are those of the picture, but nothing goes to the film.
    Unseen,
    /// The same, and light samples of the sky are counted.
    Look,
    /// The cache of scattered light learns, and light samples of the sky are counted.
    Learn {
        /// Whether the film gets the paths.
        is_seen: bool,
    },
}

/// Waves for such an errand, by the kernels of another schedule.
#[derive(Debug, Clone)]
pub(crate) struct Aside {
    pub(crate) schedule: Arc<dyn Schedule>,
    pub(crate) errand: Errand,
}

impl Schedule for Aside {
    fn texture_kernel(
        &self,
        features: &SceneFeatures,
        procedural: &Procedural,
    ) -> Result<Option<KernelText>, CompileError> {
        self.schedule.texture_kernel(features, procedural)
    }

    fn program_words<'a>(
        &self,
        procedural: &'a Procedural,
    ) -> Result<Cow<'a, [u32]>, CompileError> {
        self.schedule.program_words(procedural)
    }

    fn start(&self, wave: &mut dyn Run) {
        match self.errand {
            Errand::Gather => {
                wave.run(&irradiance::START);
                wave.run(&advance::AFTER_RAYGEN);
            }
            Errand::Emit => {
                wave.run(&photons::START);
                wave.run(&advance::AFTER_RAYGEN);
                // A point of a lamp is a hit.
                shade_hits(wave);
                wave.run(&photons::EMIT);
                wave.run(&advance::AFTER_BRDF);
            }
            Errand::Unseen | Errand::Look | Errand::Learn { .. } => self.schedule.start(wave),
        }
    }

    fn round(&self, wave: &mut dyn Run) {
        match self.errand {
            Errand::Gather => {
                wave.run(&traverse::CLOSEST);
                wave.run(&irradiance::FIRST_HIT);
                wave.run(&advance::AFTER_FIRST_HIT);
                wave.run(&light_cache::LOOK_UP);
                shade_hits(wave);
                wave.run(&brdf::PASS);
                wave.run(&irradiance::NOTE);
                wave.run(&photons::GATHER);
                wave.run(&advance::AFTER_BRDF);
                wave.run(&traverse::OCCLUSION);
            }
            Errand::Emit => {
                wave.run(&traverse::CLOSEST);
                wave.run(&photons::ARRIVE);
                shade_hits(wave);
                wave.run(&brdf::PASS);
                wave.run(&photons::FOLLOW);
                wave.run(&advance::AFTER_BRDF);
            }
            Errand::Unseen => self.schedule.round(wave),
            Errand::Look | Errand::Learn { .. } => {
                self.schedule.round(wave);
                wave.run(&irradiance::LOOK);
            }
        }
    }

    fn end(&self, wave: &mut dyn Run) {
        match self.errand {
            Errand::Gather => wave.run(&irradiance::END),
            Errand::Learn { is_seen: true } => self.schedule.end(wave),
            Errand::Unseen | Errand::Learn { is_seen: false } => wave.run(&light_cache::LEARN),
            Errand::Emit | Errand::Look => {}
        }
    }
}

/// A kernel for each pass; texture programs are data.
#[derive(Debug, Clone, Copy, Default)]
pub struct Wavefront;

impl Schedule for Wavefront {
    fn texture_kernel(
        &self,
        features: &SceneFeatures,
        procedural: &Procedural,
    ) -> Result<Option<KernelText>, CompileError> {
        if procedural.is_empty() {
            return Ok(None);
        }
        Ok(Some(KernelText {
            text: Arc::new(proctex::text(&procedural.kernel())),
            entry: proctex::PASS.name,
            trust: proctex::TRUST,
            constants: features.constants().to_vec(),
        }))
    }

    fn program_words<'a>(
        &self,
        procedural: &'a Procedural,
    ) -> Result<Cow<'a, [u32]>, CompileError> {
        Ok(Cow::Borrowed(procedural.programs()))
    }
}
