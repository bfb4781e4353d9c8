//! What an input has: its own value, or what it is connected to, through graphs in graphs.

use std::collections::HashSet;
use std::rc::Rc;

use texgen::did_you_mean;

use crate::document::{Document, ElementId};
use crate::types::{Type, numbers, to_linear};
use crate::value::Value;

use super::Converter;
use super::matrix;

/// Connections don't run through more nodes than this.
const MAX_DEPTH: usize = 256;

/// Where names are looked up: a graph, and the node that it stands for where it is a node's definition.
#[derive(Debug)]
pub(crate) struct Scope {
    /// Tells uses of one graph apart.
    key: String,
    graph: ElementId,
    caller: Option<Caller>,
}

#[derive(Debug)]
struct Caller {
    /// The node whose inputs the graph's interface has.
    node: ElementId,
    scope: Rc<Scope>,
    definition: ElementId,
}

impl Scope {
    /// What stands outside of all graphs.
    pub(crate) fn root() -> Rc<Self> {
        Rc::new(Self {
            key: String::new(),
            graph: Document::ROOT,
            caller: None,
        })
    }

    fn graph(graph: ElementId) -> Rc<Self> {
        Rc::new(Self {
            key: format!("{graph}"),
            graph,
            caller: None,
        })
    }

    /// How deep uses of graphs stand in each other.
    fn depth(&self) -> usize {
        self.key.matches('/').count()
    }

    /// What the names of its nodes begin with.
    fn prefix(&self, document: &Document) -> String {
        match &self.caller {
            Some(caller) => {
                let name = document.element(caller.node).name();
                format!("{}{name}_", caller.scope.prefix(document))
            }
            None if self.graph == Document::ROOT => String::new(),
            None => format!("{}_", document.element(self.graph).name()),
        }
    }
}

/// What a node gives: one value, or several by name.
#[derive(Debug, Clone)]
pub(crate) enum Results {
    One(Value),
    Named(Vec<(String, Value)>),
}

impl Results {
    fn take(&self, output: Option<&str>) -> Option<Value> {
        match (self, output) {
            (Self::One(value), _) => Some(value.clone()),
            (Self::Named(values), Some(output)) => {
                let found = values.iter().find(|(name, _)| name == output);
                found.map(|(_, value)| value.clone())
            }
            (Self::Named(values), None) => values.first().map(|(_, value)| value.clone()),
        }
    }
}

impl<'d> Converter<'d> {
    /// The input of an element by its name; `None` where nothing is given, or what is given can't be had (which is warned of).
    pub(crate) fn input(
        &mut self,
        scope: &Rc<Scope>,
        owner: ElementId,
        name: &str,
    ) -> Option<Value> {
        let input = self.document.input(owner, name)?;
        self.connected(scope, input)
    }

    /// What an `input` or an `output` has.
    pub(crate) fn connected(&mut self, scope: &Rc<Scope>, id: ElementId) -> Option<Value> {
        if self.depth >= 2 * MAX_DEPTH {
            self.warn(
                id,
                "connections that lead back to themselves, or too far, give nothing",
            );
            return None;
        }
        self.depth += 1;
        let value = self.followed(scope, id);
        self.depth -= 1;
        value
    }

    fn followed(&mut self, scope: &Rc<Scope>, id: ElementId) -> Option<Value> {
        let document = self.document;
        let element = document.element(id);
        let output = element.attribute("output");
        let value = if let Some(name) = element.attribute("interfacename") {
            self.interface(scope, id, name)
        } else if let Some(name) = element.attribute("nodename") {
            match document.named(scope.graph, id, name) {
                Some(node) => self.node(scope, node, output),
                None => self.missing(id, "node", name),
            }
        } else if let Some(name) = element.attribute("nodegraph") {
            match document.outermost(id, "nodegraph", name) {
                Some(graph) => self.output(&Scope::graph(graph), graph, id, output),
                None => self.missing(id, "graph", name),
            }
        } else if let Some(text) = element.attribute("value") {
            self.written(id, text)
        } else if let Some(name) = output {
            // As files before 1.39 name outputs that stand outside of graphs.
            match document.outermost(id, "output", name) {
                Some(output) => self.connected(&Scope::root(), output),
                None => self.missing(id, "output", name),
            }
        } else {
            None
        };
        let channels = element.attribute("channels");
        match (value, channels) {
            (Some(value), Some(channels)) => {
                let ty = Type::of(element.attribute("type").unwrap_or(""));
                self.swizzled(id, value, ty, channels)
            }
            (value, _) => value,
        }
    }

