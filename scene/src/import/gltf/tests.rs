//! Whole files in miniature: JSON in, scene out.

use super::{Budget, ImportError, Imported, Request, Tracks, assemble, parse};
use crate::import::merge::merge;
use crate::import::pictures::Pictures;
use crate::input::{Disk, Files};
use crate::{AlphaMode, Environment, LightKind, Moment, Projection, Scene};
use base64::Engine as _;
use glam::{DAffine3, Vec3};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;

/// Loads JSON as if it stood in `dir/test.gltf`.
pub(super) fn import(tree: Value) -> Result<Imported, ImportError> {
    import_at(tree, &Moment::default())
}

/// As it is at a moment.
pub(super) fn import_at(tree: Value, moment: &Moment) -> Result<Imported, ImportError> {
    import_within(tree, moment, Budget::for_geometry())
}

/// As it is with a budget.
pub(super) fn import_within(
    tree: Value,
    moment: &Moment,
    budget: Budget,
) -> Result<Imported, ImportError> {
    let mut tree = tree;
    tree["asset"] = json!({ "version": "2.0" });
    let text = serde_json::to_vec(&tree).unwrap();
    let path = Path::new("dir/test.gltf");
    let budget = Arc::new(budget);
    let files: Arc<dyn Files> = Arc::new(Disk);
    let document = parse(&files, path, text, &budget, true)?;
    let request = Request {
        placement: DAffine3::IDENTITY,
        scene: &Scene::default(),
        with_environment: true,
        moment,
        is_read_again: false,
        pictures: &mut Pictures::default(),
    };
    let tracks = Tracks::read(&document, &moment.motion)?;
    assemble(&document, &tracks, None, request)
}

fn scene(tree: Value) -> Scene {
    import(tree).unwrap_or_else(|error| panic!("{error}")).scene
}

fn error(tree: Value) -> String {
    import(tree)
        .map(drop)
        .expect_err("must be refused")
        .to_string()
}

/// A buffer that holds these floats.
pub(super) fn floats(values: &[f32]) -> Value {
    let bytes: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    buffer(&bytes)
}

fn buffer(bytes: &[u8]) -> Value {
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    json!({ "byteLength": bytes.len(), "uri": format!("data:;base64,{data}") })
}

/// A file with one mesh of these positions and indices, shown by one node.
fn mesh(positions: &[[f32; 3]], indices: &[u32]) -> Value {
    let mut bytes: Vec<u8> = indices
        .iter()
        .flat_map(|index| index.to_le_bytes())
        .collect();
    bytes.extend(
        positions
            .iter()
            .flatten()
            .flat_map(|value| value.to_le_bytes()),
    );
    json!({
        "buffers": [buffer(&bytes)],
        "bufferViews": [
            { "buffer": 0, "byteLength": indices.len() * 4 },
            { "buffer": 0, "byteOffset": indices.len() * 4, "byteLength": positions.len() * 12 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5125, "count": indices.len(), "type": "SCALAR" },
            { "bufferView": 1, "componentType": 5126, "count": positions.len(), "type": "VEC3" },
        ],
        "meshes": [{ "name": "shape", "primitives": [{ "attributes": { "POSITION": 1 }, "indices": 0 }] }],
        "nodes": [{ "mesh": 0 }],
    })
}

const CORNERS: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
];

pub(super) fn square() -> Value {
    mesh(&CORNERS, &[0, 1, 2, 0, 2, 3])
}

#[test]
fn a_cube_without_normals_is_flat_with_four_vertices_a_side() {
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32])
        .collect();
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let indices: Vec<u32> = sides
        .iter()
        .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d])
        .collect();
    let scene = scene(mesh(&corners, &indices));
    let mesh = &scene.meshes[0];
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (12, 24));
    let center = Vec3::splat(0.5);
    for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
        assert!(
            (*position - center).dot(*normal) > 0.49,
            "{normal} points outward"
        );
    }
}

