//! The boundary of the engine: a scene, its look and its textures are opened, edited while the picture refines, and saved.
//! Whatever renders (commands, windows, other programs) uses this and nothing below.
//!
//! | to | there is |
//! |---|---|
//! | open | [`Session::open`]; with something to do between reading and rendering, [`Opening`] |
//! | edit | [`Session::edit`] with an [`Edit`], which can come as [JSON](json); [`Session::replace_look`] |
//! | edit with a history, while the session may be busy on another thread | a [`Document`], whose [`Change`]s wait in a [`ChangeQueue`] for [`Session::apply`] |
//! | render | [`Session::step`], wave by wave |
//! | see | [`Session::snapshot`] (a film), [`Session::device_film`] (on the device), [`Session::stats`], [`Session::problems`] |
//! | save the look | [`Session::save`] |
//! | keep edits that can't be saved | [`Recovery`] |
//! | go to another moment of a scene that moves | [`Session::set_moment`] |
//! | keep other layers of the film than at first | [`Session::set_layers`] |
//! | bring edits together with what others have saved meanwhile | [`Session::look_changed_beside_edits`], [`merge`] |
//!
//! The text of the look is the truth. Everything else (graph, programs, material records, camera) follows from it and
//! from the files, so that after any number of edits the film is, bit by bit, that of a fresh render of the look as it
//! is then. How a change gets there depends on how far it reaches:
//!
//! | what changes | what happens |
//! |---|---|
//! | `[view]` | nothing: whoever shows the picture asks for [`Session::look_view`] |
//! | `[graph.NAME]` | nothing at all: it is of whoever shows the look as a graph |
//! | keys of nodes, materials, AO tables; the sky's intensity and rotation; lights but for rectangles; the camera | writes to buffers (`follow.rs`) |
//! | the source of a texture; a node of another texture | the texture kernel is built in the background, then swapped |
//! | the same, where parameters that have values or links go or change their types | as the next line, for the look's sake |
//! | what is made from the whole look (includes, documents of materials, images, which materials blend, tangents that something lies along for the first time), the scene, image files | the renderer is built anew in the background, then swapped |
//!
//! Until the swap the old picture goes on; if the build fails it stays, and [`Session::problems`] tells why. Nothing
//! here knows windows, watches files, or looks at the time: whoever does calls [`Session`]. Files are read, and work is done
//! aside, by the [`System`] that is handed in.

mod background;
mod change;
mod difference;
mod document;
mod edit;
mod error;
mod files;
mod follow;
pub mod json;
mod lights;
mod merge;
mod moment;
mod moved;
mod open;
mod patch;
mod record;
mod recovery;
mod setting;
mod view;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use texgen::{Diagnostics, SourceFile};

use device::Device;

use crate::film::{Film, Layers};
use crate::load::{StandIn, Timeline};
use crate::procedural::Procedural;
use crate::renderer::{Progress, RenderSettings, Renderer};
use crate::scene::look::{Field, LookDocument};
use crate::scene::view::ViewChoice;
use crate::scene::{Camera, Moment, PunctualLight, Scene};
use crate::stats::Stats;
use crate::system::System;

use background::Job;
use record::{Record, Recorder};

pub use change::{Change, ChangeQueue};
pub use document::Document;
pub use edit::{Edit, summary, written};
pub use error::SessionError;
pub use merge::{Merged, merge};
pub use open::{Inputs, MakeSettings, OpenDevice, Opening, Sequence};
pub use recovery::Recovery;

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
    system: System,
    open_device: Arc<OpenDevice>,
    make_settings: Arc<MakeSettings>,
    /// What the film gathers, where that isn't what its settings say.
    layers: Option<Layers>,
    /// The look as it is wanted.
    document: LookDocument,
    /// The look's text as it was read or written last.
    saved: String,
    /// The tables of the look that is shown, where it isn't the one that is wanted.
    shown: Option<Vec<Field>>,
    /// As it is shown: constants of the look included.
    scene: Scene,
    /// Its lights without the look's `[light.NAME]`.
    given_lights: Vec<PunctualLight>,
    /// Whether its file has light from all directions of its own.
    has_given_environment: bool,
    /// Whether its files have lights that are gone at the moment that is shown.
    has_gone_lights: bool,
    /// That of the look.
    camera: Camera,
    /// How the look has its picture shown.
    look_view: ViewChoice,
    /// Another one that is looked through meanwhile.
    view: Option<Camera>,
    renderer: Renderer,
    job: Option<Job>,
    /// Something changed that the running job may not have seen.
    again: Again,
    /// Files of the scene have changed that could not be shown with a look that is wrong: once it is mended they are read again.
    is_behind: bool,
    /// Textures have changed so that all has to be built anew, and that hasn't succeeded yet.
    is_unfit: bool,
    /// The look's file isn't there any more.
    is_gone: bool,
    problems: Problems,
    warnings: Diagnostics,
    generation: u64,
    /// All light there may be came from the sky when the scene was loaded.
    was_without_lamp: bool,
    /// What it is seen by then.
    stand_in: StandIn,
    /// Of a scene that moves: the one that is wanted.
    moment: Moment,
    shown_moment: Moment,
    /// The files as they were read for other moments, with the look's text of then.
    timeline: Option<(String, Timeline, Arc<Recorder>)>,
    /// What was read for what is shown.
    read: Record,
}

