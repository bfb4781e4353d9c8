//! The forms of textures that ours is compared with: inlined in their kernel, and in a path tracer in one kernel on ray
//! queries. They give the picture of the usual form, with ambient occlusion, blends, bumps and opacity. Skipped with a
//! notice where there is no adapter, or none with ray queries.

use std::path::Path;

use ::device::{Device, DeviceChoice, DeviceOptions};
use engine::film::Film;
use engine::procedural::{Procedural, TextureSources};
use engine::renderer::{RenderSettings, Renderer};
use engine::scene::{AlphaMode, Instance, Material, Projection, Scene};
use glam::{Affine3A, Quat, Vec3, Vec4};
use patina_bench::forms::Form;
use patina_bench::inspect::{Inspection, private_bytes};
use texgen::Value;

use crate::support::device;
use crate::support::estimate::Estimate;
use crate::support::scenes::{
    Shot, add, camera, faceted_sphere, floor, lambert, lamp, quad, scene, settings, textured,
};
use crate::support::stats::ZTest;

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
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../user_textures");
    let sources = TextureSources::scan(&[folder]).expect("the shipped textures");
    let procedural = textured(&mut scene, LOOK, &sources);
    (scene, procedural)
}

fn view() -> RenderSettings {
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
    settings(&camera, shot)
}

fn renderer(device: &Device, (scene, procedural): &(Scene, Procedural), form: Form) -> Renderer {
    form.renderer(device, scene, procedural, &view())
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
    let Some(device) = device::open() else { return };
    if device.description().storage_buffers_per_stage < 10 {
        eprintln!("skipped: the inlined form needs ten storage buffers per stage");
        return;
    }
    let mut stack = renderer(&device, &room(), Form::Stack);
    let mut inlined = renderer(&device, &room(), Form::Inlined);
    assert_same("inlined form", &film(&mut inlined), &film(&mut stack));

    let pipelines = device.counts().pipelines;
    let edit = |renderer: &mut Renderer| {
        renderer
            .edit_graph(|graph| graph.set_value("mask", "amount", Value::F32(0.7)))
            .unwrap_or_else(|error| panic!("{error}"));
        renderer
            .edit_graph(|graph| graph.set_link("rust", "scale", "cells.y"))
            .unwrap_or_else(|error| panic!("{error}"));
    };
    edit(&mut stack);
    assert_eq!(device.counts().pipelines, pipelines, "edits are data");
    edit(&mut inlined);
    assert_eq!(device.counts().pipelines, pipelines + 2, "edits are code");
    assert_same(
        "inlined form, edited",
        &film(&mut inlined),
        &film(&mut stack),
    );
}

/// A device with ray queries; `None`, with a notice, where there is none, or where it takes a minute for each kernel.
fn open_with_ray_queries() -> Option<Device> {
    // Whether there is a device at all is for the usual way to say.
    let usual = device::open()?;
    if usual.traits().compiles_slowly && usual.description().ray_queries && !device::full_run() {
        eprintln!("skipped: a software driver takes minutes for these kernels; set PATINA_FULL");
        return None;
    }
    let has_them = |device: &Device| device.has_ray_queries();
    let device = Device::open_with(&DeviceOptions::new(&DeviceChoice::Best).with_ray_queries())
        .ok()
        .filter(has_them);
    if device.is_none() {
        eprintln!("skipped: the device has no ray queries");
    }
    device
}

#[track_caller]
fn assert_same_picture(name: &str, tested: &Film, reference: &Film) {
    let (tested, reference) = (Estimate::from_film(tested), Estimate::from_film(reference));
    ZTest::default()
        .compare(tested, reference, |_, _| true)
        .assert_matches(name, 0.99, 0.01);
}

#[test]
fn the_ray_query_form_gives_the_same_picture_and_is_built_again_for_an_edit() {
    let Some(device) = open_with_ray_queries() else {
        return;
    };
    let mut stack = renderer(&device, &room(), Form::Stack);
    let mut queries = renderer(&device, &room(), Form::RayQuery);
    assert_same_picture("ray queries", &film(&mut queries), &film(&mut stack));
    // The stack of our own traversal is not in it; the state of a path is.
    let inlined = private_bytes(&renderer(&device, &room(), Form::Inlined));
    assert!(private_bytes(&stack) < inlined);
    assert!(private_bytes(&queries) > 256);

    let edit = |renderer: &mut Renderer| {
        let before = device.counts().pipelines;
        renderer
            .edit_graph(|graph| graph.set_value("mask", "amount", Value::F32(0.9)))
            .unwrap_or_else(|error| panic!("{error}"));
        device.counts().pipelines - before
    };
    assert_eq!((edit(&mut stack), edit(&mut queries)), (0, 1));
    assert_same_picture(
        "ray queries, edited",
        &film(&mut queries),
        &film(&mut stack),
    );
}

