//! The texture kernel that really runs: everything that texgen's kernels call is there, as texgen expects it, for
//! textures that use all of the language. No device is needed.

use std::collections::BTreeMap;

use engine::passes::wgsl::ComposedWgsl;
use texgen::{BUILTIN_ATTRIBUTES, GLOBALS, HOST_STUB, Library, SourceFile, TextureType};

/// A library that reads every attribute and global, and calls every function, with every type of parameter.
fn whole_language() -> Library {
    let mut reads = String::new();
    for attribute in BUILTIN_ATTRIBUTES {
        reads.push_str(&format!("    v += readAttr({});\n", attribute.name()));
    }
    for global in GLOBALS {
        reads.push_str(&format!("    v += readGlobal({});\n", global.name()));
    }
    let everything = format!(
        "fn userProc(a: f32, b: i32, c: u32, d: bool, e: vec2f, f: vec3f, g: vec4f, h: mat3x3f, k: mat4x4f,
                     image: sam2D, ramp: ramp1D, list: array<f32, 3>, points: array<vec3f, 2>) -> vec4f {{
    var v = readAttr(_FIRST) + readAttr(_SECOND);
{reads}
    v += tex2D(image, e) + tex2DLod(image, e, a) + vec4f(texSize(image), 0.0, 0.0) + rampEval(ramp, a);
    v += k * g + vec4f(h * f, f32(b) + f32(c) + select(0.0, 1.0, d));
    let copy = list;
    for (var i = 0; i < 3; i++) {{ v += list[i] + copy[i] + points[i].x; }}
    for (var x = 0.0; x < a; x += 1.0) {{ v += 1.0; }}
    return v;
}}"
    );
    let types = [
        ("everything", everything.as_str()),
        ("number", "fn userProc() -> f32 { return 1.0; }"),
        ("pair", "fn userProc(x: f32) -> vec2f { return vec2f(x); }"),
        (
            "colour",
            "fn userProc(x: vec2f) -> vec3f { return vec3f(x, 0.0); }",
        ),
    ]
    .map(|(name, text)| {
        TextureType::parse(SourceFile::new(name, format!("{name}.wgsl"), text))
            .unwrap_or_else(|problems| panic!("{problems}"))
    });
    Library::new(types.into()).unwrap_or_else(|problem| panic!("{problem}"))
}

fn validated(text: &str) -> naga::Module {
    let module =
        naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::empty(),
    )
    .validate(&module)
    .unwrap_or_else(|e| panic!("{}", e.emit_to_string(text)));
    module
}

/// Parameter types and result of each function, by name.
fn signatures(module: &naga::Module) -> BTreeMap<String, (Vec<String>, String)> {
    let shown = |ty: naga::Handle<naga::Type>| format!("{:?}", module.types[ty].inner);
    let signature = |f: &naga::Function| {
        let arguments = f.arguments.iter().map(|a| shown(a.ty)).collect();
        let result = f.result.as_ref().map_or(String::new(), |r| shown(r.ty));
        (arguments, result)
    };
    let functions = module.functions.iter();
    functions
        .map(|(_, f)| (f.name.clone().unwrap_or_default(), signature(f)))
        .collect()
}

#[test]
fn the_whole_language_compiles_into_the_kernel_that_runs() {
    let mut source = ComposedWgsl::of("proctex/proctex.wgsl");
    source.append_generated(&whole_language().emit(8));
    let module = validated(&source.text);
    assert!(module.entry_points.iter().any(|e| e.name == "proctex"));
}

#[test]
fn the_kernel_has_every_host_function_as_texgen_expects_it() {
    let mut source = ComposedWgsl::of("proctex/proctex.wgsl");
    source.append_generated(&Library::default().emit(1));
    let ours = signatures(&validated(&source.text));
    let expected = signatures(&validated(HOST_STUB));
    assert!(expected.len() > 20);
    for (name, signature) in expected {
        assert_eq!(ours.get(&name), Some(&signature), "{name}");
    }
}
