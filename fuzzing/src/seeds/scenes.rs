//! Scenes as text and as `.glb`, and the small ones that lie beside the checkout.

use std::io::Cursor;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use serde_json::{Value, json};

use super::files;
use crate::root;

/// The largest file that is taken from elsewhere: larger ones are slower and rarely better.
const LARGEST: u64 = 40 << 10;

/// All seeds of scenes.
pub fn gltf() -> Vec<Vec<u8>> {
    let mut scenes = renderable();
    scenes.extend(elsewhere("malformed"));
    scenes
}

/// Those that are meant to be seen.
pub(super) fn renderable() -> Vec<Vec<u8>> {
    let rich = rich();
    let mut scenes = vec![
        triangle().to_string().into_bytes(),
        rich.to_string().into_bytes(),
        glb(&rich),
        glb(&triangle()),
    ];
    scenes.extend(elsewhere("khronos"));
    let trials = root().join("../shared/trials/reliability");
    scenes.extend(files(&trials, &["glb", "gltf"], LARGEST));
    scenes
}

/// Small scenes of a folder beside the checkout.
fn elsewhere(folder: &str) -> Vec<Vec<u8>> {
    let folder = root().join("../shared/scenes").join(folder);
    // Text whose data lie in other files reads nothing from here.
    let mut scenes = files(&folder, &["gltf"], LARGEST);
    scenes.retain(|text| text.windows(5).any(|window| window == b"data:"));
    scenes.extend(files(&folder, &["glb"], LARGEST));
    scenes
}

fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", BASE64.encode(bytes))
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// One triangle with a material called A.
pub fn triangle() -> Value {
    let corners = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "uri": data("application/octet-stream", &corners), "byteLength": 36 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "materials": [{ "name": "A", "doubleSided": true }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    })
}

/// Buffers by and by: where each piece lies.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
}

impl Buffer {
    fn add(&mut self, piece: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view =
            json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": piece.len() });
        self.bytes.extend(piece);
        self.views.push(view);
        self.views.len() - 1
    }
}

