//! Files made here to take more than they need: memory stays within a few times of what they hold.

use std::fs::File;
use std::io::Cursor;
use std::path::Path;

use engine::load;
use engine::scene::import;
use serde_json::{Value, json};

use super::{bounded, memory};

/// What is held beside the input: stacks, queues, allocators of threads.
const SLACK: usize = 4 << 20;

/// Runs `work` and fails where it holds more than four times `needed` bytes.
fn within<T: Send + 'static>(
    what: &str,
    needed: usize,
    work: impl FnOnce() -> T + Send + 'static,
) -> T {
    let before = memory::held();
    let result = bounded(Path::new(what), work);
    let held = memory::peak().saturating_sub(before);
    eprintln!("  {what}: {:.1} MiB for {:.1}", mib(held), mib(needed));
    assert!(
        held <= 4 * needed + SLACK,
        "{what} takes {:.1} MiB, four times {:.1} are allowed",
        mib(held),
        mib(needed)
    );
    result
}

fn mib(bytes: usize) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

/// One triangle, whose three corners lie in the file `name`.
fn triangle(name: &str) -> Value {
    json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "uri": name, "byteLength": 36 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "nodes": [{ "mesh": 0 }],
    })
}

fn corners() -> Vec<u8> {
    let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    corners.iter().flat_map(|n| n.to_le_bytes()).collect()
}

pub(super) fn made_here() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut buffer = corners();
    buffer.resize(8 << 20, 0);
    std::fs::write(folder.join("corners.bin"), &buffer).unwrap();
    std::fs::hard_link(folder.join("corners.bin"), folder.join("again.bin")).unwrap();
    one_buffer_a_thousand_times(folder);
    one_picture_three_times(folder);
    large_json(folder);
    files_larger_than_they_are(folder);
    includes(folder);
    odd_layouts(folder);
    looks(folder);
}

fn write(folder: &Path, name: &str, tree: &Value) -> std::path::PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, serde_json::to_vec(tree).unwrap()).unwrap();
    path
}

fn one_buffer_a_thousand_times(folder: &Path) {
    let mut tree = triangle("corners.bin");
    let names = ["corners.bin", "./corners.bin", "again.bin"];
    let more = (0..1000).map(|i| json!({ "uri": names[i % 3], "byteLength": (8 << 20) - i }));
    tree["buffers"].as_array_mut().unwrap().extend(more);
    let path = write(folder, "buffers.gltf", &tree);
    let read = path.clone();
    let loaded = within("a buffer a thousand times", 8 << 20, move || {
        import::load(&read)
    });
    assert_eq!(loaded.unwrap().scene.instances.len(), 1);
    let files = within("its files", 1 << 20, move || {
        import::referenced_files(&path)
    });
    assert_eq!(files.len(), 1001);
}

fn one_picture_three_times(folder: &Path) {
    const SIDE: u32 = 2048;
    let mut png = Cursor::new(Vec::new());
    image::RgbaImage::new(SIDE, SIDE)
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let png = png.into_inner();
    std::fs::write(folder.join("black.png"), &png).unwrap();
    std::fs::write(folder.join("pictures.bin"), &png).unwrap();
    let mut tree = triangle("corners.bin");
    let view = json!({ "buffer": 1, "byteLength": png.len() });
    tree["buffers"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "uri": "pictures.bin", "byteLength": png.len() }));
    tree["bufferViews"]
        .as_array_mut()
        .unwrap()
        .extend([view.clone(), view]);
    tree["images"] = json!([
        { "bufferView": 1 }, { "bufferView": 2 }, { "bufferView": 1 },
        { "uri": "black.png" }, { "uri": "./black.png" }, { "uri": "%62lack.png" },
    ]);
    tree["textures"] = (0..6).map(|i| json!({ "source": i })).collect();
    let material =
        |i: usize| json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": i } } });
    tree["materials"] = (0..6).map(material).collect();
    let path = write(folder, "pictures.gltf", &tree);
    // Two pictures: the same one in a buffer and in a file of its own.
    let needed = 2 * (SIDE * SIDE * 4) as usize;
    let read = path.clone();
    let scene = within("a picture six times", needed, move || import::load(&read)).unwrap();
    assert_eq!(scene.scene.images.len(), 2);

    let look = "[[include]]\nfile = 'pictures.gltf'\n".repeat(20);
    let look_path = folder.join("pictures.look.toml");
    std::fs::write(&look_path, look).unwrap();
    let loaded = within("a picture in twenty includes", needed, move || {
        load::load(&path, Some(&look_path), &[])
    });
    assert_eq!(loaded.unwrap().scene.images.len(), 2);
}

