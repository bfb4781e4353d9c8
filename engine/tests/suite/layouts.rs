//! Structs that Rust and WGSL share have the same size and offsets, and every kernel composes, validates and stays
//! within eight storage buffers.

use std::collections::BTreeSet;
use std::mem::{offset_of, size_of};

use engine::{
    display::{GpuDisplay, GpuMix},
    frame::Frame,
    gpu_scene::{GpuInstance, light_tree::GpuLightNode, lights::GpuLight, materials::GpuMaterial},
    passes::{
        display, guide, irradiance,
        photons::{self, PhotonSettings},
        proctex,
        wgsl::{ComposedWgsl, FILES},
    },
    schedule,
    wave::{GpuAoTable, RayHit},
};

fn module(text: &str) -> (naga::Module, naga::valid::ModuleInfo) {
    let module =
        naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    let info = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::RAY_QUERY,
    )
    .validate(&module)
    .unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    (module, info)
}

/// Size and member offsets of a WGSL struct as naga lays it out.
fn wgsl_struct(module: &naga::Module, name: &str) -> (usize, Vec<(String, usize)>) {
    let (_, ty) = module
        .types
        .iter()
        .find(|(_, t)| t.name.as_deref() == Some(name))
        .expect("the struct is declared");
    let naga::TypeInner::Struct { members, span } = &ty.inner else {
        panic!("`{name}` is no struct")
    };
    let offsets = members
        .iter()
        .map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize))
        .collect();
    (*span as usize, offsets)
}

fn assert_layout(module: &naga::Module, name: &str, size: usize, offsets: &[(&str, usize)]) {
    let (wgsl_size, wgsl_offsets) = wgsl_struct(module, name);
    assert_eq!(wgsl_size, size, "size of {name}");
    for (member, offset) in offsets {
        let found = wgsl_offsets
            .iter()
            .find(|(n, _)| n == member)
            .unwrap_or_else(|| panic!("{name}.{member} is missing"));
        assert_eq!(found.1, *offset, "offset of {name}.{member}");
    }
}

#[test]
fn shared_structs_agree() {
    let (brdf, _) = module(&ComposedWgsl::of("brdf/entry.wgsl").text);
    let (advance, _) = module(&ComposedWgsl::of("advance/advance.wgsl").text);
    assert_layout(&brdf, "Frame", size_of::<Frame>(), &Frame::offsets());
    let (display, _) = module(&ComposedWgsl::of(display::FILE).text);
    assert_layout(
        &display,
        "Display",
        size_of::<GpuDisplay>(),
        &GpuDisplay::offsets(),
    );
    let (mix, _) = module(&ComposedWgsl::of(display::MIX).text);
    assert_layout(&mix, "Mix", size_of::<GpuMix>(), &GpuMix::offsets());
    assert_layout(
        &brdf,
        "RayHit",
        size_of::<RayHit>(),
        &[
            ("origin", offset_of!(RayHit, origin)),
            ("t_min", offset_of!(RayHit, t_min)),
            ("direction", offset_of!(RayHit, direction)),
            ("t_max", offset_of!(RayHit, t_max)),
            ("barycentrics", offset_of!(RayHit, barycentrics)),
            ("triangle", offset_of!(RayHit, triangle)),
            ("instance", offset_of!(RayHit, instance)),
        ],
    );
    assert_layout(
        &brdf,
        "Material",
        size_of::<GpuMaterial>(),
        &GpuMaterial::offsets(),
    );
    assert_layout(&brdf, "Light", size_of::<GpuLight>(), &GpuLight::offsets());
    assert_layout(
        &brdf,
        "LightNode",
        size_of::<GpuLightNode>(),
        &GpuLightNode::offsets(),
    );
    assert_layout(
        &brdf,
        "Instance",
        size_of::<GpuInstance>(),
        &GpuInstance::offsets(),
    );
    let (photons, _) = module(&photons::GATHER.source().text);
    assert_layout(
        &photons,
        "PhotonSettings",
        size_of::<PhotonSettings>(),
        &[
            ("radius", offset_of!(PhotonSettings, radius)),
            ("references", offset_of!(PhotonSettings, references)),
            ("target_count", offset_of!(PhotonSettings, target_count)),
            ("targets", offset_of!(PhotonSettings, targets)),
        ],
    );
    assert_layout(
        &advance,
        "AoTable",
        size_of::<GpuAoTable>(),
        &[
            ("distance", offset_of!(GpuAoTable, distance)),
            ("direction", offset_of!(GpuAoTable, direction)),
            ("samples", offset_of!(GpuAoTable, samples)),
            ("same_object", offset_of!(GpuAoTable, same_object)),
        ],
    );
}

