//! Flags of `patina farm`.

use std::path::PathBuf;

use clap::{ArgAction, Subcommand, ValueEnum};

pub(crate) const EXAMPLES: &str = "\
Examples:
  Sixteen parts of a picture on a Slurm cluster, which merges them:
    patina farm export --to slurm -o job --result a.exr a.glb -- --size 640x360
    sh job/submit.sh
  What is missing after a machine was lost:
    patina farm export --to slurm --missing -o job --result a.exr a.glb -- --size 640x360

Everything behind `--` is handed to `patina render`. Parts that are there already are not rendered again.";

/// What to do with a farm.
#[derive(Debug, Subcommand)]
pub(crate) enum FarmCommand {
    /// Write the files with which a scheduler renders a picture in parts on many machines, and merges them.
    #[command(after_help = EXAMPLES)]
    // Clap doesn't wrap it.
    #[command(
        override_usage = "patina farm export --to NAME -o DIR --result FILE [OPTIONS]\n       SCENE [-- FLAGS]"
    )]
    Export(ExportArgs),
}

/// A scheduler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Scheduler {
    /// An array job with a merge that depends on it: `sh FOLDER/submit.sh`.
    Slurm,
    /// A job template of Open Job Description, as Deadline Cloud takes it.
    Openjd,
    /// A job of `OpenCue` as XML.
    Opencue,
    /// A job type of Flamenco 3.
    Flamenco,
}

/// Flags of `patina farm export`.
#[derive(Debug, clap::Args)]
pub(crate) struct ExportArgs {
    /// The scene.
    pub(crate) scene: PathBuf,

    /// The scheduler.
    #[arg(long, value_name = "NAME")]
    pub(crate) to: Scheduler,

    /// Parts into which the samples are cut.
    #[arg(long, value_name = "N", default_value = "16")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) parts: String,

    /// Samples per pixel of the whole picture.
    #[arg(long, value_name = "N", default_value = "256")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) spp: String,

    /// Folder for the job's files, and for the parts when they are rendered: all machines must see it by this path.
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub(crate) folder: PathBuf,

    /// The picture that the parts make; may be given several times.
    #[arg(long, value_name = "FILE", action = ArgAction::Append, required = true)]
    pub(crate) result: Vec<PathBuf>,

    /// Only the samples that no part in the folder has.
    #[arg(long)]
    pub(crate) missing: bool,

    /// Flags of `patina render`.
    #[arg(last = true, value_name = "FLAGS")]
    pub(crate) flags: Vec<String>,
}
