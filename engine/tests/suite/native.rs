//! The renderer's kernels on processors: all of them compile, and each dispatch of a wave leaves in every buffer what a
//! GPU device leaves there.

use std::collections::{BTreeMap, BTreeSet};

use device::{
    Device, DeviceChoice, Extent, Recording, Resources, Text, Usage,
    native::compile::{Cache, Kernel as NativeKernel, Options},
};
use engine::{
    bvh::SceneBvh,
    frame::Frame,
    gpu_scene::{GpuScene, SceneFeatures},
    passes::{
        display, guide,
        pass::{Pass, Work},
        proctex, traverse,
        wgsl::ComposedWgsl,
    },
    scene::{Camera, Instance, Material, Mesh, Projection, Scene},
    schedule::{self, Run},
    settings::RenderSettings,
    texturing::TextureReads,
    wave::{self, RayHit},
};
use glam::{Affine3A, Vec3};
use texgen::{Library, SourceFile, TextureType};

/// The override constants of all kernels, with one value.
fn constants(value: f64) -> Vec<(&'static str, f64)> {
    let features = SceneFeatures::default().constants();
    let names = features.iter().map(|(name, _)| *name);
    names
        .chain(["ao_thread_per_hit", "photons_by_grid"])
        .map(|name| (name, value))
        .collect()
}

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
    source: &ComposedWgsl,
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
    let passes = schedule::WAVE.iter().chain([&&guide::PASS]);
    let files: BTreeSet<&str> = passes
        .filter(|pass| pass.name != proctex::PASS.name)
        .map(|pass| pass.file)
        .chain([display::FILE, display::MIX])
        .collect();
    for file in files {
        let source = ComposedWgsl::of(file);
        let (module, _) = parse(&source.text);
        for entry in &module.entry_points {
            for value in [0.0, 1.0] {
                let constants = constants(value);
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
    let source = proctex::text(&library.emit(8));
    for value in [0.0, 1.0] {
        let constants = constants(value);
        let kernel = compile(&source, proctex::PASS.name, &constants, &options);
        assert!(kernel.statistics().functions > count);
    }
    let constants = constants(0.0);
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

    /// All but the hierarchy, which each device has of its own.
    fn contents(&self) -> Contents {
        let read = |(name, bytes)| {
            let words = self.device.read(self.resources.buffer(name), 0, bytes);
            (name, bytemuck::pod_collect_to_vec(&words.expect("read")))
        };
        let sizes = self.resources.buffer_sizes();
        sizes
            .filter(|(name, _)| *name != "nodes")
            .map(read)
            .collect()
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

/// A grey room with a green wall, a slab across its middle and a lamp below its ceiling; open where the camera is.
fn room() -> Scene {
    let mut scene = Scene {
        cameras: vec![Camera {
            name: String::new(),
            transform: Affine3A::from_translation(Vec3::new(0.5, 0.5, 2.5)),
            projection: Projection::Perspective { y_fov: 0.68 },
            aperture_radius: 0.0,
            aperture_blades: 0,
            aperture_rotation: 0.0,
            focus_distance: 1.0,
        }],
        ..Scene::default()
    };
    let grey = Vec3::splat(0.73);
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    // Corner, two sides whose cross product points to where the front is, colour and emission.
    for (corner, u, v, color, light) in [
        (z, x, -z, grey, 0.0),
        (y, x, z, grey, 0.0),
        (Vec3::ZERO, x, y, grey, 0.0),
        (z, -z, y, grey, 0.0),
        (x, z, y, Vec3::new(0.14, 0.45, 0.09), 0.0),
        (
            Vec3::new(0.2, 0.3, 0.7),
            x * 0.5,
            Vec3::new(0.1, 0.2, -0.4),
            grey,
            0.0,
        ),
        (
            Vec3::new(0.38, 0.999, 0.38),
            x * 0.24,
            z * 0.24,
            Vec3::ZERO,
            15.0,
        ),
    ] {
        let number = scene.meshes.len() as u32;
        scene.meshes.push(Mesh {
            positions: vec![corner, corner + u, corner + u + v, corner + v],
            normals: vec![u.cross(v).normalize(); 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            triangle_materials: vec![number; 2],
            ..Mesh::default()
        });
        scene.instances.push(Instance {
            name: String::new(),
            mesh: number,
            transform: Affine3A::IDENTITY,
            asset: None,
        });
        scene.materials.push(Material {
            base_color: color.extend(1.0),
            emission: Vec3::splat(light),
            metallic: 0.0,
            specular: 0.0,
            ..Material::default()
        });
    }
    scene
}

/// Names what rays hit on the native device, which keeps triangles and instances in the scene's order, as the other does, in
/// whose order they lie in memory. Of a shadow ray that is stopped nothing else is of interest.
fn rename_hits(scene: &Scene, gpu: &SceneBvh, before: &[u32], sides: [&mut Vec<u32>; 2]) {
    let place_of = |places: &[u32], source: u32| {
        let place = places.iter().position(|&at| at == source);
        place.expect("it is somewhere") as u32
    };
    let own = SceneBvh::in_scene_order(scene).expect("a scene");
    let [driver, native] = sides;
    let words = size_of::<RayHit>() / 4;
    for first in (0..before.len()).step_by(words) {
        let [triangle, instance] = [first + words - 2, first + words - 1];
        let is_stopped = before[triangle] == RayHit::MISS && native[triangle] != RayHit::MISS;
        if first >= before.len() / 2 {
            for side in [&mut *driver, &mut *native] {
                if side[triangle] != RayHit::MISS {
                    side[triangle] = 0;
                }
            }
        } else if is_stopped {
            let source = own.instance_order[native[instance] as usize];
            native[instance] = place_of(&gpu.instance_order, source);
            let mesh = scene.instances[source as usize].mesh as usize;
            let in_mesh = native[triangle] - own.mesh_first_triangle[mesh];
            let place = place_of(&gpu.triangle_order[mesh], in_mesh);
            native[triangle] = gpu.mesh_first_triangle[mesh] + place;
        }
    }
}

/// A wave of a room, pass by pass: both devices begin each with what the GPU device left.
#[test]
fn passes_leave_what_a_gpu_leaves() {
    let Ok(driver) = Device::open(&DeviceChoice::Driver) else {
        let required = std::env::var_os("PATINA_REQUIRE_DEVICE").is_some();
        assert!(!required, "there is no driver");
        eprintln!("skipped: there is no driver");
        return;
    };
    let native = DeviceChoice::Name("native".to_owned());
    let native = Device::open(&native).unwrap_or_else(|error| panic!("{error}"));
    let scene = room();
    let (gpu, native) = (Side::new(driver, &scene), Side::new(native, &scene));
    let mut passes = Listed(gpu.features, Vec::new());
    schedule::start(&mut passes);
    for _ in 0..4 {
        schedule::round(&mut passes);
    }
    schedule::end(&mut passes);
    let order = SceneBvh::build(&scene).expect("a scene");
    let mut before = gpu.contents();
    for pass in passes.1 {
        native.set_contents(&before);
        native.run(pass);
        gpu.run(pass);
        let (after, mut native) = (gpu.contents(), native.contents());
        let mut compared = after.clone();
        if [traverse::CLOSEST.name, traverse::OCCLUSION.name].contains(&pass.name) {
            let [gpu, native] = [&mut compared, &mut native].map(|contents| {
                contents
                    .get_mut("rays")
                    .expect("they are among the buffers")
            });
            rename_hits(&scene, &order, &before["rays"], [gpu, native]);
        }
        for (name, words) in &compared {
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
