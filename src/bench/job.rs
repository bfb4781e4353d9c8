//! Validated jobs of `patina bench`: numbers and names are understood here, and nothing is opened.

use std::path::PathBuf;

use engine::bench::forms::Form;
use engine::gpu::DeviceChoice;

use crate::job::{
    MAX_DEPTH, MAX_SPP, UsageError, parse_device, parse_number, parse_size, refuse_overwriting,
};

use super::args::{BenchCommand, EffortArgs, RenderArgs, TexturesArgs};

/// Most timed runs of a scene.
const MAX_RUNS: u32 = 1000;

/// What is to be measured.
#[derive(Debug, PartialEq)]
pub(crate) enum BenchJob {
    /// The texture kernel.
    Kernel {
        /// Most textures in a kernel.
        most: u32,
        /// Folders the user named, searched first.
        texture_dirs: Vec<PathBuf>,
        /// Device to measure.
        device: DeviceChoice,
    },
    /// Live edits.
    Edit {
        /// Nodes of the look.
        nodes: u32,
        /// Edits of each kind.
        edits: u32,
        /// Device to measure.
        device: DeviceChoice,
    },
    /// Whole renders.
    Render(RenderJob),
    /// What textures cost.
    Textures(TexturesJob),
    /// The traversal kernel.
    Traverse(TraverseJob),
}

/// A measurement of whole renders.
#[derive(Debug, PartialEq)]
pub(crate) struct RenderJob {
    /// glTF files; the built-in scenes where there is none.
    pub(crate) scenes: Vec<PathBuf>,
    /// A look for all of them.
    pub(crate) look: Option<PathBuf>,
    /// How it is measured.
    pub(crate) effort: Effort,
}

/// A measurement of what textures cost.
#[derive(Debug, PartialEq)]
pub(crate) struct TexturesJob {
    /// The glTF file and the material in it; `None` is the built-in scene.
    pub(crate) scene: Option<(PathBuf, String)>,
    /// A look for it.
    pub(crate) look: Option<PathBuf>,
    /// Forms of the kernel.
    pub(crate) forms: Vec<Form>,
    /// Rays of ambient occlusion, a table each.
    pub(crate) ao_rays: Vec<u32>,
    /// Another device whose driver is asked about kernels.
    pub(crate) statistics_device: Option<String>,
    /// How it is measured.
    pub(crate) effort: Effort,
}

/// How whole renders are measured.
#[derive(Debug, PartialEq)]
pub(crate) struct Effort {
    /// Samples per pixel of a run.
    pub(crate) spp: u32,
    /// Pixels.
    pub(crate) width: u32,
    /// Pixels.
    pub(crate) height: u32,
    /// Timed runs of each case.
    pub(crate) runs: u32,
    /// Most scattering vertices of a path.
    pub(crate) max_depth: u32,
    /// Where the figures go.
    pub(crate) json: Option<PathBuf>,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
    /// Device to measure.
    pub(crate) device: DeviceChoice,
}

/// A measurement of the traversal kernel.
#[derive(Debug, PartialEq)]
pub(crate) struct TraverseJob {
    /// The glTF file; `None` is the built-in scene.
    pub(crate) scene: Option<PathBuf>,
    /// Device to measure.
    pub(crate) device: DeviceChoice,
}

impl BenchJob {
    /// Validates a command line.
    ///
    /// # Errors
    /// The first flag that makes no sense.
    pub(crate) fn from_args(what: BenchCommand) -> Result<Self, UsageError> {
        Ok(match what {
            BenchCommand::Kernel {
                most,
                texture_dirs,
                device,
            } => Self::Kernel {
                most: parse_number("--most", &most, 1, 100)?,
                texture_dirs,
                device: parse_device(device.as_deref())?,
            },
            BenchCommand::Edit {
                nodes,
                edits,
                device,
            } => Self::Edit {
                // One chain for the blend's base, one for what lies over it.
                nodes: parse_number("--nodes", &nodes, 20, 100_000)?,
                edits: parse_number("--edits", &edits, 100, 1_000_000)?,
                device: parse_device(device.as_deref())?,
            },
            BenchCommand::Render(args) => Self::Render(RenderJob::from_args(args)?),
            BenchCommand::Textures(args) => Self::Textures(TexturesJob::from_args(*args)?),
            BenchCommand::Traverse { scene, device } => Self::Traverse(TraverseJob {
                scene,
                device: parse_device(device.as_deref())?,
            }),
        })
    }
}