#[test]
fn kernels_are_valid_and_bind_at_most_eight_storage_buffers() {
    let mut proctex = ComposedWgsl::of("proctex/proctex.wgsl");
    proctex.append_generated(&texgen::Library::default().emit(1));
    let passes = schedule::WAVE
        .iter()
        .chain([&&guide::PASS, &&irradiance::SOLVE])
        .chain(&photons::APART);
    let files = passes
        .filter(|pass| pass.name != proctex::PASS.name)
        .map(|pass| pass.file)
        .chain([display::FILE, display::MIX]);
    let texts = files
        .map(|file| (file, ComposedWgsl::of(file).text))
        .chain([("proctex", proctex.text)]);
    for (name, text) in texts {
        let (module, info) = module(&text);
        for (index, entry) in module.entry_points.iter().enumerate() {
            let uses = info.get_entry_point(index);
            let buffers = module
                .global_variables
                .iter()
                .filter(|(handle, v)| {
                    matches!(v.space, naga::AddressSpace::Storage { .. })
                        && !uses[*handle].is_empty()
                })
                .count();
            assert!(
                buffers <= 8,
                "{name}: `{}` binds {buffers} storage buffers",
                entry.name
            );
        }
    }
}

/// What a pass declares is what its kernel uses.
#[test]
fn passes_read_and_write_what_they_declare() {
    // It reads all that textures can read.
    let text =
        "fn userProc(image: sam2D) -> vec4f { return tex2D(image, readAttr(TexCoord0).xy); }";
    let file = texgen::SourceFile::new("picture", "picture.wgsl", text);
    let texture = texgen::TextureType::parse(file).unwrap_or_else(|e| panic!("{e}"));
    let library = texgen::Library::new(vec![texture]).unwrap_or_else(|e| panic!("{e}"));
    let mut wrong = String::new();
    for pass in schedule::WAVE
        .into_iter()
        .chain([&guide::PASS, &irradiance::SOLVE])
        .chain(photons::APART)
    {
        let mut source = ComposedWgsl::of(pass.file);
        if pass.name == proctex::PASS.name {
            source.append_generated(&library.emit(1));
        }
        let (module, info) = module(&source.text);
        let mut entries = module.entry_points.iter();
        let index = entries.position(|entry| entry.name == pass.name);
        let uses = info.get_entry_point(index.expect("its entry point"));
        let (mut reads, mut writes) = (Vec::new(), Vec::new());
        for (handle, global) in module.global_variables.iter() {
            let (Some(_), Some(name)) = (&global.binding, &global.name) else {
                continue;
            };
            match uses[handle] {
                used if used.is_empty() => {}
                used if used.contains(naga::valid::GlobalUse::WRITE) => writes.push(name),
                _ => reads.push(name),
            }
        }
        reads.sort_unstable();
        writes.sort_unstable();
        if reads != pass.reads || writes != pass.writes {
            wrong += &format!("{}: reads {reads:?}, writes {writes:?}\n", pass.name);
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn private_memory_counts_the_stack_of_programs() {
    let library = texgen::Library::default();
    let stack = |slots| {
        let (module, info) = module(&proctex::text(&library.emit(slots)).text);
        let mut entries = module.entry_points.iter();
        let index = entries.position(|entry| entry.name == proctex::PASS.name);
        let index = index.expect("it is there");
        let entry = &module.entry_points[index];
        texgen::kernel_private_bytes(&module, info.get_entry_point(index), entry)
    };
    assert_eq!(stack(24) - stack(8), 16 * 16);
}

/// Nothing lies in the passes' folders that no kernel is made of.
#[test]
fn every_wgsl_file_is_part_of_a_kernel() {
    let mut roots: Vec<&str> = schedule::WAVE.iter().map(|pass| pass.file).collect();
    let aside = [guide::PASS.file, irradiance::SOLVE.file];
    roots.extend(aside.into_iter().chain([display::FILE, display::MIX]));
    roots.extend(photons::APART.map(|pass| pass.file));
    let used: BTreeSet<String> = roots
        .into_iter()
        .flat_map(|root| ComposedWgsl::of(root).origins)
        .map(|(file, _)| file)
        .filter(|file| FILES.iter().any(|(name, _)| name == file)) // not made when the program runs
        .collect();
    let all: BTreeSet<String> = FILES.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(used, all);
}
