//! What is seen directly: emission, unlit surfaces, and alpha as a mask and as coverage.

use engine::scene::{
    AlphaMode, Environment, Filter, Image, LightKind, Material, PunctualLight, Sampler, TextureRef,
    Wrap,
};
use glam::{Vec2, Vec3};

use super::assert_shows;
use crate::support::device;
use crate::support::scenes::{
    Shot, camera, floor, floor_point, from_above, lambert, lamp, quad, render, scene, unlit,
};

const SHOT: Shot = Shot {
    size: (16, 16),
    max_depth: 1,
    spp: 16,
};

/// Every pixel, to the last bit.
#[track_caller]
fn assert_is(film: &engine::film::Film, radiance: Vec3) {
    let expected = radiance.to_array();
    assert!(
        film.mean().iter().all(|&pixel| pixel == expected),
        "expected {expected:?}, the first pixel is {:?}",
        film.mean()[0]
    );
}

#[test]
fn emission_is_seen_as_it_was_set_and_from_the_front() {
    let Some(device) = device::open() else { return };
    // Sums of sixteen of them are exact.
    let radiance = Vec3::new(3.0, 0.25, 0.0625);
    let from_below = camera(
        Vec3::NEG_Y,
        Vec3::ZERO,
        Vec3::Z,
        engine::scene::Projection::Orthographic { y_mag: 1.0 },
    );
    let above = from_above(1.0, 1.0);
    let two_sided = Material {
        double_sided: true,
        ..lamp(radiance)
    };
    for (camera, material, seen) in [
        (&above, lamp(radiance), radiance),
        (&from_below, lamp(radiance), Vec3::ZERO),
        (&above, two_sided.clone(), radiance),
        (&from_below, two_sided, radiance),
    ] {
        let mut scene = scene([(floor(3.0), material)], Vec3::ZERO);
        assert_is(&render(&device, &mut scene, camera, SHOT), seen);
    }
}

#[test]
fn an_unlit_surface_shows_its_colour_whatever_lights_it() {
    let Some(device) = device::open() else { return };
    let color = Vec3::new(0.5, 0.25, 0.125);
    let mut scene = scene([(floor(3.0), unlit(color.extend(1.0)))], Vec3::splat(7.0));
    scene.lights.push(sun());
    assert_is(
        &render(&device, &mut scene, &from_above(1.0, 1.0), SHOT),
        color,
    );
}

fn sun() -> PunctualLight {
    PunctualLight {
        name: "sun".to_owned(),
        intensity: Vec3::new(3.0, 2.0, 1.0),
        position: Vec3::ZERO,
        direction: Vec3::NEG_Y,
        range: f32::INFINITY,
        kind: LightKind::Directional,
    }
}

fn blend(color: Vec3, alpha: f32) -> Material {
    Material {
        alpha_mode: AlphaMode::Blend,
        // Shadow rays come from below.
        double_sided: true,
        ..unlit(color.extend(alpha))
    }
}

#[test]
fn blended_surfaces_cover_by_their_alpha() {
    let Some(device) = device::open() else { return };
    let sky = Vec3::new(1.0, 2.0, 0.5);
    let (pane, other) = (Vec3::new(0.2, 0.4, 0.9), Vec3::new(0.1, 3.0, 0.3));
    let shot = Shot { spp: 1024, ..SHOT };
    let camera = from_above(1.0, 1.0);

    let mut one = scene([(floor(3.0), blend(pane, 0.3))], sky);
    let film = render(&device, &mut one, &camera, shot);
    let through_one = pane * 0.3 + sky * 0.7;
    assert_shows("one pane", &film, |_| through_one);

    // The second decides independently of the first.
    let mut below = floor(3.0);
    for position in &mut below.positions {
        position.y = -0.5;
    }
    let mut two = scene(
        [(floor(3.0), blend(pane, 0.3)), (below, blend(other, 0.6))],
        sky,
    );
    let film = render(&device, &mut two, &camera, shot);
    let through_two = pane * 0.3 + 0.7 * (other * 0.6 + sky * 0.4);
    assert_shows("two panes", &film, |_| through_two);
}

#[test]
fn a_blended_surface_lets_as_much_light_through_as_it_does_not_cover() {
    let Some(device) = device::open() else { return };
    let mut pane = quad(Vec3::new(-3.0, 1.0, 3.0), Vec3::X * 6.0, Vec3::NEG_Z * 6.0);
    pane.name = "pane".to_owned();
    let mut scene = scene(
        [
            (floor(3.0), lambert(Vec3::splat(0.5))),
            (pane, blend(Vec3::ZERO, 0.25)),
        ],
        Vec3::ZERO,
    );
    scene.lights.push(sun());
    let shot = Shot { spp: 512, ..SHOT };
    // From below the pane, so that only the shadow rays pass it.
    let film = render(&device, &mut scene, &from_above(0.5, 1.0), shot);
    let expected = sun().intensity * 0.5 / std::f32::consts::PI * 0.75;
    assert_shows("light through a pane", &film, |_| expected);
}

#[test]
fn a_mask_cuts_along_its_texels() {
    let Some(device) = device::open() else { return };
    // Four texels across the picture; those at or above the cutoff of one half are there.
    let alphas: [u8; 16] = [
        0, 255, 127, 128, //
        255, 0, 0, 255, //
        128, 128, 127, 127, //
        1, 254, 200, 100,
    ];
    let rgba8 = alphas.iter().flat_map(|&a| [255, 255, 255, a]).collect();
    let sky = Vec3::splat(2.0);
    let color = Vec3::new(0.5, 0.25, 0.125);
    let masked = Material {
        base_color_texture: Some(TextureRef {
            image: 0,
            uv_set: 0,
            sampler: Sampler {
                wrap_u: Wrap::Clamp,
                wrap_v: Wrap::Clamp,
                filter: Filter::Nearest,
            },
            transform: [Vec3::X, Vec3::Y],
        }),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        double_sided: true,
        ..unlit(color.extend(1.0))
    };
    // uv (0, 0) is the upper left corner of the picture and the image's.
    let sheet = quad(Vec3::new(-1.0, 0.0, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0);
    let mut scene = scene([(sheet, masked)], Vec3::ZERO);
    scene.environment = Environment::Constant(sky);
    scene.images.push(Image {
        name: "mask".to_owned(),
        width: 4,
        height: 4,
        rgba8: std::sync::Arc::new(rgba8),
        srgb: true,
    });
    let film = render(&device, &mut scene, &from_above(1.0, 1.0), SHOT);
    let expected = |picture: Vec2| {
        let p = floor_point(1.0, picture);
        let texel = (Vec2::new(p.x, p.z) + 1.0) * 2.0;
        let alpha = alphas[texel.y as usize * 4 + texel.x as usize];
        if alpha >= 128 { color } else { sky }
    };
    assert_shows("mask", &film, expected);
}
