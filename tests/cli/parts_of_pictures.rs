//! Parts of pictures, how EXR files hold numbers, and the memory that a render may take.

use super::*;

use exr::math::Vec2;
use exr::prelude::{FlatImage, FlatSamples, ReadChannels, ReadLayers};

fn read(path: &Path) -> FlatImage {
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level();
    let read = read.all_channels().all_layers().all_attributes();
    read.from_file(path).expect("an EXR file")
}

/// Numbers of a channel, and whether they have 16 bits.
fn channel(image: &FlatImage, name: &str) -> (Vec<f32>, bool) {
    let channels = &image.layer_data[0].channel_data.list;
    let channel = channels.iter().find(|c| c.name.to_string() == name);
    let samples = &channel.expect("it is there").sample_data;
    let is_half = matches!(samples, FlatSamples::F16(_));
    (samples.values_as_f32().collect(), is_half)
}

#[test]
fn a_part_of_a_picture_is_that_of_the_whole() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let render = "render triangle.gltf --size 66x34 --scale 50% --max-depth 2 --layers depth";
    let run = |flags: &str| bench.run(&format!("{render} {flags}")).expect_code(0);
    run("--spp 5 -o whole.exr");
    run("--spp 5 --crop 9,3,11,13 -o part.exr -o part.png");
    for (name, range) in [("a", "0..2"), ("b", "2..5")] {
        let line = format!("--crop 9,3,11,13 --sample-range {range} -o {name}.patina-film");
        run(&line);
    }
    let merge = "merge a.patina-film b.patina-film -o merged.exr -o merged.png";
    bench.run(merge).expect_code(0);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    for kind in ["exr", "png"] {
        let same = bytes(&format!("part.{kind}")) == bytes(&format!("merged.{kind}"));
        assert!(same, "{kind}");
    }
    let [whole, part] = ["whole.exr", "part.exr"].map(|name| read(&bench.path(name)));
    let layer = &part.layer_data[0];
    assert_eq!(layer.attributes.layer_position, Vec2(9, 3));
    assert_eq!(layer.size, Vec2(11, 13));
    let window = part.attributes.display_window;
    assert_eq!((window.position, window.size), (Vec2(0, 0), Vec2(33, 17)));
    for name in ["ViewLayer.Combined.G", "ViewLayer.Depth.Z"] {
        let [(whole, _), (part, is_half)] = [&whole, &part].map(|image| channel(image, name));
        let there = |at: usize| (3 + at / 11) * 33 + 9 + at % 11;
        let is_same = |(at, value): (usize, &f32)| *value == whole[there(at)];
        assert!(part.iter().enumerate().all(is_same), "{name}");
        assert_eq!(is_half, name.contains("Combined"), "{name}");
    }
    run("--crop 10,3,11,13 --sample-range 5..6 -o c.patina-film");
    bench
        .run("merge a.patina-film c.patina-film -o refused.exr")
        .expect_error(1, "crop");
    bench
        .run(&format!("{render} --crop 30,3,11,13 -o refused.exr"))
        .expect_error(2, "33 x 17");
}

#[test]
fn exr_files_are_as_they_are_asked_for() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let render = "render triangle.gltf --size 33x17 --max-depth 2 --spp 2 --layers depth,normal";
    let form = "--exr-float all --exr-half normal --exr-compression piz --metadata shot=0420 --metadata owner=Us";
    bench
        .run(&format!("{render} {form} -o a.exr -o a.patina-film"))
        .expect_code(0);
    let merge = format!("merge a.patina-film {form} -o b.exr");
    bench.run(&merge).expect_code(0);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    assert!(bytes("a.exr") == bytes("b.exr"));
    let image = read(&bench.path("a.exr"));
    for (name, is_half) in [
        ("Combined.R", false),
        ("Depth.Z", false),
        ("Normal.X", true),
    ] {
        let found = channel(&image, &format!("ViewLayer.{name}")).1;
        assert_eq!(found, is_half, "{name}");
    }
    let picture = bench.run("info a.exr").expect_code(0).stdout;
    for wanted in ["piz", "shot", "0420", "patina:camera"] {
        assert!(picture.contains(wanted), "{wanted}:\n{picture}");
    }
    let refused = "--layers crypto_object --exr-compression dwab -o c.exr";
    bench
        .run(&format!("render triangle.gltf --spp 1 {refused}"))
        .expect_error(2, "choose zip");
    for wrong in ["shot", "tiles=1", "=x"] {
        let line = format!("render triangle.gltf -o c.exr --metadata {wrong}");
        bench.run(&line).expect_error(2, "--metadata");
    }
}

