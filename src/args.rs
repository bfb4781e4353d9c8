//! The command line as the user typed it: names, help texts and defaults of flags, nothing else.
//!
//! Whether the values make sense together, and what they mean, is [`crate::job`]'s business.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{ArgAction, Parser, Subcommand};
use engine::filter::PixelFilter;
use engine::settings::{Estimator, Method, Sampler};

use crate::accuracy::Accuracy;
use crate::bake::args::BakeArgs;
use crate::bench::args::BenchCommand;
use crate::compare::args::CompareArgs;
use crate::console::MessageFormat;
use crate::export::args::ExportArgs;
use crate::farm::args::FarmCommand;
use crate::flags::{CommonArgs, DisplayArgs, LayerWords, scene_help, words};
use crate::form::FormArgs;
use crate::import::args::ImportArgs;
use crate::info::args::InfoArgs;
use crate::progress::Reader;
use crate::texture::args::TextureCommand;
use crate::view::args::ViewArgs;
use crate::watch::args::WatchArgs;

const EXAMPLES: &str = "\
Examples:
  patina render scene.glb                            writes scene-render.png
  patina render scene.glb -o a.png -o a.exr          a picture to look at and one to work with
  patina render scene.glb --look rust.look.toml      with procedural textures
  patina view scene.glb                              in a window, to be walked through and edited
  patina info scene.glb                              what is in it
  patina compare a.png b.png                         how far they are apart
  patina texture list                                which textures there are
  patina devices                                     which devices there are

`patina render --help` shows all options and more examples.

Exit codes: 0 done, 1 failed, 2 wrong usage, 130 ended by Ctrl-C (143 by SIGTERM, 129 by SIGHUP).";

const RENDER_EXAMPLES: &str = "\
Examples:
  A quick look at a scene, written to helmet-render.png:
    patina render helmet.glb --spp 16 --size 640x360
  With procedural textures, as a PNG one stop brighter and as linear floats:
    patina render helmet.glb --look rust.look.toml --exposure 1 -o helmet.png -o helmet.exr
  Another value of a look, another sky, without editing files:
    patina render helmet.glb --set material.Steel.roughness=0.2
    patina render helmet.glb --look rust.look.toml --environment dusk.hdr
  As AgX shows it, with light of 3200 K as white:
    patina render room.glb --view agx --white-balance 3200 -o room.png
  Through a camera of the scene, direct light only, on the second device:
    patina render room.gltf --camera Door --max-depth 1 --device 1
  On all GPUs and the processor together, and on two devices by name:
    patina render room.gltf --device all
    patina render room.gltf --device native,llvmpipe
  The picture with depth and normals, in one EXR for compositing:
    patina render room.glb --layers depth,normal -o room.exr
  A part of it, which its EXR puts in its place in the whole:
    patina render room.glb --crop 400,200,320,180 -o door.exr
  As good as 2 % of noise allow, but in ten minutes at most:
    patina render room.glb --noise 0.02 --time 10m -o room.exr
  For hours, with what is done kept each minute; after a crash the same line goes on:
    patina render room.glb --spp 4096 --checkpoint --resume -o room.exr
  A few samples without their noise; needs Open Image Denoise (`pip install pyoidn`, or OIDN_DIR=FOLDER):
    patina render room.glb --spp 32 --denoise -o room.png
  The second second of an animation with motion blur, as walk.0024.png and so on:
    patina render walk.glb --frames 24..48 --shutter 0.5 -o walk.png
  Once around a model:
    patina render helmet.glb --turntable 60 -o turn/####.png
  Where the time goes, for people and for programs:
    patina render room.gltf --stats --stats-json room.json

Ctrl-C, SIGTERM and SIGHUP end the render early, and what has been rendered is written; a second one aborts. So does a soft limit of \
processor time (SIGXCPU, `ulimit -S -t 3600`): between it and the hard one there have to be seconds. Where a result can't be written, the \
samples are kept and it is said where.

