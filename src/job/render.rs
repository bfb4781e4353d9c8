//! A validated render.

use std::num::NonZeroU32;
use std::path::PathBuf;
use std::time::Duration;

use engine::adaptive::GRAIN;
use engine::denoise::GUIDES;
use engine::film::write::{Form, TRANSPARENCY};
use engine::film::{Crop, Layers, layers::SHADOW_CATCHER};
use engine::filter::PixelFilter;
use engine::scene::Scene;
use engine::scene::view::ViewChoice;
use engine::settings::{Divided, Estimator, Method, Sampler};
use pictures::seen::FINAL;

use crate::accuracy::{Accuracy, method_flag};
use crate::args::RenderArgs;
use crate::form;
use crate::motion::MotionJob;
use crate::overrides::Overrides;
use crate::progress::Reader;
use crate::usage::UsageError;
use crate::words::{
    Devices, MAX_DEPTH, MAX_SPP, MOST_THREADS, Outputs, parse_crop, parse_decimal, parse_devices,
    parse_display, parse_duration, parse_layers, parse_memory, parse_number, parse_part,
    parse_sample_range, parse_scale, parse_sides, parse_word, refuse_overwriting,
};

/// Samples per pixel where nothing else ends a render.
const DEFAULT_SPP: u32 = 64;
/// Most samples per pixel of a picture that ends where one sees no more noise.
const FINAL_SPP: u32 = 4096;
/// How often a render is kept where nothing else is said.
const CHECKPOINTS: Duration = Duration::from_secs(60);

/// A render, complete.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RenderJob {
    /// The glTF file.
    pub(crate) scene: PathBuf,
    /// The look file.
    pub(crate) look: Option<PathBuf>,
    /// Where the picture and the film go.
    pub(crate) outputs: Outputs,
    /// Samples per pixel.
    pub(crate) spp: NonZeroU32,
    /// What ends it before.
    pub(crate) limits: Limits,
    /// Samples go where they help most; `spp` is their average.
    pub(crate) adaptive: bool,
    /// How it is kept while it is under way.
    pub(crate) checkpoints: Option<Checkpoints>,
    /// The first of them.
    pub(crate) first_sample: u32,
    /// Pixels.
    pub(crate) width: u32,
    /// Pixels.
    pub(crate) height: u32,
    /// Where these lie in a larger picture, of which nothing else is rendered.
    pub(crate) crop: Option<Crop>,
    /// What this is a piece of, where the picture doesn't fit the memory.
    pub(crate) piece_of: Option<Divided>,
    /// Name of the camera.
    pub(crate) camera: Option<String>,
    /// When the scene is seen.
    pub(crate) motion: MotionJob,
    /// Samples of the whole picture, of which this may be a part, as far as that is known.
    pub(crate) whole_spp: u32,
    /// What is to be otherwise than in the look.
    pub(crate) overrides: Overrides,
    /// Most scattering vertices of a path.
    pub(crate) max_depth: u32,
    /// How a pixel weighs the light around its centre.
    pub(crate) filter: PixelFilter,
    /// From edge to edge, pixels.
    pub(crate) filter_width: f32,
    /// Most that one contribution of indirect light adds.
    pub(crate) clamp: Option<f32>,
    /// How light is found.
    pub(crate) estimator: Estimator,
    /// How light that is scattered more than once is found.
    pub(crate) method: Method,
    /// How right the picture has to be, where that was said.
    pub(crate) accuracy: Option<Accuracy>,
    /// Russian roulette: dark paths may end early.
    pub(crate) roulette: bool,
    /// Where random numbers come from.
    pub(crate) sampler: Sampler,
    /// What the film gathers.
    pub(crate) layers: Layers,
    /// What of that files of pictures hold.
    pub(crate) shown_layers: Layers,
    /// Take the noise out of the picture.
    pub(crate) denoise: bool,
    /// Leave out the environment behind everything.
    pub(crate) transparent: bool,
    /// How EXR files are written.
    pub(crate) form: Form,
    /// Rough surfaces keep the energy that single scattering between microfacets loses.
    pub(crate) energy_compensation: bool,
    /// Seed of the random numbers.
    pub(crate) seed: u32,
    /// Devices to render on.
    pub(crate) devices: Devices,
    /// Threads that compute, if not one for each processor.
    pub(crate) threads: Option<u32>,
    /// Most bytes of memory, where that is said.
    pub(crate) memory: Option<u64>,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
    /// How PNG and JPEG show it, as far as the command line says it.
    pub(crate) display: ViewChoice,
    /// Who reads how far it is.
    pub(crate) progress: Reader,
    /// Print statistics.
    pub(crate) stats: bool,
    /// Write statistics.
    pub(crate) stats_json: Option<PathBuf>,
}

