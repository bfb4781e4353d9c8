//! `--denoise` on the command line.

use super::*;

use exr::prelude::{ReadChannels as _, ReadLayers as _};

#[test]
fn what_denoises_is_looked_for_before_the_scene_is_read() {
    let bench = Bench::new();
    for line in [
        "render no/such.glb --denoise",
        "merge no.patina-film -o a.exr --denoise",
    ] {
        let mut command = bench.command(line);
        command.env("OIDN_DIR", bench.path(""));
        let outcome = Outcome::of(command.output().expect("patina starts"), line);
        outcome.expect_error(1, "pyoidn");
    }
    // Films take no denoised picture.
    let line = "render no/such.glb --denoise -o a.patina-film";
    let mut command = bench.command(line);
    command.env("OIDN_DIR", bench.path(""));
    let outcome = Outcome::of(command.output().expect("patina starts"), line);
    outcome.expect_error(1, "no/such.glb");
}

/// The channels of an EXR file by name.
fn channels(path: &Path) -> std::collections::BTreeMap<String, Vec<f32>> {
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level();
    let read = read.all_channels().first_valid_layer().all_attributes();
    let image = read.from_file(path).expect("an EXR file");
    let list = image.layer_data.channel_data.list.into_iter();
    list.map(|channel| {
        let values = channel.sample_data.values_as_f32().collect();
        (channel.name.to_string(), values)
    })
    .collect()
}

#[test]
fn a_denoised_picture_is_the_same_each_time_and_keeps_the_noisy_one() {
    if !device() {
        return;
    }
    if std::env::var_os("OIDN_DIR").is_none() {
        eprintln!(
            "skipped: OIDN_DIR doesn't say where Open Image Denoise is (`pip install pyoidn`)"
        );
        return;
    }
    let bench = Bench::new();
    let render = "render triangle.gltf --size 64x48 --max-depth 2 --spp 2";
    for line in [
        "--layers depth -o noisy.exr -o noisy.png",
        "--layers depth --denoise -o a.exr -o a.png -o a.patina-film",
        "--layers depth --denoise -o b.exr",
        "--denoise -o alone.exr",
    ] {
        bench.run(&format!("{render} {line}")).expect_code(0);
    }
    bench
        .run("merge a.patina-film --denoise -o merged.exr")
        .expect_code(0);
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    assert!(bytes("a.exr") == bytes("b.exr"), "the same each time");
    assert!(bytes("a.png") != bytes("noisy.png"));
    let (noisy, clean) = (
        channels(&bench.path("noisy.exr")),
        channels(&bench.path("a.exr")),
    );
    let names: Vec<_> = clean
        .keys()
        .map(|name| name.trim_start_matches("ViewLayer."))
        .collect();
    let expected = [
        "Combined.B",
        "Combined.G",
        "Combined.R",
        "Depth.Z",
        "Noisy Image.B",
        "Noisy Image.G",
        "Noisy Image.R",
    ];
    assert_eq!(names, expected);
    assert_eq!(clean["ViewLayer.Depth.Z"], noisy["ViewLayer.Depth.Z"]);
    assert_eq!(
        clean["ViewLayer.Noisy Image.G"],
        noisy["ViewLayer.Combined.G"]
    );
    assert_ne!(clean["ViewLayer.Combined.G"], noisy["ViewLayer.Combined.G"]);
    let merged = channels(&bench.path("merged.exr"));
    assert_eq!(
        merged["ViewLayer.Combined.G"],
        clean["ViewLayer.Combined.G"]
    );
    assert_eq!(channels(&bench.path("alone.exr")).len(), 6);
}
