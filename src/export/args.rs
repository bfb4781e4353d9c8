//! The command line of `patina export` as the user typed it. What it means is [`super::job`]'s business.

use std::path::PathBuf;

use crate::bake::args::FineArgs;
use crate::flags::scene_help;

pub(crate) const EXAMPLES: &str = "\
Examples:
  A scene with its look for programs that read glTF:
    patina export room.glb --look rust.look.toml -o baked.glb
  With larger pictures, and with ambient occlusion for those who compute none:
    patina export room.glb --look rust.look.toml --size 4096 --occlusion 0.2 -o baked.glb

Each instance with driven materials gets pictures of its own; --size is that of the one with the greatest surface. Where texture \
coordinates overlap or are missing, they are made anew.

Exit codes: 0 done, 1 failed, 2 wrong usage, 130 ended by Ctrl-C (143 by SIGTERM, 129 by SIGHUP).";

/// Flags of `patina export`.
#[derive(Debug, clap::Args)]
pub(crate) struct ExportArgs {
    #[arg(help = scene_help())]
    pub(crate) scene: PathBuf,

    /// The look: a TOML file with procedural textures.
    #[arg(long, value_name = "FILE")]
    pub(crate) look: Option<PathBuf>,

    /// Where to write: .glb.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// How finely, and by what.
    #[command(flatten)]
    pub(crate) fine: FineArgs,
}
