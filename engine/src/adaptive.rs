//! Adaptive sampling: which parts of a picture get how many further samples, so that its error falls fastest.
//!
//! The picture is divided into blocks of 8 x 8 pixels. All get [`FIRST`] samples; then, round by round, the film tells how much the
//! samples of each block differ, and the blocks where more samples help most get them. Of N samples per pixel in a block whose
//! samples have the variance s², the error squared is s²/N, and for a given number of samples in all the sum over the blocks is
//! least where N is proportional to s (Neyman, "On the Two Different Aspects of the Representative Method", 1934). Blocks that
//! are done cost nothing any more, and those that are left keep the device busy with many samples of each: the distribution of work
//! over blocks of Frolov's thesis ("Methods for solving the global illumination problem on GPUs", 2014), with another rule.
//!
//! Where it is what is seen of the noise that is to be small, FLIP of each block takes the place of its error squared. It falls with the power
//! 0.35 of the samples, and the sum of q/N^p is least where N is proportional to q^(1/(1 + p)), of which Neyman's rule is the case of p = 1.
//!
//! What is decided depends on the film alone, whose sums are exact, and is decided only between rounds. So the picture
//! depends neither on the device's speed nor on how work was cut, and a film that was kept between two rounds can be gone on with.
//!
//! Where the samples decide how many there are, the mean of what they give may be off: light that no sample has met yet looks as if
//! there were none (Kirk and Arvo, "Unbiased Sampling Techniques for Image Synthesis", 1991). Three things keep that
//! below what can be measured: a block's spread is averaged with its neighbours', the first samples are many, and a share of all
//! further ones goes everywhere.

use crate::film::{Film, HALF_RUN, MAX_SAMPLES, Tally};
use crate::frame::BLOCK;
use crate::renderer::Lot;

/// Samples of each pixel before anything is decided, where the picture may have four times as many.
pub const FIRST: u32 = 64;
/// Blocks get samples in multiples of this: a run of each half.
pub const GRAIN: u32 = 2 * HALF_RUN;
/// A round has so many of the samples that there are before it, at most: what it decides is as rough as what they tell.
const GROWTH: f64 = 0.5;
/// Share of what an even block would get that each block gets, whatever it looks like.
const EVEN: f64 = 0.1;

/// How far a picture is to be taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal<'p> {
    /// [`Film::relative_error`] that is small enough; `None` if only the samples end it.
    pub error: Option<f64>,
    /// Mean radiance of the picture that this film is a part of, to which its error is relative; `None` where it is all of it.
    pub brightness: Option<f64>,
    /// Samples per pixel at most, on average over the picture.
    pub spp: u32,
    /// What is seen of the noise, where that is to be small and not the error.
    pub seen: Option<SeenNoise<'p>>,
}

/// What is seen of a picture's noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenNoise<'p> {
    /// FLIP of each pixel between the picture and the one without its noise, row by row.
    pub map: &'p [f32],
    /// What its mean is to be.
    pub most: f64,
}

/// FLIP of a picture's noise falls with this power of its samples: less than its error does, for FLIP makes small differences large.
pub const FLIP_FALL: f64 = 0.35;

impl Goal<'_> {
    /// That only the samples end: so many per pixel.
    pub fn of_samples(spp: u32) -> Self {
        Self {
            error: None,
            brightness: None,
            spp,
            seen: None,
        }
    }

    /// Samples that all pixels begin with.
    pub fn first(&self) -> u32 {
        (self.spp / 4 / GRAIN * GRAIN).clamp(GRAIN, FIRST)
    }
}

/// What comes next.
#[derive(Debug, Clone, PartialEq)]
pub struct Round {
    /// Work to be done, in any order; none where the goal is reached.
    pub lots: Vec<Lot>,
    /// Samples per pixel so far, on average.
    pub spp: f64,
    /// [`Film::relative_error`] so far, or that of a part.
    pub error: f64,
    /// Whether it is the error that ends the picture, where nothing comes any more.
    pub is_clean: bool,
}

