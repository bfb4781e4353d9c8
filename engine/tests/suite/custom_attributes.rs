//! Custom attributes of glTF meshes, from the file to what a texture reads at a hit; and files in which they are wrong.
//! What renders is skipped with a notice where there is no adapter.

use std::fs;
use std::path::PathBuf;

use engine::load::{LoadError, Loaded, load};
use glam::{Vec2, Vec3};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::support::device;
use crate::support::estimate::Estimate;
use crate::support::scenes::{Shot, floor_point, from_above, render_textured};
use crate::support::stats::ZTest;

const SHOW: &str = "
fn userProc(tint: bool) -> vec3f {
    let v = select(readAttr(_WETNESS), readAttr(_TINT), tint);
    return 0.25 * v.xyw;
}";

/// A glTF file in the making.
struct File {
    bytes: Vec<u8>,
    tree: Value,
}

impl File {
    fn new() -> Self {
        let material = |name: &str| json!({ "name": name });
        Self {
            bytes: Vec::new(),
            tree: json!({
                "asset": { "version": "2.0" },
                "bufferViews": [], "accessors": [], "meshes": [], "nodes": [],
                "materials": [material("Shown"), material("Other")],
                "scenes": [{ "nodes": [] }],
                "scene": 0,
            }),
        }
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.tree[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// An accessor of elements that begin every `stride` bytes.
    fn accessor(&mut self, bytes: &[u8], stride: usize, kind: &str, component: u32) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
        });
        if stride.is_multiple_of(4) {
            view["byteStride"] = json!(stride);
        }
        let view = self.push("bufferViews", view);
        self.bytes.extend(bytes);
        let count = bytes.len() / stride;
        let accessor = json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind,
            "normalized": matches!(component, 5121 | 5120),
        });
        self.push("accessors", accessor)
    }

    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let bytes: Vec<u8> = (values.iter().flatten())
            .flat_map(|v| v.to_le_bytes())
            .collect();
        self.accessor(&bytes, 4 * N, kind, 5126)
    }

    fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, 2, "SCALAR", 5123)
    }

    /// A mesh of these primitives, shown once.
    fn mesh(&mut self, primitives: Value) {
        let mesh = self.push("meshes", json!({ "primitives": primitives }));
        let node = self.push("nodes", json!({ "mesh": mesh }));
        let roots = self.tree["scenes"][0]["nodes"].as_array_mut();
        roots.expect("a list").push(json!(node));
    }

    /// Loads it with a look in which a texture shows the attributes on the material `Shown`.
    fn load(mut self, tint: bool) -> (TempDir, Result<Loaded, LoadError>) {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| -> PathBuf { dir.path().join(name) };
        self.tree["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": "mesh.bin" }]);
        let look = format!(
            "[node.show]\ntexture='show'\ntint={tint}\n[material.Shown]\nbase_color='show'\nunlit=true\n"
        );
        fs::write(path("mesh.bin"), &self.bytes).expect("written");
        fs::write(path("mesh.gltf"), self.tree.to_string()).expect("written");
        fs::write(path("look.toml"), look).expect("written");
        fs::write(path("show.wgsl"), SHOW).expect("written");
        let textures = [dir.path().to_owned()];
        let loaded = load(&path("mesh.gltf"), Some(&path("look.toml")), &textures);
        (dir, loaded)
    }
}

/// Corners of the square of side 2 whose least corner is (x, z), front up.
fn square(x: f32, z: f32) -> [[f32; 3]; 4] {
    let [right, bottom] = [x + 2.0, z + 2.0];
    [
        [x, 0.0, bottom],
        [right, 0.0, bottom],
        [right, 0.0, z],
        [x, 0.0, z],
    ]
}

const SQUARE: [u16; 6] = [0, 1, 2, 0, 2, 3];

/// A function that triangles interpolate exactly.
fn wetness(x: f32, z: f32) -> f32 {
    2.5 + 0.8 * x + 0.4 * z
}

