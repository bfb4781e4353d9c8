//! A validated job: what the command line asks for, with every number in range and every file name understood.
//!
//! Everything that can be refused without touching a file or a device is refused here, as a [`UsageError`]. Nothing
//! is opened, read or written here.

mod render;

use std::ops::Range;
use std::path::PathBuf;

use clap::Parser;
use device::DeviceChoice;
use engine::film::write::Form;
use engine::scene::view::ViewChoice;

use crate::args::{Args, Command, MergeArgs};
use crate::bake::job::BakeJob;
use crate::bench::job::BenchJob;
use crate::compare::job::CompareJob;
use crate::export::job::GltfJob;
use crate::farm::job::{ExportJob, PartInputs};
use crate::form;
use crate::import::job::ImportJob;
use crate::info::job::InfoJob;
use crate::texture::job::TextureJob;
use crate::usage::UsageError;
use crate::view::job::ViewJob;
use crate::watch::job::WatchJob;
use crate::words::{Outputs, parse_device, parse_display, parse_sample_range, refuse_overwriting};

pub(crate) use self::render::{Checkpoints, Limits, RenderJob};

/// What is to be done.
#[derive(Debug, PartialEq)]
pub(crate) enum Job {
    /// Render a scene.
    Render(Box<RenderJob>),
    /// Render a scene whenever its files change.
    Watch(WatchJob),
    /// Open a window.
    View(ViewJob),
    /// Add films.
    Merge(MergeJob),
    /// Write a job for a farm.
    Farm(ExportJob),
    /// Compare two pictures.
    Compare(CompareJob),
    /// Tell what a file holds.
    Info(InfoJob),
    /// Turn a MaterialX document into a look.
    Import(ImportJob),
    /// Write pictures of a material or a node.
    Bake(Box<BakeJob>),
    /// Write a scene without programs.
    Export(Box<GltfJob>),
    /// Do something with textures.
    Texture(TextureJob),
    /// List devices.
    Devices,
    /// Write the manual's pages and completions for shells into this folder.
    Manuals(PathBuf),
    /// Build and run one texture alone.
    ProbeTexture {
        /// The texture.
        file: PathBuf,
        /// Device to run it on.
        device: DeviceChoice,
    },
    /// Measure the renderer.
    Bench(BenchJob),
}

/// A merge, complete.
#[derive(Debug, PartialEq)]
pub(crate) struct MergeJob {
    /// The films; at least one, no two alike.
    pub(crate) parts: Vec<PathBuf>,
    /// The samples that they must make up.
    pub(crate) expected: Option<Range<u32>>,
    /// The look file that says how the picture is shown.
    pub(crate) look: Option<PathBuf>,
    /// Where the picture and the film go.
    pub(crate) outputs: Outputs,
    /// Take the noise out of the picture.
    pub(crate) denoise: bool,
    /// Leave out the environment behind everything.
    pub(crate) transparent: bool,
    /// How EXR files are written.
    pub(crate) form: Form,
    /// How PNG and JPEG show it, as far as the command line says it.
    pub(crate) display: ViewChoice,
}

impl Job {
    /// Validates a command line.
    ///
    /// # Errors
    /// The first flag that makes no sense.
    pub(crate) fn from_args(args: Args) -> Result<Self, UsageError> {
        Ok(match args.command {
            Command::Render(args) => Self::Render(Box::new(RenderJob::from_args(*args)?)),
            Command::Watch(args) => Self::Watch(WatchJob::from_args(*args)?),
            Command::View(args) => Self::View(ViewJob::from_args(*args)?),
            Command::Merge(args) => Self::Merge(MergeJob::from_args(args)?),
            Command::Farm { what } => Self::Farm(ExportJob::from_args(what, inputs_of_a_part)?),
            Command::Compare(args) => Self::Compare(CompareJob::from_args(args)?),
            Command::Info(args) => Self::Info(InfoJob::from_args(args)),
            Command::Bake(args) => Self::Bake(Box::new(BakeJob::from_args(args)?)),
            Command::Export(args) => Self::Export(Box::new(GltfJob::from_args(args)?)),
            Command::Import(args) => Self::Import(ImportJob::from_args(args)?),
            Command::Texture { what } => Self::Texture(TextureJob::from_args(what)?),
            Command::Devices => Self::Devices,
            Command::Manuals { dir } => Self::Manuals(dir),
            Command::ProbeTexture { file, device } => Self::ProbeTexture {
                file,
                device: parse_device(device.as_deref())?,
            },
            Command::Bench { what } => Self::Bench(BenchJob::from_args(what)?),
        })
    }
}

impl Job {
    /// Threads that are to compute, if not one for each processor.
    pub(crate) fn threads(&self) -> Option<usize> {
        match self {
            Self::Render(job) => job.threads.map(|threads| threads as usize),
            Self::View(job) => job.threads.map(|threads| threads as usize),
            _ => None,
        }
    }
}

