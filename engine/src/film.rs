//! The film: exact sums of samples and of their squares, so that films can be added and the error of each pixel is known,
//! and the [`layers`] that are gathered beside the picture; the files that films come from and go to ([`Part`], [`mod@write`]).
//! How samples come about is none of its business.
//!
//! A sum of floating-point numbers depends on their order. The film's sums are whole numbers of 96 bits, in units of
//! 2^-44 for radiance and of 2^-36 for its square: a sample is rounded to a whole number of units once, and what is
//! added up afterwards is exact in any order. With at most [`MAX_SAMPLES`] samples no sum can leave 96 bits:
//!
//! | | unit | largest sample | sum of 2^20 samples |
//! |---|---|---|---|
//! | radiance, signed | 2^-44 = 5.7e-14 | 2^31 = 2.1e9 | 2^95 units |
//! | its square | 2^-36 = 1.5e-11 | 2^40, of radiance 1.0e6 | 2^96 units |
//!
//! 24 bits of a sample's radiance are kept from 1e-6 on, and the sun's disk in W/m²/sr has room above. Larger samples
//! are clamped and counted ([`crate::stats::Stats::clamped_samples`]). Larger squares are clamped in silence: the
//! picture stays as it is, and the error of such a pixel, which is enormous anyway, is underestimated.
//!
//! Samples may come in two halves, whose random numbers have nothing in common (`RenderSettings::halves`): runs of [`HALF_RUN`]
//! in turn. Then the sums of the first
//! half stand where those of the squares would, and the error is known from how far the halves are apart. Squares make it too
//! large, for the points of one sequence fill the pixel more evenly than random numbers; the halves make it right, if rough:
//! what one pixel says is to be averaged over many.

mod catcher;
mod crop;
mod hash;
pub mod ids;
pub mod layers;
pub(crate) mod layers_wgsl;
mod mix;
mod part;
mod tally;
pub mod write;

pub use crop::Crop;
pub(crate) use hash::Hash;
pub use layers::{LAYERS, Layer, Layers};
pub(crate) use mix::Multiple;
pub use mix::{GroupFactors, LightMix};
pub(crate) use part::HALVES;
pub use part::{MAGIC_BYTES, Origin, Part, PartError, is_film};
#[doc(hidden)]
pub use part::{sealed, unpacked};
pub use tally::Tally;

use ids::{Counts, Coverage, IDS};
use layers::{ENVIRONMENT, MAX_CHANNELS, Rule};

/// The largest side of a picture, pixels.
pub const MAX_SIDE: u32 = 16384;

/// Most samples of a pixel: more could leave the range of the sums.
pub const MAX_SAMPLES: u32 = 1 << 20;

/// Buffers of the picture's sums on a device, each with four words per pixel: so few that a picture of 3840 x 2160 pixels
/// stays within the 128 MiB that every device can bind.
pub(crate) const PICTURE_PLANES: [&str; 5] = ["film0", "film1", "film2", "film3", "film4"];

/// Words before the sums of squares, and before the number of samples, in the order of the planes.
const SQUARES: usize = 9;
const COUNT: usize = 18;
/// The word with the number of samples in the first half; 0 where there are sums of squares.
const FIRST_HALF: usize = 19;
/// Samples of one half in a row: of a pixel's samples, so many are of the first one, then as many of the second, and so on.
/// `frame.wgsl` has the same number.
pub const HALF_RUN: u32 = 16;
/// Bits behind the point, and the largest sample, of both kinds of sums. `exact_sums.wgsl` and `accumulate.wgsl` have the same
/// numbers.
const SUM_BITS: i32 = 44;
const SQUARE_BITS: i32 = 36;
const LARGEST: f32 = 2_147_483_520.0;
const LARGEST_SQUARE: f32 = 1_099_511_562_240.0;
/// The darkest colour that light is divided by, 2^-14: of smaller numbers halves lose digits.
const LEAST_COLOR: f32 = 1.0 / 16384.0;

