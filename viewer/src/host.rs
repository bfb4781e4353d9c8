//! What the window wants of the program that opens it: file events, and the formats of pictures. Files are read and
//! written there, as for every other command.

use std::path::{Path, PathBuf};
use std::time::Duration;

use engine::denoise::Denoiser;
use engine::film::{Film, Layers, Origin};
use engine::scene::view::View;

use crate::link::{Files, Waker};

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

/// A picture that is to be written.
#[derive(Debug, Clone, Copy)]
pub struct Finished<'a> {
    /// What was gathered.
    pub film: &'a Film,
    /// Those of its layers that files hold.
    pub layers: &'a Layers,
    /// Its radiance without the noise, and what has taken it out.
    pub denoised: Option<(&'a [[f32; 3]], &'a str)>,
    /// Where it comes from.
    pub origin: &'a Origin,
    /// How it is shown.
    pub view: &'a View,
}

/// Opens what takes noise out of pictures, or says why there is none and what to do; the text is for people. Called on a thread of its own.
pub type OpenDenoiser = Box<dyn FnOnce() -> Result<Denoiser, String> + Send>;

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

    /// Is handed what is to be called when there may be changes, before anything is watched.
    fn wake_by(&mut self, waker: Waker);

    /// How long nobody needs to ask for changes, unless he is woken.
    fn patience(&self) -> Duration;

    /// Whether the program is to end, as by a signal. Asked in each turn of the render: what is not saved is kept then, and the window
    /// closes.
    fn is_ending(&self) -> bool {
        false
    }

    /// The window is about to close; the text says where edits are that were not saved, or why they could not be kept.
    fn ends(&self, _kept: Option<&str>) {}

    /// Says on the terminal what is wrong, as what the window shows may be overlooked.
    fn report(&self, text: &str);

    /// How what takes noise out of pictures is opened. Returns at once.
    fn denoiser(&self) -> OpenDenoiser;

    /// What has been shown at former times, the latest first.
    fn recent(&self) -> Vec<Files>;

    /// Keeps that for the next time, where the system has a place for it.
    ///
    /// # Errors
    /// It can't be written; the text is for people.
    fn keep_recent(&self, list: &[Files]) -> Result<(), String>;

    /// Whether a picture can be written there: by its ending, and without overwriting what is shown.
    ///
    /// # Errors
    /// The text is for people.
    fn check_picture(&self, path: &Path) -> Result<(), String>;

    /// Writes a picture: as the view shows it (.png, .jpg), or as linear radiance with its layers and where it came from (.exr).
    ///
    /// # Errors
    /// The text is for people.
    fn write_picture(&self, path: &Path, picture: &Finished<'_>) -> Result<(), String>;
}
