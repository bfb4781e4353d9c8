//! The command line of `patina texture` as the user typed it. What it means is [`super::job`]'s business.

use std::path::PathBuf;

use clap::{ArgAction, Args, Subcommand, ValueEnum};

const EVAL_EXAMPLES: &str = "\
Examples:
  patina texture eval checker --at TexCoord0=0.1,0.1 --at TexCoord0=0.2,0.1
  patina texture eval fbm --set scale=3 --at \"WorldPos=1,2,3;Footprint=0.01\"
  patina texture eval rust --look rust.look.toml --at \"WorldPos=1,2,3;AO=0.5\"

Each --at is a point and gives a line. Names are those of readAttr and readGlobal, and those of custom attributes \
(_WETNESS). What isn't given has a plain value: the origin, the normal +Y, AO 1, and so on.";

const PREVIEW_EXAMPLES: &str = "\
Examples:
  patina texture preview voronoi --set scale=6 -o voronoi.png
  patina texture preview voronoi --set scale=6 --range 0..0.6
  patina texture preview rust --look rust.look.toml";

/// What to do with textures.
#[derive(Debug, Subcommand)]
pub(crate) enum TextureCommand {
    /// List the textures there are, with their parameters.
    List {
        /// Where they are.
        #[command(flatten)]
        folders: Folders,
    },
    /// Show every mistake in textures; the exit code is 1 where there is one.
    Check {
        /// Texture files, folders of them, or names; without any, all textures there are.
        files: Vec<PathBuf>,

        /// Where they are.
        #[command(flatten)]
        folders: Folders,
    },
    /// Write a page about all textures, with a sheet of swatches for each group.
    Doc {
        /// Where the page goes; without it, it is printed.
        #[arg(short, long, value_name = "FILE")]
        output: Option<PathBuf>,

        /// Write the sheets into this folder, as textures-GROUP.jpg; it is made where there is none.
        #[arg(long, value_name = "DIR")]
        sheets: Option<PathBuf>,

        /// Device by number or by part of its name, as `patina devices` lists them.
        #[arg(long, value_name = "NAME|N")]
        device: Option<String>,

        /// Where textures are.
        #[command(flatten)]
        folders: Folders,
    },
    /// Print the prelude: with it in front, a texture is a complete WGSL module.
    Prelude,
    /// Show what Patina makes of a texture or a look: kernel, programs, arguments, memory.
    Inspect(InspectArgs),
    /// Print the value of a texture at points of your choice.
    #[command(after_help = EVAL_EXAMPLES)]
    Eval(EvalArgs),
    /// Render a texture on a sphere, a plane and a cube.
    #[command(after_help = PREVIEW_EXAMPLES)]
    Preview(PreviewArgs),
    /// Begin a texture with a commented template, or with a copy of another texture.
    New {
        /// The texture's name.
        name: String,

        /// Copy this texture instead of the template.
        #[arg(long, value_name = "TEXTURE")]
        from: Option<String>,

        /// The folder it is written to; it is made where there is none.
        #[arg(long, value_name = "DIR", default_value = "user_textures")]
        dir: PathBuf,

        /// Where textures are.
        #[command(flatten)]
        folders: Folders,
    },
}

/// Where textures are looked for.
#[derive(Debug, Args)]
pub(crate) struct Folders {
    /// Folder with textures (.wgsl), searched before all others. May be given several times.
    #[arg(long = "textures", value_name = "DIR", action = ArgAction::Append)]
    pub(crate) texture_dirs: Vec<PathBuf>,
}

/// Which texture is meant, and its arguments.
#[derive(Debug, Args)]
pub(crate) struct Target {
    /// A texture, or with --look one of its nodes; `voronoi.color` is an output of it, `voronoi.x` a component.
    pub(crate) name: String,

    /// Take a node of this look, with its arguments and links, instead of a bare texture.
    #[arg(long, value_name = "FILE")]
    pub(crate) look: Option<PathBuf>,

    /// An argument, written as in a look file. May be given several times.
    #[arg(long = "set", value_name = "NAME=VALUE", action = ArgAction::Append)]
    pub(crate) sets: Vec<String>,

    /// Where textures are.
    #[command(flatten)]
    pub(crate) folders: Folders,

    /// Device by number or by part of its name, as `patina devices` lists them.
    #[arg(long, value_name = "NAME|N")]
    pub(crate) device: Option<String>,
}

/// Flags of `patina texture inspect`.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    /// A texture.
    #[arg(required_unless_present = "look", conflicts_with = "look")]
    pub(crate) name: Option<String>,

    /// A look: its programs and arguments as well.
    #[arg(long, value_name = "FILE")]
    pub(crate) look: Option<PathBuf>,

    /// Show only this part.
    #[arg(long, value_name = "PART")]
    pub(crate) part: Option<Part>,

    /// Where textures are.
    #[command(flatten)]
    pub(crate) folders: Folders,
}

/// What `inspect` shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    /// The generated WGSL.
    Kernel,
    /// The instructions of each material's program.
    Programs,
    /// Where arguments lie in the fake stack.
    Arguments,
    /// Bytes per thread.
    Memory,
}

/// Flags of `patina texture eval`.
#[derive(Debug, Args)]
pub(crate) struct EvalArgs {
    /// Of what.
    #[command(flatten)]
    pub(crate) target: Target,

    /// A point: attributes and globals with their values. May be given several times.
    #[arg(long = "at", value_name = "NAME=X,Y,..;..", action = ArgAction::Append)]
    pub(crate) points: Vec<String>,
}

/// Flags of `patina texture preview`.
#[derive(Debug, Args)]
pub(crate) struct PreviewArgs {
    /// A texture, or with --look one of its nodes; `voronoi.color` is an output of it, `voronoi.x` a component.
    #[arg(required_unless_present = "material", conflicts_with = "material")]
    pub(crate) name: Option<String>,

    /// A look with the node or material that is meant.
    #[arg(long, value_name = "FILE")]
    pub(crate) look: Option<PathBuf>,

    /// Show a material of the look, on a ball on a floor.
    #[arg(long, value_name = "NAME", requires = "look", conflicts_with_all = ["sets", "range"])]
    pub(crate) material: Option<String>,

    /// An argument, written as in a look file. May be given several times.
    #[arg(long = "set", value_name = "NAME=VALUE", action = ArgAction::Append)]
    pub(crate) sets: Vec<String>,

    /// Where textures are.
    #[command(flatten)]
    pub(crate) folders: Folders,

    /// Device by number or by part of its name, as `patina devices` lists them.
    #[arg(long, value_name = "NAME|N")]
    pub(crate) device: Option<String>,

    /// Where to write: .png, .jpg or .exr. Without it the picture goes to NAME-preview.png.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Width of the picture in pixels; it is two fifths as high, of materials three quarters.
    #[arg(long, value_name = "N", default_value = "512")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) size: String,

    /// Values that are shown black and white, for textures that don't give colours.
    #[arg(long, value_name = "LOW..HIGH", allow_hyphen_values = true)]
    pub(crate) range: Option<String>,
}
