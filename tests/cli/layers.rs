//! Layers of the film on the command line, and what the headers of EXR files say whoever wrote them.

use super::*;

use exr::prelude::{ReadChannels, ReadLayers};

/// The names of an EXR file's channels, and those of the facts in its header.
fn contents(path: &Path) -> (Vec<String>, Vec<String>) {
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level();
    let read = read.all_channels().first_valid_layer().all_attributes();
    let image = read.from_file(path).expect("an EXR file");
    let layer = image.layer_data;
    let channels = layer.channel_data.list.iter();
    let channels = channels.map(|channel| channel.name.to_string()).collect();
    let facts = layer.attributes.other.keys();
    let mut facts: Vec<String> = facts.map(ToString::to_string).collect();
    facts.sort();
    (channels, facts)
}

#[test]
fn layers_are_named_on_the_command_line() {
    let bench = Bench::new();
    bench
        .run("render triangle.gltf --layers deep -o a.exr")
        .expect_error(2, "depth");
    bench
        .run("render triangle.gltf --layers depth -o a.png")
        .expect_error(2, ".exr");
    for flags in ["--exr-float all", "--exr-half depth", "--metadata a=b"] {
        let flag = flags.split(' ').next().unwrap_or_default();
        bench
            .run(&format!("render triangle.gltf {flags} -o a.png"))
            .expect_error(2, flag);
    }
    bench
        .run("render triangle.gltf --exr-float depth -o a.exr")
        .expect_error(2, "--layers depth");
}

#[test]
fn what_nothing_covers_is_transparent_in_renders_and_merges() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let render = "render triangle.gltf --size 33x17 --max-depth 2 --transparent";
    let line = format!("{render} --spp 6 -o a.png -o a.exr -o a.patina-film");
    bench.run(&line).expect_code(0);
    for (name, range) in [("b", "0..2"), ("c", "2..6")] {
        let line = format!("{render} --sample-range {range} -o {name}.patina-film");
        bench.run(&line).expect_code(0);
    }
    let merge = "merge b.patina-film c.patina-film --transparent -o m.png -o m.exr";
    bench.run(merge).expect_code(0);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    assert!(bytes("a.png") == bytes("m.png"));
    let merged = contents(&bench.path("m.exr")).0;
    assert!(merged.contains(&"ViewLayer.Combined.A".to_owned()));
    assert_eq!(contents(&bench.path("a.exr")).0, ["A", "B", "G", "R"]);
    bench
        .run("compare a.patina-film a.exr --max-relative-mse 1e-6 --max-flip 0.01")
        .expect_code(0);
    let picture = image::open(bench.path("a.png")).expect("a picture");
    let picture = picture.as_rgba8().expect("it has an alpha");
    assert_eq!(picture.get_pixel(0, 0).0, [0; 4], "a corner");
    assert_eq!(picture.get_pixel(16, 9).0[3], 255, "the triangle");
    bench
        .run("render triangle.gltf --size 33x17 --spp 1 -o d.patina-film")
        .expect_code(0);
    bench
        .run("merge d.patina-film --transparent -o d.png")
        .expect_error(1, "--transparent");
}

#[test]
fn groups_of_lights_are_named_by_the_look() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let look = "environment = { color = [1, 1, 1], group = \"sky\" }\n";
    fs::write(bench.path("groups.look.toml"), look).expect("written");
    let render = "render triangle.gltf --look groups.look.toml --size 9x9 --spp 2 --layers light_groups -o g.exr";
    bench.run(render).expect_code(0);
    let caught = bench.run(&render.replace("light_groups", "shadow_catcher"));
    let caught = caught.expect_code(0).stderr;
    assert!(caught.contains("no material is a"), "{caught}");
    bench.run(render).expect_code(0);
    let (channels, facts) = contents(&bench.path("g.exr"));
    assert!(facts.contains(&"patina:roulette".to_owned()), "{facts:?}");
    let groups = ["Combined", "Combined_rest", "Combined_sky"];
    let expected = groups.map(|group| ["B", "G", "R"].map(|c| format!("ViewLayer.{group}.{c}")));
    assert_eq!(channels, expected.as_flattened());
    for wrong in ["rest", "a b", ""] {
        let look = format!("environment = {{ color = [1, 1, 1], group = \"{wrong}\" }}\n");
        fs::write(bench.path("groups.look.toml"), look).expect("written");
        bench.run(render).expect_error(1, "group");
    }
}

