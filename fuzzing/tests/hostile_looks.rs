//! Looks made here to take more than they need: memory stays within a few times of what they hold.

#[path = "../../scene/tests/malformed/bounded.rs"]
mod bounded;

use std::io::Cursor;
use std::path::Path;

use bounded::{corners, mib, triangle, within, write};
use engine::load;
use fuzzing::memory;
use serde_json::json;

#[global_allocator]
static ALLOCATOR: memory::Counting = memory::Counting;

/// One test: what is held is that of the whole program.
#[test]
fn hostile_looks_take_little_memory() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("corners.bin"), corners()).unwrap();
    one_picture_in_twenty_includes(folder);
    includes(folder);
    looks(folder);
}

fn one_picture_in_twenty_includes(folder: &Path) {
    const SIDE: u32 = 2048;
    let mut png = Cursor::new(Vec::new());
    image::RgbaImage::new(SIDE, SIDE)
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    std::fs::write(folder.join("black.png"), png.into_inner()).unwrap();
    let mut tree = triangle("corners.bin");
    tree["images"] = json!([{ "uri": "black.png" }, { "uri": "./black.png" }]);
    tree["textures"] = json!([{ "source": 0 }, { "source": 1 }]);
    let material =
        |i: usize| json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": i } } });
    tree["materials"] = (0..2).map(material).collect();
    let path = write(folder, "pictures.gltf", &tree);
    let look = "[[include]]\nfile = 'pictures.gltf'\n".repeat(20);
    let needed = (SIDE * SIDE * 4) as usize;
    let look_path = folder.join("pictures.look.toml");
    std::fs::write(&look_path, look).unwrap();
    let loaded = within("a picture in twenty includes", needed, move || {
        load::load(&path, Some(&look_path), &[])
    });
    assert_eq!(loaded.unwrap().scene.images.len(), 1);
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
