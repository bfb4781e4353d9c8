//! `patina info` of a look, without its scene: nodes and what feeds them, materials and what drives them, and the rest in a line
//! each.

use std::collections::BTreeSet;
use std::path::Path;

use engine::scene::look::{
    AoDirection, EnvironmentLook, Input, Link, Look, MaterialLook, NodeLook, Value, link_text,
};
use engine::scene::material_parameters::PARAMETERS;
use serde::Serialize;

use crate::console;
use crate::failure::Failure;

use super::table::{number, numbers, section};

/// A look.
#[derive(Serialize)]
pub(super) struct LookInfo {
    file: String,
    /// For people; absent where the scene's is kept.
    environment: Option<String>,
    /// Keys of the camera that it sets.
    camera: Vec<&'static str>,
    /// Lights that it changes.
    lights: Vec<String>,
    occlusions: Vec<OcclusionInfo>,
    nodes: Vec<NodeInfo>,
    materials: Vec<LookMaterialInfo>,
    includes: Vec<String>,
    /// Nodes that feed no material.
    unused_nodes: Vec<String>,
}

/// A table of ambient occlusion.
#[derive(Serialize)]
struct OcclusionInfo {
    name: String,
    /// Metres.
    distance: f32,
    direction: &'static str,
    samples: u32,
}

/// A node.
#[derive(Serialize)]
struct NodeInfo {
    name: String,
    texture: String,
    /// Parameters that other nodes drive.
    links: Vec<LinkInfo>,
    /// Parameters that are given otherwise.
    arguments: Vec<String>,
}

/// What drives something.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct LinkInfo {
    /// What is driven: a parameter of a texture, or a key of a material.
    pub(super) parameter: String,
    /// The node, and the components that are taken of its result: `rust.x`.
    pub(super) from: String,
    /// The node's texture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) texture: Option<String>,
}

/// What a look says of a material.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(super) struct Driven {
    /// Keys that nodes drive.
    pub(super) driven: Vec<LinkInfo>,
    /// Keys that the look gives constants for.
    pub(super) set: Vec<&'static str>,
    /// Where the material is a blend.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) blend: Option<BlendInfo>,
}

/// `over` where the mask is 1, `base` where it is 0.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct BlendInfo {
    pub(super) base: String,
    pub(super) over: String,
    /// A number, or the node that gives it.
    pub(super) mask: String,
}

#[derive(Serialize)]
struct LookMaterialInfo {
    name: String,
    #[serde(flatten)]
    says: Driven,
}

impl LookInfo {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let look = Look::load(path)?;
        console::diagnostics(&look.warnings);
        Ok(Self::of(&look))
    }

    fn of(look: &Look) -> Self {
        let material = |material: &MaterialLook| LookMaterialInfo {
            name: material.name.value.clone(),
            says: Driven::of(material, look),
        };
        Self {
            file: look.path.display().to_string(),
            environment: (look.environment.as_ref()).map(|e| environment(&e.value)),
            camera: camera(look),
            lights: (look.lights.iter()).map(|l| l.name.value.clone()).collect(),
            occlusions: (look.ao.iter())
                .map(|ao| OcclusionInfo {
                    name: ao.name.value.clone(),
                    distance: ao.settings.distance,
                    direction: match ao.settings.direction {
                        AoDirection::Outside => "outside",
                        AoDirection::Inside => "inside",
                        AoDirection::Both => "both",
                    },
                    samples: ao.settings.samples,
                })
                .collect(),
            nodes: look.nodes.iter().map(|n| NodeInfo::of(n, look)).collect(),
            materials: look.materials.iter().map(material).collect(),
            includes: (look.includes.iter())
                .map(|include| include.file.value.clone())
                .collect(),
            unused_nodes: unused_nodes(look),
        }
    }

    pub(super) fn text(&self) -> String {
        let mut text = format!("{}: a look\n", self.file);
        let mut line = |name: &str, words: &[&str]| {
            if !words.is_empty() {
                text += &format!("  {name:<13}{}\n", words.join(", "));
            }
        };
        let words = |list: &[String]| {
            list.iter()
                .map(String::as_str)
                .collect::<Vec<_>>()
                .join(", ")
        };
        let environment = self.environment.as_deref();
        line("environment", &[environment.unwrap_or("the scene's")]);
        line("camera", &self.camera);
        for (name, list) in [("lights", &self.lights), ("includes", &self.includes)] {
            if !list.is_empty() {
                line(name, &[words(list).as_str()]);
            }
        }
        let occlusions: Vec<_> = (self.occlusions.iter())
            .map(|ao| {
                vec![
                    ao.name.clone(),
                    format!("{} m", number(ao.distance)),
                    ao.direction.to_owned(),
                    format!("{} rays", ao.samples),
                ]
            })
            .collect();
        let nodes: Vec<_> = (self.nodes.iter())
            .map(|node| {
                let links = node.links.iter().map(LinkInfo::text);
                let given = node.arguments.iter().cloned();
                let arguments: Vec<_> = links.chain(given).collect();
                vec![
                    node.name.clone(),
                    node.texture.clone(),
                    arguments.join(", "),
                ]
            })
            .collect();
        let materials: Vec<_> = (self.materials.iter())
            .map(|material| vec![material.name.clone(), material.says.text()])
            .collect();
        text += &section("ambient occlusion", &occlusions);
        text += &section("nodes", &nodes);
        text += &section("materials", &materials);
        let unused: Vec<_> = (self.unused_nodes.iter())
            .map(|name| vec![format!("node {name}")])
            .collect();
        text + &section("unused", &unused)
    }
}

