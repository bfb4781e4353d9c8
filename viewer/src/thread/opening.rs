//! How files are opened, and what becomes of those that can't be.

use std::sync::{Arc, Mutex};
use std::time::Instant;

use device::DeviceError;
use engine::load;
use engine::renderer::{RenderSettings, TextureCosts};
use engine::scene::Camera;
use engine::scene::look::Look;
use engine::session::{Inputs, Opening, Session, SessionError};
use engine::system::{Disk, System};

use crate::link::{Files, Reply, lock};

use super::{Pending, Render, Run, publish};

/// Files that have been shown, of which the menu has so many.
const RECENT: usize = 10;

impl Render {
    /// Renders other files, if they can be read.
    pub(super) fn open(&mut self, files: Files) {
        self.publish_loading(true);
        match self.opened(&files) {
            Ok(session) => {
                self.end = end(&session).unwrap_or_default();
                self.is_unheard = self.session.is_some();
                self.recovery = None;
                self.session = Some(session);
                self.run = Run::default();
                self.run.cause = Some(Instant::now());
                // The first picture comes soon, too.
                self.motion = self.run.cause;
                self.before = None;
                self.mixing.forget();
                self.region = None;
                (self.picked, self.outlined, self.beside) = (None, None, None);
                self.pending = Pending::default();
                self.published.forget();
                {
                    let mut board = lock(&self.board);
                    board.status.fatal = None;
                    board.status.refused = None;
                    board.status.textures = TextureCosts::default();
                }
                self.waiting = None;
                self.publish_scene();
                self.watch();
                self.remember(&files);
                self.reply(Reply::Opened(files));
            }
            Err(why) => self.refuse(files, why),
        }
        self.publish_loading(false);
    }

    /// Puts files in front of those that have been shown.
    fn remember(&self, files: &Files) {
        let files = files.absolute();
        let former = Arc::clone(&lock(&self.board).recent);
        let others = former.iter().filter(|other| **other != files).cloned();
        let list: Vec<Files> = [files.clone()]
            .into_iter()
            .chain(others)
            .take(RECENT)
            .collect();
        if let Err(why) = self.host.keep_recent(&list) {
            self.reply(Reply::Failed(why));
        }
        lock(&self.board).recent = list.into();
    }

    /// Files can't be opened. Where there is nothing else to show, that stays in sight until they have been mended.
    fn refuse(&mut self, files: Files, why: String) {
        self.host.report(&why);
        if self.session.is_some() {
            return self.reply(Reply::Failed(why));
        }
        let look = files.look.as_deref().and_then(|path| {
            let text = Look::read_text(&Disk, path).ok()?;
            Look::parse(path, &text).ok()
        });
        let mut watched = load::files(&files.scene, look.as_ref());
        watched.extend(files.look.clone());
        let textures = self.host.texture_folders(files.look.as_deref());
        let textures = textures.unwrap_or_default();
        // Where the system offers no way, they can be opened again by hand.
        let _ = (self.host).watch(&watched, files.look.as_deref(), &textures);
        lock(&self.board).status.refused = Some(why);
        self.waiting = Some(files);
    }

    fn opened(&self, files: &Files) -> Result<Session, String> {
        let inputs = Inputs {
            scene: files.scene.clone(),
            look: files.look.clone(),
            textures: self.host.texture_folders(files.look.as_deref())?,
            camera: files.camera.clone(),
        };
        // What is shown lies on this device, which may be the window's: there can be no other one.
        let (device, is_first) = (self.device.clone(), Mutex::new(true));
        let open_device = move || {
            let mut is_first = is_first
                .lock()
                .map_err(|e| DeviceError::Lost(e.to_string()))?;
            match std::mem::replace(&mut *is_first, false) {
                true => Ok(device.clone()),
                false => Err(DeviceError::Lost(
                    "the window has to be opened again".to_owned(),
                )),
            }
        };
        let (size, max_depth, seed) = (
            Arc::clone(&self.size),
            self.options.max_depth,
            self.options.seed,
        );
        let make_settings = move |camera: Camera| {
            let [width, height] = *size
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner);
            RenderSettings {
                max_depth,
                seed,
                ..RenderSettings::new(width, height, &camera)
            }
        };
        let opened = Opening::read(inputs, System::default()).and_then(|opening| {
            let opening = opening.lit_by(self.stand_in);
            opening.start(Arc::new(open_device), Arc::new(make_settings))
        });
        opened.map_err(|error| publish::message(&error))
    }

    pub(super) fn watch(&mut self) {
        let Some(session) = &self.session else {
            return;
        };
        let inputs = session.inputs();
        let watched = self
            .host
            .watch(&session.files(), inputs.look.as_deref(), &inputs.textures);
        if let Err(why) = watched {
            self.reply(Reply::Failed(why));
        }
    }
}

/// When a scene's last animation ends, seconds. What is wrong with animations is told where one is shown.
pub(super) fn end(session: &Session) -> Result<Option<f64>, SessionError> {
    let animations = session.animations()?;
    let ends = animations.iter().map(|animation| animation.end);
    Ok(ends.filter(|&end| end > 0.0).reduce(f64::max))
}
