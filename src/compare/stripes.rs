//! The distance of large layers, by some rows of them at a time: what a comparison takes beside the layers is then that of a stripe,
//! and a number of each pixel.

use std::fs;
use std::path::{Path, PathBuf};

use engine::input;
use pictures::{Channel, Distance, DistanceError, Facts, Layer};

use crate::failure::Failure;
use crate::left::left;
use crate::picture::MAX_FILE;

use super::job::CompareJob;

/// Pixels that are compared at once.
const PIXELS: usize = 1 << 22;
/// Rows on either side that FLIP looks at, and some more: its kernels reach ten pixels.
const REACH: usize = 16;
/// Bytes of each of those pixels, about: what is shown of them, and the planes of FLIP.
const AT_ONCE: u64 = 192;
/// Bytes of a number of a layer while it is read: the layer, and the picture that it is of.
const READ: u64 = 8;
/// The same once it is read.
const KEPT: u64 = 4;
/// Bytes of a pixel of the map of differences.
const MAP: u64 = 4;
/// Bytes of a pixel of the picture that is made of it: its colours, and what is written of them.
const SHOWN: u64 = 8;

/// As [`Distance::between`], which takes many times the memory.
///
/// # Errors
/// As of that.
pub(super) fn distance(
    layer: &Layer,
    reference: &Layer,
    exposure: f32,
) -> Result<Distance, DistanceError> {
    by_rows(layer, reference, exposure, rows_of(layer.size[0]))
}

/// Rows of a stripe of so many columns. Between two seams there have to be as many as both look at.
fn rows_of(width: usize) -> usize {
    (PIXELS / width.max(1)).max(2 * REACH)
}

fn by_rows(
    layer: &Layer,
    reference: &Layer,
    exposure: f32,
    rows: usize,
) -> Result<Distance, DistanceError> {
    let [width, height] = layer.size;
    if layer.size != reference.size || height <= rows {
        return Distance::between(layer, reference, exposure);
    }
    // What is behind them is behind the whole of them.
    let are_covering = layer.is_covering() && reference.is_covering();
    let between = |from: usize, to: usize| {
        let [layer, reference] = [layer, reference].map(|whole| stripe(whole, from, to));
        Distance::of_parts(&layer, &reference, exposure, are_covering)
    };
    let mut sum = Sum::default();
    let mut map = Vec::with_capacity(width * height);
    let mut largest_of_stripes = Vec::new();
    for from in (0..height).step_by(rows) {
        let to = (from + rows).min(height);
        let mut of_stripe = between(from, to)?;
        sum.add(&of_stripe, (to - from) * width);
        largest_of_stripes.push(of_stripe.largest);
        map.append(&mut of_stripe.map);
    }
    let is_seen = sum.squares.is_some();
    if is_seen {
        // At seams FLIP took the border of a stripe for that of the picture.
        for seam in (rows..height).step_by(rows) {
            let (from, to) = (seam - REACH, (seam + REACH).min(height));
            let above = from.saturating_sub(REACH);
            let around = between(above, (to + REACH).min(height))?;
            let whole = &around.map[(from - above) * width..(to - above) * width];
            map[from * width..to * width].copy_from_slice(whole);
        }
    } else {
        // Differences of each stripe are shares of its own largest one.
        for (of_stripe, largest) in map.chunks_mut(rows * width).zip(largest_of_stripes) {
            let share = match (largest.is_finite(), sum.largest.is_finite()) {
                (true, true) => largest / sum.largest.max(f64::MIN_POSITIVE),
                (true, false) => 0.0,
                // 1 is infinite there, and all others are 0.
                (false, _) => 1.0,
            };
            of_stripe
                .iter_mut()
                .for_each(|value| *value = (f64::from(*value) * share) as f32);
        }
    }
    Ok(sum.distance(map))
}

/// Some rows of a layer.
fn stripe(layer: &Layer, from: usize, to: usize) -> Layer {
    let width = layer.size[0];
    let channels = layer.channels.iter().map(|channel| Channel {
        name: channel.name.clone(),
        values: channel.values[from * width..to * width].to_vec(),
    });
    Layer {
        name: layer.name.clone(),
        size: [width, to - from],
        channels: channels.collect(),
    }
}

/// The figures of stripes, by their pixels.
#[derive(Default)]
struct Sum {
    pixels: f64,
    mse: f64,
    relative_mse: f64,
    largest: f64,
    changed: f64,
    /// Squared differences of what is shown, where there are colours.
    squares: Option<f64>,
}

