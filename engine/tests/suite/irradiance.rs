//! Records of irradiance: what is interpolated between them is what paths find, nearly, and without their noise.

use std::sync::Arc;

use ::device::{Device, DeviceChoice};
use engine::film::Layers;
use engine::fleet::{Fleet, Plan};
use engine::renderer::{Lot, Renderer};
use engine::scene::{Environment, FloatImage, Material, Projection, Scene};
use engine::settings::{Estimator, Method, RenderSettings};
use engine::system::System;
use glam::Vec3;

use crate::light_cache::{film, mean, room, seen};
use crate::support::device;
use crate::support::scenes::{Shot, camera, lambert, lamp, no_textures, quad, scene, settings};

/// So many paths go ahead where it doesn't matter how right records are.
const FEW: u32 = 1 << 15;

#[test]
fn a_room_is_nearly_right_and_far_less_noisy() {
    let Some(device) = device::open() else { return };
    let size = (48, 36);
    let reference = device::open_for_reference();
    let right = film(&reference, room(), &seen(size, 7, Method::Path), 4096);
    let [path, cache] = [(Method::Path, 256), (Method::Cache, 32)].map(|(method, spp)| {
        let film = film(&device, room(), &seen(size, 1, method), spp);
        let (found, wanted) = (mean(&film), mean(&right));
        let off = (found / wanted - 1.0).abs().max_element();
        let right = right.mean();
        let apart = film.mean().into_iter().zip(right);
        let squares: f32 = apart
            .map(|(a, b)| (Vec3::from(a) - Vec3::from(b)).length_squared())
            .sum();
        println!(
            "{} with {spp} samples: mean off by {off:.4}, squared error {squares:.4}",
            method.name()
        );
        (off, squares)
    });
    assert!(cache.0 < 0.03, "the mean is off by {}", cache.0);
    // An eighth of the samples.
    assert!(cache.1 < path.1, "{} and {}", cache.1, path.1);
}

/// A flat triangle stops what comes from below it, whichever way its corners' normals lean.
#[test]
fn flat_triangles_whose_normals_lean_get_what_is_above_them() {
    let Some(device) = device::open() else { return };
    let leaning = || {
        let mut scene = room();
        // The floor, as cards of foliage have them.
        let floor = &mut scene.meshes[0];
        floor.normals = vec![Vec3::new(1.0, 1.2, 0.0).normalize(); floor.positions.len()];
        scene
    };
    let settings = |method| seen((48, 36), 3, method);
    let reference = device::open_for_reference();
    let right = mean(&film(&reference, leaning(), &settings(Method::Path), 2048));
    let found = mean(&film(&device, leaning(), &settings(Method::Cache), 256));
    let off = (found / right - 1.0).abs().max_element();
    println!("{found} is {off:.4} off {right}");
    assert!(off < 0.015, "{found} is not {right}");
}

/// Paths that teach end in what others have found that have scattered as often as they may, though they have scattered more often by then.
#[test]
fn light_is_scattered_as_often_as_it_may() {
    let Some(device) = device::open() else { return };
    for max_depth in [2, 4, 6, 9] {
        let settings = |method| RenderSettings {
            max_depth,
            ..seen((32, 24), 3, method)
        };
        let reference = device::open_for_reference();
        let right = mean(&film(&reference, room(), &settings(Method::Path), 2048));
        let found = mean(&film(&device, room(), &settings(Method::Cache), 256));
        let off = (found / right - 1.0).abs().max_element();
        println!("{max_depth} at most: {found} is {off:.4} off {right}");
        assert!(off < 0.02, "{max_depth} at most: {found} is not {right}");
    }
}

