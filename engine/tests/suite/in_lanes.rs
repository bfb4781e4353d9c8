//! Textures that are evaluated eight at a time give what they give one at a time, to the bit.

use std::path::Path;

use device::{Device, DeviceChoice};
use engine::evaluate::{Evaluator, Point};
use engine::isolated::{Isolated, Subject};
use engine::procedural::TextureSources;
use texgen::{ParameterType, TextureType};

use crate::support::scenes::{
    Shot, camera, faceted_sphere, floor, lambert, scene, settings, textured,
};

/// Surfaces with pixels of different sizes; neighbours differ much.
fn places() -> Vec<Point> {
    (0..200)
        .map(|i| {
            let at = i as f32;
            let wave = |k: f32| (at * k).sin();
            Point::new()
                .with(
                    "WorldPos",
                    &[3.0 * wave(0.7), 2.0 * wave(1.3), 4.0 * wave(2.1)],
                )
                .with("Normal", &[0.6, 0.8 * wave(9.0).signum(), 0.0])
                .with("ViewDir", &[0.0, 0.0, 1.0])
                .with("TexCoord0", &[2.0 * wave(0.9), 2.0 * wave(1.7)])
                .with("Footprint", &[10.0f32.powf(2.0 * wave(3.1) - 2.5); 4])
                .with("AO", &[0.5 + 0.5 * wave(0.3); 4])
                .with("Curvature", &[20.0 * wave(4.0); 4])
                .with("InstanceId", &[(i / 3) as f32; 4])
                .with("Time", &[at; 4])
        })
        .collect()
}

fn native() -> Device {
    let choice = DeviceChoice::Name("native".to_owned());
    Device::open(&choice).unwrap_or_else(|error| panic!("{error}"))
}

/// What isn't a number has many bits; it counts as one.
fn bits(values: &[[f32; 4]]) -> Vec<u32> {
    let bits = |x: &f32| {
        if x.is_nan() {
            f32::NAN.to_bits()
        } else {
            x.to_bits()
        }
    };
    values.iter().flatten().map(bits).collect()
}

#[test]
fn every_standard_texture_is_the_same_in_lanes() {
    if kernels::functions_in_lanes().is_empty() {
        eprintln!("skipped: nothing runs in lanes on this processor");
        return;
    }
    let (device, places) = (native(), places());
    let nowhere: [&Path; 0] = [];
    let sources = TextureSources::search(&nowhere).expect("nothing to list");
    for name in sources.names() {
        let file = sources.read(name).expect("is there").expect("is text");
        let texture = TextureType::parse(file).unwrap_or_else(|problems| panic!("{problems}"));
        let isolated = Isolated::new(Subject::Texture(name), &sources);
        let isolated = isolated.unwrap_or_else(|problems| panic!("{problems}"));
        let mut evaluator = Evaluator::new(&device, isolated);
        for parameter in texture.parameters() {
            if parameter.ty == ParameterType::Image {
                let image = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/images/demo.jpg");
                evaluator.set(&parameter.name, image).expect("an image");
            }
        }
        let before = device.counts().in_lanes;
        let mut values = || {
            let values = evaluator.evaluate(&places);
            bits(&values.unwrap_or_else(|error| panic!("{name}: {error}")))
        };
        let alone = values();
        device.finish_compiling();
        assert!(device.counts().in_lanes > before, "{name} isn't in lanes");
        assert!(values() == alone, "{name}");
    }
}

const LOOK: &str = r#"
    [ao.corners]
    distance = 0.4
    samples = 3

    [node.spots]
    texture = "voronoi"

    [node.rusty]
    texture = "rust"
    occlusion = "corners"

    [node.lines]
    texture = "scratches"
    scale = 3

    [material.paint]
    base_color = [0.2, 0.5, 0.8]
    roughness = "lines"
    bump = "lines"

    [material.metal]
    base_color = "rusty"
    metallic = "rusty.w"

    [material."material 0"]
    blend = { base = "metal", over = "paint", mask = "lines" }

    [material."material 1"]
    base_color = "rusty"
    opacity = "spots.cell"
"#;

#[test]
fn a_picture_is_the_same_in_lanes() {
    if kernels::functions_in_lanes().is_empty() {
        eprintln!("skipped: nothing runs in lanes on this processor");
        return;
    }
    let objects = [floor(4.0), faceted_sphere(12)].map(|mesh| (mesh, lambert(glam::Vec3::ONE)));
    let mut scene = scene(objects, glam::Vec3::ONE);
    let nowhere: [&Path; 0] = [];
    let sources = TextureSources::search(&nowhere).expect("nothing to list");
    let procedural = textured(&mut scene, LOOK, &sources);
    let view = camera(
        glam::Vec3::new(0.5, 2.0, 4.0),
        glam::Vec3::Y * 0.2,
        glam::Vec3::Y,
        engine::scene::Projection::Perspective { y_fov: 0.8 },
    );
    let shot = Shot {
        size: (40, 24),
        max_depth: 4,
        spp: 4,
    };
    let device = native();
    let mut films = [false, true].map(|waits| {
        let made =
            engine::renderer::Renderer::new(&device, &scene, &procedural, &settings(&view, shot));
        let mut renderer = made.unwrap_or_else(|error| panic!("{error}"));
        if waits {
            device.finish_compiling();
            assert!(device.counts().in_lanes > 0);
        }
        renderer.render(shot.spp).expect("the device renders");
        renderer.film().expect("the device reads")
    });
    let [alone, in_lanes] = &mut films;
    assert!(alone == in_lanes);
}