/// What ends a render before all samples are taken.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Limits {
    /// Relative error of the picture: [`engine::film::Film::relative_error`].
    pub(crate) noise: Option<f64>,
    /// How much of its noise is seen: [`pictures::seen`].
    pub(crate) flip: Option<f64>,
    /// From the program's start.
    pub(crate) time: Option<Duration>,
}

/// How a render is kept while it is under way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Checkpoints {
    /// The file.
    pub(crate) path: PathBuf,
    /// How often it is written.
    pub(crate) every: Duration,
    /// It is gone on with where it is there.
    pub(crate) resumes: bool,
    /// The pictures are written with it.
    pub(crate) with_pictures: bool,
}

impl RenderJob {
    /// Validates a command line.
    ///
    /// # Errors
    /// The first flag that makes no sense.
    pub(super) fn from_args(args: RenderArgs) -> Result<Self, UsageError> {
        let (width, height) = scaled(&args)?;
        let part = (args.crop.as_deref())
            .map(|part| parse_crop(part, [width, height]))
            .transpose()?;
        let (crop, (width, height)) = match part {
            Some((crop, size)) => (Some(crop), size),
            None => (None, (width, height)),
        };
        let form = form::parse(&args.form)?;
        let outputs = Outputs::from_paths(args.outputs.clone(), Some(&args.scene))?;
        let accuracy = args
            .accuracy
            .as_deref()
            .map(|word| parse_word("--accuracy", word, Accuracy::ALL, Accuracy::name));
        let accuracy = accuracy.transpose()?;
        let method = method(&args, accuracy)?;
        let mut limits = limits(&args)?;
        let ends_by_itself = accuracy == Some(Accuracy::Final)
            && args.spp.is_none()
            && limits.noise.or(limits.flip).is_none();
        if ends_by_itself {
            limits.flip = Some(FINAL);
        }
        let samples = match &args.sample_range {
            Some(range) => parse_sample_range("--sample-range", range)?,
            None => match &args.spp {
                Some(spp) => 0..parse_number("--spp", spp, 1, MAX_SPP)?,
                None if ends_by_itself => 0..FINAL_SPP,
                None if limits == Limits::default() => 0..DEFAULT_SPP,
                None => 0..MAX_SPP,
            },
        };
        // Of what a range is a part, nobody says.
        let whole_spp = match args.sample_range {
            Some(_) => u32::MAX,
            None => samples.end,
        };
        let motion = motion(&args, accuracy, &limits, whole_spp)?;
        let samples = match &args.part {
            Some(part) => parse_part(part, samples.end)?,
            None => samples,
        };
        let checkpoints = checkpoints(&args, &outputs)?;
        let overrides = Overrides::parse(
            &args.set,
            args.environment.as_deref(),
            args.camera_at.as_deref(),
            args.look_at.as_deref(),
        )?;
        let shown_layers = parse_layers(&args.layers, &outputs)?;
        form.check(&shown_layers)
            .map_err(|error| form::refused("--exr-compression", &error))?;
        let coverage = Some("alpha").filter(|_| args.transparent);
        let of_files = shown_layers.with(coverage);
        form::check(
            &args.form,
            &outputs,
            of_files.as_ref().unwrap_or(&shown_layers),
        )?;
        let filter = parse_word(
            "--filter",
            &args.filter,
            PixelFilter::ALL,
            PixelFilter::name,
        )?;
        refuse_overwriting(
            outputs.paths().chain(&args.stats_json),
            [
                Some(&args.scene),
                args.look.as_ref(),
                args.environment.as_ref(),
            ]
            .into_iter()
            .flatten(),
        )?;
        Ok(Self {
            layers: {
                let guides = GUIDES.iter().filter(|_| args.denoise);
                let of_transparency = TRANSPARENCY.iter().chain([&SHADOW_CATCHER]);
                let needed = guides.chain(of_transparency.filter(|_| args.transparent));
                let layers = shown_layers.with(needed.copied());
                layers.expect("the film knows what it needs itself")
            },
            shown_layers,
            denoise: args.denoise,
            transparent: args.transparent,
            outputs,
            spp: NonZeroU32::new(samples.end - samples.start).expect("the range is not empty"),
            first_sample: samples.start,
            limits,
            adaptive: args.adaptive,
            checkpoints,
            width,
            height,
            crop,
            piece_of: None,
            form,
            camera: args.camera,
            motion,
            whole_spp,
            overrides,
            filter,
            filter_width: match &args.filter_width {
                Some(width) => {
                    parse_decimal("--filter-width", width, "of pixels from 0.1 to 16", |w| {
                        (0.1..=16.0).contains(&w)
                    })?
                }
                None => filter.default_width(),
            },
            clamp: (args.clamp.as_deref())
                .map(|most| parse_decimal("--clamp", most, "greater than 0", |x| x > 0.0))
                .transpose()?,
            estimator: parse_word(
                "--estimator",
                &args.estimator,
                Estimator::ALL,
                Estimator::name,
            )?,
            method,
            accuracy,
            roulette: !args.no_roulette,
            sampler: parse_word("--sampler", &args.sampler, Sampler::ALL, Sampler::name)?,
            energy_compensation: !args.no_energy_compensation,
            max_depth: parse_number("--max-depth", &args.common.max_depth, 1, MAX_DEPTH)?,
            seed: parse_number("--seed", &args.common.seed, 0, u32::MAX)?,
            devices: parse_devices(&args.devices)?,
            threads: (args.threads.as_deref())
                .map(|threads| parse_number("--threads", threads, 1, MOST_THREADS))
                .transpose()?,
            memory: args.memory.as_deref().map(parse_memory).transpose()?,
            texture_dirs: args.common.texture_dirs,
            display: parse_display(&args.display)?,
            progress: args.progress,
            stats: args.stats,
            stats_json: args.stats_json,
            scene: args.scene,
            look: args.look,
        })
    }
}

