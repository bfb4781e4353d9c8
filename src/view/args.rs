//! The command line of `patina view` as the user typed it. What it means is [`super::job`]'s business.

use std::path::PathBuf;

use crate::flags::{CommonArgs, DisplayArgs, scene_help};

pub(crate) const EXAMPLES: &str = "\
Examples:
  Look at a scene, walk through it, edit its look:
    patina view helmet.glb --look rust.look.toml
  Where one has been last:
    patina view
  A picture of the window, for a page about it:
    patina view helmet.glb --screenshot window.png

In the window, `?` lists keys and what the mouse does. Files that are edited elsewhere are followed as by \
`patina watch`.

Exit codes: 0 closed, 1 failed, 2 wrong usage.";

/// Flags of `patina view`.
#[derive(Debug, clap::Args)]
pub(crate) struct ViewArgs {
    #[arg(help = format!("{}; without it, the last one", scene_help()))]
    pub(crate) scene: Option<PathBuf>,

    /// The look: a TOML file with procedural textures, environment and overrides.
    #[arg(long, value_name = "FILE", requires = "scene")]
    pub(crate) look: Option<PathBuf>,

    /// Samples per pixel after which a picture is done.
    #[arg(long, value_name = "N", default_value = "4096")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) spp: String,

    /// Camera of the scene by name, in place of the look's.
    #[arg(long, value_name = "NAME", requires = "scene")]
    pub(crate) camera: Option<String>,

    /// What all renders can choose.
    #[command(flatten)]
    pub(crate) common: CommonArgs,

    /// Device to render on, by number or by part of its name, as `patina devices` lists them; it draws the window, too, if it has a
    /// driver. Without it a GPU does both; where there is none, `native` renders, and a driver in software draws the window.
    #[arg(long, value_name = "NAME|N")]
    pub(crate) device: Option<String>,

    /// Threads of the device `native` and of all else that the program computes by itself; without it one for each processor.
    #[arg(long, value_name = "N")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) threads: Option<String>,

    /// How the picture is shown.
    #[command(flatten)]
    pub(crate) display: DisplayArgs,

    /// Show the picture without its noise, whatever it has, by Open Image Denoise; a screenshot waits for that. Without it a window does
    /// so by itself where it is found, while the noise is seen and the result is steady, and a screenshot has its noise.
    #[arg(long)]
    pub(crate) denoise: bool,

    /// When the window is closed, print how quickly it followed: the first picture, frames and pictures while dragging, changes.
    #[arg(long)]
    pub(crate) figures: bool,

    /// Write a picture of the window (.png or .jpg) and close it.
    #[arg(long, value_name = "FILE")]
    pub(crate) screenshot: Option<PathBuf>,

    /// Samples per pixel that the picture in the screenshot has.
    #[arg(long, value_name = "N", default_value = "16")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) screenshot_spp: String,
}
