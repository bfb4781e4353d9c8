//! `patina bake` and `patina export` on the command line.

use exr::prelude::{ReadChannels as _, ReadLayers as _};

use super::*;

/// A square with texture coordinates.
const SQUARE: &str = r#"{
  "asset": { "version": "2.0" },
  "scenes": [{ "nodes": [0] }],
  "nodes": [{ "mesh": 0, "name": "Wall" }],
  "meshes": [{ "name": "square", "primitives": [{
    "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2, "material": 0
  }] }],
  "materials": [{ "name": "Paint", "pbrMetallicRoughness": { "metallicFactor": 0 } }],
  "accessors": [
    { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
    { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2" },
    { "bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR" }
  ],
  "bufferViews": [
    { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
    { "buffer": 0, "byteOffset": 48, "byteLength": 32 },
    { "buffer": 0, "byteOffset": 80, "byteLength": 12 }
  ],
  "buffers": [{ "byteLength": 92, "uri": "square.bin" }]
}"#;

fn square(bench: &Bench) {
    let numbers: [f32; 20] = [
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, // positions
        0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, // texture coordinates
    ];
    let indices: [u16; 6] = [0, 1, 2, 0, 2, 3];
    let mut bytes = bytemuck::cast_slice::<f32, u8>(&numbers).to_vec();
    bytes.extend(bytemuck::cast_slice::<u16, u8>(&indices));
    fs::write(bench.path("square.bin"), bytes).expect("written");
    fs::write(bench.path("square.gltf"), SQUARE).expect("written");
    let look = "[node.squares]\ntexture = \"checker\"\nscale = 4.0\n[material.Paint]\nbase_color = \"squares\"\n";
    fs::write(bench.path("l.toml"), look).expect("written");
}

#[test]
fn materials_and_nodes_become_pictures() {
    let bench = Bench::new();
    square(&bench);
    let flags = "--scene square.gltf --look l.toml --device native --size 32";
    bench
        .run(&format!("bake Paint {flags} -o p.png"))
        .expect_code(0);
    for role in ["base_color", "metallic_roughness", "normal"] {
        let path = bench.path(&format!("p_{role}.png"));
        let picture = image::open(&path).expect("a picture").to_rgba8();
        assert_eq!(picture.dimensions(), (32, 32));
        if role == "normal" {
            assert!(picture.pixels().all(|p| p.0 == [128, 128, 255, 255]));
        }
        if role == "base_color" {
            let colors: std::collections::HashSet<_> = picture.pixels().map(|p| p.0).collect();
            assert!(colors.len() >= 2, "a checkerboard: {colors:?}");
        }
    }
    bench
        .run(&format!("bake squares {flags} --mesh Wall -o n.exr"))
        .expect_code(0);
    assert!(bench.path("n.exr").exists());
}

#[test]
fn a_number_as_exr_hides_nothing_by_its_alpha() {
    let bench = Bench::new();
    square(&bench);
    let flags = "--scene square.gltf --look l.toml --device native --size 32";
    bench
        .run(&format!("bake squares.x {flags} --mesh Wall -o n.exr"))
        .expect_code(0);
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level();
    let read = read.all_channels().first_valid_layer().all_attributes();
    let image = read.from_file(bench.path("n.exr")).expect("an EXR file");
    let channels = &image.layer_data.channel_data.list;
    let values = |name: &str| -> Vec<f32> {
        let channel = channels.iter().find(|channel| channel.name.eq(name));
        let samples = &channel.expect("there is one").sample_data;
        samples.values_as_f32().collect()
    };
    assert!(values("R").iter().any(|&value| value < 0.9));
    assert!(values("A").iter().all(|&alpha| alpha == 1.0));
}

#[test]
fn what_only_lies_above_another_material_is_baked_over_a_named_mesh() {
    let bench = Bench::new();
    square(&bench);
    let look = "[node.squares]\ntexture = \"checker\"\nscale = 4.0\n[material.Rust]\nbase_color = \"squares\"\n\
                [material.Paint]\nblend = { base = \"Paint\", over = \"Rust\", mask = 0.5 }\n";
    fs::write(bench.path("l.toml"), look).expect("written");
    let flags = "--scene square.gltf --look l.toml --device native --size 32 -o p.png";
    let run = bench.run(&format!("bake Rust {flags}")).expect_code(1);
    assert!(run.stderr.contains("--mesh NAME"), "{}", run.stderr);
    let run = bench.run(&format!("bake Rust {flags} --mesh Wall"));
    let said = run.expect_code(0).stdout;
    assert!(said.contains("over the whole mesh"), "{said}");
    let picture = image::open(bench.path("p_base_color.png")).expect("a picture");
    let colors: std::collections::HashSet<_> = picture.to_rgba8().pixels().map(|p| p.0).collect();
    assert!(colors.len() >= 2, "a checkerboard: {colors:?}");
}

#[test]
fn pictures_have_the_opacity_in_alpha() {
    let bench = Bench::new();
    square(&bench);
    let look = "[node.squares]\ntexture = \"checker\"\nscale = 4.0\n[material.Paint]\nopacity = \"squares.x\"\n";
    fs::write(bench.path("l.toml"), look).expect("written");
    let flags = "--scene square.gltf --look l.toml --device native --size 32";
    bench
        .run(&format!("bake Paint {flags} -o p.png"))
        .expect_code(0);
    let open = |name: &str| image::open(bench.path(name)).expect("a picture");
    let picture = open("p_base_color.png");
    assert!(picture.color().has_alpha());
    let alphas: std::collections::HashSet<_> =
        picture.to_rgba8().pixels().map(|p| p.0[3]).collect();
    assert!(alphas.len() >= 2, "a checkerboard: {alphas:?}");
    assert!(!open("p_normal.png").color().has_alpha());
    let run = bench.run(&format!("bake Paint {flags} -o p.jpg"));
    let said = run.expect_code(0).stderr;
    assert!(
        said.contains("p_base_color.jpg can't hold its fourth channel"),
        "{said}"
    );
}

#[test]
fn what_has_no_texel_is_told() {
    let bench = Bench::new();
    square(&bench);
    let line = "bake Paint --scene square.gltf --look l.toml --device native --size 32 -o p.png";
    let run = bench.run(line).expect_code(0);
    assert!(!run.stderr.contains("no texel"), "{}", run.stderr);
    // The fourth corner lies on the first one.
    let mut bytes = fs::read(bench.path("square.bin")).expect("it is there");
    bytes[72..80].copy_from_slice(bytemuck::cast_slice::<f32, u8>(&[0.0, 1.0]));
    fs::write(bench.path("square.bin"), bytes).expect("written");
    let run = bench.run(line).expect_code(0);
    let said = "50 % of the surface of mesh \"square\" has no texel and shows what lies nearest";
    assert!(run.stderr.contains(said), "{}", run.stderr);
}

#[test]
fn what_cannot_be_baked_is_said() {
    let bench = Bench::new();
    square(&bench);
    let flags = "--scene square.gltf --look l.toml --device native -o p.png";
    for (line, because) in [
        (format!("bake Pint {flags}"), "did you mean `Paint`?"),
        (
            format!("bake Paint --mesh Wal {flags}"),
            "did you mean `Wall`?",
        ),
        (
            "bake Paint --scene triangle.gltf -o p.png".to_owned(),
            "there is no material or node",
        ),
    ] {
        let run = bench.run(&line).expect_code(1);
        assert!(run.stderr.contains(because), "{line}: {}", run.stderr);
    }
    let bare = SQUARE.replace(", \"TEXCOORD_0\": 1", "");
    fs::write(bench.path("bare.gltf"), bare).expect("written");
    let line = "bake Paint --scene bare.gltf --look l.toml --device native -o p.png";
    let run = bench.run(line).expect_code(1);
    assert!(run.stderr.contains("unwrap it"), "{}", run.stderr);
    for (flag, because) in [
        ("--size 0", "from 1 to"),
        ("--samples 9", "from 1 to 8"),
        ("--occlusion -1", "greater than 0"),
    ] {
        let run = bench
            .run(&format!("bake Paint {flags} {flag}"))
            .expect_code(2);
        assert!(run.stderr.contains(because), "{flag}: {}", run.stderr);
    }
}

#[test]
fn a_scene_is_exported_and_looks_the_same() {
    let bench = Bench::new();
    square(&bench);
    let look = "environment = { color = [1.0, 1.0, 1.0] }\n[camera]\nposition = [0.5, 0.5, 2.0]\nlook_at = [0.5, 0.5, 0.0]\n\
                [node.squares]\ntexture = \"checker\"\nscale = 4.0\n[material.Paint]\nbase_color = \"squares\"\nroughness = 0.9\n";
    fs::write(bench.path("l.toml"), look).expect("written");
    let line = "export square.gltf --look l.toml --device native --size 256 -o baked.glb";
    bench.run(line).expect_code(0);
    let flags = "--device native --size 48x48 --spp 64";
    for (scene, output) in [
        ("square.gltf --look l.toml", "a.png"),
        ("baked.glb", "b.png"),
    ] {
        let line = format!("render {scene} {flags} -o {output}");
        let run = bench.run(&line).expect_code(0);
        assert!(!run.stderr.contains("warning"), "{}", run.stderr);
    }
    bench
        .run("compare a.png b.png --max-flip 0.05")
        .expect_code(0);
    let line = "export square.gltf --look l.toml -o baked.gltf";
    let run = bench.run(line).expect_code(2);
    assert!(run.stderr.contains(".glb"), "{}", run.stderr);
}