/// A white wall in the sky's light beside a floor that sees much of the wall: near the wall its light changes steeply.
#[test]
fn beside_a_wall_gradients_follow_the_light() {
    let Some(device) = device::open() else { return };
    let wall = Material {
        double_sided: true,
        ..lambert(Vec3::ONE)
    };
    let black = Material {
        double_sided: true,
        ..lambert(Vec3::ZERO)
    };
    let floor = lambert(Vec3::splat(0.5));
    // A black wall stands across.
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    let scene_of = || {
        scene(
            [
                (quad(-x * 50.0, x * 100.0, y * 1.0), wall.clone()),
                (quad(-x * 2.0 + z * 0.05, z * 0.9, x * 4.0), floor.clone()),
                (quad(-x * 50.0 + z * 1.0, x * 100.0, y * 1.0), black.clone()),
            ],
            Vec3::ONE,
        )
    };
    let camera = camera(
        Vec3::new(0.0, 0.9, 0.5),
        Vec3::new(0.0, 0.0, 0.5),
        Vec3::Z,
        Projection::Perspective { y_fov: 0.9 },
    );
    let shot = Shot {
        size: (48, 48),
        max_depth: 4,
        spp: 0,
    };
    let mut wanted = settings(&camera, shot);
    let right = film(&device::open_for_reference(), scene_of(), &wanted, 4096);
    wanted.method = Method::Cache;
    let found = film(&device, scene_of(), &wanted, 256);
    let rows = |film: &engine::film::Film| -> Vec<f32> {
        let means = film.mean();
        let row = |y: usize| (8..40).map(|x| means[y * 48 + x][0]).sum::<f32>() / 32.0;
        (4..44).map(row).collect()
    };
    for (row, (found, right)) in rows(&found).into_iter().zip(rows(&right)).enumerate() {
        assert!(
            (found / right - 1.0).abs() < 0.03,
            "row {row}: {found} is not {right}"
        );
    }
}

/// A floor in the light that a lamp throws on the ceiling: brightest in the middle, and bent downwards everywhere. Gradients of records alone
/// would make it 1.3 % too bright.
#[test]
fn light_that_bends_is_right_between_records() {
    let Some(device) = device::open() else { return };
    let white = Material {
        double_sided: true,
        ..lambert(Vec3::splat(0.8))
    };
    let (x, y) = (Vec3::X, Vec3::Y);
    let corner = -2.0 * (x + y);
    let room = scene(
        [
            (quad(corner, x * 4.0, y * 4.0), white.clone()),
            (quad(corner + Vec3::Z * 2.0, x * 4.0, y * 4.0), white),
            (
                quad(0.2 * corner + Vec3::Z * 1.5, x * 0.8, y * 0.8),
                lamp(Vec3::splat(6.0)),
            ),
        ],
        Vec3::ZERO,
    );
    let camera = camera(
        Vec3::new(0.0, 0.0, 1.4),
        Vec3::ZERO,
        Vec3::Y,
        Projection::Perspective { y_fov: 0.6 },
    );
    let shot = Shot {
        size: (40, 40),
        max_depth: 6,
        spp: 0,
    };
    let of = |device: &Device, method, spp| {
        let settings = RenderSettings {
            method,
            paths_ahead: 1 << 18,
            ..settings(&camera, shot)
        };
        mean(&film(device, room.clone(), &settings, spp)).x
    };
    let right = of(&device::open_for_reference(), Method::Path, 2048);
    let found = of(&device, Method::Cache, 64);
    let off = found / right - 1.0;
    println!("{found} where {right} is right: {off:.4}");
    assert!(off.abs() < 0.007, "{found} is {off} off {right}");
}

