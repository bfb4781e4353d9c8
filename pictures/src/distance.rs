//! How far two layers are apart: mean squared errors of their numbers, and the difference of what is shown.

use rayon::prelude::*;
use serde::Serialize;

use crate::read::linear_to_srgb;
use crate::{Layer, flip};

/// Added to the squares that relative errors are divided by, so that what is nearly black doesn't outweigh all else (Rousselle, Knaus,
/// Zwicker: "Adaptive sampling and reconstruction using greedy error minimization", 2011, section 5).
const RELATIVE_TO: f64 = 0.01;

/// The distance of a layer from its reference. Where a number of one is not finite and not the same in the other, errors are
/// infinite; numbers that are not finite are `null` in JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Distance {
    /// Mean of squared differences, over all channels: alpha among them where both layers have it.
    pub mse: f64,
    /// Mean of squared differences, each divided by the square of the reference and 0.01.
    pub relative_mse: f64,
    /// The largest difference.
    pub largest: f64,
    /// Share of the pixels that are not the same.
    pub changed: f64,
    /// Peak signal-to-noise ratio of the colours that are shown, 0 to 1 and encoded as sRGB, decibels: infinite where there is no
    /// difference, minus infinity where a difference is infinite. Of layers of colours only, like [`Self::flip`]; where both have alpha
    /// that belongs to their colours ([`Layer::is_covering`]) they are in front of grey.
    pub psnr: Option<f64>,
    /// Mean of [`flip`], 0 to 1; infinite where a difference is.
    pub flip: Option<f64>,
    /// Of each pixel: its FLIP, 0 to 1. Of other layers than colours the largest difference of its channels, by the largest of all.
    #[serde(skip)]
    pub map: Vec<f32>,
}

/// Layers that can't be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DistanceError {
    /// Of different sizes.
    #[error("the pictures differ in size: {}x{} and {}x{} pixels; only pictures of one size can be compared", .0[0], .0[1], .1[0], .1[1])]
    Size([usize; 2], [usize; 2]),
    /// Of different kinds.
    #[error("the layers have other channels: {0} and {1}; name two of one kind")]
    Channels(String, String),
}

impl Distance {
    /// The distance of `layer` from `reference`; what is shown of them is brighter by `exposure` stops.
    ///
    /// # Errors
    /// They differ in size or in channels.
    pub fn between(layer: &Layer, reference: &Layer, exposure: f32) -> Result<Self, DistanceError> {
        let are_covering = layer.is_covering() && reference.is_covering();
        Self::of_parts(layer, reference, exposure, are_covering)
    }

    /// As [`Self::between`] of parts of two pictures, of which `are_covering` says whether the alpha of both wholes belongs to their colours.
    ///
    /// # Errors
    /// As [`Self::between`].
    pub fn of_parts(
        layer: &Layer,
        reference: &Layer,
        exposure: f32,
        are_covering: bool,
    ) -> Result<Self, DistanceError> {
        if layer.size != reference.size {
            return Err(DistanceError::Size(layer.size, reference.size));
        }
        let names = |layer: &Layer| {
            let names: Vec<_> = layer.channels.iter().map(|c| c.name.as_str()).collect();
            names.join(", ")
        };
        let are_colors = layer.is_color() && reference.is_color();
        if !are_colors && names(layer) != names(reference) {
            return Err(DistanceError::Channels(names(layer), names(reference)));
        }
        // What only one of them has can't be compared.
        let channels = layer.channels.len().min(reference.channels.len());
        let pixels = layer.size[0] * layer.size[1];
        let (mut squares, mut relative, mut largest) = (0.0, 0.0, 0.0_f64);
        let mut differences = vec![0.0_f64; pixels];
        for (here, there) in layer.channels.iter().zip(&reference.channels) {
            let values = here.values.iter().zip(&there.values);
            for ((&a, &b), of_pixel) in values.zip(&mut differences) {
                let (difference, b) = (difference(a, b), f64::from(b));
                squares += difference * difference;
                relative += match difference == 0.0 || difference.is_infinite() {
                    true => difference,
                    false => difference * difference / (b * b + RELATIVE_TO),
                };
                largest = largest.max(difference);
                *of_pixel = of_pixel.max(difference);
            }
        }
        let numbers = (pixels * channels) as f64;
        let changed = differences.iter().filter(|&&d| d > 0.0).count();
        let mut distance = Self {
            mse: squares / numbers,
            relative_mse: relative / numbers,
            largest,
            changed: changed as f64 / pixels as f64,
            psnr: None,
            flip: None,
            map: Vec::new(),
        };
        let alphas = layer.alpha().zip(reference.alpha());
        let alphas = alphas.filter(|_| are_covering).unzip();
        let shown = layer.displayed(exposure, alphas.0);
        let shown = shown.zip(reference.displayed(exposure, alphas.1));
        match shown {
            Some((here, there)) => {
                distance.map = flip::map(layer.size, &there, &here);
                (distance.psnr, distance.flip) = match largest.is_finite() {
                    true => (Some(psnr(&here, &there)), Some(mean(&distance.map))),
                    false => (Some(f64::NEG_INFINITY), Some(f64::INFINITY)),
                };
                for (value, difference) in distance.map.iter_mut().zip(&differences) {
                    if difference.is_infinite() {
                        *value = 1.0;
                    }
                }
            }
            None => {
                let share = |&d: &f64| match d.is_finite() && largest.is_finite() {
                    true => (d / largest.max(f64::MIN_POSITIVE)) as f32,
                    false => f32::from(!d.is_finite()),
                };
                distance.map = differences.iter().map(share).collect();
            }
        }
        Ok(distance)
    }
}

