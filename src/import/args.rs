//! The command line of `patina import` as the user typed it. What it means is [`super::job`]'s business.

use std::path::PathBuf;

pub(crate) const EXAMPLES: &str = "\
Examples:
  A look with all materials of a MaterialX document, brass.look.toml:
    patina import brass.mtlx
  One of them, for the material of the scene that is called Handle:
    patina import metals.mtlx --material Brass --name Handle -o door.look.toml
    patina render door.glb --look door.look.toml
  The procedural textures of a model, as the drafts of glTF have them:
    patina import floor.gltf --drafts
    patina render floor.gltf --look floor.look.toml

What can't be expressed is named with its line, and has its default. A look can also read the document itself, each time anew: \
`[[materialx]]`.

Exit codes: 0 done, 1 failed, 2 wrong usage.";

/// Flags of `patina import`.
#[derive(Debug, clap::Args)]
pub(crate) struct ImportArgs {
    /// The MaterialX document (.mtlx); with --drafts a model with procedural textures, too (.gltf, .glb).
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,

    /// Where to write the look; without it to FILE.look.toml in the current folder. Nothing is overwritten.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Only the material of that name.
    #[arg(long, value_name = "NAME")]
    pub(crate) material: Option<String>,

    /// What the material is called in the look: a material of the scene by this name looks like it then.
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,

    /// Read drafts, too: KHR_texture_procedurals with EXT_texture_procedurals_mx_1_39 of glTF. What they say may change before
    /// they are done.
    #[arg(long)]
    pub(crate) drafts: bool,
}
