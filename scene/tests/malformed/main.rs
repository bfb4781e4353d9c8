//! Damaged and hostile files: none may panic, hang or exhaust memory, and what is out of range or cut is refused.
//!
//! The cases and the verdicts (`*.report.json`) are those of the Khronos glTF validator. Each case is loaded as it
//! is, and once more with everything in it made visible, because most cases show nothing by themselves.
//! Skipped with a notice where the data is absent. Changes of valid files are tried by the crate `fuzzing`.

mod bounded;
mod hostile;
#[path = "../../../fuzzing/src/memory.rs"]
#[expect(dead_code, unreachable_pub, reason = "it is a part of another crate")]
mod memory;

use bounded::bounded;
use scene::import::{ImportError, Imported, Importer, load, load_environment_image};
use scene::{Moment, Motion};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Findings of the validator after which a file must not be accepted.
const FATAL: &[&str] = &[
    "ACCESSOR_INDEX_OOB",
    "ACCESSOR_JOINTS_INDEX_OOB",
    "ACCESSOR_SMALL_BYTESTRIDE",
    "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
    "ACCESSOR_TOO_LONG",
    "ARRAY_TYPE_MISMATCH",
    "BUFFER_VIEW_TOO_LONG",
    "GLB_CHUNK_TOO_BIG",
    "GLB_INVALID_MAGIC",
    "GLB_INVALID_VERSION",
    "GLB_LENGTH_TOO_SMALL",
    "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
    "GLB_UNEXPECTED_END_OF_CHUNK_HEADER",
    "GLB_UNEXPECTED_END_OF_HEADER",
    "GLB_UNEXPECTED_FIRST_CHUNK",
    "INVALID_JSON",
    "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT",
    "NODE_LOOP",
    "NODE_PARENT_OVERRIDE",
    "UNKNOWN_ASSET_MAJOR_VERSION",
];

/// Valid enough: a byte order mark before the JSON, which the specification lets readers ignore.
const TOLERATED: &[&str] = &["base/glb/bom.glb", "base/json/bom.gltf"];

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;

fn cases() -> Option<PathBuf> {
    let path = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../shared/scenes/malformed"
    ));
    if !path.exists() {
        eprintln!("skipped: no {}", path.display());
        return None;
    }
    Some(path.canonicalize().unwrap())
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Codes of the errors that the validator reports for a case; `None` for files that are not cases.
fn verdict(case: &Path) -> Option<Vec<String>> {
    let report = PathBuf::from(format!("{}.report.json", case.display()));
    let report: Value = serde_json::from_slice(&std::fs::read(report).ok()?).unwrap();
    let messages = report["issues"]["messages"].as_array()?;
    let errors = messages.iter().filter(|message| message["severity"] == 0);
    Some(
        errors
            .map(|error| error["code"].as_str().unwrap().to_owned())
            .collect(),
    )
}

/// The JSON of a `.gltf` case with a node for each mesh, skin, camera and light; `None` where it is not JSON.
fn all_visible(case: &Path) -> Option<Value> {
    let text = std::fs::read(case).ok()?;
    let mut tree: Value = serde_json::from_slice(&text).ok()?;
    let folder = case.parent()?;
    for list in ["buffers", "images"] {
        for entry in tree
            .get_mut(list)
            .and_then(Value::as_array_mut)
            .into_iter()
            .flatten()
        {
            if let Some(uri) = entry.get("uri").and_then(Value::as_str)
                && !uri.contains(':')
            {
                entry["uri"] = folder.join(uri).to_str()?.into();
            }
        }
    }
    let count =
        |tree: &Value, list: &str| tree.get(list).and_then(Value::as_array).map_or(0, Vec::len);
    let (meshes, skins, cameras, images, accessors, textures) = (
        count(&tree, "meshes"),
        count(&tree, "skins"),
        count(&tree, "cameras"),
        count(&tree, "images"),
        count(&tree, "accessors"),
        count(&tree, "textures"),
    );
    let object = tree.as_object_mut()?;
    let mut push = |list: &str, value: Value| {
        if let Some(list) = object
            .entry(list)
            .or_insert_with(|| json!([]))
            .as_array_mut()
        {
            list.push(value);
        }
    };
    for image in 0..images {
        push("textures", json!({ "source": image }));
        let info = json!({ "index": textures + image });
        push(
            "materials",
            json!({ "pbrMetallicRoughness": { "baseColorTexture": info } }),
        );
    }
    for accessor in 0..accessors {
        for attributes in [json!({ "POSITION": accessor }), json!({ "POSITION": 0 })] {
            push(
                "meshes",
                json!({ "primitives": [{ "attributes": attributes, "indices": accessor }] }),
            );
            push(
                "meshes",
                json!({ "primitives": [{ "attributes": attributes, "mode": 5 }] }),
            );
        }
    }
    for mesh in 0..meshes + accessors * 4 {
        push("nodes", json!({ "mesh": mesh }));
        for skin in 0..skins {
            push("nodes", json!({ "mesh": mesh, "skin": skin }));
        }
    }
    for camera in 0..cameras {
        push("nodes", json!({ "camera": camera }));
    }
    for light in 0..4 {
        push(
            "nodes",
            json!({ "extensions": { "KHR_lights_punctual": { "light": light } } }),
        );
    }
    // Without scenes everything is shown.
    object.remove("scenes");
    object.remove("scene");
    Some(tree)
}

