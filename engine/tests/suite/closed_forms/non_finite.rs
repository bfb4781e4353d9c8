//! Values of textures that are not finite: whatever they drive, they are counted and their node is named.

use engine::procedural::TextureSources;
use engine::renderer::Renderer;
use engine::scene::{Material, Scene};
use engine::stats::{Doubt, NodeName, Stats};
use glam::Vec3;

use crate::support::device;
use crate::support::scenes::{
    Shot, floor, from_above, lambert, lamp, quad, scene, settings, textured,
};

const TEXTURES: [(&str, &str); 2] = [
    // On the left half of the floor.
    (
        "broken",
        "fn userProc(bits: u32) -> vec3f {
            return select(vec3f(0.5), vec3f(0.5, bitcast<f32>(bits), 0.5), readAttr(WorldPos).x < 0.0);
        }",
    ),
    (
        "reader",
        "fn userProc(color: vec3f) -> vec3f { return 2.0 * color; }",
    ),
];

fn room() -> Scene {
    let below = Material {
        name: "below".to_owned(),
        ..Material::default()
    };
    let above = quad(Vec3::new(-0.5, 3.0, -0.5), Vec3::X, Vec3::Z);
    let mut scene = scene(
        [
            (floor(2.0), lambert(Vec3::splat(0.5))),
            (above, lamp(Vec3::splat(6.0))),
        ],
        Vec3::splat(0.5),
    );
    scene.materials.push(below);
    scene
}

const SAMPLES: u32 = 4;

/// Figures of a picture of the floor, and the pixels that are black.
fn figures(device: &::device::Device, look: &str) -> (Stats, Vec<bool>) {
    let mut sources = TextureSources::default();
    for (name, text) in TEXTURES {
        sources.insert(name, text);
    }
    let mut scene = room();
    let procedural = textured(&mut scene, look, &sources);
    let shot = Shot {
        size: (16, 16),
        max_depth: 2,
        spp: SAMPLES,
    };
    let settings = settings(&from_above(2.0, 1.0), shot);
    let renderer = Renderer::new(device, &scene, &procedural, &settings);
    let mut renderer = renderer.unwrap_or_else(|error| panic!("{error}"));
    let mut render = || -> Result<_, engine::renderer::RenderError> {
        renderer.render(SAMPLES)?;
        let (stats, film) = (renderer.stats()?, renderer.film()?);
        // What was wrong with a picture is not wrong with the next one.
        renderer.restart();
        assert!(renderer.stats()?.doubts().is_empty());
        renderer.render(1)?;
        renderer.resize(8, 8)?;
        assert!(renderer.stats()?.doubts().is_empty());
        Ok((stats, film))
    };
    let (stats, film) = render().unwrap_or_else(|error| panic!("{error}"));
    let mean = film.mean();
    assert!(mean.iter().flatten().all(|value| value.is_finite()));
    (stats, mean.iter().map(|rgb| *rgb == [0.0; 3]).collect())
}

#[test]
fn values_that_are_not_finite_are_counted_and_named_whatever_they_drive() {
    let Some(device) = device::open() else { return };
    let nodes = |bits: u32| {
        format!(
            "[node.culprit]\ntexture='broken'\nbits={bits}\n[node.innocent]\ntexture='reader'\ncolor='culprit'\n"
        )
    };
    let drives = [
        "base_color='innocent'",
        "metallic='innocent.y'",
        "roughness='innocent.y'",
        "emission='innocent'",
        "emission='#ffffff'\nemission_strength='innocent.y'",
        "opacity='innocent.y'",
        "normal='innocent'",
        "bump='innocent.y'",
        "coat='innocent.y'",
        "anisotropy_rotation='innocent.y'",
        "blend={ base='material 0', over='below', mask='innocent.y' }",
    ];
    for drive in drives {
        for (name, bits) in [("NaN", 0x7fc0_0000), ("infinity", 0x7f80_0000)] {
            let look = format!("{}[material.'material 0']\n{drive}\n", nodes(bits));
            let (stats, is_black) = figures(&device, &look);
            let what = format!("{name}: {drive}: {stats:?}");
            // The camera alone finds as many as half of the samples.
            let half = u64::from(16 * 16 * SAMPLES / 2);
            assert!(stats.non_finite_hits >= half, "{what}");
            assert!(stats.invalid_samples >= half, "{what}");
            let culprit = NodeName {
                node: "culprit".to_owned(),
                texture: "broken".to_owned(),
            };
            assert_eq!(stats.non_finite_node, Some(culprit), "{what}");
            assert!(
                matches!(stats.doubts()[..], [Doubt::NonFinite(..)]),
                "{what}"
            );
            let left = is_black.iter().enumerate().filter(|(i, _)| i % 16 < 8);
            assert!(left.into_iter().all(|(_, &black)| black), "{what}");
            assert!(is_black.iter().any(|black| !black), "{what}");
        }
    }
}

#[test]
fn values_that_drive_nothing_do_no_harm() {
    let Some(device) = device::open() else { return };
    let look = "[node.culprit]\ntexture='broken'\nbits=0x7fc00000\n[material.'material 0']\nroughness='culprit.x'\n";
    let (stats, _) = figures(&device, look);
    assert_eq!((stats.non_finite_hits, stats.invalid_samples), (0, 0));
    assert!(stats.doubts().is_empty(), "{:?}", stats.doubts());
}
