//! Samples that go where the picture is noisiest: the same samples as ever, an error that is what it is said to be, and less of it.

use ::device::{Device, DeviceChoice};
use engine::adaptive::{Goal, next_round};
use engine::film::{Film, Layers};
use engine::procedural::Procedural;
use engine::renderer::{Lot, Renderer};
use engine::scene::{Material, Projection, Scene};
use engine::settings::RenderSettings;
use glam::Vec3;

use crate::support::device;
use crate::support::scenes::{
    Shot, camera, faceted_sphere, floor, lambert, lamp, no_textures, quad, render_with, scene,
    settings,
};

/// A metal ball that throws light on a floor, below a small lamp, seen from far away, under an even sky: most of the picture is
/// smooth, no multiple of eight pixels wide.
struct Ball {
    scene: Scene,
    procedural: Procedural,
    settings: RenderSettings,
}

fn ball(size: (u32, u32)) -> Ball {
    let metal = Material {
        roughness: 0.1,
        ..Material::default()
    };
    let lamp_above = quad(Vec3::new(-0.1, 3.0, -0.1), Vec3::X * 0.2, Vec3::Z * 0.2);
    let mut scene = scene(
        [
            (floor(30.0), lambert(Vec3::splat(0.5))),
            (faceted_sphere(24), metal),
            (lamp_above, lamp(Vec3::splat(60.0))),
        ],
        Vec3::new(0.2, 0.3, 0.4),
    );
    let camera = camera(
        Vec3::new(1.0, 4.0, 12.0),
        Vec3::Y * 0.5,
        Vec3::Y,
        Projection::Perspective { y_fov: 0.9 },
    );
    let shot = Shot {
        size,
        max_depth: 5,
        spp: 0,
    };
    let procedural = no_textures(&mut scene);
    let mut settings = settings(&camera, shot);
    settings.halves = true;
    Ball {
        scene,
        procedural,
        settings,
    }
}

impl Ball {
    fn renderer(&self, device: &Device, capacity: u32) -> Renderer {
        let (scene, procedural) = (&self.scene, &self.procedural);
        Renderer::with_capacity(device, scene, procedural, &self.settings, capacity)
            .expect("the scene renders")
    }

    fn adaptive(&self, device: &Device, goal: &Goal<'_>, capacity: u32) -> Film {
        let mut renderer = self.renderer(device, capacity);
        loop {
            let film = renderer.film().expect("the device reads");
            let round = next_round(&film, goal);
            if round.lots.is_empty() {
                return film;
            }
            for lot in &round.lots {
                render(&mut renderer, lot);
            }
        }
    }
}

fn render(renderer: &mut Renderer, lot: &Lot) {
    let mut from = 0;
    while from < lot.blocks.len() {
        from += renderer.render_lot(lot, from).expect("the device renders");
    }
}

fn squared_distance(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let squares = a.iter().flatten().zip(b.iter().flatten());
    let sum: f64 = squares.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    sum / (3 * a.len()) as f64
}

fn mean(picture: &[[f32; 3]]) -> f64 {
    let sum: f64 = picture.iter().flatten().map(|&x| f64::from(x)).sum();
    sum / (3 * picture.len()) as f64
}

#[test]
fn a_lot_of_everything_is_the_whole_picture() {
    let Some(device) = device::open() else { return };
    let mut ball = ball((83, 45));
    ball.settings.layers = Layers::named(["depth", "albedo", "crypto_object"]).expect("known");
    let mut whole = ball.renderer(&device, 4096);
    whole.render(64).expect("the device renders");
    let whole = whole.film().expect("the device reads");
    // In pieces, from the last block to the first, by waves of other sizes.
    let mut pieces = ball.renderer(&device, 640);
    for (first, samples) in [(0, 32), (32, 16), (48, 16)] {
        let blocks = (0..11 * 6).rev().map(|at| [at, first]).collect();
        let lot = Lot {
            blocks,
            samples,
            before: first,
        };
        render(&mut pieces, &lot);
    }
    assert!(pieces.film().expect("the device reads") == whole);
}

#[test]
fn the_picture_does_not_depend_on_how_waves_are_cut() {
    let Some(device) = device::open() else { return };
    let ball = ball((83, 45));
    let goal = Goal {
        error: Some(0.003),
        ..Goal::of_samples(160)
    };
    let films = [512, 1 << 14].map(|capacity| ball.adaptive(&device, &goal, capacity));
    let (fewest, most) = films[0].sample_bounds();
    assert!(
        fewest < most && fewest % 32 == 0 && most % 32 == 0,
        "{fewest} {most}"
    );
    assert!(films[0] == films[1]);
}