impl NodeInfo {
    fn of(node: &NodeLook, look: &Look) -> Self {
        let links = links(node, look);
        let is_link = |key: &str| links.iter().any(|link| link.parameter == key);
        let arguments = node.params.iter().map(|field| field.key.value.clone());
        Self {
            name: node.name.value.clone(),
            texture: node.texture.value.clone(),
            arguments: arguments.filter(|key| !is_link(key)).collect(),
            links,
        }
    }
}

impl LinkInfo {
    fn new(parameter: &str, link: &Link, look: &Look) -> Self {
        let mut nodes = look.nodes.iter();
        let node = nodes.find(|node| node.name.value == link.node);
        Self {
            parameter: parameter.to_owned(),
            from: from(link),
            texture: node.map(|node| node.texture.value.clone()),
        }
    }

    pub(super) fn text(&self) -> String {
        format!("{} = {}", self.parameter, self.from)
    }
}

impl Driven {
    pub(super) fn of(material: &MaterialLook, look: &Look) -> Self {
        let mut says = Self::default();
        for parameter in &PARAMETERS {
            let key = parameter.key;
            match material.input(key).map(|input| &input.value) {
                Some(Input::Link(link)) => says.driven.push(LinkInfo::new(key, link, look)),
                Some(Input::Constant(_)) => says.set.push(key),
                None if material.flag(key).is_some() || material.word(key).is_some() => {
                    says.set.push(key);
                }
                None => {}
            }
        }
        says.blend = material.blend.as_ref().map(|blend| BlendInfo {
            base: blend.value.base.value.clone(),
            over: blend.value.over.value.clone(),
            mask: match &blend.value.mask.value {
                Input::Constant(value) => number(value.x),
                Input::Link(link) => from(link),
            },
        });
        says
    }

    pub(super) fn text(&self) -> String {
        let mut words: Vec<String> = self.driven.iter().map(LinkInfo::text).collect();
        if let Some(BlendInfo { base, over, mask }) = &self.blend {
            words.push(format!("{over} over {base} by {mask}"));
        }
        words.extend(self.set.iter().map(|key| (*key).to_owned()));
        words.join(", ")
    }
}

fn from(link: &Link) -> String {
    let swizzle = link.swizzle.map_or(String::new(), |s| s.to_string());
    format!("{}{swizzle}", link.node)
}

/// What drives the parameters of a node: texts that name a node. A parameter that takes something else has no such text.
fn links(node: &NodeLook, look: &Look) -> Vec<LinkInfo> {
    let link = |value: &Value| match value {
        Value::Text(text) => link_text(text).ok(),
        _ => None,
    };
    let is_node = |link: &Link| look.nodes.iter().any(|node| node.name.value == link.node);
    let fields = node.params.iter();
    fields
        .filter_map(|field| {
            let link = link(&field.value.value).filter(is_node)?;
            Some(LinkInfo::new(&field.key.value, &link, look))
        })
        .collect()
}