#[test]
fn a_mesh_shown_twice_is_stored_once() {
    let mut tree = square();
    tree["nodes"] = json!([
        { "mesh": 0, "translation": [5, 0, 0] },
        { "mesh": 0, "scale": [-1, 2, 3], "children": [2] },
        { "mesh": 0, "rotation": [0, 0, 2, 0] },
    ]);
    let scene = scene(tree);
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 3));
    assert_eq!(
        scene.instances[0].transform.translation.to_array(),
        [5.0, 0.0, 0.0]
    );
    assert!(scene.instances[1].transform.matrix3.determinant() < 0.0);
    let p = scene.instances[2]
        .transform
        .transform_point3(Vec3::new(1.0, 1.0, 1.0));
    assert!(
        p.abs_diff_eq(Vec3::new(1.0, -2.0, 3.0), 1e-5),
        "half a turn, then mirrored: {p}"
    );
}

#[test]
fn primitives_become_one_mesh_with_a_material_for_each_triangle() {
    let mut tree = square();
    let attributes = json!({ "POSITION": 1 });
    tree["materials"] = json!([{ "name": "a" }, { "name": "b" }]);
    tree["meshes"][0]["primitives"] = json!([
        { "attributes": attributes, "material": 1, "mode": 6 },
        { "attributes": attributes, "mode": 0 },
        { "attributes": attributes, "indices": 0, "material": 0 },
    ]);
    let Imported {
        scene, warnings, ..
    } = import(tree).unwrap();
    assert_eq!(scene.meshes[0].triangle_materials, [1, 1, 0, 0]);
    assert_eq!(scene.materials.len(), 2, "no stand-in where none is needed");
    assert_eq!(warnings.len(), 1, "points: {warnings:?}");
}

#[test]
fn a_primitive_without_a_material_gets_the_default_one() {
    let mut tree = square();
    tree["materials"] = json!([{ "name": "default" }]);
    let scene = scene(tree);
    assert_eq!(scene.meshes[0].triangle_materials, [1, 1]);
    assert_eq!(scene.materials[1].name, "default.001");
    assert_eq!(scene.materials[1].metallic, 1.0);
}

#[test]
fn an_index_out_of_range_names_mesh_and_primitive() {
    let message = error(mesh(&CORNERS, &[0, 1, 4]));
    assert!(
        message.contains("mesh 0 \"shape\", primitive 0"),
        "{message}"
    );
    assert!(message.contains("index 4"), "{message}");
}

#[test]
fn an_accessor_beyond_its_buffer_is_refused_whatever_overflows() {
    for (count, offset) in [
        (5, 0),
        (4, 4),
        (u32::MAX as u64, 0),
        (1, u64::MAX),
        (u64::MAX, u64::MAX),
    ] {
        let mut tree = square();
        tree["accessors"][1]["count"] = count.into();
        tree["accessors"][1]["byteOffset"] = offset.into();
        error(tree);
    }
    let mut tree = square();
    tree["bufferViews"][1]["byteStride"] = 4.into();
    assert!(error(tree).contains("stride"));
}

#[test]
fn useless_triangles_are_dropped_with_one_warning_each() {
    let mut corners = CORNERS.to_vec();
    corners.push([f32::NAN, 0.0, 0.0]);
    let tree = mesh(&corners, &[0, 1, 2, 0, 0, 1, 0, 1, 1, 1, 2, 4]);
    let Imported {
        scene, warnings, ..
    } = import(tree).unwrap();
    assert_eq!(scene.meshes[0].triangles.len(), 1);
    assert_eq!(scene.meshes[0].positions.len(), 3, "the NaN vertex is gone");
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].starts_with("2 degenerate triangles"));
}

#[test]
fn flat_and_infinite_transforms_are_left_out_with_a_warning() {
    for node in [
        json!({ "mesh": 0, "scale": [1, 0, 1] }),
        json!({ "mesh": 0, "translation": [1e38, 1e38, 1e38], "scale": [1e-30, 1, 1e38] }),
    ] {
        let mut tree = square();
        tree["nodes"] = json!([node]);
        let Imported {
            scene, warnings, ..
        } = import(tree).unwrap();
        assert!(scene.instances.is_empty());
        assert_eq!(warnings.len(), 1);
    }
}

