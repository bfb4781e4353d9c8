//! Kernels that come compiled with the program: they are found, and do what is compiled from the same text at run time.

use std::collections::HashMap;

use device::native::{
    buffer::Buffer,
    compile::{BindingKind, Kernel, Options, Resource},
    image::{Format, Image},
};
use engine::{gpu_scene::SceneFeatures, passes::wgsl::ComposedWgsl};

/// Entry points and what their texts begin with.
const KERNELS: [(&str, &str); 11] = [
    ("accumulate", "accumulate/entry.wgsl"),
    ("accumulate_first", "film_layers/accumulate.wgsl"),
    ("accumulate_ids", "film_layers/accumulate_ids.wgsl"),
    ("accumulate_mean", "film_layers/accumulate.wgsl"),
    ("accumulate_means", "film_layers/accumulate.wgsl"),
    ("ao", "ao/ao.wgsl"),
    ("brdf", "brdf/entry.wgsl"),
    ("classify", "classify/entry.wgsl"),
    ("raygen", "raygen/entry.wgsl"),
    ("traverse_closest", "traverse/entry.wgsl"),
    ("traverse_occlusion", "traverse/entry.wgsl"),
];

/// The same of caches of light and of photons.
const CACHES: [(&str, &str); 25] = [
    ("count_again", "photons/map.wgsl"),
    ("count_leaves", "photons/map.wgsl"),
    ("count_photons", "photons/sort.wgsl"),
    ("gather_end", "irradiance/gather.wgsl"),
    ("gather_first_hit", "irradiance/first_hit.wgsl"),
    ("gather_note", "irradiance/gather.wgsl"),
    ("gather_photons", "photons/gather.wgsl"),
    ("gather_start", "irradiance/gather.wgsl"),
    ("give_photons", "photons/sort.wgsl"),
    ("give_places", "photons/map.wgsl"),
    ("join_cells", "photons/map.wgsl"),
    ("learn_light", "light_cache/learn.wgsl"),
    ("look_for_sky", "irradiance/look.wgsl"),
    ("look_up_irradiance", "irradiance/look_up.wgsl"),
    ("look_up_light", "light_cache/look_up.wgsl"),
    ("note_light", "light_cache/learn.wgsl"),
    ("photon_arrive", "photons/fly.wgsl"),
    ("photon_emit", "photons/emit.wgsl"),
    ("photon_follow", "photons/fly.wgsl"),
    ("photon_start", "photons/emit.wgsl"),
    ("put_down", "photons/map.wgsl"),
    ("solve_irradiance", "irradiance/solve.wgsl"),
    ("sort_photons", "photons/sort.wgsl"),
    ("split_cells", "photons/map.wgsl"),
    ("weigh_lights", "photons/lights.wgsl"),
];

fn kernel(entry: &str, file: &str, features: &SceneFeatures, options: &Options<'_>) -> Kernel {
    let text = ComposedWgsl::of(file).text;
    let module = naga::front::wgsl::parse_str(&text).expect("it is valid");
    let flags = naga::valid::ValidationFlags::all();
    let mut validator = naga::valid::Validator::new(flags, texgen::CAPABILITIES);
    let info = validator.validate(&module).expect("it is valid");
    // As suits processors.
    let own = [("ao_thread_per_hit", 1.0), ("photons_by_grid", 1.0)];
    let constants = [&features.constants()[..], &own].concat();
    Kernel::new(&module, &info, entry, &constants, options).expect("it can be compiled")
}

fn ahead() -> Options<'static> {
    Options {
        host: &engine::gpu_scene::host_traversal::FUNCTIONS,
        ahead: kernels::all(),
        omissions: kernels::OMISSIONS,
        ..Options::default()
    }
}

/// Whether there are any for this processor; else says so.
fn are_any() -> bool {
    if kernels::all().is_empty() {
        eprintln!("skipped: no kernels are compiled ahead for this processor");
    }
    !kernels::all().is_empty()
}

