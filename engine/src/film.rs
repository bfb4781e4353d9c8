//! The film on the CPU: sums of samples and of their squares, so that the error of each pixel is known.

/// What has been gathered for each pixel, row 0 on top.
#[derive(Debug, Clone)]
pub struct Film {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples of each pixel.
    pub samples: Vec<u32>,
    /// Sum of radiance, linear Rec.709.
    pub sum: Vec<[f32; 3]>,
    /// Sum of squared radiance.
    pub sum_squares: Vec<[f32; 3]>,
}

impl Film {
    /// From the GPU's two buffers of `vec4f`.
    pub(crate) fn from_gpu(
        width: u32,
        height: u32,
        sum: &[[f32; 4]],
        squares: &[[f32; 4]],
    ) -> Self {
        let rgb = |v: &[f32; 4]| [v[0], v[1], v[2]];
        Self {
            width,
            height,
            samples: sum.iter().map(|v| v[3] as u32).collect(),
            sum: sum.iter().map(rgb).collect(),
            sum_squares: squares.iter().map(rgb).collect(),
        }
    }

    /// Mean radiance of each pixel; black where there is no sample.
    pub fn mean(&self) -> Vec<[f32; 3]> {
        self.sum
            .iter()
            .zip(&self.samples)
            .map(|(s, &n)| s.map(|v| if n == 0 { 0.0 } else { v / n as f32 }))
            .collect()
    }

    /// Standard error of each pixel's mean, from the spread of its samples; infinite below two samples.
    ///
    /// The samples are points of a low-discrepancy sequence, so this overestimates the error.
    pub fn standard_error(&self) -> Vec<[f32; 3]> {
        let pixel = |((s, q), &n): ((&[f32; 3], &[f32; 3]), &u32)| {
            std::array::from_fn(|c| {
                if n < 2 {
                    return f32::INFINITY;
                }
                let n = f64::from(n);
                let mean = f64::from(s[c]) / n;
                let variance = (f64::from(q[c]) / n - mean * mean).max(0.0) * n / (n - 1.0);
                (variance / n).sqrt() as f32
            })
        };
        self.sum
            .iter()
            .zip(&self.sum_squares)
            .zip(&self.samples)
            .map(pixel)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_of_known_samples() {
        // Samples 1 and 3: mean 2, variance 2, standard error 1.
        let film = Film {
            width: 1,
            height: 1,
            samples: vec![2],
            sum: vec![[4.0; 3]],
            sum_squares: vec![[10.0; 3]],
        };
        assert_eq!(film.mean(), vec![[2.0; 3]]);
        assert!((film.standard_error()[0][0] - 1.0).abs() < 1e-6);
    }
}
