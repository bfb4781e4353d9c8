//! A validated job of `patina watch`. Nothing is opened here.

use std::num::NonZeroU32;
use std::path::PathBuf;

use device::DeviceChoice;
use engine::scene::view::ViewChoice;

use crate::usage::UsageError;
use crate::words::{
    MAX_DEPTH, MAX_SPP, Output, Outputs, parse_device, parse_display, parse_number, parse_size,
    refuse_overwriting,
};

use super::args::WatchArgs;

/// A scene to be rendered live.
#[derive(Debug, PartialEq)]
pub(crate) struct WatchJob {
    /// The glTF file.
    pub(crate) scene: PathBuf,
    /// The look file.
    pub(crate) look: Option<PathBuf>,
    /// Where the picture goes; at least one, no two alike.
    pub(crate) outputs: Vec<Output>,
    /// Samples per pixel of the last picture.
    pub(crate) spp: NonZeroU32,
    /// Pixels.
    pub(crate) width: u32,
    /// Pixels.
    pub(crate) height: u32,
    /// Name of the camera.
    pub(crate) camera: Option<String>,
    /// Most scattering vertices of a path.
    pub(crate) max_depth: u32,
    /// Seed of the random numbers.
    pub(crate) seed: u32,
    /// Device to render on.
    pub(crate) device: DeviceChoice,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
    /// How PNG and JPEG show it, as far as the command line says it.
    pub(crate) display: ViewChoice,
}

impl WatchJob {
    /// Validates a command line.
    ///
    /// # Errors
    /// The first flag that makes no sense.
    pub(crate) fn from_args(args: WatchArgs) -> Result<Self, UsageError> {
        let (width, height) = parse_size(&args.size)?;
        let outputs =
            Outputs::from_paths(args.outputs, Some(&args.scene)).map_err(|error| match error {
                // Films aren't written while files change.
                UsageError::ExtensionOfFilm { path } => UsageError::Extension { path },
                error => error,
            })?;
        refuse_overwriting(
            outputs.paths(),
            [Some(&args.scene), args.look.as_ref()]
                .into_iter()
                .flatten(),
        )?;
        if let Some(path) = outputs.films.first() {
            return Err(UsageError::Extension { path: path.clone() });
        }
        Ok(Self {
            outputs: outputs.pictures,
            spp: NonZeroU32::new(parse_number("--spp", &args.spp, 1, MAX_SPP)?)
                .expect("the range starts at 1"),
            width,
            height,
            camera: args.camera,
            max_depth: parse_number("--max-depth", &args.common.max_depth, 1, MAX_DEPTH)?,
            seed: parse_number("--seed", &args.common.seed, 0, u32::MAX)?,
            device: parse_device(args.device.as_deref())?,
            texture_dirs: args.common.texture_dirs,
            display: parse_display(&args.display)?,
            scene: args.scene,
            look: args.look,
        })
    }
}
