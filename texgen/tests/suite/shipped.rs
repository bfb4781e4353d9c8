//! The textures that ship with Patina: each is valid WGSL with the prelude, and all of them make a valid kernel.

use crate::common::{shipped, validate};
use std::sync::Arc;

use texgen::{Graph, HOST_STUB, Library, PRELUDE, emit_inlined};

#[test]
fn every_shipped_texture_is_plain_wgsl_with_the_prelude() {
    for file in shipped() {
        for text in [
            format!("{PRELUDE}\n{}", file.text()),
            format!("{}\n{PRELUDE}", file.text()),
        ] {
            if let Err(problem) = validate(&text) {
                panic!("{}: {problem}", file.path());
            }
        }
    }
}

#[test]
fn every_shipped_texture_is_accepted_without_warnings_and_is_documented() {
    for file in shipped() {
        let texture =
            texgen::TextureType::parse(file).unwrap_or_else(|problems| panic!("{problems}"));
        assert!(texture.warnings().is_empty(), "{}", texture.warnings());
        assert!(
            !texture.docs().is_empty(),
            "{} has no documentation",
            texture.name()
        );
        for parameter in texture.parameters() {
            assert_ne!(
                parameter.label,
                parameter.name,
                "{}: `{}` has no label",
                texture.name(),
                parameter.name
            );
        }
    }
}

#[test]
fn all_of_them_make_one_valid_kernel_that_can_be_read() {
    let textures = shipped()
        .into_iter()
        .map(|file| texgen::TextureType::parse(file).expect("checked above"));
    let library = Library::new(textures.collect()).expect("names differ");
    for slots in [0, 1, 100] {
        let kernel = library.emit(slots);
        validate(&format!("{}\n{HOST_STUB}", kernel.wgsl))
            .unwrap_or_else(|problem| panic!("{problem}"));
    }
    let kernel = library.emit(1).wgsl;
    for file in shipped() {
        for comment in file
            .text()
            .lines()
            .filter(|line| line.trim_start().starts_with("//"))
        {
            assert!(
                kernel.contains(comment),
                "{}: lost comment {comment:?}",
                file.name()
            );
        }
    }
    assert!(
        !kernel.contains("readAttr(") || kernel.contains("fn readAttr"),
        "an attribute was not rewritten"
    );
}

#[test]
fn the_look_of_the_design_fits_the_shipped_textures() {
    let textures = shipped()
        .into_iter()
        .map(|file| texgen::TextureType::parse(file).expect("checked above"));
    let library = Library::new(textures.collect()).expect("names differ");
    let names = |texture: &str| -> Vec<String> {
        let texture = library
            .get(texture)
            .unwrap_or_else(|| panic!("{texture} is missing"));
        texture
            .parameters()
            .iter()
            .map(|parameter| parameter.name.clone())
            .collect()
    };
    assert!(names("rust_mask").contains(&"scale".into()));
    assert!(
        names("rust_color").contains(&"scale".into())
            && names("rust_color").contains(&"ramp".into())
    );
    for texture in ["fbm", "voronoi", "checker", "mix_color", "scratches"] {
        names(texture);
    }
}

#[test]
fn the_inlined_form_is_valid_too() {
    let textures = shipped()
        .into_iter()
        .map(|file| texgen::TextureType::parse(file).expect("checked above"));
    let library = Library::new(textures.collect()).expect("names differ");
    let mut graph = Graph::new(Arc::new(library));
    let mut add = |texture: &str| graph.add_node(texture, texture, [1, 0]).expect("known");
    let (mask, rust, mix) = (add("rust_mask"), add("rust_color"), add("mix_color"));
    graph.set_link(mix, "factor", mask, None).expect("fits");
    graph
        .set_link(mix, "b", rust, Some("zyx".parse().expect("a swizzle")))
        .expect("fits");
    let kernel = emit_inlined(
        &graph,
        &[vec![mix.into(), mask.into()], vec![rust.into()], vec![]],
    )
    .expect("no image is missing");
    validate(&format!("{}\n{HOST_STUB}", kernel.wgsl))
        .unwrap_or_else(|problem| panic!("{problem}"));
    let call = "mix_color__userProc(vec4f(0.0f, 0.0f, 0.0f, 1.0f, ), vec4f(n";
    assert!(kernel.wgsl.contains(call), "{}", kernel.wgsl);
}
