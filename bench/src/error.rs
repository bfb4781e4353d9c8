//! What can be wrong with a comparison of textures.

use texgen::Diagnostics;

use engine::{
    procedural::SourcesError,
    renderer::{ReloadError, RenderEditError, RenderError},
    scene::look::LookError,
};

use crate::kernel;

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum TextureBenchError {
    /// The device.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// An edit was refused.
    #[error(transparent)]
    Edit(#[from] RenderEditError),
    /// A source edit was refused.
    #[error(transparent)]
    Reload(#[from] ReloadError),
    /// The standard textures are missing or changed so that they don't fit.
    #[error("{0}")]
    Textures(Box<Diagnostics>),
    /// They can't be read.
    #[error(transparent)]
    Sources(#[from] SourcesError),
    /// There are none to fill a kernel with.
    #[error(transparent)]
    Kernel(#[from] kernel::KernelBenchError),
    /// The look that is made of them.
    #[error(transparent)]
    Look(#[from] LookError),
    /// There is no material of that name to be textured.
    #[error("the scene has no material `{name}`: {remedy}")]
    NoMaterial {
        /// As asked for.
        name: String,
        /// What there is.
        remedy: String,
    },
    /// The forms don't give the same picture, so their times mean nothing.
    #[error(
        "the {form} form shows another picture of {texture} than the stack form: {percent:.2} % of the pixels differ by \
         more than {sigmas} standard errors"
    )]
    Differs {
        /// Name of the form.
        form: &'static str,
        /// Name of the texture.
        texture: &'static str,
        /// Of the pixels.
        percent: f64,
        /// Standard errors that they differ by.
        sigmas: f32,
    },
}

impl From<Diagnostics> for TextureBenchError {
    fn from(problems: Diagnostics) -> Self {
        Self::Textures(Box::new(problems))
    }
}