impl Sum {
    fn add(&mut self, of_stripe: &Distance, pixels: usize) {
        let pixels = pixels as f64;
        self.pixels += pixels;
        self.mse += of_stripe.mse * pixels;
        self.relative_mse += of_stripe.relative_mse * pixels;
        self.largest = self.largest.max(of_stripe.largest);
        self.changed += of_stripe.changed * pixels;
        if let Some(psnr) = of_stripe.psnr {
            *self.squares.get_or_insert(0.0) += 10_f64.powf(-0.1 * psnr) * pixels;
        }
    }

    fn distance(self, map: Vec<f32>) -> Distance {
        let mean = |sum: f64| sum / self.pixels;
        let flip = || match self.largest.is_finite() {
            true => mean(map.iter().copied().map(f64::from).sum()),
            false => f64::INFINITY,
        };
        Distance {
            mse: mean(self.mse),
            relative_mse: mean(self.relative_mse),
            largest: self.largest,
            changed: mean(self.changed),
            psnr: self.squares.map(|squares| -10.0 * mean(squares).log10()),
            flip: self.squares.map(|_| flip()),
            map,
        }
    }
}

/// Makes sure that there is memory for a comparison, before files are read: a program that finds none later is ended by the system. Of
/// films, whose numbers are those of the file, and of what is no picture that is known, nothing is said.
///
/// # Errors
/// There is less than it takes.
pub(super) fn check(job: &CompareJob) -> Result<(), Failure> {
    let files = [&job.picture, &job.reference];
    let [Some(picture), Some(reference)] = files.map(|path| Numbers::of(path)) else {
        return Ok(());
    };
    let need = Need::of(&picture, &reference, job.diff.is_some());
    // What the system has left isn't asked about the usual sizes.
    if picture.pixels.max(reference.pixels) <= PIXELS as u64 {
        return Ok(());
    }
    need.check(files, left())?;
    // Limits of a process (`ulimit -v`) are told only by trying. Nothing is written to it.
    let is_there = usize::try_from(need.0).is_ok_and(|need| {
        let mut probe: Vec<u8> = Vec::new();
        probe.try_reserve_exact(need).is_ok()
    });
    match is_there {
        true => Ok(()),
        false => Err(need.refused(files, "which the system doesn't give")),
    }
}

/// How much a file holds.
struct Numbers {
    /// Its bytes.
    bytes: u64,
    /// Of the largest part.
    pixels: u64,
    /// Numbers of all pixels of all parts.
    all: u64,
}

impl Numbers {
    /// By the beginning of the file; `None` where it doesn't say it, or can't be read: whoever reads it says why.
    fn of(path: &Path) -> Option<Self> {
        // Devices and pipes, which can be read once, are none.
        let file = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
        let bytes = input::read(path, MAX_FILE).ok()?;
        let facts = Facts::read(&bytes).ok()?;
        let pixels = |part: &pictures::PartFacts| part.width as u64 * part.height as u64;
        let numbers = facts.parts.iter().map(|part| {
            // All other files are read as red, green and blue, and alpha.
            let channels = match facts.format == "OpenEXR" {
                true => part.channels.len(),
                false => 4,
            };
            pixels(part) * channels as u64
        });
        Some(Self {
            bytes: file.len(),
            pixels: facts.parts.iter().map(pixels).max()?,
            all: numbers.sum(),
        })
    }
}

/// Bytes of a comparison at its largest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Need(u64);

impl Need {
    fn of(picture: &Numbers, reference: &Numbers, is_shown: bool) -> Self {
        // Numbers of a layer are at most those of its file, and of four channels.
        let kept = |of: &Numbers| KEPT * of.all.min(4 * of.pixels);
        let read = |of: &Numbers| of.bytes + READ * of.all;
        let reading = read(picture).max(kept(picture) + read(reference));
        let of_map = MAP + if is_shown { SHOWN } else { 0 };
        let comparing = kept(picture)
            + kept(reference)
            + of_map * picture.pixels
            + AT_ONCE * picture.pixels.min(PIXELS as u64);
        Self(reading.max(comparing))
    }

    fn check(self, files: [&PathBuf; 2], left: Option<u64>) -> Result<(), Failure> {
        match left {
            Some(left) if self.0 > left => {
                Err(self.refused(files, &format!("but {} are left", shown(left))))
            }
            _ => Ok(()),
        }
    }

    fn refused(self, [picture, reference]: [&PathBuf; 2], because: &str) -> Failure {
        Failure::Failed(format!(
            "{} and {}: to compare them takes about {} of memory, {because}: compare parts of them, or smaller pictures",
            picture.display(),
            reference.display(),
            shown(self.0)
        ))
    }
}

