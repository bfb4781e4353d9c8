//! What a film can gather: its layers, one declaration each. To add one is to add its line to [`LAYERS`]; storage,
//! kernels, partial renders, merging, files, the command line and the page about them follow from it.
//!
//! Nothing here knows how a path is traced: a declaration says in WGSL what the first surface of a path gives, and
//! `passes/film_layers` puts that into a kernel.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use scene::{Instance, Scene, UNGROUPED};

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
/// `FirstSurface`, `frame`, `normal` and `colors` (the surface's `first_normal` and `first_colors`, worked out once), and the functions of `passes/film_layers/record.wgsl`.
#[derive(Debug)]
pub enum Rule {
    /// It follows from the sums of the picture's samples: nothing more is kept. Of a pixel, counted row by row.
    Derived(fn(&Film, usize) -> [f32; MAX_CHANNELS]),
    /// The mean of all samples, weighed by the pixel filter like the picture; a path that meets nothing gives 0. The sums
    /// are exact, in the picture's units.
    Mean(&'static str),
    /// A part of the picture: the mean of what an expression gives for each piece of light that a path finds, named `found`, a
    /// `Found` of `passes/shared/found_light.wgsl`. It may use the functions of `film_layers/parts.wgsl`.
    Light {
        /// The part of the piece: `vec3f`.
        wgsl: &'static str,
        /// The layer of the colour by which files have it divided: light times colour is the part.
        color: Option<&'static str>,
    },
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

/// The layer of a group of lights, by its number; 0 is what belongs to none.
macro_rules! light_group {
    ($number:literal) => {
        Layer {
            name: concat!("light_group_", $number),
            pass: concat!("Combined_", $number),
            channels: "RGB",
            rule: Rule::Light {
                wgsl: concat!(
                    "select(vec3f(0.0), found.light, found.group == ",
                    $number,
                    "u)"
                ),
                color: None,
            },
            help: "light of one group",
        }
    };
}

/// The layers of a node of the look, by their number from 1 on: its value's first three components, and the fourth.
macro_rules! node_layer {
    ($number:literal) => {
        Layer {
            name: concat!("node_", $number),
            pass: concat!("Node ", $number),
            channels: "RGB",
            rule: Rule::Mean(concat!("node_value(at, ", $number, "u).xyz")),
            help: "value of a node",
        }
    };
    ($number:literal, alpha) => {
        Layer {
            name: concat!("node_", $number, "_alpha"),
            pass: concat!("Node ", $number),
            channels: "A",
            rule: Rule::Mean(concat!("node_value(at, ", $number, "u).w")),
            help: "fourth component of the value of a node",
        }
    };
}

/// How the layers of a node are asked for; its name follows.
pub const NODE: &str = "node:";
/// Most nodes whose values a film keeps.
pub const MAX_NODES: usize = 8;
/// How the names of their layers begin.
const NODE_LAYER: &str = "node_";
/// How the name of that of the fourth component ends.
const NODE_ALPHA: &str = "_alpha";

/// The layer of motion; that of what comes next comes with it.
pub const VECTOR: &str = "vector";
/// The layer of shadows on shadow catchers; those below come with it.
pub const SHADOW_CATCHER: &str = "shadow_catcher";
/// How the names of layers begin that it is made from, and that no file of a picture has; the first of them.
pub(super) const CAUGHT: &str = "caught";

/// What all layers of groups are called together.
pub const LIGHT_GROUPS: &str = "light_groups";
/// How the name of each begins; its number follows.
const LIGHT_GROUP: &str = "light_group_";

/// All layers. The picture itself is the first and always there.
pub static LAYERS: [Layer; 67] = [
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
        rule: Rule::Mean("normal"),
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
        name: "denoising_normal",
        pass: "Denoising Normal",
        channels: "XYZ",
        rule: Rule::Mean("in_camera_axes(normal)"),
        help: "as `normal`, along the axes of the camera: right, up, towards the viewer",
    },
    Layer {
        name: "denoising_depth",
        pass: "Denoising Depth",
        channels: "Z",
        rule: Rule::Mean("dot(frame.camera_position - at.surface.position, frame.camera_back)"),
        help: "as `depth`, but the mean of all samples; 0 where nothing is",
    },
    Layer {
        name: "diffuse_direct",
        pass: "Diffuse Direct",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "direct(diffuse(found), found)",
            color: Some("diffuse_color"),
        },
        help: "light that the first surface scatters diffusely, straight from a lamp; divided by `diffuse_color`",
    },
    Layer {
        name: "diffuse_indirect",
        pass: "Diffuse Indirect",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "indirect(diffuse(found), found)",
            color: Some("diffuse_color"),
        },
        help: "the same from other surfaces; divided by `diffuse_color`",
    },
    Layer {
        name: "diffuse_color",
        pass: "Diffuse Color",
        channels: "RGB",
        rule: Rule::Mean("colors.diffuse"),
        help: "the colour of diffuse scattering at the first surface",
    },
    Layer {
        name: "glossy_direct",
        pass: "Glossy Direct",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "direct(glossy(found), found)",
            color: Some("glossy_color"),
        },
        help: "light that it reflects, straight from a lamp; divided by `glossy_color`",
    },
    Layer {
        name: "glossy_indirect",
        pass: "Glossy Indirect",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "indirect(glossy(found), found)",
            color: Some("glossy_color"),
        },
        help: "the same from other surfaces; divided by `glossy_color`",
    },
    Layer {
        name: "glossy_color",
        pass: "Glossy Color",
        channels: "RGB",
        rule: Rule::Mean("colors.glossy"),
        help: "the colour of its reflection, seen straight on",
    },
    Layer {
        name: "transmission_direct",
        pass: "Transmission Direct",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "direct(transmission(found), found)",
            color: Some("transmission_color"),
        },
        help: "light that it lets through, straight from a lamp; divided by `transmission_color`",
    },
    Layer {
        name: "transmission_indirect",
        pass: "Transmission Indirect",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "indirect(transmission(found), found)",
            color: Some("transmission_color"),
        },
        help: "the same from other surfaces; divided by `transmission_color`",
    },
    Layer {
        name: "transmission_color",
        pass: "Transmission Color",
        channels: "RGB",
        rule: Rule::Mean("colors.transmission"),
        help: "the colour of what it lets through",
    },
    Layer {
        name: "emission",
        pass: "Emission",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "emitted(found)",
            color: None,
        },
        help: "radiance that the first surface emits towards the viewer",
    },
    Layer {
        name: "environment",
        pass: "Environment",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "from_far(found)",
            color: None,
        },
        help: "radiance of the environment where nothing is in front of it",
    },
    Layer {
        name: "alpha",
        pass: "Combined",
        channels: "A",
        rule: Rule::Mean("1.0"),
        help: "share of the samples that meet a surface",
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
        name: "crypto_asset",
        pass: "CryptoAsset",
        channels: "rgba",
        rule: Rule::Ids {
            wgsl: "instances[at.instance].asset",
            names: |scene| scene.instances.iter().map(Instance::asset).collect(),
        },
        help: "Cryptomatte: the same of the topmost nodes that objects hang below",
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
        name: SHADOW_CATCHER,
        pass: "Shadow Catcher",
        channels: "RGB",
        rule: Rule::Derived(Film::shadow_factor),
        help: "what a shadow leaves of the light on a shadow catcher; 1 where there is none",
    },
    Layer {
        name: "shadow_catcher_alpha",
        pass: "Shadow Catcher",
        channels: "A",
        rule: Rule::Derived(|film, pixel| [film.shadow(pixel), 0.0, 0.0]),
        help: "what it keeps from it",
    },
    Layer {
        name: CAUGHT,
        pass: "Caught",
        channels: "A",
        rule: Rule::Mean("first_caught(at)"),
        help: "share of the samples that meet a shadow catcher",
    },
    Layer {
        name: "caught_light",
        pass: "Caught Light",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "select(vec3f(0.0), found.light, is_caught(slot))",
            color: None,
        },
        help: "what is seen of shadow catchers",
    },
    Layer {
        name: "caught_shadowless",
        pass: "Caught Shadowless",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "found.shadowless",
            color: None,
        },
        help: "light of lamps on shadow catchers, as if nothing were in its way",
    },
    Layer {
        name: "caught_arrived",
        pass: "Caught Arrived",
        channels: "RGB",
        rule: Rule::Light {
            wgsl: "found.arrived",
            color: None,
        },
        help: "what arrives of it",
    },
    Layer {
        name: VECTOR,
        pass: "Vector",
        channels: "XY",
        rule: Rule::First {
            wgsl: "first_motion(at).xy",
            empty: 0.0,
        },
        help: "where the surface was a frame ago, seen from where it is: pixels to the right and up",
    },
    Layer {
        name: "vector_next",
        pass: "Vector",
        channels: "ZW",
        rule: Rule::First {
            wgsl: "first_motion(at).zw",
            empty: 0.0,
        },
        help: "where it is, seen from where it will be in a frame",
    },
    light_group!(0),
    light_group!(1),
    light_group!(2),
    light_group!(3),
    light_group!(4),
    light_group!(5),
    light_group!(6),
    light_group!(7),
    light_group!(8),
    light_group!(9),
    light_group!(10),
    light_group!(11),
    light_group!(12),
    light_group!(13),
    light_group!(14),
    light_group!(15),
    node_layer!(1),
    node_layer!(1, alpha),
    node_layer!(2),
    node_layer!(2, alpha),
    node_layer!(3),
    node_layer!(3, alpha),
    node_layer!(4),
    node_layer!(4, alpha),
    node_layer!(5),
    node_layer!(5, alpha),
    node_layer!(6),
    node_layer!(6, alpha),
    node_layer!(7),
    node_layer!(7, alpha),
    node_layer!(8),
    node_layer!(8, alpha),
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

    /// What a path gives to it, where anything is kept of it.
    pub fn wgsl(&self) -> Option<&'static str> {
        match self.rule {
            Rule::Derived(_) => None,
            Rule::Mean(wgsl)
            | Rule::Light { wgsl, .. }
            | Rule::First { wgsl, .. }
            | Rule::Ids { wgsl, .. } => Some(wgsl),
        }
    }

    /// Whether its numbers are ids.
    pub fn is_of_ids(&self) -> bool {
        matches!(self.rule, Rule::Ids { .. })
    }

    /// Whether it is something to look at: colours, or how much of a pixel is covered.
    pub fn is_color(&self) -> bool {
        // A variance is the square of a colour, and nodes give anything.
        ["RGB", "A"].contains(&self.channels) && self.name != "variance" && self.node().is_none()
    }

    /// Whether it is a part of the picture.
    pub fn is_light(&self) -> bool {
        matches!(self.rule, Rule::Light { .. })
    }

    /// The number of the group of lights that it is of.
    pub fn light_group(&self) -> Option<usize> {
        self.name.strip_prefix(LIGHT_GROUP)?.parse().ok()
    }

    /// Whether it is that of motion, or comes with it.
    fn is_of_motion(&self) -> bool {
        self.name.starts_with(VECTOR)
    }

    /// Whether it has a name of its own by which it is asked for, and doesn't only come with another one.
    fn is_asked_for(&self) -> bool {
        let comes_alone = !self.is_of_catchers() && !self.is_of_motion();
        comes_alone || [SHADOW_CATCHER, VECTOR].contains(&self.name)
    }

    /// Whether it is the layer of shadows on shadow catchers, or comes with it.
    pub fn is_of_catchers(&self) -> bool {
        self.name.starts_with(SHADOW_CATCHER) || self.is_kept_back()
    }

    /// Whether it is kept for others alone: files of pictures don't have it.
    pub fn is_kept_back(&self) -> bool {
        self.name.starts_with(CAUGHT)
    }

    /// The number of the node that it is of, from 0 on.
    pub(crate) fn node(&self) -> Option<usize> {
        let name = self.name.strip_prefix(NODE_LAYER)?;
        let number: usize = name.strip_suffix(NODE_ALPHA).unwrap_or(name).parse().ok()?;
        number.checked_sub(1)
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
            Rule::Mean(_) | Rule::Light { .. } | Rule::First { .. } => self.channels.len(),
        }
    }

    /// Planes of the film that it takes.
    fn plane_count(&self) -> usize {
        match self.rule {
            Rule::Derived(_) => 0,
            Rule::Mean(_) | Rule::Light { .. } => self.channels.len(),
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

/// Layers that there can't be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LayersError {
    /// There is none of such a name.
    #[error(transparent)]
    Unknown(#[from] UnknownLayer),
    /// They are too many.
    #[error(
        "layers of {wanted} nodes are too many: a film keeps the values of at most {MAX_NODES}"
    )]
    Nodes {
        /// So many are asked for.
        wanted: usize,
    },
}

