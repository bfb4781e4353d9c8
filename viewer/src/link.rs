//! The line between the window and the render's thread: commands one way, pictures and figures the other. The window
//! never waits.

use std::path::{Path, PathBuf};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Instant;

use engine::display::DisplaySettings;
use engine::film::LightMix;
use engine::renderer::TextureCosts;
use engine::scene::view::View;
use engine::scene::{Camera, Material, PunctualLight};
use engine::session::Change;
use engine::stats::PassStats;
use glam::Vec2;
use patina_panels::{ModelImage, Textures};

use crate::picture::Pictures;

/// What the render is to do.
#[derive(Debug, Clone)]
pub enum Command {
    /// Change the look; changes are numbered from 1 on.
    Change(Change, u64),
    /// Look through this camera, or again through that of the look.
    View(Option<Camera>),
    /// Show a scene that moves as it is after so many seconds, or at rest.
    Moment(Option<f64>),
    /// Pixels of the picture while nothing moves.
    Size([u32; 2]),
    /// How the picture is shown.
    Display(DisplaySettings),
    /// Render only the part between these corners: left, top, right, bottom, 0 to 1.
    Region(Option<[f32; 4]>),
    /// Say what is seen at this place, (0, 0) the upper left corner, (1, 1) the lower right one.
    Pick(Vec2, PickPurpose),
    /// Nothing is picked any more.
    Unpick,
    /// Draw a line around a material that was chosen by its name.
    Outline(String),
    /// Say how far below a point the ground is.
    Ground(glam::Vec3),
    /// Say how large something is.
    Bounds(Extent),
    /// Keep the picture to compare with, or forget it.
    KeepBefore(bool),
    /// Render, or wait.
    Pause(bool),
    /// When to show the picture without its noise, where there is what takes it out.
    Denoise(Denoise),
    /// Keep the light of groups apart from now on, and show it mixed; or show the picture as it is.
    MixLights(Option<LightMix>),
    /// Show a scene without any light in that of a studio, or as dark as it is.
    StudioLight(bool),
    /// Measure each pass and each texture.
    TimePasses(bool),
    /// Samples per pixel after which the picture is done.
    Target(u32),
    /// Save the look to its file, or to another one, which is its file from then on. The number is the [`LookFacts::outside`] that the look
    /// has: its own file is left alone where another program has written to it since.
    Save(Option<PathBuf>, u64),
    /// Write a picture once it is finished.
    SavePicture(PictureOrder),
    /// Write it not.
    CancelPicture,
    /// Render other files.
    Open(Files),
    /// It is known that files were opened: what comes from now on is meant for them, what came before was meant for others.
    HasOpened,
    /// Search textures in this folder, too.
    TextureFolder(PathBuf),
    /// Files may have changed.
    LookForChanges,
    /// The window can't be drawn any more, for this reason: keep what is not saved.
    Abandon(String),
    /// End.
    Quit,
}

/// When the picture is shown without its noise.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Denoise {
    /// While it has so much that it is seen, and so little that what is left without it is steady: see [`NOISY`] and [`FINE`].
    #[default]
    ByItself,
    /// However much it has.
    Always,
    /// Not at all.
    Never,
}

/// Relative error of a picture that is shown without its noise by itself from then on. With more, what the denoiser makes of the next
/// samples is another picture: it would boil.
pub const NOISY: f64 = 0.3;
/// Relative error of a picture that is shown as it is from then on: its noise isn't seen, and it has what the denoiser takes for noise.
pub const FINE: f64 = 0.05;

/// A picture that is to be written: as a view shows it as .png or .jpg, with its lights mixed as they are shown; radiance as .exr, as it is
/// rendered.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureOrder {
    /// The file.
    pub path: PathBuf,
    /// Pixels.
    pub size: [u32; 2],
    /// Samples of each pixel.
    pub spp: u32,
    /// All layers that there are, where the file can hold them.
    pub layers: bool,
    /// Without its noise. A file that holds layers keeps the noisy picture as one of them.
    pub denoised: bool,
    /// How it is shown.
    pub view: View,
}

impl PictureOrder {
    /// Whether it is radiance, and not what a screen shows.
    pub fn is_radiance(&self) -> bool {
        is_radiance(&self.path)
    }
}

/// Whether a file holds radiance, by its name.
pub(crate) fn is_radiance(path: &Path) -> bool {
    let ending = path.extension();
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case("exr"))
}

