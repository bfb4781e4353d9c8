//! What users change while a picture is rendered: arguments, links and AO distances are buffer writes that show in the
//! picture at once, and never compile anything.

#[expect(dead_code, reason = "other tests use the rest")]
mod support;

use std::path::Path;

use engine::gpu::Gpu;
use engine::load;
use engine::renderer::{RenderSettings, Renderer};
use texgen::Value;

use support::device;

const SAMPLES: u32 = 4;

fn demo(gpu: &Gpu) -> Renderer {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let loaded = load::load(
        &root.join("examples/demo/demo.gltf"),
        Some(&root.join("examples/demo/demo.look.toml")),
        &[root.join("user_textures")],
    )
    .unwrap_or_else(|error| panic!("{error}"));
    let settings = RenderSettings {
        width: 48,
        height: 32,
        max_depth: 2,
        seed: 0,
        camera: loaded.camera,
    };
    Renderer::new(gpu, &loaded.scene, &loaded.procedural, &settings)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn picture(renderer: &mut Renderer) -> Vec<[f32; 3]> {
    renderer
        .render(SAMPLES)
        .and_then(|()| renderer.film())
        .unwrap_or_else(|error| panic!("{error}"))
        .mean()
}

#[test]
fn edits_show_in_the_picture_and_compile_nothing() {
    let Some(gpu) = device::open() else { return };
    let mut renderer = demo(&gpu);
    let mut before = picture(&mut renderer);
    let original = before.clone();
    let created = (gpu.pipelines_created(), gpu.shader_modules_created());
    type Edit = fn(&mut Renderer) -> Result<(), engine::renderer::RenderEditError>;
    let edits: [(&str, Edit); 4] = [
        ("an argument", |r| {
            r.set_argument("valve_rust", "amount", Value::F32(0.9))
        }),
        ("a colour", |r| {
            r.set_argument("floor_color", "b", Value::Vec4([1.0, 0.0, 0.0, 1.0]))
        }),
        ("a link", |r| r.set_link("stone_color", "factor", "stains")),
        ("a distance", |r| {
            let mut settings = r.procedural().ao()[0];
            settings.distance = 1.0;
            r.set_ao("crevices", settings)
        }),
    ];
    for (what, edit) in edits {
        edit(&mut renderer).unwrap_or_else(|error| panic!("{what}: {error}"));
        let after = picture(&mut renderer);
        assert_ne!(before, after, "{what} changes the picture");
        before = after;
    }
    assert_eq!(
        created,
        (gpu.pipelines_created(), gpu.shader_modules_created()),
        "an edit compiled something"
    );

    let wrong = renderer.set_argument("valve_rust", "amuont", Value::F32(0.5));
    let message = wrong.expect_err("there is no such parameter").to_string();
    assert!(message.contains("amuont"), "{message}");
    assert_eq!(
        before,
        picture(&mut renderer),
        "a refused edit changes nothing"
    );
    assert_ne!(original, before);
}
