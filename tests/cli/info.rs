//! `patina info` on the command line.

use super::compare::{grey, json};
use super::*;

#[test]
fn a_scene_is_told_of_with_and_without_a_look() {
    let bench = Bench::new();
    let text = bench.run("info triangle.gltf").expect_code(0).stdout;
    for wanted in [
        "triangles    1 in 1 place of 1 mesh",
        "-1 -1 0 to 1 1 0 m",
        "materials (1)",
        "emission = 1 1 1",
        "Front",
    ] {
        assert!(text.contains(wanted), "{wanted}:\n{text}");
    }
    let look = "[node.spots]\ntexture = \"checker\"\n[node.idle]\ntexture = \"checker\"\n\
                [material.Glow]\nbase_color = \"spots\"\n";
    fs::write(bench.path("a.look.toml"), look).expect("written");
    let found = bench.run("info triangle.gltf --look a.look.toml --json");
    let found = json(&found.expect_code(0));
    assert_eq!(found["kind"], "scene");
    assert_eq!(found["triangles"], 1);
    let driven = &found["materials"][0]["look"]["driven"][0];
    assert_eq!(driven["parameter"], "base_color");
    assert_eq!(
        (&driven["from"], &driven["texture"]),
        (&"spots".into(), &"checker".into())
    );
    assert_eq!(found["unused"]["nodes"], serde_json::json!(["idle"]));
    let found = json(&bench.run("info a.look.toml --json").expect_code(0));
    assert_eq!(found["kind"], "look");
    assert_eq!(found["nodes"][1]["name"], "idle");
    assert_eq!(found["unused_nodes"], serde_json::json!(["idle"]));
    bench
        .run("info a.look.toml --look a.look.toml")
        .expect_error(1, "no scene");
}

#[test]
fn films_and_pictures_are_told_of() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let line = "render triangle.gltf --size 33x17 --sample-range 4..9 --layers depth -o a.patina-film -o a.exr";
    bench.run(line).expect_code(0);
    let film = bench.run("info a.patina-film").expect_code(0).stdout;
    for wanted in [
        "33x17",
        "4..9: 5 per pixel",
        "combined, depth",
        "triangle.gltf",
        "max-depth",
    ] {
        assert!(film.contains(wanted), "{wanted}:\n{film}");
    }
    let film = json(&bench.run("info a.patina-film --json").expect_code(0));
    assert_eq!(film["kind"], "film");
    assert_eq!(film["ranges"], serde_json::json!([[4, 9]]));
    let picture = bench.run("info a.exr").expect_code(0).stdout;
    for wanted in [
        "OpenEXR, 33x17",
        "ViewLayer.Depth.Z",
        "float",
        "samplesPerPixel",
    ] {
        assert!(picture.contains(wanted), "{wanted}:\n{picture}");
    }
    grey(&bench, "a.png", [7, 5], 1);
    let picture = json(&bench.run("info a.png --json").expect_code(0));
    assert_eq!(picture["kind"], "picture");
    assert_eq!(picture["parts"][0]["width"], 7);
}

#[test]
fn what_cannot_be_told_of_is_an_error_that_names_it() {
    let bench = Bench::new();
    let film = b"PATINAFM\x05\x00\x00\x00{}";
    for (name, content) in [
        ("empty.gltf", &b""[..]),
        ("text.bin", b"hello"),
        ("cut.exr", b"\x76\x2f\x31\x01\x02\x00\x00\x00chann"),
        ("cut.png", b"\x89PNG\r\n\x1a\n\x00\x00"),
        ("cut.patina-film", film),
        ("bad.look.toml", b"[node"),
    ] {
        fs::write(bench.path(name), content).expect("written");
        let told = bench.run(&format!("info {name}")).expect_error(1, name);
        assert!(!told.stderr.contains("warning"), "{}", told.stderr);
    }
    bench
        .run("info text.bin")
        .expect_error(1, "a partial render (.patina-film)");
    bench.run("info no.glb").expect_error(1, "no.glb");
    bench.run("info .").expect_error(1, "");
}
