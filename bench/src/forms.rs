//! The forms in which textures are compared: each is a schedule of the same renderer.

use device::Device;
use engine::{
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
        device: &Device,
        scene: &Scene,
        procedural: &Procedural,
        settings: &RenderSettings,
    ) -> Result<Renderer, RenderError> {
        Renderer::with_schedule(device, scene, procedural, settings, self.schedule())
    }
}
