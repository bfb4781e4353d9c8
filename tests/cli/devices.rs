//! Several devices on one image, on the command line.

use super::*;

#[test]
fn lists_of_devices_are_checked_before_anything_is_rendered() {
    let bench = Bench::new();
    let refused = bench.run("render triangle.gltf --device native,no-such-device");
    // The answer lists what there is.
    let refused = refused.expect_error(1, "no-such-device");
    assert!(refused.stderr.contains(": native"), "{}", refused.stderr);
    for (list, because) in [
        ("native,native", "given twice"),
        ("native,", "empty"),
        ("native:0,native:1", "from 1 to 1024"),
    ] {
        bench
            .run(&format!("render triangle.gltf --device {list}"))
            .expect_error(2, because);
    }
    bench
        .run("view triangle.gltf --device native --device 1")
        .expect_error(2, "--device");
    assert_eq!(bench.files(), ["triangle.gltf"]);
}

#[test]
fn a_part_of_the_name_means_the_processor_too() {
    let bench = Bench::new();
    let line = "render triangle.gltf --size 8x8 --spp 1 --device Nativ -o a.png";
    let said = bench.run(line).expect_code(0).stdout;
    assert!(said.contains(" on native "), "{said}");
}

#[test]
fn two_processors_write_the_film_of_one() {
    let bench = Bench::new();
    let render = |flags: &str| {
        let line = format!("render triangle.gltf --size 97x61 --sample-range 5..45 {flags}");
        bench.run(&line).expect_code(0)
    };
    render("--device native:2 -o one.patina-film -o one.exr");
    let two = render(
        "--device native:1,native:1 --stats --stats-json s.json -o two.patina-film -o two.exr",
    );
    render("--device native:1 --device native:1 --layers depth -o layers.exr");
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    for kind in ["patina-film", "exr"] {
        let same = bytes(&format!("one.{kind}")) == bytes(&format!("two.{kind}"));
        assert!(same, "{kind}");
    }
    assert!(two.stdout.contains("ranges"), "{}", two.stdout);
    let stats = fs::read_to_string(bench.path("s.json")).expect("a file");
    let stats: serde_json::Value = serde_json::from_str(&stats).expect("JSON");
    assert_eq!(stats["samples_per_pixel_done"], 40);
    let devices = stats["devices"].as_array().expect("a list");
    assert_eq!(devices.len(), 2);
    let number = |of: &serde_json::Value, name: &str| of[name].as_f64().expect("a number");
    let share: f64 = devices.iter().map(|of| number(of, "share")).sum();
    assert!((share - 1.0).abs() < 1e-9, "{stats}");
    assert!(number(&devices[0], "samples_per_second") >= 0.0);
    assert!(devices[0]["failure"].is_null() && devices[0]["name"] == "native");
}

#[test]
fn all_devices_render_together() {
    let bench = Bench::new();
    let list = bench.run("devices").expect_code(0).stdout;
    assert!(list.contains("--device all"), "{list}");
    bench
        .run("render triangle.gltf --size 32x32 --spp 8 --device all -o a.png")
        .expect_code(0);
    assert!(bench.path("a.png").is_file());
}