fn large_json(folder: &Path) {
    const LENGTH: usize = 16 << 20;
    let tree = serde_json::to_string(&triangle("corners.bin")).unwrap();
    let start = &tree[..tree.len() - 1];
    for value in ["[],", "0,", "{},", "\"a\","] {
        let list = value.repeat(LENGTH / value.len());
        let list = &list[..list.len() - 1];
        for key in ["x", "extras", "animations"] {
            let path = folder.join("large.gltf");
            std::fs::write(&path, format!("{start},\"{key}\":[{list}]}}")).unwrap();
            let what = format!("16 MiB of {value} in {key}");
            let scene = within(&what, LENGTH, move || import::load(&path)).unwrap();
            assert_eq!(scene.scene.instances.len(), 1);
        }
        // These would be kept; they are refused, or small.
        let path = folder.join("large.gltf");
        let text = tree.replacen("\"nodes\":[", &format!("\"nodes\":[{list},"), 1);
        std::fs::write(&path, text).unwrap();
        let what = format!("16 MiB of {value} as nodes");
        let refused = within(&what, LENGTH, move || import::load(&path)).unwrap_err();
        eprintln!("    {refused}");
    }
    for (open, close) in [("[", "]"), ("{\"a\":", "}")] {
        let path = folder.join("deep.gltf");
        let deep = format!("{}0{}", open.repeat(100_000), close.repeat(100_000));
        let text = tree.replacen("\"nodes\":[", &format!("\"nodes\":[{deep},"), 1);
        std::fs::write(&path, text).unwrap();
        within("deep nesting", 1 << 20, move || import::load(&path)).unwrap_err();
    }
}

