//! Flags that several subcommands share.

use std::ffi::OsStr;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgAction, Command};
use engine::film::layers;
use engine::scene::view::ViewTransform;

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

/// Flags of how a picture is shown, which `render`, `merge`, `watch` and `view` share. What they don't say, the look may.
#[derive(Debug, clap::Args)]
pub(crate) struct DisplayArgs {
    /// View transform: how PNG, JPEG and windows show radiance. Without it that of the look's table view, or standard. EXR files
    /// keep the radiance as it is.
    #[arg(long, value_name = "NAME")]
    #[arg(value_parser = words(ViewTransform::ALL.map(ViewTransform::name)))]
    pub(crate) view: Option<String>,

    /// Brightness of PNG, JPEG and windows in stops: +1 is twice as bright. Without it that of the look's table view, or 0.
    #[arg(long, value_name = "STOPS")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) exposure: Option<String>,

    /// Colour of light that PNG, JPEG and windows show as white: its temperature, and how far it is off towards green. 6500,10
    /// is daylight. Without it that of the look's table view, or nothing is balanced.
    #[arg(long, value_name = "KELVIN[,TINT]")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) white_balance: Option<String>,
}

/// The words that a flag takes: its help shows them.
pub(crate) fn words(all: impl IntoIterator<Item = &'static str>) -> PossibleValuesParser {
    PossibleValuesParser::new(all)
}

/// The names of layers: one of those that there are, or a node's.
#[derive(Clone)]
pub(crate) struct LayerWords(PossibleValuesParser);

impl LayerWords {
    pub(crate) fn new() -> Self {
        Self(words(layers::known()))
    }
}

impl TypedValueParser for LayerWords {
    type Value = String;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        match value.to_str() {
            Some(name) if name.len() > layers::NODE.len() && name.starts_with(layers::NODE) => {
                Ok(name.to_owned())
            }
            _ => self.0.parse_ref(command, arg, value),
        }
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        self.0.possible_values()
    }
}

/// What the file may be that is rendered.
pub(crate) fn scene_help() -> String {
    format!("The scene: {}", engine::scene::import::known_formats())
}