/// What has been gathered for each pixel, row 0 on top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Film {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    layers: Layers,
    /// As on the device. Those of the picture: three words for each sum of red, green and blue, three for each of their
    /// squares, the least significant one first, the number of samples, and of those in the first half. Then those of the layers.
    planes: Vec<Vec<[u32; 4]>>,
}

impl Film {
    /// A film of the picture alone, without samples.
    pub fn new(width: u32, height: u32) -> Self {
        Self::with_layers(width, height, Layers::default())
    }

    /// A film without samples.
    pub fn with_layers(width: u32, height: u32, layers: Layers) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            width,
            height,
            planes: vec![vec![[0; 4]; pixels]; layers.plane_count()],
            layers,
        }
    }

    /// From a device's buffers, in the order of [`Layers::buffers`].
    pub(crate) fn from_planes(
        width: u32,
        height: u32,
        layers: Layers,
        planes: Vec<Vec<[u32; 4]>>,
    ) -> Self {
        Self {
            width,
            height,
            layers,
            planes,
        }
    }

    /// What it gathers.
    pub fn layers(&self) -> &Layers {
        &self.layers
    }

    /// Columns times rows.
    pub fn pixels(&self) -> usize {
        self.planes[0].len()
    }

    /// Samples of a pixel, counted row by row from the upper left one.
    pub fn samples(&self, pixel: usize) -> u32 {
        self.word(pixel, COUNT)
    }

    /// The fewest and the most samples that a pixel has.
    pub fn sample_bounds(&self) -> (u32, u32) {
        (0..self.pixels())
            .map(|pixel| self.samples(pixel))
            .fold(None, |bounds: Option<(u32, u32)>, n| {
                bounds.map_or(Some((n, n)), |(low, high)| Some((low.min(n), high.max(n))))
            })
            .unwrap_or_default()
    }

    /// Samples of a pixel on average over the picture.
    pub fn mean_samples(&self) -> f64 {
        let sum: u64 = (0..self.pixels()).map(|p| u64::from(self.samples(p))).sum();
        sum as f64 / self.pixels().max(1) as f64
    }

    /// Sum of a pixel's radiance, linear Rec.709.
    pub fn sum(&self, pixel: usize) -> [f64; 3] {
        std::array::from_fn(|c| signed(self.words(pixel, 3 * c)))
    }

    /// Sum of a pixel's squared radiance, as its samples tell it: where they come in halves, what the halves let guess.
    pub fn sum_squares(&self, pixel: usize) -> [f64; 3] {
        if let Some(variance) = self.variance_by_halves(pixel) {
            let n = f64::from(self.samples(pixel));
            let sum = self.sum(pixel);
            return std::array::from_fn(|c| sum[c] * sum[c] / n + variance[c] * n * (n - 1.0));
        }
        std::array::from_fn(|c| {
            let [low, middle, high] = self.words(pixel, SQUARES + 3 * c);
            let whole = u128::from(high) << 64 | u128::from(middle) << 32 | u128::from(low);
            whole as f64 * f64::from(-SQUARE_BITS).exp2()
        })
    }

    /// The means of a pixel's two halves. `None` where samples don't come in halves, or all are of one.
    pub fn half_means(&self, pixel: usize) -> Option<[[f64; 3]; 2]> {
        let first = self.word(pixel, FIRST_HALF);
        let second = self.samples(pixel).checked_sub(first)?;
        if first == 0 || second == 0 {
            return None;
        }
        let sum = self.sum(pixel);
        let of_first = std::array::from_fn(|c| signed(self.words(pixel, SQUARES + 3 * c)));
        let of_second: [f64; 3] = std::array::from_fn(|c| sum[c] - of_first[c]);
        Some([
            of_first.map(|sum| sum / f64::from(first)),
            of_second.map(|sum| sum / f64::from(second)),
        ])
    }

    /// The variance of a pixel's mean, by the difference of its halves: one number of it, right on average. `None` where samples
    /// don't come in halves, or all are of one.
    pub fn variance_by_halves(&self, pixel: usize) -> Option<[f64; 3]> {
        let means = self.half_means(pixel)?;
        let n = f64::from(self.samples(pixel));
        let first = f64::from(self.word(pixel, FIRST_HALF));
        Some(std::array::from_fn(|c| {
            let apart = means[0][c] - means[1][c];
            // (1/first + 1/second) σ² on average, and the mean's variance is σ²/n.
            apart * apart * first * (n - first) / (n * n)
        }))
    }

    /// Mean radiance of each pixel; black where there is no sample.
    pub fn mean(&self) -> Vec<[f32; 3]> {
        (0..self.pixels()).map(|p| self.pixel_mean(p)).collect()
    }

    fn pixel_mean(&self, pixel: usize) -> [f32; 3] {
        match self.samples(pixel) {
            0 => [0.0; 3],
            n => self.sum(pixel).map(|sum| (sum / f64::from(n)) as f32),
        }
    }

    /// As [`Self::mean`] without the environment that the camera sees itself, and without shadow catchers: what lies in front of both, by
    /// its coverage ([`Self::alpha`]). `None` where the film hasn't gathered the layer `environment`.
    pub fn foreground(&self) -> Option<Vec<[f32; 3]>> {
        let environment = &self.planes[self.layers.first_plane(Layer::named(ENVIRONMENT)?)?..];
        let covered = self.covered();
        let pixel = |pixel: usize| {
            let n = f64::from(self.samples(pixel).max(1));
            let sum = self.sum(pixel);
            let caught = self.caught(pixel).map_or([0.0; 3], |caught| caught.light);
            // Where filters with negative weights cover more than all, alpha is 1, and colours are those of 1; where they cover less than
            // nothing, there is nothing.
            let covered = (covered.as_ref()).map_or(1.0, |covered| f64::from(covered[pixel]));
            if covered <= 0.0 {
                return [0.0; 3];
            }
            let excess = covered.max(1.0);
            std::array::from_fn(|c| {
                let [low, middle, high, _] = environment[c][pixel];
                // Both sums are exact, so that nothing is left where there is nothing else.
                let seen = (sum[c] - signed([low, middle, high])) / n - caught[c];
                // Parts of the light are rounded one by one.
                let is_rounding = seen.abs() < 1e-6 * caught[c];
                if is_rounding {
                    0.0
                } else {
                    (seen / excess) as f32
                }
            })
        };
        Some((0..self.pixels()).map(pixel).collect())
    }

    /// Light of a group of lights, without the environment that the camera sees itself, for that group which the environment is of
    /// ([`Layer::is_of_environment`]). `None` where the film hasn't gathered both.
    pub fn group_in_front(&self, group: &Layer) -> Option<Vec<[f32; 3]>> {
        let environment = &self.planes[self.layers.first_plane(Layer::named(ENVIRONMENT)?)?..];
        let group = &self.planes[self.layers.first_plane(group)?..];
        let pixel = |pixel: usize| {
            let n = f64::from(self.samples(pixel).max(1));
            std::array::from_fn(|c| {
                let [all, seen] = [group, environment].map(|planes| {
                    let [low, middle, high, _] = planes[c][pixel];
                    signed([low, middle, high])
                });
                ((all - seen) / n) as f32
            })
        };
        Some((0..self.pixels()).map(pixel).collect())
    }

    /// Share of each pixel that surfaces cover, 0 to 1; of shadow catchers, the share that the shadows on them take. `None` where the film hasn't gathered the layer `alpha`.
    pub fn alpha(&self) -> Option<Vec<f32>> {
        // Filters with negative weights may leave that range.
        let covered = self.covered()?;
        Some(covered.into_iter().map(|a| a.clamp(0.0, 1.0)).collect())
    }

    /// As [`Self::alpha`], by the weights of the filter as they are.
    fn covered(&self) -> Option<Vec<f32>> {
        let means = self.means(Layer::named("alpha")?)?;
        let covered = means.iter().zip(0..).map(|(mean, pixel)| {
            let hidden = self.caught(pixel).map_or(0.0, |caught| caught.hidden());
            mean[0] - hidden as f32
        });
        Some(covered.collect())
    }

    /// Standard error of each pixel's mean, from the spread of its samples; infinite below two samples.
    ///
    /// The samples are points of a low-discrepancy sequence, so this overestimates the error; but where they come in halves, it
    /// is right on average over many pixels.
    pub fn standard_error(&self) -> Vec<[f32; 3]> {
        (0..self.pixels()).map(|p| self.pixel_error(p)).collect()
    }

    /// The error of the whole picture, relative to its brightness, as far as the samples tell: the root of the mean squared
    /// standard error of pixels and channels, divided by their mean radiance. Infinite where a pixel has less than two samples, or all
    /// are black. As [`Self::standard_error`] it is rather too large than too small without halves, but for light that no sample has met
    /// yet.
    pub fn relative_error(&self) -> f64 {
        Tally::of(self).relative_error()
    }

    fn pixel_error(&self, pixel: usize) -> [f32; 3] {
        if self.word(pixel, FIRST_HALF) > 0 {
            let variance = self.variance_by_halves(pixel);
            return variance.map_or([f32::INFINITY; 3], |v| v.map(|v| v.sqrt() as f32));
        }
        let count = self.samples(pixel);
        if count < 2 {
            return [f32::INFINITY; 3];
        }
        let n = f64::from(count);
        let (sum, squares) = (self.sum(pixel), self.sum_squares(pixel));
        // Squares lose less than a unit each. Where nothing is there of larger ones, samples come in halves, and all are of the second.
        let lost = n * f64::from(-SQUARE_BITS).exp2();
        if (0..3).any(|c| squares[c] == 0.0 && sum[c] * sum[c] / n > 2.0 * lost) {
            return [f32::INFINITY; 3];
        }
        std::array::from_fn(|c| {
            let mean = sum[c] / n;
            let of = |squares: f64| (squares / n - mean * mean).max(0.0) * n / (n - 1.0);
            // Of dark pixels that is much of them: half a unit each. At most all light is that of one sample.
            let is_dark = squares[c] < 1e6 * lost;
            let variance = match is_dark {
                true => of(squares[c] + 0.5 * lost).min(n * mean * mean),
                false => of(squares[c]),
            };
            (variance / n).sqrt() as f32
        })
    }

    /// The values of a layer, pixel by pixel: as many of the three numbers as it has channels, the others are 0. `None` where
    /// the film hasn't gathered it, and for layers of ids ([`Self::coverage`]).
    pub fn values(&self, layer: &Layer) -> Option<Vec<[f32; MAX_CHANNELS]>> {
        let pixels = 0..self.pixels();
        let first = self.layers.first_plane(layer);
        let planes = || Some(&self.planes[first?..]);
        Some(match layer.rule {
            Rule::Derived(of) => pixels.map(|pixel| of(self, pixel)).collect(),
            Rule::Mean(_) => {
                let mut means = self.means(layer)?;
                self.shine_through(layer, &mut means);
                means
            }
            Rule::Light { color, .. } => {
                let mut light = self.means(layer)?;
                let color = color.and_then(Layer::named);
                for (light, color) in light.iter_mut().zip(
                    color
                        .and_then(|color| self.values(color))
                        .into_iter()
                        .flatten(),
                ) {
                    for (light, color) in light.iter_mut().zip(color) {
                        // Where the colour is black there is no light.
                        *light = if color == 0.0 { 0.0 } else { *light / color };
                    }
                }
                light
            }
            Rule::First { empty, .. } => {
                let found = planes()?[0].iter().map(|&[sample, values @ ..]| {
                    let mut shown = values.map(f32::from_bits);
                    if sample == 0 {
                        shown[..layer.channel_count()].fill(empty);
                    }
                    shown
                });
                found.collect()
            }
            Rule::Ids { .. } => return None,
        })
    }

    /// The mean of what samples give to a layer of sums.
    fn means(&self, layer: &Layer) -> Option<Vec<[f32; MAX_CHANNELS]>> {
        let first = self.layers.first_plane(layer)?;
        let planes = &self.planes[first..][..layer.channel_count()];
        let mean = |pixel: usize| {
            let n = f64::from(self.samples(pixel).max(1));
            let mut means = [0.0; MAX_CHANNELS];
            for (mean, plane) in means.iter_mut().zip(planes) {
                let [low, middle, high, _] = plane[pixel];
                *mean = (signed([low, middle, high]) / n) as f32;
            }
            means
        };
        Some((0..self.pixels()).map(mean).collect())
    }

    /// Makes a colour white where it is black, or so dark that files of 16 bits lose its digits, and there is light that is divided
    /// by it: a black metal reflects at its rim.
    fn shine_through(&self, color: &Layer, means: &mut [[f32; MAX_CHANNELS]]) {
        let divides = |layer: &&Layer| matches!(layer.rule, Rule::Light { color: Some(name), .. } if name == color.name);
        for layer in self.layers.iter().filter(divides) {
            for (color, light) in means
                .iter_mut()
                .zip(self.means(layer).into_iter().flatten())
            {
                for (color, light) in color.iter_mut().zip(light) {
                    if *color < LEAST_COLOR && light != 0.0 {
                        *color = 1.0;
                    }
                }
            }
        }
    }

    /// What the pixels of a layer of ids show, what covers most first. `None` where the film hasn't gathered it, and for other
    /// layers.
    pub fn coverage(&self, layer: &Layer) -> Option<Vec<[Coverage; IDS]>> {
        let Rule::Ids { .. } = layer.rule else {
            return None;
        };
        let planes = &self.planes[self.layers.first_plane(layer)?..];
        let ranked = |pixel| Counts::of(planes, pixel).ranked(self.samples(pixel));
        Some((0..self.pixels()).map(ranked).collect())
    }

    /// The numbers of a layer as files have them, channel by channel ([`Layer::channel_names`]); ids as the bits of floats.
    /// `None` where the film hasn't gathered it.
    pub fn channels(&self, layer: &Layer) -> Option<Vec<Vec<f32>>> {
        let count = 0..layer.channel_count();
        if let Rule::Ids { .. } = layer.rule {
            let pixels = self.coverage(layer)?;
            let number = |of: &Coverage, is_share| match is_share {
                true => of.share,
                false => f32::from_bits(of.id),
            };
            let channel = |at: usize| {
                let numbers = pixels
                    .iter()
                    .map(|ranked| number(&ranked[at / 2], at % 2 == 1));
                numbers.collect()
            };
            return Some(count.map(channel).collect());
        }
        let pixels = self.values(layer)?;
        let channel = |at: usize| pixels.iter().map(|values| values[at]).collect();
        Some(count.map(channel).collect())
    }

    /// Adds one sample to a pixel: the twin of `accumulate.wgsl`, for films that are made on the CPU.
    pub fn add_sample(&mut self, pixel: usize, radiance: [f32; 3]) {
        for (c, value) in radiance.into_iter().enumerate() {
            let value = value.clamp(-LARGEST, LARGEST);
            self.add_words(pixel, 3 * c, words(whole(value, SUM_BITS)));
            let square = (value * value).min(LARGEST_SQUARE);
            self.add_words(pixel, SQUARES + 3 * c, words(whole(square, SQUARE_BITS)));
        }
        let count = self.samples(pixel) + 1;
        self.set_word(pixel, COUNT, count);
    }

    /// As [`Self::add_sample`], of a pixel whose samples come in halves: the sample of this number.
    pub fn add_sample_of_half(&mut self, pixel: usize, number: u32, radiance: [f32; 3]) {
        let is_first = (number / HALF_RUN).is_multiple_of(2);
        for (c, value) in radiance.into_iter().enumerate() {
            let value = words(whole(value.clamp(-LARGEST, LARGEST), SUM_BITS));
            self.add_words(pixel, 3 * c, value);
            if is_first {
                self.add_words(pixel, SQUARES + 3 * c, value);
            }
        }
        for word in [Some(COUNT), is_first.then_some(FIRST_HALF)]
            .into_iter()
            .flatten()
        {
            let count = self.word(pixel, word) + 1;
            self.set_word(pixel, word, count);
        }
    }

    /// Adds to a pixel what the first surface of the sample of this number, counted from the first of the picture, gives to each
    /// layer, ids as the bits of the first number: the twin of `film_layers/accumulate.wgsl` and `accumulate_ids.wgsl`.
    pub fn add_surface(
        &mut self,
        pixel: usize,
        sample: u32,
        of: impl Fn(&Layer) -> [f32; MAX_CHANNELS],
    ) {
        for layer in self.layers.iter().filter(|layer| layer.wgsl().is_some()) {
            let values = of(layer);
            let first = self.layers.first_plane(layer);
            let planes = &mut self.planes[first.expect("layers with WGSL have planes")..];
            match layer.rule {
                Rule::Mean(_) | Rule::Light { .. } => {
                    for (value, plane) in values[..layer.channel_count()].iter().zip(planes) {
                        let value = value.clamp(-LARGEST, LARGEST);
                        add_wide(&mut plane[pixel], words(whole(value, SUM_BITS)));
                    }
                }
                Rule::First { .. } => {
                    let [x, y, z] = values.map(f32::to_bits);
                    keep_first(&mut planes[0][pixel], [sample + 1, x, y, z]);
                }
                Rule::Ids { .. } => {
                    let mut counts = Counts::of(planes, pixel);
                    counts.add(values[0].to_bits(), 1);
                    counts.store(planes, pixel);
                }
                Rule::Derived(_) => {}
            }
        }
    }

    /// Adds the samples of another film of the same size and layers: exactly what one film with all of them would hold.
    ///
    /// # Panics
    /// The films differ in size or layers.
    pub fn add(&mut self, other: &Self) {
        assert_eq!(
            (self.width, self.height, &self.layers),
            (other.width, other.height, &other.layers),
            "films of one size and the same layers are added"
        );
        for pixel in 0..self.pixels() {
            for first in (0..COUNT).step_by(3) {
                self.add_words(pixel, first, other.words(pixel, first));
            }
            for word in [COUNT, FIRST_HALF] {
                let count = self
                    .word(pixel, word)
                    .saturating_add(other.word(pixel, word));
                self.set_word(pixel, word, count);
            }
        }
        for layer in self.layers.iter() {
            let Some(first) = self.layers.first_plane(layer) else {
                continue; // the picture
            };
            let (here, there) = (&mut self.planes[first..], &other.planes[first..]);
            match layer.rule {
                Rule::Derived(_) => {}
                Rule::Mean(_) | Rule::Light { .. } => {
                    let planes = here.iter_mut().zip(there).take(layer.channel_count());
                    for (here, &[low, middle, high, _]) in
                        planes.flat_map(|(a, b)| a.iter_mut().zip(b))
                    {
                        add_wide(here, [low, middle, high]);
                    }
                }
                Rule::First { .. } => {
                    for (here, there) in here[0].iter_mut().zip(&there[0]) {
                        keep_first(here, *there);
                    }
                }
                Rule::Ids { .. } => {
                    for pixel in 0..there[0].len() {
                        let mut counts = Counts::of(here, pixel);
                        counts.add_all(&Counts::of(there, pixel));
                        counts.store(here, pixel);
                    }
                }
            }
        }
    }

    /// Whether the layers hold what samples can have given them: what is read from a file may not.
    fn has_numbers(&self) -> bool {
        let is_first = |&[sample, values @ ..]: &[u32; 4]| {
            sample <= MAX_SAMPLES && values.iter().all(|&bits| f32::from_bits(bits).is_finite())
        };
        self.layers.iter().all(|layer| {
            let Some(first) = self.layers.first_plane(layer) else {
                return true; // the picture
            };
            let planes = &self.planes[first..];
            match layer.rule {
                Rule::Derived(_) | Rule::Mean(_) | Rule::Light { .. } => true,
                Rule::First { .. } => planes[0].iter().all(is_first),
                Rule::Ids { .. } => {
                    let is_right = |p| Counts::of(planes, p).is_of(self.samples(p));
                    (0..self.pixels()).all(is_right)
                }
            }
        })
    }

    /// What each of a device's buffers holds of it.
    pub(crate) fn planes_by_name(&self) -> impl Iterator<Item = (&'static str, &Vec<[u32; 4]>)> {
        self.layers.buffers().into_iter().zip(&self.planes)
    }

    fn planes(&self) -> &[Vec<[u32; 4]>] {
        &self.planes
    }

    fn word(&self, pixel: usize, word: usize) -> u32 {
        self.planes[word / 4][pixel][word % 4]
    }

    fn set_word(&mut self, pixel: usize, word: usize, value: u32) {
        self.planes[word / 4][pixel][word % 4] = value;
    }

    fn words(&self, pixel: usize, first: usize) -> [u32; 3] {
        std::array::from_fn(|i| self.word(pixel, first + i))
    }

    /// Adds a number of 96 bits.
    fn add_words(&mut self, pixel: usize, first: usize, summand: [u32; 3]) {
        let mut carry = 0;
        for (i, summand) in summand.into_iter().enumerate() {
            let sum = u64::from(self.word(pixel, first + i)) + u64::from(summand) + carry;
            self.set_word(pixel, first + i, sum as u32);
            carry = sum >> 32;
        }
    }
}