/// Files that take no place on the disk but say that they are long.
fn files_larger_than_they_are(folder: &Path) {
    let path = folder.join("sparse.glb");
    let file = File::create(&path).unwrap();
    file.set_len(64 << 30).unwrap();
    let refused = within("64 GiB of nothing", 0, move || import::load(&path)).unwrap_err();
    assert!(refused.to_string().contains("64.0 GiB"), "{refused}");
    let tree = serde_json::to_vec(&json!({ "asset": { "version": "2.0" } })).unwrap();
    let path = folder.join("tail.glb");
    let mut glb = [&b"glTF"[..], &2u32.to_le_bytes()].concat();
    glb.extend((20 + tree.len() as u32).to_le_bytes());
    glb.extend((tree.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(&tree);
    std::fs::write(&path, &glb).unwrap();
    let file = File::options().write(true).open(&path).unwrap();
    file.set_len(64 << 30).unwrap();
    within("a tail of 64 GiB", 0, move || import::load(&path)).unwrap();
    let picture = folder.join("sparse.hdr");
    File::create(&picture).unwrap().set_len(64 << 30).unwrap();
    let refused = within("a picture of 64 GiB", 0, move || {
        import::load_environment_image(&picture)
    });
    let refused = refused.map(drop).unwrap_err().to_string();
    assert!(refused.contains("4.0 GiB"), "{refused}");
}

fn includes(folder: &Path) {
    const COUNT: usize = 100_000;
    let places = vec![1u8; COUNT * 12];
    std::fs::write(folder.join("places.bin"), places).unwrap();
    let mut tree = triangle("corners.bin");
    tree["buffers"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "uri": "places.bin", "byteLength": COUNT * 12 }));
    tree["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "buffer": 1, "byteLength": COUNT * 12 }));
    tree["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "bufferView": 1, "componentType": 5126, "count": COUNT, "type": "VEC3" }));
    tree["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 1 } } });
    tree["nodes"][0]["name"] = "n".into();
    let path = write(folder, "many.gltf", &tree);
    let look_path = folder.join("many.look.toml");
    let look = "[[include]]\nfile = 'many.gltf'\nonly = ['n']\n".repeat(10_000);
    std::fs::write(&look_path, &look).unwrap();
    let started = std::time::Instant::now();
    let before = memory::held();
    let (scene, own_look) = (path.clone(), look_path.clone());
    // As many as there may be: four million, about a hundred bytes each.
    let refused = std::thread::spawn(move || load::load(&scene, Some(&own_look), &[]))
        .join()
        .expect("no panic");
    let held = memory::peak().saturating_sub(before);
    let text = refused.map(drop).unwrap_err().to_string();
    eprintln!(
        "  10,000 includes: {:.0} MiB, {:?}",
        mib(held),
        started.elapsed()
    );
    assert!(
        text.contains("more than 4194304 instances"),
        "{}",
        &text[..500]
    );
    assert!(held < 1 << 30, "{} MiB", held >> 20);
    // A table takes about three kilobytes as a tree with places.
    let needed = look.len() * 20;
    let files = within("files of a look", needed, move || {
        let look = engine::scene::look::Look::load(&look_path).unwrap();
        load::files(&path, Some(&look))
    });
    assert_eq!(files.len(), 3, "{files:?}");
}

fn odd_layouts(folder: &Path) {
    let cases: [(&str, Value); 7] = [
        ("/accessors/0/count", json!(u64::MAX)),
        ("/accessors/0/count", json!(u32::MAX)),
        ("/accessors/0/byteOffset", json!(u64::MAX)),
        ("/bufferViews/0/byteLength", json!(u64::MAX)),
        ("/bufferViews/0/byteOffset", json!(u64::MAX - 35)),
        (
            "/accessors/0/sparse",
            json!({
                "count": u32::MAX, "indices": { "bufferView": 0, "componentType": 5125 },
                "values": { "bufferView": 0 },
            }),
        ),
        ("/buffers/0/byteLength", json!(u64::MAX)),
    ];
    for (place, value) in cases {
        let mut tree = triangle("corners.bin");
        let (parent, key) = place.rsplit_once('/').unwrap();
        tree.pointer_mut(parent).unwrap()[key] = value.clone();
        let path = write(folder, "odd.gltf", &tree);
        let refused = within(&format!("{place} {value}"), 8 << 20, move || {
            import::load(&path)
        });
        let text = refused.map(drop).unwrap_err().to_string();
        assert!(text.contains("odd.gltf"), "{text}");
    }
}

fn looks(folder: &Path) {
    let scene = write(folder, "plain.gltf", &triangle("corners.bin"));
    let cases = [
        format!("a = {}{}", "[".repeat(100_000), "]".repeat(100_000)),
        format!("a{} = 1", ".a".repeat(100_000)),
        format!("[{}]", vec!["a"; 50_000].join(".")),
        "[[include]]\nfile = 'loop.look.toml'\n".to_owned(),
        "[[include]]\nfile = '/dev/zero'\n".to_owned(),
        "[[include]]\nfile = '.'\n".to_owned(),
        "environment = { image = '/dev/zero' }\n".to_owned(),
        "environment = { image = 'loop.look.toml' }\n".to_owned(),
    ];
    for text in cases {
        let path = folder.join("loop.look.toml");
        std::fs::write(&path, &text).unwrap();
        let scene = scene.clone();
        let what = &text[..text.len().min(40)];
        // A dotted key of 200 kB is a tree of 100,000 tables, which takes 40 MB.
        let needed = (text.len() * 100).max(8 << 20);
        let refused = within(what, needed, move || load::load(&scene, Some(&path), &[]));
        let message = refused.map(drop).unwrap_err().to_string();
        assert!(message.contains("loop.look.toml"), "{message}");
    }
}
