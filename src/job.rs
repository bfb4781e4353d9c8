//! A validated job: what the command line asks for, with every number in range and every file name understood.
//!
//! Everything that can be refused without touching a file or a device is refused here, as a [`UsageError`]. Nothing
//! is opened, read or written here.

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use engine::gpu::DeviceChoice;
use thiserror::Error;

use crate::args::{Args, BenchCommand, Command, RenderArgs, WatchArgs};
use crate::texture::job::TextureJob;

/// Longest side of a picture, pixels.
pub(crate) const MAX_SIDE: u32 = engine::renderer::MAX_SIDE;
/// Most pixels of a picture. The film keeps 28 bytes for each.
pub(crate) const MAX_PIXELS: u64 = 1 << 26;
/// Most samples per pixel. The film's sums are 32-bit floats, which more samples would not make better.
pub(crate) const MAX_SPP: u32 = 1 << 20;
/// Most scattering vertices of a path.
pub(crate) const MAX_DEPTH: u32 = 255;
/// Strongest exposure in stops, either way.
pub(crate) const MAX_EXPOSURE: f32 = 32.0;

/// What is to be done.
#[derive(Debug, PartialEq)]
pub(crate) enum Job {
    /// Render a scene.
    Render(RenderJob),
    /// Render a scene whenever its files change.
    Watch(WatchJob),
    /// Do something with textures.
    Texture(TextureJob),
    /// List devices.
    Devices,
    /// Build and run one texture alone.
    ProbeTexture {
        /// The texture.
        file: PathBuf,
        /// Device to run it on.
        device: DeviceChoice,
    },
    /// Measure the texture kernel.
    BenchKernel {
        /// Most textures in a kernel.
        most: u32,
        /// Folders the user named, searched first.
        texture_dirs: Vec<PathBuf>,
        /// Device to measure.
        device: DeviceChoice,
    },
    /// Measure live edits.
    BenchEdit {
        /// Nodes of the look.
        nodes: u32,
        /// Edits of each kind.
        edits: u32,
        /// Device to measure.
        device: DeviceChoice,
    },
    /// Measure the traversal kernel.
    BenchTraverse(BenchTraverseJob),
}

/// A render, complete.
#[derive(Debug, PartialEq)]
pub(crate) struct RenderJob {
    /// The glTF file.
    pub(crate) scene: PathBuf,
    /// The look file.
    pub(crate) look: Option<PathBuf>,
    /// Where the picture goes; at least one, no two alike.
    pub(crate) outputs: Vec<Output>,
    /// Samples per pixel.
    pub(crate) spp: NonZeroU32,
    /// Pixels.
    pub(crate) width: u32,
    /// Pixels.
    pub(crate) height: u32,
    /// Name of the camera.
    pub(crate) camera: Option<String>,
    /// Most scattering vertices of a path.
    pub(crate) max_depth: u32,
    /// Rough surfaces keep the energy that single scattering between microfacets loses.
    pub(crate) energy_compensation: bool,
    /// Seed of the random numbers.
    pub(crate) seed: u32,
    /// Device to render on.
    pub(crate) device: DeviceChoice,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
    /// Stops; EXR keeps the radiance.
    pub(crate) exposure: f32,
    /// Print statistics.
    pub(crate) stats: bool,
    /// Write statistics.
    pub(crate) stats_json: Option<PathBuf>,
}

/// A scene to be rendered live.
#[derive(Debug, PartialEq)]
pub(crate) struct WatchJob {
    /// The glTF file.
    pub(crate) scene: PathBuf,
    /// The look file.
    pub(crate) look: Option<PathBuf>,
    /// Where the picture goes; at least one, no two alike.
    pub(crate) outputs: Vec<Output>,
    /// Samples per pixel of the last picture.
    pub(crate) spp: NonZeroU32,
    /// Pixels.
    pub(crate) width: u32,
    /// Pixels.
    pub(crate) height: u32,
    /// Name of the camera.
    pub(crate) camera: Option<String>,
    /// Most scattering vertices of a path.
    pub(crate) max_depth: u32,
    /// Seed of the random numbers.
    pub(crate) seed: u32,
    /// Device to render on.
    pub(crate) device: DeviceChoice,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
    /// Stops; EXR keeps the radiance.
    pub(crate) exposure: f32,
}

