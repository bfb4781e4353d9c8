//! The command line of `patina info` as the user typed it. What it means is [`super::job`]'s business.

use std::path::PathBuf;

use clap::ArgAction;

pub(crate) const EXAMPLES: &str = "\
Examples:
  What is in a scene, by the names that looks and flags use:
    patina info room.glb
  The same with what a look makes of it: what drives each material, what nothing uses:
    patina info room.glb --look rust.look.toml
  The nodes of a look, how they are linked, and what they drive:
    patina info rust.look.toml
  Which samples a partial render has, and of what; the layers of a picture:
    patina info a.patina-film
    patina info room.exr --json

Exit codes: 0 done, 1 failed, 2 wrong usage.";

/// Flags of `patina info`.
#[derive(Debug, clap::Args)]
pub(crate) struct InfoArgs {
    /// A scene, a look (.toml), a partial render (.patina-film) or a picture (.exr, .png, .jpg, .hdr).
    pub(crate) file: PathBuf,

    /// Of a scene: the look that it is rendered with.
    #[arg(long, value_name = "FILE")]
    pub(crate) look: Option<PathBuf>,

    /// Folder with textures (.wgsl), searched before all others. May be given several times.
    #[arg(long = "textures", value_name = "DIR", action = ArgAction::Append)]
    pub(crate) texture_dirs: Vec<PathBuf>,

    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}
