//! The command line of `patina bake` as the user typed it. What it means is [`super::job`]'s business.

use std::path::PathBuf;

use clap::ArgAction;

pub(crate) const EXAMPLES: &str = "\
Examples:
  All pictures of a material, as floor_base_color.png, floor_metallic_roughness.png, floor_normal.png and so on:
    patina bake Floor --scene room.glb --look rust.look.toml -o floor.png
  What one node gives on the mesh called Door, as linear floats:
    patina bake rust_mask --scene room.glb --look rust.look.toml --mesh Door --size 2048 -o mask.exr

Pictures lie on the mesh by its first texture coordinates; for those who see it in glTF's way: colours are encoded by sRGB, \
R of metallic_roughness is ambient occlusion, G roughness, B metallic, A of base_color is the opacity. What changes with the \
direction it is seen from is as seen from straight above.

Exit codes: 0 done, 1 failed, 2 wrong usage, 130 ended by Ctrl-C (143 by SIGTERM, 129 by SIGHUP).";

/// Flags that `bake` and `export` share.
#[derive(Debug, clap::Args)]
pub(crate) struct FineArgs {
    /// Width and height of the pictures in texels.
    #[arg(
        long,
        value_name = "N",
        default_value = "1024",
        allow_hyphen_values = true
    )]
    pub(crate) size: String,

    /// Samples along a side of each texel: 2 takes 4 of each.
    #[arg(
        long,
        value_name = "N",
        default_value = "2",
        allow_hyphen_values = true
    )]
    pub(crate) samples: String,

    /// Ambient occlusion as far as METRES goes into R of metallic_roughness; without it that is 1.
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    pub(crate) occlusion: Option<String>,

    /// Device by number or by part of its name, as `patina devices` lists them.
    #[arg(long, value_name = "NAME|N")]
    pub(crate) device: Option<String>,

    /// Folder with textures (.wgsl), searched before all others. May be given several times.
    #[arg(long = "textures", value_name = "DIR", action = ArgAction::Append)]
    pub(crate) texture_dirs: Vec<PathBuf>,
}

/// Flags of `patina bake`.
#[derive(Debug, clap::Args)]
pub(crate) struct BakeArgs {
    /// A material of the scene or of the look, or a node of the look.
    #[arg(value_name = "MATERIAL|NODE")]
    pub(crate) name: String,

    /// The scene whose mesh it lies on.
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,

    /// The look: a TOML file with procedural textures.
    #[arg(long, value_name = "FILE")]
    pub(crate) look: Option<PathBuf>,

    /// The mesh, or an instance of one, by name. Without it the one that has the material.
    #[arg(long, value_name = "NAME")]
    pub(crate) mesh: Option<String>,

    /// Where to write: .png (8 bits) or .exr (linear floats). Of a material, several files with this name and what they hold.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// How finely, and by what.
    #[command(flatten)]
    pub(crate) fine: FineArgs,
}