/// A picture file to write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Output {
    /// Where.
    pub(crate) path: PathBuf,
    /// What.
    pub(crate) format: Format,
}

/// Picture formats, chosen by the file's extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    /// 8-bit sRGB, exposed.
    Png,
    /// The same, compressed with loss: a noisy picture takes a tenth of the room.
    Jpeg,
    /// 32-bit linear Rec.709 floats, as rendered.
    Exr,
}

/// A measurement of the traversal kernel.
#[derive(Debug, PartialEq)]
pub(crate) struct BenchTraverseJob {
    /// The glTF file; `None` is the built-in scene.
    pub(crate) scene: Option<PathBuf>,
    /// Device to measure.
    pub(crate) device: DeviceChoice,
}

/// A command line that makes no sense.
#[derive(Debug, Error, PartialEq)]
pub(crate) enum UsageError {
    /// Not `WxH`, or outside the limits.
    #[error("--size {given}: {problem}; give width x height in pixels, as in --size 1280x720")]
    Size {
        /// As typed.
        given: String,
        /// What is wrong with it.
        problem: String,
    },
    /// Not a whole number in the range.
    #[error("{flag} {given}: must be a whole number from {low} to {high}")]
    Number {
        /// The flag's name.
        flag: &'static str,
        /// As typed.
        given: String,
        /// Smallest value allowed.
        low: u32,
        /// Largest value allowed.
        high: u32,
    },
    /// Not a finite number of stops in range.
    #[error(
        "--exposure {given}: must be a number of stops from -{MAX_EXPOSURE} to {MAX_EXPOSURE}, as in --exposure 1.5"
    )]
    Exposure {
        /// As typed.
        given: String,
    },
    /// The extension says no format.
    #[error(
        "-o {}: the file name must end in .png or .jpg (8-bit sRGB) or .exr (linear float)",
        path.display()
    )]
    Extension {
        /// As typed.
        path: PathBuf,
    },
    /// Two results would overwrite each other.
    #[error("{} is to be written twice; give each output a name of its own", path.display())]
    Twice {
        /// The file.
        path: PathBuf,
    },
    /// A result would overwrite an input.
    #[error("{} is an input of this render; write the result to another file", path.display())]
    OverwritesInput {
        /// The file.
        path: PathBuf,
    },
    /// Not `NAME=VALUE`.
    #[error("{flag} {given}: write NAME=VALUE, as in {example}")]
    Pair {
        /// The flag's name.
        flag: &'static str,
        /// As typed.
        given: String,
        /// How it is done.
        example: &'static str,
    },
    /// Not one to four numbers.
    #[error(
        "--at {given}: `{name}` takes 1 to 4 numbers with commas between, as in --at \"WorldPos=1,2,3\""
    )]
    Numbers {
        /// The point as typed.
        given: String,
        /// The attribute.
        name: String,
    },
    /// Not two numbers, the second one the larger.
    #[error("--range {given}: write two numbers, the smaller one first, as in --range -1..1")]
    Range {
        /// As typed.
        given: String,
    },
    /// A name that no texture should have.
    #[error("`{given}` can't be the name of a texture: {problem}")]
    TextureName {
        /// As typed.
        given: String,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// `--device ''`.
    #[error("--device: the name is empty; `patina devices` lists names and numbers")]
    EmptyDevice,
}

