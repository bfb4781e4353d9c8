//! How far a biased picture is from the truth, as a few paths tell that know nothing of it.
//!
//! Given are the halves of the picture, C and C', whose noise is independent, and two pictures A and B of few paths each, which are right
//! on average. Then (C - A)(C' - B) is on average the square of what is wrong with C, however noisy all four are. The means of blocks of
//! pixels take the place of single ones, for their noise is less, and what is wrong with a picture of cached light is wrong for
//! many neighbours. How sure that is, the spread over the blocks says: all of them are drawn again many times (Efron, "Bootstrap Methods:
//! Another Look at the Jackknife", 1979).
//!
//! What no path of A and B met, the blocks can't say: a highlight that one path in thousands finds looks like a picture that is too bright,
//! the same however the blocks are drawn. The picture knows more of it, for it has more samples. What its halves differ by tells the
//! spread of one of its samples, and that tells how far so few of them stray; what is said is never surer than that. Only what a cache
//! gives and a path would have to look for is spread less there, and that the blocks show.

use std::ops::Range;

use crate::film::Film;
use crate::frame::BLOCK;

/// Samples per pixel of each of the two pictures that are compared with.
pub const SAMPLES: u32 = 2;
/// Times that blocks are drawn anew.
const DRAWS: usize = 400;
/// Of these, so many are left out at each end: 95 % of them lie between.
const LEFT_OUT: usize = DRAWS / 40;
/// Standard deviations to either side within which 95 % of a normal distribution lie.
const WITHIN: f64 = 1.96;

/// What is wrong with a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Audit {
    /// How much too bright it is as a whole, relative; with 95 % certainty.
    pub brightness: Range<f64>,
    /// How far blocks of 8 x 8 pixels are off: root of the mean square, relative to the mean radiance of the picture; with 95 %
    /// certainty.
    pub blocks: Range<f64>,
}

/// Blocks that there have to be: how much fewer of them differ says nothing of how sure their mean is.
const LEAST_BLOCKS: usize = 16;

/// A block, sums over its channels.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    /// Numbers in it.
    count: f64,
    /// Of (C + C')/2 and of (A + B)/2.
    picture: f64,
    truth: f64,
    /// (C - A)(C' - B) of the block's means, times the count.
    square: f64,
    /// Variances of what noise does to `picture - truth` and to `square`, as the halves of the picture tell them.
    brightness_variance: f64,
    square_variance: f64,
}

impl Block {
    fn plus(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            picture: self.picture + other.picture,
            truth: self.truth + other.truth,
            square: self.square + other.square,
            brightness_variance: self.brightness_variance + other.brightness_variance,
            square_variance: self.square_variance + other.square_variance,
        }
    }
}

/// Largest error of the brightness, and of blocks, of a picture that is taken for right: of the mean radiance.
const FINE: [f64; 2] = [0.01, 0.03];

impl Audit {
    /// Whether more is wrong than may be, with certainty: of what isn't certain, more samples tell.
    pub fn is_wrong(&self) -> bool {
        let brightness = self.brightness.start.max(-self.brightness.end);
        brightness > FINE[0] || self.blocks.start > FINE[1]
    }

    /// Of a picture whose samples come in halves, by two others of the same size. `None` where there is nothing to compare: too few
    /// samples or pixels, or all is black.
    pub fn new(picture: &Film, truth: [&Film; 2]) -> Option<Self> {
        let mut comparison = Comparison::default();
        comparison.add(picture, truth);
        comparison.audit()
    }
}

/// Most blocks that a comparison holds: of more, neighbours are taken together.
const MOST_BLOCKS: usize = 1 << 16;

/// A picture beside two others, that may come piece by piece. However large the picture is, this is not.
#[derive(Debug, Clone, Default)]
pub struct Comparison {
    blocks: Vec<Block>,
    /// How many of the picture's each stands for is two to this power.
    doublings: u32,
    /// Of the next one, and how many of the picture's it has.
    begun: (Block, u32),
    /// A piece had too few samples for two halves.
    is_unknown: bool,
}

impl Comparison {
    /// Adds a piece whose samples come in halves, and what two others of the same size show there. One with too few samples leaves the
    /// whole unknown.
    pub fn add(&mut self, picture: &Film, truth: [&Film; 2]) {
        match blocks(picture, truth) {
            Some(blocks) => blocks.into_iter().for_each(|block| self.push(block)),
            None => self.is_unknown = true,
        }
    }

    fn push(&mut self, block: Block) {
        let (sums, count) = self.begun;
        self.begun = (sums.plus(block), count + 1);
        if self.begun.1 < 1 << self.doublings {
            return;
        }
        self.blocks.push(std::mem::take(&mut self.begun).0);
        if self.blocks.len() == MOST_BLOCKS {
            let pairs = self.blocks.chunks(2);
            let pairs = pairs.map(|pair| pair.iter().copied().fold(Block::default(), Block::plus));
            self.blocks = pairs.collect();
            self.doublings += 1;
        }
    }