Compiled pipelines are kept in the system's folder for caches; PATINA_CACHE=DIR names another, PATINA_CACHE=off none.

Exit codes: 0 done, 1 failed, 2 wrong usage, 130 ended by Ctrl-C (143 by SIGTERM, 129 by SIGHUP, 152 by SIGXCPU).";

const MERGE_EXAMPLES: &str = "\
Examples:
  Two machines render half of the samples each; merged, they are exactly the whole:
    patina render room.glb --sample-range 0..128 -o a.patina-film
    patina render room.glb --sample-range 128..256 -o b.patina-film
    patina merge a.patina-film b.patina-film -o room.exr -o room.png
  More samples later:
    patina render room.glb --sample-range 256..512 -o c.patina-film
    patina merge [abc].patina-film -o all.patina-film -o room.exr

Partial renders may have gaps between them, but no sample in common. They must be of the same scene, look, size, camera \
and settings; a device of another kind gives other last bits.

Exit codes: 0 done, 1 failed, 2 wrong usage, 130 ended by Ctrl-C (143 by SIGTERM, 129 by SIGHUP).";

/// A path tracer extended with procedural textures in plain WGSL.
#[derive(Debug, Parser)]
#[command(name = "patina", version, after_help = EXAMPLES, arg_required_else_help = true)]
pub(crate) struct Args {
    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Command,

    /// How errors and warnings are written: as text, or as JSON for editors, one object per line.
    #[arg(long, global = true, value_name = "FORMAT", default_value = "text")]
    pub(crate) message_format: MessageFormat,

    /// Print neither progress nor which files were written: only errors, warnings and what was asked for.
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a glTF scene to PNG and EXR.
    #[command(after_help = RENDER_EXAMPLES)]
    Render(Box<RenderArgs>),
    /// Render a scene again and again while its files are edited.
    #[command(after_help = crate::watch::args::EXAMPLES)]
    Watch(Box<WatchArgs>),
    /// Open a window: look at a scene, walk through it, edit its look.
    #[command(after_help = crate::view::args::EXAMPLES)]
    View(Box<ViewArgs>),
    /// Merge partial renders, as `render --sample-range` writes them, into one picture.
    #[command(after_help = MERGE_EXAMPLES)]
    Merge(MergeArgs),
    /// Render on many machines, by a scheduler that exists.
    Farm {
        /// What to do.
        #[command(subcommand)]
        what: FarmCommand,
    },
    /// Say how far a picture is from another one: MSE, relative MSE, PSNR, FLIP.
    #[command(after_help = crate::compare::args::EXAMPLES)]
    Compare(CompareArgs),
    /// Say what a scene, a look, a partial render or a picture holds.
    #[command(after_help = crate::info::args::EXAMPLES)]
    Info(InfoArgs),
    /// Turn a MaterialX document into a look.
    #[command(after_help = crate::import::args::EXAMPLES)]
    Import(ImportArgs),
    /// Write a material, or what a node gives, as pictures over a mesh's texture coordinates.
    #[command(after_help = crate::bake::args::EXAMPLES)]
    Bake(BakeArgs),
    /// Write a scene as glTF, with pictures in place of procedural textures.
    #[command(after_help = crate::export::args::EXAMPLES)]
    Export(ExportArgs),
    /// List, check, inspect, evaluate, preview and begin textures.
    Texture {
        /// What to do with them.
        #[command(subcommand)]
        what: TextureCommand,
    },
    /// List the devices a scene can be rendered on, with their limits.
    Devices,
    /// Builds one texture alone and runs it once: what `render` starts to find a texture that ends the program.
    #[command(hide = true)]
    ProbeTexture {
        /// The texture.
        file: PathBuf,

        /// Device by number or by part of its name, as `patina devices` lists them.
        #[arg(long, value_name = "NAME|N")]
        device: Option<String>,
    },
    /// Writes the manual's pages and completions for shells into a folder: for those who pack the program.
    #[command(hide = true)]
    Manuals {
        /// The folder; it is made where there is none.
        dir: PathBuf,
    },
    /// Measure parts of the renderer on this machine.
    Bench {
        /// What to measure.
        #[command(subcommand)]
        what: BenchCommand,
    },
}

