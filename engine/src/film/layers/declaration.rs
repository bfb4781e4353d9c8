//! What a layer is: its declaration, and what follows from it.

use std::collections::{BTreeMap, BTreeSet};

use scene::Scene;

use crate::film::{Film, ids};

/// Most numbers of a pixel in a layer that isn't one of ids.
pub const MAX_CHANNELS: usize = 3;

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
pub(crate) const CAUGHT: &str = "caught";

/// The layer of what the camera sees of the environment.
pub(crate) const ENVIRONMENT: &str = "environment";

/// What all layers of groups are called together.
pub const LIGHT_GROUPS: &str = "light_groups";
/// How the name of each begins; its number follows.
pub(super) const LIGHT_GROUP: &str = "light_group_";

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
/// `FirstSurface`, `frame`, `base`, `normal` and `colors` (the surface's `first_base` and so on, worked out once), and the functions of
/// `passes/film_layers/record.wgsl`.
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

impl PartialEq for Layer {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Layer {}

impl Layer {
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

    /// Whether it is the group of lights that the environment is of, by the names of a scene ([`Layers::names`](super::Layers::names)).
    pub fn is_of_environment(&self, names: &BTreeMap<String, Vec<String>>) -> bool {
        let group = names.get(ENVIRONMENT).map(Vec::as_slice);
        matches!(group, Some([group]) if group == self.name)
    }

    /// Whether it is that of motion, or comes with it.
    pub(super) fn is_of_motion(&self) -> bool {
        self.name.starts_with(VECTOR)
    }

    /// Whether it has a name of its own by which it is asked for, and doesn't only come with another one.
    pub(super) fn is_asked_for(&self) -> bool {
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
    pub(super) fn word_count(&self) -> usize {
        match self.rule {
            Rule::Derived(_) => 0,
            Rule::Ids { .. } => 1,
            Rule::Mean(_) | Rule::Light { .. } | Rule::First { .. } => self.channels.len(),
        }
    }

    /// Planes of the film that it takes.
    pub(super) fn plane_count(&self) -> usize {
        match self.rule {
            Rule::Derived(_) => 0,
            Rule::Mean(_) | Rule::Light { .. } => self.channels.len(),
            Rule::First { .. } => 1,
            Rule::Ids { .. } => ids::PLANES,
        }
    }
}
