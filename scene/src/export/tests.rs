//! Files that are held to the rules of glTF 2.0, and read again.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use serde_json::Value;

use super::glb;
use crate::{
    AlphaMode, Camera, Environment, Image, Instance, LightKind, Material, Mesh, Projection,
    PunctualLight, Sampler, Scene, TextureRef, import,
};

fn texture(image: u32, scale: f32) -> Option<TextureRef> {
    Some(TextureRef {
        image,
        uv_set: 0,
        sampler: Sampler::default(),
        transform: [Vec3::X * scale, Vec3::Y * scale],
    })
}

/// Something of everything.
fn scene() -> Scene {
    let mesh = Mesh {
        name: "tent".to_owned(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::new(0.0, 1.0, 0.5)],
        normals: vec![Vec3::Z; 4],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 4],
        uv0: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![1, 0],
        ..Mesh::default()
    };
    let texels = |rgba: [u8; 4]| Arc::new(rgba.repeat(12));
    let image = |name: &str, rgba, srgb| Image {
        name: name.to_owned(),
        width: 4,
        height: 3,
        rgba8: texels(rgba),
        srgb,
    };
    let turned = Quat::from_rotation_y(0.7);
    Scene {
        meshes: vec![mesh],
        instances: vec![
            Instance {
                name: "first".to_owned(),
                mesh: 0,
                transform: Affine3A::IDENTITY,
                asset: None,
            },
            Instance {
                name: "mirrored".to_owned(),
                mesh: 0,
                transform: Affine3A::from_scale_rotation_translation(
                    Vec3::new(-1.0, 2.0, 3.0),
                    turned,
                    Vec3::new(1.0, 2.0, 3.0),
                ),
                asset: None,
            },
        ],
        materials: vec![
            Material {
                name: "plain".to_owned(),
                base_color: Vec4::new(0.25, 0.5, 0.75, 0.5),
                emission: Vec3::new(4.0, 2.0, 0.0),
                alpha_mode: AlphaMode::Blend,
                double_sided: true,
                ..Material::default()
            },
            Material {
                name: "rich".to_owned(),
                base_color_texture: texture(0, 1.0),
                normal_texture: texture(1, 2.0),
                normal_scale: 0.5,
                ior: 1.25,
                specular: 0.5,
                transmission: 0.25,
                is_solid: true,
                absorption: Vec3::new(1.0, 2.0, 0.0),
                dispersion: 0.125,
                sheen_color: Vec3::new(0.5, 0.0, 1.0),
                coat: 0.5,
                coat_roughness: 0.25,
                anisotropy: 0.5,
                anisotropy_rotation: 1.0,
                iridescence: 1.0,
                diffuse_transmission: 0.5,
                alpha_mode: AlphaMode::Mask { cutoff: 0.25 },
                ..Material::default()
            },
        ],
        images: vec![
            image("colours", [200, 100, 50, 128], true),
            image("normals", [128, 128, 255, 255], false),
        ],
        lights: vec![PunctualLight {
            name: "spot".to_owned(),
            intensity: Vec3::new(10.0, 5.0, 0.0),
            position: Vec3::Y,
            direction: Vec3::NEG_Y,
            range: 8.0,
            kind: LightKind::Spot {
                inner_angle: 0.25,
                outer_angle: 0.5,
            },
        }],
        cameras: vec![Camera {
            name: "eye".to_owned(),
            transform: Affine3A::from_rotation_translation(turned, Vec3::new(0.0, 1.0, 5.0)),
            projection: Projection::Perspective { y_fov: 0.5 },
            aperture_radius: 0.0,
            aperture_blades: 0,
            aperture_rotation: 0.0,
            focus_distance: 1.0,
        }],
        environment: Environment::Constant(Vec3::new(0.5, 1.0, 2.0)),
        ..Scene::default()
    }
}

/// The JSON and the binary of a container, whose header and chunks are checked.
fn parts(glb: &[u8]) -> (Value, &[u8]) {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&glb[..4], word(4), word(8)), (&b"glTF"[..], 2, glb.len()));
    let json = word(12);
    assert_eq!((&glb[16..20], json % 4), (&b"JSON"[..], 0));
    let binary = word(20 + json);
    assert_eq!(&glb[24 + json..28 + json], b"BIN\0");
    assert_eq!((binary % 4, 28 + json + binary), (0, glb.len()));
    let root = serde_json::from_slice(&glb[20..20 + json]).expect("JSON");
    (root, &glb[28 + json..])
}

fn list<'v>(root: &'v Value, key: &str) -> &'v [Value] {
    root[key].as_array().map_or(&[], Vec::as_slice)
}