/// Names by which layers are asked for, but for those of nodes ([`NODE`]): those of light groups are one.
pub fn known() -> Vec<&'static str> {
    let is_single = |layer: &&Layer| {
        let is_one_of_several = layer.light_group().is_some() || layer.node().is_some();
        !is_one_of_several && layer.is_asked_for()
    };
    let single = LAYERS.iter().filter(is_single);
    single
        .map(|layer| layer.name)
        .chain([LIGHT_GROUPS])
        .collect()
}

/// What is asked for by a name.
///
/// # Errors
/// A name that no layer has.
pub(super) fn of_name(name: &str) -> Result<Vec<&'static Layer>, UnknownLayer> {
    let groups = || LAYERS.iter().filter(|layer| layer.light_group().is_some());
    let catchers = || LAYERS.iter().filter(|layer| layer.is_of_catchers());
    match (name, Layer::named(name)) {
        (LIGHT_GROUPS, _) => Ok(groups().collect()),
        (SHADOW_CATCHER, _) => Ok(catchers().collect()),
        (VECTOR, _) => Ok(LAYERS.iter().filter(|layer| layer.is_of_motion()).collect()),
        (_, Some(layer)) if layer.node().is_none() && layer.is_asked_for() => Ok(vec![layer]),
        _ => Err(UnknownLayer {
            name: name.to_owned(),
        }),
    }
}