/// Four squares around the origin: one has a number of `_WETNESS`, one normalized bytes of `_TINT`, one is made of two
/// primitives with one of the attributes each, and one has nothing.
fn four_squares() -> File {
    let mut file = File::new();
    let quad = file.indices(&SQUARE);
    let upper = file.indices(&SQUARE[..3]);
    let lower = file.indices(&SQUARE[3..]);

    // No normals: vertices are split for flat shading, and what they carry goes along.
    let corners = square(-2.0, -2.0);
    let position = file.floats(&corners);
    let wet = file.floats(&corners.map(|[x, _, z]| [wetness(x, z)]));
    file.mesh(json!([{ "attributes": { "POSITION": position, "_WETNESS": wet }, "indices": quad, "material": 0 }]));

    let position = file.floats(&square(0.0, -2.0));
    let up = file.floats(&[[0.0, 1.0, 0.0]; 4]);
    let uv = file.floats(&[[0.5, 0.5]; 4]);
    let color = file.floats(&[[1.0f32; 4]; 4]);
    // Elements of three bytes, four bytes apart.
    let tint = [
        [51, 0, 255, 9],
        [153, 0, 255, 9],
        [204, 0, 255, 9],
        [102, 0, 255, 9],
    ];
    let tint = file.accessor(tint.as_flattened(), 4, "VEC3", 5121);
    let attributes = json!({
        "POSITION": position, "NORMAL": up, "TEXCOORD_0": uv, "COLOR_0": color, "_TINT": tint, "_UNREAD": uv,
    });
    file.mesh(json!([{ "attributes": attributes, "indices": quad, "material": 0 }]));

    let position = file.floats(&square(-2.0, 0.0));
    let wet: Vec<u8> = [3i16, 3, 3, 3]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let wet = file.accessor(&wet, 2, "SCALAR", 5122);
    let tint = file.floats(&[[1.0, 2.0, 0.0, 3.5]; 4]);
    file.mesh(json!([
        { "attributes": { "POSITION": position, "_WETNESS": wet }, "indices": upper, "material": 0 },
        { "attributes": { "POSITION": position, "_TINT": tint }, "indices": lower, "material": 0 },
    ]));

    let position = file.floats(&square(0.0, 0.0));
    file.mesh(json!([{ "attributes": { "POSITION": position }, "indices": quad, "material": 0 }]));

    // Out of sight, and nobody reads an attribute here.
    let position = file.floats(&square(50.0, 50.0));
    file.mesh(json!([{ "attributes": { "POSITION": position }, "indices": quad, "material": 1 }]));
    file
}

/// What the texture shows of x, y and w.
fn expected(tint: bool, p: Vec3) -> Vec3 {
    let v = match (p.x < 0.0, p.z < 0.0, tint) {
        (true, true, false) => Vec3::new(wetness(p.x, p.z), 0.0, 1.0),
        (false, true, true) => {
            let bytes = 51.0 + 51.0 * p.x - 25.5 * p.z;
            Vec3::new(bytes / 255.0, 0.0, 1.0)
        }
        // The diagonal of the square goes from the lower left to the upper right.
        (true, false, false) if p.x + 2.0 > 2.0 - p.z => Vec3::new(3.0, 0.0, 1.0),
        (true, false, true) if p.x + 2.0 < 2.0 - p.z => Vec3::new(1.0, 2.0, 3.5),
        _ => Vec3::ZERO,
    };
    0.25 * v
}

#[test]
fn textures_read_the_attributes_of_each_mesh() {
    let Some(device) = device::open() else { return };
    for tint in [false, true] {
        let (_dir, loaded) = four_squares().load(tint);
        let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
        let shot = Shot {
            size: (32, 32),
            max_depth: 1,
            spp: 64,
        };
        let camera = from_above(1.0, 2.0);
        let film = render_textured(&device, &loaded.scene, &loaded.procedural, &camera, shot);
        let exact = Estimate::exact(shot.size, |at: Vec2| expected(tint, floor_point(2.0, at)));
        let test = ZTest {
            rounding: 1.0e-4, // of the interpolation
            ..ZTest::default()
        };
        // In a pixel of two triangles the points of the exact picture lie on the border between them.
        let is_inside = |x: usize, y: usize| x >= 16 || y < 16 || x + y != 31;
        let compared = test.compare(Estimate::from_film(&film), exact, is_inside);
        let share = compared.passing_share();
        // Chance alone lets 99.86 % pass.
        assert!(
            share > 0.995,
            "tint: {tint}: only {share} of the pixels are right"
        );
    }
}

