//! What a look means to an editor: its graph, which nodes belong to which material, and who reads what.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use engine::procedural::{Output, resketch, sketch};
use engine::scene::look::{Field, Link, Look, NodeLook, Section, Value, find, link_text};
use engine::session::Document;
use texgen::{Graph, Library, Swizzle, TextureType};

use crate::widgets::is_image;

/// Something that a node's result can be connected to.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum Target {
    /// A parameter of a node.
    Parameter { node: String, parameter: String },
    /// A value of a material.
    Input { material: String, output: Output },
    /// Where a blend shows its `over`.
    Mask { material: String },
}

impl Target {
    /// The table in which it is written, and the key.
    pub(crate) fn place(&self) -> (Section, &str) {
        match self {
            Self::Parameter { node, parameter } => (Section::Node(node.clone()), parameter),
            Self::Input { material, output } => (Section::Material(material.clone()), output.key()),
            Self::Mask { material } => (Section::Material(material.clone()), "blend.mask"),
        }
    }
}

/// A link that is written in the look.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Wire {
    pub(crate) source: String,
    pub(crate) swizzle: Option<Swizzle>,
    pub(crate) target: Target,
}

/// The graph of a look, kept until the look or the textures change.
#[derive(Debug)]
pub(crate) struct Model {
    pub(crate) graph: Graph,
    pub(crate) wires: Vec<Wire>,
    /// Places of wires by their targets.
    by_target: HashMap<Target, usize>,
    /// Places of wires by the nodes that they lead to.
    by_reader: HashMap<String, Vec<usize>>,
    /// Places of nodes in the look by their names.
    nodes: HashMap<String, usize>,
    /// The look's materials by name, as they are written.
    materials: HashMap<String, Vec<Field>>,
    revision: u64,
    id: u64,
}

/// Numbers models from 1 on.
static COUNT: AtomicU64 = AtomicU64::new(1);

impl Model {
    pub(crate) fn new(document: &Document, library: &Arc<Library>) -> Self {
        Self::of_graph(document, sketch(document.look(), library))
    }

    /// The model of what the look has become. Where only constants have changed, as in a drag, that takes less time.
    pub(crate) fn renewed(self: Rc<Self>, document: &Document, library: &Arc<Library>) -> Self {
        if Arc::ptr_eq(self.graph.library(), library) {
            let own = Rc::try_unwrap(self);
            let mut graph = own.map_or_else(|shared| shared.graph.clone(), |own| own.graph);
            if resketch(&mut graph, document.look()) {
                return Self::of_graph(document, graph);
            }
        }
        Self::new(document, library)
    }

    fn of_graph(document: &Document, graph: Graph) -> Self {
        let look = document.look();
        let materials = look.materials.iter().map(|material| {
            let name = material.name.value.clone();
            let table = document.table(&Section::Material(name.clone()));
            (name, table)
        });
        let materials = materials.collect();
        let wires = wires(look, &graph, &materials);
        let mut by_reader: HashMap<String, Vec<usize>> = HashMap::new();
        for (i, wire) in wires.iter().enumerate() {
            if let Target::Parameter { node, .. } = &wire.target {
                by_reader.entry(node.clone()).or_default().push(i);
            }
        }
        let targets = wires.iter().enumerate();
        let names = look.nodes.iter().enumerate();
        let nodes = names
            .map(|(i, node)| (node.name.value.clone(), i))
            .collect();
        let by_target = targets.map(|(i, wire)| (wire.target.clone(), i)).collect();
        Self {
            graph,
            wires,
            by_target,
            by_reader,
            nodes,
            materials,
            revision: document.revision(),
            id: COUNT.fetch_add(1, Ordering::Relaxed),
        }
    }

    /// Another one for each model.
    pub(crate) fn id(&self) -> u64 {
        self.id
    }

    /// Whether it is of this look and these textures.
    pub(crate) fn is_of(&self, document: &Document, library: &Arc<Library>) -> bool {
        self.revision == document.revision() && Arc::ptr_eq(self.graph.library(), library)
    }