/// What the layers of a node are called in EXR files, after the view layer.
pub fn node_pass(node: &str) -> String {
    // Points part the names of layers and channels.
    format!("Node {}", node.replace('.', "_"))
}

/// The layers of a film, each once, in the order of [`LAYERS`]: the picture, and what was asked for beside it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Layers {
    /// Beside the picture.
    others: Vec<&'static Layer>,
    /// The names of the nodes that some of these are of, by their numbers: in order, so that lists can be compared.
    nodes: Vec<String>,
}

impl Layers {
    /// Those of these names, and the picture; light comes with the colour that it is divided by. Behind [`NODE`] a name is that of a node
    /// of the look.
    ///
    /// # Errors
    /// A name that no layer has; too many nodes.
    pub fn named<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<Self, LayersError> {
        let mut wanted = Vec::new();
        let mut nodes = BTreeSet::new();
        for name in names {
            if let Some(node) = name.strip_prefix(NODE).filter(|node| !node.is_empty()) {
                nodes.insert(node.to_owned());
                continue;
            }
            for layer in of_name(name)? {
                wanted.push(layer);
                if let Rule::Light { color, .. } = layer.rule {
                    wanted.extend(color.and_then(Layer::named));
                }
            }
        }
        if nodes.len() > MAX_NODES {
            let wanted = nodes.len();
            return Err(LayersError::Nodes { wanted });
        }
        let is_wanted = |layer: &&Layer| match layer.node() {
            Some(number) => number < nodes.len(),
            None => wanted.contains(layer),
        };
        Ok(Self {
            others: LAYERS[1..].iter().filter(is_wanted).collect(),
            nodes: nodes.into_iter().collect(),
        })
    }

