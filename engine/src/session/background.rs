//! What is built on threads of its own while the old picture goes on: texture kernels, and whole renderers where a
//! change reaches what is made once.

use std::sync::Arc;

use texgen::{Diagnostic, Diagnostics, Label, TextureType};

use crate::film::Layers;
use crate::load::{LoadError, Loaded, StandIn};
use crate::procedural::{SourcesError, TextureSources};
use crate::renderer::{Reload, ReloadError, Renderer};
use crate::scene::Moment;
use crate::scene::look::{Look, LookError, Section, Value, find, placed_fields};
use crate::system::{Assets, Task};

use super::difference::TableChange;
use super::moment::timeline;
use super::{Again, Inputs, Record, Recorder, Session, SessionError};

/// Something in the making.
pub(super) enum Job {
    Kernel(Reload),
    Rebuild {
        /// The look's text that it began with.
        text: String,
        /// It was begun for the sake of the look, which couldn't be followed.
        is_for_look: bool,
        /// It was begun while the look wasn't what is shown: what is wrong with files may be its fault.
        blames_look: bool,
        /// What else is done with it, and has to be done without it.
        covers: Again,
        /// Nothing where the files are what is shown.
        task: Task<Result<Option<Box<Rebuilt>>, SessionError>>,
    },
}

/// A renderer and what it shows.
pub(super) struct Rebuilt {
    loaded: Loaded,
    /// What was read for it, if anything was.
    read: Option<Record>,
    renderer: Renderer,
    moment: Moment,
}

/// Loads scene, textures, and a look of this text, at a moment.
pub(super) fn load(
    files: &Arc<dyn Assets>,
    inputs: &Inputs,
    text: &str,
    moment: &Moment,
    stand_in: StandIn,
) -> Result<(Loaded, Record), LoadError> {
    let files = Recorder::new(files);
    let mut loaded = timeline(&files, inputs, text).once(moment)?;
    if let Some(name) = &inputs.camera {
        loaded.camera = loaded.camera_named(name)?;
    }
    loaded.lit_by(stand_in);
    Ok((loaded, files.record()))
}

impl Session {
    /// The files of textures may have changed: those in use whose text is another one are built in the background.
    pub fn sources_changed(&mut self) {
        self.timeline = None;
        if self.job.is_some() {
            self.again.sources = true;
            return;
        }
        let mut is_back = false;
        let changed = self.textures().and_then(|sources| {
            let files = self.renderer.procedural().changed_sources(&sources)?;
            let gone = self.gone(&sources);
            let former = std::mem::replace(&mut self.problems.gone, gone);
            let mut former = former.iter();
            is_back = former.any(|one| !self.problems.gone.as_slice().contains(one));
            Ok(files)
        });
        match changed {
            Ok(files) if files.is_empty() => {
                let was_unfit = std::mem::take(&mut self.is_unfit);
                match self.shown {
                    None => {
                        self.problems.sources = Diagnostics::new();
                        // Nor is what was said of the look with the other textures, or without them, true any more.
                        if was_unfit || is_back {
                            self.assets_changed();
                        }
                    }
                    // A texture that the look waits for may have come.
                    Some(_) => self.catch_up(),
                }
            }
            Ok(files) => {
                self.again.assets |= is_back;
                self.begin_kernel(files);
            }
            Err(error) => self.problems.sources = Diagnostic::error(error.to_string()).into(),
        }
    }

    /// The textures in use whose files aren't there: what is shown can't be rendered again.
    fn gone(&self, sources: &TextureSources) -> Diagnostics {
        let is_named = |node: &str| {
            let section = Section::Node(node.to_owned());
            self.document.table(&section).is_some()
        };
        let gone = self.renderer.procedural().gone_sources(sources, is_named);
        let error = |name| format!("texture `{name}`: its file is gone; the former text is used");
        gone.map(|name| Diagnostic::error(error(name))).collect()
    }

