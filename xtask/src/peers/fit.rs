//! Error over samples: a power law through what was measured.

/// `error = scale * samples ^ -exponent`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Falling {
    pub(super) scale: f64,
    pub(super) exponent: f64,
}

impl Falling {
    /// The line of least squares through the logarithms of (samples, error). `None` where there are fewer than two
    /// numbers of samples or an error of zero.
    pub(super) fn through(points: &[(f64, f64)]) -> Option<Self> {
        let logs: Vec<(f64, f64)> = points.iter().map(|&(n, e)| (n.ln(), e.ln())).collect();
        let count = logs.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
        let (mean_n, mean_e) = (mean(|p| p.0), mean(|p| p.1));
        let spread: f64 = logs.iter().map(|p| (p.0 - mean_n).powi(2)).sum();
        let together: f64 = logs.iter().map(|p| (p.0 - mean_n) * (p.1 - mean_e)).sum();
        let slope = together / spread;
        let scale = (mean_e - slope * mean_n).exp();
        (slope.is_finite() && scale.is_finite()).then_some(Self {
            scale,
            exponent: -slope,
        })
    }

    /// Samples until the error is so low; `None` where it doesn't fall.
    pub(super) fn samples(self, error: f64) -> Option<f64> {
        (self.exponent > 0.0).then(|| (self.scale / error).powf(1.0 / self.exponent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_again() {
        let law = |n: f64| 3.0 * n.powf(-0.6);
        let points = [4.0, 16.0, 64.0].map(|n| (n, law(n)));
        let fit = Falling::through(&points).unwrap();
        assert!(
            (fit.scale - 3.0).abs() < 1e-9 && (fit.exponent - 0.6).abs() < 1e-9,
            "{fit:?}"
        );
        assert!((fit.samples(law(100.0)).unwrap() - 100.0).abs() < 1e-6);
    }

    #[test]
    fn nothing_is_read_into_too_little() {
        assert_eq!(Falling::through(&[(4.0, 0.1)]), None);
        assert_eq!(Falling::through(&[]), None);
        assert_eq!(Falling::through(&[(4.0, 0.0), (16.0, 0.0)]), None);
        let rising = Falling::through(&[(4.0, 0.1), (16.0, 0.2)]).unwrap();
        assert_eq!(rising.samples(0.1), None);
    }
}