impl Job {
    /// Validates a command line.
    ///
    /// # Errors
    /// The first flag that makes no sense.
    pub(crate) fn from_args(args: Args) -> Result<Self, UsageError> {
        Ok(match args.command {
            Command::Render(args) => Self::Render(RenderJob::from_args(*args)?),
            Command::Watch(args) => Self::Watch(WatchJob::from_args(*args)?),
            Command::Texture { what } => Self::Texture(TextureJob::from_args(what)?),
            Command::Devices => Self::Devices,
            Command::ProbeTexture { file, device } => Self::ProbeTexture {
                file,
                device: parse_device(device.as_deref())?,
            },
            Command::Bench {
                what:
                    BenchCommand::Kernel {
                        most,
                        texture_dirs,
                        device,
                    },
            } => Self::BenchKernel {
                most: parse_number("--most", &most, 1, 100)?,
                texture_dirs,
                device: parse_device(device.as_deref())?,
            },
            Command::Bench {
                what:
                    BenchCommand::Edit {
                        nodes,
                        edits,
                        device,
                    },
            } => Self::BenchEdit {
                nodes: parse_number("--nodes", &nodes, 4, 100_000)?,
                edits: parse_number("--edits", &edits, 100, 1_000_000)?,
                device: parse_device(device.as_deref())?,
            },
            Command::Bench {
                what: BenchCommand::Traverse { scene, device },
            } => Self::BenchTraverse(BenchTraverseJob {
                scene,
                device: parse_device(device.as_deref())?,
            }),
        })
    }
}

impl RenderJob {
    fn from_args(args: RenderArgs) -> Result<Self, UsageError> {
        let (width, height) = parse_size(&args.size)?;
        let outputs = parse_outputs(args.outputs, &args.scene)?;
        refuse_overwriting(
            outputs
                .iter()
                .map(|output| &output.path)
                .chain(&args.stats_json),
            [Some(&args.scene), args.look.as_ref()]
                .into_iter()
                .flatten(),
        )?;
        Ok(Self {
            outputs,
            spp: NonZeroU32::new(parse_number("--spp", &args.spp, 1, MAX_SPP)?)
                .expect("the range starts at 1"),
            width,
            height,
            camera: args.camera,
            energy_compensation: !args.no_energy_compensation,
            max_depth: parse_number("--max-depth", &args.max_depth, 1, MAX_DEPTH)?,
            seed: parse_number("--seed", &args.seed, 0, u32::MAX)?,
            device: parse_device(args.device.as_deref())?,
            texture_dirs: args.texture_dirs,
            exposure: parse_exposure(&args.exposure)?,
            stats: args.stats,
            stats_json: args.stats_json,
            scene: args.scene,
            look: args.look,
        })
    }
}

impl WatchJob {
    fn from_args(args: WatchArgs) -> Result<Self, UsageError> {
        let (width, height) = parse_size(&args.size)?;
        let outputs = parse_outputs(args.outputs, &args.scene)?;
        refuse_overwriting(
            outputs.iter().map(|output| &output.path),
            [Some(&args.scene), args.look.as_ref()]
                .into_iter()
                .flatten(),
        )?;
        Ok(Self {
            outputs,
            spp: NonZeroU32::new(parse_number("--spp", &args.spp, 1, MAX_SPP)?)
                .expect("the range starts at 1"),
            width,
            height,
            camera: args.camera,
            max_depth: parse_number("--max-depth", &args.max_depth, 1, MAX_DEPTH)?,
            seed: parse_number("--seed", &args.seed, 0, u32::MAX)?,
            device: parse_device(args.device.as_deref())?,
            texture_dirs: args.texture_dirs,
            exposure: parse_exposure(&args.exposure)?,
            scene: args.scene,
            look: args.look,
        })
    }
}

/// The outputs asked for, or the usual one.
fn parse_outputs(given: Vec<PathBuf>, scene: &Path) -> Result<Vec<Output>, UsageError> {
    match given.is_empty() {
        true => Ok(vec![default_output(scene)]),
        false => given.into_iter().map(parse_output).collect(),
    }
}

