//! The inlined form of the texture kernel, the base of comparisons: it gives the picture of the usual form, with
//! ambient occlusion, blends, bumps and opacity. Skipped with a notice where there is no adapter.

#[path = "support/mod.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod support;

use std::path::Path;

use engine::film::Film;
use engine::gpu::Gpu;
use engine::passes::proctex::TextureForm;
use engine::procedural::{Procedural, TextureSources};
use engine::renderer::Renderer;
use engine::scene::{Material, Projection, Scene};
use glam::Vec3;
use texgen::Value;

use support::device;
use support::estimate::Estimate;
use support::scenes::{
    Shot, camera, faceted_sphere, floor, lambert, quad, scene, settings, textured,
};
use support::stats::ZTest;

const LOOK: &str = r#"
[ao.near]
distance = 0.6
samples = 6
direction = "both"

[node.mask]
texture = "rust_mask"
scale = 3.0
amount = 0.4
occlusion = "near"

[node.rust]
texture = "rust_color"
scale = 6.0

[node.cells]
texture = "voronoi"
scale = 4.0

[node.leaf]
texture = "checker"
scale = 3.0
color_a = [1, 1, 1]
color_b = [0, 0, 0]

[material.'material 0']
base_color = "rust"
roughness = "cells.x"
bump = "cells.x"
bump_scale = 0.02

[material.'material 1']
blend = { base = 'material 1', over = 'Rusty', mask = 'mask' }

[material.Rusty]
blend = { base = 'Rust', over = 'Dust', mask = 0.25 }

[material.Rust]
base_color = "rust"

[material.Dust]
base_color = [0.2, 0.12, 0.05]

[material.'material 2']
opacity = "leaf.x"
"#;

fn room() -> (Scene, Procedural) {
    let sheet = quad(
        Vec3::new(-1.5, 0.2, 1.2),
        Vec3::X * 1.2,
        Vec3::new(0.0, 1.0, -0.3),
    );
    let mut scene = scene(
        [
            (floor(3.0), lambert(Vec3::splat(0.5))),
            (faceted_sphere(12), lambert(Vec3::new(0.2, 0.4, 0.7))),
            (
                sheet,
                Material {
                    double_sided: true,
                    ..lambert(Vec3::splat(0.7))
                },
            ),
        ],
        Vec3::ONE,
    );
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("user_textures");
    let sources = TextureSources::scan(&[folder]).expect("the shipped textures");
    let procedural = textured(&mut scene, LOOK, &sources);
    (scene, procedural)
}

fn renderer(gpu: &Gpu, form: TextureForm) -> Renderer {
    let (scene, procedural) = room();
    let camera = camera(
        Vec3::new(0.5, 1.6, 4.0),
        Vec3::new(-0.2, 0.3, 0.0),
        Vec3::Y,
        Projection::Perspective { y_fov: 0.8 },
    );
    let shot = Shot {
        size: (40, 32),
        max_depth: 3,
        spp: 32,
    };
    Renderer::with_form(gpu, &scene, &procedural, &settings(&camera, shot), form)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn film(renderer: &mut Renderer) -> Film {
    renderer
        .render(32)
        .and_then(|()| renderer.film())
        .unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn assert_same(name: &str, tested: &Film, reference: &Film) {
    let (tested, reference) = (Estimate::from_film(tested), Estimate::from_film(reference));
    // The same random numbers are used, so only paths that rounding sends another way differ at all.
    let close = tested
        .mean
        .iter()
        .zip(&reference.mean)
        .filter(|(a, b)| (0..3).all(|c| (a[c] - b[c]).abs() <= 0.02 * b[c].abs().max(0.05)));
    let share = close.count() as f64 / tested.mean.len() as f64;
    assert!(share > 0.97, "{name}: {share} of the pixels are the same");
    ZTest::default()
        .compare(tested, reference, |_, _| true)
        .assert_matches(name, 0.995, 0.005);
}

#[test]
fn the_inlined_form_gives_the_same_picture_and_is_built_again_for_an_edit() {
    let Some(gpu) = device::open() else { return };
    if gpu.description().storage_buffers_per_stage < 10 {
        eprintln!("skipped: the inlined form needs ten storage buffers per stage");
        return;
    }
    let mut stack = renderer(&gpu, TextureForm::Stack);
    let mut inlined = renderer(&gpu, TextureForm::Inlined);
    assert_same("inlined form", &film(&mut inlined), &film(&mut stack));

    let pipelines = gpu.pipelines_created();
    let edit = |renderer: &mut Renderer| {
        renderer
            .set_argument("mask", "amount", Value::F32(0.7))
            .unwrap_or_else(|error| panic!("{error}"));
        renderer
            .set_link("rust", "scale", "cells.y")
            .unwrap_or_else(|error| panic!("{error}"));
    };
    edit(&mut stack);
    assert_eq!(gpu.pipelines_created(), pipelines, "edits are data");
    edit(&mut inlined);
    assert_eq!(gpu.pipelines_created(), pipelines + 2, "edits are code");
    assert_same(
        "inlined form, edited",
        &film(&mut inlined),
        &film(&mut stack),
    );
}