    /// What is wrong with all that was added; `None` as for [`Audit::new`].
    pub fn audit(&self) -> Option<Audit> {
        let mut blocks = self.blocks.clone();
        blocks.extend(Some(self.begun.0).filter(|_| self.begun.1 > 0));
        if self.is_unknown || blocks.len() < LEAST_BLOCKS {
            return None;
        }
        let brightness = |sums: Block, stray: f64| (sums.picture + stray) / sums.truth - 1.0;
        let square = |sums: Block, stray: f64| {
            (sums.square + stray) / sums.count / (sums.truth / sums.count).powi(2)
        };
        let sums = blocks.iter().copied().fold(Block::default(), Block::plus);
        let [brightness_stray, square_stray] =
            [sums.brightness_variance, sums.square_variance].map(|v| WITHIN * v.sqrt());
        let squares = hull(
            certain(&blocks, |sums| square(sums, 0.0)),
            square(sums, -square_stray)..square(sums, square_stray),
        );
        // Of what is nearly right the square may come out below 0, by luck: as far above is no less likely.
        let luck = square(sums, 0.0).min(0.0);
        let off = |square: f64| (square - luck).max(0.0).sqrt();
        let audit = Audit {
            brightness: hull(
                certain(&blocks, |sums| brightness(sums, 0.0)),
                brightness(sums, -brightness_stray)..brightness(sums, brightness_stray),
            ),
            blocks: off(squares.start)..off(squares.end),
        };
        let ends = [&audit.brightness, &audit.blocks];
        let is_known = ends
            .iter()
            .all(|range| range.start.is_finite() && range.end.is_finite());
        is_known.then_some(audit)
    }
}

/// The blocks of a picture.
fn blocks(picture: &Film, truth: [&Film; 2]) -> Option<Vec<Block>> {
    let (width, height) = (picture.width, picture.height);
    let (columns, rows) = (width.div_ceil(BLOCK), height.div_ceil(BLOCK));
    let means = truth.map(Film::mean);
    let block = |at: u32| {
        let (left, top) = (at % columns * BLOCK, at / columns * BLOCK);
        let (mut sums, mut count) = ([[0.0; 3]; 4], 0.0);
        let (mut brightness_variance, mut product_deviation) = (0.0, 0.0);
        for y in top..height.min(top + BLOCK) {
            for x in left..width.min(left + BLOCK) {
                let pixel = y as usize * width as usize + x as usize;
                let [first, second] = picture.half_means(pixel)?;
                let [a, b] = [&means[0], &means[1]].map(|mean| mean[pixel].map(f64::from));
                for (sum, value) in sums.iter_mut().zip([first, second, a, b]) {
                    for (sum, value) in sum.iter_mut().zip(value) {
                        *sum += value;
                    }
                }
                count += 1.0;
                // A mean of so many fewer samples strays so much more.
                let fewer = f64::from(picture.samples(pixel)) / f64::from(truth[0].samples(pixel));
                let variance = picture.variance_by_halves(pixel)?;
                // At worst the channels' noise is one.
                let deviation: f64 = variance.iter().map(|v| v.sqrt()).sum();
                brightness_variance += deviation * deviation * (1.0 + 0.5 * fewer);
                product_deviation += variance.iter().sum::<f64>() * (2.0 + fewer);
            }
        }
        let [c, d, a, b] = sums;
        let sum = |x: [f64; 3]| x.iter().sum::<f64>();
        Some(Block {
            count: 3.0 * count,
            picture: 0.5 * (sum(c) + sum(d)),
            truth: 0.5 * (sum(a) + sum(b)),
            square: (0..3).map(|i| (c[i] - a[i]) * (d[i] - b[i])).sum::<f64>() / count,
            brightness_variance,
            square_variance: (product_deviation / count).powi(2),
        })
    };
    (0..columns * rows).map(block).collect()
}

/// A range that has both in it.
fn hull(one: Range<f64>, other: Range<f64>) -> Range<f64> {
    one.start.min(other.start)..one.end.max(other.end)
}