#[test]
fn every_set_of_features_finds_its_kernels() {
    if !are_any() {
        return;
    }
    // Some sets of what may be left out, among them ones that no build has listed.
    for bits in [0, 0b00_0001, 0b00_0101, 0b10_1010, 0b11_1111_u32] {
        let has = |bit: u32| bits >> bit & 1 == 1;
        let programs = [(false, false), (true, false), (true, true)];
        let ways = [(false, false), (true, false), (false, true), (true, true)];
        let all = programs
            .into_iter()
            .flat_map(|programs| ways.map(|ways| (programs, ways)));
        for ((programs, program_shadows), (splits_light, light_cache)) in all {
            if program_shadows && light_cache {
                continue; // rare: compiled when it is needed
            }
            let features = SceneFeatures {
                alpha: has(0),
                textures: has(1),
                environment: has(2),
                transmission: has(3),
                clear: has(4),
                layers: has(5),
                programs,
                program_shadows,
                splits_light,
                light_cache,
                energy_compensation: true,
                ..SceneFeatures::default()
            };
            let caches = CACHES.iter().filter(|_| light_cache);
            for (entry, file) in KERNELS.iter().chain(caches) {
                let kernel = kernel(entry, file, &features, &ahead());
                assert!(kernel.is_ahead(), "{entry} with {features:?}");
            }
        }
    }
}

/// Both on the same numbers: what they write is the same to the bit.
#[test]
fn what_is_compiled_ahead_gives_the_same_bits() {
    if !are_any() {
        return;
    }
    let features = SceneFeatures {
        energy_compensation: true,
        ..SceneFeatures::default()
    };
    for (entry, file) in [
        ("raygen", "raygen/entry.wgsl"),
        ("accumulate", "accumulate/entry.wgsl"),
    ] {
        let outcomes = [true, false].map(|is_ahead| {
            let options = Options {
                ahead: if is_ahead { kernels::all() } else { &[] },
                ..ahead()
            };
            let kernel = kernel(entry, file, &features, &options);
            assert_eq!(kernel.is_ahead(), is_ahead, "{entry}");
            run(&kernel)
        });
        assert!(
            outcomes[0]
                .iter()
                .any(|buffer| buffer.iter().any(|&word| word != 0))
        );
        assert!(outcomes[0] == outcomes[1], "{entry} differs");
    }
}

/// Path slots of the wave that [`vertices`] shades.
const CAPACITY: u32 = 256;

/// A kernel of the most ways that invocations may part, over vertices of all kinds: the paths' state and rays are the same to the
/// bit, and the queues hold the same.
#[test]
fn vertices_are_shaded_to_the_same_bits_ahead() {
    if !are_any() {
        return;
    }
    let plain = SceneFeatures::default();
    let pictures = SceneFeatures {
        textures: true,
        environment: true,
        ..plain
    };
    let all = SceneFeatures {
        alpha: true,
        transmission: true,
        clear: true,
        layers: true,
        ..pictures
    };
    // Without energy compensation one kernel stands for all scenes.
    let compensated = [plain, pictures, all].map(|features| SceneFeatures {
        energy_compensation: true,
        ..features
    });
    for features in compensated.into_iter().chain([all]) {
        let [found, expected] = [kernels::all(), &[]].map(|ahead_kernels| {
            let options = Options {
                ahead: ahead_kernels,
                ..ahead()
            };
            let kernel = kernel("brdf", "brdf/entry.wgsl", &features, &options);
            assert_eq!(kernel.is_ahead(), !ahead_kernels.is_empty());
            vertices(&kernel)
        });
        for ((name, found), (_, expected)) in found.iter().zip(&expected) {
            let different = (0..found.len()).find(|&word| found[word] != expected[word]);
            assert_eq!(different, None, "{name} with {features:?}");
        }
        let (_, queues) = (found.iter())
            .find(|(name, _)| name == "queues")
            .expect("there are queues");
        // Paths that go on, and shadow rays.
        assert!(queues[0] > 16 && queues[2] > 0, "{:?}", &queues[..4]);
    }
}