    fn missing(&mut self, id: ElementId, what: &str, name: &str) -> Option<Value> {
        self.warn(
            id,
            format!("there is no {what} called `{name}` here; the input has its default"),
        );
        None
    }

    /// An input of the interface of a graph.
    fn interface(&mut self, scope: &Rc<Scope>, id: ElementId, name: &str) -> Option<Value> {
        let document = self.document;
        let Some(caller) = &scope.caller else {
            return match document.input(scope.graph, name) {
                Some(input) => self.connected(&Scope::root(), input),
                None => self.missing(id, "input", name),
            };
        };
        if let Some(given) = document.input(caller.node, name) {
            return self.connected(&caller.scope, given);
        }
        let Some(declared) = document.input(caller.definition, name) else {
            return self.missing(id, "input", name);
        };
        let element = document.element(declared);
        if let Some(text) = element.attribute("value") {
            return self.written(declared, text);
        }
        if let Some(property) = element.attribute("defaultgeomprop") {
            return self.property(declared, property);
        }
        // A value that is there but empty says that nothing is meant, as of texts and names of files.
        if !element.attributes.iter().any(|(key, _)| key == "value") {
            let message = format!(
                "the input `{name}` is given nothing, and its definition has no value for it: what takes it has its default"
            );
            self.warn(caller.node, message);
        }
        None
    }

    /// What an input has by the name of one of MaterialX's properties of the surface.
    fn property(&mut self, id: ElementId, name: &str) -> Option<Value> {
        let texture = match name {
            "UV0" => return Some(self.place("mx_texcoord", Type::Vector2)),
            "UV1" => return Some(self.place("mx_texcoord1", Type::Vector2)),
            "Pobject" => "mx_position",
            "Pworld" => "mx_position_world",
            "Nobject" => "mx_normal",
            "Nworld" => "mx_normal_world",
            "Tobject" | "Tworld" => "mx_tangent_world",
            "Bobject" | "Bworld" => "mx_bitangent_world",
            "Vobject" | "Vworld" => "mx_viewdirection_world",
            _ => {
                let message = format!(
                    "the geometric property `{name}` is not known: what takes it has its default"
                );
                self.warn(id, message);
                return None;
            }
        };
        if matches!(name, "Tobject" | "Bobject" | "Vobject") {
            self.warn(
                id,
                format!("`{name}` is given in the world, not in the object's own space"),
            );
        }
        Some(self.vector(texture))
    }

    /// The node that an input is connected to, straight or through a graph's output.
    pub(crate) fn source(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
    ) -> Option<(Rc<Scope>, ElementId)> {
        let document = self.document;
        let element = document.element(id);
        if let Some(name) = element.attribute("nodename") {
            let node = document.named(scope.graph, id, name)?;
            return Some((Rc::clone(scope), node));
        }
        let name = element.attribute("nodegraph")?;
        let graph = document.outermost(id, "nodegraph", name)?;
        let output = document.output(graph, element.attribute("output"))?;
        let name = document.element(output).attribute("nodename")?;
        let node = document.named(graph, output, name)?;
        Some((Scope::graph(graph), node))
    }

    /// What a graph gives by one of its outputs.
    fn output(
        &mut self,
        scope: &Rc<Scope>,
        graph: ElementId,
        user: ElementId,
        wanted: Option<&str>,
    ) -> Option<Value> {
        match self.document.output(graph, wanted) {
            Some(output) => self.connected(scope, output),
            None => self.missing(user, "output", wanted.unwrap_or("out")),
        }
    }