/// What ends the picture.
fn limits(args: &RenderArgs) -> Result<Limits, UsageError> {
    let decimal = |flag, text: &Option<String>, range, is_in: fn(f32) -> bool| {
        let text = text.as_deref();
        let parsed = text.map(|most| parse_decimal(flag, most, range, is_in));
        // As it is written, not as the nearest single.
        let exact = parsed.transpose()?.and(text);
        Ok(exact.and_then(|most| most.parse().ok()))
    };
    let noise = "greater than 0, as 0.02 for 2 %";
    let flip = "greater than 0 and less than 1, as 0.03";
    Ok(Limits {
        noise: decimal("--noise", &args.noise, noise, |x| x > 0.0)?,
        flip: decimal("--flip", &args.flip, flip, |x| x > 0.0 && x < 1.0)?,
        time: (args.time.as_deref())
            .map(|time| parse_duration("--time", time))
            .transpose()?,
    })
}

/// The size of the picture.
fn scaled(args: &RenderArgs) -> Result<(u32, u32), UsageError> {
    let (width, height) = parse_sides(&args.size)?;
    let Some(scale) = &args.scale else {
        return Ok((width, height));
    };
    let factor = parse_scale(scale)?;
    let side = |pixels: u32| (f64::from(pixels) * factor).round().max(1.0);
    // The same limits as for a size that is typed.
    let sides = format!("{}x{}", side(width), side(height));
    parse_sides(&sides).map_err(|_| UsageError::Scale {
        given: scale.clone(),
        sides,
    })
}