#[test]
fn samples_that_come_several_at_once_are_the_same_samples() {
    let Ok(device) = Device::open(&DeviceChoice::Native(1)) else {
        return; // no such processor
    };
    let mut ball = ball((83, 45));
    ball.settings.layers = Layers::all();
    let mut single = ball.renderer(&device, 4096);
    for spp in 1..=40 {
        single.render(spp).expect("the device renders");
    }
    let wanted = single.film().expect("the device reads");
    let mut several = ball.renderer(&device, 4096);
    let mut uneven = None;
    while !several.step(40).expect("the device renders").is_done() {
        let film = several.film().expect("the device reads");
        let (fewest, most) = film.sample_bounds();
        if most > fewest + 1 {
            uneven = Some((film, several.paths_done()));
        }
    }
    assert!(several.film().expect("the device reads") == wanted);
    // A film within such a burst says itself how far it is.
    let (film, paths) = uneven.expect("samples come several at once");
    for end in [40, 41] {
        let mut resumed = ball.renderer(&device, 640);
        resumed.resume(&film, paths).expect("the device writes");
        resumed.render(end).expect("the device renders");
        single.render(end).expect("the device renders");
        let wanted = single.film().expect("the device reads");
        assert!(resumed.film().expect("the device reads") == wanted);
    }
}

#[test]
fn the_error_is_what_it_is_said_to_be() {
    let Some(device) = device::open() else { return };
    let mut ball = ball((56, 40));
    ball.settings.halves = false;
    ball.settings.seed = 1000;
    let of_reference = |spp| {
        let (scene, procedural) = (&ball.scene, &ball.procedural);
        render_with(&device, scene, procedural, &ball.settings, spp)
    };
    let reference = of_reference(8192);
    let (brightness, rest) = (mean(&reference.mean()), reference.relative_error());
    let reference = reference.mean();
    ball.settings.halves = true;
    let goal = Goal {
        error: Some(0.01),
        ..Goal::of_samples(4096)
    };
    let (mut errors, mut claims, mut offsets) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..20 {
        ball.settings.seed = seed;
        let film = ball.adaptive(&device, &goal, 1 << 14);
        let picture = film.mean();
        errors.push(squared_distance(&picture, &reference) / brightness.powi(2) - rest.powi(2));
        claims.push(film.relative_error());
        offsets.push(mean(&picture) / brightness - 1.0);
    }
    let average = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    for (error, claim) in errors.iter().zip(&claims) {
        let ratio = error.max(0.0).sqrt() / claim;
        println!("claimed {claim:.4}, {ratio:.2} times that");
        assert!(*claim <= 0.01, "{claim}");
    }
    let ratio = average(&errors).sqrt() / average(&claims);
    assert!(
        (0.8..=1.2).contains(&ratio),
        "the error is {ratio} of what is claimed"
    );
    // Samples that decide how many there are lose little: a tenth of the error that is asked for at most.
    let mean_offset = average(&offsets);
    let spread = offsets
        .iter()
        .map(|x| (x - mean_offset).powi(2))
        .sum::<f64>()
        / 19.0;
    let z = mean_offset / (spread / 20.0 + (rest * rest) / (56.0 * 40.0)).sqrt();
    println!("mean off by {mean_offset:.6}, z {z:.2}");
    assert!(
        mean_offset.abs() < 0.001,
        "the mean is off by {mean_offset}, z {z}"
    );
}

#[test]
fn uneven_pictures_have_less_noise_for_as_many_samples() {
    let Some(device) = device::open() else { return };
    let mut ball = ball((112, 80));
    let goal = Goal::of_samples(128);
    let adaptive = ball.adaptive(&device, &goal, 1 << 14);
    ball.settings.seed = 5;
    let mut even = ball.renderer(&device, 1 << 14);
    even.render(128).expect("the device renders");
    let even = even.film().expect("the device reads");
    let samples = adaptive.mean_samples();
    assert!((110.0..=128.1).contains(&samples), "{samples}");
    let gain = (even.relative_error() / adaptive.relative_error()).powi(2);
    println!("as good as {gain:.2} times the samples");
    assert!(gain > 1.5, "{gain}");
}