    /// What a node gives by one of its outputs.
    pub(crate) fn node(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
        output: Option<&str>,
    ) -> Option<Value> {
        let key = (scope.key.clone(), id);
        if let Some(done) = self.done.get(&key) {
            let taken = done.as_ref().map(|results| results.take(output));
            return self.taken(id, output, taken);
        }
        if self.open.contains(&key) || self.open.len() >= MAX_DEPTH {
            self.warn(
                id,
                "nodes that are connected in a circle, or too many in a row, give nothing",
            );
            return None;
        }
        if self.is_full(id) {
            return None;
        }
        self.open.push(key.clone());
        let results = match self.definition(id) {
            Some((definition, graph)) => self.defined(scope, id, definition, graph),
            // Its definition may not have been looked for to the end.
            None if self.has_ended(id) => None,
            None => self.leaf(scope, id),
        };
        self.open.pop();
        let taken = results.as_ref().map(|results| results.take(output));
        self.done.insert(key, results);
        self.taken(id, output, taken)
    }

    /// What was taken of a node's outputs, if the node gives anything; names outputs that it hasn't.
    fn taken(
        &mut self,
        id: ElementId,
        output: Option<&str>,
        taken: Option<Option<Value>>,
    ) -> Option<Value> {
        if let (Some(None), Some(output)) = (&taken, output) {
            // An output that a definition has but that gives nothing has been warned of.
            let graph = self.definition(id).map(|(_, graph)| graph);
            let is_known = graph.and_then(|graph| self.document.output(graph, Some(output)));
            if is_known.is_none() {
                return self.missing(id, "output", output);
            }
        }
        taken.flatten()
    }

    /// The definition of a node as a graph, where the document has one. Of several that give its type those count that take all that
    /// the node is given, or else all.
    fn definition(&mut self, id: ElementId) -> Option<(ElementId, ElementId)> {
        let document = self.document;
        let node = document.element(id);
        let definition = match node.attribute("nodedef") {
            Some(name) => document.outermost(id, "nodedef", name),
            None if document.definitions(id).is_empty() => None,
            None => {
                let inputs = self.inputs_of(id);
                let signature = self.signature(id, &inputs);
                match self.definitions.get(&signature) {
                    Some(known) => *known,
                    None => {
                        let found = self.fitting(id, &inputs);
                        self.definitions.insert(signature, found);
                        found
                    }
                }
            }
        }?;
        Some((definition, document.implementation(definition)?))
    }

    /// All that chooses the definition of a node: many nodes share it.
    fn signature(&self, id: ElementId, inputs: &[ElementId]) -> String {
        let document = self.document;
        let node = document.element(id);
        let of = |name| node.attribute(name).unwrap_or("");
        let space = document.space(id).unwrap_or("");
        let (ty, version) = (of("type"), of("version"));
        let mut signature = format!("{space}\n{}\n{ty}\n{version}", node.kind);
        for &given in inputs {
            let given = document.element(given);
            let ty = given.attribute("type").unwrap_or("");
            for part in [given.name(), ty] {
                signature.push('\n');
                signature.push_str(part);
            }
        }
        signature
    }

    /// What an element is given: its own inputs, then those that it inherits and hasn't itself.
    pub(crate) fn inputs_of(&mut self, id: ElementId) -> Vec<ElementId> {
        let document = self.document;
        let mut names = HashSet::new();
        let mut found = Vec::new();
        for at in document.lineage(id) {
            let children = document.children(at);
            if at != id {
                // Each that is looked at is a step: any number of nodes may inherit the same ones.
                self.steps = self.steps.saturating_add(children.len());
            }
            found.extend(children.iter().copied().filter(|&child| {
                let element = document.element(child);
                let is_input = matches!(&*element.kind, "input" | "parameter");
                is_input && names.insert(element.name())
            }));
        }
        found
    }