/// Bytes as people read them.
fn shown(bytes: u64) -> String {
    format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [23, 101];

    /// Numbers from 0 to 1 that look like none.
    fn noise(seed: u32) -> Vec<f32> {
        let count = (SIZE[0] * SIZE[1]) as u32;
        let at = |pixel: u32| (pixel + 7 * seed).wrapping_mul(0x9e37_79b9) >> 8;
        (0..count)
            .map(|pixel| at(pixel) as f32 / (1 << 24) as f32)
            .collect()
    }

    fn layer(names: &[&str], seed: u32) -> Layer {
        let channels = names.iter().zip(seed..).map(|(name, seed)| Channel {
            name: (*name).to_owned(),
            values: noise(seed),
        });
        Layer::new(String::new(), SIZE, channels.collect())
    }

    fn assert_alike(a: &Layer, b: &Layer) {
        let whole = Distance::between(a, b, 0.5).expect("alike");
        // With a last stripe that is large, and one of a single row.
        for rows in [40, 50] {
            let found = by_rows(a, b, 0.5, rows).expect("alike");
            assert_eq!(found.map.len(), whole.map.len());
            let differ = found.map.iter().zip(&whole.map).map(|(a, b)| (a - b).abs());
            assert!(differ.fold(0.0, f32::max) < 1e-6, "{rows} rows");
            assert_eq!(found.largest, whole.largest);
            for (found, whole) in [
                (Some(found.mse), Some(whole.mse)),
                (Some(found.relative_mse), Some(whole.relative_mse)),
                (Some(found.changed), Some(whole.changed)),
                (found.psnr, whole.psnr),
                (found.flip, whole.flip),
            ] {
                let is_same = found == whole
                    || found
                        .zip(whole)
                        .is_some_and(|(a, b)| (a - b).abs() < 1e-9 * b.abs());
                assert!(is_same, "{rows} rows: {found:?}, {whole:?}");
            }
        }
    }

    #[test]
    fn stripes_give_what_the_whole_gives() {
        let rgb = &["R", "G", "B"][..];
        let rgba = &["R", "G", "B", "A"][..];
        assert_alike(&layer(rgb, 1), &layer(rgb, 2));
        assert_alike(&layer(rgba, 1), &layer(rgba, 5));
        assert_alike(&layer(rgba, 1), &layer(rgb, 3));
        assert_alike(&layer(&["Z"], 1), &layer(&["Z"], 2));
        for same in [layer(rgb, 1), layer(&["Z"], 1)] {
            assert_alike(&same, &same);
        }
        // Colours where nothing covers in one of the stripes: alpha belongs to none of them.
        let mut seen_through = layer(rgba, 1);
        seen_through.channels[3].values[SIZE[0] * 45] = 0.0;
        assert_alike(&seen_through, &layer(rgba, 5));
        // Infinite in one of the stripes.
        for names in [rgb, &["Z"][..]] {
            let mut broken = layer(names, 1);
            broken.channels[0].values[SIZE[0] * 45] = f32::NAN;
            assert_alike(&broken, &layer(names, 2));
        }
    }

    #[test]
    fn sizes_and_channels_must_agree_here_too() {
        let color = layer(&["R", "G", "B"], 1);
        assert!(by_rows(&color, &layer(&["Z"], 1), 0.0, 40).is_err());
        let small = stripe(&color, 0, 50);
        assert!(by_rows(&color, &small, 0.0, 40).is_err());
    }

    #[test]
    fn stripes_are_wide_enough_for_their_seams() {
        assert_eq!(rows_of(16384), 256);
        assert_eq!(rows_of(1 << 22), 2 * REACH);
        assert_eq!(rows_of(0), PIXELS);
    }

    #[test]
    fn large_pictures_take_little_beside_their_layers_and_what_is_not_there_is_refused() {
        let pixels = 16384 * 16384;
        let of = |channels: u64| Numbers {
            bytes: 1 << 20,
            pixels,
            all: channels * pixels,
        };
        let need = Need::of(&of(3), &of(3), false);
        assert!(need.0 < 40 * pixels, "{need:?}");
        assert!(Need::of(&of(16), &of(3), false).0 > need.0);
        assert!(Need::of(&of(3), &of(3), true).0 >= need.0);
        let files = [PathBuf::from("a.exr"), PathBuf::from("b.exr")];
        let check = |left| need.check([&files[0], &files[1]], left);
        assert!(check(None).is_ok() && check(Some(need.0)).is_ok());
        let refused = check(Some(1 << 30))
            .expect_err("it isn't there")
            .to_string();
        for words in [
            "a.exr and b.exr",
            "9.",
            "GiB of memory",
            "but 1.0 GiB are left",
        ] {
            assert!(refused.contains(words), "{words}: {refused}");
        }
    }
}