/// What is in a kernel's buffers after it has shaded a wave of made-up vertices. What isn't a number counts as one, and the
/// lists of queues have no order.
fn vertices(kernel: &Kernel) -> Vec<(String, Vec<u32>)> {
    const WORDS: u32 = 1 << 16;
    const QUEUE_HEADER: u32 = 32;
    let (_, frame) = layout("Frame");
    let material = layout("Material");
    let mut buffers = Vec::new();
    let bound = kernel
        .bind(|binding| match binding.kind {
            BindingKind::Buffer { .. } => {
                let buffer = Buffer::new(4 * u64::from(WORDS)).expect("there is memory");
                let words: Vec<u32> = (0..WORDS)
                    .map(|word| {
                        let bits = (word + 1).wrapping_mul(2_654_435_761);
                        let bits = bits ^ bits >> 15;
                        let unit = ((bits >> 8) as f32 / 16_777_216.0).to_bits();
                        match binding.name.as_str() {
                            "queues" => match word {
                                0..8 => CAPACITY * (word % 2),
                                8..QUEUE_HEADER => 0,
                                _ => (word - QUEUE_HEADER) % CAPACITY,
                            },
                            // Few have scattered often.
                            "paths" if word / 4 / CAPACITY == 3 => bits >> 8 & 3,
                            "rays" if word % 12 == 10 && bits >> 8 & 7 == 0 => u32::MAX,
                            "rays" if word % 12 >= 10 => bits >> 8 & 15,
                            // Vertices, then one of four materials and what the vertices have.
                            "triangles" if word % 4 == 3 => bits & 0x5000_0003,
                            "triangles" => bits >> 8 & 1023,
                            "vertices" if word % 4 == 3 => bits,
                            "rays" | "vertices" | "instances" => {
                                (f32::from_bits(unit) - 0.5).to_bits()
                            }
                            // Two lights, and behind them a tree that is one leaf.
                            "lights" if word == 35 => 0x8000_0000,
                            // Two-sided, and some of them cut out, blended, solid, or clear.
                            "materials" if 4 * word % material.0 == material.1["flags"] => {
                                1 | bits >> 8 & 0x18c
                            }
                            "materials" if 4 * word % material.0 == material.1["texture_mask"] => {
                                bits >> 8 & 0x3ff
                            }
                            "materials" if bits >> 8 & 15 == 0 => bits >> 12 & 3,
                            _ => unit,
                        }
                    })
                    .collect();
                buffer.write(0, &words);
                if binding.name == "frame" {
                    let numbers = [
                        ("capacity", CAPACITY),
                        ("wave_size", CAPACITY),
                        ("padded_pixels", CAPACITY),
                        ("blocks_x", 2),
                        ("width", 16),
                        ("height", 16),
                        ("max_depth", 3),
                        ("roulette_start", 2),
                        ("light_count", 2),
                        ("directional_count", 0),
                        ("sampler", 0),
                        ("caches", 0),
                        ("lot_samples", 0),
                        ("has_halves", 0),
                        ("crop_blocks_x", 0),
                        ("estimator", 0),
                    ];
                    for (name, number) in numbers {
                        buffer.write(u64::from(frame[name]), &[number]);
                    }
                    for name in ["environment_size", "distribution_size"] {
                        buffer.write(u64::from(frame[name]), &[4u32, 4]);
                    }
                }
                buffers.push((binding.name.clone(), buffer.clone()));
                Some(Resource::from(buffer))
            }
            BindingKind::Image { scalar, .. } => {
                let format = match (binding.name.as_str(), scalar) {
                    ("image_layers", _) => Format::Rgba8Unorm,
                    ("image_layers_srgb", _) => Format::Rgba8UnormSrgb,
                    (_, naga::ScalarKind::Float) => Format::Rgba32Float,
                    _ => Format::Rgba32Uint,
                };
                let image = Image::new(format, 4, 4, 1).expect("there is memory");
                let texels: Vec<u32> = (0..format.texel_bytes() * 4)
                    .map(|word| match (format, word % 4) {
                        (Format::Rgba32Float, _) => (word as f32 / 64.0).to_bits(),
                        // As the table has them: where a picture lies, its size, its layer or whether it is sRGB, its sampler.
                        (Format::Rgba32Uint, 0) => 0,
                        (Format::Rgba32Uint, 1) => 4 | 4 << 16,
                        (Format::Rgba32Uint, 2) => ((word / 4) % 2) << 31,
                        (Format::Rgba32Uint, _) => word / 4,
                        _ => word.wrapping_mul(2_654_435_761),
                    })
                    .collect();
                image.texels().write(0, &texels);
                Some(Resource::from(image))
            }
            BindingKind::Function { .. } => None,
        })
        .expect("all of it is bound");
    bound.dispatch_alone([CAPACITY / 64, 1, 1]);
    let canonical = |word: u32| match f32::from_bits(word).is_nan() {
        true => f32::NAN.to_bits(),
        false => word,
    };
    let read = |(name, buffer): (String, Buffer)| {
        let words = buffer.read::<u32>(0, WORDS as usize);
        let mut words: Vec<u32> = words.into_iter().map(canonical).collect();
        if name == "queues" {
            let lists = words[QUEUE_HEADER as usize..].chunks_mut(CAPACITY as usize);
            lists.for_each(|list| list.sort_unstable());
        }
        (name, words)
    };
    buffers.into_iter().map(read).collect()
}