    /// A node's table in the look.
    pub(crate) fn table<'l>(&self, look: &'l Look, node: &str) -> Option<&'l NodeLook> {
        look.nodes.get(*self.nodes.get(node)?)
    }

    /// The texture of a node; `None` where the library lacks it.
    pub(crate) fn texture(&self, node: &str) -> Option<&TextureType> {
        Some(self.graph.texture(self.graph.node(node)?))
    }

    /// What the look says about a material.
    pub(crate) fn material(&self, name: &str) -> &[Field] {
        self.materials.get(name).map_or(&[], Vec::as_slice)
    }

    /// Names of the two materials that a blend is made of.
    pub(crate) fn sides(&self, material: &str) -> Option<[&str; 2]> {
        let Value::Table(blend) = &find(self.material(material), "blend")?.value else {
            return None;
        };
        let side = |key| match &find(blend, key)?.value {
            Value::Text(name) => Some(name.as_str()),
            _ => None,
        };
        Some([side("base")?, side("over")?])
    }

    /// Whether a material is a blend of others only, without a surface of its own.
    pub(crate) fn is_pure_blend(&self, material: &str) -> bool {
        self.sides(material)
            .is_some_and(|[base, _]| base != material)
    }

    /// A material and all that it is blended of, itself first.
    pub(crate) fn family<'m>(&'m self, material: &'m str) -> Vec<&'m str> {
        let mut family = vec![material];
        let mut next = 0;
        while let Some(&material) = family.get(next) {
            for side in self.sides(material).into_iter().flatten() {
                if !family.contains(&side) {
                    family.push(side);
                }
            }
            next += 1;
        }
        family
    }

    /// Whether `inner` is part of the blend that `material` is.
    pub(crate) fn is_made_of(&self, material: &str, inner: &str) -> bool {
        self.family(material).contains(&inner)
    }

    /// The nodes below some materials, those that drive them directly first.
    pub(crate) fn nodes_of(&self, materials: &[&str]) -> Vec<String> {
        let mut nodes: Vec<String> = Vec::new();
        let mut seen = HashSet::new();
        for wire in &self.wires {
            let is_root = match &wire.target {
                Target::Input { material, .. } | Target::Mask { material } => {
                    materials.contains(&material.as_str())
                }
                Target::Parameter { .. } => false,
            };
            if is_root && seen.insert(wire.source.clone()) {
                nodes.push(wire.source.clone());
            }
        }
        let mut next = 0;
        while let Some(reader) = nodes.get(next).cloned() {
            for source in self.read_by(&reader) {
                if seen.insert(source.to_owned()) {
                    nodes.push(source.to_owned());
                }
            }
            next += 1;
        }
        nodes
    }

    /// The nodes that a node reads itself.
    fn read_by(&self, node: &str) -> impl Iterator<Item = &str> {
        let wires = self.by_reader.get(node).map_or(&[][..], Vec::as_slice);
        wires.iter().map(|&i| self.wires[i].source.as_str())
    }

    /// A node and all that it reads, directly or not.
    pub(crate) fn upstream<'m>(&'m self, node: &'m str) -> HashSet<&'m str> {
        let mut seen = HashSet::from([node]);
        let mut open = vec![node];
        while let Some(reader) = open.pop() {
            for source in self.read_by(reader) {
                if seen.insert(source) {
                    open.push(source);
                }
            }
        }
        seen
    }

    /// Nodes that no material needs, in the order of the look.
    pub(crate) fn loose_nodes(&self, look: &Look) -> Vec<String> {
        let all: Vec<&str> = self.wires.iter().filter_map(material_of).collect();
        let used: HashSet<String> = self.nodes_of(&all).into_iter().collect();
        let names = look.nodes.iter().map(|node| node.name.value.clone());
        names.filter(|name| !used.contains(name)).collect()
    }

    /// What drives a target.
    pub(crate) fn source(&self, target: &Target) -> Option<&Wire> {
        self.by_target.get(target).map(|&i| &self.wires[i])
    }

    /// What could be connected to a target: nodes as a whole where they fit, else their first component.
    pub(crate) fn fitting(&self, target: &Target) -> Vec<(String, Option<Swizzle>)> {
        // One copy for all: a link replaces the one before.
        let mut graph = self.graph.clone();
        let first: Option<Swizzle> = "x".parse().ok();
        let mut fits = |source, swizzle| match target {
            Target::Parameter { node, parameter } => {
                let reader = self.graph.node(node);
                reader.is_some_and(|reader| {
                    graph.set_link(reader, parameter, source, swizzle).is_ok()
                })
            }
            _ => self.check(self.graph.name(source), swizzle, target).is_ok(),
        };
        let candidates = self.graph.ids().filter_map(|id| {
            let fitting = [None, first]
                .into_iter()
                .find(|&swizzle| fits(id, swizzle))?;
            Some((self.graph.name(id).to_owned(), fitting))
        });
        candidates.collect()
    }

    /// The usual choices of a source's components that fit a target: all of them, one, the first few.
    pub(crate) fn swizzles(&self, source: &str, target: &Target) -> Vec<Option<Swizzle>> {
        let usual = ["x", "y", "z", "w", "xy", "xyz"];
        let usual = usual.iter().filter_map(|text| text.parse().ok().map(Some));
        let fits = |swizzle: &Option<Swizzle>| self.check(source, *swizzle, target).is_ok();
        let outputs = self.texture(source).map_or(&[][..], TextureType::outputs);
        // Each output as a whole where it fits, else its first component.
        let named = outputs.iter().filter_map(|output| {
            let first = format!("{}.x", output.name);
            let whole = Swizzle::of_output(&output.name);
            [whole, first.parse().ok()].into_iter().find(fits)
        });
        [None]
            .into_iter()
            .chain(usual)
            .filter(fits)
            .chain(named)
            .collect()
    }

    /// Checks that a node's result, or some of its components, may go to a target.
    ///
    /// # Errors
    /// Says what to do instead.
    pub(crate) fn check(
        &self,
        source: &str,
        swizzle: Option<Swizzle>,
        target: &Target,
    ) -> Result<(), String> {
        let missing = |name: &str| format!("node `{name}` has a texture with mistakes, or none");
        let node = self.graph.node(source).ok_or_else(|| missing(source))?;
        let link = texgen::Link {
            source: node,
            swizzle,
        };
        match target {
            Target::Parameter { node, parameter } => {
                let reader = self.graph.node(node).ok_or_else(|| missing(node))?;
                let mut graph = self.graph.clone();
                let linked = graph.set_link(reader, parameter, link.source, swizzle);
                linked.map(|_| ()).map_err(|error| error.to_string())
            }
            Target::Input { material, output } => {
                if self.is_pure_blend(material) {
                    return Err(format!(
                        "`{material}` is a blend of other materials: connect to one of those"
                    ));
                }
                output.check(&self.graph, link)
            }
            // A mask is a number, like roughness.
            Target::Mask { .. } => Output::ROUGHNESS.check(&self.graph, link),
        }
    }
}

