//! The tests' own statistics, tested on noise that is known: a judge must be right before it judges.

use std::panic::catch_unwind;
use std::path::Path;

use crate::support::estimate::{Estimate, read_exr};
use crate::support::normal::{Normal, two_sided_p_value};
use crate::support::stats::{Comparison, ZTest};
use crate::support::{maps, shared};

const WIDTH: usize = 200;
const HEIGHT: usize = 150;

/// A gradient with Gaussian noise of known size, all of it times `gain`.
fn noisy(seed: u64, error: f32, gain: f32) -> Estimate {
    let mut normal = Normal::new(seed);
    let mean = (0..WIDTH * HEIGHT).map(|i| {
        let radiance = 1.0 + (i % WIDTH) as f32 / WIDTH as f32;
        [0; 3].map(|_| gain * radiance + error * normal.sample() as f32)
    });
    Estimate {
        width: WIDTH,
        height: HEIGHT,
        mean: mean.collect(),
        error: vec![[error; 3]; WIDTH * HEIGHT],
    }
}

fn compare(tested: Estimate, reference: Estimate) -> Comparison {
    ZTest::default().compare(tested, reference, |_, _| true)
}

#[test]
fn p_values_are_those_of_the_normal_distribution() {
    for (z, p) in [
        (0.0, 1.0),
        (1.0, 0.317_310_507_862_9),
        (-1.959_963_985, 0.049_999_999_946_2),
        // Just below and above the point where the method changes.
        (3.5, 4.652_581_580_7e-4),
        (3.54, 4.001_270_320_1e-4),
        (6.0, 1.973_175_290_1e-9),
    ] {
        let relative = two_sided_p_value(z) / p - 1.0;
        assert!(relative.abs() < 1.0e-8, "z {z}: off by {relative}");
    }
}

#[test]
fn two_estimates_of_one_picture_match() {
    let comparison = compare(noisy(1, 0.1, 1.0), noisy(2, 0.02, 1.0));
    // Three channels at 4.65e-4 each: 99.86 % are expected; 30,000 pixels scatter by 0.02 %.
    assert!((comparison.passing_share() - 0.9986).abs() < 0.001);
    comparison.assert_matches("two estimates", 0.995, 0.005);
}

#[test]
fn errors_that_are_claimed_too_small_are_found() {
    let mut bold = noisy(1, 0.1, 1.0);
    for error in &mut bold.error {
        *error = [0.05; 3];
    }
    let comparison = compare(bold, noisy(2, 0.02, 1.0));
    assert!(comparison.passing_share() < 0.9);
}

#[test]
fn a_bias_hidden_in_every_pixels_noise_is_found_by_the_mean() {
    let comparison = compare(noisy(1, 0.1, 1.01), noisy(2, 0.02, 1.0));
    assert!(comparison.passing_share() > 0.995, "no pixel shows it");
    for ratio in comparison.mean_ratio() {
        assert!((ratio - 1.01).abs() < 0.002, "{ratio}");
    }
}

#[test]
fn a_wrong_region_fails_and_can_be_excluded() {
    let (mut wrong, reference) = (noisy(1, 0.1, 1.0), noisy(2, 0.02, 1.0));
    for y in 0..HEIGHT {
        for pixel in &mut wrong.mean[y * WIDTH..y * WIDTH + 20] {
            *pixel = [f32::NAN, 0.0, 5.0];
        }
    }
    let whole = compare(wrong.clone(), reference.clone());
    assert!((whole.passing_share() - 0.9).abs() < 0.01);
    let rest = ZTest::default().compare(wrong, reference, |x, _| x >= 20);
    rest.assert_matches("the rest", 0.995, 0.005);
}

#[test]
fn rounding_is_no_difference_where_there_is_no_noise() {
    let exact = |value: f32| Estimate {
        width: 1,
        height: 1,
        mean: vec![[value; 3]],
        error: vec![[0.0; 3]],
    };
    assert_eq!(compare(exact(1.0), exact(1.000_001)).passing_share(), 1.0);
    assert_eq!(compare(exact(0.0), exact(0.0)).passing_share(), 1.0);
    assert_eq!(compare(exact(1.0), exact(1.001)).passing_share(), 0.0);
    assert_eq!(compare(exact(f32::NAN), exact(1.0)).passing_share(), 0.0);
}

#[test]
fn a_failure_leaves_maps_to_look_at() {
    let comparison = compare(noisy(1, 0.1, 1.2), noisy(2, 0.02, 1.0));
    let failure = catch_unwind(|| comparison.assert_matches("statistics-self-test", 0.995, 0.005))
        .expect_err("20 % too bright must fail");
    let text = failure.downcast::<String>().expect("a message");
    assert!(text.contains("statistics-self-test"), "{text}");
    let dir = maps::write(&comparison, "statistics-self-test").expect("written before, too");
    for name in ["tested.png", "reference.png", "error.png", "p-value.png"] {
        let map = image::open(dir.join(name)).expect("a PNG");
        assert_eq!((map.width(), map.height()), (WIDTH as u32, HEIGHT as u32));
    }
    std::fs::remove_dir_all(dir).expect("this failure was made on purpose");
}

#[test]
fn a_film_is_an_estimate() {
    // Samples 1 and 3 in one pixel: mean 2, standard deviation sqrt(2), standard error 1.
    let mut film = engine::film::Film::new(1, 1);
    film.add_sample(0, [1.0; 3]);
    film.add_sample(0, [3.0; 3]);
    let estimate = Estimate::from_film(&film);
    assert_eq!(estimate.mean, [[2.0; 3]]);
    assert!((estimate.error[0][0] - 1.0).abs() < 1.0e-6);
}

#[test]
fn larger_pixels_are_means_with_the_error_of_means() {
    let fine = Estimate {
        width: 4,
        height: 2,
        mean: (0..8).map(|i| [i as f32, 2.0, 0.0]).collect(),
        error: vec![[0.2, 0.4, 0.0]; 8],
    };
    let coarse = fine.downsampled(2);
    assert_eq!((coarse.width, coarse.height), (2, 1));
    assert_eq!(coarse.mean, [[2.5, 2.0, 0.0], [4.5, 2.0, 0.0]]);
    // A mean of four has half the error.
    assert!((coarse.error[0][0] - 0.1).abs() < 1.0e-6);
    assert!((coarse.error[1][1] - 0.2).abs() < 1.0e-6);
}

#[test]
fn the_references_can_be_read_and_match_themselves() {
    let Some(dir) = shared::find("reference/cornell") else {
        return;
    };
    let reference = Estimate::from_exr(
        &dir.join("ref_mitsuba.exr"),
        &dir.join("ref_mitsuba_stderr.exr"),
    );
    assert_eq!((reference.width, reference.height), (512, 512));
    let (_, _, mean) = read_exr(&dir.join("ref_mitsuba.exr"));
    let red: f64 = mean.iter().map(|pixel| f64::from(pixel[0])).sum();
    // The figure in the reference's own ref_mitsuba.json.
    assert!((red / (512.0 * 512.0) - 0.294_539_77).abs() < 1.0e-5);
    compare(reference.clone(), reference).assert_matches("itself", 1.0, 0.0);
}

#[test]
#[should_panic(expected = "missing.exr")]
fn a_missing_reference_is_named() {
    read_exr(Path::new("missing.exr"));
}
