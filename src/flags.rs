//! Flags that several subcommands share.

use std::path::PathBuf;

use clap::ArgAction;
use clap::builder::PossibleValuesParser;

/// Flags that `render`, `watch` and `view` share.
#[derive(Debug, clap::Args)]
pub(crate) struct CommonArgs {
    /// Largest path depth: at most N surface points scatter light along a path; 1 is direct light only.
    #[arg(long, value_name = "N", default_value = "9")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) max_depth: String,

    /// Seed of the random numbers; the same seed gives the same noise.
    #[arg(long, value_name = "N", default_value = "0")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) seed: String,

    /// Folder with textures (.wgsl), searched before all others. May be given several times.
    #[arg(long = "textures", value_name = "DIR", action = ArgAction::Append)]
    pub(crate) texture_dirs: Vec<PathBuf>,
}

/// The words that a flag takes: its help shows them.
pub(crate) fn words(all: impl IntoIterator<Item = &'static str>) -> PossibleValuesParser {
    PossibleValuesParser::new(all)
}

/// What the file may be that is rendered.
pub(crate) fn scene_help() -> String {
    format!("The scene: {}", engine::scene::import::known_formats())
}