    /// Builds the kernel with textures that changed nodes use for the first time.
    pub(super) fn load_textures(&mut self, changes: &[TableChange]) {
        if self.job.is_some() {
            self.again.sources = true;
            return;
        }
        let library = self.renderer.procedural().graph().library();
        let mut wanted: Vec<&str> = changes
            .iter()
            .filter(|change| matches!(change.section, Section::Node(_)))
            .filter_map(
                |change| match &find(change.after.as_deref()?, "texture")?.value {
                    Value::Text(name) => Some(name.as_str()),
                    _ => None,
                },
            )
            .filter(|name| library.get(name).is_none())
            .collect();
        wanted.sort_unstable();
        wanted.dedup();
        let files: Result<Option<Vec<_>>, SourcesError> = self.textures().and_then(|sources| {
            wanted
                .iter()
                .map(|name| sources.read(name).transpose())
                .collect()
        });
        match files {
            // What doesn't fit what was loaded needs all of it anew; what can't be read is told at its place in the look.
            Ok(Some(files)) => self.begin_kernel(files),
            _ => self.rebuild_for_look(),
        }
    }

    fn begin_kernel(&mut self, files: Vec<texgen::SourceFile>) {
        let procedural = self.renderer.procedural();
        match procedural.library_with(files) {
            // Attributes of meshes are uploaded with the geometry, and tangents and images as they are read. What a
            // parameter was given that is gone or of another type is known by the look alone.
            Ok(library)
                if self.is_unfit
                    || library.custom_attributes() != procedural.reads().attributes
                    || !procedural.reads_as_loaded(&library)
                    || !procedural.graph().keeps_given(&library) =>
            {
                self.is_unfit = true;
                // They are understood by now: what doesn't fit is told of the look.
                self.problems.sources = Diagnostics::new();
                self.rebuild();
            }
            Ok(library) => self.job = Some(Job::Kernel(self.renderer.begin_reload_of(library))),
            Err(problems) => self.problems.sources = problems,
        }
    }

    /// Builds another renderer of the files and the look as they are now.
    pub(super) fn rebuild(&mut self) {
        self.rebuild_for(false);
    }

    /// The same for an edit of the look, which is for nothing once that is undone.
    pub(super) fn rebuild_for_look(&mut self) {
        self.rebuild_for(true);
    }

    fn rebuild_for(&mut self, is_for_look: bool) {
        if self.job.is_some() {
            self.again.rebuild = true;
            return;
        }
        // All that had to be looked at, but for the textures.
        let sources = self.again.sources;
        let former = std::mem::take(&mut self.again);
        let covers = Again {
            sources: false,
            // Not the look, but files are what it is for.
            assets: former.assets || !is_for_look,
            ..former
        };
        self.again.sources = sources;
        self.rebuild_unless(None, is_for_look, covers);
    }

    /// Scene or images may have changed: all is read again in the background, unless they are what is shown.
    pub fn assets_changed(&mut self) {
        if self.job.is_some() {
            self.again.assets = true;
            return;
        }
        let known = self.is_up_to_date().then(|| self.read.clone());
        let covers = Again {
            assets: true,
            ..Again::default()
        };
        self.rebuild_unless(known, false, covers);
    }

    /// Builds another renderer unless files are what was read once.
    fn rebuild_unless(&mut self, known: Option<Record>, is_for_look: bool, covers: Again) {
        let text = self.document.text();
        let (inputs, files) = (self.inputs.clone(), Arc::clone(&self.system.files));
        let (stand_in, moment, look) = (self.stand_in, self.moment.clone(), text.clone());
        // Files may be others by now.
        self.timeline = None;
        self.build(text, is_for_look, covers, move || {
            if known.is_some_and(|known| known.is_of(&*files)) {
                return Ok(None);
            }
            let (loaded, read) = load(&files, &inputs, &look, &moment, stand_in)?;
            Ok(Some((loaded, Some(read))))
        });
    }