    /// Of the definitions of a node's category the one that counts.
    fn fitting(&mut self, id: ElementId, inputs: &[ElementId]) -> Option<ElementId> {
        let document = self.document;
        let node = document.element(id);
        let definitions = document.definitions(id);
        // Each that is looked at is a step: there may be as many as nodes.
        self.steps = self.steps.saturating_add(definitions.len());
        if self.is_full(id) {
            return None;
        }
        let mut giving = definitions.to_vec();
        giving.retain(|&definition| self.gives(definition, id));
        let mut taking = giving.clone();
        taking.retain(|&definition| self.takes(definition, inputs));
        let fitting = if taking.is_empty() { giving } else { taking };
        self.of_version(&fitting, node.attribute("version"))
    }

    /// Of several definitions the one of a version, or else the default one, or else the first (MaterialX specification, "Versioned
    /// definitions").
    fn of_version(&self, definitions: &[ElementId], wanted: Option<&str>) -> Option<ElementId> {
        let document = self.document;
        let is_wanted = |&definition: &ElementId| {
            let version = document.element(definition).attribute("version");
            wanted.is_some() && version.map(without_zeros) == wanted.map(without_zeros)
        };
        let is_default = |&definition: &ElementId| {
            let default = document.element(definition).attribute("isdefaultversion");
            default == Some("true")
        };
        let mut all = definitions.iter().copied();
        let found = all.clone().find(is_wanted);
        let found = found.or_else(|| all.clone().find(is_default));
        found.or_else(|| all.next())
    }

    /// Whether a definition has an output of a node's type. Those that it inherits count where it declares none.
    fn gives(&mut self, definition: ElementId, node: ElementId) -> bool {
        let document = self.document;
        let Some(ty) = document.element(node).attribute("type") else {
            return true;
        };
        let types = self.output_types.entry(definition).or_insert_with(|| {
            let mut types = document.lineage(definition).map(|at| {
                let children = document.children(at).iter();
                let outputs = children.map(|&child| document.element(child));
                let outputs = outputs.filter(|child| child.kind == "output");
                let declaring = std::iter::once(document.element(at)).chain(outputs);
                let types = declaring.filter_map(|element| element.attribute("type"));
                types.collect::<Vec<_>>()
            });
            types.find(|types| !types.is_empty()).unwrap_or_default()
        });
        ty == "multioutput" || types.contains(&ty)
    }

    /// Whether a definition declares all inputs that a node is given, with their types.
    fn takes(&self, definition: ElementId, inputs: &[ElementId]) -> bool {
        inputs.iter().all(|&given| {
            let given = self.document.element(given);
            let declared = self.document.input(definition, given.name());
            declared.is_some_and(|declared| {
                self.document.element(declared).attribute("type") == given.attribute("type")
            })
        })
    }

    fn defined(
        &mut self,
        scope: &Rc<Scope>,
        node: ElementId,
        definition: ElementId,
        graph: ElementId,
    ) -> Option<Results> {
        let document = self.document;
        let inner = Rc::new(Scope {
            key: format!("{}/{node}", scope.key),
            graph,
            caller: Some(Caller {
                node,
                scope: Rc::clone(scope),
                definition,
            }),
        });
        if inner.depth() > 32 {
            self.warn(node, "graphs in graphs, more than 32 deep, give nothing");
            return None;
        }
        if self.checked.insert(node) {
            self.name_strangers(node, definition);
        }
        let mut values = Vec::new();
        let mut seen = HashSet::new();
        for at in document.lineage(graph) {
            for &child in document.children(at) {
                let element = document.element(child);
                if element.kind == "output"
                    && seen.insert(element.name())
                    && let Some(value) = self.connected(&inner, child)
                {
                    values.push((element.name().to_owned(), value));
                }
            }
        }
        Some(Results::Named(values))
    }

    /// Warns of what a node is given and its definition doesn't declare.
    fn name_strangers(&mut self, node: ElementId, definition: ElementId) {
        /// Among more inputs nothing near is looked for.
        const MAX_NEAR: usize = 100;
        let document = self.document;
        let mut known: Option<Vec<&str>> = None;
        for child in self.inputs_of(node) {
            let name = document.element(child).name();
            if document.input(definition, name).is_some() {
                continue;
            }
            let known = known.get_or_insert_with(|| {
                let declared = self.inputs_of(definition).into_iter();
                let names = declared.map(|input| document.element(input).name());
                names.take(MAX_NEAR).collect()
            });
            self.stranger(node, child, known);
        }
    }