/// What `patina render` reads by these words, which must write nothing but one film.
fn inputs_of_a_part(words: &[String]) -> Result<PartInputs, UsageError> {
    let start = ["patina", "render"].map(str::to_owned);
    let words = start.iter().chain(words);
    let refused = |message: String| UsageError::FarmFlags { message };
    let args = Args::try_parse_from(words).map_err(|error| refused(error.render().to_string()))?;
    let Command::Render(args) = args.command else {
        return Err(refused("these are no flags of `patina render`".to_owned()));
    };
    let job = RenderJob::from_args(*args).map_err(|error| match error {
        UsageError::Apart {
            flag: "--shutter",
            other: "--sample-range",
            ..
        } => UsageError::FarmShutter,
        error => error,
    })?;
    let several = job.outputs.paths().nth(1).map(|_| "-o");
    match several.or(job.stats_json.as_ref().map(|_| "--stats-json")) {
        Some(flag) => Err(UsageError::FarmFlag {
            flag: flag.to_owned(),
        }),
        None => Ok(PartInputs {
            look: job.look,
            overrides: job.overrides,
            texture_dirs: job.texture_dirs,
        }),
    }
}

impl MergeJob {
    fn from_args(args: MergeArgs) -> Result<Self, UsageError> {
        let outputs = Outputs::from_paths(args.outputs, None)?;
        refuse_overwriting(outputs.paths(), args.parts.iter().chain(&args.look))?;
        let mut parts = args.parts.iter().enumerate();
        if let Some((_, path)) = parts.find(|(i, path)| args.parts[..*i].contains(path)) {
            return Err(UsageError::PartTwice { path: path.clone() });
        }
        let expected = args.expect.as_deref();
        Ok(Self {
            expected: expected
                .map(|range| parse_sample_range("--expect", range))
                .transpose()?,
            parts: args.parts,
            look: args.look,
            outputs,
            denoise: args.denoise,
            transparent: args.transparent,
            form: form::parse(&args.form)?,
            display: parse_display(&args.display)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::{
        Devices, Format, Output, parse_devices, parse_memory, parse_scale, parse_size,
    };
    use engine::film::Layers;
    use engine::scene::view::{View, ViewTransform};
    use std::path::Path;

    fn job(line: &str) -> Result<Job, UsageError> {
        let words = ["patina"].into_iter().chain(line.split_whitespace());
        Job::from_args(Args::try_parse_from(words).expect("clap accepts the line"))
    }

    fn render(line: &str) -> Result<RenderJob, UsageError> {
        job(line).map(|job| match job {
            Job::Render(job) => *job,
            other => panic!("not a render: {other:?}"),
        })
    }

    #[test]
    fn a_bare_render_has_sensible_defaults() {
        let job = render("render some/where/helmet.glb").unwrap();
        assert_eq!((job.width, job.height), (1280, 720));
        assert_eq!((job.spp.get(), job.max_depth, job.seed), (64, 9, 0));
        assert_eq!(job.devices, Devices::default());
        assert_eq!(job.first_sample, 0);
        let expected = Output {
            path: "helmet-render.png".into(),
            format: Format::Png,
        };
        assert_eq!(job.outputs.pictures, [expected]);
        assert!(job.outputs.films.is_empty());
    }

    #[test]
    fn layers_go_to_files_that_can_hold_them() {
        let job = render("render a.glb --layers normal,depth -o x.exr").unwrap();
        let names: Vec<_> = job.layers.iter().map(|layer| layer.name).collect();
        assert_eq!(names, ["combined", "depth", "normal"]);
        assert!(render("render a.glb --layers depth -o x.patina-film").is_ok());
        assert!(render("render a.glb --layers combined").is_ok());
        let error = render("render a.glb --layers depth -o x.png").unwrap_err();
        assert!(error.to_string().contains(".exr"), "{error}");
    }

    #[test]
    fn what_a_picture_is_denoised_by_is_gathered_and_not_shown() {
        let names = |layers: &Layers| -> Vec<_> { layers.iter().map(|layer| layer.name).collect() };
        let job = render("render a.glb --denoise").unwrap();
        assert_eq!(names(&job.layers), ["combined", "normal", "albedo"]);
        assert!(job.denoise && job.shown_layers.is_picture_alone());
        let job = render("render a.glb --denoise --layers depth,normal -o x.exr").unwrap();
        let gathered = ["combined", "depth", "normal", "albedo"];
        assert_eq!(names(&job.layers), gathered);
        assert_eq!(names(&job.shown_layers), ["combined", "depth", "normal"]);
    }

    #[test]
    fn formats_follow_the_extension_in_any_case() {
        let job = render("render a.glb -o x.PNG --output y.exr").unwrap();
        let formats: Vec<_> = job.outputs.pictures.iter().map(|o| o.format).collect();
        assert_eq!(formats, [Format::Png, Format::Exr]);
        for bad in ["x", "x.gif", "png", ".png", "x.png.gz"] {
            let error = render(&format!("render a.glb -o {bad}")).unwrap_err();
            assert!(error.to_string().contains(".exr"), "{bad}: {error}");
        }
    }

    #[test]
    fn a_range_of_samples_is_two_ascending_numbers() {
        let job = render("render a.glb --sample-range 16..40 -o x.patina-film").unwrap();
        assert_eq!((job.first_sample, job.spp.get()), (16, 24));
        assert_eq!(job.outputs.films, [Path::new("x.patina-film")]);
        assert!(job.outputs.pictures.is_empty());
        for bad in [
            "16",
            "3..3",
            "4..3",
            "..3",
            "3..",
            "-1..3",
            "0..1048577",
            "0..1e3",
        ] {
            let error = render(&format!("render a.glb --sample-range {bad}")).unwrap_err();
            assert!(matches!(error, UsageError::SampleRange { .. }), "{bad}");
        }
    }

    #[test]
    fn parts_are_merged_once_and_not_overwritten() {
        assert!(job("merge a.patina-film b.patina-film -o c.exr").is_ok());
        let error = job("merge a.patina-film a.patina-film -o c.exr").unwrap_err();
        assert!(matches!(error, UsageError::PartTwice { .. }));
        let error = job("merge a.patina-film -o a.patina-film").unwrap_err();
        assert!(matches!(error, UsageError::OverwritesInput { .. }));
        let error = job("merge a.patina-film -o a.tiff").unwrap_err();
        assert!(matches!(error, UsageError::ExtensionOfFilm { .. }));
    }

    #[test]
    fn comparisons_have_limits_that_make_sense() {
        let Ok(Job::Compare(found)) = job("compare a.png b.exr --max-flip 0.05 --exposure -1")
        else {
            panic!("a comparison");
        };
        assert_eq!((found.most.flip, found.most.mse), (Some(0.05), None));
        assert_eq!((found.exposure, found.diff), (-1.0, None));
        assert!(job("compare a.exr b.exr --diff d.PNG").is_ok());
        for (line, because) in [
            ("--diff d.exr", ".png"),
            ("--diff b.png", "input"),
            ("--max-flip -1", "isn't negative"),
            ("--max-mse NaN", "isn't negative"),
            ("--max-relative-mse little", "isn't negative"),
            ("--exposure 99", "stops"),
        ] {
            let error = job(&format!("compare a.png b.png {line}")).unwrap_err();
            assert!(error.to_string().contains(because), "{line}: {error}");
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
            ("--clamp 0", "greater than 0"),
            ("--filter-width 0", "from 0.1 to 16"),
            ("--filter-width wide", "from 0.1 to 16"),
            ("--exposure NaN", "number of stops"),
            ("--exposure inf", "number of stops"),
            ("--exposure bright", "number of stops"),
        ] {
            let error = render(&format!("render a.glb {line}"))
                .unwrap_err()
                .to_string();
            assert!(error.contains(because), "{line}: {error}");
        }
        let job = render("render a.glb --exposure -1.5").unwrap();
        assert_eq!(job.display.exposure, Some(-1.5));
    }

    #[test]
    fn a_part_of_the_picture_lies_in_it() {
        let job = render("render a.glb --size 64x40 --crop 8,4,20,36").unwrap();
        assert_eq!((job.width, job.height), (20, 36));
        let crop = job.crop.expect("it is said");
        assert_eq!((crop.left, crop.top, crop.whole), (8, 4, [64, 40]));
        assert_eq!(render("render a.glb").unwrap().crop, None);
        for bad in [
            "8,4,20,37",
            "0,0,0,1",
            "1,2,3",
            "a,0,1,1",
            "-1,0,1,1",
            "64,0,1,1",
        ] {
            let error = render(&format!("render a.glb --size 64x40 --crop {bad}")).unwrap_err();
            let text = error.to_string();
            assert!(text.contains("64 x 40"), "{bad}: {text}");
        }
        // Of what --scale makes of it.
        assert!(render("render a.glb --size 64x40 --scale 50% --crop 8,4,20,16").is_ok());
        assert!(render("render a.glb --size 64x40 --scale 50% --crop 8,4,30,16").is_err());
    }

    #[test]
    fn ids_are_not_packed_with_loss() {
        let line = "render a.glb --exr-compression dwaa -o a.exr --layers";
        assert!(render(&format!("{line} depth")).is_ok());
        let error = render(&format!("{line} depth,crypto_object")).unwrap_err();
        assert!(error.to_string().contains("choose zip"), "{error}");
    }

    #[test]
    fn memory_has_a_unit() {
        let memory =
            |given: &str| render(&format!("render a.glb --memory {given}")).map(|j| j.memory);
        assert_eq!(memory("8G"), Ok(Some(8 << 30)));
        assert_eq!(memory("1.5m"), Ok(Some(3 << 19)));
        assert_eq!(memory("2GiB"), Ok(Some(2 << 30)));
        for bad in ["8", "G", "-1G", "nanG", "1e30T", "0G", "much", ""] {
            let error = parse_memory(bad).unwrap_err().to_string();
            assert!(error.contains("500M"), "{bad}: {error}");
        }
    }

    #[test]
    fn a_view_is_what_is_said_of_it() {
        let display = |line: &str| render(&format!("render a.glb {line}")).map(|job| job.display);
        assert_eq!(display("--exposure 0").unwrap().view(), View::default());
        assert_eq!(display("--spp 1"), Ok(ViewChoice::default()));
        let said = display("--view aces2 --white-balance 3200,-20").unwrap();
        assert_eq!(said.transform, Some(ViewTransform::Aces2));
        let white = said.white_balance.expect("it is said");
        assert_eq!((white.temperature, white.tint), (3200.0, -20.0));
        for bad in ["warm", "100", "5000,", "5000,x", "5000,101", "1,2,3", "nan"] {
            let error = display(&format!("--white-balance {bad}")).unwrap_err();
            assert!(
                error.to_string().contains("from 1800 to 25000"),
                "{bad}: {error}"
            );
        }
    }

    #[test]
    fn threads_are_counted() {
        let threads = |line: &str| job(line).map(|job| job.threads());
        assert_eq!(threads("render a.glb"), Ok(None));
        assert_eq!(threads("render a.glb --threads 3"), Ok(Some(3)));
        assert_eq!(threads("view a.glb --threads 3"), Ok(Some(3)));
        assert!(threads("render a.glb --threads 0").is_err());
        assert!(threads("view a.glb --threads 0").is_err());
        assert!(threads("render a.glb --threads -1").is_err());
        assert_eq!(threads("devices"), Ok(None));
    }

    #[test]
    fn a_device_is_a_number_or_a_name() {
        assert_eq!(parse_device(Some("2")), Ok(DeviceChoice::Index(2)));
        assert_eq!(
            parse_device(Some("llvmpipe")),
            Ok(DeviceChoice::Name("llvmpipe".into()))
        );
        assert_eq!(parse_device(Some(" ")), Err(UsageError::EmptyDevice));
        assert_eq!(parse_device(Some("native:3")), Ok(DeviceChoice::Native(3)));
        let error = parse_device(Some("native:0")).unwrap_err().to_string();
        assert!(error.contains("from 1 to 1024"), "{error}");
        let error = parse_device(Some("native:1,native:1")).unwrap_err();
        assert!(error.to_string().contains("one device"), "{error}");
        for line in [
            "watch a.glb",
            "bake Paint --scene a.glb -o a.png",
            "texture eval fbm",
            "bench render",
        ] {
            let error = job(&format!("{line} --device All")).unwrap_err();
            let expected = UsageError::SeveralDevices {
                given: "All".into(),
            };
            assert_eq!(error, expected, "{line}");
        }
    }

    #[test]
    fn a_scale_of_fifty_is_no_factor() {
        for good in ["50%", "0.5", "2", "250 %"] {
            assert!(parse_scale(good).is_ok(), "{good}");
        }
        for bad in ["50", "0", "-1", "nan", "20000%", "half"] {
            assert!(parse_scale(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn several_devices_are_a_list() {
        let devices = |line: &str| {
            let given: Vec<String> = line.split(';').map(str::to_owned).collect();
            parse_devices(&given)
        };
        let named = |name: &str| DeviceChoice::Name(name.to_owned());
        let found = devices("native, 1,llvmpipe (LLVM 15.0.6, 256 bits)").unwrap();
        let llvmpipe = named("llvmpipe (LLVM 15.0.6, 256 bits)");
        assert_eq!(
            found.named,
            [named("native"), DeviceChoice::Index(1), llvmpipe]
        );
        assert!(!found.all);
        let found = devices("all;native:1,native:1").unwrap();
        assert!(found.all);
        assert_eq!(found.named, vec![DeviceChoice::Native(1); 2]);
        let twice = devices("llvmpipe,llvmpipe").unwrap_err();
        assert!(matches!(twice, UsageError::DeviceTwice { .. }), "{twice}");
        assert_eq!(devices("native,"), Err(UsageError::EmptyDevice));
        let job = render("render a.glb --device native --device 1").unwrap();
        assert_eq!(job.devices.named.len(), 2);
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
}
