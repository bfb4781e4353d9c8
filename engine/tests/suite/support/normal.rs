//! The normal distribution: tail probabilities, and reproducible random numbers for tests of tests.

use std::f64::consts::{FRAC_2_SQRT_PI, SQRT_2, TAU};

/// Probability that a standard normal variable lies at least |z| from zero, on either side: erfc(|z| / sqrt 2).
/// Exact to at least ten digits.
pub(crate) fn two_sided_p_value(z: f64) -> f64 {
    let x = z.abs() / SQRT_2;
    if x < 2.5 {
        1.0 - erf_by_series(x)
    } else {
        erfc_by_fraction(x)
    }
}

/// Abramowitz and Stegun, 7.1.6: all terms are positive, so nothing cancels.
fn erf_by_series(x: f64) -> f64 {
    let mut term = x;
    let mut sum = x;
    let mut odd = 3.0;
    while term > 1.0e-17 * sum {
        term *= 2.0 * x * x / odd;
        sum += term;
        odd += 2.0;
    }
    FRAC_2_SQRT_PI * (-x * x).exp() * sum
}

/// Abramowitz and Stegun, 7.1.14: the continued fraction, from its far end. It converges fast away from zero.
fn erfc_by_fraction(x: f64) -> f64 {
    let denominator = (1..60)
        .rev()
        .fold(x, |rest, n| x + 0.5 * f64::from(n) / rest);
    0.5 * FRAC_2_SQRT_PI * (-x * x).exp() / denominator
}

/// Standard normal numbers from a seed (SplitMix64 and the Box-Muller transform).
pub(crate) struct Normal {
    state: u64,
}

impl Normal {
    /// The sequence of a seed.
    pub(crate) fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next number.
    pub(crate) fn sample(&mut self) -> f64 {
        // The logarithm must not see zero.
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }

    /// The next number of the uniform distribution over [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.state;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (x ^ (x >> 31)) as f64 / 2.0_f64.powi(64)
    }
}
