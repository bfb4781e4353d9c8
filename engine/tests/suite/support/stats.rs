//! Two pictures compared as statistics: a two-sided z-test of every pixel, and the ratio of the means.
//!
//! "Equal" is judged by the error both pictures are known to have, not by a tolerance somebody liked: a pixel passes
//! if its difference is within so many standard errors of both combined. A bias too small to be seen in any one
//! pixel is found by the mean of the whole picture.

use super::estimate::Estimate;
use super::maps;
use super::normal::two_sided_p_value;

/// How strictly pixels are judged.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ZTest {
    /// A pixel passes within this many combined standard errors, in every channel. At 3.5 about 1 in 700 pixels
    /// fails by chance (three channels at 1 in 2,150).
    pub(crate) sigmas: f64,
    /// Differences up to this are always fine: rounding where neither picture has any noise (a lamp seen directly).
    /// Relative to the brighter of the two, plus the same absolutely.
    pub(crate) rounding: f64,
}

impl Default for ZTest {
    fn default() -> Self {
        Self {
            sigmas: 3.5,
            rounding: 1.0e-5,
        }
    }
}

/// The outcome of comparing a picture with a reference.
#[derive(Debug, Clone)]
pub(crate) struct Comparison {
    settings: ZTest,
    tested: Estimate,
    reference: Estimate,
    /// Which pixels count.
    counted: Vec<bool>,
    /// Difference in combined standard errors, positive where the picture is too bright. Zero where it doesn't count.
    z: Vec<[f64; 3]>,
}

impl ZTest {
    /// Compares `tested` with `reference` pixel by pixel; `counts(x, y)` says which pixels take part.
    ///
    /// # Panics
    /// The pictures differ in size.
    pub(crate) fn compare(
        self,
        tested: Estimate,
        reference: Estimate,
        counts: impl Fn(usize, usize) -> bool,
    ) -> Comparison {
        assert_eq!(
            (tested.width, tested.height),
            (reference.width, reference.height),
            "the pictures must have the same size"
        );
        let (width, pixels) = (tested.width, tested.width * tested.height);
        let counted: Vec<bool> = (0..pixels).map(|i| counts(i % width, i / width)).collect();
        let z = (0..pixels)
            .map(|i| {
                std::array::from_fn(|c| {
                    if counted[i] {
                        self.z(
                            [tested.mean[i][c], reference.mean[i][c]],
                            [tested.error[i][c], reference.error[i][c]],
                        )
                    } else {
                        0.0
                    }
                })
            })
            .collect();
        Comparison {
            settings: self,
            tested,
            reference,
            counted,
            z,
        }
    }

    /// Signed difference of two means in combined standard errors. A value that is no number is infinitely wrong.
    fn z(self, means: [f32; 2], errors: [f32; 2]) -> f64 {
        let [tested, reference] = means.map(f64::from);
        let error = errors.map(f64::from).into_iter().fold(0.0, f64::hypot);
        let difference = tested - reference;
        if !difference.is_finite() || !error.is_finite() {
            return f64::INFINITY;
        }
        let rounding = self.rounding * (1.0 + tested.abs().max(reference.abs()));
        if difference.abs() <= rounding {
            return 0.0;
        }
        difference / error
    }
}

impl Comparison {
    /// Share of the counted pixels that pass, 0 to 1.
    pub(crate) fn passing_share(&self) -> f64 {
        let counted = self.counted.iter().filter(|&&counts| counts).count();
        let passing = (0..self.z.len()).filter(|&i| self.counted[i] && self.passes(i));
        passing.count() as f64 / counted as f64
    }

    /// Mean of the picture over mean of the reference per channel, counted pixels only.
    pub(crate) fn mean_ratio(&self) -> [f64; 3] {
        let sum = |pixels: &[[f32; 3]], c: usize| -> f64 {
            let counted = pixels.iter().zip(&self.counted);
            counted
                .filter(|&(_, &counts)| counts)
                .map(|(pixel, _)| f64::from(pixel[c]))
                .sum()
        };
        std::array::from_fn(|c| sum(&self.tested.mean, c) / sum(&self.reference.mean, c))
    }

    /// The smallest p-value among the channels of a pixel: how likely so large a difference is by chance.
    pub(crate) fn p_value(&self, pixel: usize) -> f64 {
        let worst = self.z[pixel]
            .iter()
            .fold(0.0, |worst, z| z.abs().max(worst));
        two_sided_p_value(worst)
    }

    /// Whether a pixel is within the limit in every channel.
    pub(crate) fn passes(&self, pixel: usize) -> bool {
        let limit = self.settings.sigmas;
        self.z[pixel].iter().all(|z| z.abs() <= limit)
    }

    /// Difference of a pixel in combined standard errors.
    pub(crate) fn z(&self, pixel: usize) -> [f64; 3] {
        self.z[pixel]
    }

    /// The picture under test.
    pub(crate) fn tested(&self) -> &Estimate {
        &self.tested
    }

    /// What it is compared with.
    pub(crate) fn reference(&self) -> &Estimate {
        &self.reference
    }

    /// Fails the test called `name` unless at least `min_passing` of the pixels pass and no channel's mean is off by
    /// more than `max_mean_error` (relative). Writes maps to look at into `target/test-failures/` before it does.
    ///
    /// # Panics
    /// That is how a test fails.
    #[track_caller]
    pub(crate) fn assert_matches(&self, name: &str, min_passing: f64, max_mean_error: f64) {
        let passing = self.passing_share();
        let ratio = self.mean_ratio();
        let mean_matches = ratio.iter().all(|r| (r - 1.0).abs() <= max_mean_error);
        eprintln!(
            "{name}: {:.3} % of the pixels pass at {} sigma; means relative to the reference {ratio:.5?}",
            100.0 * passing,
            self.settings.sigmas
        );
        if passing >= min_passing && mean_matches {
            return;
        }
        let written = match maps::write(self, name) {
            Ok(dir) => format!("maps are in {}", dir.display()),
            Err(error) => format!("maps could not be written: {error}"),
        };
        panic!(
            "{name} differs from its reference: {:.3} % of the pixels pass at {} sigma, {:.3} % must; \
             means relative to the reference {ratio:.5?}, allowed is {max_mean_error}; {written}",
            100.0 * passing,
            self.settings.sigmas,
            100.0 * min_passing,
        );
    }
}
