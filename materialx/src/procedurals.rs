//! Procedural textures of glTF as a [`Document`]: the drafts `KHR_texture_procedurals` and `EXT_texture_procedurals_mx_1_39`, whose
//! flat lists of nodes say the same as MaterialX's XML. What a material binds to them is in [`materials`].

mod json;
mod materials;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use scene::input::Files;
use serde_json::Value as Json;
use texgen::{Diagnostic, Diagnostics, SourceFile};

use crate::document::{Document, Element, ElementId};

use json::{Named, named};

const EXTENSION: &str = "KHR_texture_procedurals";
const DEFINITIONS: &str = "EXT_texture_procedurals_mx_1_39";

impl Document {
    /// Reads a document by the ending of its name: MaterialX, or where drafts are wanted the procedural textures of a `.gltf` or
    /// `.glb` file.
    ///
    /// # Errors
    /// As [`Self::read`]; of glTF a node that can't be understood, by its name; glTF where drafts aren't wanted.
    pub fn open(files: &dyn Files, path: &Path, with_drafts: bool) -> Result<Self, Diagnostics> {
        let ending = path.extension().unwrap_or_default();
        if !["gltf", "glb"]
            .iter()
            .any(|known| ending.eq_ignore_ascii_case(known))
        {
            return Self::read(files, path);
        }
        if !with_drafts {
            let message = format!(
                "{} is glTF, whose procedural textures are drafts",
                path.display()
            );
            let problem = Diagnostic::error(message);
            let remedy = "`--drafts`, or `drafts = true` in a look, reads them all the same; they may change before they are done";
            return Err(problem.with_note(remedy).into());
        }
        let text = json::text(files, path)?;
        Self::of_gltf(path, &text).map_err(Diagnostics::from)
    }

    /// The procedural textures of glTF's JSON.
    fn of_gltf(path: &Path, text: &str) -> Result<Self, Diagnostic> {
        let source = SourceFile::new("gltf", path.display().to_string(), text);
        let gltf: Json = serde_json::from_str(text).map_err(|error| {
            let at = source
                .offset(error.line(), error.column())
                .unwrap_or(text.len());
            Diagnostic::error(format!("not valid JSON: {error}")).with_label(&source, at..at, "")
        })?;
        let mut builder = Builder {
            source: &source,
            gltf: &gltf,
            elements: Vec::new(),
            graphs: Vec::new(),
            places: places(source.text()),
        };
        builder.add("materialx", None, &[("version", "1.39")], 0..0);
        builder.check_versions()?;
        let list = &gltf["extensions"][EXTENSION]["procedurals"];
        let Some(list) = list.as_array().filter(|list| !list.is_empty()) else {
            let problem =
                Diagnostic::error(format!("{} has no procedural textures", path.display()));
            return Err(problem.with_note(format!(
                "they stand in `extensions.{EXTENSION}.procedurals`"
            )));
        };
        for graph in list {
            builder.graph(graph)?;
        }
        builder.materials()?;
        let elements = builder.elements;
        let mut document = Self::new(elements, vec![source.clone()], vec![path.to_owned()]);
        document.is_of_model = true;
        Ok(document)
    }
}

/// A graph that has been read.
struct Graph {
    name: String,
    /// Names and types of what it gives.
    outputs: Vec<(String, String)>,
}

/// A document on its way.
struct Builder<'j> {
    source: &'j SourceFile,
    gltf: &'j Json,
    elements: Vec<Element>,
    graphs: Vec<Graph>,
    /// Where texts are first written behind the extension's name.
    places: HashMap<&'j str, std::ops::Range<usize>>,
}