#[test]
fn cycles_and_shared_children_are_errors() {
    let nodes = |nodes: Value| json!({ "nodes": nodes });
    assert!(error(nodes(json!([{ "children": [1] }, { "children": [0] }]))).contains("ancestor"));
    assert!(error(nodes(json!([{ "children": [0] }]))).contains("ancestor"));
    assert!(error(nodes(json!([{ "children": [1, 1] }, {}]))).contains("two parents"));
    assert!(error(nodes(json!([{ "children": [7] }]))).contains("child 7"));
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes_needs_no_stack() {
    let mut nodes: Vec<Value> = (1..100_000).map(|i| json!({ "children": [i] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    let mut tree = square();
    tree["nodes"] = nodes.into();
    assert_eq!(scene(tree).instances.len(), 1);
}

#[test]
fn a_kilobyte_cannot_ask_for_gigabytes() {
    let mut tree = square();
    tree["accessors"][1] = json!({ "componentType": 5126, "count": 1 << 24, "type": "VEC3" });
    let primitive = json!({ "attributes": { "POSITION": 1 } });
    tree["meshes"][0]["primitives"] = vec![primitive; 1000].into();
    let message = error(tree);
    assert!(message.contains("MiB"), "{message}");
}

#[test]
fn small_files_cannot_buy_much_work() {
    // Many primitives, targets and nodes over the same few large things: hours, if they were all made.
    let mut tree = square();
    tree["accessors"][1] = json!({ "componentType": 5126, "count": 1 << 20, "type": "VEC3", "sparse": {
        "count": 4, "indices": { "bufferView": 0, "componentType": 5125 }, "values": { "bufferView": 1 },
    } });
    tree["buffers"][0] = buffer(&[0u32, 1, 2, 3].map(u32::to_le_bytes).concat().repeat(8));
    tree["bufferViews"] =
        json!([{ "buffer": 0, "byteLength": 16 }, { "buffer": 0, "byteLength": 64 }]);
    tree["accessors"][0]["count"] = 4.into();
    let target = json!({ "POSITION": 1 });
    let primitive = json!({ "attributes": target, "targets": vec![target.clone(); 2000] });
    tree["meshes"][0] = json!({ "weights": vec![1; 2000], "primitives": vec![primitive; 4] });
    let long = "x".repeat(1 << 16);
    tree["nodes"] = (0..2000)
        .map(|_| json!({ "mesh": 0, "name": long }))
        .collect();
    let message = error(tree);
    assert!(message.contains("MiB"), "{message}");
}

#[test]
fn a_required_extension_is_named_and_an_optional_one_a_warning() {
    let mut tree = square();
    tree["extensionsRequired"] = json!(["KHR_mesh_quantization", "EXT_meshopt_compression"]);
    let message = error(tree);
    assert!(message.contains("EXT_meshopt_compression"), "{message}");
    assert!(message.contains("without mesh compression"), "{message}");

    let mut tree = square();
    tree["extensionsRequired"] = json!(["KHR_animation_pointer", "KHR_xmp_json_ld"]);
    assert!(
        import(tree)
            .expect("they can't be seen")
            .warnings
            .is_empty()
    );

    let mut tree = square();
    tree["materials"] = json!([{ "extensions": { "KHR_materials_volume_scatter": {} } }, { "extensions": { "KHR_materials_volume_scatter": {} } }]);
    let warnings = import(tree).unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("KHR_materials_volume_scatter"));
}

#[test]
fn materials_keep_their_numbers_and_sanitize_nonsense() {
    let mut tree = square();
    tree["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 7.0, 0.5], "metallicFactor": 0.25, "roughnessFactor": -1 },
        "emissiveFactor": [1, 0.5, 0],
        "alphaMode": "MASK", "alphaCutoff": 0.75, "doubleSided": true,
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 10, "extras": { "any": 1 } },
            "KHR_materials_ior": { "ior": 1.25 },
            "KHR_materials_specular": { "specularFactor": 0.5, "specularColorFactor": [2, 1, 1], "extras": {} },
            "KHR_materials_unlit": {},
        },
    }]);
    let Imported {
        scene, warnings, ..
    } = import(tree).unwrap();
    let material = &scene.materials[0];
    assert_eq!(material.base_color.to_array(), [0.5, 0.25, 1.0, 0.5]);
    assert_eq!(
        (material.metallic, material.roughness, material.ior),
        (0.25, 0.0, 1.25)
    );
    assert_eq!(material.emission.to_array(), [10.0, 5.0, 0.0]);
    assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.75 });
    assert_eq!(material.specular_color.to_array(), [2.0, 1.0, 1.0]);
    assert!(material.double_sided && material.unlit && material.specular == 0.5);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
}

