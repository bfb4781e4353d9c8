//! Validated jobs of `patina bench`: numbers and names are understood here, and nothing is opened.

use std::path::PathBuf;

use device::DeviceChoice;
use patina_bench::forms::Form;
use patina_bench::methods::{How, LEAST_SPP};
use patina_bench::sweeps::Sweep;

use crate::usage::UsageError;
use crate::words::{
    Devices, MAX_DEPTH, MAX_SIDE, MAX_SPP, MOST_THREADS, parse_device, parse_devices,
    parse_exposure, parse_number, parse_size, parse_word, refuse_overwriting,
};

use super::args::{
    ALL, BenchCommand, EffortArgs, MethodsArgs, RenderArgs, ScalingArgs, TexturesArgs,
};

/// Most timed runs of a scene.
const MAX_RUNS: u32 = 1000;

/// Fewest samples of a pixel where pictures of several forms are held against each other: a single one has no known error.
const LEAST_COMPARED_SPP: u32 = 2;

/// Longest side of a picture whose scaling is measured: 64 million pixels.
const MOST_SCALED_SIDE: u32 = 8192;
/// Longest limit: a week.
const MOST_MINUTES: u32 = 7 * 24 * 60;

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
    /// Ways to find photons.
    Gather {
        /// Photons, and places that ask for them.
        photons: u32,
        /// Timed runs.
        runs: u32,
        /// Device to measure.
        device: DeviceChoice,
    },
    /// Ways to find light.
    Methods(MethodsJob),
    /// Whole renders.
    Render(RenderJob),
    /// Threads, pieces and devices.
    Scaling(ScalingJob),
    /// What textures cost.
    Textures(TexturesJob),
    /// The traversal kernel.
    Traverse(TraverseJob),
}

/// A measurement of ways to find light.
#[derive(Debug, PartialEq)]
pub(crate) struct MethodsJob {
    /// The glTF file; `None` is the built-in scene.
    pub(crate) scene: Option<PathBuf>,
    /// A look for it.
    pub(crate) look: Option<PathBuf>,
    /// What is compared; all if none were named.
    pub(crate) methods: Vec<How>,
    /// What it is compared with.
    pub(crate) reference: Option<PathBuf>,
    /// Samples per pixel of what is rendered in its place.
    pub(crate) reference_spp: u32,
    /// Stops.
    pub(crate) exposure: f32,
    /// Most minutes of all.
    pub(crate) minutes: u32,
    /// Reports to write; no two alike.
    pub(crate) reports: Vec<ReportFile>,
    /// How it is measured.
    pub(crate) effort: Effort,
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

/// A measurement of how rendering scales.
#[derive(Debug, PartialEq)]
pub(crate) struct ScalingJob {
    /// The glTF file; `None` is the built-in scene.
    pub(crate) scene: Option<PathBuf>,
    /// A look for it.
    pub(crate) look: Option<PathBuf>,
    /// Sides of the pictures, ascending.
    pub(crate) sides: Vec<u32>,
    /// Sides of the pieces, ascending.
    pub(crate) tiles: Vec<u32>,
    /// Numbers of threads, ascending; those that suit the machine if none were named.
    pub(crate) threads: Option<Vec<u32>>,
    /// Devices that render together; the processor's if none were named.
    pub(crate) devices: Devices,
    /// Samples per pixel of a run.
    pub(crate) spp: u32,
    /// Timed runs of each case.
    pub(crate) runs: u32,
    /// Most scattering vertices of a path.
    pub(crate) max_depth: u32,
    /// Most minutes of all.
    pub(crate) minutes: u32,
    /// Reports to write; no two alike.
    pub(crate) reports: Vec<ReportFile>,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
}

/// A measurement of what textures cost.
#[derive(Debug, PartialEq)]
pub(crate) struct TexturesJob {
    /// The glTF file and what is textured in it; `None` is the built-in scene.
    pub(crate) scene: Option<(PathBuf, Model)>,
    /// A look for it.
    pub(crate) look: Option<PathBuf>,
    /// Forms of the kernel; those that suit the device if none were named.
    pub(crate) forms: Option<Vec<Form>>,
    /// Rays of ambient occlusion, a table each.
    pub(crate) ao_rays: Vec<u32>,
    /// Another device whose driver is asked about kernels.
    pub(crate) statistics_device: Option<String>,
    /// What is changed beyond that.
    pub(crate) sweeps: Vec<Sweep>,
    /// Reports to write; no two alike.
    pub(crate) reports: Vec<ReportFile>,
    /// How it is measured.
    pub(crate) effort: Effort,
}

/// What is textured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Model {
    /// A material of the scene.
    Material(String),
    /// A glTF file that is put into the scene.
    Inserted(PathBuf),
}

