//! What a film can gather: its layers, one declaration each. To add one is to add its line to [`LAYERS`]; storage,
//! kernels, partial renders, merging, files, the command line and the page about them follow from it.
//!
//! Nothing here knows how a path is traced: a declaration says in WGSL what the first surface of a path gives, and
//! `passes/film_layers` puts that into a kernel.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use scene::Scene;

use super::{Film, PICTURE_PLANES, ids};

/// Most numbers of a pixel in a layer that isn't one of ids.
pub const MAX_CHANNELS: usize = 3;

/// Most bytes of names in the header of a file.
const MOST_NAMES: usize = 8 << 20;

/// A layer's declaration.
#[derive(Debug)]
pub struct Layer {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its name in EXR files of several layers, after that of the view layer: as Blender 5 calls it.
    pub pass: &'static str,
    /// A letter for each of its channels in EXR files, in the order of its values; at most [`MAX_CHANNELS`]. For layers of ids the
    /// four letters of each pair of ranks.
    pub channels: &'static str,
    /// What is kept of it.
    pub rule: Rule,
    /// What it is, with units; for people.
    pub help: &'static str,
}

/// How a layer comes about from samples.
///
/// Where WGSL is asked for, it is an expression: `f32`, `vec2f` or `vec3f`, as many as there are channels, or `u32` for ids. It is evaluated
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
    /// How many samples meet what, by ids that are normal numbers as the bits of a float: see [`ids`]. Every sample counts
    /// as one, whatever the weight that the pixel filter gives it.
    Ids {
        /// The id.
        wgsl: &'static str,
        /// What ids may be of, by name: for the manifests of files.
        names: fn(&Scene) -> BTreeSet<&str>,
    },
}