/// A sum of 96 bits, whose topmost word has the sign.
fn signed([low, middle, high]: [u32; 3]) -> f64 {
    let whole = i128::from(high as i32) << 64 | i128::from(middle) << 32 | i128::from(low);
    whole as f64 * f64::from(-SUM_BITS).exp2()
}

/// Adds a number of 96 bits to the first three words.
fn add_wide(words: &mut [u32; 4], summand: [u32; 3]) {
    let mut carry = 0;
    for (word, summand) in words.iter_mut().zip(summand) {
        let sum = u64::from(*word) + u64::from(summand) + carry;
        *word = sum as u32;
        carry = sum >> 32;
    }
}

/// Keeps of two samples that with the lower number; 0 is none.
fn keep_first(here: &mut [u32; 4], there: [u32; 4]) {
    if there[0] != 0 && (here[0] == 0 || there[0] < here[0]) {
        *here = there;
    }
}

/// The nearest whole number of units; halves away from zero.
fn whole(value: f32, bits: i32) -> i128 {
    (f64::from(value) * f64::from(bits).exp2()).round() as i128
}

/// The lowest 96 bits, least significant word first.
fn words(whole: i128) -> [u32; 3] {
    [whole as u32, (whole >> 32) as u32, (whole >> 64) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn error_of_known_samples() {
        // Samples 1 and 3: mean 2, variance 2, standard error 1.
        let mut film = Film::new(1, 1);
        film.add_sample(0, [1.0; 3]);
        assert_eq!(film.standard_error(), [[f32::INFINITY; 3]]);
        film.add_sample(0, [3.0; 3]);
        assert_eq!(film.mean(), vec![[2.0; 3]]);
        assert!((film.standard_error()[0][0] - 1.0).abs() < 1e-6);
        assert!((film.relative_error() - 0.5).abs() < 1e-6);
        assert_eq!(Film::new(1, 1).relative_error(), f64::INFINITY);
        // As dark as what their squares are rounded by.
        let mut film = Film::new(1, 1);
        film.add_sample(0, [1e-6; 3]);
        film.add_sample(0, [3e-6; 3]);
        let error = film.standard_error()[0][0];
        assert!((0.9e-6..4e-6).contains(&error), "{error}");
    }

    #[test]
    fn the_order_of_samples_does_not_matter() {
        // Summed as floats, the small ones would vanish beside the large ones.
        let samples = [
            1e9,
            1e-7,
            0.1,
            3.0,
            -2.5,
            1e-13,
            7e5,
            f32::MIN_POSITIVE,
            -1e9,
        ];
        let film = |order: &[f32]| {
            let mut film = Film::new(2, 1);
            for &value in order {
                film.add_sample(1, [value, -value, 0.5 * value]);
            }
            film
        };
        let whole = film(&samples);
        let reversed: Vec<f32> = samples.into_iter().rev().collect();
        assert_eq!(whole, film(&reversed));
        for split in 0..=samples.len() {
            let mut merged = film(&samples[..split]);
            merged.add(&film(&samples[split..]));
            assert_eq!(whole, merged);
        }
        let exact: f64 = [0.1_f32, 3.0, -2.5, 7e5]
            .iter()
            .map(|&v| f64::from(v))
            .sum();
        assert!((whole.sum(1)[0] - exact - 1e-7).abs() < 1e-9);
        assert_eq!(whole.sum(1)[0], -whole.sum(1)[1]);
        assert_eq!((whole.samples(0), whole.samples(1)), (0, 9));
        assert_eq!(whole.sample_bounds(), (0, 9));
    }

    #[test]
    fn halves_tell_the_variance_of_the_mean() {
        // Halves of 1 and 3: apart by 2, so that the mean's variance is (2/2)² = 1.
        let mut film = Film::new(1, 1);
        for number in 0..64 {
            let value = if (number / HALF_RUN).is_multiple_of(2) {
                1.0
            } else {
                3.0
            };
            film.add_sample_of_half(0, number, [value; 3]);
        }
        assert_eq!(film.mean(), vec![[2.0; 3]]);
        assert_eq!(film.variance_by_halves(0), Some([1.0; 3]));
        assert!((film.relative_error() - 0.5).abs() < 1e-6);
        let squares = film.sum_squares(0)[0];
        let spread = (squares / 64.0 - 4.0) / 63.0;
        assert!((spread - 1.0).abs() < 1e-9, "{spread}");
        // Twice the same half twice as often is the same variance.
        let mut twice = film.clone();
        twice.add(&film);
        assert_eq!(twice.variance_by_halves(0), Some([1.0; 3]));
        // One half alone tells nothing.
        let mut film = Film::new(1, 1);
        film.add_sample_of_half(0, 0, [1.0; 3]);
        assert_eq!(film.relative_error(), f64::INFINITY);
        let mut film = Film::new(1, 1);
        for number in HALF_RUN..2 * HALF_RUN {
            film.add_sample_of_half(0, number, [1.0; 3]);
        }
        assert_eq!(film.relative_error(), f64::INFINITY);
        // Light so faint that nothing is left of its squares is no second half.
        let mut film = Film::new(1, 1);
        (0..4).for_each(|_| film.add_sample(0, [1e-7; 3]));
        // Nor is anything known of its noise, but that it isn't more than there is.
        let error = film.standard_error()[0];
        assert!(
            error.iter().all(|e| (0.0..=1.01e-7).contains(e)),
            "{error:?}"
        );
    }

    #[test]
    fn samples_beyond_the_range_are_clamped() {
        let mut film = Film::new(1, 1);
        for _ in 0..3 {
            film.add_sample(0, [f32::MAX, -f32::MAX, 0.0]);
        }
        let largest = f64::from(LARGEST);
        assert_eq!(film.sum(0), [3.0 * largest, -3.0 * largest, 0.0]);
        assert_eq!(film.sum_squares(0)[0], 3.0 * f64::from(LARGEST_SQUARE));
    }
}