/// A file that a report is written to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ReportFile {
    /// Where.
    pub(crate) path: PathBuf,
    /// What.
    pub(crate) format: ReportFormat,
}

/// Forms of a report, chosen by the file's extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ReportFormat {
    /// A page that needs no other file.
    Html,
    /// Figures for programs.
    Json,
    /// The chart alone.
    Svg,
}

/// How whole renders are measured.
#[derive(Debug, PartialEq)]
pub(crate) struct Effort {
    /// Samples per pixel of a run, if the user said so.
    pub(crate) spp: Option<u32>,
    /// Columns and rows of pixels, if the user said so.
    pub(crate) size: Option<(u32, u32)>,
    /// Timed runs of each case, if the user said so.
    pub(crate) runs: Option<u32>,
    /// Most scattering vertices of a path.
    pub(crate) max_depth: u32,
    /// Where the figures go.
    pub(crate) json: Option<PathBuf>,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
    /// Device to measure.
    pub(crate) device: DeviceChoice,
}

/// How much is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Amount {
    /// Pixels.
    pub(crate) width: u32,
    /// Pixels.
    pub(crate) height: u32,
    /// Samples per pixel of a run.
    pub(crate) spp: u32,
    /// Timed runs of each case.
    pub(crate) runs: u32,
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
            BenchCommand::Gather {
                photons,
                runs,
                device,
            } => Self::Gather {
                // A reference has twenty bits for a photon's number.
                photons: parse_number("--photons", &photons, 1 << 10, 1 << 20)?,
                runs: parse_number("--runs", &runs, 1, MAX_RUNS)?,
                device: parse_device(device.as_deref())?,
            },
            BenchCommand::Methods(args) => Self::Methods(MethodsJob::from_args(*args)?),
            BenchCommand::Render(args) => Self::Render(RenderJob::from_args(args)?),
            BenchCommand::Scaling(args) => Self::Scaling(ScalingJob::from_args(*args)?),
            BenchCommand::Textures(args) => Self::Textures(TexturesJob::from_args(*args)?),
            BenchCommand::Traverse { scene, device } => Self::Traverse(TraverseJob {
                scene,
                device: parse_device(device.as_deref())?,
            }),
        })
    }
}

impl MethodsJob {
    fn from_args(args: MethodsArgs) -> Result<Self, UsageError> {
        let read = [&args.scene, &args.look, &args.reference];
        let written = args.outputs.iter().chain(&args.effort.json);
        refuse_overwriting(written, read.into_iter().flatten())?;
        let reports = args.outputs.into_iter().map(ReportFile::from_path);
        let effort = Effort::from_args(args.effort, LEAST_SPP)?;
        Ok(Self {
            methods: parse_all(args.methods.iter(), |word| {
                parse_word("--methods", word, How::ALL, How::name)
            })?,
            reference_spp: parse_number("--reference-spp", &args.reference_spp, 1, MAX_SPP)?,
            exposure: parse_exposure(&args.exposure)?,
            minutes: parse_number("--minutes", &args.minutes, 1, MOST_MINUTES)?,
            reports: reports.collect::<Result<_, _>>()?,
            effort,
            scene: args.scene,
            look: args.look,
            reference: args.reference,
        })
    }
}

impl RenderJob {
    fn from_args(args: RenderArgs) -> Result<Self, UsageError> {
        let read = args.scenes.iter().chain(&args.look);
        refuse_overwriting(args.effort.json.iter(), read)?;
        Ok(Self {
            effort: Effort::from_args(args.effort, 1)?,
            scenes: args.scenes,
            look: args.look,
        })
    }
}