fn check(imported: &Imported) {
    let scene = &imported.scene;
    for mesh in &scene.meshes {
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(
            mesh.triangles
                .iter()
                .flatten()
                .all(|&v| (v as usize) < mesh.positions.len())
        );
        assert!(
            mesh.triangle_materials
                .iter()
                .all(|&m| (m as usize) < scene.materials.len())
        );
    }
    assert!(
        scene
            .instances
            .iter()
            .all(|i| (i.mesh as usize) < scene.meshes.len())
    );
}

/// One test, because the allocations are counted for the whole process.
#[test]
fn malformed_files_are_survived_and_fatal_ones_refused() {
    hostile::made_here();
    let Some(folder) = cases() else {
        return;
    };
    gltf_cases(&folder.join("gltf-validator"));
    damaged_pictures(&folder.join("exr-damaged"));
}

fn gltf_cases(folder: &Path) {
    let scratch = std::env::temp_dir().join(format!("patina-malformed-{}", std::process::id()));
    std::fs::create_dir_all(&scratch).unwrap();
    let mut accepted: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut refused = Vec::new();
    let mut wrong = Vec::new();
    let (mut cases, mut invalid, mut agreed) = (0, 0, 0);
    for case in files(folder) {
        let Some(errors) = verdict(&case) else {
            continue;
        };
        cases += 1;
        let name = case.strip_prefix(folder).unwrap().display().to_string();
        let path = case.clone();
        let result = bounded(&case, move || load(&path));
        invalid += usize::from(!errors.is_empty());
        agreed += usize::from(result.is_err() != errors.is_empty());
        match &result {
            Ok(imported) => {
                check(imported);
                for error in &errors {
                    accepted
                        .entry(error.clone())
                        .or_default()
                        .push(name.clone());
                }
            }
            Err(error) => {
                let text = error.to_string();
                assert!(
                    text.contains(';') || text.contains("limit"),
                    "names no remedy: {text}"
                );
                if errors.is_empty() {
                    refused.push(text);
                }
            }
        }

        let path = case.clone();
        match bounded(&case, move || moved(&path)) {
            Ok(imported) => check(&imported),
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains(';'), "names no remedy: {text}");
                assert!(
                    !errors.is_empty() || result.is_err(),
                    "moved, it is refused although valid: {text}"
                );
            }
        }

        let shown = all_visible(&case).map(|tree| {
            let path = scratch.join("case.gltf");
            std::fs::write(&path, serde_json::to_vec(&tree).unwrap()).unwrap();
            bounded(&case, move || load(&path))
        });
        if let Some(Ok(imported)) = &shown {
            check(imported);
        }
        let fatal = errors.iter().any(|error| FATAL.contains(&error.as_str()));
        let is_accepted = result.is_ok() && shown.is_none_or(|shown| shown.is_ok());
        if fatal && is_accepted && !TOLERATED.contains(&name.as_str()) {
            wrong.push(format!("{name}: {errors:?}"));
        }
    }
    std::fs::remove_dir_all(&scratch).unwrap();
    eprintln!(
        "{cases} cases, {invalid} of them invalid; same verdict as the validator in {agreed}"
    );
    for (code, names) in accepted {
        eprintln!("  accepted in spite of {code}: {}", names.join(", "));
    }
    for text in &refused {
        eprintln!("  refused although valid: {text}");
    }
    assert!(wrong.is_empty(), "accepted: {wrong:#?}");
    assert_eq!(cases, 372);
}

/// The file half a second after its beginning.
fn moved(path: &Path) -> Result<Imported, ImportError> {
    let mut importer = Importer::new();
    importer.begin(Moment {
        seconds: 0.5,
        motion: Motion::Usual,
    });
    importer.load(path)
}

fn damaged_pictures(folder: &Path) {
    for path in files(folder) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name == "LICENSE" || name == "README.rst" {
            continue;
        }
        let copy = path.clone();
        match bounded(&path, move || {
            load_environment_image(&scene::input::Disk, &copy)
        }) {
            Ok((image, warnings)) => {
                eprintln!("  {name}: {} x {} {warnings:?}", image.width, image.height);
                assert!(
                    image
                        .rgb
                        .iter()
                        .flatten()
                        .all(|v| v.is_finite() && *v >= 0.0)
                );
            }
            Err(error) => eprintln!("  {error}"),
        }
    }
}
