//! A scene that moves, at a moment of one's own: none of it is part of the look.

use std::path::PathBuf;
use std::sync::Arc;

use texgen::Diagnostics;

use crate::load::{Loaded, Timeline};
use crate::renderer::RenderSettings;
use crate::scene::look::{Field, Value, placed_fields};
use crate::scene::{Animation, Moment};
use crate::system::Assets;

use super::{Inputs, Recorder, Session, SessionError};

impl Session {
    /// The animations of the scene's own file, which is read for them.
    ///
    /// # Errors
    /// As [`Timeline::animations`].
    pub fn animations(&self) -> Result<Vec<Animation>, SessionError> {
        let files = Recorder::new(&self.system.files);
        let mut timeline = timeline(&files, &self.inputs, "");
        Ok(timeline.animations()?)
    }

    /// The moment that is shown, or will be once what is being built is ready.
    pub fn moment(&self) -> &Moment {
        &self.moment
    }

    /// The moment of what is shown by now.
    pub fn shown_moment(&self) -> &Moment {
        &self.shown_moment
    }

    /// Shows the scene as it is at another moment. Only what has changed is sent to the device, and files are read again only after
    /// the look has been edited. Whatever is edited or built meanwhile is of this moment, too.
    ///
    /// # Errors
    /// The scene can't be read, or makes no sense at that moment: then it is shown as before. The device.
    pub fn set_moment(&mut self, moment: &Moment) -> Result<(), SessionError> {
        if *moment == self.moment {
            self.problems.moment = Diagnostics::new();
            return Ok(());
        }
        if self.job.is_some() {
            // What is being built is of the former moment.
            self.moment = moment.clone();
            self.again.moment = true;
            return Ok(());
        }
        let former = std::mem::replace(&mut self.moment, moment.clone());
        let gone = self.go_to_moment();
        if gone.is_err() && self.job.is_none() {
            self.moment = former;
        }
        gone
    }

    /// Shows what is wanted.
    pub(super) fn go_to_moment(&mut self) -> Result<(), SessionError> {
        let moment = self.moment.clone();
        let text = self.document.text();
        let former = self.timeline.take().filter(|(of, ..)| *of == text);
        let (mut timeline, files) = match former {
            Some((_, timeline, files)) => (timeline, files),
            None => {
                let files = Recorder::new(&self.system.files);
                (timeline(&files, &self.inputs, &text), files)
            }
        };
        let mut loaded = timeline.at(&moment)?;
        let read = files.record();
        self.timeline = Some((text.clone(), timeline, files));
        if let Some(name) = &self.inputs.camera {
            loaded.camera = loaded.camera_named(name)?;
        }
        loaded.lit_by(self.stand_in);
        let settings = RenderSettings {
            camera: self.view.as_ref().unwrap_or(&loaded.camera).clone(),
            time: moment.seconds as f32,
            ..self.renderer.settings().clone()
        };
        let (scenes, procedural) = ([&self.scene, &loaded.scene], &loaded.procedural);
        if let Err(error) = self.renderer.show(scenes, procedural, &settings, false) {
            // What is on the device now is of no use.
            self.rebuild();
            return Err(error.into());
        }
        self.adopt(loaded, moment);
        self.read = read;
        self.generation += 1;
        self.shown = Some(placed_fields(&text));
        self.catch_up();
        Ok(())
    }

    /// Takes over what the renderer shows.
    pub(super) fn adopt(&mut self, loaded: Loaded, moment: Moment) {
        self.shown_moment = moment;
        self.problems.moment = Diagnostics::new();
        self.scene = loaded.scene;
        self.given_lights = loaded.given_lights;
        self.has_given_environment = loaded.has_given_environment;
        self.has_gone_lights = loaded.has_gone_lights;
        self.camera = loaded.camera;
        self.warnings = loaded.warnings;
        self.look_view = loaded.look.map_or_else(Default::default, |look| look.view);
        self.was_without_lamp = self.has_no_lamp();
    }
}

/// A scene with a look of this text, of which nothing has been read yet.
pub(super) fn timeline(files: &Arc<Recorder>, inputs: &Inputs, text: &str) -> Timeline {
    // Edits of a look without a file are one, too.
    let has_look = inputs.look.is_some() || !text.is_empty();
    let path: PathBuf = inputs.look.clone().unwrap_or_default();
    let look = has_look.then(|| (path, text.to_owned()));
    let files: Arc<dyn Assets> = Arc::clone(files) as Arc<dyn Assets>;
    Timeline::new(&files, &inputs.scene, look, &inputs.textures)
}

/// Whether a value of these depends on the moment. A table that is read alone is read at its beginning.
pub(super) fn has_keys(fields: &[Field]) -> bool {
    fields.iter().any(|field| is_keyed(&field.value.value))
}

fn is_keyed(value: &Value) -> bool {
    match value {
        Value::Table(fields) => fields.iter().any(|f| f.key.value == "keys") || has_keys(fields),
        Value::List(items) => items.iter().any(|item| is_keyed(&item.value)),
        _ => false,
    }
}
