//! Files made here to take more than they need: memory stays within a few times of what they hold.

use std::fs::File;
use std::io::Cursor;
use std::path::Path;

use scene::import;
use serde_json::{Value, json};

use super::bounded::{corners, triangle, within, write};

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
    odd_layouts(folder);
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
        import::referenced_files(&scene::input::Disk, &path)
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
    let scene = within("a picture six times", needed, move || import::load(&path)).unwrap();
    assert_eq!(scene.scene.images.len(), 2);
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
        import::load_environment_image(&scene::input::Disk, &picture)
    });
    let refused = refused.map(drop).unwrap_err().to_string();
    assert!(refused.contains("4.0 GiB"), "{refused}");
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