/// Between what bounds a number lies that depends on all blocks, with 95 % certainty.
fn certain(blocks: &[Block], of: impl Fn(Block) -> f64) -> Range<f64> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut draw = || {
        // A step of Knuth's generator; its upper bits are random enough to pick blocks.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        blocks[((state >> 33) as usize) % blocks.len()]
    };
    let mut draws: Vec<f64> = (0..DRAWS)
        .map(|_| of((0..blocks.len()).fold(Block::default(), |sums, _| sums.plus(draw()))))
        .collect();
    draws.sort_by(f64::total_cmp);
    draws[LEFT_OUT]..draws[DRAWS - 1 - LEFT_OUT]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A film of noise around a brightness, in runs of both halves.
    fn noise(seed: u64, brightness: f32, spread: f32, samples: u32) -> Film {
        noise_in(0..64, seed, [brightness, spread], samples)
    }

    /// Some rows of it.
    fn noise_in(rows: Range<u32>, seed: u64, [brightness, spread]: [f32; 2], samples: u32) -> Film {
        film_of(rows, seed, samples, |_, uniform| {
            brightness + spread * (uniform - 0.5)
        })
    }

    /// Rows of a film of samples, each by its pixel and a number between 0 and 1.
    fn film_of(
        rows: Range<u32>,
        seed: u64,
        samples: u32,
        sample: impl Fn(usize, f32) -> f32,
    ) -> Film {
        let mut film = Film::new(64, rows.end - rows.start);
        let (first, pixels) = (64 * rows.start as usize, film.pixels());
        let mut state = seed << 40;
        for pixel in 0..first + pixels {
            for number in 0..samples {
                // SplitMix64 (Steele, Lea and Flood 2014).
                state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
                let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                let radiance = sample(pixel, (mixed >> 40) as f32 / 16_777_216.0);
                if let Some(pixel) = pixel.checked_sub(first) {
                    film.add_sample_of_half(pixel, number, [radiance; 3]);
                }
            }
        }
        film
    }

    #[test]
    fn what_is_wrong_is_found_below_the_noise() {
        let (a, b) = (noise(1, 1.0, 2.0, 2), noise(2, 1.0, 2.0, 2));
        let wrong = Audit::new(&noise(3, 1.05, 2.0, 32), [&a, &b]).expect("there is light");
        assert!(wrong.is_wrong(), "{wrong:?}");
        assert!(wrong.brightness.contains(&0.05), "{wrong:?}");
        assert!(wrong.blocks.contains(&0.05), "{wrong:?}");
        assert!(
            wrong.brightness.start > 0.02 && wrong.blocks.start > 0.02,
            "{wrong:?}"
        );
        let right = Audit::new(&noise(4, 1.0, 2.0, 32), [&a, &b]).expect("there is light");
        assert!(!right.is_wrong(), "{right:?}");
        assert!(right.brightness.contains(&0.0), "{right:?}");
        assert!(
            right.blocks.start < 0.01 && right.blocks.end < 0.04,
            "{right:?}"
        );
    }

    #[test]
    fn a_highlight_that_few_paths_find_is_no_error() {
        // In four of the 64 blocks one path in 500 brings a fourth of all light, and the truth's 1024 paths there find it twice.
        let film = |seed, samples| {
            film_of(0..64, seed, samples, |pixel, uniform| {
                let (x, y) = (pixel % 64, pixel / 64);
                let is_in = (24..32).contains(&x) && (16..48).contains(&y);
                1.0 + if is_in && uniform < 0.002 {
                    3000.0
                } else {
                    0.5 * uniform
                }
            })
        };
        let wrong = (0..40).filter(|&seed| {
            let [a, b] = [3 * seed + 1, 3 * seed + 2].map(|seed| film(seed, 2));
            let audit = Audit::new(&film(3 * seed + 3, 64), [&a, &b]).expect("there is light");
            audit.is_wrong()
        });
        // Of 95 % certainty, each way; by the blocks alone it is 10 of them.
        assert!(wrong.count() <= 4);
    }

    #[test]
    fn pieces_say_what_the_whole_does() {
        let films = |rows: Range<u32>| {
            [(3, 32), (1, 2), (2, 2)]
                .map(|(seed, spp)| noise_in(rows.clone(), seed, [1.0, 2.0], spp))
        };
        let [picture, a, b] = films(0..64);
        let whole = Audit::new(&picture, [&a, &b]);
        let mut pieces = Comparison::default();
        for rows in [0..16, 16..48, 48..64] {
            let [picture, a, b] = films(rows);
            pieces.add(&picture, [&a, &b]);
        }
        assert_eq!(pieces.audit(), whole);
        pieces.add(&Film::new(64, 8), [&Film::new(64, 8), &Film::new(64, 8)]);
        assert_eq!(pieces.audit(), None, "a piece without samples");
    }

    #[test]
    fn however_many_blocks_there_are_few_are_held() {
        let mut many = Comparison::default();
        let block = Block {
            count: 192.0,
            picture: 101.0,
            truth: 100.0,
            square: 0.5,
            ..Block::default()
        };
        for _ in 0..3 * MOST_BLOCKS + 1 {
            many.push(block);
        }
        assert!(many.blocks.len() < MOST_BLOCKS, "{}", many.blocks.len());
        let held = many.blocks.iter().chain([&many.begun.0]);
        let sums = held.copied().fold(Block::default(), Block::plus);
        assert_eq!(sums.count, 192.0 * (3 * MOST_BLOCKS + 1) as f64);
        let audit = many.audit().expect("there is light");
        assert!((audit.brightness.start - 0.01).abs() < 1e-9, "{audit:?}");
    }

    #[test]
    fn nothing_is_known_of_too_little() {
        let black = noise(1, 0.0, 0.0, 2);
        assert_eq!(Audit::new(&noise(3, 0.0, 0.0, 32), [&black, &black]), None);
        let few = noise(3, 1.0, 0.0, 16);
        assert_eq!(Audit::new(&few, [&few, &few]), None, "one half alone");
        let mut dot = Film::new(1, 1);
        for number in 0..64 {
            dot.add_sample_of_half(0, number, [1.0; 3]);
        }
        assert_eq!(Audit::new(&dot, [&dot, &dot]), None, "a single block");
    }
}
