//! Pixel filters, sampled by importance: each sample belongs to one pixel and lies where that pixel's filter is large
//! (Ernst, Stamminger and Greiner, "Filter Importance Sampling", RT 2006). A filter with negative lobes is sampled by
//! its absolute value, and samples in those lobes count negatively.
//!
//! All filters are separable: products of the same function along x and along y.

use std::f64::consts::PI;
use std::sync::OnceLock;

/// Steps of each lobe in the table of the sampling kernel; `raygen.wgsl` has the same number. They are finer towards both
/// ends of a lobe, where the filter falls to zero and equal shares would be ever wider: step `k` of the table is a share of
/// 2 (k / SLOTS)², and likewise from the other end.
const SLOTS: usize = 512;
/// Steps of numerical integration over half a filter.
const STEPS: usize = 1 << 14;

/// How a pixel weighs the light around its centre.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PixelFilter {
    /// All alike within the width.
    #[default]
    Box,
    /// exp(-x²/2σ²) less its value at the edge, with σ a sixth of the width.
    Gaussian,
    /// The four-term window of Harris, "On the Use of Windows for Harmonic Analysis", 1978, 92 dB.
    BlackmanHarris,
    /// Mitchell and Netravali, "Reconstruction Filters in Computer Graphics", 1988, with B = C = 1/3. It is negative
    /// towards its edge, which sharpens; pixels beside much brighter ones may be negative.
    Mitchell,
}

impl PixelFilter {
    /// All filters.
    pub const ALL: [Self; 4] = [
        Self::Box,
        Self::Gaussian,
        Self::BlackmanHarris,
        Self::Mitchell,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Gaussian => "gaussian",
            Self::BlackmanHarris => "blackman-harris",
            Self::Mitchell => "mitchell",
        }
    }

    /// The usual width, pixels from edge to edge.
    pub fn default_width(self) -> f32 {
        match self {
            Self::Box => 1.0,
            Self::Gaussian | Self::BlackmanHarris => 3.0,
            Self::Mitchell => 4.0,
        }
    }

    /// The filter at a distance from the centre, as a share of half its width, 0 to 1; not normalised.
    pub fn value(self, distance: f64) -> f64 {
        let t = distance;
        match self {
            Self::Box => 1.0,
            Self::Gaussian => (-4.5 * t * t).exp() - (-4.5_f64).exp(),
            Self::BlackmanHarris => {
                0.35875
                    + 0.48829 * (PI * t).cos()
                    + 0.14128 * (2.0 * PI * t).cos()
                    + 0.01168 * (3.0 * PI * t).cos()
            }
            Self::Mitchell => {
                // The published polynomials, times 18, with B = C = 1/3; their unit is half of our half width.
                let x = 2.0 * t;
                if x < 1.0 {
                    (21.0 * x - 36.0) * x * x + 16.0
                } else {
                    ((-7.0 * x + 36.0) * x - 60.0) * x + 32.0
                }
            }
        }
    }
}

/// What the sampling kernel needs to know of a filter, for one axis and one side of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FilterTable {
    /// Share of the filter's absolute value that is positive.
    pub(crate) positive: f32,
    /// Integral of the absolute value over that of the filter.
    pub(crate) weight: f32,
    /// First for the positive lobe, then for the negative one: within which distance, 0 to 1, lie the shares of the lobe
    /// that the steps stand for.
    pub(crate) distances: Vec<f32>,
}