impl ScalingJob {
    fn from_args(args: ScalingArgs) -> Result<Self, UsageError> {
        let read = args.scene.iter().chain(&args.look);
        refuse_overwriting(args.outputs.iter(), read)?;
        let reports = args.outputs.into_iter().map(ReportFile::from_path);
        let numbers = |flag: &'static str, list: &str, most: u32| {
            let mut numbers = parse_all(list.split(','), |word| parse_number(flag, word, 1, most))?;
            numbers.sort_unstable();
            Ok(numbers)
        };
        let tiles = numbers("--tiles", &args.tiles, MAX_SIDE)?;
        if let Some(tile) = tiles.iter().find(|tile| !tile.is_multiple_of(8)) {
            let given = tile.to_string();
            return Err(UsageError::Tile { given });
        }
        let threads = args.threads.as_deref();
        let threads = threads.map(|list| numbers("--threads", list, MOST_THREADS));
        Ok(Self {
            sides: numbers("--sizes", &args.sizes, MOST_SCALED_SIDE)?,
            tiles,
            threads: threads.transpose()?,
            devices: parse_devices(&args.devices)?,
            spp: parse_number("--spp", &args.spp, 1, MAX_SPP)?,
            runs: parse_number("--runs", &args.runs, 1, MAX_RUNS)?,
            max_depth: parse_number("--max-depth", &args.max_depth, 1, MAX_DEPTH)?,
            minutes: parse_number("--minutes", &args.minutes, 1, MOST_MINUTES)?,
            reports: reports.collect::<Result<_, _>>()?,
            scene: args.scene,
            look: args.look,
            texture_dirs: args.texture_dirs,
        })
    }
}

impl TexturesJob {
    fn from_args(args: TexturesArgs) -> Result<Self, UsageError> {
        let read = [&args.scene, &args.look, &args.insert];
        let written = args.outputs.iter().chain(&args.effort.json);
        refuse_overwriting(written, read.into_iter().flatten())?;
        let reports = args.outputs.into_iter().map(ReportFile::from_path);
        let scene = match (args.scene, args.material, args.insert) {
            (None, ..) => None,
            (Some(path), Some(material), _) => Some((path, Model::Material(material))),
            (Some(path), None, Some(model)) => Some((path, Model::Inserted(model))),
            (Some(path), None, None) => return Err(UsageError::Untextured { path }),
        };
        Ok(Self {
            forms: match args.modes.is_empty() {
                true => None,
                false => Some(parse_all(args.modes.iter(), |word| {
                    parse_word("--modes", word, Form::ALL, Form::name)
                })?),
            },
            ao_rays: parse_all(args.ao_rays.split(','), |word| {
                parse_number("--ao-rays", word, 1, 255)
            })?,
            sweeps: match args.sweep.iter().any(|word| word == ALL) {
                true => Sweep::ALL.to_vec(),
                false => parse_all(args.sweep.iter(), |word| {
                    parse_word("--sweep", word, Sweep::ALL, Sweep::name)
                })?,
            },
            reports: reports.collect::<Result<_, _>>()?,
            effort: Effort::from_args(args.effort, LEAST_COMPARED_SPP)?,
            scene,
            look: args.look,
            statistics_device: args.statistics_device,
        })
    }
}

/// What words mean, each once.
fn parse_all<T: PartialEq, W: AsRef<str>>(
    words: impl Iterator<Item = W>,
    parse: impl Fn(&str) -> Result<T, UsageError>,
) -> Result<Vec<T>, UsageError> {
    let mut values = Vec::new();
    for word in words {
        let value = parse(word.as_ref().trim())?;
        if !values.contains(&value) {
            values.push(value);
        }
    }
    Ok(values)
}

impl ReportFile {
    fn from_path(path: PathBuf) -> Result<Self, UsageError> {
        let extension = path.extension().map(|e| e.to_ascii_lowercase());
        let format = match extension.as_ref().and_then(|e| e.to_str()) {
            Some("html" | "htm") => ReportFormat::Html,
            Some("json") => ReportFormat::Json,
            Some("svg") => ReportFormat::Svg,
            _ => return Err(UsageError::Report { path }),
        };
        Ok(Self { path, format })
    }
}