impl Builder<'_> {
    fn add(
        &mut self,
        kind: &str,
        parent: Option<ElementId>,
        attributes: &[(&str, &str)],
        span: std::ops::Range<usize>,
    ) -> ElementId {
        let id = self.elements.len();
        let attributes = attributes
            .iter()
            .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
        self.elements.push(Element {
            kind: kind.to_owned(),
            attributes: attributes.collect(),
            children: Vec::new(),
            parent,
            file: 0,
            span,
        });
        if let Some(parent) = parent {
            self.elements[parent].children.push(id);
        }
        id
    }

    /// Where a name is first written behind the extension's, to show the line; the extension where it isn't found.
    fn place(&self, name: &str) -> std::ops::Range<usize> {
        if let Some(place) = self.places.get(name) {
            return place.clone();
        }
        let start = self.places.get("procedurals").map_or(0, |at| at.start);
        start..start
    }

    fn problem(&self, name: &str, message: impl Into<String>) -> Diagnostic {
        Diagnostic::error(message).with_label(self.source, self.place(name), "")
    }

    /// Nodes are those of one version of MaterialX, which the file has to name.
    fn check_versions(&self) -> Result<(), Diagnostic> {
        let used = self.gltf["extensionsUsed"].as_array();
        let mut used = used.into_iter().flatten().filter_map(Json::as_str);
        let other = used
            .clone()
            .find(|name| name.contains("texture_procedurals_mx_") && *name != DEFINITIONS);
        if let Some(other) = other {
            let message = format!("the nodes of `{other}` are not known");
            let problem = self.problem(other, message);
            return Err(problem.with_note(format!("what is read: `{DEFINITIONS}`")));
        }
        if used.any(|name| name == DEFINITIONS) || self.gltf["extensions"][EXTENSION].is_null() {
            return Ok(());
        }
        let problem = self.problem(
            EXTENSION,
            "the file doesn't say which nodes its procedural textures have",
        );
        Err(problem.with_note(format!("`extensionsUsed` should list `{DEFINITIONS}`")))
    }

    /// Adds a graph with all that is in it.
    fn graph(&mut self, graph: &Json) -> Result<(), Diagnostic> {
        let number = self.graphs.len();
        let given = graph["name"].as_str().unwrap_or("");
        let is_free = !given.is_empty() && !self.graphs.iter().any(|known| known.name == given);
        let name = if is_free {
            given.to_owned()
        } else {
            format!("procedural_{number}")
        };
        let at = self.place(given);
        let id = self.add("nodegraph", Some(Document::ROOT), &[("name", &name)], at);
        let inputs = named(&graph["inputs"]);
        for input in &inputs {
            let value = self.constant(&name, input)?;
            let at = self.place(input.name);
            let attributes = [
                ("name", input.name),
                ("type", input.ty()),
                ("value", &value),
            ];
            self.add("input", Some(id), &attributes, at);
        }
        let nodes: &[Json] = graph["nodes"].as_array().map_or(&[], Vec::as_slice);
        let names = node_names(nodes);
        for (node, node_name) in nodes.iter().zip(&names) {
            self.node(id, node, node_name, &names, &inputs)?;
        }
        let mut outputs = Vec::new();
        for output in named(&graph["outputs"]) {
            outputs.push((output.name.to_owned(), output.ty().to_owned()));
            let at = self.place(output.name);
            let mut attributes = vec![("name", output.name), ("type", output.ty())];
            let from = format!("the output `{}` of `{name}`", output.name);
            let source = self.source_of(&from, output.name, output.json, &names, &inputs)?;
            attributes.extend(source.iter().map(|(key, value)| (*key, value.as_str())));
            self.add("output", Some(id), &attributes, at);
        }
        self.graphs.push(Graph { name, outputs });
        Ok(())
    }

    fn node(
        &mut self,
        graph: ElementId,
        node: &Json,
        name: &str,
        names: &[String],
        inputs: &[Named<'_>],
    ) -> Result<(), Diagnostic> {
        let at = self.place(name);
        let Some(kind) = node["nodetype"].as_str().filter(|kind| !kind.is_empty()) else {
            return Err(self.problem(name, format!("the node `{name}` has no `nodetype`")));
        };
        let outputs = named(&node["outputs"]);
        let ty = match outputs.len() {
            0 | 1 => node["type"]
                .as_str()
                .unwrap_or_else(|| outputs.first().map_or("", Named::ty)),
            _ => "multioutput",
        };
        let id = self.add(
            kind,
            Some(graph),
            &[("name", name), ("type", ty)],
            at.clone(),
        );
        for input in named(&node["inputs"]) {
            let from = format!("the input `{}` of the node `{name}`", input.name);
            let mut attributes = vec![("name", input.name), ("type", input.ty())];
            let source = self.source_of(&from, name, input.json, names, inputs)?;
            let value = match source.is_empty() {
                true => self.constant(name, &input)?,
                false => String::new(),
            };
            attributes.extend(source.iter().map(|(key, value)| (*key, value.as_str())));
            if !value.is_empty() {
                attributes.push(("value", &value));
            }
            self.add("input", Some(id), &attributes, at.clone());
        }
        Ok(())
    }

    /// What an input or an output is connected to, as attributes of MaterialX; nothing where it has a value of its own.
    fn source_of(
        &self,
        from: &str,
        name: &str,
        json: &Json,
        names: &[String],
        inputs: &[Named<'_>],
    ) -> Result<Vec<(&'static str, String)>, Diagnostic> {
        let mut source = Vec::new();
        if !json["node"].is_null() {
            let number = json["node"]
                .as_u64()
                .and_then(|number| usize::try_from(number).ok());
            let Some(node) = number.and_then(|number| names.get(number)) else {
                let message = format!(
                    "{from} is connected to node {}, but the graph has {}",
                    json["node"],
                    names.len()
                );
                let problem = self.problem(name, message);
                return Err(
                    problem.with_note("nodes are numbered from 0, in the order of the graph")
                );
            };
            source.push(("nodename", node.clone()));
            if let Some(output) = json["output"].as_str() {
                source.push(("output", output.to_owned()));
            }
        } else if !json["input"].is_null() {
            let given = &json["input"];
            let number = given
                .as_u64()
                .and_then(|number| usize::try_from(number).ok());
            let by_number = number.and_then(|number| inputs.get(number));
            let by_name = inputs
                .iter()
                .find(|input| given.as_str() == Some(input.name));
            let Some(input) = by_number.or(by_name) else {
                let message =
                    format!("{from} is connected to the graph's input {given}, which isn't there");
                let known: Vec<&str> = inputs.iter().map(|input| input.name).collect();
                let problem = self.problem(name, message);
                return Err(problem.with_note(format!("inputs of the graph: {}", known.join(", "))));
            };
            source.push(("interfacename", input.name.to_owned()));
        }
        Ok(source)
    }

    /// A value as MaterialX writes it; empty where there is none.
    fn constant(&self, owner: &str, input: &Named<'_>) -> Result<String, Diagnostic> {
        if !input.json["texture"].is_null() {
            return self.image(owner, input);
        }
        let part = |value: &Json| match value {
            Json::Number(number) => Some(number.to_string()),
            Json::Bool(is_on) => Some(is_on.to_string()),
            Json::String(text) => Some(text.clone()),
            _ => None,
        };
        let value = &input.json["value"];
        let text = match value {
            Json::Null => Some(String::new()),
            Json::Array(parts) => parts
                .iter()
                .map(part)
                .collect::<Option<Vec<_>>>()
                .map(|parts| parts.join(", ")),
            value => part(value),
        };
        text.ok_or_else(|| {
            let message = format!(
                "the value of the input `{}` of `{owner}` is no number, text or list of them",
                input.name
            );
            self.problem(owner, message)
        })
    }

    /// The file of an image that an input names by its texture.
    fn image(&self, owner: &str, input: &Named<'_>) -> Result<String, Diagnostic> {
        let texture = &input.json["texture"];
        let number = texture
            .as_u64()
            .and_then(|number| usize::try_from(number).ok());
        let source = number.and_then(|number| self.gltf["textures"][number]["source"].as_u64());
        let image = source.and_then(|source| usize::try_from(source).ok());
        let uri = image.and_then(|image| self.gltf["images"][image]["uri"].as_str());
        match uri {
            Some(uri) if !uri.starts_with("data:") => Ok(json::file_name(uri)),
            _ => {
                let message = format!(
                    "the texture {texture} of the input `{}` of `{owner}` is no image file",
                    input.name
                );
                let problem = self.problem(owner, message);
                Err(problem.with_note("images inside of the file can't be read by graphs so far: write them beside it"))
            }
        }
    }
}

/// Where each text of a JSON file, between its quotes, is first written behind the extension's name.
fn places(text: &str) -> HashMap<&str, std::ops::Range<usize>> {
    let mut places = HashMap::new();
    let mut at = text.find("\"procedurals\"").unwrap_or(0);
    while let Some(open) = text[at..].find('"').map(|open| at + open) {
        let mut is_escaped = false;
        let end = text.as_bytes()[open + 1..].iter().position(|&byte| {
            let ends = byte == b'"' && !is_escaped;
            is_escaped = byte == b'\\' && !is_escaped;
            ends
        });
        let Some(end) = end else { break };
        let close = open + 1 + end;
        places
            .entry(&text[open + 1..close])
            .or_insert(open..close + 1);
        at = close + 1;
    }
    places
}

/// Names of nodes, each of its own.
fn node_names(nodes: &[Json]) -> Vec<String> {
    let mut taken = HashSet::new();
    let mut names = Vec::new();
    for (number, node) in nodes.iter().enumerate() {
        let mut name = node["name"].as_str().unwrap_or("").to_owned();
        if name.is_empty() || taken.contains(&name) {
            name = format!("node_{number}");
        }
        while !taken.insert(name.clone()) {
            name.push('_');
        }
        names.push(name);
    }
    names
}

#[cfg(test)]
mod tests;