#[test]
fn a_picture_used_as_colour_and_as_data_is_there_twice() {
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(2, 3, image::Rgb([10, 20, 30]))
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let data = base64::engine::general_purpose::STANDARD.encode(png.into_inner());
    let mut tree = square();
    tree["images"] =
        json!([{ "uri": format!("data:image/png;base64,{data}") }, { "uri": "not-there.png" }]);
    tree["textures"] = json!([{ "source": 0 }]);
    let info = json!({ "index": 0, "extensions": { "KHR_texture_transform": { "offset": [0.5, 0], "texCoord": 1 } } });
    tree["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorTexture": info, "metallicRoughnessTexture": { "index": 0 } },
        "normalTexture": { "index": 0, "scale": 0.5, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } },
        "emissiveTexture": { "index": 0 },
    }]);
    let scene = scene(tree.clone());
    assert_eq!(scene.images.len(), 2, "the unused one is skipped");
    assert_eq!(
        scene
            .images
            .iter()
            .map(|image| image.srgb)
            .collect::<Vec<_>>(),
        [true, false]
    );
    assert_eq!((scene.images[0].width, scene.images[0].height), (2, 3));
    assert_eq!(scene.images[1].rgba8[..4], [10, 20, 30, 255]);
    let base = scene.materials[0].base_color_texture.unwrap();
    assert_eq!((base.uv_set, base.transform[0].z), (1, 0.5));
    assert_eq!(
        scene.materials[0].normal_texture.unwrap().transform[1].y,
        2.0
    );
    assert_eq!(
        scene.materials[0].emission_texture.unwrap().image,
        base.image
    );

    tree["textures"][0]["source"] = 1.into();
    let message = error(tree);
    assert!(message.contains("not-there.png"), "{message}");
}

#[test]
fn sixteen_bits_a_channel_are_cut_with_a_warning() {
    let mut png = std::io::Cursor::new(Vec::new());
    let grey = image::ImageBuffer::from_pixel(2, 1, image::Luma([0x8080u16]));
    image::DynamicImage::ImageLuma16(grey)
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let data = base64::engine::general_purpose::STANDARD.encode(png.into_inner());
    let mut tree = square();
    tree["images"] = json!([{ "uri": format!("data:image/png;base64,{data}"), "name": "bumps" }]);
    tree["textures"] = json!([{ "source": 0 }]);
    // As colour and as data: it is told once.
    tree["materials"] = json!([{
        "normalTexture": { "index": 0 },
        "emissiveTexture": { "index": 0 },
    }]);
    let Imported {
        scene, warnings, ..
    } = import(tree).unwrap();
    assert_eq!(scene.images.len(), 2);
    assert_eq!(
        warnings,
        ["image 0 \"bumps\" has 16 bits a channel; 8 are kept: slopes from it are terraced"]
    );
}