/// A block of the picture as its film shows it.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    /// Pixels inside the picture.
    pixels: f64,
    /// Samples of each of them.
    samples: u32,
    /// How noisy a pixel of one sample would be, on average over the pixels: with N of them it is as noisy as this by N to the
    /// power of [`fall`].
    noise: f64,
}

/// The power of the samples with which noise falls.
fn fall(goal: &Goal<'_>) -> f64 {
    goal.seen.map_or(1.0, |_| FLIP_FALL)
}

/// What comes next for a picture whose samples come in halves and whose blocks have multiples of [`GRAIN`].
///
/// # Panics
/// Never; a film whose pixels have other numbers of samples gives rounds that make little sense.
pub fn next_round(film: &Film, goal: &Goal<'_>) -> Round {
    let columns = film.width.div_ceil(BLOCK);
    let fall = fall(goal);
    let blocks = blocks(film, goal);
    let samples = |block: &Block| block.pixels * f64::from(block.samples);
    let pixels = film.pixels() as f64;
    let total: f64 = blocks.iter().map(samples).sum();
    let tally = Tally::of(film);
    let error = (goal.brightness).map_or_else(
        || tally.relative_error(),
        |brightness| tally.error_relative_to(brightness),
    );
    let mut round = Round {
        lots: Vec::new(),
        spp: total / pixels,
        error,
        is_clean: false,
    };
    let first = goal.first();
    if blocks.iter().any(|block| block.samples < first) {
        let wanted: Vec<u32> = blocks
            .iter()
            .map(|block| first.saturating_sub(block.samples).div_ceil(GRAIN))
            .collect();
        round.lots = lots(&blocks, &wanted, round.spp);
        return round;
    }
    round.is_clean = goal.error.is_some_and(|limit| round.error <= limit);
    let budget = (pixels * f64::from(goal.spp) - total).min(GROWTH * total);
    if round.is_clean || budget < pixels.min(f64::from(GRAIN * BLOCK * BLOCK)) {
        return round;
    }
    let shares = shares(&blocks, columns as usize, fall);
    // How much of the noise may stay.
    let of_error = goal.error.map(|limit| (limit / round.error).powi(2));
    let of_seen = goal.seen.map(|seen| {
        let sum: f64 = seen.map.iter().copied().map(f64::from).sum();
        seen.most * seen.map.len() as f64 / sum
    });
    // A mean that is small enough may leave spots that aren't.
    let keep = of_seen.or(of_error).filter(|&keep| keep < 1.0);
    let wanted = distribute(
        &blocks,
        &shares,
        &Rule {
            budget,
            keep: 0.97 * keep.unwrap_or_default(),
            fall,
        },
    );
    round.lots = lots(&blocks, &wanted, round.spp);
    round
}

/// The blocks of a film, row by row.
fn blocks(film: &Film, goal: &Goal<'_>) -> Vec<Block> {
    let (columns, rows) = (film.width.div_ceil(BLOCK), film.height.div_ceil(BLOCK));
    let block = |at: u32| {
        let (left, top) = (at % columns * BLOCK, at / columns * BLOCK);
        let (right, bottom) = (film.width.min(left + BLOCK), film.height.min(top + BLOCK));
        let places = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
        let mut block = Block {
            samples: u32::MAX,
            ..Block::default()
        };
        for (x, y) in places {
            let pixel = y as usize * film.width as usize + x as usize;
            block.pixels += 1.0;
            block.samples = block.samples.min(film.samples(pixel));
            let n = f64::from(film.samples(pixel));
            block.noise += match goal.seen {
                Some(seen) => n.powf(FLIP_FALL) * f64::from(seen.map[pixel]),
                None => film
                    .variance_by_halves(pixel)
                    .map_or(0.0, |of_mean| n * of_mean.iter().sum::<f64>() / 3.0),
            };
        }
        block.noise /= block.pixels;
        block
    };
    (0..columns * rows).map(block).collect()
}