/// The bytes of a struct of the kernel of vertices, and where its members lie.
fn layout(name: &str) -> (u32, HashMap<String, u32>) {
    let text = ComposedWgsl::of("brdf/entry.wgsl").text;
    let module = naga::front::wgsl::parse_str(&text).expect("it is valid");
    let mut types = module.types.iter();
    let found = types.find(|(_, ty)| ty.name.as_deref() == Some(name));
    match &found.expect("the struct is there").1.inner {
        naga::TypeInner::Struct { members, span } => {
            let members = members.iter();
            let places = members.filter_map(|member| Some((member.name.clone()?, member.offset)));
            (*span, places.collect())
        }
        _ => panic!("{name} is a struct"),
    }
}

/// What is in its buffers after one dispatch over numbers that look like those of a small picture.
fn run(kernel: &Kernel) -> Vec<Vec<u32>> {
    const WORDS: usize = 1 << 16;
    let mut buffers = Vec::new();
    let bound = kernel
        .bind(|binding| match binding.kind {
            BindingKind::Buffer { .. } => {
                let buffer = Buffer::new(4 * WORDS as u64).expect("there is memory");
                let words: Vec<u32> = (0..WORDS as u32)
                    .map(|word| match binding.name.as_str() {
                        // Counts and sizes are whole numbers, and most of the rest of a frame may be.
                        "frame" => 16 + word % 16,
                        _ => {
                            (f64::from(word.wrapping_mul(2_654_435_761) >> 8) / 2.0_f64.powi(25))
                                .to_bits() as u32
                                >> 4
                        }
                    })
                    .collect();
                buffer.write(0, &words);
                buffers.push(buffer.clone());
                Some(Resource::from(buffer))
            }
            BindingKind::Image { .. } => Image::new(Format::Rgba32Float, 1, 1, 1)
                .ok()
                .map(Resource::from),
            BindingKind::Function { .. } => None,
        })
        .expect("all of it is bound");
    bound.dispatch([4, 1, 1]);
    buffers
        .iter()
        .map(|buffer| buffer.read::<u32>(0, WORDS))
        .collect()
}

/// A kernel that calls a function of `text` for each of some inputs and writes what it returns.
fn caller(text: &str, function: &str, options: &Options<'_>) -> Kernel {
    let module = naga::front::wgsl::parse_str(text).expect("it is valid");
    let mut functions = module.functions.iter().map(|(_, function)| function);
    let found = functions.find(|found| found.name.as_deref() == Some(function));
    let found = found.unwrap_or_else(|| panic!("there is no {function}"));
    let mut words = 0;
    let mut arguments = Vec::new();
    for argument in &found.arguments {
        let size = components(&module, argument.ty);
        let words: Vec<String> = (words..words + size)
            .inspect(|_| words += 1)
            .map(|word| format!("input[16u * id.x + {word}u]"))
            .collect();
        arguments.push(match size {
            1 => words.concat(),
            size => format!("vec{size}f({})", words.join(", ")),
        });
    }
    let result = found.result.as_ref().expect("it returns something").ty;
    let members: Vec<(String, u32)> = match &module.types[result].inner {
        naga::TypeInner::Struct { members, .. } => members
            .iter()
            .map(|member| {
                let name = member.name.clone().unwrap_or_default();
                (format!("result.{name}"), components(&module, member.ty))
            })
            .collect(),
        _ => vec![("result".to_owned(), components(&module, result))],
    };
    let mut stores = String::new();
    let mut word = 0;
    for (name, size) in members {
        for component in 0..size {
            let component = match size {
                1 => String::new(),
                _ => format!("[{component}]"),
            };
            stores += &format!("output[16u * id.x + {word}u] = bitcast<u32>({name}{component});\n");
            word += 1;
        }
    }
    let text = format!(
        "{text}
        @group(0) @binding(0) var<storage, read> input: array<f32>;
        @group(0) @binding(1) var<storage, read_write> output: array<u32>;
        @compute @workgroup_size(64) fn call(@builtin(global_invocation_id) id: vec3u) {{
            let result = {function}({});
            {stores}
        }}",
        arguments.join(", ")
    );
    let module = naga::front::wgsl::parse_str(&text).expect("it is valid");
    let flags = naga::valid::ValidationFlags::all();
    let mut validator = naga::valid::Validator::new(flags, texgen::CAPABILITIES);
    let info = validator.validate(&module).expect("it is valid");
    Kernel::new(&module, &info, "call", &[], options).expect("it can be compiled")
}