#[test]
fn basisu_textures_fall_back_to_their_pictures_unless_they_are_required() {
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(2, 3)
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let data = base64::engine::general_purpose::STANDARD.encode(png.into_inner());
    let mut tree = square();
    tree["extensionsUsed"] = json!(["KHR_texture_basisu"]);
    tree["images"] = json!([
        { "uri": "not-there.ktx2", "mimeType": "image/ktx2" },
        { "uri": format!("data:image/png;base64,{data}") },
    ]);
    tree["textures"] = json!([
        { "source": 1, "extensions": { "KHR_texture_basisu": { "source": 0 } } },
        { "extensions": { "KHR_texture_basisu": { "source": 0 } } },
    ]);
    tree["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
        "emissiveTexture": { "index": 1 },
    }]);
    let Imported {
        scene, warnings, ..
    } = import(tree.clone()).unwrap();
    assert_eq!((scene.images[0].width, scene.images[0].height), (2, 3));
    assert!(scene.materials[0].base_color_texture.is_some());
    assert!(scene.materials[0].emission_texture.is_none());
    let warnings = warnings.join("\n");
    assert!(warnings.contains("fallback"), "{warnings}");
    assert!(warnings.contains("texture 1 has no picture"), "{warnings}");
    tree["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    let message = error(tree);
    assert!(message.contains("KHR_texture_basisu"), "{message}");
    assert!(message.contains("PNG, JPEG or WebP"), "{message}");
}

#[test]
fn cameras_and_lights_stand_in_the_world() {
    let mut tree = square();
    tree["cameras"] = json!([
        { "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } },
        { "type": "orthographic", "orthographic": { "xmag": 2, "ymag": 3, "znear": 0, "zfar": 1 } },
    ]);
    tree["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "color": [1, 0.5, 0], "intensity": 4, "range": 9, "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } },
        { "type": "point", "name": "bulb" },
    ] } });
    // A quarter turn about X turns -Z to +Y... of the parent, which is scaled and moved.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    tree["nodes"] = json!([
        { "scale": [3, 3, 3], "translation": [1, 2, 3], "children": [1, 2, 3] },
        { "rotation": [half, 0, 0, half], "camera": 0, "name": "eye", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "camera": 1, "name": "eye" },
        { "extensions": { "KHR_lights_punctual": { "light": 1 } } },
    ]);
    let scene = scene(tree);
    let names: Vec<&str> = scene
        .cameras
        .iter()
        .map(|camera| camera.name.as_str())
        .collect();
    assert_eq!(names, ["eye", "eye.001"]);
    assert_eq!(
        scene.cameras[0].projection,
        Projection::Perspective { y_fov: 0.5 }
    );
    assert_eq!(
        scene.cameras[1].projection,
        Projection::Orthographic { y_mag: 3.0 }
    );
    let looks = scene.cameras[0].transform.transform_vector3(Vec3::NEG_Z);
    assert!(looks.abs_diff_eq(Vec3::Y, 1e-5), "{looks}");
    let spot = &scene.lights[0];
    assert_eq!(spot.intensity.to_array(), [4.0, 2.0, 0.0]);
    assert_eq!(
        (spot.position.to_array(), spot.range),
        ([1.0, 2.0, 3.0], 9.0)
    );
    assert!(spot.direction.abs_diff_eq(Vec3::Y, 1e-5));
    assert_eq!(
        spot.kind,
        LightKind::Spot {
            inner_angle: 0.1,
            outer_angle: 0.2
        }
    );
    assert_eq!(
        (scene.lights[1].name.as_str(), scene.lights[1].range),
        ("bulb", f32::INFINITY)
    );
}