    /// Gathers these layers from now on, those that the scene has, whatever the settings say; without them what these say. Nothing is read
    /// again: what is shown is built anew in the background, and begins once more when that is ready.
    pub fn set_layers(&mut self, layers: Option<Layers>) {
        if layers == self.layers {
            return;
        }
        self.layers = layers;
        // Otherwise what is shown isn't what is wanted.
        if !self.is_up_to_date() {
            return self.rebuild();
        }
        let text = self.document.text();
        let loaded = Loaded {
            scene: self.scene.clone(),
            procedural: self.renderer.procedural().clone(),
            camera: self.camera.clone(),
            look: Look::parse(&self.look_path(), &text).ok(),
            given_lights: self.given_lights.clone(),
            has_given_environment: self.has_given_environment,
            has_gone_lights: self.has_gone_lights,
            warnings: self.warnings.clone(),
        };
        let covers = Again::default();
        self.build(text, false, covers, move || Ok(Some((loaded, None))));
    }

    /// Builds another renderer in the background, of what was read by a look's text.
    fn build(
        &mut self,
        text: String,
        is_for_look: bool,
        covers: Again,
        read: impl FnOnce() -> Result<Option<(Loaded, Option<Record>)>, LoadError> + Send + 'static,
    ) {
        let (device, system) = (self.renderer.device().clone(), self.system.clone());
        let (make_settings, layers) = (self.make_settings.clone(), self.layers.clone());
        let moment = self.moment.clone();
        let build = move || {
            let Some((loaded, read)) = read()? else {
                return Ok(None);
            };
            let mut settings = make_settings(loaded.camera.clone());
            settings.time = moment.seconds as f32;
            if let Some(layers) = layers {
                settings.layers = layers.of_scene(&loaded.scene);
            }
            let renderer = Renderer::new(&device, &loaded.scene, &loaded.procedural, &settings)?;
            let renderer = renderer.in_system(&system);
            Ok(Some(Box::new(Rebuilt {
                loaded,
                read,
                renderer,
                moment,
            })))
        };
        match Task::start(&*self.system.threads, "another renderer", build) {
            Ok(task) => {
                self.job = Some(Job::Rebuild {
                    text,
                    is_for_look,
                    blames_look: self.shown.is_some(),
                    covers,
                    task,
                });
            }
            Err(error) => self.problems.look = Diagnostic::error(error.to_string()).into(),
        }
    }

    /// Swaps in what has become ready, and begins what has been waiting for it.
    pub(super) fn swap(&mut self) {
        let is_ready = self.is_job_done();
        if !is_ready.unwrap_or(!self.again.is_empty()) {
            return;
        }
        match self.job.take() {
            Some(Job::Kernel(reload)) => self.finish_kernel(reload),
            Some(Job::Rebuild {
                text,
                is_for_look,
                blames_look,
                covers,
                task,
            }) => {
                let built = task.wait().unwrap_or_else(|_| {
                    let message = "the scene could not be prepared in the background";
                    Err(SessionError::Refused(message.to_owned()))
                });
                // The look has been mended, and what is shown is what is wanted.
                let is_outdated = is_for_look && self.shown.is_none();
                match is_outdated {
                    true => self.still_to_do(covers),
                    false => self.finish_rebuild(text, blames_look, covers, built),
                }
            }
            None => {}
        }
        if self.job.is_none() {
            let again = std::mem::take(&mut self.again);
            if again.rebuild {
                self.rebuild();
                return;
            }
            if again.moment
                && let Err(error) = self.go_to_moment()
            {
                self.problems.moment = Diagnostic::error(error.to_string()).into();
                // Where all is built anew for it, that will be of this moment, or say why not.
                if self.job.is_none() {
                    self.moment = self.shown_moment.clone();
                }
            }
            if again.assets {
                self.assets_changed();
            }
            if again.sources {
                self.sources_changed();
            }
        }
    }

    /// What a rebuild would have brought that isn't wanted any more.
    fn still_to_do(&mut self, covers: Again) {
        self.again.assets |= covers.assets;
        self.again.rebuild |= covers.rebuild;
        self.again.moment |= self.moment != self.shown_moment;
    }