/// Flags of `patina render`.
#[derive(Debug, clap::Args)]
pub(crate) struct RenderArgs {
    #[arg(help = scene_help())]
    pub(crate) scene: PathBuf,

    /// The look: a TOML file with procedural textures, environment and overrides.
    #[arg(long, value_name = "FILE")]
    pub(crate) look: Option<PathBuf>,

    /// Where to write: .png or .jpg (8-bit sRGB), .exr (linear float) or .patina-film (exact sums for `patina merge`).
    /// May be given several times.
    ///
    /// Without it the picture goes to SCENE-render.png in the current directory.
    #[arg(short, long = "output", value_name = "FILE", action = ArgAction::Append)]
    pub(crate) outputs: Vec<PathBuf>,

    /// Samples (camera paths) per pixel: 64, or with --noise, --flip, --time or --accuracy final as many as these want.
    #[arg(long, value_name = "N")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) spp: Option<String>,

    /// End as soon as the picture's relative error, as its samples tell it, is at most X: 0.02 is 2 % of the mean brightness.
    #[arg(long, value_name = "X")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) noise: Option<String>,

    /// End as soon as less than X of the picture's noise is seen, as its samples tell it: mean FLIP, 0 to 1, and no spot of five times as
    /// much. Of 0.03 little is seen.
    #[arg(long, value_name = "X")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) flip: Option<String>,

    /// End when so much time is over since the start, as in 90s, 10m or 1h30m; a number alone is seconds.
    #[arg(long, value_name = "TIME")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) time: Option<String>,

    /// Keep the samples in NAME.patina-film, by the name of the first output, each minute or after each TIME; a number alone is seconds.
    #[arg(long, value_name = "TIME", num_args = 0..=1, require_equals = true, default_missing_value = "1m")]
    pub(crate) checkpoint: Option<String>,

    /// Go on with the checkpoint that an earlier run has left, and keep further ones, each minute without --checkpoint. Where there is
    /// none, begin.
    #[arg(long)]
    pub(crate) resume: bool,

    /// Write the pictures with each checkpoint, too; without --checkpoint one is kept each minute.
    #[arg(long)]
    pub(crate) refresh: bool,

    /// Partial render: only the samples from A up to, but not including, B of each pixel, to be put together by `patina merge`.
    #[arg(long, value_name = "A..B", conflicts_with = "spp")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) sample_range: Option<String>,

    /// Partial render: part I of N of the samples, the parts numbered from 1.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["sample_range", "noise", "flip"])]
    pub(crate) part: Option<String>,

    /// Samples go where the picture is noisiest, or with --flip where noise is seen: --spp is then their number on average over the
    /// picture. The error that --noise compares with is known better, so that such a render ends sooner.
    #[arg(long, conflicts_with_all = ["sample_range", "part"])]
    pub(crate) adaptive: bool,

    /// Width and height of the picture in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) size: String,

    /// Width and height are so much of --size, as in 50%.
    #[arg(long, value_name = "PERCENT")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) scale: Option<String>,

    /// Only this part of the picture: first column and row, width and height, in pixels of the whole. EXR files say where it lies.
    #[arg(long, value_name = "X,Y,W,H")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) crop: Option<String>,

    /// Camera of the scene by name or number; without it the first one, or a view of everything where there is none. `all` renders a
    /// picture through each, into files named after them.
    #[arg(long, value_name = "NAME|N|all")]
    pub(crate) camera: Option<String>,

    /// The camera stands here, in metres: in place of what look and scene say.
    #[arg(long, value_name = "X,Y,Z", conflicts_with = "camera")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) camera_at: Option<String>,

