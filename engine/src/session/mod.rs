//! Live rendering: a scene, its look and its textures are edited while the picture refines.
//!
//! The text of the look is the truth. Everything else (graph, programs, material records, camera) follows from it and
//! from the files, so that after any number of edits the film is, bit by bit, that of a fresh render of the look as it
//! is then. How a change gets there depends on how far it reaches:
//!
//! | what changes | what happens |
//! |---|---|
//! | keys of nodes, materials, AO tables; the sky's intensity and rotation; the camera | writes to buffers (`follow.rs`) |
//! | the source of a texture; a node of another texture | the texture kernel is built in the background, then swapped |
//! | what is made from the whole look (includes, images, which materials blend), the scene, image files | the renderer is built anew in the background, then swapped |
//!
//! Until the swap the old picture goes on; if the build fails it stays, and [`Session::problems`] tells why. Nothing
//! here knows windows, watches files, or looks at the time: whoever does calls [`Session`].

mod background;
mod difference;
mod edit;
mod follow;
mod view;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use texgen::{Diagnostic, Diagnostics, SourceFile};

use crate::film::Film;
use crate::load::{self, LoadError, Loaded};
use crate::renderer::{Progress, RenderEditError, RenderError, RenderSettings, Renderer};
use crate::scene::look::{Field, Look, LookDocument, LookError};
use crate::scene::{Camera, Scene};
use device::{Device, DeviceError};

use background::Job;

pub use edit::{Edit, written};

/// What is rendered, by files.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// The glTF file.
    pub scene: PathBuf,
    /// The look file, if there is one. It is written by [`Session::save`] only.
    pub look: Option<PathBuf>,
    /// Folders with textures, the earlier ones first.
    pub textures: Vec<PathBuf>,
    /// A camera of the scene in place of the look's.
    pub camera: Option<String>,
}

/// Opens the device; called again when it is lost.
pub type OpenDevice = dyn Fn() -> Result<Device, DeviceError> + Send + Sync;
/// Size and depth of the picture seen by a camera.
pub type MakeSettings = dyn Fn(Camera) -> RenderSettings + Send + Sync;

/// Why something did not happen. The picture and the look are as before.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// What is to be rendered can't be read.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The device.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// An edit that makes no sense.
    #[error("{0}")]
    Refused(String),
    /// The device was lost and can't be opened again. The look is kept: it can be saved, and the next step tries again.
    #[error("the graphics device was lost and can't be used again: {0}; the look is kept")]
    Lost(RenderError),
    /// There is no file to save the look to.
    #[error("there is no look file to save to: name one")]
    NoFile,
    /// The file has been changed by others, and what they wrote has not become part of the look, because it is wrong or has
    /// just been written.
    #[error("{} was changed by another program; mend it there, or save under a name: the same one replaces it", path.display())]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// The look can't be saved.
    #[error("cannot write the look {}: {source}", path.display())]
    Save {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl From<RenderEditError> for SessionError {
    fn from(error: RenderEditError) -> Self {
        match error {
            RenderEditError::Render(error) => Self::Render(error),
            other => Self::Refused(other.to_string()),
        }
    }
}

/// A picture as far as it is.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// Samples of this generation only.
    pub film: Film,
    /// Of the picture; see [`Session::generation`].
    pub generation: u64,
}

/// A render that follows edits. See the module's description.
pub struct Session {
    inputs: Inputs,
    open_device: Arc<OpenDevice>,
    make_settings: Arc<MakeSettings>,
    /// The look as it is wanted.
    document: LookDocument,
    /// The look's text as it was read or written last.
    saved: String,
    /// The tables of the look that is shown, where it isn't the one that is wanted.
    shown: Option<Vec<Field>>,
    /// As it is shown: constants of the look included.
    scene: Scene,
    /// That of the look.
    camera: Camera,
    /// Another one that is looked through meanwhile.
    view: Option<Camera>,
    renderer: Renderer,
    job: Option<Job>,
    /// Something changed that the running job may not have seen.
    again: Again,
    problems: Problems,
    warnings: Diagnostics,
    generation: u64,
    /// All light there may be came from the sky when the scene was loaded.
    was_without_lamp: bool,
}

/// What is to be looked at once the background is free.
#[derive(Debug, Clone, Copy, Default)]
struct Again {
    sources: bool,
    rebuild: bool,
}