#[test]
fn nodes_are_layers_by_their_names() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let look = "[node.rust]\ntexture = \"fbm\"\n[material.Glow]\nroughness = \"rust.x\"\n";
    fs::write(bench.path("a.look.toml"), look).expect("written");
    let render = "render triangle.gltf --look a.look.toml --size 9x9 --max-depth 2";
    let layers = "--layers depth,node:rust";
    bench
        .run(&format!(
            "{render} --spp 5 {layers} -o a.exr -o a.patina-film"
        ))
        .expect_code(0);
    for (name, range) in [("b", "0..2"), ("c", "2..5")] {
        let line = format!("{render} {layers} --sample-range {range} -o {name}.patina-film");
        bench.run(&line).expect_code(0);
    }
    let merge = "merge c.patina-film b.patina-film -o m.exr -o m.patina-film";
    bench.run(merge).expect_code(0);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    for kind in ["exr", "patina-film"] {
        assert!(
            bytes(&format!("a.{kind}")) == bytes(&format!("m.{kind}")),
            "{kind}"
        );
    }
    let (channels, _) = contents(&bench.path("a.exr"));
    let node = ["A", "B", "G", "R"].map(|c| format!("ViewLayer.Node rust.{c}"));
    assert_eq!(channels[4..], node);
    bench
        .run("compare a.exr m.patina-film --layer node:rust --max-mse 0")
        .expect_code(0);
    bench
        .run(&format!("{render} --spp 2 --layers node:rus -o d.exr"))
        .expect_error(1, "did you mean `rust`");
    bench
        .run(&format!("{render} --spp 2 -o d.patina-film"))
        .expect_code(0);
    bench
        .run("merge b.patina-film d.patina-film -o e.exr")
        .expect_error(1, "layers");
    bench
        .run("render triangle.gltf --layers node: -o a.exr")
        .expect_error(2, "node:");
}

#[test]
fn layers_are_written_and_merged_to_exactly_the_whole() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let render = |flags: &str| {
        let line = format!("render triangle.gltf --size 33x17 --max-depth 2 {flags}");
        bench.run(&line).expect_code(0)
    };
    let layers = "--layers depth,normal,variance";
    render(&format!(
        "{layers} --spp 11 -o whole.exr -o whole.patina-film -o whole.png"
    ));
    render("--spp 11 -o alone.exr -o alone.png");
    for (name, range) in [("a", "0..2"), ("b", "2..9"), ("c", "9..11")] {
        render(&format!(
            "{layers} --sample-range {range} -o {name}.patina-film"
        ));
    }
    render("--sample-range 9..11 -o alone.patina-film");
    let merged =
        "merge c.patina-film a.patina-film b.patina-film -o m.exr -o m.patina-film -o m.png";
    bench.run(merged).expect_code(0);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    for kind in ["exr", "patina-film", "png"] {
        let same = bytes(&format!("whole.{kind}")) == bytes(&format!("m.{kind}"));
        assert!(same, "{kind}");
    }
    assert!(bytes("whole.png") == bytes("alone.png"));
    let (channels, facts) = contents(&bench.path("whole.exr"));
    let expected = [
        "Combined.B",
        "Combined.G",
        "Combined.R",
        "Depth.Z",
        "Normal.X",
        "Normal.Y",
        "Normal.Z",
        "Variance.B",
        "Variance.G",
        "Variance.R",
    ];
    assert_eq!(channels, expected.map(|name| format!("ViewLayer.{name}")));
    let (channels, alone) = contents(&bench.path("alone.exr"));
    assert_eq!(channels, ["B", "G", "R"]);
    assert_eq!(facts, alone);
    bench
        .run("merge a.patina-film b.patina-film alone.patina-film -o refused.exr")
        .expect_error(1, "layers");
}

#[test]
fn ids_are_the_same_for_any_number_of_threads_and_parts() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let render = |flags: &str| {
        let line = "render triangle.gltf --size 33x17 --max-depth 1";
        let layers = "--layers crypto_object,crypto_material";
        bench
            .run(&format!("{line} {layers} {flags}"))
            .expect_code(0)
    };
    render("--threads 1 --spp 11 -o one.exr -o one.patina-film");
    render("--threads 3 --spp 11 -o three.exr -o three.patina-film");
    render("--threads 2 --sample-range 4..11 -o a.patina-film");
    render("--threads 1 --sample-range 0..4 -o b.patina-film");
    let merge = "merge a.patina-film b.patina-film -o merged.exr -o merged.patina-film";
    bench.run(merge).expect_code(0);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    for kind in ["exr", "patina-film"] {
        let one = bytes(&format!("one.{kind}"));
        assert!(one == bytes(&format!("three.{kind}")), "threads, {kind}");
        assert!(one == bytes(&format!("merged.{kind}")), "parts, {kind}");
    }
    let (channels, facts) = contents(&bench.path("one.exr"));
    for name in ["CryptoObject00.r", "CryptoObject03.a", "CryptoMaterial00.g"] {
        assert!(channels.contains(&format!("ViewLayer.{name}")), "{name}");
    }
    let of_ids = facts.iter().filter(|fact| fact.starts_with("cryptomatte/"));
    // Name, hash, conversion and manifest of both.
    assert_eq!(of_ids.count(), 8);
}

#[cfg(unix)]
#[test]
fn what_watch_writes_says_how_it_was_made() {
    use std::time::{Duration, Instant};

    if !device() {
        return;
    }
    let bench = Bench::new();
    let line = "render triangle.gltf --size 16x16 --spp 1 -o render.exr";
    bench.run(line).expect_code(0);
    let line = "watch triangle.gltf --size 16x16 --spp 1 -o watch.exr";
    let mut command = bench.command(line);
    let mut child = command
        .stdout(Stdio::null())
        .spawn()
        .expect("patina starts");
    let start = Instant::now();
    while !bench.path("watch.exr").exists() && start.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(50));
    }
    child.kill().expect("it is ours");
    child.wait().expect("it ends");
    let [by_render, by_watch] = ["render.exr", "watch.exr"].map(|name| contents(&bench.path(name)));
    assert_eq!(by_watch, by_render);
    assert!(by_watch.1.iter().any(|fact| fact == "device"));
}