fn difference(a: f32, b: f32) -> f64 {
    match a == b || (a.is_nan() && b.is_nan()) {
        true => 0.0,
        false if a.is_finite() && b.is_finite() => (f64::from(a) - f64::from(b)).abs(),
        false => f64::INFINITY,
    }
}

/// Of colours that are shown, linear.
fn psnr(here: &[[f32; 3]], there: &[[f32; 3]]) -> f64 {
    let encoded = |pixels: &[[f32; 3]]| -> Vec<f64> {
        let values = pixels.as_flattened().par_iter();
        values.map(|&v| f64::from(linear_to_srgb(v))).collect()
    };
    let values = encoded(here).into_iter().zip(encoded(there));
    let squares: f64 = values.map(|(a, b)| (a - b) * (a - b)).sum();
    -10.0 * (squares / (3 * here.len()) as f64).log10()
}

fn mean(values: &[f32]) -> f64 {
    let sum: f64 = values.iter().copied().map(f64::from).sum();
    sum / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Channel;

    fn depth(values: &[f32]) -> Layer {
        let channel = Channel {
            name: "Z".to_owned(),
            values: values.to_vec(),
        };
        Layer::new("Depth".to_owned(), [values.len(), 1], vec![channel])
    }

    #[test]
    fn errors_are_those_that_are_computed_by_hand() {
        let here = Layer::rgb("", [2, 1], &[[1.0, 0.5, 0.0], [0.2; 3]]);
        let there = Layer::rgb("", [2, 1], &[[0.8, 0.5, 0.1], [0.2; 3]]);
        let distance = Distance::between(&here, &there, 0.0).expect("alike");
        assert!((distance.mse - (0.04 + 0.01) / 6.0).abs() < 1e-7);
        let relative = (0.04 / (0.64 + 0.01) + 0.01 / (0.01 + 0.01)) / 6.0;
        assert!((distance.relative_mse - relative).abs() < 1e-6);
        assert!((distance.largest - 0.2).abs() < 1e-6);
        assert_eq!(distance.changed, 0.5);
        // sRGB of 1, 0.8, 0 and 0.1 is 1, 0.9063, 0 and 0.3492.
        let squares = (0.0937_f64.powi(2) + 0.3492_f64.powi(2)) / 6.0;
        let psnr = distance.psnr.expect("colours");
        assert!((psnr + 10.0 * squares.log10()).abs() < 0.01, "{psnr}");
        assert_eq!(distance.map.len(), 2);
        // Twice as bright, both clip.
        let brighter = Distance::between(&here, &there, 1.0).expect("alike");
        assert_eq!(brighter.mse, distance.mse);
        assert!(brighter.psnr < distance.psnr);
    }

    #[test]
    fn the_same_is_no_distance_whatever_it_is() {
        let same = Layer::rgb("", [2, 1], &[[f32::NAN, f32::INFINITY, -1.0], [0.5; 3]]);
        let distance = Distance::between(&same, &same, 0.0).expect("alike");
        let expected = (0.0, 0.0, 0.0, 0.0);
        let found = (
            distance.mse,
            distance.relative_mse,
            distance.largest,
            distance.changed,
        );
        assert_eq!(found, expected);
        assert_eq!(distance.psnr, Some(f64::INFINITY));
        assert_eq!(distance.flip, Some(0.0));
    }

    #[test]
    fn other_layers_have_errors_and_a_map() {
        let distance = Distance::between(&depth(&[1.0, 2.0, 4.0]), &depth(&[1.0, 3.0, 2.0]), 0.0);
        let distance = distance.expect("alike");
        assert_eq!((distance.psnr, distance.flip), (None, None));
        assert!((distance.mse - 5.0 / 3.0).abs() < 1e-12);
        assert_eq!(distance.map, [0.0, 0.5, 1.0]);
        let broken = Distance::between(&depth(&[1.0, f32::NAN]), &depth(&[2.0, 0.0]), 0.0);
        let broken = broken.expect("alike");
        assert_eq!((broken.mse, broken.largest), (f64::INFINITY, f64::INFINITY));
        assert_eq!(broken.map, [0.0, 1.0]);
        // Not a number would be shown as black, as the other is.
        let [nothing, black] = [f32::NAN, 0.0].map(|v| Layer::rgb("", [1, 1], &[[v; 3]]));
        let broken = Distance::between(&nothing, &black, 0.0).expect("alike");
        assert_eq!(broken.flip, Some(f64::INFINITY));
        assert_eq!(broken.map, [1.0]);
    }

    #[test]
    fn alpha_counts_where_both_have_it() {
        let layer = |alpha: Option<f32>| {
            let names = ["R", "G", "B", "A"].into_iter();
            let values = [Some(0.1), Some(0.2), Some(0.3), alpha];
            let channel = |(name, value): (&str, Option<f32>)| {
                let (name, values) = (name.to_owned(), vec![value?]);
                Some(Channel { name, values })
            };
            let channels = names.zip(values).filter_map(channel);
            Layer::new(String::new(), [1, 1], channels.collect())
        };
        let distance = |a, b| Distance::between(&layer(a), &layer(b), 0.0).expect("alike");
        let both = distance(Some(0.5), Some(1.0));
        assert_eq!((both.mse, both.changed), (0.0625, 1.0));
        assert!(both.flip > Some(0.0) && both.psnr < Some(30.0), "{both:?}");
        let one = distance(None, Some(0.5));
        assert_eq!((one.mse, one.changed, one.flip), (0.0, 0.0, Some(0.0)));
        let none = distance(Some(f32::NAN), Some(0.5));
        assert_eq!(none.flip, Some(f64::INFINITY));
    }

    #[test]
    fn what_is_seen_where_nothing_covers_counts() {
        let layer = |sky: f32| {
            let channels = ["R", "G", "B", "A"].into_iter().map(|name| Channel {
                name: name.to_owned(),
                values: vec![if name == "A" { 0.0 } else { sky }],
            });
            Layer::new(String::new(), [1, 1], channels.collect())
        };
        // In front of grey all of these would be white.
        let found = Distance::between(&layer(0.8), &layer(1.0), 0.0).expect("alike");
        assert!(
            found.flip > Some(0.0) && found.psnr < Some(30.0),
            "{found:?}"
        );
        let found = Distance::between(&layer(0.0), &layer(0.0), 0.0).expect("alike");
        assert_eq!(found.flip, Some(0.0));
    }

    #[test]
    fn sizes_and_channels_must_agree() {
        let error = Distance::between(&depth(&[1.0]), &depth(&[1.0, 2.0]), 0.0).unwrap_err();
        assert!(error.to_string().contains("1x1 and 2x1"), "{error}");
        let color = Layer::rgb("", [1, 1], &[[0.0; 3]]);
        let error = Distance::between(&depth(&[1.0]), &color, 0.0).unwrap_err();
        assert!(error.to_string().contains("Z and R, G, B"), "{error}");
    }
}
