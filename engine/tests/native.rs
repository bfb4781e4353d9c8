//! The renderer's kernels on processors: all of them compile, and each dispatch of a wave leaves in every buffer what a
//! GPU device leaves there.

use std::collections::BTreeMap;

use device::{
    Device, DeviceChoice, DeviceDescription, Extent, Recording, Resources, Text, Usage,
    native::compile::{Cache, Kernel as NativeKernel, Options},
};
use engine::{
    bench::scenes,
    frame::Frame,
    gpu_scene::{GpuScene, SceneFeatures},
    passes::{
        pass::{Pass, Work},
        proctex,
        wgsl::Source,
    },
    procedural::TextureReads,
    scene::Scene,
    schedule::{self, Run},
    settings::RenderSettings,
    wave,
};
use texgen::{Library, SourceFile, TextureType};

/// The override constants of all kernels.
const FEATURES: [&str; 10] = [
    "has_alpha",
    "has_textures",
    "has_environment",
    "has_transmission",
    "has_clear",
    "has_layers",
    "energy_compensation",
    "has_programs",
    "has_program_shadows",
    "ao_thread_per_hit",
];

fn parse(text: &str) -> (naga::Module, naga::valid::ModuleInfo) {
    let module =
        naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    let info = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::empty(),
    )
    .validate(&module)
    .unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    (module, info)
}

/// Compiles an entry point, and says what that took.
fn compile(
    source: &Source,
    entry: &str,
    constants: &[(&str, f64)],
    options: &Options<'_>,
) -> NativeKernel {
    let (module, info) = parse(&source.text);
    let kernel = NativeKernel::new(&module, &info, entry, constants, options);
    let kernel = kernel.unwrap_or_else(|error| {
        let place = error.span.to_range();
        let place = place.and_then(|range| source.locate(range, &error.to_string()));
        panic!("{entry}: {}", place.unwrap_or_else(|| error.to_string()))
    });
    println!("{entry}: {:?}", kernel.statistics());
    kernel
}

#[test]
fn every_kernel_compiles() {
    for file in [
        "raygen/entry.wgsl",
        "advance/advance.wgsl",
        "traverse/entry.wgsl",
        "classify/entry.wgsl",
        "ao/ao.wgsl",
        "brdf/entry.wgsl",
        "accumulate/entry.wgsl",
        "film_layers/record.wgsl",
        "film_layers/accumulate.wgsl",
        "guide/guide.wgsl",
        "display/display.wgsl",
    ] {
        let source = Source::of(file);
        let (module, _) = parse(&source.text);
        for entry in &module.entry_points {
            for value in [0.0, 1.0] {
                let constants = FEATURES.map(|name| (name, value));
                compile(&source, &entry.name, &constants, &Options::default());
            }
        }
    }
}

/// The standard textures, all in one kernel.
fn standard_textures() -> Vec<TextureType> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../user_textures");
    let mut types = Vec::new();
    for file in std::fs::read_dir(folder).expect("the standard textures") {
        let path = file.expect("a file").path();
        if path.extension().is_some_and(|e| e == "wgsl") {
            let name = path
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            let text = std::fs::read_to_string(&path).expect("text");
            let source = SourceFile::new(name, path.display().to_string(), text);
            types.push(TextureType::parse(source).unwrap_or_else(|e| panic!("{e}")));
        }
    }
    types
}

/// With the code of a texture compiled apart, a change of it compiles nothing else.
#[test]
fn generated_kernels_compile() {
    let cache = Cache::new();
    let options = Options {
        separate: &|name| name.ends_with("__userProc"),
        cache: Some(&cache),
        ..Options::default()
    };
    let types = standard_textures();
    let count = types.len();
    let library = Library::new(types).unwrap_or_else(|e| panic!("{e}"));
    let stack = proctex::TextureForm::Stack;
    for generated in [library.emit(8), library.emit_in_rounds(8, &[])] {
        let source = proctex::source(stack, &generated);
        for value in [0.0, 1.0] {
            let constants = FEATURES.map(|name| (name, value));
            let kernel = compile(&source, proctex::PASS.name, &constants, &options);
            assert!(kernel.statistics().functions > count);
        }
    }
    let source = proctex::source(stack, &library.emit(8));
    let constants = FEATURES.map(|name| (name, 0.0));
    let again = compile(&source, proctex::PASS.name, &constants, &options);
    assert_eq!(again.statistics().compiled, 0);
}

/// Paths of the wave that is compared.
const PATHS: u32 = 64 * 64;

/// What is in the buffers, by name.
type Contents = BTreeMap<&'static str, Vec<u32>>;

/// A device with the scene and the memory of a wave.
struct Side {
    device: Device,
    resources: Resources,
    features: SceneFeatures,
}