/// What is wrong now, by where it was found.
#[derive(Debug, Default)]
struct Problems {
    /// The look's file can't be read, or understood: the look is a former one.
    file: Diagnostics,
    look: Diagnostics,
    sources: Diagnostics,
}

impl std::fmt::Debug for Session {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Session")
            .field("inputs", &self.inputs)
            .field("generation", &self.generation)
            .finish_non_exhaustive()
    }
}

impl Session {
    /// Loads everything and opens the device.
    ///
    /// # Errors
    /// As [`load::load`] and [`Renderer::new`].
    pub fn open(
        inputs: Inputs,
        open_device: Arc<OpenDevice>,
        make_settings: Arc<MakeSettings>,
    ) -> Result<Self, SessionError> {
        let saved = match &inputs.look {
            Some(path) => Look::read_text(path).map_err(LoadError::from)?,
            None => String::new(),
        };
        let loaded = background::load(&inputs, &saved)?;
        let document =
            parse_look(&inputs, &saved).map_err(|e| LoadError::from(LookError::from(e)))?;
        let gpu = open_device().map_err(RenderError::from)?;
        let Loaded {
            scene,
            procedural,
            camera,
            warnings,
            ..
        } = loaded;
        let renderer = Renderer::new(&gpu, &scene, &procedural, &make_settings(camera.clone()))?;
        let mut session = Self {
            was_without_lamp: false,
            inputs,
            open_device,
            make_settings,
            document,
            saved,
            shown: None,
            scene,
            camera,
            view: None,
            renderer,
            job: None,
            again: Again::default(),
            problems: Problems::default(),
            warnings,
            generation: 0,
        };
        session.was_without_lamp = session.has_no_lamp();
        Ok(session)
    }