fn parse_size(given: &str) -> Result<(u32, u32), UsageError> {
    let refuse = |problem: String| UsageError::Size {
        given: given.to_owned(),
        problem,
    };
    let side = |text: &str, name: &str| match text.parse::<u64>() {
        Ok(0) => Err(refuse(format!("the {name} is zero"))),
        Ok(n) if n > u64::from(MAX_SIDE) => Err(refuse(format!("the {name} exceeds {MAX_SIDE}"))),
        Ok(n) => Ok(n as u32),
        Err(_) if text.is_empty() => Err(refuse(format!("the {name} is missing"))),
        // Digits that do not fit 64 bits are still a number to the user.
        Err(_) if text.bytes().all(|b| b.is_ascii_digit()) => {
            Err(refuse(format!("the {name} exceeds {MAX_SIDE}")))
        }
        Err(_) => Err(refuse(format!("the {name} is not a whole number"))),
    };
    let Some((width, height)) = given.split_once(['x', 'X']) else {
        return Err(refuse("there is no 'x' between two numbers".to_owned()));
    };
    let (width, height) = (side(width, "width")?, side(height, "height")?);
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MAX_PIXELS {
        return Err(refuse(format!(
            "{pixels} pixels are more than the {MAX_PIXELS} supported"
        )));
    }
    Ok((width, height))
}

pub(crate) fn parse_number(
    flag: &'static str,
    given: &str,
    low: u32,
    high: u32,
) -> Result<u32, UsageError> {
    given
        .parse::<u32>()
        .ok()
        .filter(|n| (low..=high).contains(n))
        .ok_or_else(|| UsageError::Number {
            flag,
            given: given.to_owned(),
            low,
            high,
        })
}

fn parse_exposure(given: &str) -> Result<f32, UsageError> {
    given
        .parse::<f32>()
        .ok()
        // NaN is in no range.
        .filter(|stops| (-MAX_EXPOSURE..=MAX_EXPOSURE).contains(stops))
        .ok_or_else(|| UsageError::Exposure {
            given: given.to_owned(),
        })
}

pub(crate) fn parse_device(given: Option<&str>) -> Result<DeviceChoice, UsageError> {
    match given.map(str::trim) {
        None => Ok(DeviceChoice::Best),
        Some("") => Err(UsageError::EmptyDevice),
        Some(text) => Ok(match text.parse() {
            Ok(index) => DeviceChoice::Index(index),
            Err(_) => DeviceChoice::Name(text.to_owned()),
        }),
    }
}

pub(crate) fn parse_output(path: PathBuf) -> Result<Output, UsageError> {
    let extension = path
        .extension()
        .map(|extension| extension.to_ascii_lowercase());
    let format = match extension.as_ref().and_then(|extension| extension.to_str()) {
        Some("png") => Format::Png,
        Some("jpg" | "jpeg") => Format::Jpeg,
        Some("exr") => Format::Exr,
        _ => return Err(UsageError::Extension { path }),
    };
    Ok(Output { path, format })
}

/// `SCENE-render.png`: not `SCENE.png`, which may well be a texture of the scene.
fn default_output(scene: &Path) -> Output {
    let mut name = scene
        .file_stem()
        .map_or_else(|| "scene".into(), ToOwned::to_owned);
    name.push("-render.png");
    Output {
        path: name.into(),
        format: Format::Png,
    }
}