/// How far a picture is that is to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Saving {
    /// The file.
    pub path: PathBuf,
    /// Samples of each pixel so far.
    pub spp: f64,
    /// Wanted.
    pub target: u32,
}

/// What is rendered.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Files {
    /// The glTF file.
    pub scene: PathBuf,
    /// The look.
    pub look: Option<PathBuf>,
    /// A camera of the scene in place of the look's.
    pub camera: Option<String>,
}

impl Files {
    /// The same from whatever folder.
    pub fn absolute(&self) -> Self {
        let absolute = |path: &PathBuf| std::path::absolute(path).unwrap_or_else(|_| path.clone());
        Self {
            scene: absolute(&self.scene),
            look: self.look.as_ref().map(absolute),
            camera: self.camera.clone(),
        }
    }
}

/// What is to be framed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Everything.
    Scene,
    /// What was picked last; everything where that was nothing.
    Picked,
}

/// What a pick is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PickPurpose {
    /// To choose the material.
    Material,
    /// To focus the lens there, and to turn around it.
    Focus,
    /// To place a light.
    Light,
    /// To give it a material that was dropped there.
    Drop,
}

/// What lies below a place of the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Hit {
    /// Name of its material.
    pub material: String,
    /// Distance from the camera's plane, metres.
    pub depth: f32,
    /// Where it is, in the world.
    pub position: glam::Vec3,
    /// Away from it, towards the camera.
    pub normal: glam::Vec3,
}

/// What the render has to say, once.
#[derive(Debug, Clone)]
pub enum Reply {
    /// What lies below a place.
    Picked {
        /// What it was asked for.
        purpose: PickPurpose,
        /// `None` where nothing is seen.
        hit: Option<Hit>,
    },
    /// Something was done.
    Done(String),
    /// Something could not be done, or there is something wrong with the picture.
    Failed(String),
    /// The look could not be saved, or a picture not be written.
    NotWritten(String),
    /// The ground below a point.
    Ground {
        /// The point.
        from: glam::Vec3,
        /// Metres to what lies below; `None` where nothing does.
        below: Option<f32>,
    },
    /// Corners of a box around what was asked for, metres.
    Bounds([glam::Vec3; 2]),
    /// Not the moment that was asked for is shown, but this one, in seconds; `None` for the scene at rest.
    Moment(Option<f64>),
    /// Other files are rendered from now on.
    Opened(Files),
}

/// What is to be seen.
#[derive(Debug, Clone)]
pub struct Shown {
    /// What is rendered; what was kept to compare with, shown in the same way; what lies beside the region, where only that follows
    /// changes.
    pub pictures: Pictures,
    /// Pixels of what is rendered; fewer than those of the viewport while something moves.
    pub size: [u32; 2],
    /// Another one with each other picture. One on the window's device is the same one while samples are added to it.
    pub number: u64,
}

/// Figures of a render.
#[derive(Debug, Clone, Default)]
pub struct Status {
    /// Samples per pixel of what is shown.
    pub spp: f64,
    /// Samples per pixel of the picture whose noise was taken out, where such a one is shown.
    pub denoised: Option<f64>,
    /// Where it ends.
    pub target: u32,
    /// Seconds after which the scene is as it is shown; `None` at rest.
    pub moment: Option<f64>,
    /// The light of groups is kept apart in what is shown, so that it can be mixed.
    pub keeps_groups: bool,
    /// Pixels.
    pub size: [u32; 2],
    /// Camera paths per second.
    pub samples_per_second: f64,
    /// Million rays of all kinds per second.
    pub mrays_per_second: f64,
    /// Passes, if they are measured.
    pub passes: Vec<PassStats>,
    /// What textures cost, as far as that is measured.
    pub textures: TextureCosts,
    /// GPU memory of the render, bytes.
    pub memory: u64,
    /// Relative standard error of the picture, before its lights are mixed.
    pub error: Option<f64>,
    /// Pipelines created since the device was opened.
    pub pipelines: u64,
    /// Shader modules created since the device was opened.
    pub shader_modules: u64,
    /// Changes that a first picture has been shown of.
    pub answered: u64,
    /// Seconds from the last of them to its picture.
    pub latency: Option<f64>,
    /// Something is being built in the background.
    pub is_building: bool,
    /// The picture has the size of the viewport, all of it.
    pub is_whole: bool,
    /// A picture that is being finished to be written.
    pub saving: Option<Saving>,
    /// The scene is being read.
    pub is_loading: bool,
    /// The program is to end: the window closes.
    pub is_ending: bool,
    /// Nothing is rendered for now.
    pub is_paused: bool,
    /// What is wrong with the files, each with line and caret.
    pub problems: String,
    /// Why files that were to be opened are not.
    pub refused: Option<String>,
    /// What is odd about them.
    pub warnings: String,
    /// What is wrong with the picture, a line each.
    pub doubts: String,
    /// The look has edits that are not saved.
    pub has_unsaved_edits: bool,
    /// The device that renders.
    pub device: String,
    /// What takes noise out of the picture.
    pub denoiser: DenoiserState,
    /// Why nothing is rendered until something changes.
    pub stuck: Option<String>,
    /// Why nothing can be rendered any more.
    pub fatal: Option<String>,
}

