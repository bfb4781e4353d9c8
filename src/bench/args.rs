//! The command line of `patina bench` as the user typed it. What it means is [`super::job`]'s business.

use std::path::PathBuf;

use clap::{ArgAction, Args, Subcommand};
use patina_bench::forms::Form;
use patina_bench::methods::How;
use patina_bench::sweeps::Sweep;

use crate::flags::words;

/// All sweeps.
pub(super) const ALL: &str = "all";

const RENDER_EXAMPLES: &str = "\
Examples:
  patina bench render                                the built-in scenes
  patina bench render a.glb b.glb --runs 5           two scenes in turn, five times each
  patina bench render a.glb --look a.look.toml --json a.json";

const SCALING_EXAMPLES: &str = "\
Examples:
  patina bench scaling                               the built-in Cornell box, ten minutes at most
  patina bench scaling --sizes 256,512 --tiles 32,128,512 --minutes 2
  patina bench scaling --device native,llvmpipe -o scaling.html -o scaling.json
  patina bench scaling Sponza.gltf --threads 1,2,4,8 --spp 16

What the tables say: docs/devices.md.";

const METHODS_EXAMPLES: &str = "\
Examples:
  patina bench methods                               the built-in Cornell box
  patina bench methods room.glb --size 320x180 --minutes 20 -o methods.html
  patina bench methods room.glb --reference converged.exr --methods path,cache

What the table says: docs/light-caches.md.";

const TEXTURES_EXAMPLES: &str = "\
Examples:
  patina bench textures                              the built-in scene, a table
  patina bench textures -o report.html -o report.json
  patina bench textures --sweep nodes,ao -o report.html
  patina bench textures --size 96x96 --runs 1        a quick look
  patina bench textures --scene Sponza.gltf --insert car.glb -o report.html
  patina bench textures --scene room.glb --material Paint

What the columns mean, and how figures are to be compared: docs/benchmarks.md.";

/// What `patina bench` measures.
#[derive(Debug, Subcommand)]
pub(crate) enum BenchCommand {
    /// The texture kernel: seconds to build it for 1 to 100 textures, and what a hit costs beside unused ones.
    ///
    /// A hundred textures are a large kernel: software drivers take many minutes to compile it.
    Kernel {
        /// No kernel holds more textures than this, besides the three whose hits are measured.
        #[arg(
            long,
            value_name = "N",
            default_value = "100",
            allow_hyphen_values = true
        )]
        most: String,

        /// Folder with textures (.wgsl), searched before all others. May be given several times.
        #[arg(long = "textures", value_name = "DIR", action = ArgAction::Append)]
        texture_dirs: Vec<PathBuf>,

        /// Device by number or by part of its name, as `patina devices` lists them.
        #[arg(long, value_name = "NAME|N")]
        device: Option<String>,
    },
    /// Live edits of a look with many nodes: milliseconds from the call to the command submitted, and to a picture.
    Edit {
        /// Nodes of the look.
        #[arg(
            long,
            value_name = "N",
            default_value = "1000",
            allow_hyphen_values = true
        )]
        nodes: String,

        /// Edits of each kind.
        #[arg(
            long,
            value_name = "N",
            default_value = "1000",
            allow_hyphen_values = true
        )]
        edits: String,

        /// Device by number or by part of its name, as `patina devices` lists them.
        #[arg(long, value_name = "NAME|N")]
        device: Option<String>,
    },
    /// Finding photons: the renderer's octree of references against its grid of sorted photons and a kd-tree, milliseconds to build and to ask.
    Gather {
        /// Photons, and places that ask for them; rounded up to a power of two.
        #[arg(
            long,
            value_name = "N",
            default_value = "262144",
            allow_hyphen_values = true
        )]
        photons: String,

        /// Timed runs, in turn.
        #[arg(
            long,
            value_name = "N",
            default_value = "5",
            allow_hyphen_values = true
        )]
        runs: String,

        /// Device by number or by part of its name, as `patina devices` lists them.
        #[arg(long, value_name = "NAME|N")]
        device: Option<String>,
    },
    /// How long ways to find light take until the picture is as good as a converged one to the eye: paths, adaptive sampling,
    /// caches of light, photons.
    #[command(after_help = METHODS_EXAMPLES)]
    Methods(Box<MethodsArgs>),
    /// Whole renders: samples and rays per second, time of each pass, for several scenes in turn.
    #[command(after_help = RENDER_EXAMPLES)]
    Render(RenderArgs),
    /// How rendering scales: with threads of the processor, with the size of the pieces of a picture (ranges and tiles of 32x32 to
    /// 2048x2048 pixels), and with devices that render together.
    #[command(after_help = SCALING_EXAMPLES)]
    Scaling(Box<ScalingArgs>),
    /// What procedural textures cost: time over plain grey of rust and of scratches, for each form of the texture kernel.
    #[command(after_help = TEXTURES_EXAMPLES)]
    Textures(Box<TexturesArgs>),
    /// Rays per second of the traversal kernel: primary, bounce and shadow rays.
    Traverse {
        /// The scene to shoot rays into; without it a built-in one of 262,144 triangles.
        scene: Option<PathBuf>,

        /// Device by number or by part of its name, as `patina devices` lists them.
        #[arg(long, value_name = "NAME|N")]
        device: Option<String>,
    },
}