/// When the scene is seen, and whether all else can be done so.
fn motion(
    args: &RenderArgs,
    accuracy: Option<Accuracy>,
    limits: &Limits,
    spp: u32,
) -> Result<MotionJob, UsageError> {
    let motion = MotionJob::from_args(&args.motion)?;
    let apart = |flag, other, because| {
        Err(UsageError::Apart {
            flag,
            other,
            because,
        })
    };
    let devices = parse_devices(&args.devices)?;
    let is_several = devices.all || devices.named.len() > 1;
    if motion.is_sequence() {
        let flag = match args.motion.frames {
            Some(_) => "--frames",
            None => "--turntable",
        };
        if is_several {
            return Err(UsageError::OneDevice { flag });
        }
        if args.camera.as_deref() == Some("all") {
            return apart(
                flag,
                "--camera all",
                "render each camera's frames by themselves",
            );
        }
        if args.refresh {
            return apart(
                flag,
                "--refresh",
                "frames are written when they are done; leave it out",
            );
        }
    }
    let Some(shutter) = motion.shutter else {
        return Ok(motion);
    };
    if is_several {
        return Err(UsageError::OneDevice { flag: "--shutter" });
    }
    let is_final = accuracy == Some(Accuracy::Final);
    if is_final && args.spp.is_none() {
        let because = "by itself a picture ends where it is good enough, and would lack the last moments; say how many samples it gets, with --spp";
        return apart(Accuracy::Final.flag(), "--shutter", because);
    }
    if *limits != Limits::default() {
        let because = "a picture that ends early would lack the last moments; say how many samples it gets, with --spp";
        return apart("--shutter", "--noise, --flip or --time", because);
    }
    if args.adaptive {
        let because = "each moment has its share of a pixel's samples";
        return apart("--shutter", "--adaptive", because);
    }
    if args.sample_range.is_some() {
        let because = "what a moment's samples are follows from those of the whole; write --part I/N with --spp";
        return apart("--shutter", "--sample-range", because);
    }
    let moments = shutter.moments;
    let even = match is_final {
        true => moments.saturating_mul(GRAIN),
        false => moments,
    };
    let near = spp.checked_next_multiple_of(even);
    let remedy = match near.filter(|&near| near <= MAX_SPP) {
        Some(near) => format!("write --spp {near}, or another number of --motion-samples"),
        None => "write another number of --motion-samples".to_owned(),
    };
    match (spp.is_multiple_of(even), is_final) {
        (true, _) => Ok(motion),
        (false, false) => Err(UsageError::Moments {
            spp,
            moments,
            remedy,
        }),
        (false, true) => Err(UsageError::JudgedMoments {
            spp,
            moments,
            remedy,
        }),
    }
}

/// How a render is to be kept while it is under way.
fn method(args: &RenderArgs, accuracy: Option<Accuracy>) -> Result<Method, UsageError> {
    let method = match accuracy {
        Some(accuracy) => accuracy.method(),
        None => parse_word("--method", &args.method, Method::ALL, Method::name)?,
    };
    // What photons bring follows from the number of a sample alone, and caches are made anew, as they were, wherever a picture goes on.
    let may_begin_again = accuracy == Some(Accuracy::Final);
    let by_parts = may_begin_again.then_some(
        "such a picture may be rendered again as a whole, with finer records; --method cache isn't",
    );
    let by_blocks = (method.has_photons()).then_some(
        "photons are sent out for one sample of all pixels, and would take as long for some of them",
    );
    let by_bsdf = (method.has_photons()).then_some(
        "without it, what a surface scatters diffusely depends on where light comes from, which photons don't tell",
    );
    let refused = [
        (
            "--no-energy-compensation",
            args.no_energy_compensation,
            by_bsdf,
        ),
        ("--part", args.part.is_some(), by_parts),
        ("--sample-range", args.sample_range.is_some(), by_parts),
        ("--adaptive", args.adaptive, by_blocks),
    ];
    let first = refused
        .into_iter()
        .find_map(|(other, is_asked_for, because)| {
            let because = because.filter(|_| is_asked_for)?;
            Some((other, because))
        });
    match first {
        Some((other, because)) if method != Method::Path => Err(UsageError::Apart {
            flag: accuracy.map_or(method_flag(method), Accuracy::flag),
            other,
            because,
        }),
        _ => Ok(method),
    }
}

fn checkpoints(args: &RenderArgs, outputs: &Outputs) -> Result<Option<Checkpoints>, UsageError> {
    let every = match &args.checkpoint {
        Some(time) => parse_duration("--checkpoint", time)?,
        None if args.resume || args.refresh => CHECKPOINTS,
        None => return Ok(None),
    };
    Ok(Some(Checkpoints {
        path: outputs.checkpoint(),
        every,
        resumes: args.resume,
        with_pictures: args.refresh,
    }))
}

impl RenderJob {
    /// The same for a scene that is known: without groups of lights that it hasn't.
    pub(crate) fn for_scene(&self, scene: &Scene) -> Self {
        Self {
            layers: self.layers.of_scene(scene),
            shown_layers: self.shown_layers.of_scene(scene),
            ..self.clone()
        }
    }
}
