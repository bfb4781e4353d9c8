//! How a session begins: files are read, a device is opened, and the scene goes onto it.

use std::path::PathBuf;
use std::sync::Arc;

use device::{Device, DeviceError};

use crate::load::{LoadError, Loaded, StandIn, Timeline};
use crate::renderer::{RenderError, RenderSettings, Renderer};
use crate::scene::look::{Look, LookDocument, LookError};
use crate::scene::{Animation, Camera, Moment};
use crate::system::{Assets, System};

use super::{Again, Edit, Problems, Record, Recorder, Session, SessionError, parse_look, setting};

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

/// All that is to be rendered, read and checked, before there is a device for it.
#[derive(Debug)]
pub struct Opening {
    inputs: Inputs,
    system: System,
    /// The look's text.
    text: String,
    document: LookDocument,
    loaded: Loaded,
    /// What was read for it.
    read: Record,
    stand_in: StandIn,
    moment: Moment,
}

/// What is rendered at one moment after the other: files are read once. See [`Timeline`].
#[derive(Debug)]
pub struct Sequence {
    inputs: Inputs,
    system: System,
    /// The look's text.
    text: String,
    document: LookDocument,
    edits: Vec<Edit>,
    timeline: Timeline,
    files: Arc<Recorder>,
}

impl Sequence {
    /// Reads the look, as if its file had these edits.
    ///
    /// # Errors
    /// It can't be read, has mistakes, or can't have the edits.
    pub fn read(inputs: Inputs, system: System, edits: &[Edit]) -> Result<Self, SessionError> {
        let text = match &inputs.look {
            Some(path) => Look::read_text(&*system.files, path).map_err(LoadError::from)?,
            None => String::new(),
        };
        let path = inputs.look.clone().unwrap_or_default();
        let text = setting::edited(&path, &text, edits).map_err(SessionError::Refused)?;
        let document =
            parse_look(&inputs, &text).map_err(|e| LoadError::from(LookError::from(e)))?;
        // Edits make a look of what has no file.
        let look = (inputs.look.is_some() || !text.is_empty()).then(|| (path, text.clone()));
        let files = Recorder::new(&system.files);
        let recorded: Arc<dyn Assets> = Arc::clone(&files) as Arc<dyn Assets>;
        let timeline = Timeline::new(&recorded, &inputs.scene, look, &inputs.textures);
        Ok(Self {
            files,
            inputs,
            system,
            text,
            document,
            edits: edits.to_vec(),
            timeline,
        })
    }

    /// See [`Timeline::animations`].
    ///
    /// # Errors
    /// As there.
    pub fn animations(&mut self) -> Result<Vec<Animation>, SessionError> {
        Ok(self.timeline.animations()?)
    }

    /// Reads everything at a moment, as if it were the only one.
    ///
    /// # Errors
    /// As [`crate::load::load`], and where there is no camera of the name that is asked for; a number outside of the range that
    /// a texture declares.
    pub fn at(&mut self, moment: &Moment) -> Result<Opening, SessionError> {
        let loaded = self.timeline.at(moment)?;
        let (inputs, system, text) = (&self.inputs, &self.system, &self.text);
        let opening = Opening {
            inputs: inputs.clone(),
            system: system.clone(),
            text: text.clone(),
            document: self.document.clone(),
            loaded,
            read: self.files.record(),
            stand_in: StandIn::default(),
            moment: moment.clone(),
        };
        opening.checked(&self.edits)
    }

    /// Reads everything at the one moment that is wanted.
    ///
    /// # Errors
    /// As [`Self::at`].
    pub fn once(self, moment: &Moment) -> Result<Opening, SessionError> {
        let opening = Opening {
            inputs: self.inputs,
            system: self.system,
            text: self.text,
            document: self.document,
            loaded: self.timeline.once(moment)?,
            read: self.files.record(),
            stand_in: StandIn::default(),
            moment: moment.clone(),
        };
        opening.checked(&self.edits)
    }
}

impl Opening {
    /// Reads everything.
    ///
    /// # Errors
    /// As [`crate::load::load`], and where there is no camera of the name that is asked for.
    pub fn read(inputs: Inputs, system: System) -> Result<Self, SessionError> {
        Self::read_with(inputs, system, &[])
    }

    /// As [`Self::read`], as if the look's file had these edits.
    ///
    /// # Errors
    /// As [`Self::read`]; a look that can't have them; a number outside of the range that a texture declares.
    pub fn read_with(inputs: Inputs, system: System, edits: &[Edit]) -> Result<Self, SessionError> {
        Sequence::read(inputs, system, edits)?.once(&Moment::default())
    }