/// Nodes from which no way leads to a material.
pub(super) fn unused_nodes(look: &Look) -> Vec<String> {
    let node_of = |from: &str| from.split('.').next().unwrap_or_default().to_owned();
    let mut used: BTreeSet<String> = BTreeSet::new();
    let mut open: Vec<String> = Vec::new();
    for material in &look.materials {
        let blend = material.blend.iter().map(|blend| &blend.value.mask);
        for input in material.inputs().chain(blend) {
            if let Input::Link(link) = &input.value {
                open.push(link.node.clone());
            }
        }
    }
    while let Some(name) = open.pop() {
        let mut nodes = look.nodes.iter();
        let node = nodes.find(|node| node.name.value == name);
        if let Some(node) = node
            && used.insert(name)
        {
            open.extend(links(node, look).iter().map(|link| node_of(&link.from)));
        }
    }
    let names = look.nodes.iter().map(|node| &node.name.value);
    names
        .filter(|name| !used.contains(*name))
        .cloned()
        .collect()
}

fn environment(look: &EnvironmentLook) -> String {
    match look {
        EnvironmentLook::Constant(radiance) => numbers(&radiance.to_array()),
        EnvironmentLook::Image {
            image,
            rotation,
            intensity,
        } => format!(
            "{}, turned by {}°, times {}",
            image.value,
            number(*rotation),
            number(*intensity)
        ),
        EnvironmentLook::Sky(sky) => format!(
            "clear sky, sun {}° high at {}°",
            number(sky.sun_elevation),
            number(sky.sun_azimuth)
        ),
    }
}

/// The keys of `[camera]` that are given.
fn camera(look: &Look) -> Vec<&'static str> {
    let camera = &look.camera;
    let keys = [
        ("name", camera.name.is_some()),
        ("position", camera.position.is_some()),
        ("look_at", camera.look_at.is_some()),
        ("up", camera.up.is_some()),
        ("y_fov", camera.y_fov.is_some()),
        ("aperture_radius", camera.aperture_radius.is_some()),
        ("f_number", camera.f_number.is_some()),
        ("sensor_height", camera.sensor_height.is_some()),
        ("blades", camera.blades.is_some()),
        ("blade_rotation", camera.blade_rotation.is_some()),
        ("focus_distance", camera.focus_distance.is_some()),
    ];
    let given = keys.into_iter().filter(|(_, is_given)| *is_given);
    given.map(|(key, _)| key).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOK: &str = r##"
environment = { sky = { sun_elevation = 12 } }
[ao.near]
distance = 0.05
[node.base]
texture = "fbm"
scale = 3.0
[node.rust]
texture = "rust"
noise = "base.x"
color = "#804020"
[node.lonely]
texture = "fbm"
[node.lonelier]
texture = "rust"
noise = "lonely"
[material.Paint]
base_color = "rust"
roughness = 0.4
[material.Car]
blend = { base = "Paint", over = "Steel", mask = "base.y" }
"##;

    #[test]
    fn what_drives_what_is_told() {
        let look = Look::parse(Path::new("a.look.toml"), LOOK).expect("a look");
        let info = LookInfo::of(&look);
        assert_eq!(info.unused_nodes, ["lonely", "lonelier"]);
        let rust = &info.nodes[1];
        assert_eq!(rust.links[0].text(), "noise = base.x");
        assert_eq!(rust.links[0].texture.as_deref(), Some("fbm"));
        assert_eq!(rust.arguments, ["color"]);
        let [paint, car] = info.materials.as_slice() else {
            panic!("two materials");
        };
        assert_eq!(paint.says.text(), "base_color = rust, roughness");
        assert_eq!(car.says.text(), "Steel over Paint by base.y");
        let text = info.text();
        for wanted in [
            "clear sky, sun 12° high",
            "nodes (4)",
            "0.05 m",
            "node lonelier",
        ] {
            assert!(text.contains(wanted), "{wanted}:\n{text}");
        }
    }
}