fn material_of(wire: &Wire) -> Option<&str> {
    match &wire.target {
        Target::Input { material, .. } | Target::Mask { material } => Some(material),
        Target::Parameter { .. } => None,
    }
}

/// The link that a value of a node is whose texture has mistakes, or is missing. Nobody knows what its parameters are; but what is called
/// like an image is one: `wood.png` leads to no output of a node `wood`.
pub(crate) fn assumed_link(value: &Value) -> Option<Link> {
    match value {
        Value::Text(text) if !is_image(Path::new(text)) => link_text(text).ok(),
        _ => None,
    }
}

/// All links as they are written, those of nodes first.
fn wires(look: &Look, graph: &Graph, materials: &HashMap<String, Vec<Field>>) -> Vec<Wire> {
    let mut wires = Vec::new();
    let wire = |value: &Value, target| {
        let Value::Text(text) = value else {
            return None;
        };
        let link = link_text(text).ok()?;
        Some(Wire {
            source: link.node,
            swizzle: link.swizzle,
            target,
        })
    };
    let nodes: HashSet<&str> = (look.nodes.iter())
        .map(|node| node.name.value.as_str())
        .collect();
    for node in &look.nodes {
        let name = &node.name.value;
        let texture = graph.node(name).map(|id| graph.texture(id));
        for field in &node.params {
            let parameter = &field.key.value;
            let declared = texture.and_then(|texture| texture.parameter(parameter));
            // The path of an image is no link. Of a texture with mistakes, what leads to a node counts.
            let may_link = match texture {
                Some(_) => declared.is_some_and(|(_, declared)| declared.ty.is_linkable()),
                None => assumed_link(&field.value.value)
                    .is_some_and(|link| nodes.contains(link.node.as_str())),
            };
            if may_link {
                let target = Target::Parameter {
                    node: name.clone(),
                    parameter: parameter.clone(),
                };
                wires.extend(wire(&field.value.value, target));
            }
        }
    }
    for material in &look.materials {
        let name = &material.name.value;
        let Some(table) = materials.get(name) else {
            continue;
        };
        for output in Output::ALL {
            let target = Target::Input {
                material: name.clone(),
                output,
            };
            wires.extend(find(table, output.key()).and_then(|value| wire(&value.value, target)));
        }
        if let Some(Value::Table(blend)) = find(table, "blend").map(|value| &value.value) {
            let target = Target::Mask {
                material: name.clone(),
            };
            wires.extend(find(blend, "mask").and_then(|value| wire(&value.value, target)));
        }
    }
    wires
}
