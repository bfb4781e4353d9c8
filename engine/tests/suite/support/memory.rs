//! Sessions of what is in memory: no file is read, and work aside may wait until a test says so.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use ::device::Device;
use engine::film::Film;
use engine::procedural::{SourcesError, TextureSources};
use engine::scene::import::{ImportError, Imported, Importer};
use engine::scene::look::LookError;
use engine::scene::{Camera, Scene};
use engine::session::{Inputs, Opening, Session};
use engine::system::{Files, System, Threads};

use super::scenes::{Shot, settings};

/// A scene, its look and its textures.
#[derive(Debug)]
pub(crate) struct InMemory {
    scene: Scene,
    look: Mutex<String>,
    textures: Mutex<TextureSources>,
}

impl InMemory {
    /// A scene that is seen by this camera.
    pub(crate) fn new(
        mut scene: Scene,
        view: Camera,
        look: &str,
        textures: TextureSources,
    ) -> Arc<Self> {
        scene.cameras = vec![view];
        Arc::new(Self {
            scene,
            look: Mutex::new(look.to_owned()),
            textures: Mutex::new(textures),
        })
    }

    /// Saves a texture, as in an editor.
    pub(crate) fn save_texture(&self, name: &str, text: &str) {
        self.textures.lock().expect("unharmed").insert(name, text);
    }

    /// Rendered on a device.
    ///
    /// # Panics
    /// Something of it is wrong.
    pub(crate) fn open(self: &Arc<Self>, gpu: &Device, shot: Shot) -> Session {
        self.open_with(gpu, shot, System::default().threads)
    }

    /// As [`Self::open`], with threads of one's own.
    pub(crate) fn open_with(
        self: &Arc<Self>,
        gpu: &Device,
        shot: Shot,
        threads: Arc<dyn Threads>,
    ) -> Session {
        let system = System {
            files: Arc::clone(self) as Arc<dyn Files>,
            threads,
            ..System::default()
        };
        let inputs = Inputs {
            scene: PathBuf::from("scene in memory"),
            look: Some(PathBuf::from("look.toml")),
            textures: Vec::new(),
            camera: None,
        };
        let gpu = gpu.clone();
        Opening::read(inputs, system)
            .and_then(|opening| {
                opening.start(
                    Arc::new(move || Ok(gpu.clone())),
                    Arc::new(move |camera| settings(&camera, shot)),
                )
            })
            .unwrap_or_else(|error| panic!("{error}"))
    }
}

impl Files for InMemory {
    fn scene(&self, _: &mut Importer, _: &Path) -> Result<Imported, ImportError> {
        Ok(Imported {
            scene: self.scene.clone(),
            warnings: Vec::new(),
        })
    }

    fn look(&self, _: &Path) -> Result<String, LookError> {
        Ok(self.look.lock().expect("unharmed").clone())
    }

    fn save_look(&self, _: &Path, text: &str) -> io::Result<()> {
        text.clone_into(&mut self.look.lock().expect("unharmed"));
        Ok(())
    }

    fn textures(&self, _: &[PathBuf]) -> Result<TextureSources, SourcesError> {
        Ok(self.textures.lock().expect("unharmed").clone())
    }
}

/// Threads that don't begin before they are told to.
#[derive(Default)]
pub(crate) struct Held {
    waiting: Mutex<Vec<Box<dyn FnOnce() + Send>>>,
}

impl fmt::Debug for Held {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Held").finish_non_exhaustive()
    }
}

impl Held {
    /// Does all that is waiting.
    pub(crate) fn release(&self) {
        let waiting = std::mem::take(&mut *self.waiting.lock().expect("unharmed"));
        waiting.into_iter().for_each(|work| work());
    }
}

impl Threads for Held {
    fn spawn(&self, _: &str, work: Box<dyn FnOnce() + Send>) -> io::Result<()> {
        self.waiting.lock().expect("unharmed").push(work);
        Ok(())
    }
}

/// The film after so many samples.
///
/// # Panics
/// It can't be rendered.
pub(crate) fn film(session: &mut Session, spp: u32) -> Film {
    let step = |session: &mut Session| {
        let progress = session.step(spp).unwrap_or_else(|error| panic!("{error}"));
        progress.is_done()
    };
    while !step(session) {}
    let snapshot = session.snapshot();
    snapshot.unwrap_or_else(|error| panic!("{error}")).film
}

/// Waits until nothing is built any more.
///
/// # Panics
/// The device fails.
pub(crate) fn settle(session: &mut Session) {
    loop {
        session.poll().unwrap_or_else(|error| panic!("{error}"));
        if !session.is_building() {
            // What has been waiting begins with the next look.
            session.poll().unwrap_or_else(|error| panic!("{error}"));
            if !session.is_building() {
                return;
            }
        }
        std::thread::yield_now();
    }
}