    /// It looks at this point.
    #[arg(long, value_name = "X,Y,Z", conflicts_with = "camera")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) look_at: Option<String>,

    /// In place of the look's environment, a picture of all directions (.hdr or .exr; any other is read as sRGB, without light above 1).
    #[arg(long, value_name = "FILE")]
    pub(crate) environment: Option<PathBuf>,

    /// In place of what the look says: NODE.PARAMETER=VALUE, material.NAME.KEY=VALUE (so with light and ao), environment.KEY=VALUE,
    /// camera.KEY=VALUE, view.KEY=VALUE; the value as in a look. May be given several times.
    #[arg(long, value_name = "KEY=VALUE", action = ArgAction::Append)]
    pub(crate) set: Vec<String>,

    /// When the scene is seen.
    #[command(flatten)]
    pub(crate) motion: MotionArgs,

    /// How a pixel weighs the light around its centre. mitchell sharpens by weights that are negative, too: what is of one colour
    /// everywhere is even, and what is solid opaque, with 256 samples or more.
    #[arg(long, value_name = "NAME", default_value = "box")]
    #[arg(value_parser = words(PixelFilter::ALL.map(PixelFilter::name)))]
    pub(crate) filter: String,

    /// Width of the filter from edge to edge; 1 for the box, 3 for gaussian and blackman-harris, 4 for mitchell.
    #[arg(long, value_name = "PIXELS")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) filter_width: Option<String>,

    /// Clamp indirect light: no contribution that was scattered twice or more exceeds X. Takes away fireflies, and light with
    /// them: the picture is biased. Off by default.
    #[arg(long, visible_alias = "clamp-indirect", value_name = "X")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) clamp: Option<String>,

    /// How light that is scattered more than once is found: path, which is right on average; draft, by a cache of what surfaces scatter;
    /// cache, by records of irradiance between which it is interpolated; photons, by photons from the lamps for what glass and mirrors
    /// throw on other surfaces; cache+photons, by both. All but the first are biased, and faster where they fit.
    #[arg(long, value_name = "NAME", default_value = "path")]
    #[arg(value_parser = words(Method::ALL.map(Method::name)))]
    pub(crate) method: String,

    /// How right a picture has to be: reference (as --method path), final (as --method cache, rendered again with finer records where the
    /// audit finds more wrong than one sees; without --spp, --noise or --flip until --flip 0.03, of 4096 samples at most) or draft (as
    /// --method draft).
    #[arg(long, value_name = "NAME", conflicts_with = "method")]
    #[arg(value_parser = words(Accuracy::ALL.map(Accuracy::name)))]
    pub(crate) accuracy: Option<String>,

    /// How direct light is sampled: mis (multiple importance sampling of lights and BSDFs), bsdf or lights (one of both alone).
    /// The picture is the same but for its noise.
    #[arg(long, value_name = "NAME", default_value = "mis")]
    #[arg(value_parser = words(Estimator::ALL.map(Estimator::name)))]
    pub(crate) estimator: String,

    /// Trace all paths to their full depth, without Russian roulette. The picture is the same but for its noise.
    #[arg(long)]
    pub(crate) no_roulette: bool,

    /// The sampler: sobol (Owen-scrambled Sobol points) or independent (independent random numbers, to compare with).
    #[arg(long, value_name = "NAME", default_value = "sobol")]
    #[arg(value_parser = words(Sampler::ALL.map(Sampler::name)))]
    pub(crate) sampler: String,

    /// What EXR and .patina-film files hold beside the picture, with commas between; node:NAME is the value of a node of the look.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', action = ArgAction::Append)]
    #[arg(value_parser = LayerWords::new())]
    pub(crate) layers: Vec<String>,

    /// Take the noise out of the picture, by Open Image Denoise, where that is found. EXR files keep the noisy picture as the layer
    /// "Noisy Image", and their other layers as they are; .patina-film files keep their sums, and what `merge --denoise` needs.
    #[arg(long)]
    pub(crate) denoise: bool,

