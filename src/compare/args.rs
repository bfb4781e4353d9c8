//! The command line of `patina compare` as the user typed it. What it means is [`super::job`]'s business.

use std::path::PathBuf;

pub(crate) const EXAMPLES: &str = "\
Examples:
  How far a quick render is from a long one, and where:
    patina compare quick.exr long.exr --diff where.png
  Whether a picture still is what it was, for a script: the exit code is 1 where it isn't:
    patina compare new.png reference.png --max-flip 0.02
  One layer of two files, and figures for programs:
    patina compare a.exr b.exr --layer depth --max-mse 1e-6
    patina compare a.patina-film b.exr --json

MSE is the mean of squared differences of linear values, relative MSE that of squares divided by the square of the reference \
and 0.01. PSNR and FLIP (0 to 1; below 0.05 few people see a difference) compare what is shown: sRGB after --exposure.

Exit codes: 0 done, 1 failed or a --max is exceeded, 2 wrong usage.";

/// Flags of `patina compare`.
#[derive(Debug, clap::Args)]
pub(crate) struct CompareArgs {
    /// The picture: .png, .jpg, .exr, .hdr or .patina-film.
    #[arg(value_name = "PICTURE")]
    pub(crate) picture: PathBuf,

    /// What it is compared with, of the same size.
    #[arg(value_name = "REFERENCE")]
    pub(crate) reference: PathBuf,

    /// The layer of .exr and .patina-film files that is compared, as `--layers` of `render` calls it, or as the file does; without
    /// it the picture itself.
    #[arg(long, value_name = "NAME")]
    pub(crate) layer: Option<String>,

    /// Brightness of what is shown in stops: +1 is twice as bright.
    #[arg(long, value_name = "STOPS", default_value = "0")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) exposure: String,

    /// Write a picture of the differences: FLIP from black (0) over violet and orange to nearly white (1). Of layers without colours
    /// the differences themselves, by the largest.
    #[arg(long, value_name = "FILE")]
    pub(crate) diff: Option<PathBuf>,

    /// Fail where FLIP is larger.
    #[arg(long, value_name = "X")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) max_flip: Option<String>,

    /// Fail where the mean squared error is larger.
    #[arg(long, value_name = "X")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) max_mse: Option<String>,

    /// Fail where the relative mean squared error is larger.
    #[arg(long, value_name = "X")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) max_relative_mse: Option<String>,

    /// Print the figures as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}
