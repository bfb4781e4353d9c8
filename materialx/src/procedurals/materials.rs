//! Materials of glTF that have procedural textures, as shaders of the model `gltf_pbr`: what textures are multiplied with is
//! multiplied here, and of textures that hold several numbers each has its channel.

use serde_json::Value as Json;
use texgen::{Diagnostic, did_you_mean};

use crate::document::{Document, ElementId};

use super::{Builder, EXTENSION};

/// What a texture of a material drives: an input of the shader.
struct Slot {
    /// Where the texture stands, with slashes.
    texture: &'static str,
    input: &'static str,
    /// The channel, or all three as a colour.
    channel: Option<usize>,
    /// What it is multiplied with, and the number that this is where it isn't given.
    factor: &'static str,
    default: f64,
}

const fn slot(
    texture: &'static str,
    input: &'static str,
    channel: Option<usize>,
    factor: &'static str,
    default: f64,
) -> Slot {
    Slot {
        texture,
        input,
        channel,
        factor,
        default,
    }
}

const PBR: &str = "/pbrMetallicRoughness";

/// Those of glTF and its extensions that the shader has.
const SLOTS: [Slot; 14] = [
    slot(
        "/pbrMetallicRoughness/baseColorTexture",
        "base_color",
        None,
        "/pbrMetallicRoughness/baseColorFactor",
        1.0,
    ),
    slot(
        "/pbrMetallicRoughness/metallicRoughnessTexture",
        "metallic",
        Some(2),
        "/pbrMetallicRoughness/metallicFactor",
        1.0,
    ),
    slot(
        "/pbrMetallicRoughness/metallicRoughnessTexture",
        "roughness",
        Some(1),
        "/pbrMetallicRoughness/roughnessFactor",
        1.0,
    ),
    slot("/emissiveTexture", "emissive", None, "/emissiveFactor", 0.0),
    slot(
        "/extensions/KHR_materials_specular/specularTexture",
        "specular",
        Some(3),
        "/extensions/KHR_materials_specular/specularFactor",
        1.0,
    ),
    slot(
        "/extensions/KHR_materials_specular/specularColorTexture",
        "specular_color",
        None,
        "/extensions/KHR_materials_specular/specularColorFactor",
        1.0,
    ),
    slot(
        "/extensions/KHR_materials_transmission/transmissionTexture",
        "transmission",
        Some(0),
        "/extensions/KHR_materials_transmission/transmissionFactor",
        0.0,
    ),
    slot(
        "/extensions/KHR_materials_clearcoat/clearcoatTexture",
        "clearcoat",
        Some(0),
        "/extensions/KHR_materials_clearcoat/clearcoatFactor",
        0.0,
    ),
    slot(
        "/extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture",
        "clearcoat_roughness",
        Some(1),
        "/extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor",
        0.0,
    ),
    slot(
        "/extensions/KHR_materials_sheen/sheenColorTexture",
        "sheen_color",
        None,
        "/extensions/KHR_materials_sheen/sheenColorFactor",
        0.0,
    ),
    slot(
        "/extensions/KHR_materials_sheen/sheenRoughnessTexture",
        "sheen_roughness",
        Some(3),
        "/extensions/KHR_materials_sheen/sheenRoughnessFactor",
        0.0,
    ),
    slot(
        "/extensions/KHR_materials_iridescence/iridescenceTexture",
        "iridescence",
        Some(0),
        "/extensions/KHR_materials_iridescence/iridescenceFactor",
        0.0,
    ),
    slot(
        "/extensions/KHR_materials_anisotropy/anisotropyTexture",
        "anisotropy_strength",
        Some(2),
        "/extensions/KHR_materials_anisotropy/anisotropyStrength",
        0.0,
    ),
    slot(
        "/pbrMetallicRoughness/baseColorTexture",
        "alpha",
        Some(3),
        "",
        1.0,
    ),
];

/// Numbers that no texture multiplies.
const NUMBERS: [(&str, &str); 6] = [
    ("ior", "/extensions/KHR_materials_ior/ior"),
    (
        "emissive_strength",
        "/extensions/KHR_materials_emissive_strength/emissiveStrength",
    ),
    ("alpha_cutoff", "/alphaCutoff"),
    // Whether it is a body.
    (
        "thickness",
        "/extensions/KHR_materials_volume/thicknessFactor",
    ),
    (
        "anisotropy_rotation",
        "/extensions/KHR_materials_anisotropy/anisotropyRotation",
    ),
    (
        "iridescence_ior",
        "/extensions/KHR_materials_iridescence/iridescenceIor",
    ),
];