#[test]
fn a_mesh_without_the_attribute_is_told_of_once() {
    let (_dir, loaded) = four_squares().load(false);
    let warnings = loaded.unwrap_or_else(|error| panic!("{error}")).warnings;
    let of = |name: &str| -> Vec<String> {
        let texts = warnings.iter().map(ToString::to_string);
        texts.filter(|text| text.contains(name)).collect()
    };
    for name in ["_WETNESS", "_TINT"] {
        let [warning] = &of(name)[..] else {
            panic!("one warning of {name}: {warnings:?}")
        };
        assert!(
            warning.contains(&format!(
                "2 of the 4 meshes on which `show` reads the attribute {name} don't have it"
            )),
            "{warning}"
        );
    }
    assert!(of("_UNREAD").is_empty());
}

/// One square with an attribute `_WETNESS` of this accessor, changed.
fn with_wetness(accessor: impl FnOnce(&mut File) -> usize) -> File {
    let mut file = File::new();
    let quad = file.indices(&SQUARE);
    let position = file.floats(&square(0.0, 0.0));
    let wet = accessor(&mut file);
    file.mesh(json!([{ "attributes": { "POSITION": position, "_WETNESS": wet }, "indices": quad, "material": 0 }]));
    file
}

#[test]
fn wrong_accessors_are_errors_that_name_file_and_accessor() {
    let changed = |key: &'static str, value: Value| {
        move |file: &mut File| {
            let accessor = file.floats(&[[1.0f32; 4]; 4]);
            file.tree["accessors"][accessor][key] = value;
            accessor
        }
    };
    let cases = [
        (
            with_wetness(changed("count", json!(3))),
            "has 3 elements for 4 vertices",
        ),
        (
            with_wetness(changed("count", json!(5))),
            "reaches beyond buffer view",
        ),
        (
            with_wetness(changed("count", json!(u64::MAX))),
            "too many elements",
        ),
        (
            with_wetness(changed("type", json!("MAT2"))),
            "holds matrices",
        ),
        (
            with_wetness(changed("type", json!("MAT4"))),
            "has elements of 64 bytes",
        ),
        (with_wetness(changed("type", json!("VEC5"))), "unknown type"),
        (
            with_wetness(changed("componentType", json!(5130))),
            "unknown componentType",
        ),
        (
            with_wetness(changed("bufferView", json!(99))),
            "buffer view 99",
        ),
        (
            with_wetness(changed("byteOffset", json!(8))),
            "reaches beyond buffer view",
        ),
    ];
    for (file, problem) in cases {
        let (_dir, loaded) = file.load(false);
        let error = loaded.map(drop).expect_err(problem).to_string();
        for part in ["mesh.gltf", "accessor 2", problem] {
            assert!(error.contains(part), "`{part}` is not in: {error}");
        }
    }
    let (_dir, loaded) = with_wetness(|_| 99).load(false);
    let error = loaded.map(drop).expect_err("no such accessor").to_string();
    assert!(
        error.contains("_WETNESS: accessor 99 does not exist"),
        "{error}"
    );
}

#[test]
fn what_is_no_number_becomes_zero() {
    let file = with_wetness(|file| file.floats(&[[f32::NAN], [1.0], [f32::INFINITY], [2.0]]));
    let (_dir, loaded) = file.load(false);
    let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
    let mesh = &loaded.scene.meshes[0];
    let wet = mesh.custom("_WETNESS").expect("it is there");
    let mut values: Vec<[f32; 4]> = wet.values.iter().map(|v| v.to_array()).collect();
    values.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    let [one, two] = [1.0, 2.0].map(|x| [x, 0.0, 0.0, 1.0]);
    assert_eq!(values, [[0.0; 4], [0.0; 4], one, two]);
    assert!(!loaded.warnings.is_empty(), "the user is told");
}