/// Of parts, of a render that goes on, and of several devices each makes the cache for itself: the same one, which grows at the same
/// samples.
#[test]
fn a_picture_that_is_divided_is_the_same() {
    let Some(device) = device::open() else { return };
    let cases = [
        (Method::Draft, 0),
        (Method::Cache, 0),
        (Method::Photons, 0),
        (Method::CachePhotons, 0),
        (Method::Draft, 1021),
        (Method::Cache, 1021),
        (Method::CachePhotons, 1021),
    ];
    for (method, first_sample) in cases {
        let mut scene = room();
        let procedural = no_textures(&mut scene);
        let settings = RenderSettings {
            paths_ahead: FEW,
            first_sample,
            ..seen((40, 24), 3, method)
        };
        let renderer = |settings: &RenderSettings| {
            let renderer = Renderer::new(&device, &scene, &procedural, settings);
            renderer.expect("the scene renders")
        };
        let name = format!("{} from sample {first_sample}", method.name());
        let whole = film(&device, room(), &settings, 6);
        let mut sum = film(&device, room(), &settings, 2);
        let rest = RenderSettings {
            first_sample: first_sample + 2,
            ..settings.clone()
        };
        sum.add(&film(&device, room(), &rest, 4));
        assert!(sum == whole, "{name}: parts");
        let mut first = renderer(&settings);
        first.render(2).expect("the device renders");
        let (begun, paths) = (first.film().expect("it reads"), first.paths_done());
        let mut second = renderer(&settings);
        second.resume(&begun, paths).expect("it goes on");
        second.render(6).expect("the device renders");
        let same = second.film().expect("the device reads") == whole;
        assert!(same, "{name}: goes on");
        let mut turned = renderer(&settings);
        let paths = turned.paths_per_sample();
        for range in [4 * paths..6 * paths, 0..4 * paths] {
            let mut from = range.start;
            while from < range.end {
                from += turned.render_paths(from..range.end).expect("it renders");
            }
        }
        let same = turned.film().expect("the device reads") == whole;
        assert!(same, "{name}: its end first");
        let plan = Plan {
            scene: Arc::new(scene.clone()),
            procedural: Arc::new(procedural.clone()),
            settings: settings.clone(),
            spp: 6,
            times_passes: false,
            system: System::default(),
        };
        let native = || Device::open(&DeviceChoice::Native(1)).expect("processors are there");
        let devices = [native(), native()];
        let fleet = Fleet::start(&plan, devices.iter().map(|device| plan.recruit(device)));
        let together = fleet.outcome().film;
        fleet.join();
        let mut alone =
            Renderer::new(&devices[0], &scene, &procedural, &settings).expect("renders");
        alone.render(6).expect("the device renders");
        let same = alone.film().expect("the device reads") == together;
        assert!(same, "{name}: two devices");
    }
}

/// What pixels share of the noise falls as a picture gets more samples: the later of them know more.
#[test]
fn noise_of_records_falls_with_the_samples() {
    let Some(device) = device::open() else { return };
    let size = (48, 36);
    // Mean squared difference of two pictures, by means of 12 x 12 pixels, whose own noise is small.
    let [early, late] = [0, 8192].map(|first_sample| {
        let [a, b] = [1, 2].map(|seed| {
            let settings = RenderSettings {
                paths_ahead: FEW,
                first_sample,
                ..seen(size, seed, Method::Cache)
            };
            film(&device, room(), &settings, 128).mean()
        });
        let block = |pixels: &[[f32; 3]], x: usize, y: usize| -> Vec3 {
            let all = (0..144).map(|i| pixels[(12 * y + i / 12) * 48 + 12 * x + i % 12]);
            all.map(Vec3::from).sum::<Vec3>() / 144.0
        };
        let blocks = (0..12).map(|i| (i % 4, i / 4));
        let squares = blocks.map(|(x, y)| block(&a, x, y).distance_squared(block(&b, x, y)));
        squares.sum::<f32>()
    });
    println!("{early} early, {late} late");
    assert!(late < 0.5 * early, "{late} is not much less than {early}");
}

/// Samples' two halves know nothing of each other's light: what they differ by is all the noise of a picture, that of caches as well.
#[test]
fn halves_differ_by_the_noise_of_caches_too() {
    let Some(device) = device::open() else { return };
    let (width, size) = (48, (48, 36));
    // By means of 12 x 12 pixels, whose own noise is small.
    let block = |pixels: &[Vec3], x: usize, y: usize| -> Vec3 {
        let all = (0..144).map(|i| pixels[(12 * y + i / 12) * width + 12 * x + i % 12]);
        all.sum::<Vec3>() / 144.0
    };
    let blocks = || (0..12).map(|i| (i % 4, i / 4));
    for method in [Method::Draft, Method::Cache] {
        let (mut told, mut sums, mut squares) = (0.0, [Vec3::ZERO; 12], 0.0);
        // A few records by chance have most of it, so that 20 pictures may differ by as much as a factor of two.
        let seeds = 40;
        for seed in 0..seeds {
            let settings = RenderSettings {
                paths_ahead: 1 << 13,
                halves: true,
                ..seen(size, seed, method)
            };
            let film = film(&device, room(), &settings, 32);
            let means = (0..film.pixels()).map(|pixel| film.half_means(pixel).expect("halves"));
            let [first, second]: [Vec<Vec3>; 2] = means
                .map(|halves| halves.map(|half| Vec3::from(half.map(|x| x as f32))))
                .map(|[first, second]| (first, second))
                .unzip::<_, _, Vec<_>, Vec<_>>()
                .into();
            for (i, (x, y)) in blocks().enumerate() {
                let [one, other] = [&first, &second].map(|half| block(half, x, y));
                told += (0.5 * (one - other)).length_squared();
                let mean = 0.5 * (one + other);
                sums[i] += mean;
                squares += mean.length_squared();
            }
        }
        let of_means: f32 = sums.iter().map(|sum| sum.length_squared()).sum();
        let strays = (squares - of_means / seeds as f32) / (seeds - 1) as f32;
        let told = told / seeds as f32;
        println!("{}: {told} told, {strays} there", method.name());
        assert!(
            (0.6..1.6).contains(&(told / strays)),
            "{told} is not {strays}"
        );
    }
}