/// What is to be looked at once the background is free.
#[derive(Debug, Clone, Copy, Default)]
struct Again {
    sources: bool,
    assets: bool,
    rebuild: bool,
    /// The moment that is wanted isn't that of what is shown.
    moment: bool,
}

/// What is wrong now, by where it was found.
#[derive(Debug, Default)]
struct Problems {
    /// The look's file can't be read, or understood: the look is a former one.
    file: Diagnostics,
    look: Diagnostics,
    /// Files of the scene that were read because they had changed: what is shown is of former ones, whatever becomes of the look.
    scene: Diagnostics,
    /// The moment that was asked for while something was built can't be shown: another one is.
    moment: Diagnostics,
    sources: Diagnostics,
    /// Files of textures in use that aren't there any more.
    gone: Diagnostics,
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
    /// Swaps in what has become ready in the background, then renders one wave towards `target_spp` samples per pixel.
    ///
    /// # Errors
    /// The device; a lost one is opened again, and the picture starts anew.
    pub fn step(&mut self, target_spp: u32) -> Result<Progress, SessionError> {
        self.poll()?;
        self.advance(target_spp)
    }

    /// Renders one wave as [`Self::step`] does, of what is shown: nothing is swapped in.
    ///
    /// # Errors
    /// As there.
    pub fn advance(&mut self, target_spp: u32) -> Result<Progress, SessionError> {
        match self.renderer.step(target_spp) {
            Ok(progress) => Ok(progress),
            Err(_) if self.renderer.device().is_lost() => {
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
        if self.renderer.device().is_lost() {
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
            Err(_) if self.renderer.device().is_lost() => {
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
            scene,
            moment,
            sources,
            gone,
        } = &self.problems;
        let all = [file, look, scene, moment, sources, gone].into_iter();
        all.flat_map(Diagnostics::iter).cloned().collect()
    }

    /// What is odd about what is shown.
    pub fn warnings(&self) -> &Diagnostics {
        &self.warnings
    }

    /// Whether something has become ready in the background, which the next [`poll`](Self::poll) swaps in.
    pub fn has_built(&self) -> bool {
        self.is_job_done().unwrap_or(false)
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

    /// The device that renders; another one once this one was lost.
    pub fn device(&self) -> &Device {
        self.renderer.device()
    }

    /// How it is rendered, with the camera of now.
    pub fn settings(&self) -> &RenderSettings {
        self.renderer.settings()
    }

    /// The texture graph as it is shown.
    pub fn procedural(&self) -> &Procedural {
        self.renderer.procedural()
    }

    /// Figures so far, of what has been rendered since something was built anew last.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn stats(&self) -> Result<Stats, SessionError> {
        Ok(self.renderer.stats()?)
    }

    /// The scene as it is shown.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The text of the look with all edits.
    pub fn look_text(&self) -> String {
        self.document.text()
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
        let device = (self.open_device)().map_err(|e| SessionError::Lost(e.into()))?;
        // What was being built belongs to the lost device.
        match self.job.take() {
            Some(Job::Kernel(_)) => self.again.sources = true,
            Some(Job::Rebuild { .. }) => self.again.rebuild = true,
            None => {}
        }
        let procedural = self.renderer.procedural();
        let settings = self.renderer.settings();
        let renderer = Renderer::new(&device, &self.scene, procedural, settings);
        let renderer = renderer.map_err(SessionError::Lost)?;
        self.renderer = renderer.in_system(&self.system);
        self.generation += 1;
        Ok(())
    }
}

fn parse_look(inputs: &Inputs, text: &str) -> Result<LookDocument, Diagnostics> {
    LookDocument::parse(inputs.look.as_deref().unwrap_or(Path::new("")), text)
}