    /// Warns of an input that its node hasn't, with the nearest one that it has.
    pub(crate) fn stranger(&mut self, node: ElementId, input: ElementId, known: &[&str]) {
        let document = self.document;
        let (kind, name) = (&document.element(node).kind, document.element(input).name());
        let near = did_you_mean(name, known.iter().copied());
        let near = near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
        let message = format!("`{kind}` has no input `{name}`: it has no effect{near}");
        self.warn(input, message);
    }

    /// What the name of a node's node in the look begins with, and its own name.
    pub(crate) fn look_name(&self, scope: &Rc<Scope>, id: ElementId) -> String {
        let name = self.document.element(id).name();
        format!("{}{name}", scope.prefix(self.document))
    }

    /// A value as it is written.
    fn written(&mut self, id: ElementId, text: &str) -> Option<Value> {
        let document = self.document;
        let element = document.element(id);
        let name = element.attribute("type").unwrap_or("");
        if name == "filename" {
            return self.file(id, text);
        }
        if let Some(size) = matrix::size_of(name) {
            let matrix = matrix::written(size, text);
            if matrix.is_none() {
                self.warn(
                    id,
                    format!("`{text}` is no {name}; the input has its default"),
                );
            }
            return matrix;
        }
        let ty = Type::of(name);
        if ty == Type::Other {
            return Some(Value::Text(text.to_owned()));
        }
        let Some(mut values) = numbers(ty, text) else {
            self.warn(
                id,
                format!("`{text}` is no {name}; the input has its default"),
            );
            return None;
        };
        if let (true, Some(space)) = (ty.is_color(), document.inherited(id, "colorspace")) {
            match to_linear(space, [values[0], values[1], values[2]]) {
                Some(rgb) => values[..3].copy_from_slice(&rgb),
                None => self.warn(
                    id,
                    format!(
                        "the colour space `{space}` is not known; the colour is taken as it is"
                    ),
                ),
            }
        }
        if ty == Type::Color3 {
            values[3] = 1.0;
        }
        if let Some(unit) = element.attribute("unit") {
            match factor(unit) {
                Some(factor) => {
                    let own = (element.parent).map_or(1.0, |node| {
                        unit_of_input(&document.element(node).kind, element.name())
                    });
                    values = values.map(|x| x * (factor / own));
                }
                None => self.warn(
                    id,
                    format!("the unit `{unit}` is not known; the number is taken as it is"),
                ),
            }
        }
        Some(Value::Numbers(ty, values))
    }
}

/// A version without the zeros that it may end with: `2.0` is `2`.
fn without_zeros(version: &str) -> &str {
    version.trim_end_matches(".0")
}

/// How many metres or degrees are one of what an input is reckoned in, whatever it is written in: of films in nanometres or
/// micrometres, of some angles in radians.
fn unit_of_input(kind: &str, input: &str) -> f32 {
    let unit = match (kind, input) {
        ("standard_surface", "thin_film_thickness") | ("gltf_pbr", "iridescence_thickness") => {
            "nanometer"
        }
        ("open_pbr_surface", "thin_film_thickness") => "micron",
        ("gltf_pbr", "anisotropy_rotation") | ("sin" | "cos" | "tan", "in") => "radian",
        _ => return 1.0,
    };
    factor(unit).unwrap_or(1.0)
}

/// How many metres, degrees or whatever MaterialX reckons in are one of a unit.
fn factor(unit: &str) -> Option<f32> {
    Some(match unit {
        "meter" | "degree" | "percent" => 1.0,
        "nanometer" => 1e-9,
        "micron" => 1e-6,
        "millimeter" => 1e-3,
        "centimeter" => 1e-2,
        "kilometer" => 1e3,
        "inch" => 0.0254,
        "foot" => 0.3048,
        "yard" => 0.9144,
        "mile" => 1_609.344,
        "radian" => 180.0 / std::f32::consts::PI,
        _ => return None,
    })
}