impl Side {
    fn new(device: Device, scene: &Scene) -> Self {
        let mut resources = Resources::default();
        let reads = TextureReads::default();
        let traits = |_| Default::default();
        let uploaded = GpuScene::new(&device, scene, &reads, traits, &mut resources);
        let uploaded = uploaded.expect("a scene");
        wave::allocate(&device, PATHS, 0, &mut resources).expect("memory");
        let camera = scene.cameras[0].clone();
        let mut frame = Frame::new(&RenderSettings::new(64, 64, &camera), PATHS, &uploaded);
        (frame.wave_size, frame.sample_limit) = (PATHS, 1);
        let mut add = |name, usage, contents: &[u8]| {
            let buffer = device.filled_buffer(name, usage, contents);
            resources.set_buffer(name, buffer.expect("memory"));
        };
        add("frame", Usage::Uniform, bytemuck::bytes_of(&frame));
        for plane in ["film0", "film1", "film2", "film3", "film4"] {
            add(plane, Usage::Storage, &[0; 16 * PATHS as usize]);
        }
        let filter: Vec<f32> = (0..4096).map(|i| i as f32 / 4096.0 - 0.5).collect();
        let filter = bytemuck::cast_slice(&filter);
        add("filter_table", Usage::Storage, filter);
        let fresh = wave::fresh_queues();
        let queues = resources.buffer("queues");
        device.write(queues, 0, bytemuck::cast_slice(&fresh));
        Self {
            device,
            resources,
            features: uploaded.features,
        }
    }

    fn contents(&self) -> Contents {
        let read = |(name, bytes)| {
            let words = self.device.read(self.resources.buffer(name), 0, bytes);
            (name, bytemuck::pod_collect_to_vec(&words.expect("read")))
        };
        self.resources.buffer_sizes().map(read).collect()
    }

    fn set_contents(&self, contents: &Contents) {
        for (name, words) in contents {
            let words = bytemuck::cast_slice(words);
            self.device.write(self.resources.buffer(name), 0, words);
        }
    }

    fn run(&self, pass: &Pass) {
        let kernel = pass.kernel(&self.device, &self.features);
        let bound = kernel
            .unwrap_or_else(|error| panic!("{error}"))
            .bind(&self.device, &self.resources);
        let extent = match pass.work {
            Work::Paths => Extent::Threads(PATHS),
            Work::Single => Extent::One,
            Work::Queue(queue) => {
                let sizes = self.resources.buffer("dispatch_sizes").clone();
                Extent::Indirect(sizes, queue.dispatch_offset())
            }
        };
        let mut recording = Recording::new("a pass");
        recording.dispatch(&bound, extent);
        self.device.play(&recording).expect("the device works");
    }
}

/// The passes that a scene needs, in their order.
struct Listed(SceneFeatures, Vec<&'static Pass>);

impl Run for Listed {
    fn run(&mut self, pass: &'static Pass) {
        if (pass.exists)(&self.0) {
            self.1.push(pass);
        }
    }
}

/// Whether a word means the same on both devices: an integer or packed numbers, or a float that was computed by functions
/// which devices approximate differently (Lavapipe's sines by 2e-4).
fn agrees(a: u32, b: u32) -> bool {
    let (x, y) = (f32::from_bits(a), f32::from_bits(b));
    let halves = |word: u32| [word & 0xffff, word >> 16];
    a.abs_diff(b) <= 64
        || (x - y).abs() <= 1e-3 * x.abs().max(y.abs()) + 1e-6
        || halves(a)
            .iter()
            .zip(halves(b))
            .all(|(&a, b)| a.abs_diff(b) <= 8)
}

/// The lists of `queues` are filled in any order.
fn sorted(name: &str, words: &[u32]) -> Vec<u32> {
    let mut words = words.to_vec();
    if name == "queues" {
        let lists = &mut words[wave::QUEUE_HEADER as usize..];
        lists
            .chunks_mut(PATHS as usize)
            .for_each(<[u32]>::sort_unstable);
    }
    words
}

/// A wave of the Cornell box, pass by pass: both devices begin each with what the GPU device left.
#[test]
fn passes_leave_what_a_gpu_leaves() {
    let is_driver = |device: &DeviceDescription| device.backend != "native";
    let driver = Device::all().into_iter().find(is_driver);
    let Some(driver) = driver.filter(|driver| driver.usable.is_ok()) else {
        let required = std::env::var_os("PATINA_REQUIRE_DEVICE").is_some();
        assert!(!required, "there is no driver");
        eprintln!("skipped: there is no driver");
        return;
    };
    let open = |choice| Device::open(&choice).unwrap_or_else(|error| panic!("{error}"));
    let scene = scenes::cornell_box();
    let gpu = Side::new(open(DeviceChoice::Index(driver.index)), &scene);
    let native = Side::new(open(DeviceChoice::Name("native".to_owned())), &scene);
    let mut passes = Listed(gpu.features, Vec::new());
    schedule::start(&mut passes);
    for _ in 0..4 {
        schedule::round(&mut passes);
    }
    schedule::end(&mut passes);
    let mut before = gpu.contents();
    for pass in passes.1 {
        native.set_contents(&before);
        native.run(pass);
        gpu.run(pass);
        let (after, native) = (gpu.contents(), native.contents());
        for (name, words) in &after {
            let (words, native) = (sorted(name, words), sorted(name, &native[name]));
            let old = sorted(name, &before[name]);
            let changed = words.iter().zip(&old).filter(|(a, b)| a != b).count();
            let pairs = words.iter().zip(&native);
            let differ = pairs.filter(|(a, b)| !agrees(**a, **b)).count();
            // Where a number is next to a threshold, a path may go another way.
            assert!(
                differ * 500 <= changed,
                "{} leaves in `{name}` {differ} other words of {changed} that it changes",
                pass.name
            );
        }
        before = after;
    }
}
