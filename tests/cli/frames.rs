//! Scenes that move: frames, moments, open shutters, turntables.

use serde_json::{Value, json};

use super::*;

/// The triangle, which moves to the right by two metres a second for two seconds, with another animation that turns it.
fn moving() -> Bench {
    let bench = Bench::new();
    let mut scene: Value = serde_json::from_str(TRIANGLE).expect("it is JSON");
    let numbers: [f32; 16] = [
        0.0, 2.0, // times
        0.0, 0.0, 0.0, 4.0, 0.0, 0.0, // places
        0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, // turns
    ];
    let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    fs::write(bench.path("moving.bin"), bytes).expect("written");
    let list = |scene: &mut Value, name: &str, value: Value| {
        let list = scene[name].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    };
    let buffer = json!({ "byteLength": 64, "uri": "moving.bin" });
    list(&mut scene, "buffers", buffer);
    for (start, length, kind) in [(0, 8, "SCALAR"), (8, 24, "VEC3"), (32, 32, "VEC4")] {
        let view = json!({ "buffer": 1, "byteOffset": start, "byteLength": length });
        let view = list(&mut scene, "bufferViews", view);
        let accessor =
            json!({ "bufferView": view, "componentType": 5126, "count": 2, "type": kind });
        list(&mut scene, "accessors", accessor);
    }
    scene["animations"] = json!([
        {
            "name": "Slide",
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
            "samplers": [{ "input": 1, "output": 2 }],
        },
        {
            "name": "Turn",
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "rotation" } }],
            "samplers": [{ "input": 1, "output": 3 }],
        },
    ]);
    fs::write(bench.path("moving.gltf"), scene.to_string()).expect("written");
    bench
}

const SMALL: &str = "render moving.gltf --camera Front --size 48x32 --spp 8 --device native";