    /// All that there are, but for those of nodes.
    pub fn all() -> Self {
        let others = LAYERS[1..].iter();
        Self {
            others: others.filter(|layer| layer.node().is_none()).collect(),
            nodes: Vec::new(),
        }
    }

    /// The nodes of the look whose values are kept, by their numbers.
    pub fn nodes(&self) -> &[String] {
        &self.nodes
    }

    /// The name by which one of them is asked for; of a node, `node:` and its name for both of its layers.
    pub fn name_of(&self, layer: &Layer) -> Cow<'static, str> {
        match layer.node().and_then(|number| self.nodes.get(number)) {
            Some(node) => format!("{NODE}{node}").into(),
            None => layer.name.into(),
        }
    }

    /// The names by which all of them are asked for, the picture's first, each once.
    pub fn asked(&self) -> Vec<Cow<'static, str>> {
        let asked = self.iter().filter(|layer| layer.is_asked_for());
        let mut names: Vec<_> = asked.map(|layer| self.name_of(layer)).collect();
        names.dedup();
        names
    }

    /// The name of one of them in EXR files, after that of the view layer.
    pub fn pass_of(&self, layer: &Layer) -> Cow<'static, str> {
        match layer.node().and_then(|number| self.nodes.get(number)) {
            Some(node) => node_pass(node).into(),
            None => layer.pass.into(),
        }
    }

    /// Without groups of lights and shadow catchers that a scene hasn't.
    #[must_use]
    pub fn of_scene(&self, scene: &Scene) -> Self {
        let groups = scene.light_groups.names().len();
        let catches = scene.materials.iter().any(|m| m.shadow_catcher);
        let is_there = |layer: &&&Layer| {
            (catches || !layer.is_of_catchers())
                && layer.light_group().is_none_or(|number| number <= groups)
        };
        Self {
            others: self.others.iter().filter(is_there).copied().collect(),
            nodes: self.nodes.clone(),
        }
    }

    /// Whether some of them are parts of the picture.
    pub(crate) fn split_light(&self) -> bool {
        self.others.iter().any(|layer| layer.is_light())
    }

    /// Whether motion is among them.
    pub(crate) fn have_motion(&self) -> bool {
        self.others.iter().any(|layer| layer.is_of_motion())
    }

    /// Whether shadows on shadow catchers are among them.
    pub(crate) fn catch_shadows(&self) -> bool {
        self.others.iter().any(|layer| layer.is_of_catchers())
    }

    /// These, and those of other names.
    ///
    /// # Errors
    /// A name that no layer has.
    pub fn with<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Result<Self, LayersError> {
        let mut all = self.asked();
        all.extend(names.into_iter().map(|name| name.to_owned().into()));
        Self::named(all.iter().map(AsRef::as_ref))
    }

    /// The layers, the picture first.
    pub fn iter(&self) -> impl Iterator<Item = &'static Layer> {
        LAYERS[..1].iter().chain(self.others.iter().copied())
    }

    /// Whether there is nothing but the picture.
    pub fn is_picture_alone(&self) -> bool {
        self.others.is_empty()
    }

    /// The names of what a scene has to show in layers of ids, and of its groups of lights, by layer: for
    /// [`Origin::names`](super::Origin::names). None where they are too many for the header of a file.
    pub fn names(&self, scene: &Scene) -> BTreeMap<String, Vec<String>> {
        let mut bytes = 0;
        let mut names = BTreeMap::new();
        for layer in self.iter() {
            let list: Option<Vec<String>> = match (layer.light_group(), &layer.rule) {
                (Some(0), _) => Some(vec![UNGROUPED.to_owned()]),
                (Some(number), _) => {
                    let name = scene.light_groups.names().get(number - 1);
                    name.map(|name| vec![name.clone()])
                }
                (None, Rule::Ids { names: of, .. }) => {
                    Some(of(scene).into_iter().map(str::to_owned).collect())
                }
                _ => None,
            };
            if let Some(list) = list {
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
            let words = layer.word_count() as u32;
            sums.push(Sum {
                planes: (0..layer.plane_count())
                    .map(|plane| plane_name(layer, plane))
                    .collect(),
                layer,
                word,
                words,
                is_of_surfaces: !layer.is_light(),
            });
            word += words;
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
/// ([`Rule::Mean`] and [`Rule::Light`], a plane for each channel), the number of a sample plus 1 and up to three numbers ([`Rule::First`]; 0: no
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
    /// Whether only paths that have met a surface give anything to it.
    pub(crate) is_of_surfaces: bool,
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
            let names = |layer: &Layer| layer.channel_names().collect::<BTreeSet<_>>();
            assert!(before.iter().all(|b| b.name != layer.name));
            assert!(before.iter().all(|b| names(b).is_disjoint(&names(layer))));
            let most = match layer.rule {
                Rule::Ids { .. } => 4,
                _ => MAX_CHANNELS,
            };
            assert!((1..=most).contains(&layer.channels.len()));
            assert_eq!(layer.channel_names().count(), layer.channel_count());
            // It is part of names in WGSL.
            let mut letters = layer.name.chars();
            assert!(letters.all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_'));
            if let Rule::Light {
                color: Some(color), ..
            } = layer.rule
            {
                assert!(matches!(
                    Layer::named(color).expect("there").rule,
                    Rule::Mean(_)
                ));
            }
        }
        assert_eq!(LAYERS[0].name, "combined");
    }

    #[test]
    fn light_is_divided_by_its_color_and_comes_with_it() {
        let layers = Layers::named(["glossy_direct"]).expect("known");
        let names: Vec<_> = layers.iter().map(|layer| layer.name).collect();
        assert_eq!(names, ["combined", "glossy_direct", "glossy_color"]);
        let mut film = Film::with_layers(1, 1, layers);
        for sample in 0..2 {
            film.add_sample(0, [0.0; 3]);
            film.add_surface(0, sample, |layer| match layer.is_light() {
                true => [0.5, 0.25, 0.0],
                false => [0.25, 0.0, 0.0],
            });
        }
        let value = |name| {
            film.values(Layer::named(name).expect("known"))
                .expect("gathered")[0]
        };
        // Light that has no colour to be divided by makes it white.
        assert_eq!(value("glossy_color"), [0.25, 1.0, 0.0]);
        assert_eq!(value("glossy_direct"), [2.0, 0.25, 0.0]);
    }

    #[test]
    fn groups_of_lights_are_those_of_a_scene() {
        let mut scene = Scene::default();
        let source = scene::LightSource::Environment;
        scene.light_groups.assign(source, "sky").expect("room");
        let layers = Layers::named([LIGHT_GROUPS])
            .expect("known")
            .of_scene(&scene);
        let names: Vec<_> = layers.iter().map(|layer| layer.name).collect();
        assert_eq!(names, ["combined", "light_group_0", "light_group_1"]);
        let names = layers.names(&scene);
        assert_eq!(names["light_group_0"], [UNGROUPED]);
        assert_eq!(names["light_group_1"], ["sky"]);
        assert!(known().contains(&LIGHT_GROUPS) && !known().contains(&"light_group_1"));
    }

    #[test]
    fn nodes_have_layers_of_their_names() {
        let layers = Layers::named(["node:rust", "depth", "node:dirt.old", "node:rust"]);
        let layers = layers.expect("known");
        assert_eq!(layers.nodes(), ["dirt.old", "rust"]);
        assert_eq!(
            layers.asked(),
            ["combined", "depth", "node:dirt.old", "node:rust"]
        );
        assert_eq!(layers.with(["uv"]).expect("known").nodes(), layers.nodes());
        let passes: Vec<_> = layers.iter().map(|layer| layers.pass_of(layer)).collect();
        assert_eq!(passes[2..4], ["Node dirt_old", "Node dirt_old"]);
        for wrong in ["node:", "node", "node_1", "node_1_alpha"] {
            Layers::named([wrong]).expect_err(wrong);
        }
        let many: Vec<String> = (0..9).map(|i| format!("node:{i}")).collect();
        let error = Layers::named(many.iter().map(String::as_str)).expect_err("too many");
        assert!(error.to_string().contains("9 nodes"), "{error}");
        assert!(Layers::all().nodes().is_empty());
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
                ("layer normal 0", 3, 2, 3),
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