/// Flags of `patina bench textures`.
#[derive(Debug, Args)]
pub(crate) struct TexturesArgs {
    /// A glTF file in place of the built-in arcade.
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: Option<PathBuf>,

    /// A look for it: camera, light, models. Its own textures are left out.
    #[arg(long, value_name = "FILE", requires = "scene")]
    pub(crate) look: Option<PathBuf>,

    /// The material of that scene that is grey, rusty and scratched in turn.
    #[arg(long, value_name = "NAME", requires = "scene")]
    pub(crate) material: Option<String>,

    /// Or a glTF file whose model is put on the floor in front of the camera, and is grey, rusty and scratched all over.
    #[arg(
        long,
        value_name = "FILE",
        requires = "scene",
        conflicts_with = "material"
    )]
    pub(crate) insert: Option<PathBuf>,

    /// What is compared, with commas between. All by default; on a software driver, which needs minutes to compile a kernel
    /// of the last one, the first two.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    #[arg(value_parser = words(Form::ALL.map(Form::name)))]
    pub(crate) modes: Vec<String>,

    /// Rays of ambient occlusion at a hit: one table for each number.
    #[arg(
        long,
        value_name = "LIST",
        default_value = "4,16",
        allow_hyphen_values = true
    )]
    pub(crate) ao_rays: String,

    /// Ask the driver of another Vulkan device, by a part of its name, for registers and stack of the kernels.
    #[arg(long, value_name = "NAME")]
    pub(crate) statistics_device: Option<String>,

    /// Measure also what changes the cost, with commas between. Takes minutes each.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    #[arg(value_parser = words(Sweep::ALL.map(Sweep::name).into_iter().chain([ALL])))]
    pub(crate) sweep: Vec<String>,

    /// Report to write: .html (a page to read), .json (figures for programs) or .svg (the chart). May be given several
    /// times.
    #[arg(short, long = "output", value_name = "FILE", action = ArgAction::Append)]
    pub(crate) outputs: Vec<PathBuf>,

    /// How it is measured.
    #[command(flatten)]
    pub(crate) effort: EffortArgs,
}

/// Flags of `patina bench scaling`.
#[derive(Debug, Args)]
pub(crate) struct ScalingArgs {
    /// A glTF file; without it the built-in Cornell box.
    pub(crate) scene: Option<PathBuf>,

    /// A look for it.
    #[arg(long, value_name = "FILE", requires = "scene")]
    pub(crate) look: Option<PathBuf>,

    /// Columns of pixels of the pictures, which have as many rows, with commas between.
    #[arg(long, value_name = "LIST", default_value = "256,512,1024,2048")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) sizes: String,

    /// Sides of the pieces, multiples of 8 pixels, with commas between; no piece is larger than the picture.
    #[arg(
        long,
        value_name = "LIST",
        default_value = "32,64,128,256,512,1024,2048"
    )]
    #[arg(allow_hyphen_values = true)]
    pub(crate) tiles: String,

    /// Numbers of threads, with commas between; without it 1, 2, 4 and so on up to one for each processor.
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub(crate) threads: Option<String>,

    /// Devices that render one picture together, as `patina render` takes them; without it, as many of the processor's with one
    /// thread each as there are processors.
    #[arg(long = "device", value_name = "NAME|N|all", action = ArgAction::Append)]
    pub(crate) devices: Vec<String>,

    /// Samples (camera paths) per pixel of each run.
    #[arg(
        long,
        value_name = "N",
        default_value = "4",
        allow_hyphen_values = true
    )]
    pub(crate) spp: String,

    /// Timed runs of each case, in turn. One more comes first and isn't counted.
    #[arg(
        long,
        value_name = "N",
        default_value = "2",
        allow_hyphen_values = true
    )]
    pub(crate) runs: String,

    /// Largest path depth: at most N surface points scatter light along a path.
    #[arg(
        long,
        value_name = "N",
        default_value = "9",
        allow_hyphen_values = true
    )]
    pub(crate) max_depth: String,

    /// What would take longer than this altogether is left out, and named.
    #[arg(
        long,
        value_name = "N",
        default_value = "10",
        allow_hyphen_values = true
    )]
    pub(crate) minutes: String,

    /// Report to write: .html (a page to read), .json (figures for programs) or .svg (the charts). May be given several
    /// times.
    #[arg(short, long = "output", value_name = "FILE", action = ArgAction::Append)]
    pub(crate) outputs: Vec<PathBuf>,

    /// Folder with textures (.wgsl), searched before all others. May be given several times.
    #[arg(long = "textures", value_name = "DIR", action = ArgAction::Append)]
    pub(crate) texture_dirs: Vec<PathBuf>,
}

