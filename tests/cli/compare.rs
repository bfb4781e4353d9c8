//! `patina compare` on the command line.

use super::*;

/// Writes a PNG of one grey.
pub(crate) fn grey(bench: &Bench, name: &str, [width, height]: [u32; 2], grey: u8) {
    let picture = image::RgbImage::from_pixel(width, height, image::Rgb([grey; 3]));
    picture
        .save(bench.path(name))
        .expect("the picture is written");
}

pub(crate) fn json(outcome: &Outcome) -> serde_json::Value {
    serde_json::from_str(&outcome.stdout).expect("it prints JSON")
}

#[test]
fn pictures_are_compared_in_figures_and_as_a_picture() {
    let bench = Bench::new();
    grey(&bench, "a.png", [40, 30], 128);
    grey(&bench, "b.png", [40, 30], 188);
    let text = bench.run("compare a.png b.png --diff d.png").expect_code(0);
    for wanted in [
        "40x30",
        "MSE",
        "relative MSE",
        "PSNR",
        "FLIP",
        "100.00 %",
        "wrote d.png",
    ] {
        assert!(text.stdout.contains(wanted), "{wanted}:\n{}", text.stdout);
    }
    let diff = image::open(bench.path("d.png")).expect("a picture");
    assert_eq!((diff.width(), diff.height()), (40, 30));
    let found = json(&bench.run("compare a.png b.png --json").expect_code(0));
    // sRGB 128 and 188 are 0.2159 and 0.5029 of linear light.
    let mse = found["mse"].as_f64().expect("a number");
    assert!((mse - 0.287_f64.powi(2)).abs() < 1e-4, "{mse}");
    let psnr = found["psnr"].as_f64().expect("a number");
    assert!(
        (psnr + 20.0 * (60.0_f64 / 255.0).log10()).abs() < 1e-3,
        "{psnr}"
    );
    assert_eq!(found["passed"], true);
    let same = json(&bench.run("compare a.png a.png --json").expect_code(0));
    assert_eq!(same["flip"], 0.0);
    assert_eq!(same["psnr"], serde_json::Value::Null);
}

#[test]
fn limits_of_a_comparison_are_an_exit_code() {
    let bench = Bench::new();
    grey(&bench, "a.png", [16, 16], 128);
    grey(&bench, "b.png", [16, 16], 140);
    let kept = "compare a.png b.png --max-flip 0.5 --max-mse 0.5 --max-relative-mse 0.5";
    bench.run(kept).expect_code(0);
    let flip = bench.run("compare a.png b.png --max-flip 0.001");
    let flip = flip.expect_error(1, "--max-flip 0.001");
    assert!(flip.stdout.contains("FLIP"), "the figures are told, too");
    let both = "compare a.png b.png --json --max-mse 1e-6 --max-relative-mse 1e-6";
    let both = bench.run(both).expect_error(1, "--max-relative-mse");
    assert!(both.stderr.contains("--max-mse"), "{}", both.stderr);
    assert_eq!(json(&both)["passed"], false);
    bench.run("compare a.png a.png --max-flip 0").expect_code(0);
}

#[test]
fn what_cannot_be_compared_is_named() {
    let bench = Bench::new();
    grey(&bench, "a.png", [16, 16], 128);
    grey(&bench, "small.png", [8, 16], 128);
    fs::write(bench.path("text.png"), "no picture").expect("written");
    let whole = fs::read(bench.path("a.png")).expect("written");
    fs::write(bench.path("cut.png"), &whole[..40]).expect("written");
    for (line, mentions) in [
        ("a.png small.png", "16x16 and 8x16"),
        ("a.png no.png", "no.png"),
        ("text.png a.png", "text.png"),
        ("a.png cut.png", "cut.png"),
        ("a.png a.png --layer depth", "depth"),
        ("a.png a.png --diff no/such/d.png", "does not exist"),
    ] {
        bench
            .run(&format!("compare {line}"))
            .expect_error(1, mentions);
    }
    for (line, mentions) in [
        ("a.png", "REFERENCE"),
        ("a.png a.png --diff d.exr", ".png"),
        ("a.png a.png --diff a.png", "input"),
        ("a.png a.png --max-flip -1", "--max-flip -1"),
    ] {
        let outcome = bench.run(&format!("compare {line}")).expect_code(2);
        assert!(outcome.stderr.contains(mentions), "{}", outcome.stderr);
    }
}

#[test]
fn layers_of_films_and_pictures_are_compared_by_name() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let render = "render triangle.gltf --size 33x17 --max-depth 2 --spp 3 --layers depth,normal --exr-float all";
    let outputs = "-o a.exr -o a.patina-film -o a.png";
    bench.run(&format!("{render} {outputs}")).expect_code(0);
    let far = "render triangle.gltf --size 33x17 --max-depth 2 --seed 7 --spp 3 -o far.exr";
    bench.run(far).expect_code(0);
    for line in [
        "a.exr a.patina-film --max-mse 0 --max-flip 0",
        "a.exr a.patina-film --layer depth --max-mse 0",
        "a.patina-film a.exr --layer ViewLayer.Normal --max-relative-mse 0",
        "a.exr far.exr --layer combined --max-mse 1",
        "a.png a.exr --max-flip 0.01",
    ] {
        bench.run(&format!("compare {line}")).expect_code(0);
    }
    bench
        .run("compare a.exr a.exr --layer albedo")
        .expect_error(1, "ViewLayer.Depth");
    bench
        .run("compare a.exr a.exr --layer depth --max-flip 1")
        .expect_error(1, "--max-mse");
}
