//! Sessions of what is in memory: no file of the disk is read, and work aside may wait until a test says so.

use std::collections::BTreeMap;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use ::device::Device;
use engine::film::Film;
use engine::procedural::TextureSources;
use engine::scene::import::{ImportError, Imported, Importer};
use engine::scene::{Camera, Scene};
use engine::session::{Inputs, Opening, Session};
use engine::system::{Assets, Files, System, Threads};

use super::scenes::{Shot, settings};

/// A scene, its look and its textures.
#[derive(Debug)]
pub(crate) struct InMemory {
    scene: Scene,
    /// The look, and the textures of a folder.
    texts: Mutex<BTreeMap<PathBuf, String>>,
}

const LOOK: &str = "look.toml";
const TEXTURES: &str = "textures";

fn texture_path(name: &str) -> PathBuf {
    Path::new(TEXTURES).join(format!("{name}.wgsl"))
}

impl InMemory {
    /// A scene that is seen by this camera.
    pub(crate) fn new(
        mut scene: Scene,
        view: Camera,
        look: &str,
        textures: &TextureSources,
    ) -> Arc<Self> {
        scene.cameras = vec![view];
        let text = |name| {
            let file = textures.read(name).expect("it is one of theirs");
            let file = file.unwrap_or_else(|error| panic!("{error}"));
            (texture_path(name), file.text().to_owned())
        };
        let mut texts: BTreeMap<PathBuf, String> = textures.names().map(text).collect();
        texts.insert(LOOK.into(), look.to_owned());
        Arc::new(Self {
            scene,
            texts: Mutex::new(texts),
        })
    }

    fn text(&self, path: &Path) -> io::Result<Vec<u8>> {
        let texts = self.texts.lock().expect("unharmed");
        let text = texts.get(path).ok_or(io::ErrorKind::NotFound)?;
        Ok(text.clone().into_bytes())
    }

    /// Saves a texture, as in an editor.
    pub(crate) fn save_texture(&self, name: &str, text: &str) {
        let mut texts = self.texts.lock().expect("unharmed");
        texts.insert(texture_path(name), text.to_owned());
    }

    /// Rendered on a device.
    ///
    /// # Panics
    /// Something of it is wrong.
    pub(crate) fn open(self: &Arc<Self>, device: &Device, shot: Shot) -> Session {
        self.open_with(device, shot, System::default().threads)
    }

    /// As [`Self::open`], with threads of one's own.
    pub(crate) fn open_with(
        self: &Arc<Self>,
        device: &Device,
        shot: Shot,
        threads: Arc<dyn Threads>,
    ) -> Session {
        let system = System {
            files: Arc::clone(self) as Arc<dyn Assets>,
            threads,
            ..System::default()
        };
        let inputs = Inputs {
            scene: PathBuf::from("scene in memory"),
            look: Some(PathBuf::from(LOOK)),
            textures: vec![PathBuf::from(TEXTURES)],
            camera: None,
        };
        let device = device.clone();
        Opening::read(inputs, system)
            .and_then(|opening| {
                opening.start(
                    Arc::new(move || Ok(device.clone())),
                    Arc::new(move |camera| settings(&camera, shot)),
                )
            })
            .unwrap_or_else(|error| panic!("{error}"))
    }
}

impl Files for InMemory {
    fn read_start(&self, path: &Path, length: u64) -> io::Result<Vec<u8>> {
        let mut text = self.text(path)?;
        text.truncate(length as usize);
        Ok(text)
    }

    fn read(&self, path: &Path, _: u64) -> io::Result<Vec<u8>> {
        self.text(path)
    }

    fn has(&self, path: &Path) -> bool {
        self.text(path).is_ok()
    }

    fn list(&self, folder: &Path) -> io::Result<Vec<PathBuf>> {
        let texts = self.texts.lock().expect("unharmed");
        let paths = texts.keys().filter(|path| path.parent() == Some(folder));
        Ok(paths.cloned().collect())
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let text = String::from_utf8(bytes.to_vec()).map_err(io::Error::other)?;
        let mut texts = self.texts.lock().expect("unharmed");
        texts.insert(path.to_owned(), text);
        Ok(())
    }
}

impl Assets for InMemory {
    fn scene(&self, _: &mut Importer, _: &Path) -> Result<Imported, ImportError> {
        Ok(Imported {
            scene: self.scene.clone(),
            ..Imported::default()
        })
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
