//! Meshes, and the nodes that place them, lights and cameras.

use glam::{Affine3A, Quat, Vec3};
use serde_json::{Map, Value, json};

use crate::{LightKind, Mesh, Projection, PunctualLight, Scene};

use super::Tree;
use super::shear::Place;

/// A node for each instance, light and camera; lights and cameras go to the root. So many of them, the first ones, are shown by the
/// scene, the others are within these.
pub(super) fn nodes(
    scene: &Scene,
    tree: &mut Tree,
    root: &mut Map<String, Value>,
) -> (Vec<Value>, usize) {
    let shown = scene.instances.len() + scene.lights.len() + scene.cameras.len();
    let mut nodes = Vec::new();
    let mut within = Vec::new();
    for instance in &scene.instances {
        let (outside, inside) = Place::of(&instance.transform);
        let mut node = json!({ "mesh": instance.mesh });
        if let Some(inside) = inside {
            named(&mut node, &instance.name);
            place(&mut node, &inside);
            let outer = json!({ "children": [shown + within.len()] });
            within.push(std::mem::replace(&mut node, outer));
        }
        named(&mut node, &instance.name);
        place(&mut node, &outside);
        nodes.push(node);
    }
    let mut lights = Vec::new();
    for light in &scene.lights {
        let extension = tree.uses("KHR_lights_punctual");
        let mut node = json!({ "extensions": { extension: { "light": lights.len() } } });
        named(&mut node, &light.name);
        let turned = Quat::from_rotation_arc(Vec3::NEG_Z, light.direction);
        let transform = Affine3A::from_rotation_translation(turned, light.position);
        place(&mut node, &Place::of(&transform).0);
        nodes.push(node);
        lights.push(light_of(light, tree));
    }
    if !lights.is_empty() {
        let extensions = json!({ "KHR_lights_punctual": { "lights": lights } });
        root.insert("extensions".to_owned(), extensions);
    }
    let mut cameras = Vec::new();
    for camera in &scene.cameras {
        let mut node = json!({ "camera": cameras.len() });
        named(&mut node, &camera.name);
        place(&mut node, &Place::of(&camera.transform).0);
        nodes.push(node);
        let mut seen = match camera.projection {
            Projection::Perspective { y_fov } => json!({
                "type": "perspective", "perspective": { "yfov": y_fov, "znear": 0.01 },
            }),
            Projection::Orthographic { y_mag } => json!({
                "type": "orthographic",
                "orthographic": { "xmag": y_mag, "ymag": y_mag, "znear": 0.01, "zfar": 1000.0 },
            }),
        };
        named(&mut seen, &camera.name);
        cameras.push(seen);
        if camera.aperture_radius > 0.0 {
            let warning = format!(
                "camera \"{}\": glTF has no lenses, all is sharp",
                camera.name
            );
            tree.warnings.push(warning);
        }
    }
    if !cameras.is_empty() {
        root.insert("cameras".to_owned(), Value::Array(cameras));
    }
    nodes.extend(within);
    (nodes, shown)
}

fn named(value: &mut Value, name: &str) {
    if !name.is_empty() {
        value["name"] = json!(name);
    }
}

/// Where a node is: as translation, rotation and scale, which glTF demands of matrices, too.
fn place(node: &mut Value, place: &Place) {
    let Place {
        scale,
        rotation,
        translation,
    } = *place;
    if translation != Vec3::ZERO {
        node["translation"] = json!(translation.to_array());
    }
    if rotation.is_finite() && rotation != Quat::IDENTITY {
        node["rotation"] = json!(rotation.normalize().to_array());
    }
    if scale != Vec3::ONE {
        node["scale"] = json!(scale.to_array());
    }
}