    /// Leave out the environment behind everything: PNG and EXR files get an alpha. What lights the scene stays as it is.
    #[arg(long)]
    pub(crate) transparent: bool,

    /// How EXR files are written.
    #[command(flatten)]
    pub(crate) form: FormArgs,

    /// Leave out what rough surfaces scatter more than once between their microfacets, as glTF's own formula does.
    #[arg(long)]
    pub(crate) no_energy_compensation: bool,

    /// What all renders can choose.
    #[command(flatten)]
    pub(crate) common: CommonArgs,

    /// Devices by number or by part of their names, as `patina devices` lists them; `native:N` is the processor with N threads of
    /// its own. Several, with commas between, render one picture together; `all` is every device that this gains from.
    #[arg(long = "device", value_name = "NAME|N|all", action = ArgAction::Append)]
    pub(crate) devices: Vec<String>,

    /// Threads of the device `native` and of all else that the program computes by itself; without it one for each processor.
    #[arg(long, value_name = "N")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) threads: Option<String>,

    /// Most memory that the render may take, of the machine and of each device, as in 8G or 500M: a picture that needs more is rendered
    /// in pieces, one after the other, or refused before it begins where it can't be. Without it what the system has left.
    #[arg(long, value_name = "SIZE")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) memory: Option<String>,

    /// How the picture is shown.
    #[command(flatten)]
    pub(crate) display: DisplayArgs,

    /// Who reads how far the render is.
    #[arg(long, value_name = "READER", default_value = "people")]
    pub(crate) progress: Reader,

    /// Print where the time and the memory went.
    #[arg(long)]
    pub(crate) stats: bool,

    /// Write the same figures as JSON.
    #[arg(long, value_name = "FILE")]
    pub(crate) stats_json: Option<PathBuf>,
}

/// Flags of `patina render` for scenes that move.
#[derive(Debug, clap::Args)]
pub(crate) struct MotionArgs {
    /// The scene as its animations have it after so many seconds. Without this, --frames, --animation or --shutter it is at rest.
    #[arg(long, value_name = "SECONDS")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) at: Option<String>,

    /// A picture for each frame from A up to, but not including, B, or each STEPth of them. Frame N is seen after N / FPS seconds. Names
    /// of files get the number before their ending, or where they have ####. With --resume, frames whose pictures are there are left
    /// out.
    #[arg(long, value_name = "A..B[:STEP]", conflicts_with_all = ["at", "turntable"])]
    #[arg(allow_hyphen_values = true)]
    pub(crate) frames: Option<String>,

    /// Of all frames only part I of N, the parts numbered from 1: for many machines, each with frames of its own.
    #[arg(long, value_name = "I/N")]
    pub(crate) frame_part: Option<String>,

    /// Frames of a second: 24 where nothing is said.
    #[arg(long, value_name = "FPS")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) fps: Option<String>,

    /// Which of the scene's animations moves it, by name or number as `patina info` lists them. Without it all do, or the first where
    /// several move the same.
    #[arg(long, value_name = "NAME|N")]
    pub(crate) animation: Option<String>,

    /// N pictures, numbered from 0, between which the camera goes once around the middle of the scene, counter-clockwise as seen from
    /// above.
    #[arg(long, value_name = "N")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) turntable: Option<String>,

    /// Motion blur: the shutter is open for so much of a frame's time, half of it before the frame's own moment and half after. 0.5 is
    /// what film calls 180 degrees; 0 is off.
    #[arg(long, value_name = "SHARE")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) shutter: Option<String>,

    /// At how many moments the scene is seen while the shutter is open: 8 where nothing is said. They share the samples evenly.
    #[arg(long, value_name = "N", requires = "shutter")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) motion_samples: Option<String>,
}