/// Everything that decides whether a triangle is there for a ray: sides, mirrored instances, alpha, clear walls; and a
/// body of glass and a lamp, whose surfaces are met from both sides and at given distances.
fn hall(has_glass: bool) -> (Scene, Procedural) {
    let upright = |x: f32, z: f32| quad(Vec3::new(x, 0.0, z), Vec3::X, Vec3::Y);
    let away = |x: f32, z: f32| quad(Vec3::new(x + 1.0, 0.0, z), Vec3::NEG_X, Vec3::Y);
    let mut leaf = upright(-0.4, 1.6);
    leaf.colors = vec![
        Vec4::ONE,
        Vec4::new(1.0, 1.0, 1.0, 0.1),
        Vec4::ONE,
        Vec4::new(1.0, 1.0, 1.0, 0.3),
    ];
    let veil = Material {
        alpha_mode: AlphaMode::Blend,
        ..lambert(Vec3::new(0.1, 0.6, 0.1))
    };
    let cut = Material {
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        ..lambert(Vec3::new(0.6, 0.6, 0.1))
    };
    let mut cut_leaf = upright(0.7, 1.3);
    cut_leaf.colors.clone_from(&leaf.colors);
    let clear = Material {
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        ..lambert(Vec3::new(0.9, 0.6, 0.6))
    };
    let glass = Material {
        is_solid: true,
        specular: 1.0,
        ..clear.clone()
    };
    let mut scene = scene(
        [
            (floor(3.0), lambert(Vec3::splat(0.5))),
            // Seen from the front, and from the back, which isn't there.
            (upright(-1.6, 0.0), lambert(Vec3::new(0.7, 0.1, 0.1))),
            (away(-0.3, 0.6), lambert(Vec3::new(0.1, 0.1, 0.7))),
            (leaf, veil),
            (cut_leaf, cut),
            (
                quad(Vec3::new(0.2, 2.5, -0.5), Vec3::X, Vec3::Z),
                lamp(Vec3::splat(6.0)),
            ),
            (away(-1.9, 1.0), clear),
        ],
        Vec3::splat(0.4),
    );
    if has_glass {
        add(&mut scene, faceted_sphere(8), glass);
        let ball = scene.instances.last_mut().expect("it was just added");
        ball.transform = Affine3A::from_scale_rotation_translation(
            Vec3::new(0.5, 0.3, 0.4),
            Quat::from_rotation_z(0.5),
            Vec3::new(1.2, 0.6, 0.2),
        );
    }
    // The red wall once more, in a mirror.
    scene.instances.push(Instance {
        name: "mirrored".to_owned(),
        mesh: 1,
        transform: Affine3A::from_scale_rotation_translation(
            Vec3::new(-1.0, 1.2, 0.7),
            Quat::from_rotation_y(0.3),
            Vec3::new(0.2, 0.0, -0.8),
        ),
        asset: None,
    });
    let procedural = textured(&mut scene, "", &TextureSources::default());
    (scene, procedural)
}

#[test]
fn ray_queries_meet_what_the_traversal_kernel_meets() {
    let Some(device) = open_with_ray_queries() else {
        return;
    };
    // Rays pass the back of every triangle, or of all but those of the glass.
    for (name, has_glass) in [("single-sided", false), ("with glass", true)] {
        let hall = hall(has_glass);
        let mut passes = renderer(&device, &hall, Form::Stack);
        let mut queries = renderer(&device, &hall, Form::RayQuery);
        assert_same_picture(name, &film(&mut queries), &film(&mut passes));
    }
}

#[test]
fn a_driver_that_tells_registers_tells_them_of_every_form() {
    let Some(usual) = device::open() else { return };
    let inspection = Inspection::new(&usual, None);
    if let Some(reason) = inspection.absent() {
        eprintln!("skipped: {reason}");
        return;
    }
    // Kernels are compiled, none is run.
    let device = Device::open_with(&DeviceOptions::new(&DeviceChoice::Best).with_ray_queries())
        .unwrap_or_else(|error| panic!("{error}"));
    for form in Form::ALL {
        if form == Form::RayQuery && !device.has_ray_queries() {
            continue;
        }
        let said = inspection.of(&renderer(&device, &room(), form));
        eprintln!("{}: {:?}", form.name(), said.all);
        assert!(said.registers.is_some_and(|count| count >= 8.0));
    }
}