/// What number of samples each block should have, but for a factor: the spread of its samples, in which its neighbours' are seen,
/// too, and some of everybody's.
fn shares(blocks: &[Block], columns: usize, fall: f64) -> Vec<f64> {
    let rows = blocks.len() / columns.max(1);
    let spread = |at: usize| {
        let (x, y) = (at % columns, at / columns);
        let (mut sum, mut weights) = (0.0, 0.0);
        for v in y.saturating_sub(1)..(y + 2).min(rows) {
            for u in x.saturating_sub(1)..(x + 2).min(columns) {
                // Binomial: a quarter of the sum is the block's own.
                let weight = [2.0, 1.0][x.abs_diff(u)] * [2.0, 1.0][y.abs_diff(v)];
                sum += weight * blocks[v * columns + u].noise;
                weights += weight;
            }
        }
        (sum / weights)
            .max(blocks[at].noise * 0.5)
            .powf(1.0 / (1.0 + fall))
    };
    let spreads: Vec<f64> = (0..blocks.len()).map(spread).collect();
    let mean = spreads.iter().sum::<f64>() / spreads.len().max(1) as f64;
    let least = EVEN * mean;
    spreads.into_iter().map(|spread| spread + least).collect()
}

/// How much is distributed.
struct Rule {
    /// Samples of pixels in all, at most.
    budget: f64,
    /// As many of them as are needed for so much of the noise to be left.
    keep: f64,
    /// The power of the samples with which noise falls.
    fall: f64,
}

/// How many grains each block gets.
fn distribute(blocks: &[Block], shares: &[f64], rule: &Rule) -> Vec<u32> {
    let &Rule { budget, keep, fall } = rule;
    let grain = f64::from(GRAIN);
    let target = |block: &Block, share: f64, scale: f64| {
        (scale * share).clamp(f64::from(block.samples), f64::from(MAX_SAMPLES - GRAIN))
    };
    let with = |of: &dyn Fn(&Block, f64) -> f64, scale: f64| -> f64 {
        let each = blocks.iter().zip(shares);
        each.map(|(block, &share)| of(block, target(block, share, scale)))
            .sum()
    };
    let cost = |block: &Block, n: f64| block.pixels * (n - f64::from(block.samples));
    let noise = |block: &Block, n: f64| block.pixels * block.noise / n.max(1.0).powf(fall);
    let now = with(&noise, 0.0);
    // The largest scale that the budget allows, unless a smaller one does. Both sums are monotonic in it.
    let (mut low, mut high) = (0.0, 1.0);
    let is_too_much = |scale: f64| with(&cost, scale) > budget || with(&noise, scale) < keep * now;
    while high < 1e30 && !is_too_much(high) {
        high *= 2.0;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match is_too_much(middle) {
            true => high = middle,
            false => low = middle,
        }
    }
    let missing = |(block, &share): (&Block, &f64)| {
        (target(block, share, high) - f64::from(block.samples)) / grain
    };
    let round_up = |least: f64| -> Vec<u32> {
        let each = blocks.iter().zip(shares).map(missing);
        each.map(|grains| (grains + 1.0 - least).floor().max(0.0) as u32)
            .collect()
    };
    // Grains are rounded to the nearest; where all would get none, those get one that want most.
    for least in [0.5, 0.25, 0.1, 0.01] {
        let mut grains = round_up(least);
        if grains.iter().all(|&grains| grains == 0) {
            continue;
        }
        // What rounding has given beyond the budget is taken back from those that were rounded up most.
        let rounded_up: Vec<f64> = (blocks.iter().zip(shares).map(missing))
            .zip(&grains)
            .map(|(missing, &grains)| f64::from(grains) - missing)
            .collect();
        let mut order: Vec<usize> = (0..blocks.len()).filter(|&at| grains[at] > 0).collect();
        order.sort_by(|&a, &b| rounded_up[b].total_cmp(&rounded_up[a]));
        order.pop(); // so that a grain is left
        let given = blocks.iter().zip(&grains);
        let mut spent: f64 = given
            .map(|(block, &grains)| block.pixels * f64::from(grains) * grain)
            .sum();
        for at in order {
            if spent <= budget {
                break;
            }
            grains[at] -= 1;
            spent -= blocks[at].pixels * grain;
        }
        return grains;
    }
    let wishes: Vec<f64> = (blocks.iter().zip(shares))
        .map(|(block, share)| share / f64::from(block.samples))
        .collect();
    let most = wishes.iter().copied().fold(0.0, f64::max);
    wishes
        .iter()
        .map(|&wish| u32::from(wish >= 0.9 * most))
        .collect()
}