/// Whether noise can be taken out of what is shown.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum DenoiserState {
    /// That is found out at the moment.
    #[default]
    Unknown,
    /// By this library.
    Ready(String),
    /// It can't, for this reason; the text says what to do.
    Absent(String),
}

/// What is known of the scene; changes with its files only.
#[derive(Debug, Clone, Default)]
pub struct SceneFacts {
    /// What is rendered.
    pub files: Files,
    /// Cameras of the scene.
    pub cameras: Vec<Camera>,
    /// That of the look.
    pub look_camera: Option<Camera>,
    /// When its last animation ends, seconds; `None` where nothing moves.
    pub end: Option<f64>,
    /// Names of the groups that its lights are in.
    pub light_groups: Vec<String>,
}

/// The look as the render has it.
#[derive(Debug, Clone, Default)]
pub struct LookFacts {
    /// With all changes that it has heard of.
    pub text: Arc<str>,
    /// As its file has it.
    pub saved: Arc<str>,
    /// How often that came from another program.
    pub outside: u64,
    /// How many these are.
    pub heard: u64,
    /// As they are shown.
    pub materials: Arc<Vec<Material>>,
    /// So many of them are those of the scene's files.
    pub own_materials: usize,
    /// There is no light but one that nobody asked for.
    pub has_stand_in_light: bool,
    /// Images of the model.
    pub images: Arc<[ModelImage]>,
    /// As they are shown.
    pub lights: Arc<[PunctualLight]>,
    /// That there are.
    pub textures: Arc<Textures>,
}

/// What the render's thread writes and the window reads.
#[derive(Debug, Default)]
pub struct Board {
    /// The picture.
    pub shown: Option<Shown>,
    /// Its figures.
    pub status: Status,
    /// The scene, and how often that has changed.
    pub scene: Arc<SceneFacts>,
    /// The look, once it has been read.
    pub look: Option<LookFacts>,
    /// What has been shown, the latest first.
    pub recent: Arc<[Files]>,
    /// Not read yet.
    pub replies: Vec<Reply>,
    /// When the user did something last; written by the window.
    pub touched: Option<Instant>,
    /// A button or a key is held, so that what moves may go on moving; written by the window.
    pub is_held: bool,
}

/// The window's end.
#[derive(Debug, Clone)]
pub struct Link {
    commands: Arc<Sender<Command>>,
    board: Arc<Mutex<Board>>,
}

impl Link {
    /// From both halves.
    pub fn new(commands: Sender<Command>, board: Arc<Mutex<Board>>) -> Self {
        let commands = Arc::new(commands);
        Self { commands, board }
    }

    /// What wakes the render.
    pub fn waker(&self) -> Waker {
        Waker(Arc::downgrade(&self.commands))
    }

    /// Sends a command. One that nobody hears is lost: then the board says why.
    pub fn send(&self, command: Command) {
        let _ = self.commands.send(command);
    }

    /// What there is to read. Held for moments only, by either side.
    pub fn board(&self) -> MutexGuard<'_, Board> {
        lock(&self.board)
    }
}

/// Wakes the render, while there is a [`Link`] to it, to look for files that have changed.
#[derive(Debug, Clone)]
pub struct Waker(Weak<Sender<Command>>);

impl Waker {
    /// From any thread.
    pub fn wake(&self) {
        if let Some(commands) = self.0.upgrade() {
            // Where nobody hears it, nobody sleeps.
            let _ = commands.send(Command::LookForChanges);
        }
    }
}

/// A board whose writer died is as readable as before.
pub(crate) fn lock(board: &Mutex<Board>) -> MutexGuard<'_, Board> {
    board.lock().unwrap_or_else(PoisonError::into_inner)
}