/// A little of everything that is read: attributes, indices, sparse accessors, morph targets, a skin, instances,
/// pictures, extensions of materials, lights and cameras, animations.
fn rich() -> Value {
    let mut buffer = Buffer::default();
    let positions = buffer.add(&floats(&[
        -1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0,
    ]));
    let normals = buffer.add(&floats(&[0.0, 0.0, 1.0].repeat(4)));
    let coordinates = buffer.add(&floats(&[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]));
    let colors = buffer.add(&[255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 9, 9, 9, 128]);
    let indices = buffer.add(&[0, 0, 1, 0, 2, 0, 0, 0, 2, 0, 3, 0]);
    let joints = buffer.add(&[0, 1, 0, 0].repeat(4));
    let weights = buffer.add(&floats(&[0.5, 0.5, 0.0, 0.0].repeat(4)));
    let matrix = [
        1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
    ];
    let matrices = buffer.add(&floats(&matrix.repeat(2)));
    let moved = buffer.add(&floats(&[0.0, 0.0, 0.25]));
    let which = buffer.add(&[2]);
    let places = buffer.add(&floats(&[0.0, 0.0, 0.0, 2.5, 0.0, -1.0]));
    let custom = buffer.add(&floats(&[0.1, 0.2, 0.3, 0.4]));
    let picture = buffer.add(&png());
    let times = buffer.add(&floats(&[0.0, 1.0]));
    let ways = buffer.add(&floats(&[0.0, 0.0, 0.0, 1.0, 2.0, 3.0]));
    let turns = buffer.add(&floats(&[0.0, 0.0, 0.0, 1.0].repeat(6)));
    let shares = buffer.add(&floats(&[0.0, 1.0]));
    let texture = json!({ "index": 0, "extensions": { "KHR_texture_transform":
        { "offset": [0.1, 0.2], "rotation": 0.5, "scale": [2, 2] } } });
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform", "EXT_mesh_gpu_instancing"],
        "buffers": [{ "uri": data("application/octet-stream", &buffer.bytes), "byteLength": buffer.bytes.len() }],
        "bufferViews": buffer.views,
        "accessors": [
            { "bufferView": positions, "componentType": 5126, "count": 4, "type": "VEC3",
                "min": [-1, -1, 0], "max": [1, 1, 0] },
            { "bufferView": normals, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": coordinates, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": colors, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4" },
            { "bufferView": indices, "componentType": 5123, "count": 6, "type": "SCALAR" },
            { "bufferView": joints, "componentType": 5121, "count": 4, "type": "VEC4" },
            { "bufferView": weights, "componentType": 5126, "count": 4, "type": "VEC4" },
            { "bufferView": matrices, "componentType": 5126, "count": 2, "type": "MAT4" },
            { "componentType": 5126, "count": 4, "type": "VEC3", "sparse": { "count": 1,
                "indices": { "bufferView": which, "componentType": 5121 }, "values": { "bufferView": moved } } },
            { "bufferView": places, "componentType": 5126, "count": 2, "type": "VEC3" },
            { "bufferView": custom, "componentType": 5126, "count": 4, "type": "SCALAR" },
            { "bufferView": times, "componentType": 5126, "count": 2, "type": "SCALAR" },
            { "bufferView": ways, "componentType": 5126, "count": 2, "type": "VEC3" },
            { "bufferView": turns, "componentType": 5126, "count": 6, "type": "VEC4" },
            { "bufferView": shares, "componentType": 5126, "count": 2, "type": "SCALAR" },
        ],
        "animations": [{ "name": "Swing",
            "channels": [
                { "sampler": 0, "target": { "node": 3, "path": "translation" } },
                { "sampler": 1, "target": { "node": 0, "path": "rotation" } },
                { "sampler": 2, "target": { "node": 1, "path": "weights" } },
                { "sampler": 0, "target": { "node": 5, "path": "scale" } },
            ],
            "samplers": [
                { "input": 11, "output": 12 },
                { "input": 11, "output": 13, "interpolation": "CUBICSPLINE" },
                { "input": 11, "output": 14, "interpolation": "STEP" },
            ] }],
        "images": [
            { "bufferView": picture, "mimeType": "image/png" },
            { "uri": data("image/png", &png()) },
        ],
        "samplers": [{ "magFilter": 9728, "minFilter": 9987, "wrapS": 33071, "wrapT": 33648 }],
        "textures": [{ "source": 0, "sampler": 0 }, { "source": 1 }],
        "materials": [
            { "name": "A", "doubleSided": true, "alphaMode": "BLEND",
                "pbrMetallicRoughness": { "baseColorFactor": [1, 0.5, 0.25, 0.75], "baseColorTexture": texture,
                    "metallicFactor": 0.5, "roughnessFactor": 0.25, "metallicRoughnessTexture": { "index": 1 } },
                "normalTexture": { "index": 1, "scale": 0.5 }, "emissiveFactor": [0.1, 0.1, 0.1],
                "extensions": { "KHR_materials_ior": { "ior": 1.4 }, "KHR_materials_transmission":
                    { "transmissionFactor": 0.5 }, "KHR_materials_volume": { "thicknessFactor": 1,
                    "attenuationDistance": 0.5, "attenuationColor": [0.5, 0.9, 0.9] },
                    "KHR_materials_emissive_strength": { "emissiveStrength": 3 } } },
            { "name": "B", "alphaMode": "MASK", "alphaCutoff": 0.4,
                "extensions": { "KHR_materials_clearcoat": { "clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.1 },
                    "KHR_materials_sheen": { "sheenColorFactor": [1, 0, 1], "sheenRoughnessFactor": 0.3 },
                    "KHR_materials_anisotropy": { "anisotropyStrength": 0.6, "anisotropyRotation": 0.4 },
                    "KHR_materials_specular": { "specularFactor": 0.5 } } },
        ],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3,
                "_WEAR": 10 }, "indices": 4, "material": 0, "targets": [{ "POSITION": 8 }] }], "weights": [0.5] },
            { "primitives": [{ "attributes": { "POSITION": 0, "JOINTS_0": 5, "WEIGHTS_0": 6 },
                "mode": 5, "material": 1 }] },
        ],
        "skins": [{ "joints": [3, 4], "inverseBindMatrices": 7 }],
        "cameras": [
            { "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1, "aspectRatio": 1.5 } },
            { "type": "orthographic", "orthographic": { "xmag": 2, "ymag": 2, "znear": 0.1, "zfar": 10 } },
        ],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "point", "intensity": 40, "color": [1, 0.9, 0.8] },
            { "type": "spot", "intensity": 9, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.5 } },
            { "type": "directional", "intensity": 3 } ] } },
        "nodes": [
            { "name": "all", "children": [1, 2, 3, 5, 6, 7], "rotation": [0, 0.1, 0, 0.995] },
            { "mesh": 0, "scale": [1, 2, -1], "extensions": { "EXT_mesh_gpu_instancing":
                { "attributes": { "TRANSLATION": 9 } } } },
            { "mesh": 1, "skin": 0 },
            { "children": [4], "translation": [0, 0.5, 0] },
            { "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0, 1] },
            { "camera": 0, "translation": [0, 0, 5] },
            { "translation": [1, 2, 3], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "translation": [0, 3, 2], "extensions": { "KHR_lights_punctual": { "light": 1 } } },
            { "extensions": { "KHR_lights_punctual": { "light": 2 } } },
            { "camera": 1 },
        ],
        "scenes": [{ "nodes": [0, 8, 9] }],
        "scene": 0,
    })
}

/// A picture of a few colours.
fn png() -> Vec<u8> {
    let mut png = Cursor::new(Vec::new());
    image::RgbaImage::from_fn(3, 2, |x, y| {
        image::Rgba([80 * x as u8, 200 * y as u8, 128, 255])
    })
    .write_to(&mut png, image::ImageFormat::Png)
    .expect("memory takes everything");
    png.into_inner()
}

/// The same scene as a `.glb`, with its first buffer as the binary chunk.
fn glb(tree: &Value) -> Vec<u8> {
    let mut tree = tree.clone();
    let uri = tree["buffers"][0]["uri"].take();
    let encoded = uri
        .as_str()
        .and_then(|uri| uri.split_once(','))
        .expect("a data URI")
        .1;
    let mut binary = BASE64.decode(encoded).expect("encoded here");
    binary.resize(binary.len().next_multiple_of(4), 0);
    if let Some(buffer) = tree["buffers"][0].as_object_mut() {
        buffer.remove("uri");
    }
    let mut json = tree.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let word = |n: usize| (n as u32).to_le_bytes();
    [
        &b"glTF"[..],
        &word(2),
        &word(length),
        &word(json.len()),
        b"JSON",
        &json,
        &word(binary.len()),
        b"BIN\0",
        &binary,
    ]
    .concat()
}