/// An output of a graph as attributes of what is connected to it, and how many numbers it is.
struct Source {
    graph: String,
    output: String,
    ty: String,
}

impl Builder<'_> {
    /// Adds the materials that have procedural textures.
    pub(super) fn materials(&mut self) -> Result<(), Diagnostic> {
        let gltf = self.gltf;
        let materials = gltf["materials"].as_array().into_iter().flatten();
        for (number, material) in materials.enumerate() {
            let name = match material["name"].as_str() {
                Some(name) if !name.is_empty() => name.to_owned(),
                // As the scene calls it.
                _ => format!("material {number}"),
            };
            self.material(&name, material)?;
        }
        Ok(())
    }

    fn material(&mut self, name: &str, material: &Json) -> Result<(), Diagnostic> {
        let is_bound = |slot: &Slot| {
            !material.pointer(slot.texture).unwrap_or(&Json::Null)["extensions"][EXTENSION]
                .is_null()
        };
        let normal = &material["normalTexture"];
        let has_normal = !normal["extensions"][EXTENSION].is_null();
        if !has_normal && !SLOTS.iter().any(is_bound) {
            return Ok(());
        }
        let at = self.place(name);
        let shader_name = format!("{name}_shader");
        let attributes = [("name", &*shader_name), ("type", "surfaceshader")];
        let shader = self.add("gltf_pbr", Some(Document::ROOT), &attributes, at.clone());
        for slot in &SLOTS {
            let source = match material.pointer(slot.texture) {
                Some(texture) => self.bound(name, texture)?,
                None => None,
            };
            self.slot(name, shader, material, slot, source.as_ref());
        }
        if let Some(source) = self.bound(name, normal)? {
            self.normal(name, shader, normal, &source);
        }
        for (input, factor) in NUMBERS {
            if let Some(number) = material.pointer(factor).and_then(Json::as_f64) {
                let value = number.to_string();
                let attributes = [("name", input), ("type", "float"), ("value", &*value)];
                self.add("input", Some(shader), &attributes, at.clone());
            }
        }
        let film = &material["extensions"]["KHR_materials_iridescence"];
        if !film.is_null() {
            let thickness = film["iridescenceThicknessMaximum"]
                .as_f64()
                .unwrap_or(400.0);
            let value = thickness.to_string();
            let attributes = [
                ("name", "iridescence_thickness"),
                ("type", "float"),
                ("value", &*value),
            ];
            self.add("input", Some(shader), &attributes, at.clone());
        }
        let mode = match material["alphaMode"].as_str() {
            Some("MASK") => "1",
            Some("BLEND") => "2",
            _ => "0",
        };
        let attributes = [("name", "alpha_mode"), ("type", "integer"), ("value", mode)];
        self.add("input", Some(shader), &attributes, at.clone());
        let attributes = [("name", name), ("type", "material")];
        let whole = self.add(
            "surfacematerial",
            Some(Document::ROOT),
            &attributes,
            at.clone(),
        );
        let attributes = [
            ("name", "surfaceshader"),
            ("type", "surfaceshader"),
            ("nodename", &*shader_name),
        ];
        self.add("input", Some(whole), &attributes, at);
        Ok(())
    }

    /// The output that a texture of a material names, if it is procedural.
    fn bound(&self, material: &str, texture: &Json) -> Result<Option<Source>, Diagnostic> {
        let binding = &texture["extensions"][EXTENSION];
        if binding.is_null() {
            return Ok(None);
        }
        let number = binding["index"]
            .as_u64()
            .and_then(|number| usize::try_from(number).ok());
        let Some(graph) = number.and_then(|number| self.graphs.get(number)) else {
            let count = self.graphs.len();
            let message = format!(
                "the material `{material}` names the procedural texture {}, but there are {count}",
                binding["index"]
            );
            return Err(self.problem(material, message));
        };
        let wanted = &binding["output"];
        let number = wanted
            .as_u64()
            .and_then(|number| usize::try_from(number).ok());
        let found = match (number, wanted.as_str()) {
            (Some(number), _) => graph.outputs.get(number),
            (None, Some(name)) => graph.outputs.iter().find(|(known, _)| known == name),
            (None, None) => graph.outputs.first(),
        };
        let Some((output, ty)) = found else {
            let message = format!(
                "the material `{material}` names the output {wanted} of `{}`, which isn't there",
                graph.name
            );
            let known: Vec<&str> = graph.outputs.iter().map(|(name, _)| &**name).collect();
            let near = wanted
                .as_str()
                .and_then(|name| did_you_mean(name, known.iter().copied()));
            let note = match near {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("it has {}", known.join(", ")),
            };
            return Err(self.problem(material, message).with_note(note));
        };
        Ok(Some(Source {
            graph: graph.name.clone(),
            output: output.clone(),
            ty: ty.clone(),
        }))
    }

    /// An input of the shader: what its texture gives times its factor, or the factor alone.
    fn slot(
        &mut self,
        name: &str,
        shader: ElementId,
        material: &Json,
        slot: &Slot,
        source: Option<&Source>,
    ) {
        let at = self.place(name);
        let ty = if slot.channel.is_none() {
            "color3"
        } else {
            "float"
        };
        let factor = factor(material, slot);
        let Some(source) =
            source.filter(|source| slot.input != "alpha" || source.ty.ends_with('4'))
        else {
            let attributes = [("name", slot.input), ("type", ty), ("value", &*factor)];
            self.add("input", Some(shader), &attributes, at);
            return;
        };
        let mut connection = vec![
            ("nodegraph", source.graph.clone()),
            ("output", source.output.clone()),
        ];
        let mut given = source.ty.clone();
        let count = source
            .ty
            .chars()
            .last()
            .and_then(|last| last.to_digit(10))
            .unwrap_or(1) as usize;
        if let Some(channel) = slot.channel.filter(|_| count > 1) {
            let index = channel.min(count - 1).to_string();
            let node = format!("{name}_{}", slot.input);
            let id = self.step("extract", &node, "float", &at);
            self.connect(id, "in", &given, &connection, &at);
            let attributes = [("name", "index"), ("type", "integer"), ("value", &*index)];
            self.add("input", Some(id), &attributes, at.clone());
            connection = vec![("nodename", node)];
            given = "float".to_owned();
        } else if slot.channel.is_none() && count == 4 {
            let node = format!("{name}_{}", slot.input);
            let id = self.step("convert", &node, "color3", &at);
            self.connect(id, "in", &given, &connection, &at);
            connection = vec![("nodename", node)];
            given = "color3".to_owned();
        }
        if factor.split(", ").any(|part| part != "1") {
            let node = format!("{name}_{}_factor", slot.input);
            let id = self.step("multiply", &node, ty, &at);
            self.connect(id, "in1", &given, &connection, &at);
            let attributes = [("name", "in2"), ("type", ty), ("value", &*factor)];
            self.add("input", Some(id), &attributes, at.clone());
            connection = vec![("nodename", node)];
        }
        self.connect(shader, slot.input, ty, &connection, &at);
    }

    /// The normal: a graph gives what a normal map holds, components from 0 to 1.
    fn normal(&mut self, name: &str, shader: ElementId, texture: &Json, source: &Source) {
        let at = self.place(name);
        let node = format!("{name}_normal");
        let id = self.step("normalmap", &node, "vector3", &at);
        let connection = [
            ("nodegraph", source.graph.clone()),
            ("output", source.output.clone()),
        ];
        self.connect(id, "in", "vector3", &connection, &at);
        if let Some(scale) = texture["scale"].as_f64() {
            let value = scale.to_string();
            let attributes = [("name", "scale"), ("type", "float"), ("value", &*value)];
            self.add("input", Some(id), &attributes, at.clone());
        }
        self.connect(shader, "normal", "vector3", &[("nodename", node)], &at);
    }

    fn step(&mut self, kind: &str, name: &str, ty: &str, at: &std::ops::Range<usize>) -> ElementId {
        self.add(
            kind,
            Some(Document::ROOT),
            &[("name", name), ("type", ty)],
            at.clone(),
        )
    }

    fn connect(
        &mut self,
        id: ElementId,
        input: &str,
        ty: &str,
        connection: &[(&'static str, String)],
        at: &std::ops::Range<usize>,
    ) {
        let mut attributes = vec![("name", input), ("type", ty)];
        attributes.extend(connection.iter().map(|(key, value)| (*key, value.as_str())));
        self.add("input", Some(id), &attributes, at.clone());
    }
}

/// A factor as MaterialX writes it, of its kind.
fn factor(material: &Json, slot: &Slot) -> String {
    if slot.input == "alpha" {
        let color = material.pointer(&format!("{PBR}/baseColorFactor"));
        let alpha = color.and_then(|color| color[3].as_f64()).unwrap_or(1.0);
        return alpha.to_string();
    }
    let given = material.pointer(slot.factor);
    let component = |i: usize| match given {
        Some(Json::Array(parts)) => parts.get(i).and_then(Json::as_f64).unwrap_or(slot.default),
        Some(number) => number.as_f64().unwrap_or(slot.default),
        None => slot.default,
    };
    match slot.channel {
        Some(_) => component(0).to_string(),
        None => [0, 1, 2].map(|i| component(i).to_string()).join(", "),
    }
}