    /// Swaps in what has become ready in the background, then renders one wave towards `target_spp` samples per pixel.
    ///
    /// # Errors
    /// The device; a lost one is opened again, and the picture starts anew.
    pub fn step(&mut self, target_spp: u32) -> Result<Progress, SessionError> {
        self.poll()?;
        match self.renderer.step(target_spp) {
            Ok(progress) => Ok(progress),
            Err(_) if self.renderer.gpu().is_lost() => {
                self.recover()?;
                Ok(self.renderer.step(target_spp)?)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Swaps in what has become ready in the background, as [`Self::step`] does first. The number of the
    /// [generation](Self::generation) tells whether the picture has begun anew.
    ///
    /// # Errors
    /// The device was lost, and there is no other.
    pub fn poll(&mut self) -> Result<(), SessionError> {
        // Before anything is built for a device that is gone.
        if self.renderer.gpu().is_lost() {
            self.recover()?;
        }
        self.swap();
        Ok(())
    }

    /// The picture as far as it is. All its samples are of the look that is shown now.
    ///
    /// # Errors
    /// The device; a lost one is opened again, and the film is empty.
    pub fn snapshot(&mut self) -> Result<Snapshot, SessionError> {
        let film = match self.renderer.film() {
            Err(_) if self.renderer.gpu().is_lost() => {
                self.recover()?;
                self.renderer.film()?
            }
            film => film?,
        };
        Ok(Snapshot {
            film,
            generation: self.generation,
        })
    }

    /// How often the picture has begun anew: films of different numbers show different things.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// What is wrong with the files as they are now. Empty once it has been mended.
    pub fn problems(&self) -> Diagnostics {
        let Problems {
            file,
            look,
            sources,
        } = &self.problems;
        let all = file.iter().chain(look.iter()).chain(sources.iter());
        all.cloned().collect()
    }

    /// What is odd about what is shown.
    pub fn warnings(&self) -> &Diagnostics {
        &self.warnings
    }

    /// Whether something is being built in the background.
    pub fn is_building(&self) -> bool {
        self.job.is_some()
    }

    /// Whether the picture is that of the look with all edits, or will be once more samples are there.
    pub fn is_up_to_date(&self) -> bool {
        self.job.is_none() && self.shown.is_none()
    }

    /// Begins the picture anew, as it is.
    pub fn restart(&mut self) {
        self.renderer.restart();
        self.generation += 1;
    }

    /// The renderer, to look at.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The scene as it is shown.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The text of the look with all edits.
    pub fn look_text(&self) -> String {
        self.document.text()
    }

    /// Whether there are edits that have not been saved.
    pub fn has_unsaved_edits(&self) -> bool {
        self.document.text() != self.saved
    }

    /// Saves the look to its file, or to `path`: comments, order and formatting of what was not edited are kept.
    ///
    /// # Errors
    /// There is no file, or the system refuses; the look's own file was changed by others and isn't the look as it is known.
    /// An old file is untouched then. With a `path`, whatever is there is replaced.
    pub fn save(&mut self, path: Option<&Path>) -> Result<(), SessionError> {
        let own = self.inputs.look.as_deref();
        if let (None, Some(own)) = (path, own)
            && Look::read_text(own).is_ok_and(|text| text != self.saved)
        {
            let path = own.to_owned();
            return Err(SessionError::Changed { path });
        }
        let path = path.or(own);
        let path = path.ok_or(SessionError::NoFile)?.to_owned();
        let text = self.document.text();
        match self.document.save(&path) {
            Ok(()) => {
                self.saved = text;
                Ok(())
            }
            Err(source) => Err(SessionError::Save { path, source }),
        }
    }

    /// Saves the look to another file, which is its file from then on. In another folder the look is read anew, because
    /// what it names is searched from there.
    ///
    /// # Errors
    /// As [`Self::save`].
    pub fn save_as(&mut self, path: &Path) -> Result<(), SessionError> {
        self.save(Some(path))?;
        let folder = |path: &Path| path.parent().map(Path::to_owned);
        let is_elsewhere = self.inputs.look.as_deref().map(folder) != Some(folder(path));
        self.inputs.look = Some(path.to_owned());
        if is_elsewhere {
            self.rebuild();
        }
        Ok(())
    }

    /// Searches textures in this folder, too, before the others.
    pub fn add_textures(&mut self, folder: PathBuf) {
        if !self.inputs.textures.contains(&folder) {
            self.inputs.textures.insert(0, folder);
            self.sources_changed();
        }
    }

    /// The files to be watched: scene, look, images. Those of textures lie in [`Inputs::textures`].
    pub fn files(&self) -> Vec<PathBuf> {
        let path = self.look_path();
        let look = Look::parse(&path, &self.document.text()).ok();
        let mut files = load::files(&self.inputs.scene, look.as_ref());
        files.extend(self.inputs.look.clone());
        files
    }

    /// What is rendered.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// The look's file may have changed. Its text replaces that of the look, edits that were not saved included.
    pub fn look_changed(&mut self) {
        let Some(path) = self.inputs.look.clone() else {
            return;
        };
        let text = match Look::read_text(&path) {
            Ok(text) => text,
            Err(error) => {
                self.problems.file = Diagnostic::error(error.to_string()).into();
                return;
            }
        };
        if text == self.saved && self.shown.is_none() && !self.has_unsaved_edits() {
            self.problems.file = Diagnostics::new();
            return;
        }
        let checked = Look::parse(&path, &text);
        match (checked, parse_look(&self.inputs, &text)) {
            (Ok(_), Ok(document)) => {
                self.problems.file = Diagnostics::new();
                self.saved = text;
                self.want(document);
            }
            (Err(problems), _) | (_, Err(problems)) => self.problems.file = problems,
        }
    }

    /// Scene or images may have changed: all is read again in the background.
    pub fn assets_changed(&mut self) {
        self.rebuild();
    }

    fn look_path(&self) -> PathBuf {
        self.inputs.look.clone().unwrap_or_default()
    }

    /// The look as a source to point into.
    fn look_file(&self, text: &str) -> SourceFile {
        SourceFile::new("look", self.look_path().display().to_string(), text)
    }

    /// Another device in place of the one that was lost, with everything on it again.
    fn recover(&mut self) -> Result<(), SessionError> {
        let gpu = (self.open_device)().map_err(|e| SessionError::Lost(e.into()))?;
        // What was being built belongs to the lost device.
        match self.job.take() {
            Some(Job::Kernel(_)) => self.again.sources = true,
            Some(Job::Rebuild { .. }) => self.again.rebuild = true,
            None => {}
        }
        let procedural = self.renderer.procedural();
        self.renderer = Renderer::new(&gpu, &self.scene, procedural, self.renderer.settings())
            .map_err(SessionError::Lost)?;
        self.generation += 1;
        Ok(())
    }
}

fn parse_look(inputs: &Inputs, text: &str) -> Result<LookDocument, Diagnostics> {
    LookDocument::parse(inputs.look.as_deref().unwrap_or(Path::new("")), text)
}
