//! How EXR files hold numbers: with how many bits, packed how, and what else their headers say.

use exr::compression::Compression as Packing;
use exr::image::FlatSamples;
use exr::meta::header::standard_names;
use exr::prelude::f16;

use super::{OWN, OWN_PREFIX};
use crate::film::layers::{self, UnknownLayer};
use crate::film::{LAYERS, Layer, Layers};

/// The name of all layers together.
pub const ALL_LAYERS: &str = "all";

/// The largest number of 16 bits.
const LARGEST_HALF: f32 = 65504.0;
/// The largest one that survives a transform with loss: it may come back larger by some, and beyond the largest of 16 bits it would be
/// infinite.
const LARGEST_TRANSFORMED: f32 = 49152.0;
/// Channels that DWAA and DWAB transform, in 16 bits: they know them by the ends of their names. All others are kept as they are.
const TRANSFORMED: &str = "RGBY";
/// A layer of colours whose brightest number is darker is kept in 32 bits: of numbers below 2^-14 halves lose digits.
const DARKEST: f32 = 1.0 / 64.0;
/// Longest name of an attribute that any reader takes.
const LONGEST_NAME: usize = 31;
/// Attributes of the format itself that are texts, and may be given.
pub(super) const TEXTS: [&str; 3] = ["owner", "comments", "capDate"];

/// How blocks of an EXR file are packed, by the names that other programs have for it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Compression {
    /// Not at all.
    None,
    /// Runs of equal bytes; lossless.
    Rle,
    /// Deflate, row by row; lossless.
    Zips,
    /// Deflate of 16 rows; lossless.
    #[default]
    Zip,
    /// Wavelets; lossless, and the smallest of grainy pictures.
    Piz,
    /// As [`Self::Zip`] with 24 bits of each 32-bit float; 16-bit floats are kept as they are.
    Pxr24,
    /// Blocks of 4 x 4 numbers of 16 bits, with loss; 32-bit floats are kept as they are. Files of which a block of rows may
    /// grow so, as the last one where few rows are left for it, are packed as [`Self::Zip`].
    B44,
    /// The same, with less for blocks of one colour.
    B44a,
    /// Like JPEG, with loss, 32 rows at a time.
    Dwaa,
    /// The same, 256 rows at a time.
    Dwab,
}

impl Compression {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::None,
        Self::Rle,
        Self::Zips,
        Self::Zip,
        Self::Piz,
        Self::Pxr24,
        Self::B44,
        Self::B44a,
        Self::Dwaa,
        Self::Dwab,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rle => "rle",
            Self::Zips => "zips",
            Self::Zip => "zip",
            Self::Piz => "piz",
            Self::Pxr24 => "pxr24",
            Self::B44 => "b44",
            Self::B44a => "b44a",
            Self::Dwaa => "dwaa",
            Self::Dwab => "dwab",
        }
    }

    /// Whether 32-bit floats come back as they were.
    fn keeps_floats(self) -> bool {
        !matches!(self, Self::Pxr24 | Self::Dwaa | Self::Dwab)
    }

    pub(super) fn packing(self) -> Packing {
        match self {
            Self::None => Packing::Uncompressed,
            Self::Rle => Packing::RLE,
            Self::Zips => Packing::ZIP1,
            Self::Zip => Packing::ZIP16,
            Self::Piz => Packing::PIZ,
            Self::Pxr24 => Packing::PXR24,
            Self::B44 => Packing::B44,
            Self::B44a => Packing::B44A,
            Self::Dwaa => Packing::DWAA(None),
            Self::Dwab => Packing::DWAB(None),
        }
    }
}

/// What was asked for that can't be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FormError {
    /// There is no such layer.
    #[error(transparent)]
    Layer(#[from] UnknownLayer),
    /// Numbers that have to be kept to the bit would not be.
    #[error(
        "{compression} changes 32-bit floats, and the ids of `{layer}` are worth nothing then: choose zip, or leave the layer out"
    )]
    Loss {
        /// The compression.
        compression: &'static str,
        /// A layer of ids.
        layer: &'static str,
    },
    /// The same, by their bits.
    #[error("`{layer}` can't be kept in 16 bits: its ids need all 32")]
    Ids {
        /// A layer of ids.
        layer: &'static str,
    },
    /// A layer with two precisions.
    #[error("`{layer}` is to be of 16 bits and of 32: name it once")]
    Twice {
        /// The layer.
        layer: &'static str,
    },
    /// A name that an attribute can't have.
    #[error("`{name}`: {problem}")]
    Name {
        /// As it was given.
        name: String,
        /// What is wrong.
        problem: &'static str,
    },
}

/// How an EXR file is written. As a rule colours have 16 bits ("half"), where these suffice, and everything else has 32; it is packed
/// without loss.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Form {
    pub(super) compression: Compression,
    /// Layers of which it is said.
    bits: Vec<(&'static Layer, Bits)>,
    /// Further attributes of the header.
    pub(super) facts: Vec<(String, String)>,
}

