//! Pictures whose every pixel is known in closed form or by a quadrature written here, independently of the engine:
//! scenes built in code, rendered, and judged as statistics.

mod albedo;
mod aperture;
mod appearance;
mod convergence;
mod determinism;
mod direct;
mod disk;
mod environment;
mod estimators;
mod film_layers;
mod filters;
mod furnace;
pub(crate) mod light_layers;
mod light_mix;
mod non_finite;
mod seeds;
mod shadow_catcher;

use engine::film::Film;
use glam::{Vec2, Vec3};

use crate::support::estimate::Estimate;
use crate::support::stats::ZTest;

/// Share of the pixels that must pass, in all of their channels. Chance alone lets 99.86 % pass.
const PASSING: f64 = 0.995;
/// How far the mean of a channel may be off, relative.
const MEAN_ERROR: f64 = 0.005;

/// Fails the test `name` unless the film shows `radiance`, given by points of the picture in 0 to 1.
#[track_caller]
fn assert_shows(name: &str, film: &Film, radiance: impl Fn(Vec2) -> Vec3) {
    let exact = Estimate::exact((film.width, film.height), radiance);
    ZTest::default()
        .compare(Estimate::from_film(film), exact, |_, _| true)
        .assert_matches(name, PASSING, MEAN_ERROR);
}