    /// With the camera that is asked for, and edits in the ranges that textures declare.
    fn checked(mut self, edits: &[Edit]) -> Result<Self, SessionError> {
        if let Some(name) = &self.inputs.camera {
            self.loaded.camera = self.loaded.camera_named(name)?;
        }
        let mut outside = edits
            .iter()
            .filter_map(|edit| edit.out_of_range(&self.loaded.procedural));
        match outside.next() {
            Some(message) => Err(SessionError::Refused(message)),
            None => Ok(self),
        }
    }

    /// What was read.
    pub fn loaded(&self) -> &Loaded {
        &self.loaded
    }

    /// All files that it was read from, textures included.
    pub fn files(&self) -> Vec<PathBuf> {
        let (files, inputs) = (&*self.system.files, &self.inputs);
        (self.loaded).files(files, &inputs.scene, inputs.look.as_deref())
    }

    /// What was read, for those who render it otherwise than in a session.
    pub fn into_loaded(self) -> Loaded {
        self.loaded
    }

    /// Is seen by this where neither scene nor look has any light.
    #[must_use]
    pub fn lit_by(mut self, stand_in: StandIn) -> Self {
        self.stand_in = stand_in;
        self.loaded.lit_by(stand_in);
        self
    }

    /// Begins with this camera in place of the look's.
    #[must_use]
    pub fn seen_by(mut self, camera: Camera) -> Self {
        self.loaded.camera = camera;
        self
    }

    /// Opens the device, uploads the scene and compiles the kernels.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn start(
        self,
        open_device: Arc<OpenDevice>,
        make_settings: Arc<MakeSettings>,
    ) -> Result<Session, SessionError> {
        let device = open_device().map_err(RenderError::from)?;
        let Loaded {
            scene,
            procedural,
            camera,
            warnings,
            look,
            given_lights,
            has_given_environment,
            has_gone_lights,
        } = self.loaded;
        let settings = make_settings(camera.clone());
        let renderer =
            Renderer::new(&device, &scene, &procedural, &settings)?.in_system(&self.system);
        let mut session = Session {
            was_without_lamp: false,
            stand_in: self.stand_in,
            inputs: self.inputs,
            system: self.system,
            open_device,
            make_settings,
            layers: None,
            document: self.document,
            saved: self.text,
            shown: None,
            scene,
            given_lights,
            has_given_environment,
            has_gone_lights,
            camera,
            view: None,
            look_view: look.map_or_else(Default::default, |look| look.view),
            renderer,
            job: None,
            again: Again::default(),
            is_behind: false,
            is_unfit: false,
            is_gone: false,
            problems: Problems::default(),
            warnings,
            generation: 0,
            shown_moment: self.moment.clone(),
            moment: self.moment,
            timeline: None,
            read: self.read,
        };
        session.was_without_lamp = session.has_no_lamp();
        Ok(session)
    }
}

impl Session {
    /// Shows what was read at another moment, of the same [`Sequence`]: only what has changed is sent to the device, and kernels are
    /// compiled only where a scene needs what the former one didn't. The picture has the same size and layers.
    ///
    /// It begins anew, unless it `goes_on`: then further samples are of this moment, and the picture is the mean of what it has
    /// seen, as a camera's is whose shutter is open meanwhile.
    ///
    /// # Errors
    /// The device.
    pub fn show(
        &mut self,
        opening: Opening,
        settings: &RenderSettings,
        goes_on: bool,
    ) -> Result<(), SessionError> {
        let Opening {
            loaded,
            moment,
            read,
            ..
        } = opening;
        let scenes = [&self.scene, &loaded.scene];
        (self.renderer).show(scenes, &loaded.procedural, settings, goes_on)?;
        (self.moment, self.read) = (moment.clone(), read);
        self.adopt(loaded, moment);
        if !goes_on {
            self.generation += 1;
        }
        Ok(())
    }

    /// Reads everything from the disk and opens the device: [`Opening::read`], then [`Opening::start`].
    ///
    /// # Errors
    /// As both.
    pub fn open(
        inputs: Inputs,
        open_device: Arc<OpenDevice>,
        make_settings: Arc<MakeSettings>,
    ) -> Result<Self, SessionError> {
        Opening::read(inputs, System::default())?.start(open_device, make_settings)
    }
}