impl RenderJob {
    fn from_args(args: RenderArgs) -> Result<Self, UsageError> {
        let read = args.scenes.iter().chain(&args.look);
        refuse_overwriting(args.effort.json.iter(), read)?;
        Ok(Self {
            effort: Effort::from_args(args.effort)?,
            scenes: args.scenes,
            look: args.look,
        })
    }
}

impl TexturesJob {
    fn from_args(args: TexturesArgs) -> Result<Self, UsageError> {
        let read = args.scene.iter().chain(&args.look);
        refuse_overwriting(args.effort.json.iter(), read)?;
        let words = |list: &str| -> Vec<String> {
            list.split(',').map(|word| word.trim().to_owned()).collect()
        };
        let form = |given: String| {
            let form = Form::ALL.into_iter().find(|form| form.name() == given);
            form.ok_or_else(|| UsageError::Word {
                flag: "--modes",
                given,
                known: Form::ALL.map(Form::name).to_vec(),
            })
        };
        let rays = |given: String| parse_number("--ao-rays", &given, 1, 255);
        Ok(Self {
            forms: (words(&args.modes).into_iter().map(form)).collect::<Result<_, _>>()?,
            ao_rays: (words(&args.ao_rays).into_iter().map(rays)).collect::<Result<_, _>>()?,
            effort: Effort::from_args(args.effort)?,
            scene: args.scene.zip(args.material),
            look: args.look,
            statistics_device: args.statistics_device,
        })
    }
}

impl Effort {
    fn from_args(args: EffortArgs) -> Result<Self, UsageError> {
        let (width, height) = parse_size(&args.size)?;
        Ok(Self {
            spp: parse_number("--spp", &args.spp, 1, MAX_SPP)?,
            width,
            height,
            runs: parse_number("--runs", &args.runs, 1, MAX_RUNS)?,
            max_depth: parse_number("--max-depth", &args.max_depth, 1, MAX_DEPTH)?,
            json: args.json,
            texture_dirs: args.texture_dirs,
            device: parse_device(args.device.as_deref())?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::Args;
    use crate::job::Job;
    use clap::Parser;

    fn job(line: &str) -> Result<BenchJob, UsageError> {
        let words = ["patina", "bench"]
            .into_iter()
            .chain(line.split_whitespace());
        let args = Args::try_parse_from(words).expect("clap accepts the line");
        Job::from_args(args).map(|job| match job {
            Job::Bench(job) => job,
            other => panic!("not a measurement: {other:?}"),
        })
    }

    #[test]
    fn no_measurement_needs_a_scene() {
        let expected = TraverseJob {
            scene: None,
            device: DeviceChoice::Best,
        };
        assert_eq!(job("traverse"), Ok(BenchJob::Traverse(expected)));
        let Ok(BenchJob::Render(job)) = job("render") else {
            panic!("a render without scenes is fine");
        };
        assert_eq!(job.scenes, [""; 0].map(PathBuf::from));
        let effort = job.effort;
        assert_eq!((effort.spp, effort.width, effort.runs), (16, 512, 3));
    }

    #[test]
    fn senseless_numbers_are_refused() {
        for (line, because) in [
            ("render --runs 0", "--runs 0"),
            ("render --spp x", "--spp x"),
            ("render --size 3", "--size 3"),
            ("render a.glb --json a.glb", "input"),
        ] {
            let error = job(line).unwrap_err().to_string();
            assert!(error.contains(because), "{line}: {error}");
        }
    }
}
