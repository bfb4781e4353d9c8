//! Kernels that come compiled with the program: they are found, and do what is compiled from the same text at run time.

use device::native::{
    buffer::Buffer,
    compile::{BindingKind, Kernel, Options, Resource},
    image::{Format, Image},
};
use engine::{gpu_scene::SceneFeatures, passes::wgsl::ComposedWgsl};

/// Entry points and what their texts begin with.
const KERNELS: [(&str, &str); 9] = [
    ("accumulate", "accumulate/entry.wgsl"),
    ("accumulate_first", "film_layers/accumulate.wgsl"),
    ("accumulate_ids", "film_layers/accumulate_ids.wgsl"),
    ("accumulate_mean", "film_layers/accumulate.wgsl"),
    ("accumulate_means", "film_layers/accumulate.wgsl"),
    ("brdf", "brdf/entry.wgsl"),
    ("raygen", "raygen/entry.wgsl"),
    ("traverse_closest", "traverse/entry.wgsl"),
    ("traverse_occlusion", "traverse/entry.wgsl"),
];

fn kernel(entry: &str, file: &str, features: &SceneFeatures, options: &Options<'_>) -> Kernel {
    let text = ComposedWgsl::of(file).text;
    let module = naga::front::wgsl::parse_str(&text).expect("it is valid");
    let flags = naga::valid::ValidationFlags::all();
    let mut validator = naga::valid::Validator::new(flags, texgen::CAPABILITIES);
    let info = validator.validate(&module).expect("it is valid");
    let constants = features.constants();
    Kernel::new(&module, &info, entry, &constants, options).expect("it can be compiled")
}

fn ahead() -> Options<'static> {
    Options {
        host: &[engine::gpu_scene::host_traversal::FUNCTION],
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
        for ((programs, program_shadows), splits_light) in
            programs.into_iter().flat_map(|p| [(p, false), (p, true)])
        {
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
                energy_compensation: true,
                ..SceneFeatures::default()
            };
            for (entry, file) in KERNELS {
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