impl FilterTable {
    /// Computed when a filter is asked for first: integration takes longer than all else that an edit needs.
    pub(crate) fn of(filter: PixelFilter) -> &'static Self {
        static TABLES: [OnceLock<FilterTable>; PixelFilter::ALL.len()] =
            [const { OnceLock::new() }; PixelFilter::ALL.len()];
        TABLES[filter as usize].get_or_init(|| Self::new(filter))
    }

    fn new(filter: PixelFilter) -> Self {
        let step = |i: usize| filter.value((i as f64 + 0.5) / STEPS as f64);
        // No filter has more than one zero on a side.
        let zero = (0..STEPS).find(|&i| step(i) < 0.0).unwrap_or(STEPS);
        let mass = |lobe: std::ops::Range<usize>| -> f64 { lobe.map(|i| step(i).abs()).sum() };
        let (positive, negative) = (mass(0..zero), mass(zero..STEPS));
        let all = positive + negative;
        let mut distances = Vec::with_capacity(2 * (SLOTS + 1));
        for (lobe, mass) in [(0..zero, positive), (zero..STEPS, negative)] {
            let (mut at, mut within) = (lobe.start, 0.0);
            for slot in 0..=SLOTS {
                let place = slot as f64 / SLOTS as f64;
                let end = place.min(1.0 - place);
                let share = 2.0 * end * end;
                let wanted = mass * if place < 0.5 { share } else { 1.0 - share };
                while at < lobe.end && within + step(at).abs() < wanted {
                    within += step(at).abs();
                    at += 1;
                }
                let inside = match at < lobe.end && slot < SLOTS {
                    true => (wanted - within) / step(at).abs(),
                    false => (lobe.end - at) as f64,
                };
                distances.push(((at as f64 + inside) / STEPS as f64) as f32);
            }
        }
        Self {
            positive: (positive / all) as f32,
            weight: (all / (positive - negative)) as f32,
            distances,
        }
    }

    /// The twin of `filter_offset` in `raygen.wgsl`, in half widths.
    #[cfg(test)]
    fn offset(&self, u: f32) -> f32 {
        let side = 2.0 * u - 1.0;
        let (mut share, mut first) = (side.abs() / self.positive, 0);
        if side.abs() > self.positive {
            share = (side.abs() - self.positive) / (1.0 - self.positive);
            first = SLOTS + 1;
        }
        let share = share.min(1.0);
        let end = (0.5 * share.min(1.0 - share)).sqrt();
        let scaled = SLOTS as f32 * if share < 0.5 { end } else { 1.0 - end };
        let slot = (scaled as usize).min(SLOTS - 1);
        let pair = &self.distances[first + slot..];
        let distance = pair[0] + (pair[1] - pair[0]) * (scaled - slot as f32);
        distance * side.signum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integral of the filter's absolute value from the centre to a distance.
    fn mass(filter: PixelFilter, from: f64, to: f64) -> f64 {
        let at = |k: usize| from + (to - from) * (k as f64 + 0.5) / 1000.0;
        (0..1000).map(|k| filter.value(at(k)).abs()).sum::<f64>() * (to - from) / 1000.0
    }

    #[test]
    fn samples_are_distributed_as_the_filter() {
        const BINS: usize = 40;
        const SAMPLES: usize = 100_000;
        for filter in PixelFilter::ALL {
            let table = FilterTable::of(filter);
            let mut counts = [0.0; BINS];
            let mut state = 1_u64;
            for _ in 0..SAMPLES {
                // Knuth's generator: the distribution is that of random numbers, not of a grid.
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                let u = (state >> 40) as f32 / (1 << 24) as f32;
                let x = f64::from(table.offset(u));
                assert!((-1.0..=1.0).contains(&x), "{filter:?}");
                counts[((x * 0.5 + 0.5) * BINS as f64).min(BINS as f64 - 1.0) as usize] += 1.0;
            }
            let all = 2.0 * mass(filter, 0.0, 1.0);
            let mut chi2 = 0.0;
            for (bin, count) in counts.iter().enumerate() {
                let edge = |bin: usize| (2.0 * bin as f64 / BINS as f64 - 1.0).abs();
                let (a, b) = (edge(bin), edge(bin + 1));
                let expected = SAMPLES as f64 * mass(filter, a.min(b), a.max(b)) / all;
                chi2 += (count - expected).powi(2) / expected.max(5.0);
            }
            // 39 degrees of freedom: 85 has a chance of about 3e-5.
            assert!(chi2 < 85.0, "{filter:?}: {chi2}");
        }
    }

    #[test]
    fn weights_have_a_mean_of_one() {
        for filter in PixelFilter::ALL {
            let table = FilterTable::of(filter);
            let mean = (2.0 * table.positive - 1.0) * table.weight;
            assert!((mean - 1.0).abs() < 1e-6, "{filter:?}: {mean}");
            let has_negative = filter == PixelFilter::Mitchell;
            assert_eq!(table.positive < 1.0, has_negative, "{filter:?}");
            assert_eq!(table.distances.len(), 2 * (SLOTS + 1));
            assert_eq!(table.distances[0], 0.0);
            assert_eq!(table.distances[2 * SLOTS + 1], 1.0);
        }
    }
}