/// Samples may go where they are needed, with a cache as without.
#[test]
fn blocks_get_their_samples_with_a_cache_too() {
    let Some(device) = device::open() else { return };
    let mut scene = room();
    let procedural = no_textures(&mut scene);
    let settings = RenderSettings {
        halves: true,
        paths_ahead: FEW,
        ..seen((40, 24), 3, Method::Cache)
    };
    let even = film(&device, room(), &settings, 32);
    let renderer = Renderer::new(&device, &scene, &procedural, &settings);
    let mut renderer = renderer.expect("the scene renders");
    for samples in [0..16, 16..32] {
        let lot = Lot {
            blocks: (0..15).map(|at| [at, samples.start]).collect(),
            samples: samples.len() as u32,
            before: samples.start,
        };
        let mut from = 0;
        while from < lot.blocks.len() {
            from += renderer.render_lot(&lot, from).expect("it renders");
        }
    }
    assert!(renderer.film().expect("the device reads") == even);
}

/// A render may be ended before the cache is there.
#[test]
fn until_the_cache_is_made_the_picture_is_one_of_paths() {
    let Some(device) = device::open() else { return };
    let mut scene = room();
    let procedural = no_textures(&mut scene);
    let settings = RenderSettings {
        paths_ahead: 2 * FEW,
        ..seen((48, 36), 3, Method::Cache)
    };
    let renderer = Renderer::new(&device, &scene, &procedural, &settings);
    let mut renderer = renderer.expect("the scene renders");
    while renderer.irradiance_records() == 0 {
        renderer.step(16).expect("the device renders");
    }
    assert!(renderer.is_preview());
    let early = renderer.film().expect("the device reads");
    let (least, most) = early.sample_bounds();
    assert!(least == most && least >= 8, "{least} to {most}");
    let reference = device::open_for_reference();
    let right = film(&reference, room(), &seen((48, 36), 7, Method::Path), 512);
    let off = (mean(&early) / mean(&right) - 1.0).abs().max_element();
    assert!(off < 0.1, "the mean is off by {off}");
    // None of that is the picture's.
    renderer.render(4).expect("the device renders");
    assert!(!renderer.is_preview());
    let begun = renderer.film().expect("the device reads");
    assert_eq!(begun.sample_bounds(), (4, 4));
}

#[test]
fn the_picture_does_not_depend_on_how_waves_are_cut() {
    let Some(device) = device::open() else { return };
    let films = [512, 1 << 13].map(|capacity| {
        let mut scene = room();
        let procedural = no_textures(&mut scene);
        let mut settings = seen((40, 24), 3, Method::Cache);
        settings.paths_ahead = FEW;
        settings.layers = Layers::named(["albedo"]).expect("known");
        let renderer = Renderer::with_capacity(&device, &scene, &procedural, &settings, capacity);
        let mut renderer = renderer.expect("the scene renders");
        renderer.render(4).expect("the device renders");
        // An edit of the camera forgets all records.
        renderer.set_camera(&settings.camera);
        renderer.render(8).expect("the device renders");
        assert!(renderer.irradiance_records() > 0);
        renderer.film().expect("the device reads")
    });
    assert!(films[0] == films[1]);
}

