//! Hot reload: the generated kernel is built anew on a thread of its own while the old one keeps rendering, and is
//! swapped between two waves. Whatever fails leaves kernel, graph and picture as they are.

use std::sync::Arc;

use texgen::{Diagnostics, Library, SourceFile, TextureType};

use device::{Device, Kernel, KernelCost};

use crate::{gpu_scene::SceneFeatures, procedural::Procedural, schedule::Schedule, system::Task};

use super::pipeline::texture_kernel;
use super::{RenderError, Renderer, edits};

/// Why changed textures are not in use. The former ones still are.
#[derive(Debug, thiserror::Error)]
pub enum ReloadError {
    /// Their text is wrong, or doesn't fit the nodes any more: with file and line.
    #[error("{0}")]
    Textures(Diagnostics),
    /// The device, or its driver.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Another reload was finished after this one had begun.
    #[error("the textures were changed by another reload meanwhile: begin this one again")]
    Stale,
    /// The thread that built the kernel did not start, or ended without a result.
    #[error("the texture kernel could not be built in the background: {0}")]
    Thread(String),
}

impl From<Diagnostics> for ReloadError {
    fn from(problems: Diagnostics) -> Self {
        Self::Textures(problems)
    }
}

/// A texture kernel in the making; see [`Renderer::begin_reload`]. Dropped, it is built for nothing.
#[derive(Debug)]
pub struct Reload {
    /// The library it began with.
    base: Arc<Library>,
    task: Result<Task<Result<Built, ReloadError>>, ReloadError>,
}

#[derive(Debug)]
struct Built {
    library: Arc<Library>,
    /// None where no material has a program, and where edits made meanwhile change it.
    kernel: Option<Kernel>,
    stack_slots: u32,
}

impl Reload {
    /// Whether it is done, well or badly: then [`Renderer::finish_reload`] doesn't wait.
    pub fn is_finished(&self) -> bool {
        self.task.as_ref().map_or(true, Task::is_finished)
    }

    fn wait(self) -> Result<Built, ReloadError> {
        self.task?.wait().map_err(ReloadError::Thread)?
    }
}

impl Renderer {
    /// Begins to build the kernel with these textures in the place of those of their names, or beside them. Returns at
    /// once; rendering and edits go on with the old kernel. Hand the result to [`Self::finish_reload`] when it
    /// [is finished](Reload::is_finished).
    pub fn begin_reload(&self, files: Vec<SourceFile>) -> Reload {
        let procedural = self.procedural.clone();
        self.begin(move || Ok(Arc::new(procedural.library_with(files)?)))
    }

    /// As [`Self::begin_reload`], with textures that have been read: see [`Procedural::library_with`].
    pub fn begin_reload_of(&self, library: Library) -> Reload {
        self.begin(move || Ok(Arc::new(library)))
    }

    /// What it took to compile the texture kernel that is in use, if there is one.
    pub fn texture_kernel_cost(&self) -> Option<KernelCost> {
        self.kernels.texture_cost()
    }

    fn begin(
        &self,
        library: impl FnOnce() -> Result<Arc<Library>, ReloadError> + Send + 'static,
    ) -> Reload {
        let (device, procedural) = (self.device.clone(), self.procedural.clone());
        let (features, schedule) = (self.scene.features, Arc::clone(&self.schedule));
        Reload {
            base: Arc::clone(procedural.graph().library()),
            task: Task::start(&*self.system.threads, "texture kernel", move || {
                build(&device, &procedural, &features, &*schedule, library()?)
            })
            .map_err(|error| ReloadError::Thread(error.to_string())),
        }
    }

    /// Swaps the kernel for the one that was built, waiting for it if need be, and starts the picture anew, unless textures have only been added. Edits made
    /// since [`Self::begin_reload`] are kept. Returns what is odd about the change but not wrong: values that don't fit
    /// a parameter's new type, warnings of the textures.
    ///
    /// # Errors
    /// Wrong textures, with file and line; a kernel that the driver refuses; then nothing has changed.
    pub fn finish_reload(&mut self, reload: Reload) -> Result<Diagnostics, ReloadError> {
        let is_current = Arc::ptr_eq(&reload.base, self.procedural.graph().library());
        let built = reload.wait()?;
        if !is_current {
            return Err(ReloadError::Stale);
        }
        let is_more = has_more(self.procedural.graph().library(), &built.library);
        let procedural = self.procedural.with_library(built.library)?;
        // Edits made meanwhile may have brought the first program, or one that needs a larger stack.
        let fits = |_: &Kernel| built.stack_slots >= procedural.stack_slots();
        let kernel = match built.kernel.filter(fits) {
            Some(kernel) if !procedural.is_empty() => Some(kernel),
            _ => texture_kernel(
                &self.device,
                &self.scene.features,
                &procedural,
                &*self.schedule,
            )?,
        };
        // On copies of the handles, so that a device without memory leaves all as it is.
        let mut resources = self.resources.clone();
        let words = procedural.result_words() + self.scene.features.path_words();
        self.schedule
            .grow_results(&self.device, self.capacity, words, &mut resources)
            .map_err(RenderError::from)?;
        self.lanes
            .grow_results(&self.device, &*self.schedule, self.capacity, words)
            .map_err(RenderError::from)?;
        edits::allocate(&self.device, &procedural, &*self.schedule, &mut resources)?;
        if let Some(kernel) = kernel {
            self.kernels
                .set_texture(&self.device, &self.scene.features, kernel)?;
        }
        self.resources = resources;
        self.procedural = procedural;
        self.bind();
        if !is_more {
            self.restart();
        }
        self.device.check().map_err(RenderError::from)?;
        Ok(self.procedural.warnings().clone())
    }
}

/// Whether a library has all textures of a former one as they were, so that those in use give what they gave.
fn has_more(former: &Library, library: &Library) -> bool {
    let is_there = |texture: &TextureType| {
        let former = texture.file();
        let now = library.get(texture.name()).map(TextureType::file);
        now.is_some_and(|now| now.text() == former.text() && now.libraries() == former.libraries())
    };
    former.textures().iter().all(is_there)
}

/// What the thread does.
fn build(
    device: &Device,
    procedural: &Procedural,
    features: &SceneFeatures,
    schedule: &dyn Schedule,
    library: Arc<Library>,
) -> Result<Built, ReloadError> {
    let procedural = procedural.with_library(Arc::clone(&library))?;
    let kernel = match schedule.edits_are_code() {
        true => None,
        false => texture_kernel(device, features, &procedural, schedule)?,
    };
    Ok(Built {
        library,
        kernel,
        stack_slots: procedural.stack_slots(),
    })
}