#[test]
fn integers_are_normalized_and_sparse_elements_replaced() {
    // Positions as bytes: the unit square of normalized unsigned bytes, one corner replaced.
    let mut bytes = vec![0, 0, 0, 0, 255, 0, 0, 0, 255, 255, 0, 0];
    bytes.extend([2, 0, 0, 0]); // the index of the replaced element
    bytes.extend([0, 255, 0, 0]); // its value
    let tree = json!({
        "buffers": [buffer(&bytes)],
        "bufferViews": [
            { "buffer": 0, "byteLength": 12, "byteStride": 4 },
            { "buffer": 0, "byteOffset": 12, "byteLength": 1 },
            { "buffer": 0, "byteOffset": 16, "byteLength": 4 },
        ],
        "accessors": [{
            "bufferView": 0, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC3",
            "sparse": { "count": 1, "indices": { "bufferView": 1, "componentType": 5121 }, "values": { "bufferView": 2 } },
        }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "nodes": [{ "mesh": 0 }],
    });
    let scene = scene(tree);
    assert_eq!(scene.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
}

#[test]
fn morph_targets_are_applied_at_their_default_weights() {
    let positions = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let deltas = [0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0];
    let tree = json!({
        "buffers": [floats(&positions), floats(&deltas)],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }, { "buffer": 1, "byteLength": 36 }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3" },
        ],
        "meshes": [{ "weights": [0.5], "primitives": [{ "attributes": { "POSITION": 0 }, "targets": [{ "POSITION": 1 }] }] }],
        "nodes": [{ "mesh": 0 }, { "mesh": 0, "weights": [1] }],
    });
    let scene = scene(tree);
    assert_eq!(scene.meshes.len(), 2, "two poses are two meshes");
    assert_eq!(scene.meshes[0].positions[0].z, 1.0);
    assert_eq!(scene.meshes[1].positions[0].z, 2.0);
}

#[test]
fn what_morph_targets_cannot_change_is_told() {
    for (target, is_read) in [
        (json!({ "POSITION": 1 }), true),
        (json!({ "POSITION": 1, "extras": { "COLOR_0": 1 } }), true),
        (json!({ "COLOR_0": 1 }), false),
        (json!({ "TEXCOORD_0": 1 }), false),
    ] {
        let mut tree = square();
        tree["meshes"][0]["primitives"][0]["targets"] = json!([{ "NORMAL": 1 }, target]);
        tree["meshes"][0]["weights"] = json!([0, 1]);
        let warnings = import(tree).unwrap().warnings.join("\n");
        let is_told = warnings.contains("colours and texture coordinates are ignored");
        assert_eq!(is_told, !is_read, "{target}: {warnings}");
    }
}

#[test]
fn pieces_know_the_topmost_node_above_them() {
    let mut tree = square();
    tree["nodes"] = json!([
        { "name": "car", "children": [1] },
        { "mesh": 0, "children": [2] },
        { "name": "wheel", "mesh": 0 },
        { "name": "tree", "mesh": 0 },
        { "children": [5] },
        { "name": "lost", "mesh": 0 },
    ]);
    tree["scenes"] = json!([{ "nodes": [0, 3, 4] }]);
    tree["scene"] = 0.into();
    let scene = scene(tree);
    let assets = scene.instances.iter().map(|i| (i.name.as_str(), i.asset()));
    let expected = [
        ("node 1", "car"),
        ("wheel", "car"),
        ("tree", "tree"),
        ("lost", "node 4"),
    ];
    assert_eq!(assets.collect::<Vec<_>>(), expected);
}

