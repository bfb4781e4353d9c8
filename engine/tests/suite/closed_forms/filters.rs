//! Pixel filters: what a bright point spreads to, and that nothing else changes.

use engine::filter::PixelFilter;
use engine::renderer::RenderSettings;
use engine::scene::Scene;
use glam::{Vec2, Vec3};

use super::PASSING;
use crate::support::device;
use crate::support::estimate::Estimate;
use crate::support::scenes::{
    Shot, add, from_above, no_textures, quad, render_with, scene, settings, unlit,
};
use crate::support::stats::ZTest;

/// Pixels along a side of the picture, one metre each.
const SIDE: u32 = 7;

fn picture(
    device: &::device::Device,
    scene: &mut Scene,
    filter: PixelFilter,
    width: f32,
    spp: u32,
) -> engine::film::Film {
    let shot = Shot {
        size: (SIDE, SIDE),
        max_depth: 1,
        spp,
    };
    let settings = RenderSettings {
        filter,
        filter_width: width,
        ..settings(&from_above(1.0, 0.5 * SIDE as f32), shot)
    };
    let procedural = no_textures(scene);
    render_with(device, scene, &procedural, &settings, spp)
}

/// The filter's integral over a part of an axis, in pixels from the centre; the whole is 1.
fn share(filter: PixelFilter, width: f32, from: f32, to: f32) -> f64 {
    const STEPS: u32 = 4000;
    let value = |x: f64| match 2.0 * x.abs() / f64::from(width) {
        t if t <= 1.0 => filter.value(t),
        _ => 0.0,
    };
    let integral = |from: f64, to: f64| {
        let step = (to - from) / f64::from(STEPS);
        (0..STEPS)
            .map(|k| value(from + (f64::from(k) + 0.5) * step))
            .sum::<f64>()
            * step
    };
    let half = 0.5 * f64::from(width);
    integral(f64::from(from), f64::from(to)) / integral(-half, half)
}

#[test]
fn a_bright_square_spreads_as_the_filter_says() {
    let Some(device) = device::open() else { return };
    // Off the centre of the middle pixel; y of the picture is -z of the floor.
    let (low, high) = (Vec2::new(0.1, -0.3), Vec2::new(0.4, 0.2));
    for filter in PixelFilter::ALL {
        for width in [filter.default_width(), 2.5] {
            let mut scene = Scene::default();
            let size = high - low;
            let mesh = quad(
                Vec3::new(low.x, 0.0, high.y),
                Vec3::X * size.x,
                Vec3::NEG_Z * size.y,
            );
            add(&mut scene, mesh, unlit(glam::Vec4::ONE));
            let film = picture(&device, &mut scene, filter, width, 8192);
            let middle = SIDE as f32 * 0.5;
            let mean = |pixel: u32| {
                let center = Vec2::new((pixel % SIDE) as f32, (pixel / SIDE) as f32) + 0.5 - middle;
                let along = |axis: usize| {
                    share(
                        filter,
                        width,
                        low[axis] - center[axis],
                        high[axis] - center[axis],
                    )
                };
                [(along(0) * along(1)) as f32; 3]
            };
            let exact = Estimate {
                width: SIDE as usize,
                height: SIDE as usize,
                mean: (0..SIDE * SIDE).map(mean).collect(),
                // A pixel that sees little of the square may have met it by no sample: an error of half of one.
                error: vec![[6.0e-5; 3]; (SIDE * SIDE) as usize],
            };
            let name = format!("{} filter of {width}", filter.name());
            ZTest::default()
                .compare(Estimate::from_film(&film), exact, |_, _| true)
                .assert_matches(&name, PASSING, 0.01);
        }
    }
}

#[test]
fn an_even_picture_stays_even() {
    let Some(device) = device::open() else { return };
    for filter in PixelFilter::ALL {
        // Only the sky is seen: the floor is behind the camera.
        let roof = quad(Vec3::Y * 5.0, Vec3::X, Vec3::NEG_Z);
        let mut scene = scene([(roof, unlit(glam::Vec4::ONE))], Vec3::ONE);
        let film = picture(&device, &mut scene, filter, filter.default_width(), 1024);
        for mean in film.mean() {
            // Signed weights are 1 on average only.
            let tolerance = if filter == PixelFilter::Mitchell {
                0.02
            } else {
                0.0
            };
            assert!((mean[0] - 1.0).abs() <= tolerance, "{filter:?}: {mean:?}");
        }
        let all: f32 = film.mean().iter().map(|mean| mean[0]).sum();
        assert!(
            (all / (SIDE * SIDE) as f32 - 1.0).abs() < 0.003,
            "{filter:?}"
        );
    }
}
