//! Looks that are rendered in turn, A B C A B C, so that a machine that slows down slows down all of them. What comes
//! out are the times of each and what one takes over another, run by run.

use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use device::Device;

use engine::{
    film::Film,
    procedural::{Procedural, TextureSources},
    renderer::{RenderError, RenderSettings, Renderer},
    scene::{
        Scene,
        look::{Look, LookError},
    },
};

use crate::{error::TextureBenchError, forms::Form, spread::Spread};

/// Standard errors that two pictures of one pixel may differ by, and the share of the pixels that may differ by more.
const SIGMAS: f32 = 3.5;
const OUTLIERS: f64 = 0.005;

/// A look in one form of the texture kernel, and how long its renders took.
pub(crate) struct Case {
    pub(crate) form: Form,
    pub(crate) renderer: Renderer,
    /// Seconds of each timed run.
    pub(crate) times: Vec<f64>,
}

impl Case {
    /// Puts the text of a look on the scene.
    ///
    /// # Errors
    /// [`TextureBenchError::Render`] if the device can't run the form, anything else if the look is at fault.
    pub(crate) fn new(
        device: &Device,
        scene: &Scene,
        look: &str,
        sources: &TextureSources,
        settings: &RenderSettings,
        form: Form,
    ) -> Result<Self, TextureBenchError> {
        let mut scene = scene.clone();
        let look = Look::parse(Path::new("bench.look.toml"), look)?;
        let procedural = Procedural::build(&look, &mut scene, sources).map_err(LookError::from)?;
        Ok(Self {
            form,
            renderer: form.renderer(device, &scene, &procedural, settings)?,
            times: Vec::new(),
        })
    }
}

/// A form that could not be measured.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Absent {
    /// Its name.
    pub mode: &'static str,
    /// Why.
    pub reason: String,
}

/// Makes the cases of each form; those of a form that the device can't run are left out and the reason is told.
///
/// # Errors
/// The first reason if no form is left, and whatever isn't about the device.
pub(crate) fn of_each_form<T>(
    forms: &[Form],
    mut cases: impl FnMut(Form) -> Result<Vec<T>, TextureBenchError>,
) -> Result<(Vec<T>, Vec<Absent>), TextureBenchError> {
    let (mut made, mut absent, mut first) = (Vec::new(), Vec::new(), None);
    for &form in forms {
        match cases(form) {
            Ok(cases) => made.extend(cases),
            Err(TextureBenchError::Render(error)) => {
                absent.push(Absent {
                    mode: form.name(),
                    reason: error.to_string(),
                });
                first.get_or_insert(error);
            }
            Err(error) => return Err(error),
        }
    }
    match first {
        Some(error) if made.is_empty() => Err(error.into()),
        _ => Ok((made, absent)),
    }
}

/// Renders each case `runs` times at `spp` samples per pixel, in turn, after one run of each that isn't counted: drivers
/// compile kernels when they run for the first time. `progress` hears of each render. Returns whether all of that was done before it
/// was over.
///
/// # Errors
/// The device.
pub(crate) fn run(
    cases: &mut [&mut Case],
    spp: u32,
    runs: u32,
    is_over: fn() -> bool,
    progress: &mut dyn FnMut(),
) -> Result<bool, RenderError> {
    for case in &mut *cases {
        case.times.clear();
    }
    for run in 0..=runs {
        for case in &mut *cases {
            case.renderer.restart();
            // What a processor makes of kernels beside their use would else begin in the midst of a run.
            case.renderer.device().finish_compiling();
            let start = Instant::now();
            while !case.renderer.step(spp)?.is_done() {
                if is_over() {
                    return Ok(false);
                }
            }
            if run > 0 {
                case.times.push(start.elapsed().as_secs_f64());
            }
            progress();
            if is_over() {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// Milliseconds of a sample of all pixels, from seconds of runs.
pub(crate) fn ms_per_spp(times: &[f64], spp: u32) -> Spread {
    Spread::of(times.iter().map(|s| s * 1e3 / f64::from(spp)))
}

/// How much longer runs took than those of gray beside them, percent.
pub(crate) fn increase(times: &[f64], gray: &[f64]) -> Spread {
    Spread::of(times.iter().zip(gray).map(|(t, g)| (t / g - 1.0) * 100.0))
}

/// Compares what two cases of one look show; `texture` is what the error calls it.
///
/// # Errors
/// [`TextureBenchError::Differs`], or the device.
pub(crate) fn same_picture(
    first: &Film,
    case: &Case,
    texture: &'static str,
) -> Result<(), TextureBenchError> {
    let share = outliers(first, &case.renderer.film()?);
    match share > OUTLIERS {
        true => Err(TextureBenchError::Differs {
            form: case.form.name(),
            texture,
            percent: share * 100.0,
            sigmas: SIGMAS,
        }),
        false => Ok(()),
    }
}

/// Share of the pixels and channels whose means differ by more than [`SIGMAS`] standard errors of their difference.
fn outliers(a: &Film, b: &Film) -> f64 {
    let errors = a.standard_error().into_iter().zip(b.standard_error());
    let means = a.mean().into_iter().zip(b.mean());
    let (mut outside, mut all) = (0_u64, 0_u64);
    for ((ma, mb), (ea, eb)) in means.zip(errors) {
        for c in 0..3 {
            let error = ea[c].hypot(eb[c]) + 1e-4 * ma[c].abs();
            all += 1;
            outside += u64::from((ma[c] - mb[c]).abs() > SIGMAS * error);
        }
    }
    outside as f64 / all.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_one_sample_are_never_told_apart() {
        // Nothing is known of the error of a single sample: why `bench textures` takes two at least.
        for (samples, share) in [(1, 0.0), (2, 1.0)] {
            let mut films = [(); 2].map(|()| Film::new(8, 8));
            for (number, film) in films.iter_mut().enumerate() {
                for pixel in 0..64 {
                    for _ in 0..samples {
                        film.add_sample(pixel, [1.0 + number as f32; 3]);
                    }
                }
            }
            assert_eq!(outliers(&films[0], &films[1]), share, "{samples}");
        }
    }

    #[test]
    fn increases_are_of_runs_beside_each_other() {
        // The machine slowed down by a factor of two in between: the ratio doesn't notice.
        let Spread { median, low, high } = increase(&[1.5, 3.0, 3.2], &[1.0, 2.0, 2.0]);
        assert_eq!((low, median), (50.0, 50.0));
        assert!((high - 60.0).abs() < 1e-9);
    }

    #[test]
    fn a_picture_that_differs_has_outliers() {
        let mut films = [(); 2].map(|()| Film::new(8, 8));
        for (number, film) in films.iter_mut().enumerate() {
            for pixel in 0..64 {
                for sample in 0..16 {
                    let bright = if pixel < 8 { number as f32 } else { 0.0 };
                    let noise = 0.1 * ((sample + number) % 4) as f32;
                    film.add_sample(pixel, [1.0 + noise + bright; 3]);
                }
            }
        }
        assert_eq!(outliers(&films[0], &films[0]), 0.0);
        assert_eq!(outliers(&films[0], &films[1]), 0.125);
    }
}
