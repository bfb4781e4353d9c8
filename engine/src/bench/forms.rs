//! The forms in which textures are compared, and one renderer for all of them.

use texgen::SourceFile;

use device::{Device, KernelText};

use crate::{
    film::Film,
    passes::proctex::TextureForm,
    procedural::{EditError, Procedural},
    renderer::{ReloadError, RenderEditError, RenderError, RenderSettings, Renderer},
    scene::Scene,
};

use super::rayquery::RayQueryRenderer;

/// How textures get into a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// [`TextureForm::Stack`]: what this project does.
    Stack,
    /// [`TextureForm::Inlined`].
    Inlined,
    /// A path tracer in one kernel on ray queries: [`RayQueryRenderer`].
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
}

/// Renders a scene with its textures in one of the forms.
#[derive(Debug)]
pub enum FormRenderer {
    /// Pass by pass.
    Passes(Box<Renderer>),
    /// In one kernel.
    RayQuery(Box<RayQueryRenderer>),
}

impl FormRenderer {
    /// Uploads the scene and compiles the kernels.
    ///
    /// # Errors
    /// As [`Renderer::with_form`] and [`RayQueryRenderer::new`].
    pub fn new(
        gpu: &Device,
        scene: &Scene,
        procedural: &Procedural,
        settings: &RenderSettings,
        form: Form,
    ) -> Result<Self, RenderError> {
        let passes = |form| -> Result<Self, RenderError> {
            let renderer = Renderer::with_form(gpu, scene, procedural, settings, form)?;
            Ok(Self::Passes(Box::new(renderer)))
        };
        match form {
            Form::Stack => passes(TextureForm::Stack),
            Form::Inlined => passes(TextureForm::Inlined),
            Form::RayQuery => {
                let renderer = RayQueryRenderer::new(gpu, scene, procedural, settings)?;
                Ok(Self::RayQuery(Box::new(renderer)))
            }
        }
    }

    /// Renders up to so many samples per pixel.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn render(&mut self, target_spp: u32) -> Result<(), RenderError> {
        match self {
            Self::Passes(renderer) => renderer.render(target_spp),
            Self::RayQuery(renderer) => renderer.render(target_spp),
        }
    }

    /// Forgets all samples.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn restart(&mut self) -> Result<(), RenderError> {
        match self {
            Self::Passes(renderer) => {
                renderer.restart();
                Ok(())
            }
            Self::RayQuery(renderer) => renderer.restart(),
        }
    }

    /// What has been gathered so far.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn film(&self) -> Result<Film, RenderError> {
        match self {
            Self::Passes(renderer) => renderer.film(),
            Self::RayQuery(renderer) => renderer.film(),
        }
    }

    /// Changes the texture graph: buffer writes in the stack form, a kernel in the others.
    ///
    /// # Errors
    /// What the graph refuses, or the device.
    pub fn edit_graph(
        &mut self,
        change: impl FnOnce(&mut Procedural) -> Result<(), EditError>,
    ) -> Result<(), RenderEditError> {
        match self {
            Self::Passes(renderer) => renderer.edit_graph(change),
            Self::RayQuery(renderer) => renderer.edit_graph(change),
        }
    }

    /// Puts these textures in the place of those of their names: a kernel in all forms.
    ///
    /// # Errors
    /// Wrong textures, with file and line; a kernel that the driver refuses.
    pub fn reload(&mut self, files: Vec<SourceFile>) -> Result<(), ReloadError> {
        match self {
            Self::Passes(renderer) => {
                let reload = renderer.begin_reload(files);
                renderer.finish_reload(reload).map(|_| ())
            }
            Self::RayQuery(renderer) => renderer.reload(files),
        }
    }

    /// The texture graph as it is now.
    pub fn procedural(&self) -> &Procedural {
        match self {
            Self::Passes(renderer) => renderer.procedural(),
            Self::RayQuery(renderer) => renderer.procedural(),
        }
    }

    /// Bytes of private memory that a thread of the kernel with the textures asks for, by the kernel's types: see
    /// [`texgen::kernel_private_bytes`]. 0 where no kernel has textures in it, as for gray in the first two forms; in the
    /// third the path tracer itself is there.
    pub fn private_bytes(&self) -> u32 {
        match self {
            Self::Passes(renderer) => renderer.texture_private_bytes().unwrap_or(0),
            Self::RayQuery(renderer) => renderer.private_bytes(),
        }
    }

    /// The text of that kernel, for tools; none where no kernel has textures in it.
    ///
    /// # Errors
    /// Programs that have no inlined form.
    pub fn kernel_text(&self) -> Result<Option<KernelText>, RenderError> {
        match self {
            Self::Passes(renderer) => renderer.texture_kernel_text(),
            Self::RayQuery(renderer) => renderer.kernel_text().map(Some),
        }
    }
}