fn refuse_overwriting<'a>(
    written: impl Iterator<Item = &'a PathBuf>,
    read: impl Iterator<Item = &'a PathBuf>,
) -> Result<(), UsageError> {
    let inputs: Vec<_> = read.collect();
    let mut seen: Vec<&PathBuf> = Vec::new();
    for path in written {
        if seen.contains(&path) {
            return Err(UsageError::Twice { path: path.clone() });
        }
        if inputs.contains(&path) {
            return Err(UsageError::OverwritesInput { path: path.clone() });
        }
        seen.push(path);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    fn job(line: &str) -> Result<Job, UsageError> {
        let words = ["patina"].into_iter().chain(line.split_whitespace());
        Job::from_args(Args::try_parse_from(words).expect("clap accepts the line"))
    }

    fn render(line: &str) -> Result<RenderJob, UsageError> {
        job(line).map(|job| match job {
            Job::Render(job) => job,
            other => panic!("not a render: {other:?}"),
        })
    }

    #[test]
    fn a_bare_render_has_sensible_defaults() {
        let job = render("render some/where/helmet.glb").unwrap();
        assert_eq!((job.width, job.height), (1280, 720));
        assert_eq!((job.spp.get(), job.max_depth, job.seed), (64, 9, 0));
        assert_eq!(job.device, DeviceChoice::Best);
        assert_eq!(job.outputs[0].path, Path::new("helmet-render.png"));
        assert_eq!(job.outputs[0].format, Format::Png);
    }

    #[test]
    fn formats_follow_the_extension_in_any_case() {
        let job = render("render a.glb -o x.PNG --output y.exr").unwrap();
        let formats: Vec<_> = job.outputs.iter().map(|output| output.format).collect();
        assert_eq!(formats, [Format::Png, Format::Exr]);
        for bad in ["x", "x.gif", "png", ".png", "x.png.gz"] {
            let error = render(&format!("render a.glb -o {bad}")).unwrap_err();
            assert!(error.to_string().contains(".exr"), "{bad}: {error}");
        }
    }

    #[test]
    fn sizes_are_two_positive_bounded_numbers() {
        assert_eq!(parse_size("1x1"), Ok((1, 1)));
        assert_eq!(parse_size("1920X1080"), Ok((1920, 1080)));
        for (bad, because) in [
            ("0x0", "width is zero"),
            ("640x0", "height is zero"),
            ("1x", "height is missing"),
            ("x1", "width is missing"),
            ("", "no 'x'"),
            ("640", "no 'x'"),
            ("-1", "no 'x'"),
            ("-1x2", "width is not a whole number"),
            ("1.5x2", "width is not a whole number"),
            ("99999999x2", "width exceeds 16384"),
            ("2x99999999999999999999999", "height exceeds 16384"),
            ("16384x16384", "268435456 pixels"),
            ("2x3x4", "height is not a whole number"),
        ] {
            let error = parse_size(bad).unwrap_err().to_string();
            assert!(error.contains(because), "{bad}: {error}");
        }
    }

    #[test]
    fn numbers_out_of_range_are_refused_with_the_range() {
        for (line, because) in [
            ("--spp 0", "from 1 to"),
            ("--spp -1", "from 1 to"),
            ("--spp many", "from 1 to"),
            ("--max-depth 0", "from 1 to 255"),
            ("--max-depth 256", "from 1 to 255"),
            ("--seed -1", "from 0 to 4294967295"),
            ("--seed 4294967296", "from 0 to 4294967295"),
            ("--exposure NaN", "number of stops"),
            ("--exposure inf", "number of stops"),
            ("--exposure bright", "number of stops"),
        ] {
            let error = render(&format!("render a.glb {line}"))
                .unwrap_err()
                .to_string();
            assert!(error.contains(because), "{line}: {error}");
        }
        assert_eq!(
            render("render a.glb --exposure -1.5").unwrap().exposure,
            -1.5
        );
    }

    #[test]
    fn a_device_is_a_number_or_a_name() {
        assert_eq!(parse_device(Some("2")), Ok(DeviceChoice::Index(2)));
        assert_eq!(
            parse_device(Some("llvmpipe")),
            Ok(DeviceChoice::Name("llvmpipe".into()))
        );
        assert_eq!(parse_device(Some(" ")), Err(UsageError::EmptyDevice));
    }

    #[test]
    fn no_file_is_written_twice_or_over_an_input() {
        let twice = render("render a.glb -o x.png -o x.png").unwrap_err();
        assert!(matches!(twice, UsageError::Twice { .. }));
        let stats = render("render a.glb -o x.png --stats-json x.png").unwrap_err();
        assert!(matches!(stats, UsageError::Twice { .. }));
        let input = render("render a.glb --look l.toml --stats-json l.toml").unwrap_err();
        assert!(matches!(input, UsageError::OverwritesInput { .. }));
    }

    #[test]
    fn the_benchmark_needs_no_scene() {
        let expected = BenchTraverseJob {
            scene: None,
            device: DeviceChoice::Best,
        };
        assert_eq!(job("bench traverse"), Ok(Job::BenchTraverse(expected)));
    }
}
