//! What the window wants of the program that opens it: file events, and the formats of pictures. Files are read and
//! written there, as for every other command.

use std::path::{Path, PathBuf};

use engine::film::{Film, Origin};

/// What of the files that are rendered has changed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Changes {
    /// A texture, or what may become one.
    pub textures: bool,
    /// The look.
    pub look: bool,
    /// The scene, what it is made of, or an image.
    pub assets: bool,
}

/// The program around the window. It is called on the render's thread.
pub trait Host: Send {
    /// Folders in which the textures of a look are searched.
    ///
    /// # Errors
    /// A folder that isn't there; the text is for people.
    fn texture_folders(&self, look: Option<&Path>) -> Result<Vec<PathBuf>, String>;

    /// Watches these files and folders from now on, in place of others.
    ///
    /// # Errors
    /// The system offers no way; the text is for people.
    fn watch(
        &mut self,
        files: &[PathBuf],
        look: Option<&Path>,
        textures: &[PathBuf],
    ) -> Result<(), String>;

    /// What has changed since the last call. Returns at once.
    fn changes(&mut self) -> Changes;

    /// Writes a film as linear radiance (.exr), and where it came from.
    ///
    /// # Errors
    /// The text is for people.
    fn write_film(&self, path: &Path, film: &Film, origin: &Origin) -> Result<(), String>;

    /// Writes 8-bit RGBA as it is shown on screen (.png, .jpg).
    ///
    /// # Errors
    /// The text is for people.
    fn write_shown(&self, path: &Path, size: [u32; 2], rgba: &[u8]) -> Result<(), String>;
}
