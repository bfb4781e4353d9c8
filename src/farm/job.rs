//! A validated job of `patina farm`. Nothing is opened here.

use std::path::PathBuf;

use crate::overrides::Overrides;
use crate::usage::UsageError;
use crate::words::{FILM_EXTENSION, MAX_SPP, Outputs, parse_number};

use super::args::{FarmCommand, Scheduler};

/// Most parts of a picture: Slurm's usual limit of an array.
const MOST_PARTS: u32 = 1000;

/// What a scheduler is to do.
#[derive(Debug, PartialEq)]
pub(crate) struct ExportJob {
    pub(crate) scheduler: Scheduler,
    pub(crate) scene: PathBuf,
    /// Words for `patina render`, but for scene, samples and output.
    pub(crate) flags: Vec<String>,
    /// What a part is rendered from by these words.
    pub(crate) inputs: PartInputs,
    pub(crate) parts: u32,
    pub(crate) spp: u32,
    pub(crate) folder: PathBuf,
    pub(crate) results: Vec<PathBuf>,
    pub(crate) missing_only: bool,
}

/// What a part is rendered from, beside the scene.
#[derive(Debug, PartialEq)]
pub(crate) struct PartInputs {
    /// The look file.
    pub(crate) look: Option<PathBuf>,
    /// What is to be otherwise than in the look.
    pub(crate) overrides: Overrides,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
}

/// The words of `patina render` that render a part.
pub(super) fn part_words(scene: &str, flags: &[String], samples: &str, film: &str) -> Vec<String> {
    let end = ["--sample-range", samples, "-o", film, "--", scene].map(str::to_owned);
    let start = std::iter::once("--quiet".to_owned());
    start.chain(flags.iter().cloned()).chain(end).collect()
}

impl ExportJob {
    /// Validates a command line; `read` says what `patina render` reads by some words.
    ///
    /// # Errors
    /// The first flag that makes no sense, those of `patina render` among them.
    pub(crate) fn from_args(
        command: FarmCommand,
        read: impl Fn(&[String]) -> Result<PartInputs, UsageError>,
    ) -> Result<Self, UsageError> {
        let FarmCommand::Export(args) = command;
        let spp = parse_number("--spp", &args.spp, 1, MAX_SPP)?;
        let parts = parse_number("--parts", &args.parts, 1, MOST_PARTS)?;
        Outputs::from_paths(args.result.clone(), None)?;
        for word in [
            "--spp",
            "--sample-range",
            "--part",
            "-o",
            "--output",
            "--noise",
            "--flip",
            "--time",
            "--frames",
            "--frame-part",
            "--turntable",
            "--resume",
            "--checkpoint",
            "--refresh",
        ] {
            let is_that = |flag: &&String| *flag == word || flag.starts_with(&format!("{word}="));
            if let Some(flag) = args.flags.iter().find(is_that) {
                return Err(UsageError::FarmFlag { flag: flag.clone() });
            }
        }
        let is_each_camera = |pair: &[String]| pair[0] == "--camera" && pair[1] == "all";
        if args.flags.windows(2).any(is_each_camera)
            || args.flags.iter().any(|f| f == "--camera=all")
        {
            let flag = "--camera all".to_owned();
            return Err(UsageError::FarmFlag { flag });
        }
        // What the farm would refuse hours later is refused now.
        let (samples, film) = (format!("0..{spp}"), format!("part.{FILM_EXTENSION}"));
        let scene = args.scene.display().to_string();
        let inputs = read(&part_words(&scene, &args.flags, &samples, &film))?;
        Ok(Self {
            inputs,
            scheduler: args.to,
            scene: args.scene,
            flags: args.flags,
            parts,
            spp,
            folder: args.folder,
            results: args.result,
            missing_only: args.missing,
        })
    }
}