fn light_of(light: &PunctualLight, tree: &mut Tree) -> Value {
    // Colours are at most 1; the rest is strength.
    let strength = light.intensity.max_element().max(1e-30);
    let color = light.intensity / strength;
    let kind = match light.kind {
        LightKind::Point => "point",
        LightKind::Spot { .. } => "spot",
        LightKind::Directional => "directional",
        LightKind::Disk { .. } => {
            let warning = format!("light \"{}\": glTF's lights have no size", light.name);
            tree.warnings.push(warning);
            "directional"
        }
    };
    let mut value = json!({ "type": kind, "color": color.to_array(), "intensity": strength });
    if let LightKind::Spot {
        inner_angle,
        outer_angle,
    } = light.kind
    {
        // The inner one must be the smaller.
        let inner = inner_angle.min(outer_angle * (1.0 - 1e-6)).max(0.0);
        value["spot"] = json!({ "innerConeAngle": inner, "outerConeAngle": outer_angle });
    }
    if light.range.is_finite() && kind != "directional" {
        value["range"] = json!(light.range);
    }
    named(&mut value, &light.name);
    value
}

/// The meshes, with a primitive for each material.
pub(super) fn meshes(scene: &Scene, tree: &mut Tree) -> Vec<Value> {
    scene
        .meshes
        .iter()
        .map(|mesh| mesh_of(mesh, tree))
        .collect()
}

fn mesh_of(mesh: &Mesh, tree: &mut Tree) -> Value {
    let buffer = &mut tree.buffer;
    let positions: Vec<[f32; 3]> = mesh.positions.iter().map(Vec3::to_array).collect();
    let normals = mesh
        .normals
        .iter()
        .map(|n| n.normalize_or(Vec3::Y).to_array());
    let mut attributes = json!({
        "POSITION": buffer.attribute(&positions, true),
        "NORMAL": buffer.attribute(&normals.collect::<Vec<_>>(), false),
    });
    let mut put = |name: &str, accessor: usize| attributes[name] = json!(accessor);
    if !mesh.tangents.is_empty() {
        let tangents = mesh.tangents.iter().map(|t| {
            let along = t.truncate().normalize_or(Vec3::X);
            along.extend(if t.w < 0.0 { -1.0 } else { 1.0 }).to_array()
        });
        put(
            "TANGENT",
            buffer.attribute(&tangents.collect::<Vec<_>>(), false),
        );
    }
    for (name, uv) in [("TEXCOORD_0", &mesh.uv0), ("TEXCOORD_1", &mesh.uv1)] {
        if !uv.is_empty() {
            let uv: Vec<[f32; 2]> = uv.iter().map(glam::Vec2::to_array).collect();
            put(name, buffer.attribute(&uv, false));
        } else if name == "TEXCOORD_0" && !mesh.uv1.is_empty() {
            // Sets are numbered without gaps.
            let zeros = vec![[0.0; 2]; mesh.uv1.len()];
            put(name, buffer.attribute(&zeros, false));
        }
    }
    let vectors = |values: &[glam::Vec4]| values.iter().map(|v| v.to_array()).collect::<Vec<_>>();
    if !mesh.colors.is_empty() {
        let colors: Vec<_> = mesh
            .colors
            .iter()
            .map(|c| c.clamp(glam::Vec4::ZERO, glam::Vec4::ONE))
            .collect();
        put("COLOR_0", buffer.attribute(&vectors(&colors), false));
    }
    for custom in &mesh.custom {
        put(
            &custom.name,
            buffer.attribute(&vectors(&custom.values), false),
        );
    }
    let mut materials = mesh.triangle_materials.clone();
    materials.sort_unstable();
    materials.dedup();
    let primitive = |material: u32| {
        let all = mesh.triangles.iter().zip(&mesh.triangle_materials);
        let own = all.filter(|(_, of)| **of == material).map(|(t, _)| *t);
        let triangles: Vec<[u32; 3]> = own.collect();
        let indices = tree.buffer.indices(&triangles, mesh.positions.len());
        json!({ "attributes": attributes, "indices": indices, "material": material })
    };
    let primitives: Vec<Value> = materials.into_iter().map(primitive).collect();
    let mut value = json!({ "primitives": primitives });
    named(&mut value, &mesh.name);
    value
}