fn number(value: &Value) -> usize {
    value
        .as_u64()
        .unwrap_or_else(|| panic!("no number: {value}")) as usize
}

/// What the Khronos validator calls errors, for what is written here.
pub(crate) fn check(glb: &[u8]) {
    let (root, binary) = parts(glb);
    assert_eq!(root["asset"]["version"], "2.0");
    assert_eq!(
        root["buffers"],
        serde_json::json!([{ "byteLength": root["buffers"][0]["byteLength"] }])
    );
    let length = number(&root["buffers"][0]["byteLength"]);
    assert!(binary.len() - length < 4);
    let mut end = 0;
    for view in list(&root, "bufferViews") {
        let (offset, bytes) = (number(&view["byteOffset"]), number(&view["byteLength"]));
        assert!(
            offset % 4 == 0 && bytes > 0 && offset >= end && offset + bytes <= length,
            "{view}"
        );
        end = offset + bytes;
    }
    for accessor in list(&root, "accessors") {
        check_accessor(&root, binary, accessor);
    }
    for (key, of) in [
        ("index", "textures"),
        ("source", "images"),
        ("sampler", "samplers"),
    ] {
        each(&root, key, &mut |index| {
            assert!(number(index) < list(&root, of).len(), "{key} {index}")
        });
    }
    let mut used: Vec<String> = Vec::new();
    extensions(&root, &mut used);
    used.sort();
    used.dedup();
    let said: Vec<&str> = list(&root, "extensionsUsed")
        .iter()
        .filter_map(Value::as_str)
        .collect();
    assert_eq!(used, said);
    empty(&root, "");
    for mesh in list(&root, "meshes") {
        check_mesh(&root, binary, mesh);
    }
    for node in list(&root, "nodes") {
        if let Some(rotation) = node["rotation"].as_array() {
            let length: f64 = rotation.iter().map(|x| x.as_f64().unwrap().powi(2)).sum();
            assert!((length - 1.0).abs() < 1e-3, "{node}");
        }
    }
    for material in list(&root, "materials") {
        for factor in material["emissiveFactor"].as_array().into_iter().flatten() {
            assert!(
                (0.0..=1.0).contains(&factor.as_f64().unwrap()),
                "{material}"
            );
        }
    }
    for image in list(&root, "images") {
        let view = &list(&root, "bufferViews")[number(&image["bufferView"])];
        let bytes = &binary[number(&view["byteOffset"])..][..number(&view["byteLength"])];
        assert_eq!(image["mimeType"], "image/png");
        assert_eq!(
            image::guess_format(bytes).ok(),
            Some(image::ImageFormat::Png)
        );
        assert!(view.get("target").is_none());
    }
}

fn check_accessor(root: &Value, binary: &[u8], accessor: &Value) {
    let view = &list(root, "bufferViews")[number(&accessor["bufferView"])];
    let kind = accessor["type"].as_str().unwrap();
    let components = ["SCALAR", "VEC2", "VEC3", "VEC4"]
        .iter()
        .position(|k| *k == kind)
        .unwrap()
        + 1;
    let bytes = if accessor["componentType"] == 5123 {
        2
    } else {
        4
    };
    let count = number(&accessor["count"]);
    assert!(count > 0);
    assert_eq!(
        count * components * bytes,
        number(&view["byteLength"]),
        "{accessor}"
    );
    if accessor["componentType"] != 5126 {
        return;
    }
    let values = floats(root, binary, accessor);
    assert!(values.iter().all(|x| x.is_finite()), "{accessor}");
    for (key, fold) in [("min", f32::min as fn(f32, f32) -> f32), ("max", f32::max)] {
        for (i, said) in accessor[key].as_array().into_iter().flatten().enumerate() {
            let found = values
                .iter()
                .skip(i)
                .step_by(components)
                .copied()
                .reduce(fold);
            assert_eq!(Some(said.as_f64().unwrap() as f32), found, "{accessor}");
        }
    }
}

fn floats(root: &Value, binary: &[u8], accessor: &Value) -> Vec<f32> {
    let view = &list(root, "bufferViews")[number(&accessor["bufferView"])];
    let bytes = &binary[number(&view["byteOffset"])..][..number(&view["byteLength"])];
    bytemuck::pod_collect_to_vec(bytes)
}