/// Work by which each block gets so many grains: by the binary digits of their number, so that a wave has as many samples of each
/// of its blocks. `spp` are the samples per pixel so far.
fn lots(blocks: &[Block], grains: &[u32], spp: f64) -> Vec<Lot> {
    let digits = grains
        .iter()
        .map(|grains| grains.checked_ilog2().map_or(0, |log| log + 1));
    let lot = |digit: u32| {
        let mut lot = Lot {
            blocks: Vec::new(),
            samples: GRAIN << digit,
            before: spp as u32,
        };
        for (at, (block, &grains)) in blocks.iter().zip(grains).enumerate() {
            if grains >> digit & 1 != 0 {
                let before = grains & ((1 << digit) - 1);
                lot.blocks.push([at as u32, block.samples + GRAIN * before]);
            }
        }
        lot
    };
    let lots = (0..digits.max().unwrap_or(0)).map(lot);
    lots.filter(|lot| !lot.blocks.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A film of blocks in a row, each with samples of a spread: those of the halves lie this far from 1 on both sides.
    fn film(spreads: &[f32], samples: u32) -> Film {
        let mut film = Film::new(8 * spreads.len() as u32, 8);
        for (block, &spread) in spreads.iter().enumerate() {
            // As far apart as the means of halves of so many samples are.
            let apart = spread / (samples as f32).sqrt();
            for pixel in 0..64 {
                let at = pixel / 8 * film.width as usize + 8 * block + pixel % 8;
                for number in 0..samples {
                    let is_first = (number / HALF_RUN).is_multiple_of(2);
                    let value = if is_first { 1.0 + apart } else { 1.0 - apart };
                    film.add_sample_of_half(at, number, [value; 3]);
                }
            }
        }
        film
    }

    fn spp(film: &Film, lots: &[Lot]) -> Vec<u32> {
        let columns = film.width / BLOCK;
        let mut samples: Vec<u32> = (0..columns)
            .map(|at| film.samples(8 * at as usize))
            .collect();
        // Lots may come in any order, but each says where it goes on.
        let mut pieces: Vec<_> = lots
            .iter()
            .flat_map(|lot| lot.blocks.iter().map(move |block| (block, lot.samples)))
            .collect();
        pieces.sort();
        for (&[at, first], count) in pieces {
            assert_eq!(samples[at as usize], first);
            samples[at as usize] += count;
        }
        samples
    }

    #[test]
    fn all_begin_with_the_same_samples() {
        let empty = Film::new(20, 9);
        let goal = Goal::of_samples(1024);
        let round = next_round(&empty, &goal);
        let blocks = (0..6).map(|at| [at, 0]).collect();
        assert_eq!(
            round.lots,
            [Lot {
                blocks,
                samples: FIRST,
                before: 0,
            }]
        );
        let few = next_round(&empty, &Goal { spp: 40, ..goal });
        assert_eq!(few.lots[0].samples, GRAIN);
    }

    #[test]
    fn samples_go_where_they_differ() {
        let mut spreads = [0.05_f32; 12];
        spreads[5] = 4.0;
        let film = film(&spreads, FIRST);
        let goal = Goal::of_samples(1024);
        let round = next_round(&film, &goal);
        assert!((round.spp - 64.0).abs() < 1e-9 && !round.is_clean);
        let samples = spp(&film, &round.lots);
        assert!(
            samples[5] > samples[4] && samples[4] > samples[1],
            "{samples:?}"
        );
        assert_eq!(samples[0], 64);
        let added: u32 = samples.iter().map(|n| n - 64).sum();
        assert!(
            (250..=450).contains(&added),
            "{samples:?}: a half of 768, in grains"
        );
    }

    #[test]
    fn the_error_ends_it() {
        let film = film(&[1.0; 4], 64);
        let error = film.relative_error();
        assert!((error - 1.0 / 8.0).abs() < 1e-3, "{error}");
        let goal = Goal {
            error: Some(0.13),
            ..Goal::of_samples(4096)
        };
        let round = next_round(&film, &goal);
        assert!(round.is_clean && round.lots.is_empty());
        // What is just missing is added, not half of all.
        let goal = Goal {
            error: Some(0.11),
            ..goal
        };
        let samples = spp(&film, &next_round(&film, &goal).lots);
        assert_eq!(samples, [96; 4]);
        // And the samples end it, too.
        let goal = Goal::of_samples(64);
        assert!(next_round(&film, &goal).lots.is_empty());
    }

    #[test]
    fn neyman_is_reached_in_the_end() {
        // 4 times the spread is 4 times the samples; with a tenth of the mean for all: (4 + 0.25) / (1 + 0.25).
        let ratio = in_the_end(1.0);
        assert!((3.0..3.8).contains(&ratio), "{ratio}");
        // 16^(1/1.35) is 7.8: (7.8 + 0.44) / (1 + 0.44).
        let ratio = in_the_end(FLIP_FALL);
        assert!((5.0..6.2).contains(&ratio), "{ratio}");
    }

    /// How many times the samples blocks have that are 16 times as noisy.
    fn in_the_end(fall: f64) -> f64 {
        // Blocks far apart, so that neighbours say nothing.
        let noise = [1.0, 1.0, 1.0, 1.0, 16.0, 16.0, 16.0, 16.0];
        let mut samples = [64_u32; 8];
        for _ in 0..20 {
            let mut blocks: Vec<Block> = Vec::new();
            for (&noise, &n) in noise.iter().zip(&samples) {
                blocks.push(Block {
                    pixels: 64.0,
                    samples: n,
                    noise,
                });
            }
            let total: u32 = samples.iter().sum();
            let total = f64::from(total);
            let budget = 64.0 * (8.0 * 1024.0 - total).clamp(0.0, GROWTH * total);
            let rule = Rule {
                budget,
                keep: 0.0,
                fall,
            };
            let grains = distribute(&blocks, &shares(&blocks, 8, fall), &rule);
            for (n, grains) in samples.iter_mut().zip(grains) {
                *n += GRAIN * grains;
            }
        }
        f64::from(samples[7]) / f64::from(samples[0])
    }

    #[test]
    fn samples_go_where_noise_is_seen() {
        // All blocks are as noisy, and in one of them it shows.
        let film = film(&[1.0; 8], FIRST);
        let map: Vec<f32> = (0..film.pixels())
            .map(|pixel| [0.02, 0.2][usize::from(pixel % 64 / 8 == 5)])
            .collect();
        let seen = |most| Goal {
            seen: Some(SeenNoise { map: &map, most }),
            ..Goal::of_samples(4096)
        };
        let samples = spp(&film, &next_round(&film, &seen(0.03)).lots);
        assert!(
            samples[5] > samples[4] && samples[4] >= samples[1],
            "{samples:?}"
        );
        // The mean is 0.0425: what is just missing is added.
        let few = spp(&film, &next_round(&film, &seen(0.042)).lots);
        let added = |samples: &[u32]| samples.iter().map(|n| n - 64).sum::<u32>();
        assert!(added(&few) < added(&samples), "{few:?}, {samples:?}");
    }

    #[test]
    fn what_is_black_ends() {
        let film = film(&[0.0; 4], 64);
        let goal = Goal {
            error: Some(0.01),
            ..Goal::of_samples(4096)
        };
        let round = next_round(&film, &goal);
        assert!(round.is_clean, "{round:?}");
        let mut black = Film::new(8, 8);
        for pixel in 0..64 {
            for number in 0..64 {
                black.add_sample_of_half(pixel, number, [0.0; 3]);
            }
        }
        // Nothing is known of what nothing was seen of, until that is hundreds of samples.
        let round = next_round(&black, &goal);
        assert!(!round.is_clean && !round.lots.is_empty());
        let same = black.clone();
        (0..3).for_each(|_| black.add(&same));
        assert!(next_round(&black, &goal).is_clean);
    }
}
