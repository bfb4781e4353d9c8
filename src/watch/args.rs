//! The command line of `patina watch` as the user typed it. What it means is [`super::job`]'s business.

use std::path::PathBuf;

use clap::ArgAction;

use crate::flags::{CommonArgs, DisplayArgs, scene_help};

pub(crate) const EXAMPLES: &str = "\
Examples:
  Write a texture with the picture in view, in any viewer that notices a new file:
    patina watch helmet.glb --look rust.look.toml -o helmet.png

The look, the textures in use, the scene and its images are watched. After each change the picture is written at 1, 4, \
16, 64, ... samples per pixel, with a line on how long that took. What is wrong is shown with file, line and caret, \
and the former picture goes on. Ctrl-C ends it, and writes the picture as it is then.

Exit codes: 1 failed, 2 wrong usage, 130 ended by Ctrl-C (143 by SIGTERM, 129 by SIGHUP).";

/// Flags of `patina watch`.
#[derive(Debug, clap::Args)]
pub(crate) struct WatchArgs {
    #[arg(help = scene_help())]
    pub(crate) scene: PathBuf,

    /// The look: a TOML file with procedural textures, environment and overrides.
    #[arg(long, value_name = "FILE")]
    pub(crate) look: Option<PathBuf>,

    /// Where to write: .png, .jpg or .exr. May be given several times.
    ///
    /// Without it the picture goes to SCENE-render.png in the current directory.
    #[arg(short, long = "output", value_name = "FILE", action = ArgAction::Append)]
    pub(crate) outputs: Vec<PathBuf>,

    /// Samples per pixel of the last picture after each change.
    #[arg(long, value_name = "N", default_value = "1024")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) spp: String,

    /// Width and height of the picture in pixels.
    #[arg(long, value_name = "WxH", default_value = "640x360")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) size: String,

    /// Camera of the scene by name, in place of the look's.
    #[arg(long, value_name = "NAME")]
    pub(crate) camera: Option<String>,

    /// What all renders can choose.
    #[command(flatten)]
    pub(crate) common: CommonArgs,

    /// Device by number or by part of its name, as `patina devices` lists them.
    #[arg(long, value_name = "NAME|N")]
    pub(crate) device: Option<String>,

    /// How the picture is shown.
    #[command(flatten)]
    pub(crate) display: DisplayArgs,
}
