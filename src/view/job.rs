//! A validated job of `patina view`. Nothing is opened here.

use std::path::PathBuf;

use device::DeviceChoice;
use engine::scene::view::ViewChoice;

use crate::usage::UsageError;
use crate::words::{
    Format, MAX_DEPTH, MAX_SPP, MOST_THREADS, Output, parse_device, parse_display, parse_number,
    parse_output, refuse_overwriting,
};

use super::args::ViewArgs;

/// A window to be opened.
#[derive(Debug, PartialEq)]
pub(crate) struct ViewJob {
    /// The glTF file; the last one without it.
    pub(crate) scene: Option<PathBuf>,
    /// The look file.
    pub(crate) look: Option<PathBuf>,
    /// Samples per pixel after which a picture is done.
    pub(crate) spp: u32,
    /// Name of the camera.
    pub(crate) camera: Option<String>,
    /// Most scattering vertices of a path.
    pub(crate) max_depth: u32,
    /// Seed of the random numbers.
    pub(crate) seed: u32,
    /// Device to render on.
    pub(crate) device: DeviceChoice,
    /// Threads of the processor, if not one for each that it has.
    pub(crate) threads: Option<u32>,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
    /// How the picture is shown, as far as the command line says it.
    pub(crate) display: ViewChoice,
    /// The picture is shown without its noise.
    pub(crate) denoise: bool,
    /// How quickly the window followed is printed when it is closed.
    pub(crate) figures: bool,
    /// Where a picture of the window goes, and the samples per pixel that it waits for.
    pub(crate) screenshot: Option<(Output, u32)>,
}

impl ViewJob {
    /// Validates a command line.
    ///
    /// # Errors
    /// The first flag that makes no sense.
    pub(crate) fn from_args(args: ViewArgs) -> Result<Self, UsageError> {
        let spp = parse_number("--spp", &args.spp, 1, MAX_SPP)?;
        let screenshot_spp = parse_number("--screenshot-spp", &args.screenshot_spp, 1, MAX_SPP)?;
        // A picture that is done waits for no more samples.
        let screenshot_spp = screenshot_spp.min(spp);
        let screenshot = match args.screenshot {
            None => None,
            Some(path) => {
                let inputs = [args.scene.as_ref(), args.look.as_ref()];
                refuse_overwriting(std::iter::once(&path), inputs.into_iter().flatten())?;
                let output = parse_output(path)?;
                if output.format == Format::Exr {
                    return Err(UsageError::Extension { path: output.path });
                }
                Some((output, screenshot_spp))
            }
        };
        Ok(Self {
            scene: args.scene,
            look: args.look,
            spp,
            camera: args.camera,
            max_depth: parse_number("--max-depth", &args.common.max_depth, 1, MAX_DEPTH)?,
            seed: parse_number("--seed", &args.common.seed, 0, u32::MAX)?,
            device: parse_device(args.device.as_deref())?,
            threads: (args.threads.as_deref())
                .map(|threads| parse_number("--threads", threads, 1, MOST_THREADS))
                .transpose()?,
            texture_dirs: args.common.texture_dirs,
            display: parse_display(&args.display)?,
            denoise: args.denoise,
            figures: args.figures,
            screenshot,
        })
    }
}