#[test]
fn only_the_default_scene_is_shown_and_its_environment_read() {
    let mut tree = square();
    tree["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "name": "shown" }]);
    tree["scenes"] = json!([
        { "nodes": [0] },
        { "nodes": [1], "extras": { "environment": { "constant": [1, 2, 3], "scale": 2 } } },
        {},
    ]);
    tree["scene"] = 1.into();
    let shown = scene(tree.clone());
    assert_eq!(shown.instances.len(), 1);
    assert_eq!(shown.instances[0].name, "shown");
    assert!(matches!(shown.environment, Environment::Constant(c) if c == Vec3::new(2.0, 4.0, 6.0)));

    tree["scene"] = 2.into();
    assert!(
        scene(tree.clone()).instances.is_empty(),
        "a scene may be empty"
    );
    tree["scene"] = 3.into();
    assert!(error(tree).contains("scene 3"));
}

#[test]
fn whole_numbers_written_as_floats_are_read() {
    let mut tree = square();
    tree["accessors"][0]["count"] = json!(6.0);
    tree["meshes"][0]["primitives"][0]["indices"] = json!(0.0);
    assert_eq!(scene(tree).meshes[0].triangles.len(), 2);
}

#[test]
fn broken_json_says_where() {
    let text = b"{\n  \"asset\": { \"version\": \"2.0\" },\n  \"nodes\": [ { \"mesh\": true } ]\n}"
        .to_vec();
    let budget = Arc::new(Budget::for_geometry());
    let files: Arc<dyn Files> = Arc::new(Disk);
    let Err(error) = parse(&files, Path::new("test.gltf"), text, &budget, true) else {
        panic!("must be refused");
    };
    assert!(error.to_string().contains("line 3"), "{error}");
}

#[test]
fn a_missing_buffer_file_is_named() {
    let mut tree = square();
    tree["buffers"][0]["uri"] = "no%20such.bin".into();
    let message = error(tree);
    assert!(message.contains("dir/no such.bin"), "{message}");
}

#[test]
fn gpu_instancing_places_a_mesh_many_times() {
    let mut tree = square();
    let translations = [1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 0.0, 0.0];
    tree["buffers"]
        .as_array_mut()
        .unwrap()
        .push(floats(&translations));
    tree["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "buffer": 1, "byteLength": 36 }));
    let accessor = json!({ "bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3" });
    tree["accessors"].as_array_mut().unwrap().push(accessor);
    tree["nodes"] = json!([{
        "mesh": 0, "scale": [2, 2, 2],
        "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 2 } } },
    }]);
    let scene = scene(tree);
    let x: Vec<f32> = scene
        .instances
        .iter()
        .map(|i| i.transform.translation.x)
        .collect();
    assert_eq!(x, [2.0, 4.0, 6.0]);
    assert_eq!(scene.instanced_triangles(), 6);
}

#[test]
fn instances_without_a_size_cannot_buy_time() {
    let mut tree = square();
    let scales = json!({ "componentType": 5126, "count": 1 << 22, "type": "VEC3" });
    tree["accessors"].as_array_mut().unwrap().push(scales);
    let extension = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "SCALE": 2 } } });
    let node = json!({ "mesh": 0, "extensions": extension });
    tree["nodes"] = vec![node; 1000].into();
    let message = error(tree.clone());
    assert!(message.contains("EXT_mesh_gpu_instancing"), "{message}");
    assert!(message.contains("far more than the size of its files"));
    tree["accessors"][2]["count"] = 3.into();
    assert!(scene(tree).instances.is_empty());
}

#[test]
fn merging_shifts_all_references_and_keeps_names_unique() {
    let mut tree = square();
    tree["materials"] = json!([{ "name": "a" }]);
    tree["meshes"][0]["primitives"][0]["material"] = 0.into();
    let mut all = scene(tree.clone());
    let added = merge(&mut all, import(tree).unwrap());
    assert_eq!((added.materials, added.instances), (1..2, 1..2));
    assert_eq!(added.renamed, [("a".to_owned(), "a.001".to_owned())]);
    assert_eq!(all.instances[1].mesh, 1);
    assert_eq!(all.meshes[1].triangle_materials, [1, 1]);
}

#[test]
fn primitives_that_each_have_another_attribute_cannot_buy_memory() {
    let mut tree = square();
    let primitive = |i: u32| {
        let mut attributes = json!({ "POSITION": 1 });
        attributes[format!("_A{i}")] = json!(1);
        json!({ "attributes": attributes, "indices": 0 })
    };
    tree["meshes"][0]["primitives"] = (0..40).map(primitive).collect();
    let few = scene(tree.clone());
    assert_eq!(few.meshes[0].custom.len(), 40);
    // Each of the joined mesh's vertices would have all of them: more than a gigabyte.
    tree["meshes"][0]["primitives"] = (0..4200).map(primitive).collect();
    assert!(error(tree).contains("far more than the size of its files explains"));
}