fn check_mesh(root: &Value, binary: &[u8], mesh: &Value) {
    for primitive in list(mesh, "primitives") {
        let accessor = |index: &Value| &list(root, "accessors")[number(index)];
        let attributes = primitive["attributes"].as_object().unwrap();
        let positions = accessor(&attributes["POSITION"]);
        assert!(positions["min"].is_array() && positions["max"].is_array());
        for (name, index) in attributes {
            assert_eq!(accessor(index)["count"], positions["count"], "{name}");
            let view = &list(root, "bufferViews")[number(&accessor(index)["bufferView"])];
            assert_eq!(view["target"], 34962, "{name}");
        }
        for (name, stride) in [("NORMAL", 3), ("TANGENT", 4)] {
            let Some(index) = attributes.get(name) else {
                continue;
            };
            for v in floats(root, binary, accessor(index)).chunks(stride) {
                let length = v[0].hypot(v[1]).hypot(v[2]);
                assert!((length - 1.0).abs() < 5e-4, "{name} {v:?}");
                assert!(stride == 3 || v[3].abs() == 1.0, "{name} {v:?}");
            }
        }
        let indices = accessor(&primitive["indices"]);
        assert_eq!(number(&indices["count"]) % 3, 0);
        assert!(number(&primitive["material"]) < list(root, "materials").len());
    }
}

/// Calls `f` with each value of that key below textures' infos, textures and samplers.
fn each(value: &Value, key: &str, f: &mut dyn FnMut(&Value)) {
    match value {
        Value::Object(fields) => {
            for (name, field) in fields {
                if name == key && field.is_u64() {
                    f(field);
                }
                each(field, key, f);
            }
        }
        Value::Array(values) => values.iter().for_each(|v| each(v, key, f)),
        _ => {}
    }
}

fn extensions(value: &Value, found: &mut Vec<String>) {
    if let Some(fields) = value.as_object() {
        let own = fields.get("extensions").and_then(Value::as_object);
        found.extend(own.into_iter().flat_map(|own| own.keys().cloned()));
    }
    match value {
        Value::Object(fields) => fields.values().for_each(|v| extensions(v, found)),
        Value::Array(values) => values.iter().for_each(|v| extensions(v, found)),
        _ => {}
    }
}

/// No list may be empty.
fn empty(value: &Value, place: &str) {
    match value {
        Value::Object(fields) => fields
            .iter()
            .for_each(|(k, v)| empty(v, &format!("{place}/{k}"))),
        Value::Array(values) => {
            assert!(!values.is_empty(), "{place} is empty");
            values.iter().for_each(|v| empty(v, place));
        }
        _ => {}
    }
}

#[test]
fn files_keep_the_rules() {
    let exported = glb(&scene()).expect("a file");
    assert!(exported.warnings.is_empty(), "{:?}", exported.warnings);
    check(&exported.glb);
    let empty = glb(&Scene::default()).expect("a file");
    assert!(empty.glb.starts_with(b"glTF"));
}

#[test]
fn what_is_read_again_is_what_was_written() {
    let written = scene();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    std::fs::write(&path, glb(&written).expect("a file").glb).expect("written");
    let imported = import::load(&path).unwrap_or_else(|e| panic!("{e}"));
    assert!(imported.warnings.is_empty(), "{:?}", imported.warnings);
    let read = imported.scene;
    assert_eq!(read.meshes[0].positions.len(), read.meshes[0].normals.len());
    assert_eq!(read.meshes[0].triangles.len(), 2);
    for (a, b) in written.instances.iter().zip(&read.instances) {
        assert_eq!(a.name, b.name);
        assert!(
            a.transform.abs_diff_eq(b.transform, 1e-5),
            "{:?}",
            b.transform
        );
    }
    for (a, b) in written.materials.iter().zip(&read.materials) {
        let numbers = |m: &Material| {
            let list = [
                m.metallic,
                m.roughness,
                m.normal_scale,
                m.ior,
                m.specular,
                m.transmission,
                m.dispersion,
                m.coat,
                m.coat_roughness,
                m.anisotropy,
                m.anisotropy_rotation,
                m.iridescence,
                m.diffuse_transmission,
                m.sheen_color.z,
                m.emission.x,
                m.emission.y,
                m.base_color.w,
            ];
            (
                list,
                m.alpha_mode,
                m.double_sided,
                m.is_solid,
                m.name.clone(),
            )
        };
        assert_eq!(numbers(a), numbers(b));
        assert!(
            a.absorption.abs_diff_eq(b.absorption, 1e-4),
            "{}",
            b.absorption
        );
    }
    let map = read.materials[1].normal_texture.expect("a normal map");
    assert_eq!(map.transform, [Vec3::X * 2.0, Vec3::Y * 2.0]);
    let image = &read.images[read.materials[1].base_color_texture.expect("one").image as usize];
    assert_eq!(image.rgba8[..4], [200, 100, 50, 128]);
    let (light, camera) = (&read.lights[0], &read.cameras[0]);
    assert_eq!((light.kind, light.range), (written.lights[0].kind, 8.0));
    assert!((light.direction - Vec3::NEG_Y).length() < 1e-5);
    assert!((light.intensity - written.lights[0].intensity).length() < 1e-4);
    assert_eq!(camera.projection, written.cameras[0].projection);
    assert!(
        camera
            .transform
            .abs_diff_eq(written.cameras[0].transform, 1e-5)
    );
    assert!(matches!(read.environment, Environment::Constant(c) if c == Vec3::new(0.5, 1.0, 2.0)));
}