#[test]
fn frames_are_what_each_is_alone() {
    let bench = moving();
    bench
        .run(&format!(
            "{SMALL} --frames 0..36:12 -o f.png -o f.patina-film"
        ))
        .expect_code(0);
    let pictures = ["f.0000.png", "f.0012.png", "f.0024.png"];
    let bytes = |name: &str| fs::read(bench.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    for (number, picture) in [0, 12, 24].into_iter().zip(pictures) {
        let seconds = f64::from(number) / 24.0;
        bench
            .run(&format!(
                "{SMALL} --at {seconds} -o alone.png -o alone.patina-film"
            ))
            .expect_code(0);
        assert!(bytes(picture) == bytes("alone.png"), "{picture}");
        let film = picture.replace("png", "patina-film");
        assert!(bytes(&film) == bytes("alone.patina-film"), "{film}");
    }
    assert!(bytes(pictures[0]) != bytes(pictures[1]));
    assert!(
        !bench.files().contains(&"f.0036.png".to_owned()),
        "the last isn't among them"
    );
    // One of the animations alone, and none.
    for (flags, other) in [
        ("--animation Slide --at 0.5", "--at 0.5"),
        ("--fps 12 --at 0.5", ""),
    ] {
        bench
            .run(&format!("{SMALL} {flags} -o one.png"))
            .expect_code(0);
        bench
            .run(&format!("{SMALL} {other} -o other.png"))
            .expect_code(0);
        assert!(bytes("one.png") != bytes("other.png"), "{flags}");
    }
    bench.run(&format!("{SMALL} -o rest.png")).expect_code(0);
    let still =
        "render triangle.gltf --camera Front --size 48x32 --spp 8 --device native -o still.png";
    bench.run(still).expect_code(0);
    assert!(
        bytes("rest.png") == bytes("still.png"),
        "at rest nothing moves"
    );
}

#[test]
fn no_frame_takes_the_place_of_an_input() {
    let bench = moving();
    fs::write(bench.path("sky.0012.png"), "a picture").expect("written");
    fs::write(bench.path("f.0024.png"), "a picture").expect("written");
    let look = "environment = { image = \"f.0024.png\" }\n";
    fs::write(bench.path("a.look.toml"), look).expect("written");
    let mut scene: Value =
        serde_json::from_slice(&fs::read(bench.path("moving.gltf")).expect("it is there"))
            .expect("it is JSON");
    scene["scenes"][0]["extras"] = json!({ "environment": { "uri": "sky.0012.png" } });
    fs::write(bench.path("lit.gltf"), scene.to_string()).expect("written");
    let files = bench.files();
    for (scene, flags) in [
        ("moving.gltf", "--environment sky.0012.png -o sky.png"),
        ("moving.gltf", "--look a.look.toml -o f.png"),
        ("lit.gltf", "-o sky.png"),
        ("lit.gltf", "--look a.look.toml -o sky.png"),
    ] {
        let line = SMALL.replace("moving.gltf", scene);
        bench
            .run(&format!("{line} --frames 0..36:12 {flags}"))
            .expect_error(2, "is an input");
        assert_eq!(bench.files(), files, "{flags}: a frame was rendered before");
    }
    if !device() {
        return;
    }
    // Those that are there may be links to one file.
    fs::write(bench.path("o.0000.png"), "a picture").expect("written");
    fs::hard_link(bench.path("o.0000.png"), bench.path("o.0012.png")).expect("a link");
    bench
        .run(&format!("{SMALL} --frames 0..24:12 -o o.png"))
        .expect_code(0);
}

#[test]
fn motion_is_a_layer_of_what_moves() {
    let bench = moving();
    let render = format!("{SMALL} --layers vector --animation Slide");
    for line in [
        format!("{render} --frames 12..13 -o f.exr"),
        format!("{render} --at 0.5 -o alone.exr"),
        format!("{render} --at 0.5 --fps 12 -o slow.exr"),
        format!("{render} --at 5 -o over.exr"),
        format!("{SMALL} --layers vector -o rest.exr"),
    ] {
        bench.run(&line).expect_code(0);
    }
    let same = |a: &str, b: &str| format!("compare {a}.exr {b}.exr --layer vector --max-mse 0");
    bench.run(&same("f.0012", "alone")).expect_code(0);
    bench.run(&same("over", "rest")).expect_code(0);
    for other in ["rest", "slow"] {
        let found = bench.run(&same("alone", other));
        assert!(found.code != Some(0), "{other}");
    }
    // Seen by turns about itself everything moves.
    let line = format!("{SMALL} --layers vector --turntable 8 --frame-part 1/8 -o t.exr");
    bench.run(&line).expect_code(0);
    assert!(bench.run(&same("t.0000", "rest")).code != Some(0));
}

#[test]
fn skins_have_their_own_motion() {
    let bench = moving();
    let text = fs::read_to_string(bench.path("moving.gltf")).expect("there");
    let mut scene: Value = serde_json::from_str(&text).expect("it is JSON");
    // Half of each vertex follows a joint that moves, half of it one that stands still: so it is half as fast as the joint.
    let mut bytes = [0_u8, 1, 0, 0].repeat(3);
    let weights = [0.5_f32, 0.5, 0.0, 0.0].repeat(3);
    bytes.extend(weights.iter().flat_map(|n| n.to_le_bytes()));
    fs::write(bench.path("skin.bin"), bytes).expect("written");
    let add = |scene: &mut Value, name: &str, value: Value| {
        let list = scene[name].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    };
    let buffer = json!({ "byteLength": 60, "uri": "skin.bin" });
    let buffer = add(&mut scene, "buffers", buffer);
    for (start, length, kind, name) in [(0, 12, 5121, "JOINTS_0"), (12, 48, 5126, "WEIGHTS_0")] {
        let view = json!({ "buffer": buffer, "byteOffset": start, "byteLength": length });
        let view = add(&mut scene, "bufferViews", view);
        let accessor =
            json!({ "bufferView": view, "componentType": kind, "count": 3, "type": "VEC4" });
        let accessor = add(&mut scene, "accessors", accessor);
        scene["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    }
    let bone = add(&mut scene, "nodes", json!({ "name": "Bone" }));
    let still = add(&mut scene, "nodes", json!({ "name": "Still" }));
    scene["scenes"][0]["nodes"] = json!([0, 1, bone, still]);
    scene["skins"] = json!([{ "joints": [bone, still] }]);
    scene["nodes"][0]["skin"] = json!(0);
    scene["animations"][0]["channels"][0]["target"]["node"] = json!(bone);
    fs::write(bench.path("skinned.gltf"), scene.to_string()).expect("written");
    let flags = "--camera Front --size 48x32 --spp 8 --device native --layers vector";
    for line in [
        format!("render skinned.gltf {flags} --animation Slide --at 0.5 -o skin.exr"),
        format!("render skinned.gltf {flags} -o rest.exr"),
        // Where the node is a quarter of a second later it has gone as far; a frame of 1/48 s is half as long.
        format!("render moving.gltf {flags} --animation Slide --at 0.25 --fps 48 -o node.exr"),
    ] {
        bench.run(&line).expect_code(0);
    }
    let compare =
        |other: &str| format!("compare skin.exr {other}.exr --layer vector --max-mse 1e-8");
    bench.run(&compare("node")).expect_code(0);
    assert!(bench.run(&compare("rest")).code != Some(0));
}

#[test]
fn frames_that_are_there_are_left_out_by_resume() {
    let bench = moving();
    let line = format!("{SMALL} --frames 0..3 --resume -o f/####.png");
    fs::create_dir(bench.path("f")).expect("a folder");
    bench.run(&line).expect_code(0);
    fs::write(bench.path("f/0001.png"), "mine").expect("written");
    fs::remove_file(bench.path("f/0002.png")).expect("it was there");
    let again = bench.run(&line).expect_code(0);
    assert!(again.stdout.contains("2 of 3 frames"), "{}", again.stdout);
    let names = fs::read_dir(bench.path("f")).expect("a folder").count();
    assert_eq!(names, 3, "checkpoints of frames that are done are gone");
    assert_eq!(fs::read(bench.path("f/0001.png")).expect("there"), b"mine");
}

#[test]
fn films_of_earlier_renders_are_left_alone() {
    let bench = moving();
    let line = format!("{SMALL} --frames 0..2 -o f.patina-film");
    bench.run(&line).expect_code(0);
    let films = || {
        ["f.0000.patina-film", "f.0001.patina-film"]
            .map(|name| fs::read(bench.path(name)).expect("it is there"))
    };
    let before = films();
    let line = format!("{SMALL} --frames 0..2 --seed 5 --checkpoint=0.001 -o f.png");
    let said = bench.run(&line).expect_code(0).stderr;
    assert_eq!(said.matches("has no checkpoint").count(), 2, "{said}");
    assert!(films() == before);
}

#[test]
fn an_open_shutter_is_the_sum_of_its_moments_and_of_its_parts() {
    let bench = moving();
    // Paths last: their files are what is compared with below.
    for method in ["cache", "path"] {
        let blurred =
            format!("{SMALL} --method {method} --at 0.5 --shutter 0.5 --motion-samples 4");
        bench
            .run(&format!("{blurred} -o whole.patina-film -o whole.png"))
            .expect_code(0);
        for part in 1..=3 {
            bench
                .run(&format!("{blurred} --part {part}/3 -o {part}.patina-film"))
                .expect_code(0);
        }
        bench
            .run("merge 1.patina-film 2.patina-film 3.patina-film -o merged.png")
            .expect_code(0);
        bench
            .run("compare whole.png merged.png --max-mse 0")
            .expect_code(0);
    }
    bench
        .run(&format!("{SMALL} --at 0.5 -o sharp.png"))
        .expect_code(0);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it is there");
    assert!(bytes("whole.png") != bytes("sharp.png"));
    // Another shutter is another picture: nothing to be added.
    bench
        .run(&format!(
            "{SMALL} --at 0.5 --part 3/3 --shutter 0.25 --motion-samples 4 -o other.patina-film"
        ))
        .expect_code(0);
    bench
        .run("merge 1.patina-film 2.patina-film other.patina-film -o no.png")
        .expect_error(1, "part of another picture");
}

#[test]
fn how_right_a_picture_of_many_moments_is_all_of_them_say() {
    let bench = moving();
    let (wide, moments) = (
        "--size 64x48 --fps 2 --at 0.25",
        "--shutter 1 --motion-samples 2",
    );
    let scene = SMALL.replace("--size 48x32 --spp 8", wide);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it is there");
    let line = format!("{scene} {moments} --spp 64");
    let said = bench.run(&format!("{line} --accuracy final -o final.png"));
    let said = said.expect_code(0).stdout;
    let bias = said.lines().find(|line| line.starts_with("biased: "));
    let numbers: Vec<f64> = bias
        .unwrap_or_else(|| panic!("nobody looked: {said}"))
        .split(|c: char| !c.is_ascii_digit() && !".+-".contains(c))
        .filter_map(|word| word.parse().ok())
        .collect();
    // Between them stand the sides of blocks.
    let [brightness, certainty, 8.0, 8.0, least, most, ..] = numbers[..] else {
        panic!("{said}");
    };
    // The triangle is elsewhere half of the time: paths of one moment alone would find blocks off by all that they show.
    assert!(brightness.abs() < 2.0 * certainty + 0.1, "{said}");
    assert!(least == 0.0 && most < 20.0, "{said}");
    // Nothing was made finer, so this is what the cache says.
    bench
        .run(&format!("{line} --method cache -o cache.png"))
        .expect_code(0);
    assert!(bytes("final.png") == bytes("cache.png"));
    // Halves that see other moments can't be compared.
    let uneven = line.replace("--spp 64", "--spp 48");
    let said = bench.run(&format!("{uneven} --method cache -o uneven.png"));
    assert!(!said.expect_code(0).stdout.contains("biased: "));
    bench
        .run(&format!("{uneven} --accuracy final -o no.png"))
        .expect_error(2, "--spp 64");
    bench
        .run(&format!("{scene} {moments} --accuracy final -o no.png"))
        .expect_error(2, "with --spp");
}

#[test]
fn a_turntable_begins_where_the_camera_is() {
    let bench = moving();
    bench
        .run(&format!("{SMALL} --turntable 5 -o t.png"))
        .expect_code(0);
    bench.run(&format!("{SMALL} -o still.png")).expect_code(0);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it is there");
    assert!(bytes("t.0000.png") == bytes("still.png"));
    assert!(bytes("t.0000.png") != bytes("t.0001.png"));
    assert!(bench.path("t.0004.png").exists() && !bench.path("t.0005.png").exists());
}

#[test]
fn what_makes_no_sense_together_is_refused() {
    let bench = moving();
    for (flags, says) in [
        ("--frames 3..1", "--frames 0..48"),
        ("--frames 0..2 --at 1", "cannot be used with"),
        ("--frames 0..2 --turntable 3", "cannot be used with"),
        ("--frames 0..2 --device native,llvmpipe", "single device"),
        ("--frames 0..2 --refresh", "leave it out"),
        ("--at soon", "seconds"),
        ("--fps 0", "from 0.001"),
        ("--shutter 2", "from 0 to 1"),
        ("--motion-samples 4", "--shutter"),
        ("--shutter 0.5 --noise 0.1", "--spp"),
        ("--shutter 0.5 --motion-samples 3", "--spp 66"),
        // More samples than that there can't be.
        (
            "--shutter 0.5 --spp 1000000 --motion-samples 600001",
            "moments; write another number of --motion-samples",
        ),
        ("--shutter 0.5 --sample-range 0..8", "--part"),
        ("--turntable 0", "from 1 to"),
    ] {
        bench
            .run(&format!("render moving.gltf {flags}"))
            .expect_error(2, says);
    }
    bench
        .run("render moving.gltf --animation Jump")
        .expect_error(1, "it has Slide, Turn");
    let text = bench.run("info moving.gltf").expect_code(0).stdout;
    assert!(
        text.contains("animations (2)") && text.contains("0 to 2 s"),
        "{text}"
    );
}

#[test]
fn looks_have_keys_and_textures_know_the_time() {
    let bench = moving();
    let look = "[node.clock]\ntexture = 'clock'\n[material.Glow]\nemission = 'clock'\n";
    fs::write(bench.path("clock.look.toml"), look).expect("written");
    let texture = "fn userProc() -> vec3f { return vec3f(readGlobal(Time).x, 0.1 * readGlobal(FrameIndex).x, 0.2); }\n";
    fs::write(bench.path("clock.wgsl"), texture).expect("written");
    let line =
        "render triangle.gltf --camera Front --size 16x16 --spp 1 --device native --textures .";
    bench
        .run(&format!(
            "{line} --look clock.look.toml --frames 0..3:2 -o f.png"
        ))
        .expect_code(0);
    let keyed = "[material.Glow]\nemission = { keys = [[0, [0, 0, 0.2]], [1, [2, 0, 0.2]]] }\n";
    fs::write(bench.path("keyed.look.toml"), keyed).expect("written");
    bench
        .run(&format!(
            "{line} --look keyed.look.toml --frames 0..3:2 -o k.png"
        ))
        .expect_code(0);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it is there");
    for name in ["f", "k"] {
        assert!(
            bytes(&format!("{name}.0000.png")) != bytes(&format!("{name}.0002.png")),
            "{name}"
        );
    }
    let wrong = "[material.Glow]\nroughness = { keys = [[0, 0.5], [9, 3]] }\n";
    fs::write(bench.path("wrong.look.toml"), wrong).expect("written");
    bench
        .run(&format!("{line} --look wrong.look.toml"))
        .expect_error(1, "from 0 to 1");
}
