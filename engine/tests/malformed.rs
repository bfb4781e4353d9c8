//! Damaged and hostile files: none may panic, hang or exhaust memory, and what is out of range or cut is refused.
//!
//! The cases and the verdicts (`*.report.json`) are those of the Khronos glTF validator. Each case is loaded as it
//! is, and once more with everything in it made visible, because most cases show nothing by themselves.
//! Skipped with a notice where the data is absent.

use engine::scene::import::{Imported, load, load_environment_image};
use serde_json::{Value, json};
use std::alloc::{GlobalAlloc, Layout, System};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;

/// No case may take longer; all of them together take a second or two.
const TIME_LIMIT: Duration = Duration::from_secs(20);
/// No case may hold more. The largest file of them has 120 kB.
const MEMORY_LIMIT: usize = 256 << 20;

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

/// Counts what the process holds, to see what a file makes it allocate.
struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn count(size: usize) {
    let held = HELD.fetch_add(size, Ordering::Relaxed) + size;
    PEAK.fetch_max(held, Ordering::Relaxed);
}

// SAFETY: every call is handed to the system's allocator unchanged; counting touches no memory of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        // SAFETY: the caller's promises are those of `System`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size);
        HELD.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Runs `work` on a thread of its own and fails where it panics, hangs or holds too much.
fn bounded<T: Send + 'static>(what: &Path, work: impl FnOnce() -> T + Send + 'static) -> T {
    let before = HELD.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    let (sender, receiver) = mpsc::channel();
    let thread = std::thread::spawn(move || {
        // The receiver is gone only after a time-out, which has failed the test already.
        let _ = sender.send(work());
    });
    let result = match receiver.recv_timeout(TIME_LIMIT) {
        Ok(result) => result,
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("{} hangs", what.display()),
        Err(mpsc::RecvTimeoutError::Disconnected) => panic!("{} panics", what.display()),
    };
    thread.join().expect("the thread has sent its result");
    let held = PEAK.load(Ordering::Relaxed).saturating_sub(before);
    assert!(
        held < MEMORY_LIMIT,
        "{} takes {} MiB",
        what.display(),
        held >> 20
    );
    result
}

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
    let Some(folder) = cases() else {
        return;
    };
    gltf_cases(&folder.join("gltf-validator"));
    damaged_pictures(&folder.join("exr-damaged"));
    mutations(folder.parent().unwrap());
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

fn damaged_pictures(folder: &Path) {
    for path in files(folder) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name == "LICENSE" || name == "README.rst" {
            continue;
        }
        let copy = path.clone();
        match bounded(&path, move || load_environment_image(&copy)) {
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

/// Numbers that break arithmetic.
const HOSTILE: &[&str] = &[
    "0",
    "1",
    "2",
    "3",
    "7",
    "255",
    "65535",
    "5121",
    "5126",
    "2147483647",
    "4294967295",
    "4294967296",
    "9007199254740993",
    "18446744073709551615",
    "-1",
    "0.5",
    "1e38",
    "-1e300",
    "null",
    "[]",
    "{}",
    "\"MAT4\"",
];

/// Small real files with numbers of the JSON replaced and bytes of the data changed, the same ones in every run.
fn mutations(scenes: &Path) {
    let mut random = Random(1);
    let scratch = std::env::temp_dir().join(format!("patina-mutated-{}", std::process::id()));
    std::fs::create_dir_all(&scratch).unwrap();
    let (mut loaded, mut refused) = (0, 0);
    for name in [
        "khronos/BoxTextured/BoxTextured.glb",
        "khronos/AnimatedMorphCube/AnimatedMorphCube.glb",
        "khronos/SimpleInstancing/SimpleInstancing.glb",
        "khronos/RiggedSimple/RiggedSimple.glb",
        "khronos/UnlitTest/UnlitTest.glb",
        "khronos/OrientationTest/OrientationTest.glb",
        "khronos/EmissiveStrengthTest/EmissiveStrengthTest.glb",
        "khronos/MorphPrimitivesTest/MorphPrimitivesTest.glb",
    ] {
        let original = std::fs::read(scenes.join(name)).unwrap();
        for round in 0..150 {
            let file = if round % 3 == 0 {
                flip_bytes(&original, &mut random)
            } else {
                replace_numbers(&original, &mut random)
            };
            let path = scratch.join("mutated.glb");
            std::fs::write(&path, file).unwrap();
            match bounded(Path::new(&format!("{name}, round {round}")), move || {
                load(&path)
            }) {
                Ok(imported) => {
                    check(&imported);
                    loaded += 1;
                }
                Err(_) => refused += 1,
            }
        }
    }
    for name in ["interior-living-room/sky.exr", "hdri/vestibule_1k.hdr"] {
        let original = std::fs::read(scenes.join(name)).unwrap();
        for round in 0..12 {
            let mut file = flip_bytes(&original, &mut random);
            if round % 2 == 0 {
                file.truncate(random.below(original.len()));
            }
            let path = scratch.join("mutated");
            std::fs::write(&path, file).unwrap();
            let result = bounded(Path::new(&format!("{name}, round {round}")), move || {
                load_environment_image(&path)
            });
            *(if result.is_ok() {
                &mut loaded
            } else {
                &mut refused
            }) += 1;
        }
    }
    std::fs::remove_dir_all(&scratch).unwrap();
    eprintln!("{loaded} changed files loaded, {refused} were refused");
    assert!(loaded > 100 && refused > 100, "the changes test nothing");
}

/// PCG without the permutation's finesse; good enough to choose bytes.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % limit.max(1)
    }
}

fn flip_bytes(original: &[u8], random: &mut Random) -> Vec<u8> {
    let mut file = original.to_vec();
    for _ in 0..1 + random.below(8) {
        let at = random.below(file.len());
        file[at] = random.below(256) as u8;
    }
    file
}

/// Replaces one to three numbers of the JSON chunk and writes the container anew.
fn replace_numbers(original: &[u8], random: &mut Random) -> Vec<u8> {
    let length = u32::from_le_bytes(original[12..16].try_into().unwrap()) as usize;
    let mut json = String::from_utf8(original[20..20 + length].to_vec()).unwrap();
    for _ in 0..1 + random.below(3) {
        let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e' | 'E');
        let starts: Vec<usize> = json
            .match_indices(|c: char| c.is_ascii_digit())
            .map(|(at, _)| at)
            .filter(|&at| at > 0 && matches!(json.as_bytes()[at - 1], b':' | b',' | b'['))
            .collect();
        let Some(&start) = starts.get(random.below(starts.len())) else {
            continue;
        };
        let end = json[start..]
            .find(|c| !is_number(c))
            .map_or(json.len(), |n| start + n);
        json.replace_range(start..end, HOSTILE[random.below(HOSTILE.len())]);
    }
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let rest = &original[20 + length..];
    let mut file = original[..8].to_vec();
    file.extend((20 + json.len() as u32 + rest.len() as u32).to_le_bytes());
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(&original[16..20]);
    file.extend(json.as_bytes());
    file.extend(rest);
    file
}
