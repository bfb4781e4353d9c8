//! Writes meshes, materials, nodes, a camera as glTF 2.0 with one `.bin` beside it.

use std::path::Path;

use glam::{Quat, Vec3};
use serde_json::{Value, json};

use crate::mesh::Mesh;

/// A glTF document being written.
#[derive(Default)]
pub(crate) struct Writer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
    cameras: Vec<Value>,
    lights: Vec<Value>,
    roots: Vec<usize>,
}

/// Where a node stands.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub(crate) translation: Vec3,
    pub(crate) rotation: Quat,
    pub(crate) scale: f32,
}

impl Place {
    /// Moved only.
    pub(crate) fn at(x: f32, y: f32, z: f32) -> Self {
        Self {
            translation: Vec3::new(x, y, z),
            rotation: Quat::IDENTITY,
            scale: 1.0,
        }
    }

    /// Turned as well.
    pub(crate) fn turned(self, rotation: Quat) -> Self {
        Self { rotation, ..self }
    }

    /// Scaled as well.
    pub(crate) fn scaled(self, scale: f32) -> Self {
        Self { scale, ..self }
    }
}

impl Writer {
    /// A metallic-roughness material; colours are linear.
    pub(crate) fn material(
        &mut self,
        name: &str,
        color: [f32; 3],
        metallic: f32,
        roughness: f32,
    ) -> usize {
        let [r, g, b] = color;
        self.materials.push(json!({
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": metallic,
                "roughnessFactor": roughness,
            },
        }));
        self.materials.len() - 1
    }

    /// A material that only shines; radiance in W/m²/sr is colour times strength.
    pub(crate) fn light(&mut self, name: &str, color: [f32; 3], strength: f32) -> usize {
        self.materials.push(json!({
            "name": name,
            "pbrMetallicRoughness": { "baseColorFactor": [0.0, 0.0, 0.0, 1.0] },
            "emissiveFactor": color,
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": strength } },
        }));
        self.materials.len() - 1
    }

    /// A mesh with one material, to be placed any number of times.
    pub(crate) fn mesh(&mut self, name: &str, mesh: &Mesh, material: usize) -> usize {
        let floats = |v: &[Vec3]| {
            v.iter()
                .flat_map(|v| v.to_array())
                .flat_map(f32::to_le_bytes)
                .collect()
        };
        let min = mesh
            .positions
            .iter()
            .copied()
            .reduce(Vec3::min)
            .unwrap_or_default();
        let max = mesh
            .positions
            .iter()
            .copied()
            .reduce(Vec3::max)
            .unwrap_or_default();
        let count = mesh.positions.len();
        let position = self.accessor(floats(&mesh.positions), 34962, 5126, "VEC3", count);
        self.accessors[position]["min"] = json!(min.to_array());
        self.accessors[position]["max"] = json!(max.to_array());
        let normal = self.accessor(floats(&mesh.normals), 34962, 5126, "VEC3", count);
        let uvs = mesh
            .uvs
            .iter()
            .flat_map(|v| v.to_array())
            .flat_map(f32::to_le_bytes)
            .collect();
        let uv = self.accessor(uvs, 34962, 5126, "VEC2", count);
        let indices = mesh
            .indices
            .iter()
            .copied()
            .flat_map(u16::to_le_bytes)
            .collect();
        let index = self.accessor(indices, 34963, 5123, "SCALAR", mesh.indices.len());
        self.meshes.push(json!({
            "name": name,
            "primitives": [{
                "attributes": { "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv },
                "indices": index,
                "material": material,
            }],
        }));
        self.meshes.len() - 1
    }

    fn accessor(
        &mut self,
        data: Vec<u8>,
        target: u32,
        component: u32,
        ty: &str,
        count: usize,
    ) -> usize {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        self.views.push(json!({
            "buffer": 0,
            "byteOffset": self.bytes.len(),
            "byteLength": data.len(),
            "target": target,
        }));
        self.bytes.extend(data);
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1,
            "componentType": component,
            "count": count,
            "type": ty,
        }));
        self.accessors.len() - 1
    }

    /// A mesh placed in the world, or in `parent`.
    pub(crate) fn node(
        &mut self,
        name: &str,
        mesh: Option<usize>,
        place: Place,
        parent: Option<usize>,
    ) -> usize {
        let mut node = json!({ "name": name });
        if place.translation != Vec3::ZERO {
            node["translation"] = json!(place.translation.to_array());
        }
        if place.rotation != Quat::IDENTITY {
            node["rotation"] = json!(place.rotation.to_array());
        }
        if place.scale != 1.0 {
            node["scale"] = json!([place.scale, place.scale, place.scale]);
        }
        if let Some(mesh) = mesh {
            node["mesh"] = json!(mesh);
        }
        self.push_node(node, parent)
    }

    /// A perspective camera at `eye` that looks at `target`; `y_fov` in degrees.
    pub(crate) fn camera(&mut self, name: &str, eye: Vec3, target: Vec3, y_fov: f32) {
        self.cameras.push(json!({
            "name": name,
            "type": "perspective",
            "perspective": { "yfov": y_fov.to_radians(), "znear": 0.05 },
        }));
        let back = (eye - target).normalize();
        let right = Vec3::Y.cross(back).normalize();
        let rotation = Quat::from_mat3(&glam::Mat3::from_cols(right, back.cross(right), back));
        let node = json!({
            "name": name,
            "camera": self.cameras.len() - 1,
            "translation": eye.to_array(),
            "rotation": rotation.to_array(),
        });
        self.push_node(node, None);
    }

    /// A sun that shines along `direction`; irradiance in W/m² is colour times intensity.
    pub(crate) fn sun(&mut self, name: &str, direction: Vec3, color: [f32; 3], intensity: f32) {
        self.lights.push(json!({
            "name": name,
            "type": "directional",
            "color": color,
            "intensity": intensity,
        }));
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, direction.normalize());
        let node = json!({
            "name": name,
            "rotation": rotation.to_array(),
            "extensions": { "KHR_lights_punctual": { "light": self.lights.len() - 1 } },
        });
        self.push_node(node, None);
    }

    fn push_node(&mut self, node: Value, parent: Option<usize>) -> usize {
        self.nodes.push(node);
        let index = self.nodes.len() - 1;
        match parent {
            None => self.roots.push(index),
            Some(parent) => match self.nodes[parent]["children"].as_array_mut() {
                Some(children) => children.push(json!(index)),
                None => self.nodes[parent]["children"] = json!([index]),
            },
        }
        index
    }

    /// Writes `NAME.gltf` and `NAME.bin` into a directory; returns the size of both in bytes.
    pub(crate) fn write(&self, directory: &Path, name: &str) -> std::io::Result<usize> {
        let mut document = json!({
            "asset": { "version": "2.0", "generator": "Patina's make_demo_scene" },
            "extensionsUsed": ["KHR_materials_emissive_strength"],
            "scene": 0,
            "scenes": [{ "nodes": self.roots }],
            "nodes": self.nodes,
            "materials": self.materials,
            "meshes": self.meshes,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "uri": format!("{name}.bin"), "byteLength": self.bytes.len() }],
        });
        // glTF allows no empty lists.
        if !self.cameras.is_empty() {
            document["cameras"] = json!(self.cameras);
        }
        if !self.lights.is_empty() {
            document["extensionsUsed"] =
                json!(["KHR_materials_emissive_strength", "KHR_lights_punctual"]);
            document["extensions"] = json!({ "KHR_lights_punctual": { "lights": self.lights } });
        }
        let text = document.to_string();
        std::fs::write(directory.join(format!("{name}.bin")), &self.bytes)?;
        std::fs::write(directory.join(format!("{name}.gltf")), &text)?;
        Ok(text.len() + self.bytes.len())
    }
}
