//! The kernels of the comparison are valid, use what they declare, and need the memory that they are said to need.

use engine::passes::proctex;
use patina_bench::{inlined, rayquery};
use texgen::{GeneratedKernel, Graph, Library, SourceFile, TextureType};

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

fn private_bytes(text: &str, entry: &str) -> u32 {
    let (module, info) = module(text);
    let index = module.entry_points.iter().position(|e| e.name == entry);
    let index = index.expect("it is there");
    let uses = info.get_entry_point(index);
    texgen::kernel_private_bytes(&module, uses, &module.entry_points[index])
}

/// A texture that reads all that textures can read.
fn picture() -> Library {
    let text = "fn userProc(image: sam2D) -> vec4f { return tex2D(image, readAttr(TexCoord0).xy) * readAttr(AO); }";
    let texture = TextureType::parse(SourceFile::new("picture", "picture.wgsl", text));
    let texture = texture.unwrap_or_else(|e| panic!("{e}"));
    Library::new(vec![texture]).unwrap_or_else(|e| panic!("{e}"))
}

fn no_programs() -> GeneratedKernel {
    texgen::emit_inlined(&Graph::new(Default::default()), &[Vec::new()])
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn the_kernel_on_ray_queries_is_valid_with_and_without_textures() {
    let inlined = no_programs();
    for generated in [None, Some(&inlined)] {
        let text = rayquery::text(generated, 9);
        let bytes = private_bytes(&text.text, rayquery::PASS.name);
        // Two rays, six fields, nine words, and what functions need.
        assert!(bytes > 2 * 48 + 6 * 16 + 9 * 4, "{bytes}");
    }
}

#[test]
fn the_kernel_on_ray_queries_reads_and_writes_what_its_pass_declares() {
    // The form is another one, but the textures read the same.
    let text = rayquery::text(Some(&picture().emit(1)), 9);
    let (module, info) = module(&text.text);
    let mut entries = module.entry_points.iter();
    let index = entries.position(|entry| entry.name == rayquery::PASS.name);
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
    assert_eq!(reads, rayquery::PASS.reads);
    assert_eq!(writes, rayquery::PASS.writes);
}

#[test]
fn occlusion_in_the_texture_kernel_brings_the_stack_of_traversal() {
    let library = picture();
    let counted = proctex::text(&library.emit(1));
    let traced = inlined::text(&library.emit(1));
    let [counted, traced] =
        [counted, traced].map(|text| private_bytes(&text.text, proctex::PASS.name));
    // 32 groups of two words.
    assert!(traced > counted + 256, "{counted} and {traced} bytes");
}