#[test]
fn memory_is_stated_before_a_render_and_refused_where_it_is_too_much() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let render = "render triangle.gltf --spp 1 --max-depth 1 -o a.exr --layers depth";
    let run = bench.run(&format!("{render} --size 32x32 --memory 8G"));
    let said = run.expect_code(0).stdout;
    assert!(said.contains("memory: at most"), "{said}");
    let film = format!("{render} -o a.patina-film --size 4096x4096 --memory 200M");
    let refused = bench.run(&film).expect_error(1, "--memory 200 MiB");
    let said = refused.stderr;
    assert!(
        said.contains("a .patina-film is written as a whole"),
        "{said}"
    );
    // Not even a row of blocks has room there.
    let refused = bench.run(&format!("{render} --size 4096x4096 --memory 2M"));
    refused.expect_error(1, "pieces of 4096x8");
}

/// What the first lines of its file claim is enough for that: there is no more of it.
#[test]
fn a_large_environment_is_refused_before_it_is_read() {
    let bench = Bench::new();
    let head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8192 +X 16384\n";
    fs::write(bench.path("sky.hdr"), head).expect("written");
    let line = "render triangle.gltf --environment sky.hdr --spp 1 -o a.png";
    let refused = bench.run(&format!("{line} --memory 1G"));
    let said = refused.expect_error(1, "more than --memory 1.0 GiB").stderr;
    assert!(said.contains("16384x8192") && said.contains("scale it down"));
    assert!(!bench.path("a.png").exists());
}

#[test]
fn parts_fit_wherever_the_textures_lie() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    for folder in ["here", "there"] {
        let textures = bench.path(folder).join("user_textures");
        fs::create_dir_all(&textures).expect("a folder");
        let texture = "fn userProc() -> vec3f { return vec3f(0.25); }";
        fs::write(textures.join("gray.wgsl"), texture).expect("written");
        let look = "[node.g]\ntexture = 'gray'\n[material.Glow]\nbase_color = 'g'\n";
        fs::write(bench.path(folder).join("a.look.toml"), look).expect("written");
    }
    let there = bench.path("there/a.look.toml");
    for (look, part) in [
        ("here/a.look.toml", "1/3"),
        ("./here/a.look.toml", "2/3"),
        (&*there.display().to_string(), "3/3"),
    ] {
        let name = &part[..1];
        bench
            .run(&format!(
                "render triangle.gltf --size 8x8 --spp 3 --look {look} --part {part} -o {name}.patina-film"
            ))
            .expect_code(0);
    }
    bench
        .run("merge 1.patina-film 2.patina-film 3.patina-film -o whole.png")
        .expect_code(0);
}

#[test]
fn each_camera_is_rendered_whatever_it_is_called() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let scene = fs::read_to_string(bench.path("triangle.gltf")).expect("it is there");
    let mut scene: serde_json::Value = serde_json::from_str(&scene).expect("JSON");
    scene["cameras"] = serde_json::Value::Array(Vec::new());
    for node in scene["nodes"].as_array_mut().expect("nodes") {
        let _ = node.as_object_mut().map(|node| node.remove("camera"));
    }
    for name in ["1", "2"] {
        let number = scene["cameras"].as_array().map_or(0, Vec::len);
        let angle = 0.3 + 0.5 * number as f32;
        let camera = serde_json::json!({
            "name": name, "type": "perspective", "perspective": { "yfov": angle, "znear": 0.1 }
        });
        let node = serde_json::json!({ "camera": number, "translation": [0.2, 0.2, 2.0] });
        let place = scene["nodes"].as_array().map_or(0, Vec::len);
        for (list, value) in [("cameras", camera), ("nodes", node)] {
            scene[list].as_array_mut().expect("a list").push(value);
        }
        let nodes = scene["scenes"][0]["nodes"].as_array_mut();
        nodes.expect("a list").push(place.into());
    }
    fs::write(bench.path("two.gltf"), scene.to_string()).expect("written");
    let line = "render two.gltf --size 16x16 --spp 1";
    // The second one's file is read, which is said before the first one is rendered.
    fs::write(bench.path("b-2.png"), "a picture").expect("written");
    bench
        .run(&format!(
            "{line} --camera all --environment b-2.png -o b.png"
        ))
        .expect_error(2, "is an input");
    assert!(!bench.path("b-1.png").exists());
    bench
        .run(&format!("{line} --camera all -o a.png"))
        .expect_code(0);
    for name in ["1", "2"] {
        bench
            .run(&format!("{line} --camera {name} -o {name}.png"))
            .expect_code(0);
        let bytes = |file: String| fs::read(bench.path(&file)).expect("it was written");
        assert!(
            bytes(format!("a-{name}.png")) == bytes(format!("{name}.png")),
            "{name}"
        );
    }
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    assert!(bytes("1.png") != bytes("2.png"));
}
