//! What a film can gather: its layers, one declaration each. To add one is to add its line to [`LAYERS`]; storage,
//! kernels, partial renders, merging, files, the command line and the page about them follow from it.
//!
//! Nothing here knows how a path is traced: a declaration says in WGSL what the first surface of a path gives, and
//! `passes/film_layers` puts that into a kernel.

mod declaration;
mod table;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use scene::{LightSource, Scene, UNGROUPED};

use super::PICTURE_PLANES;

use self::declaration::LIGHT_GROUP;
pub(super) use self::declaration::{CAUGHT, ENVIRONMENT};
pub use self::declaration::{
    LIGHT_GROUPS, Layer, MAX_CHANNELS, MAX_NODES, NODE, Rule, SHADOW_CATCHER, VECTOR,
};
pub use self::table::LAYERS;

/// Most bytes of names in the header of a file.
const MOST_NAMES: usize = 8 << 20;

impl Layer {
    /// The layer of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        LAYERS.iter().find(|layer| layer.name == name)
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

    /// Whether groups of lights are among them.
    fn have_groups(&self) -> bool {
        self.others
            .iter()
            .any(|layer| layer.light_group().is_some())
    }

    /// Whether groups of lights are among them, besides that of all light which is in none.
    pub(crate) fn have_light_groups(&self) -> bool {
        let mut groups = self.others.iter().filter_map(|layer| layer.light_group());
        groups.any(|number| number > 0)
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

    /// The names of what a scene has to show in layers of ids, and of its groups of lights, by layer, and which of the latter is that of the
    /// environment ([`Layer::is_of_environment`]): for [`Origin::names`](super::Origin::names). Where they are too many for the header of a file, those of groups alone.
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
                (None, _) if layer.name == ENVIRONMENT && self.have_groups() => {
                    let group = scene.light_groups.of(LightSource::Environment);
                    Some(vec![format!("{LIGHT_GROUP}{group}")])
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
        if bytes > MOST_NAMES {
            // Groups are few, and layers are named by them.
            names.retain(|name, _| Layer::named(name).is_some_and(|layer| !layer.is_of_ids()));
        }
        names
    }

    /// What the samples of a wave are added to beside the picture, in the order of the film's planes: one kernel each.
    pub(crate) fn sums(&self) -> Vec<Sum> {
        let mut sums = Vec::new();
        // The first word of a path's record says whether it met anything, the second one of which parts of the light it has any.
        let mut word = 2;
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

/// The bit of a layer among those that a path has brought light for, `lit_layers` of `film_layers/samples.wgsl`; 0 for one that is no part
/// of the light.
pub(crate) fn lit_bit(layer: &Layer) -> u32 {
    let mut parts = LAYERS.iter().filter(|layer| layer.is_light());
    parts.position(|part| part == layer).map_or(0, |at| 1 << at)
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
    use super::super::{Film, ids};
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
                false => [0.25, 1e-6, 0.0],
            });
        }
        let value = |name| {
            film.values(Layer::named(name).expect("known"))
                .expect("gathered")[0]
        };
        // Light that has no colour to be divided by, or next to none, makes it white.
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
        assert!(!names.contains_key(ENVIRONMENT));
        let layers = layers.with([ENVIRONMENT]).expect("known").of_scene(&scene);
        let names = layers.names(&scene);
        let of_environment = layers
            .iter()
            .filter(|layer| layer.is_of_environment(&names));
        let of_environment: Vec<_> = of_environment.map(|layer| layer.name).collect();
        assert_eq!(of_environment, ["light_group_1"]);
        assert!(known().contains(&LIGHT_GROUPS) && !known().contains(&"light_group_1"));
    }

    #[test]
    fn groups_keep_their_names_where_those_of_objects_are_too_many() {
        let mut scene = Scene::default();
        let source = scene::LightSource::Environment;
        scene.light_groups.assign(source, "sky").expect("room");
        let material = |name: String| scene::Material {
            name,
            ..scene::Material::default()
        };
        scene.materials = vec![material("few".to_owned())];
        let layers = Layers::named([LIGHT_GROUPS, "crypto_material"])
            .expect("known")
            .of_scene(&scene);
        assert_eq!(layers.names(&scene)["crypto_material"], ["few"]);
        scene.materials.push(material("x".repeat(MOST_NAMES / 6)));
        let names = layers.names(&scene);
        assert!(!names.contains_key("crypto_material"));
        assert_eq!(names["light_group_1"], ["sky"]);
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
                ("layer depth 0", 1, 2, 1),
                ("layer normal 0", 3, 3, 3),
                ("layer crypto_object 0", ids::PLANES, 6, 1),
            ]
        );
        assert_eq!(layers.record_words(), 7);
        assert_eq!(layers.plane_count(), layers.buffers().len());
        assert_eq!(Layers::default().record_words(), 0);
        let error = Layers::named(["deep"]).expect_err("unknown").to_string();
        assert!(error.contains("deep") && error.contains("depth"), "{error}");
    }
}