/// All layers. The picture itself is the first and always there.
pub static LAYERS: [Layer; 13] = [
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
        name: "crypto_object",
        pass: "CryptoObject",
        channels: "rgba",
        rule: Rule::Ids {
            wgsl: "instances[at.instance].id",
            names: |scene| (scene.instances.iter()).map(|i| i.name.as_str()).collect(),
        },
        help: "Cryptomatte: hashes of the names of objects, and how much of the pixel each covers",
    },
    Layer {
        name: "crypto_material",
        pass: "CryptoMaterial",
        channels: "rgba",
        rule: Rule::Ids {
            wgsl: "materials[at.material].id",
            names: |scene| (scene.materials.iter()).map(|m| m.name.as_str()).collect(),
        },
        help: "Cryptomatte: the same of materials",
    },
    Layer {
        name: "object_index",
        pass: "Object Index",
        channels: "X",
        rule: Rule::First {
            wgsl: "f32(instances[at.instance].source + 1u)",
            empty: 0.0,
        },
        help: "number of the object in the scene, from 1 on; 0 where nothing is",
    },
    Layer {
        name: "material_index",
        pass: "Material Index",
        channels: "X",
        rule: Rule::First {
            wgsl: "f32(at.material + 1u)",
            empty: 0.0,
        },
        help: "number of the material in the scene, from 1 on; 0 where nothing is",
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
        // Two ids with their shares have four letters: `00.r` is the first id, `00.g` its share.
        let passes: Vec<String> = match self.rule {
            Rule::Ids { .. } => (0..ids::IDS / 2)
                .map(|pair| format!("{}{pair:02}", self.pass))
                .collect(),
            _ => vec![self.pass.to_owned()],
        };
        passes.into_iter().flat_map(|pass| {
            let letters = self.channels.chars();
            letters.map(move |letter| format!("ViewLayer.{pass}.{letter}"))
        })
    }

    /// What the first surface of a path gives, where anything is kept of it.
    pub fn wgsl(&self) -> Option<&'static str> {
        match self.rule {
            Rule::Derived(_) => None,
            Rule::Mean(wgsl) | Rule::First { wgsl, .. } | Rule::Ids { wgsl, .. } => Some(wgsl),
        }
    }

    /// How many channels it has in files.
    pub fn channel_count(&self) -> usize {
        match self.rule {
            Rule::Ids { .. } => 2 * ids::IDS,
            _ => self.channels.len(),
        }
    }

    /// Words of what is recorded of a path.
    fn word_count(&self) -> usize {
        match self.rule {
            Rule::Derived(_) => 0,
            Rule::Ids { .. } => 1,
            Rule::Mean(_) | Rule::First { .. } => self.channels.len(),
        }
    }

    /// Planes of the film that it takes.
    fn plane_count(&self) -> usize {
        match self.rule {
            Rule::Derived(_) => 0,
            Rule::Mean(_) => self.channels.len(),
            Rule::First { .. } => 1,
            Rule::Ids { .. } => ids::PLANES,
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

    /// These, and those of other names.
    ///
    /// # Errors
    /// A name that no layer has.
    pub fn with<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Result<Self, UnknownLayer> {
        let own = self.others.iter().map(|layer| layer.name);
        Self::named(own.chain(names))
    }

    /// The layers, the picture first.
    pub fn iter(&self) -> impl Iterator<Item = &'static Layer> {
        LAYERS[..1].iter().chain(self.others.iter().copied())
    }

    /// Whether there is nothing but the picture.
    pub fn is_picture_alone(&self) -> bool {
        self.others.is_empty()
    }

    /// The names of what a scene has to show in layers of ids, by layer: for [`Origin::names`](super::Origin::names). None where
    /// they are too many for the header of a file.
    pub fn names(&self, scene: &Scene) -> BTreeMap<String, Vec<String>> {
        let mut bytes = 0;
        let mut names = BTreeMap::new();
        for layer in self.iter() {
            if let Rule::Ids { names: of, .. } = layer.rule {
                let list: Vec<String> = of(scene).into_iter().map(str::to_owned).collect();
                // Any character may need six in JSON.
                bytes += list.iter().map(|name| 6 * name.len() + 16).sum::<usize>();
                names.insert(layer.name.to_owned(), list);
            }
        }
        match bytes <= MOST_NAMES {
            true => names,
            false => BTreeMap::new(),
        }
    }

    /// What the samples of a wave are added to beside the picture, in the order of the film's planes: one kernel each.
    pub(crate) fn sums(&self) -> Vec<Sum> {
        let mut sums = Vec::new();
        // The first word of a path's record says whether it met anything.
        let mut word = 1;
        for &layer in self.others.iter().filter(|layer| layer.wgsl().is_some()) {
            // A mean is a plane for each channel, each by itself; anything else goes to all of its planes at once.
            let count = match layer.rule {
                Rule::Mean(_) => layer.plane_count(),
                _ => 1,
            };
            let (planes, words) = (layer.plane_count() / count, layer.word_count() / count);
            for index in 0..count {
                let planes = index * planes..(index + 1) * planes;
                sums.push(Sum {
                    planes: planes.map(|plane| plane_name(layer, plane)).collect(),
                    layer,
                    word,
                    words: words as u32,
                });
                word += words as u32;
            }
        }
        sums
    }

    /// Words of what is recorded of a path; none where nothing is.
    pub(crate) fn record_words(&self) -> u32 {
        let last = self.sums().pop();
        last.map_or(0, |sum| sum.word + sum.words)
    }

    /// Names of the buffers that hold the film on a device, in the order of its planes.
    pub(crate) fn buffers(&self) -> Vec<&'static str> {
        let others = self.sums().into_iter().flat_map(|sum| sum.planes);
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

/// What is added to one or more planes of the film. A plane has four words per pixel: a sum of 96 bits and a spare word
/// ([`Rule::Mean`], a plane for each channel), the number of a sample plus 1 and up to three numbers ([`Rule::First`]; 0: no
/// sample), or two ids with their numbers of samples ([`Rule::Ids`]).
#[derive(Debug, Clone)]
pub(crate) struct Sum {
    /// Names of the planes' buffers.
    pub(crate) planes: Vec<&'static str>,
    /// The layer that it is of.
    pub(crate) layer: &'static Layer,
    /// Its first word in what is recorded of a path.
    pub(crate) word: u32,
    /// How many of these words it takes.
    pub(crate) words: u32,
}

fn plane_name(layer: &Layer, index: usize) -> &'static str {
    static NAMES: LazyLock<Vec<Vec<String>>> = LazyLock::new(|| {
        let of = |layer: &Layer| {
            let planes = 0..layer.plane_count();
            planes
                .map(|i| format!("layer {} {i}", layer.name))
                .collect()
        };
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
            let most = match layer.rule {
                Rule::Ids { .. } => 4,
                _ => MAX_CHANNELS,
            };
            assert!((1..=most).contains(&layer.channels.len()));
            assert_eq!(layer.channel_names().count(), layer.channel_count());
            // It is part of names in WGSL.
            let mut letters = layer.name.chars();
            assert!(letters.all(|c| c.is_ascii_lowercase() || c == '_'));
        }
        assert_eq!(LAYERS[0].name, "combined");
    }

    #[test]
    fn layers_are_named_in_any_order() {
        let layers = Layers::named(["crypto_object", "normal", "depth", "combined", "depth"])
            .expect("known");
        let names: Vec<_> = layers.iter().map(|layer| layer.name).collect();
        assert_eq!(names, ["combined", "depth", "normal", "crypto_object"]);
        let sums = layers.sums();
        let words: Vec<_> = sums
            .iter()
            .map(|sum| (sum.planes[0], sum.planes.len(), sum.word, sum.words))
            .collect();
        assert_eq!(
            words,
            [
                ("layer depth 0", 1, 1, 1),
                ("layer normal 0", 1, 2, 1),
                ("layer normal 1", 1, 3, 1),
                ("layer normal 2", 1, 4, 1),
                ("layer crypto_object 0", ids::PLANES, 5, 1),
            ]
        );
        assert_eq!(layers.record_words(), 6);
        assert_eq!(layers.plane_count(), layers.buffers().len());
        assert_eq!(Layers::default().record_words(), 0);
        let error = Layers::named(["deep"]).expect_err("unknown").to_string();
        assert!(error.contains("deep") && error.contains("depth"), "{error}");
    }
}
