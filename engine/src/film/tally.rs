//! What the samples of a picture say of all of it, gathered film by film: of pictures that are never in memory as a whole.

use super::Film;

/// Samples of each pixel after which a picture without any light is taken to be black: many times those that others have before their error
/// is believed, for nothing is known of light that is met seldom.
const BELIEVED: u32 = 256;

/// Sums over pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tally {
    pixels: u64,
    samples: u64,
    /// The fewest and the most samples of a pixel; `None` where there are no pixels.
    bounds: Option<(u32, u32)>,
    /// Of the pixels' means, over all channels.
    variance: f64,
    /// Means of the pixels, over all channels.
    radiance: f64,
}

impl Tally {
    /// Of a film.
    pub fn of(film: &Film) -> Self {
        let mut tally = Self::default();
        for pixel in 0..film.pixels() {
            let samples = film.samples(pixel);
            tally.pixels += 1;
            tally.samples += u64::from(samples);
            tally.meets(samples, samples);
            let error = film.pixel_error(pixel);
            tally.variance += error.iter().map(|&e| f64::from(e).powi(2)).sum::<f64>();
            let mean = film.pixel_mean(pixel);
            tally.radiance += mean.iter().map(|&x| f64::from(x)).sum::<f64>();
        }
        tally
    }

    fn meets(&mut self, fewest: u32, most: u32) {
        let (low, high) = self.bounds.unwrap_or((fewest, most));
        self.bounds = Some((low.min(fewest), high.max(most)));
    }

    /// Adds other pixels of the same picture.
    pub fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.samples += other.samples;
        self.variance += other.variance;
        self.radiance += other.radiance;
        if let Some((fewest, most)) = other.bounds {
            self.meets(fewest, most);
        }
    }

    /// Samples of all pixels together.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// See [`Film::sample_bounds`].
    pub fn sample_bounds(&self) -> (u32, u32) {
        self.bounds.unwrap_or_default()
    }

    /// See [`Film::mean_samples`].
    pub fn mean_samples(&self) -> f64 {
        self.samples as f64 / self.pixels.max(1) as f64
    }

    /// Mean radiance of all pixels and channels.
    pub fn brightness(&self) -> f64 {
        self.radiance / (3 * self.pixels).max(1) as f64
    }

    /// See [`Film::relative_error`].
    pub fn relative_error(&self) -> f64 {
        self.error_relative_to(self.brightness())
    }

    /// As [`Self::relative_error`], where these pixels are part of a picture of this brightness: in parts whose error is below a limit so, that
    /// of the whole is, too. What is black in hundreds of samples has no error.
    pub fn error_relative_to(&self, brightness: f64) -> f64 {
        match brightness > 0.0 {
            true => (self.variance / (3 * self.pixels) as f64).sqrt() / brightness,
            false if self.variance == 0.0 && self.sample_bounds().0 >= BELIEVED => 0.0,
            false => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A film of pixels with two samples each, apart by so much from their mean on both sides.
    fn film(pixels: &[(f32, f32)]) -> Film {
        let mut film = Film::new(pixels.len() as u32, 1);
        for (pixel, &(mean, apart)) in pixels.iter().enumerate() {
            film.add_sample(pixel, [mean - apart; 3]);
            film.add_sample(pixel, [mean + apart; 3]);
        }
        film
    }

    #[test]
    fn parts_tell_what_the_whole_tells() {
        let pixels = [(1.0, 0.5), (4.0, 1.0), (0.25, 0.25), (2.0, 0.0)];
        let whole = Tally::of(&film(&pixels));
        let mut parts = Tally::of(&film(&pixels[..1]));
        parts.add(&Tally::default());
        parts.add(&Tally::of(&film(&pixels[1..])));
        assert_eq!(parts.sample_bounds(), (2, 2));
        assert_eq!(parts.mean_samples(), whole.mean_samples());
        assert!((parts.relative_error() / whole.relative_error() - 1.0).abs() < 1e-12);
        assert_eq!(whole.relative_error(), film(&pixels).relative_error());
        assert_eq!(Tally::default().relative_error(), f64::INFINITY);
    }

    #[test]
    fn black_has_no_error_once_that_is_known() {
        let mut film = Film::new(2, 1);
        for samples in 1..=BELIEVED {
            (0..2).for_each(|pixel| film.add_sample(pixel, [0.0; 3]));
            let is_known = Tally::of(&film).relative_error() == 0.0;
            assert_eq!(is_known, samples == BELIEVED, "{samples}");
        }
    }

    #[test]
    fn what_is_enough_for_parts_is_enough_for_the_whole() {
        // A bright part and a dark one, each with the error that is allowed of the whole's brightness.
        let (bright, dark) = (film(&[(9.5, 0.5)]), film(&[(0.5, 0.5)]));
        let (bright, dark) = (Tally::of(&bright), Tally::of(&dark));
        let mut whole = bright;
        whole.add(&dark);
        let brightness = whole.brightness();
        assert!((brightness - 5.0).abs() < 1e-6);
        let limit = bright.error_relative_to(brightness);
        assert!((dark.error_relative_to(brightness) - limit).abs() < 1e-6);
        assert!(whole.relative_error() <= limit * (1.0 + 1e-6));
        // The error of one relative to itself says nothing of the whole.
        assert!(dark.relative_error() > 9.0 * limit);
    }
}