    /// Whether what is built in the background is ready; nothing where nothing is.
    pub(super) fn is_job_done(&self) -> Option<bool> {
        Some(match self.job.as_ref()? {
            Job::Kernel(reload) => reload.is_finished(),
            Job::Rebuild { task, .. } => task.is_finished(),
        })
    }

    fn finish_kernel(&mut self, reload: Reload) {
        let restarts = self.renderer.restarts();
        match self.renderer.finish_reload(reload) {
            Ok(warnings) => {
                self.renew_warnings(warnings);
                self.problems.sources = Diagnostics::new();
                self.generation += u64::from(self.renderer.restarts() != restarts);
                self.catch_up();
            }
            Err(ReloadError::Stale) => self.again.sources = true,
            // The next step finds out and opens another device.
            Err(_) if self.renderer.device().is_lost() => self.again.sources = true,
            Err(ReloadError::Textures(problems)) => self.problems.sources = problems,
            Err(error) => self.problems.sources = Diagnostic::error(error.to_string()).into(),
        }
    }

    /// Those of a change, beside what was odd before and still is.
    fn renew_warnings(&mut self, new: Diagnostics) {
        let textures = self.renderer.procedural().graph().library().textures();
        let files = textures.iter().map(TextureType::file);
        let files: Vec<_> = files
            .flat_map(|file| std::iter::once(file).chain(file.libraries()))
            .collect();
        let is_former = |label: &Label| {
            let mut files = files.iter();
            files.any(|file| file.path() == label.file.path() && file.text() != label.file.text())
        };
        let is_kept = |warning: &&Diagnostic| {
            let is_told_again = |other: &Diagnostic| other.render() == warning.render();
            !warning.labels.iter().any(is_former) && !new.iter().any(is_told_again)
        };
        let mut all: Diagnostics = self.warnings.iter().filter(is_kept).cloned().collect();
        all.append(new);
        self.warnings = all;
    }

    fn finish_rebuild(
        &mut self,
        text: String,
        blames_look: bool,
        covers: Again,
        built: Result<Option<Box<Rebuilt>>, SessionError>,
    ) {
        match built {
            // Whatever was wrong with the files has been mended. The look may be another one by now: what is wrong with it is found again.
            Ok(None) => {
                self.problems.scene = Diagnostics::new();
                // That textures don't fit the look is no matter of these files: it stays until it is found out anew.
                match self.is_unfit {
                    true => self.again.sources = true,
                    false => self.problems.look = Diagnostics::new(),
                }
                self.catch_up();
            }
            Ok(Some(built)) => {
                let Rebuilt {
                    loaded,
                    read,
                    renderer,
                    moment,
                } = *built;
                self.renderer = renderer;
                // Whatever is wrong with files that weren't read again is so still.
                if let Some(read) = read {
                    self.read = read;
                    self.is_behind = false;
                    self.is_unfit = false;
                    self.problems.scene = Diagnostics::new();
                    self.problems.sources = Diagnostics::new();
                    self.problems.gone = Diagnostics::new();
                }
                self.again.sources |= self.is_unfit;
                self.adopt(loaded, moment);
                if let Some(view) = &self.view {
                    self.renderer.set_camera(view);
                }
                self.problems.look = Diagnostics::new();
                self.generation += 1;
                self.shown = Some(placed_fields(&text));
                self.catch_up();
            }
            Err(_) if self.renderer.device().is_lost() => self.again.rebuild = true,
            Err(SessionError::Load(LoadError::Look(LookError::Invalid(problems)))) => {
                self.problems.look = problems;
                self.is_behind |= covers.assets && blames_look;
            }
            Err(error) if blames_look => {
                self.problems.look = Diagnostic::error(error.to_string()).into();
                self.is_behind |= covers.assets;
            }
            Err(error) => self.problems.scene = Diagnostic::error(error.to_string()).into(),
        }
    }
}

impl Again {
    fn is_empty(self) -> bool {
        !self.sources && !self.assets && !self.rebuild && !self.moment
    }
}