/// Flags of `patina merge`.
#[derive(Debug, clap::Args)]
pub(crate) struct MergeArgs {
    /// Partial renders (.patina-film), in any order.
    #[arg(required = true, value_name = "FILM")]
    pub(crate) parts: Vec<PathBuf>,

    /// Refuse to write anything unless the parts have exactly the samples from A up to, but not including, B.
    #[arg(long, value_name = "A..B")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) expect: Option<String>,

    /// Where to write: .png or .jpg (8-bit sRGB), .exr (linear float) or .patina-film (to be merged again). May be given
    /// several times.
    #[arg(short, long = "output", value_name = "FILE", action = ArgAction::Append, required = true)]
    pub(crate) outputs: Vec<PathBuf>,

    /// Take the noise out of the picture, by Open Image Denoise, where that is found. Parts that were rendered with --denoise, or
    /// with the layers albedo and normal, keep textures and edges sharp.
    #[arg(long)]
    pub(crate) denoise: bool,

    /// Leave out the environment behind everything. The parts must have been rendered with --transparent.
    #[arg(long)]
    pub(crate) transparent: bool,

    /// How EXR files are written.
    #[command(flatten)]
    pub(crate) form: FormArgs,

    /// The look whose table view says how the picture is shown.
    #[arg(long, value_name = "FILE")]
    pub(crate) look: Option<PathBuf>,

    /// How the picture is shown.
    #[command(flatten)]
    pub(crate) display: DisplayArgs,
}

/// The message format asked for by a command line that can't be understood otherwise.
pub(crate) fn message_format(words: impl Iterator<Item = OsString>) -> MessageFormat {
    let words: Vec<OsString> = words.collect();
    let pair = |pair: &[OsString]| pair[0] == "--message-format" && pair[1] == "json";
    if words.windows(2).any(pair) || words.iter().any(|word| word == "--message-format=json") {
        MessageFormat::Json
    } else {
        MessageFormat::Text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_declaration_is_consistent() {
        Args::command().debug_assert();
    }

    /// The help of a command and of those below it.
    fn helps(command: &mut clap::Command, found: &mut Vec<String>) {
        found.push(command.render_long_help().to_string());
        for below in command.get_subcommands_mut() {
            helps(below, found);
        }
    }

    #[test]
    fn help_fits_a_narrow_terminal_and_is_wrapped_once() {
        let mut command = Args::command().term_width(80);
        command.build();
        let mut found = Vec::new();
        helps(&mut command, &mut found);
        assert!(found.len() > 10);
        for help in found {
            let lines: Vec<&str> = help.lines().collect();
            for (line, next) in lines.iter().zip(&lines[1..]) {
                assert!(line.chars().count() <= 80, "{line}\n{help}");
                // A line that was broken early though the next word had fitted: broken by hand, then again by clap.
                let word = next.split(' ').next().unwrap_or_default();
                let is_prose =
                    line.starts_with(|c: char| c.is_alphabetic()) && !line.ends_with([':', '.']);
                assert!(
                    !is_prose || word.is_empty() || line.len() + word.len() >= 80,
                    "wrapped twice:\n{line}\n{next}"
                );
            }
        }
    }

    #[test]
    fn flags_with_a_list_of_words_show_it() {
        let help = |line: &str| {
            let words = ["patina"].into_iter().chain(line.split(' '));
            let answer = Args::try_parse_from(words).expect_err("help is an answer");
            answer.to_string()
        };
        for (line, words) in [
            ("render --help", "box, gaussian, blackman-harris, mitchell"),
            ("render --help", "mis, bsdf, lights"),
            ("render --help", "sobol, independent"),
            ("bench textures --help", "stack, inlined, rayquery"),
            (
                "bench textures --help",
                "nodes, textures, ao, coverage, bounces, all",
            ),
            ("render a.glb --filter cone", "box, gaussian"),
        ] {
            let text = help(line).replace('\n', " ");
            let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(text.contains(words), "{line}: {words}:\n{text}");
        }
    }
}