impl Effort {
    /// With so many samples per pixel at least.
    fn from_args(args: EffortArgs, least_spp: u32) -> Result<Self, UsageError> {
        let number = |flag, given: &Option<String>, low, high| {
            let given = given.as_deref();
            given
                .map(|given| parse_number(flag, given, low, high))
                .transpose()
        };
        Ok(Self {
            spp: number("--spp", &args.spp, least_spp, MAX_SPP)?,
            size: args.size.as_deref().map(parse_size).transpose()?,
            runs: number("--runs", &args.runs, 1, MAX_RUNS)?,
            max_depth: parse_number("--max-depth", &args.max_depth, 1, MAX_DEPTH)?,
            json: args.json,
            texture_dirs: args.texture_dirs,
            device: parse_device(args.device.as_deref())?,
        })
    }

    /// How much is rendered, where `usual` is what is rendered if the user said nothing.
    pub(crate) fn amount(&self, usual: Amount) -> Amount {
        let (width, height) = self.size.unwrap_or((usual.width, usual.height));
        Amount {
            width,
            height,
            spp: self.spp.unwrap_or(usual.spp),
            runs: self.runs.unwrap_or(usual.runs),
        }
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
        assert_eq!((effort.spp, effort.size, effort.runs), (None, None, None));
    }

    #[test]
    fn scaling_is_measured_in_ascending_steps() {
        let Ok(BenchJob::Scaling(job)) = job("scaling --threads 4,1,2 --sizes 64,32,64") else {
            panic!("all of it makes sense");
        };
        assert_eq!(job.threads, Some(vec![1, 2, 4]));
        assert_eq!(job.sides, [32, 64]);
        assert_eq!(job.tiles, [32, 64, 128, 256, 512, 1024, 2048]);
        assert_eq!(job.devices, Devices::default());
    }

    fn textures(line: &str) -> Result<TexturesJob, UsageError> {
        job(&format!("textures {line}")).map(|job| match job {
            BenchJob::Textures(job) => job,
            other => panic!("not about textures: {other:?}"),
        })
    }

    #[test]
    fn what_the_user_says_counts_for_more_than_what_is_usual() {
        let usual = Amount {
            width: 256,
            height: 256,
            spp: 4,
            runs: 5,
        };
        let job = textures("--size 64x32 --runs 2").unwrap();
        let expected = Amount {
            width: 64,
            height: 32,
            runs: 2,
            ..usual
        };
        assert_eq!(job.effort.amount(usual), expected);
    }

    #[test]
    fn reports_sweeps_and_models_are_understood() {
        let job = textures("-o a.HTML -o b.json -o c.svg --sweep ao,nodes,ao").unwrap();
        let formats: Vec<_> = job.reports.iter().map(|report| report.format).collect();
        let expected = [ReportFormat::Html, ReportFormat::Json, ReportFormat::Svg];
        assert_eq!(formats, expected);
        assert_eq!(job.sweeps, [Sweep::Ao, Sweep::Nodes]);
        assert_eq!(textures("--sweep all").unwrap().sweeps, Sweep::ALL);
        let job = textures("--scene a.glb --insert car.glb").unwrap();
        let car = Model::Inserted("car.glb".into());
        assert_eq!(job.scene, Some(("a.glb".into(), car)));
    }

    #[test]
    fn senseless_numbers_are_refused() {
        for (line, because) in [
            ("render --runs 0", "--runs 0"),
            ("render --spp x", "--spp x"),
            ("render --size 3", "--size 3"),
            ("render a.glb --json a.glb", "input"),
            ("scaling --sizes 256,0", "--sizes 0"),
            ("scaling --sizes 9000", "from 1 to 8192"),
            ("scaling --tiles 32,33", "multiple of 8"),
            ("scaling --threads 2,x", "--threads x"),
            ("scaling --minutes 0", "--minutes 0"),
            ("scaling -o scaling.txt", ".html"),
            ("methods --spp 3", "from 4 to"),
            ("textures --spp 1", "from 2 to"),
            ("textures --ao-rays 4,256", "--ao-rays 256"),
            ("textures --ao-rays -4", "from 1 to 255"),
            ("textures -o report.pdf", ".html"),
            ("textures -o report", ".html"),
            ("textures -o a.svg -o a.svg", "twice"),
            ("textures -o a.json --json a.json", "twice"),
            ("textures --scene a.glb", "--insert FILE"),
            ("textures --scene a.glb --insert b.json -o b.json", "input"),
        ] {
            let error = job(line).unwrap_err().to_string();
            assert!(error.contains(because), "{line}: {error}");
        }
    }
}
