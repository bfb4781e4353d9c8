//! A part of a picture has the samples that the whole has there, to the last bit.

use ::device::Device;
use engine::film::{Crop, Film, Layers};
use engine::filter::PixelFilter;
use engine::renderer::{RenderError, RenderSettings, Renderer};
use engine::scene::{Material, Projection, Scene};
use glam::Vec3;

use crate::support::device;
use crate::support::scenes::{
    Shot, camera, faceted_sphere, floor, lambert, no_textures, scene, settings,
};

const SIZE: (u32, u32) = (45, 37);
const SPP: u32 = 3;

/// A sphere on a floor, and how it is seen: perspective and lens, or in parallel.
fn view(projection: Projection) -> (Scene, RenderSettings) {
    let shiny = Material {
        roughness: 0.3,
        ..Material::default()
    };
    let bodies = [
        (floor(4.0), lambert(Vec3::splat(0.7))),
        (faceted_sphere(8), shiny),
    ];
    let scene = scene(bodies, Vec3::new(0.3, 0.5, 0.9));
    let mut camera = camera(Vec3::new(0.5, 2.0, 5.0), Vec3::Y * 0.3, Vec3::Y, projection);
    camera.aperture_radius = 0.05;
    camera.focus_distance = 5.0;
    let shot = Shot {
        size: SIZE,
        max_depth: 3,
        spp: SPP,
    };
    let mut settings = settings(&camera, shot);
    settings.filter = PixelFilter::Gaussian;
    settings.filter_width = 3.0;
    settings.layers = Layers::named(["depth", "normal"]).expect("there are such layers");
    (scene, settings)
}

fn render(
    device: &Device,
    mut scene: Scene,
    settings: &RenderSettings,
) -> Result<Film, RenderError> {
    let procedural = no_textures(&mut scene);
    let mut renderer = Renderer::new(device, &scene, &procedural, settings)?;
    renderer.render(SPP)?;
    renderer.film()
}

fn part_of(settings: &RenderSettings, [left, top, width, height]: [u32; 4]) -> RenderSettings {
    let whole = [settings.width, settings.height];
    RenderSettings {
        width,
        height,
        crop: Some(Crop { left, top, whole }),
        ..settings.clone()
    }
}

#[test]
fn a_part_has_the_samples_of_the_whole() {
    let Some(device) = device::open() else {
        return;
    };
    for projection in [
        Projection::Perspective { y_fov: 0.9 },
        Projection::Orthographic { y_mag: 1.5 },
    ] {
        let (scene, settings) = view(projection);
        let whole =
            render(&device, scene.clone(), &settings).unwrap_or_else(|error| panic!("{error}"));
        // At an edge of blocks, within one, up to the last pixel, and all of it.
        for window in [
            [8, 16, 8, 8],
            [13, 3, 21, 30],
            [44, 36, 1, 1],
            [0, 0, SIZE.0, SIZE.1],
        ] {
            let part = render(&device, scene.clone(), &part_of(&settings, window));
            let part = part.unwrap_or_else(|error| panic!("{error}"));
            let [left, top, width, height] = window;
            assert_eq!((part.width, part.height), (width, height));
            assert_eq!(part.sample_bounds(), (SPP, SPP));
            for pixel in 0..part.pixels() {
                let (x, y) = (left + pixel as u32 % width, top + pixel as u32 / width);
                let there = (y * whole.width + x) as usize;
                let sums = |film: &Film, at| (film.sum(at), film.sum_squares(at));
                assert_eq!(
                    sums(&part, pixel),
                    sums(&whole, there),
                    "{window:?} {x} {y}"
                );
                for layer in settings.layers.iter() {
                    let of = |film: &Film| film.values(layer).expect("it is gathered");
                    assert_eq!(
                        of(&part)[pixel],
                        of(&whole)[there],
                        "{} {x} {y}",
                        layer.name
                    );
                }
            }
        }
    }
}

#[test]
fn one_renderer_goes_from_part_to_part() {
    let Some(device) = device::open() else {
        return;
    };
    let (mut scene, settings) = view(Projection::Perspective { y_fov: 0.9 });
    let procedural = no_textures(&mut scene);
    let windows = [
        [0, 0, 45, 16],
        [0, 16, 45, 16],
        [0, 32, 45, 5],
        [0, 0, 45, 37],
    ];
    let first = part_of(&settings, windows[0]);
    let mut renderer = Renderer::new(&device, &scene, &procedural, &first)
        .unwrap_or_else(|error| panic!("{error}"));
    // Back to a smaller one that has been there, too.
    for window in windows.into_iter().chain([windows[1]]) {
        let part = part_of(&settings, window);
        let [_, _, width, height] = window;
        let beyond = Some(Crop {
            left: 1,
            ..part.crop.expect("a part")
        });
        assert!(renderer.set_part([width, height], beyond).is_err());
        let went = renderer.set_part([width, height], part.crop);
        went.and_then(|()| renderer.render(SPP))
            .unwrap_or_else(|error| panic!("{error}"));
        let film = renderer.film().unwrap_or_else(|error| panic!("{error}"));
        let fresh = render(&device, scene.clone(), &part);
        let fresh = fresh.unwrap_or_else(|error| panic!("{error}"));
        assert!(film == fresh, "{window:?}");
    }
}

#[test]
fn what_lies_outside_is_refused() {
    let Some(device) = device::open() else {
        return;
    };
    let (scene, settings) = view(Projection::Perspective { y_fov: 0.9 });
    for window in [[40, 0, 6, 1], [0, 37, 1, 1], [u32::MAX, 0, 2, 2]] {
        let refused = render(&device, scene.clone(), &part_of(&settings, window));
        assert!(
            matches!(refused, Err(RenderError::Crop { .. })),
            "{window:?}"
        );
    }
}
