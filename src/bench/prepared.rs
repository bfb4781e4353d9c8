//! Scenes that are measured: built-in ones, and files.

use std::path::{Path, PathBuf};

use engine::load;
use engine::procedural::{Procedural, TextureSources};
use engine::scene::look::{Look, LookError};
use engine::scene::{Camera, Scene, default_camera};
use patina_bench::scenes;

use crate::failure::Failure;
use crate::progress::Bar;
use crate::{console, library};

/// Something to be rendered.
pub(super) struct Prepared {
    pub(super) name: String,
    pub(super) scene: Scene,
    pub(super) procedural: Procedural,
    pub(super) camera: Camera,
}

impl Prepared {
    /// A built-in scene, seen by its first camera.
    ///
    /// # Errors
    /// None, as long as an empty look is one.
    pub(super) fn built_in(name: &str, mut scene: Scene) -> Result<Self, Failure> {
        let nothing = Look::parse(Path::new(""), "")?;
        let procedural = Procedural::build(&nothing, &mut scene, &TextureSources::default())
            .map_err(LookError::from)?;
        let camera = scene.cameras.first().cloned();
        Ok(Self {
            name: name.to_owned(),
            camera: camera.unwrap_or_else(|| default_camera(&scene)),
            procedural,
            scene,
        })
    }

    /// The built-in Cornell box.
    ///
    /// # Errors
    /// As [`Self::built_in`].
    pub(super) fn cornell_box() -> Result<Self, Failure> {
        Self::built_in("Cornell box", scenes::cornell_box())
    }

    /// A file with a look, whose textures are in `folders` first; warnings are printed.
    ///
    /// # Errors
    /// A scene or a look that can't be loaded.
    pub(super) fn load(
        path: &Path,
        look: Option<&Path>,
        folders: &[PathBuf],
        bar: &Bar,
    ) -> Result<Self, Failure> {
        let folders = library::texture_dirs(folders, look)?;
        let loaded = load::load(path, look, &folders)?;
        bar.suspend(|| console::diagnostics(&loaded.warnings));
        Ok(Self {
            name: path.display().to_string(),
            scene: loaded.scene,
            procedural: loaded.procedural,
            camera: loaded.camera,
        })
    }

    /// A file, or without one the Cornell box.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub(super) fn load_or_cornell_box(
        path: Option<&Path>,
        look: Option<&Path>,
        folders: &[PathBuf],
        bar: &Bar,
    ) -> Result<Self, Failure> {
        match path {
            Some(path) => Self::load(path, look, folders, bar),
            None => Self::cornell_box(),
        }
    }
}
