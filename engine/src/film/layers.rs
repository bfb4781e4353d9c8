//! What a film can gather: its layers, one declaration each. To add one is to add its line to [`LAYERS`]; storage,
//! kernels, partial renders, merging, files, the command line and the page about them follow from it.
//!
//! Nothing here knows how a path is traced: a declaration says in WGSL what the first surface of a path gives, and
//! `passes/film_layers` puts that into a kernel.

use std::sync::LazyLock;

use super::{Film, PICTURE_PLANES};

/// Most channels of a layer.
pub const MAX_CHANNELS: usize = 3;

/// A layer's declaration.
#[derive(Debug)]
pub struct Layer {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its name in EXR files of several layers, after that of the view layer: as Blender 5 calls it.
    pub pass: &'static str,
    /// A letter for each of its channels in EXR files, in the order of its values; at most [`MAX_CHANNELS`].
    pub channels: &'static str,
    /// What is kept of it.
    pub rule: Rule,
    /// What it is, with units; for people.
    pub help: &'static str,
}

/// How a layer comes about from samples.
///
/// Where WGSL is asked for, it is an expression: `f32`, `vec2f` or `vec3f`, as many as there are channels. It is evaluated
/// for the first surface that a path doesn't pass through, once its texture program has run, and may name `at`, a
/// `FirstSurface`, `frame`, and the functions of `passes/film_layers/record.wgsl`.
#[derive(Debug)]
pub enum Rule {
    /// It follows from the sums of the picture's samples: nothing more is kept. Of a pixel, counted row by row.
    Derived(fn(&Film, usize) -> [f32; MAX_CHANNELS]),
    /// The mean of all samples, weighed by the pixel filter like the picture; a path that meets nothing gives 0. The sums
    /// are exact, in the picture's units.
    Mean(&'static str),
    /// The value of the sample with the lowest number among those that meet something, as it is: for values whose mean
    /// means nothing at an edge. Where no sample meets anything, the number `empty`.
    First {
        /// The value.
        wgsl: &'static str,
        /// In pixels that see no surface.
        empty: f32,
    },
}

/// All layers. The picture itself is the first and always there.
pub static LAYERS: [Layer; 9] = [
    Layer {
        name: "combined",
        pass: "Combined",
        channels: "RGB",
        rule: Rule::Derived(Film::pixel_mean),
        help: "the picture: linear Rec.709 radiance",
    },
    Layer {
        name: "depth",
        pass: "Depth",
        channels: "Z",
        rule: Rule::First {
            wgsl: "dot(frame.camera_position - at.surface.position, frame.camera_back)",
            empty: 1e10,
        },
        help: "distance from the plane of the camera, metres; 1e10 where nothing is",
    },
    Layer {
        name: "position",
        pass: "Position",
        channels: "XYZ",
        rule: Rule::First {
            wgsl: "at.surface.position",
            empty: 0.0,
        },
        help: "place in the world, metres",
    },
    Layer {
        name: "normal",
        pass: "Normal",
        channels: "XYZ",
        rule: Rule::Mean("first_normal(at)"),
        help: "shading normal in the world, towards the viewer, normal maps and textures included",
    },
    Layer {
        name: "uv",
        pass: "UV",
        channels: "UVA",
        rule: Rule::First {
            wgsl: "vec3f(first_uv(at), 1.0)",
            empty: 0.0,
        },
        help: "first texture coordinates, v upwards, and 1 where something is",
    },
    Layer {
        name: "albedo",
        pass: "Denoising Albedo",
        channels: "RGB",
        rule: Rule::Mean("first_base_color(at)"),
        help: "base colour, textures included",
    },
    Layer {
        name: "emission",
        pass: "Emission",
        channels: "RGB",
        rule: Rule::Mean("first_emission(at)"),
        help: "radiance that the surface emits towards the viewer",
    },
    Layer {
        name: "samples",
        pass: "Debug Sample Count",
        channels: "X",
        rule: Rule::Derived(|film, pixel| [film.samples(pixel) as f32, 0.0, 0.0]),
        help: "number of samples",
    },
    Layer {
        name: "variance",
        pass: "Variance",
        channels: "RGB",
        rule: Rule::Derived(|film, pixel| film.pixel_error(pixel).map(|error| error * error)),
        help: "variance of the pixel's mean radiance; infinite below two samples",
    },
];

impl PartialEq for Layer {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Layer {}

impl Layer {
    /// The layer of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        LAYERS.iter().find(|layer| layer.name == name)
    }

    /// The names of its channels in EXR files, in the order of its values.
    pub fn channel_names(&self) -> impl Iterator<Item = String> {
        let letters = self.channels.chars();
        letters.map(|letter| format!("ViewLayer.{}.{letter}", self.pass))
    }

    /// What the first surface of a path gives, where anything is kept of it.
    pub fn wgsl(&self) -> Option<&'static str> {
        match self.rule {
            Rule::Derived(_) => None,
            Rule::Mean(wgsl) | Rule::First { wgsl, .. } => Some(wgsl),
        }
    }

    /// How many channels it has.
    pub fn channel_count(&self) -> usize {
        self.channels.len()
    }

    /// Planes of the film that it takes.
    fn plane_count(&self) -> usize {
        match self.rule {
            Rule::Derived(_) => 0,
            Rule::Mean(_) => self.channel_count(),
            Rule::First { .. } => 1,
        }
    }
}

/// A layer that there is not.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no layer `{name}`; there are {}", known().join(", "))]
pub struct UnknownLayer {
    /// As it was asked for.
    pub name: String,
}