fn components(module: &naga::Module, ty: naga::Handle<naga::Type>) -> u32 {
    match module.types[ty].inner {
        naga::TypeInner::Vector { size, .. } => size as u32,
        _ => 1,
    }
}

/// What a caller writes for inputs of all kinds: near zero and far, whole numbers, and what is no number. One that isn't a
/// number has many bits; it counts as one.
fn called(kernel: &Kernel) -> Vec<u32> {
    const CALLS: usize = 4096;
    let input: Vec<f32> = (0..16 * CALLS as u32)
        .map(|word| {
            let bits = (word + 1).wrapping_mul(2_654_435_761);
            let unit = (bits >> 8) as f32 / 16_777_216.0 - 0.5;
            match word / 16 % 8 {
                0 => f32::from_bits(bits ^ bits >> 13),
                1 => (16.0 * unit).round(),
                2 => 1e6 * unit,
                3 => 2.0 * unit.abs(),
                _ => 24.0 * unit,
            }
        })
        .collect();
    let buffer = |words: &[u32]| {
        let buffer = Buffer::new(4 * words.len() as u64).expect("there is memory");
        buffer.write(0, words);
        buffer
    };
    let input = buffer(&input.iter().map(|x| x.to_bits()).collect::<Vec<u32>>());
    let output = buffer(&vec![0; 16 * CALLS]);
    let bound = kernel.bind(|binding| {
        Some(Resource::from(match binding.name.as_str() {
            "input" => input.clone(),
            _ => output.clone(),
        }))
    });
    bound
        .expect("both are bound")
        .dispatch([CALLS as u32 / 64, 1, 1]);
    let canonical = |word: u32| match f32::from_bits(word).is_nan() {
        true => f32::NAN.to_bits(),
        false => word,
    };
    let words = output.read::<u32>(0, 16 * CALLS);
    words.into_iter().map(canonical).collect()
}

/// Functions of textures, called by kernels that are compiled at run time.
#[test]
fn standard_functions_ahead_give_the_same_bits() {
    if !are_any() {
        return;
    }
    for &function in kernels::function_names() {
        for loop_limit in [None, Some(u32::MAX)] {
            let [ahead, not] = [kernels::functions(), &[]].map(|ahead_functions| {
                let options = Options {
                    separate: &kernels::is_function,
                    ahead_functions,
                    loop_limit,
                    ..Options::default()
                };
                caller(texgen::PRELUDE, function, &options)
            });
            assert_eq!(ahead.statistics().ahead, 1, "{function} is called");
            assert_eq!(
                ahead.statistics().functions,
                1,
                "{function}: nothing else is compiled"
            );
            assert_eq!(not.statistics().ahead, 0);
            let outcomes = [ahead, not].map(|kernel| called(&kernel));
            assert!(outcomes[0].iter().any(|&word| word != 0), "{function}");
            let different = (0..outcomes[0].len()).find(|&i| outcomes[0][i] != outcomes[1][i]);
            assert_eq!(different, None, "{function} differs");
        }
    }
}

/// What counts is what a function does, not what it is called.
#[test]
fn a_function_of_a_standard_name_is_its_own() {
    let text = "fn hashU1(v: u32) -> u32 { return v; }
        fn perlin3D(p: vec3f) -> f32 { return p.x + f32(hashU1(u32(p.y))); }";
    let options = Options {
        separate: &|name| name == "perlin3D",
        ahead_functions: kernels::functions(),
        ..Options::default()
    };
    let kernel = caller(text, "perlin3D", &options);
    assert_eq!(kernel.statistics().ahead, 0);
    let expected = Options::default();
    assert!(called(&kernel) == called(&caller(text, "perlin3D", &expected)));
}
