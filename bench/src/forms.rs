//! The forms in which textures are compared: each is a schedule of the same renderer.

use device::Device;
use engine::{
    passes::wgsl::{ComposedWgsl, File},
    procedural::Procedural,
    renderer::{RenderError, RenderSettings, Renderer},
    scene::Scene,
    schedule::{Schedule, Wavefront},
};

use crate::{inlined::Inlined, rayquery::RayQueries};

/// How textures get into a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// [`Wavefront`]: what this project does.
    Stack,
    /// [`Inlined`].
    Inlined,
    /// [`RayQueries`].
    RayQuery,
}

impl Form {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Stack, Self::Inlined, Self::RayQuery];

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stack => "stack",
            Self::Inlined => "inlined",
            Self::RayQuery => "rayquery",
        }
    }

    /// The schedule of this form.
    pub fn schedule(self) -> Box<dyn Schedule> {
        match self {
            Self::Stack => Box::new(Wavefront),
            Self::Inlined => Box::new(Inlined),
            Self::RayQuery => Box::new(RayQueries::default()),
        }
    }

    /// Uploads a scene and compiles the kernels of this form.
    ///
    /// # Errors
    /// As [`Renderer::with_schedule`].
    pub fn renderer(
        self,
        gpu: &Device,
        scene: &Scene,
        procedural: &Procedural,
        settings: &RenderSettings,
    ) -> Result<Renderer, RenderError> {
        Renderer::with_schedule(gpu, scene, procedural, settings, self.schedule())
    }
}

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!($name))),*]
    };
}

/// The WGSL files of this crate, by their paths here; they include the engine's.
const FILES: &[File] = files![
    "inlined/inlined.wgsl",
    "inlined/traced_ao.wgsl",
    "rayquery/kernel.wgsl",
    "rayquery/path_memory.wgsl",
    "rayquery/plain.wgsl",
    "rayquery/queries.wgsl",
    "rayquery/textured.wgsl",
];

/// Composes a kernel whose root is one of this crate's files.
pub(crate) fn compose(file: &str) -> ComposedWgsl {
    ComposedWgsl::with_files(file, FILES)
}