/// A box of 4 metres, open by so much in a corner of its wall at x = 2, under a sky that is twice as bright on one side and has a sun which
/// misses the window.
pub(crate) fn room_with_window(wide: f32, high: f32) -> Scene {
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    let wall = Material {
        double_sided: true,
        ..lambert(Vec3::splat(0.5))
    };
    let quads = [
        quad(-x * 2.0 - y * 2.0 - z * 2.0, x * 4.0, z * 4.0),
        quad(-x * 2.0 + y * 2.0 - z * 2.0, x * 4.0, z * 4.0),
        quad(-x * 2.0 - y * 2.0 - z * 2.0, y * 4.0, z * 4.0),
        quad(-x * 2.0 - y * 2.0 - z * 2.0, x * 4.0, y * 4.0),
        quad(-x * 2.0 - y * 2.0 + z * 2.0, x * 4.0, y * 4.0),
        quad(x * 2.0 - y * 2.0 - z * 2.0, y * 4.0, z * (4.0 - wide)),
        quad(
            x * 2.0 - y * 2.0 + z * (2.0 - wide),
            y * (4.0 - high),
            z * wide,
        ),
    ];
    let mut scene = scene(quads.map(|quad| (quad, wall.clone())), Vec3::ONE);
    let mut sky = FloatImage {
        width: 64,
        height: 32,
        rgb: vec![[1.0; 3]; 64 * 32],
    };
    for (i, texel) in sky.rgb.iter_mut().enumerate() {
        if i % 64 < 24 {
            *texel = [2.0; 3];
        }
    }
    sky.rgb[5 * 64 + 3] = [400.0; 3];
    scene.environment = Environment::Image {
        image: std::sync::Arc::new(sky),
        rotation: 30.0,
        intensity: 1.0,
    };
    scene
}

/// How it is seen from the wall across.
pub(crate) fn seen_in_room(max_depth: u32) -> RenderSettings {
    let camera = camera(
        Vec3::new(-1.8, 0.0, 1.2),
        Vec3::new(1.0, 0.0, -1.0),
        Vec3::Y,
        Projection::Perspective { y_fov: 1.2 },
    );
    let shot = Shot {
        size: (32, 32),
        max_depth,
        spp: 0,
    };
    RenderSettings {
        paths_ahead: 8 * FEW,
        ..settings(&camera, shot)
    }
}

/// Where the sky is seen through a window alone, light samples learn to go there: what they bring on average stays the same.
#[test]
fn a_sky_behind_a_window_is_found_sooner_and_is_as_bright() {
    let Some(device) = device::open() else { return };
    // Only light that one surface has scattered: no record has a share in it.
    let of = |device: &Device, method: Method, seed: u32, spp: u32| {
        let wanted = RenderSettings {
            method,
            seed,
            ..seen_in_room(1)
        };
        film(device, room_with_window(1.0, 1.0), &wanted, spp)
    };
    let right = of(&device::open_for_reference(), Method::Path, 7, 8192);
    let errors = [Method::Path, Method::Cache].map(|method| {
        let found = of(&device, method, 1, 512);
        let off = (mean(&found) / mean(&right) - 1.0).abs().max_element();
        let squares: f32 = (found.mean().into_iter().zip(right.mean()))
            .map(|(a, b)| (Vec3::from(a) - Vec3::from(b)).length_squared())
            .sum();
        println!(
            "{}: mean off by {off:.4}, squared error {squares:.4}",
            method.name()
        );
        assert!(off < 0.02, "{}: the mean is off by {off}", method.name());
        squares
    });
    assert!(2.0 * errors[1] < errors[0], "{errors:?}");
}

/// Of rays that only have to find the sky few go on where records are; what they find, and light samples, count for as much more.
#[test]
fn few_rays_to_the_sky_find_as_much() {
    let Some(device) = device::open() else { return };
    for max_depth in [1, 3] {
        let of = |device: &Device, method: Method, estimator: Estimator, spp: u32| {
            let wanted = RenderSettings {
                method,
                estimator,
                seed: spp,
                ..seen_in_room(max_depth)
            };
            mean(&film(device, room_with_window(3.0, 3.0), &wanted, spp))
        };
        let reference = device::open_for_reference();
        let right = of(&reference, Method::Path, Estimator::Mis, 4096);
        for estimator in Estimator::ALL {
            let found = of(&device, Method::Cache, estimator, 1024);
            let off = (found / right - 1.0).abs().max_element();
            let name = estimator.name();
            println!("{name}, {max_depth} at most: {found} is {off:.4} off {right}");
            assert!(
                off < 0.02,
                "{name}, {max_depth} at most: {found} is not {right}"
            );
        }
    }
}