/// Names of all layers.
pub fn known() -> Vec<&'static str> {
    LAYERS.iter().map(|layer| layer.name).collect()
}

/// The layers of a film, each once, in the order of [`LAYERS`]: the picture, and what was asked for beside it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Layers {
    /// Beside the picture.
    others: Vec<&'static Layer>,
}

impl Layers {
    /// Those of these names, and the picture.
    ///
    /// # Errors
    /// A name that no layer has.
    pub fn named<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<Self, UnknownLayer> {
        let mut wanted = Vec::new();
        for name in names {
            let layer = Layer::named(name).ok_or_else(|| UnknownLayer {
                name: name.to_owned(),
            })?;
            wanted.push(layer);
        }
        let others = LAYERS[1..].iter();
        Ok(Self {
            others: others.filter(|layer| wanted.contains(layer)).collect(),
        })
    }

    /// All that there are.
    pub fn all() -> Self {
        Self {
            others: LAYERS[1..].iter().collect(),
        }
    }

    /// The layers, the picture first.
    pub fn iter(&self) -> impl Iterator<Item = &'static Layer> {
        LAYERS[..1].iter().chain(self.others.iter().copied())
    }

    /// Whether there is nothing but the picture.
    pub fn is_picture_alone(&self) -> bool {
        self.others.is_empty()
    }

    /// The film's planes beside those of the picture, in their order.
    pub(crate) fn planes(&self) -> Vec<Plane> {
        let mut planes = Vec::new();
        // The first word of a path's record says whether it met anything.
        let mut word = 1;
        for &layer in self.others.iter().filter(|layer| layer.wgsl().is_some()) {
            let channels = layer.channel_count() / layer.plane_count();
            for index in 0..layer.plane_count() {
                planes.push(Plane {
                    name: plane_name(layer, index),
                    layer,
                    word,
                    channels: channels as u32,
                });
                word += channels as u32;
            }
        }
        planes
    }

    /// Words of what is recorded of a path; none where nothing is.
    pub(crate) fn record_words(&self) -> u32 {
        let last = self.planes().pop();
        last.map_or(0, |plane| plane.word + plane.channels)
    }

    /// Names of the buffers that hold the film on a device, in the order of its planes.
    pub(crate) fn buffers(&self) -> Vec<&'static str> {
        let others = self.planes();
        let others = others.iter().map(|plane| plane.name);
        PICTURE_PLANES.into_iter().chain(others).collect()
    }

    /// Number of planes, with those of the picture.
    pub(super) fn plane_count(&self) -> usize {
        let others = self.others.iter().map(|layer| layer.plane_count());
        PICTURE_PLANES.len() + others.sum::<usize>()
    }

    /// Where the planes of a layer begin among all of a film that has it.
    pub(super) fn first_plane(&self, layer: &Layer) -> Option<usize> {
        let at = self.others.iter().position(|&other| other == layer)?;
        let before = self.others[..at].iter().map(|layer| layer.plane_count());
        Some(PICTURE_PLANES.len() + before.sum::<usize>())
    }
}

/// Four words per pixel of a layer: a sum of 96 bits and a spare word ([`Rule::Mean`], a plane for each channel), or the
/// number of a sample plus 1 and up to three numbers ([`Rule::First`]; 0: no sample).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    /// Name of its buffer.
    pub(crate) name: &'static str,
    /// The layer that it is of.
    pub(crate) layer: &'static Layer,
    /// Its first word in what is recorded of a path.
    pub(crate) word: u32,
    /// How many of these words it takes.
    pub(crate) channels: u32,
}

fn plane_name(layer: &Layer, index: usize) -> &'static str {
    static NAMES: LazyLock<Vec<[String; MAX_CHANNELS]>> = LazyLock::new(|| {
        let of = |layer: &Layer| std::array::from_fn(|i| format!("layer {} {i}", layer.name));
        LAYERS.iter().map(of).collect()
    });
    let at = LAYERS.iter().position(|other| other == layer);
    &NAMES[at.expect("layers are made here alone")][index]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declarations_are_consistent() {
        for (number, layer) in LAYERS.iter().enumerate() {
            let before = &LAYERS[..number];
            assert!(
                before
                    .iter()
                    .all(|b| b.name != layer.name && b.pass != layer.pass)
            );
            assert!((1..=MAX_CHANNELS).contains(&layer.channel_count()));
            assert!(layer.name.chars().all(|c| c.is_ascii_lowercase()));
        }
        assert_eq!(LAYERS[0].name, "combined");
    }

    #[test]
    fn layers_are_named_in_any_order() {
        let layers = Layers::named(["normal", "depth", "combined", "depth"]).expect("known");
        let names: Vec<_> = layers.iter().map(|layer| layer.name).collect();
        assert_eq!(names, ["combined", "depth", "normal"]);
        let planes = layers.planes();
        let words: Vec<_> = planes
            .iter()
            .map(|p| (p.name, p.word, p.channels))
            .collect();
        assert_eq!(
            words,
            [
                ("layer depth 0", 1, 1),
                ("layer normal 0", 2, 1),
                ("layer normal 1", 3, 1),
                ("layer normal 2", 4, 1)
            ]
        );
        assert_eq!(layers.record_words(), 5);
        assert_eq!(layers.plane_count(), PICTURE_PLANES.len() + planes.len());
        assert_eq!(Layers::default().record_words(), 0);
        let error = Layers::named(["deep"]).expect_err("unknown").to_string();
        assert!(error.contains("deep") && error.contains("depth"), "{error}");
    }
}