/// Bits of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Bits {
    Half,
    Float,
}

impl Form {
    /// Where nothing is said.
    pub const USUAL: Self = Self {
        compression: Compression::Zip,
        bits: Vec::new(),
        facts: Vec::new(),
    };

    /// Packed so; layers of these names are kept in 16 bits, and those of the others in 32. [`ALL_LAYERS`] names those that are named
    /// nowhere else; ids keep their 32 bits all the same.
    ///
    /// # Errors
    /// There is no such layer, or one can't be kept so.
    pub fn new(
        compression: Compression,
        half: &[impl AsRef<str>],
        float: &[impl AsRef<str>],
    ) -> Result<Self, FormError> {
        let mut bits: Vec<(&'static Layer, Bits)> = Vec::new();
        let named = half.iter().map(|name| (name.as_ref(), Bits::Half));
        let named = named.chain(float.iter().map(|name| (name.as_ref(), Bits::Float)));
        let (all, single): (Vec<_>, Vec<_>) = named.partition(|(name, _)| *name == ALL_LAYERS);
        for (name, wanted) in single {
            for layer in layers::of_name(name)? {
                if wanted == Bits::Half && layer.is_of_ids() {
                    return Err(FormError::Ids { layer: layer.name });
                }
                match bits.iter().find(|(other, _)| *other == layer) {
                    Some((_, given)) if *given != wanted => {
                        return Err(FormError::Twice { layer: layer.name });
                    }
                    Some(_) => {}
                    None => bits.push((layer, wanted)),
                }
            }
        }
        if let [(_, first), others @ ..] = &all[..] {
            if others.iter().any(|(_, wanted)| wanted != first) {
                return Err(FormError::Twice { layer: ALL_LAYERS });
            }
            let left = LAYERS.iter().filter(|layer| !layer.is_of_ids());
            let left = left.filter(|layer| bits.iter().all(|(other, _)| other != layer));
            let left: Vec<_> = left.map(|layer| (layer, *first)).collect();
            bits.extend(left);
        }
        Ok(Self {
            compression,
            bits,
            facts: Vec::new(),
        })
    }

    /// With another attribute, a text, in the header.
    ///
    /// # Errors
    /// No attribute can have this name.
    pub fn with_fact(mut self, name: &str, value: &str) -> Result<Self, FormError> {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-:".contains(c);
        let problem = match name {
            "" => Some("the name is empty"),
            name if name.len() > LONGEST_NAME => Some("the name is longer than 31 letters"),
            name if !name.chars().all(is_plain) => {
                Some("names are made of letters from a to z, digits, and . _ - :")
            }
            name if is_reserved(name) => Some("the name is the format's own; take another one"),
            name if OWN.contains(&name) || name.starts_with(OWN_PREFIX) => {
                Some("the header says that by itself; take another name")
            }
            _ => None,
        };
        if let Some(problem) = problem {
            let name = name.to_owned();
            return Err(FormError::Name { name, problem });
        }
        self.facts.retain(|(other, _)| other != name);
        self.facts.push((name.to_owned(), value.to_owned()));
        Ok(self)
    }

    /// Whether files of these layers can be written so.
    ///
    /// # Errors
    /// Ids would be lost.
    pub fn check(&self, layers: &Layers) -> Result<(), FormError> {
        let ids = layers.iter().find(|layer| layer.is_of_ids());
        match ids.filter(|_| !self.compression.keeps_floats()) {
            None => Ok(()),
            Some(layer) => Err(FormError::Loss {
                compression: self.compression.name(),
                layer: layer.name,
            }),
        }
    }

    /// The channels of a layer with as many bits as they are to have, where this is the largest of the layer's numbers anywhere in the
    /// picture ([`largest`]). Numbers beyond the range of 16 bits become its largest ones.
    pub(super) fn samples(
        &self,
        layer: &Layer,
        channels: Vec<Vec<f32>>,
        largest: f32,
    ) -> Vec<FlatSamples> {
        let said = self.bits.iter().find(|(other, _)| *other == layer);
        let is_half = match said {
            Some((_, bits)) => *bits == Bits::Half,
            None => layer.is_color() && suffices(largest),
        };
        let short = |value: &f32| match value.is_finite() {
            true => f16::from_f32(value.clamp(-LARGEST_HALF, LARGEST_HALF)),
            false => f16::from_f32(*value),
        };
        let is_transformed = matches!(self.compression, Compression::Dwaa | Compression::Dwab);
        let mut letters = layer.channels.chars();
        let samples = channels.into_iter().map(|mut values| {
            let is_of_cosines = letters.next().is_some_and(|c| TRANSFORMED.contains(c));
            if is_transformed {
                // A sum of cosines with an infinite term is no number anywhere. What is not a number stays so.
                let most = match is_of_cosines {
                    true => LARGEST_TRANSFORMED,
                    false => f32::MAX,
                };
                let large = values.iter_mut().filter(|value| value.abs() > most);
                large.for_each(|value| *value = most.min(LARGEST_HALF).copysign(*value));
            }
            match is_half {
                true => FlatSamples::F16(values.iter().map(short).collect()),
                false => FlatSamples::F32(values),
            }
        });
        samples.collect()
    }
}

/// Whether the format has an attribute of this name that is no text.
fn is_reserved(name: &str) -> bool {
    standard_names::ALL.contains(&name.as_bytes()) && !TEXTS.contains(&name)
}

/// The largest number of a layer, but for its sign.
pub(super) fn largest(channels: &[Vec<f32>]) -> f32 {
    let sizes = channels.iter().flatten().map(|value| value.abs());
    sizes.fold(0.0, f32::max)
}

/// Whether 16 bits are enough for colours: none is too bright, nor all of them so dark that digits are missing.
fn suffices(largest: f32) -> bool {
    largest == 0.0 || (DARKEST..=LARGEST_HALF).contains(&largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: &[&str] = &[];

    fn is_half(form: &Form, layer: &str, values: &[f32]) -> bool {
        let layer = Layer::named(layer).expect("known");
        let channels = vec![values.to_vec()];
        let most = largest(&channels);
        let samples = form.samples(layer, channels, most);
        matches!(samples[0], FlatSamples::F16(_))
    }

    #[test]
    fn colours_have_half_the_bits_where_these_suffice() {
        let usual = Form::USUAL;
        let colors = [
            "combined",
            "albedo",
            "glossy_direct",
            "alpha",
            "light_group_3",
        ];
        for (layers, expected) in [
            (&colors[..], true),
            (&["depth", "position", "normal", "uv", "variance"], false),
            (&["samples", "object_index", "crypto_object"], false),
        ] {
            for layer in layers {
                assert_eq!(
                    is_half(&usual, layer, &[0.0, 0.5, 2.0]),
                    expected,
                    "{layer}"
                );
            }
        }
        assert!(is_half(&usual, "combined", &[0.0, 0.0]));
        assert!(is_half(&usual, "combined", &[-65504.0, 1e-9]));
        assert!(!is_half(&usual, "combined", &[65505.0]));
        assert!(!is_half(&usual, "combined", &[1e-3, 2e-5]));
    }

    #[test]
    fn what_is_said_of_a_layer_counts() {
        let form = Form::new(Compression::Zip, &["depth"], &["combined"]).expect("fine");
        assert!(is_half(&form, "depth", &[1e10]) && !is_half(&form, "combined", &[0.5]));
        let depth = Layer::named("depth").expect("known");
        let samples = form.samples(depth, vec![vec![1e10, f32::INFINITY, -0.1]], 1e10);
        let values: Vec<f32> = samples[0].values_as_f32().collect();
        assert_eq!(values[..2], [65504.0, f32::INFINITY]);
        assert!((values[2] + 0.1).abs() < 1e-4);
        let form = Form::new(Compression::Zip, &["all"], &["light_groups"]).expect("fine");
        assert!(is_half(&form, "normal", &[0.5]) && !is_half(&form, "light_group_2", &[0.5]));
        assert!(!is_half(&form, "crypto_object", &[0.5]));
        for (half, float, because) in [
            (&["crypto_object"][..], NONE, "32"),
            (&["deep"], NONE, "no layer"),
            (&["depth"], &["depth"], "once"),
            (&["all"], &["all"], "once"),
        ] {
            let error = Form::new(Compression::Zip, half, float).expect_err("refused");
            assert!(error.to_string().contains(because), "{error}");
        }
    }

    #[test]
    fn ids_are_packed_without_loss() {
        let ids = Layers::named(["crypto_object"]).expect("known");
        for compression in Compression::ALL {
            let form = Form::new(compression, NONE, NONE).expect("fine");
            assert!(form.check(&Layers::default()).is_ok());
            let is_lossy = ["pxr24", "dwaa", "dwab"].contains(&compression.name());
            assert_eq!(form.check(&ids).is_err(), is_lossy, "{compression:?}");
        }
    }

    #[test]
    fn facts_have_names_that_are_free() {
        let fact = |name: &str| Form::USUAL.with_fact(name, "x");
        for name in ["owner", "shot", "studio:take", "a.b_c-7"] {
            assert!(fact(name).is_ok(), "{name}");
        }
        for name in [
            "",
            "channels",
            "dataWindow",
            "software",
            "schön",
            "cryptomatte/x/name",
            "a b",
            "samplesPerPixel",
            "denoiser",
            "patina:size",
            "patina:any",
        ] {
            assert!(fact(name).is_err(), "{name}");
        }
        assert!(fact(&"x".repeat(32)).is_err());
        let twice = fact("shot").and_then(|form| form.with_fact("shot", "y"));
        assert_eq!(
            twice.expect("fine").facts,
            [("shot".to_owned(), "y".to_owned())]
        );
    }
}