fn again(scene: &Scene) -> Scene {
    let exported = glb(scene).expect("a file");
    assert!(exported.warnings.is_empty(), "{:?}", exported.warnings);
    check(&exported.glb);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    std::fs::write(&path, exported.glb).expect("written");
    let imported = import::load(&path).unwrap_or_else(|e| panic!("{e}"));
    imported.scene
}

#[test]
fn what_is_sheared_stays_so() {
    let mut written = scene();
    let stretched = Affine3A::from_scale_rotation_translation(
        Vec3::new(1.0, 3.0, -1.0),
        Quat::IDENTITY,
        Vec3::X * 20_000.0,
    );
    written.instances[0].transform = stretched * Affine3A::from_rotation_z(0.75);
    let read = again(&written);
    assert_eq!(read.instances.len(), 2);
    for (a, b) in written.instances.iter().zip(&read.instances) {
        assert_eq!((&a.name, a.mesh), (&b.name, b.mesh));
        assert_eq!(a.asset(), b.asset());
        assert_eq!(a.transform.translation, b.transform.translation);
        let (a, b) = (a.transform.matrix3, b.transform.matrix3);
        assert!(a.abs_diff_eq(b, 1e-5), "{a} {b}");
    }
    assert_eq!((read.lights.len(), read.cameras.len()), (1, 1));
}

#[test]
fn the_second_coordinates_are_written_without_the_first() {
    let mut written = scene();
    let mesh = &mut written.meshes[0];
    mesh.uv1 = std::mem::take(&mut mesh.uv0);
    mesh.triangle_materials = vec![0; 2];
    let read = again(&written);
    assert_eq!(read.meshes[0].uv1, written.meshes[0].uv1);
    assert_eq!(read.meshes[0].uv0, [Vec2::ZERO; 4]);
}

#[test]
fn a_volume_is_written_only_of_what_light_goes_through() {
    let mut written = scene();
    let file =
        |scene: &Scene| String::from_utf8_lossy(&glb(scene).expect("a file").glb).into_owned();
    assert!(file(&written).contains("KHR_materials_volume"));
    for material in &mut written.materials {
        material.transmission = 0.0;
        material.diffuse_transmission = 0.0;
    }
    assert!(!file(&written).contains("KHR_materials_volume"));
}

#[test]
fn a_coat_with_a_normal_map_gets_tangents() {
    let mut written = scene();
    written.meshes[0].tangents.clear();
    for material in &mut written.materials {
        material.coat_normal_texture = material.normal_texture.take();
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    std::fs::write(&path, glb(&written).expect("a file").glb).expect("written");
    let imported = import::load(&path).unwrap_or_else(|e| panic!("{e}"));
    assert!(!imported.scene.meshes[0].tangents.is_empty());
}

#[test]
fn a_texture_without_a_width_keeps_its_turn() {
    let mut written = scene();
    let (sin, cos) = 0.7f32.sin_cos();
    for wide in [0.0, 3.0] {
        let rows = [
            Vec3::new(cos * wide, sin * 2.0, 0.25),
            Vec3::new(-sin * wide, cos * 2.0, 0.5),
        ];
        let texture = written.materials[1].normal_texture.as_mut();
        texture.expect("a normal map").transform = rows;
        let read = again(&written).materials[1].normal_texture;
        let read = read.expect("a normal map").transform;
        for (a, b) in rows.iter().zip(read) {
            assert!(a.abs_diff_eq(b, 1e-6), "{rows:?}: {read:?}");
        }
    }
}

#[test]
fn what_gltf_has_no_word_for_is_told() {
    let mut written = scene();
    written.materials[0].priority = 2;
    written.materials[1].shadow_catcher = true;
    let told = glb(&written).expect("a file").warnings.join("\n");
    for said in [
        "\"plain\": glTF has no word for its `priority`",
        "\"rich\": glTF has no word for its `shadow_catcher`",
    ] {
        assert!(told.contains(said), "{told}");
    }
}