/// Flags of `patina bench methods`.
#[derive(Debug, Args)]
pub(crate) struct MethodsArgs {
    /// A glTF file; without it the built-in Cornell box.
    pub(crate) scene: Option<PathBuf>,

    /// A look for it.
    #[arg(long, value_name = "FILE", requires = "scene")]
    pub(crate) look: Option<PathBuf>,

    /// What is compared, with commas between; all by default.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    #[arg(value_parser = words(How::ALL.map(How::name)))]
    pub(crate) methods: Vec<String>,

    /// A converged picture to compare with, of linear light: .exr, .hdr or .patina-film. Without it one is rendered by paths.
    #[arg(long, value_name = "FILE")]
    pub(crate) reference: Option<PathBuf>,

    /// Samples per pixel of the one that is rendered.
    #[arg(
        long,
        value_name = "N",
        default_value = "4096",
        allow_hyphen_values = true
    )]
    pub(crate) reference_spp: String,

    /// Brightness by which pictures are compared in stops: +1 is twice as bright.
    #[arg(long, value_name = "STOPS", default_value = "0")]
    #[arg(allow_hyphen_values = true)]
    pub(crate) exposure: String,

    /// No picture begins that would be done later than this, after the reference.
    #[arg(
        long,
        value_name = "N",
        default_value = "20",
        allow_hyphen_values = true
    )]
    pub(crate) minutes: String,

    /// Report to write: .html (a page with the pictures), .json (figures for programs) or .svg (the chart). May be given several
    /// times.
    #[arg(short, long = "output", value_name = "FILE", action = ArgAction::Append)]
    pub(crate) outputs: Vec<PathBuf>,

    /// How it is measured; here `--spp` is the most samples of a picture.
    #[command(flatten)]
    pub(crate) effort: EffortArgs,
}

/// Flags of `patina bench render`.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// glTF files; without them two scenes are built in: a tunnel of 262,144 triangles and a Cornell box.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<PathBuf>,

    /// A look for all of the scenes.
    #[arg(long, value_name = "FILE", requires = "scenes")]
    pub(crate) look: Option<PathBuf>,

    /// How it is measured.
    #[command(flatten)]
    pub(crate) effort: EffortArgs,
}

/// Flags of all measurements of whole renders.
#[derive(Debug, Args)]
pub(crate) struct EffortArgs {
    /// Samples (camera paths) per pixel of each run. Usually 16; for textures 16 without a GPU, 4 on a software
    /// driver, 32 on a GPU, and 2 at least, as the error of a single one isn't known, by which pictures of several forms are held against each other; for
    /// methods, whose samples double until then, 1024 without a GPU, 16384 on one, and 4 at least.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub(crate) spp: Option<String>,

    /// Width and height of the picture in pixels. Usually 512x512; for methods 256x256; for textures 256x256 without a GPU,
    /// 1280x720 on one.
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    pub(crate) size: Option<String>,

    /// Timed runs of each case, in turn: A B C A B C. One more comes first and isn't counted. Usually 3; for textures 5
    /// without a GPU, 9 on one; for methods 1, and none comes first.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub(crate) runs: Option<String>,

    /// Largest path depth: at most N surface points scatter light along a path.
    #[arg(
        long,
        value_name = "N",
        default_value = "9",
        allow_hyphen_values = true
    )]
    pub(crate) max_depth: String,

    /// Write the figures as JSON.
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,

    /// Folder with textures (.wgsl), searched before all others. May be given several times.
    #[arg(long = "textures", value_name = "DIR", action = ArgAction::Append)]
    pub(crate) texture_dirs: Vec<PathBuf>,

    /// Device by number or by part of its name, as `patina devices` lists them.
    #[arg(long, value_name = "NAME|N")]
    pub(crate) device: Option<String>,
}
