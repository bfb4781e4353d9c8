//! Pictures that don't fit the memory: rendered in pieces.

use std::time::{Duration, Instant};

use super::*;

/// Lit by a sky, so that it has noise.
const LOOK: &str = "environment = { color = [0.5, 0.6, 0.9] }\n[material.Glow]\nemission = [0.1, 0.1, 0.1]\nroughness = 0.4\n";
/// A surface that throws caustics, and a lamp.
const MIRROR: &str = "[light.Lamp]\ntype = \"point\"\nposition = [0.2, 0.3, 1.0]\nintensity = 10.0\n[material.Glow]\nmetallic = 1.0\nroughness = 0.1\n";
/// Layers of sums, of first values and of ids, some in 16 bits.
const LAYERS: &str = "--layers depth,normal,diffuse_direct,emission,crypto_object,samples";

fn sky() -> Bench {
    let bench = Bench::new();
    fs::write(bench.path("sky.look.toml"), LOOK).expect("written");
    bench
}

/// Little more memory than the smallest pieces of a picture take on this device, as a flag.
fn memory(bench: &Bench, line: &str) -> String {
    let refused = bench
        .run(&format!("{line} --memory 1K"))
        .expect_error(1, "more than --memory 1 MiB");
    let said = refused.stderr;
    let word = said.split_once("the render takes ").map(|(_, rest)| rest);
    let least = word.and_then(|rest| rest.split_once(" MiB")?.0.parse::<u32>().ok());
    let least = least.unwrap_or_else(|| panic!("no number of MiB: {said}"));
    format!("--memory {}M", least + 1)
}

#[test]
fn pictures_in_pieces_are_those_rendered_at_once() {
    if !device() {
        return;
    }
    let bench = sky();
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    let scene = "render triangle.gltf --look sky.look.toml --size 70x500 --spp 3";
    let all = format!("{scene} {LAYERS}");
    fs::write(bench.path("mirror.look.toml"), MIRROR).expect("written");
    let mirror = scene.replace("sky", "mirror");
    for (name, line) in [
        ("all", all.clone()),
        ("alone", format!("{scene} --transparent --part 2/3")),
        ("crop", format!("{all} --transparent --crop 3,5,61,481")),
        // What these know of the light is the same everywhere.
        (
            "cache",
            format!("{scene} --layers depth,albedo,samples --method cache"),
        ),
        ("draft", format!("{scene} --method draft --crop 3,5,61,481")),
        ("photons", format!("{mirror} --method photons")),
        (
            "both",
            format!("{mirror} --method cache+photons --crop 3,5,61,481"),
        ),
    ] {
        let line = format!("{line} -o {name}.exr -o {name}.png");
        let whole = bench.run(&line).expect_code(0).stdout;
        assert!(!whole.contains("pieces"), "{whole}");
        let [exr, png] = ["exr", "png"].map(|kind| bytes(&format!("{name}.{kind}")));
        let memory = memory(&bench, &line);
        let said = bench.run(&format!("{line} {memory}")).expect_code(0).stdout;
        assert!(said.contains(" pieces of "), "{said}");
        assert!(bytes(&format!("{name}.exr")) == exr, "{name}: {said}");
        let pixels = |png: &[u8]| image::load_from_memory(png).expect("a picture");
        let again = bytes(&format!("{name}.png"));
        assert!(pixels(&again) == pixels(&png), "{name}: {said}");
        assert!(!bench.files().iter().any(|file| file.contains("pieces")));
    }
    // One frame after the other: moments of a shutter, and light that is another one in each.
    for flags in [
        "--spp 8 --shutter 0.5 --layers depth",
        "--spp 2 --method cache",
    ] {
        let frames = format!("{scene} {flags} --turntable 2 -o f#.exr").replace("--spp 3 ", "");
        bench.run(&frames).expect_code(0);
        let whole = ["f0.exr", "f1.exr"].map(bytes);
        let memory = memory(&bench, &frames);
        for name in ["f0.exr", "f1.exr"] {
            fs::remove_file(bench.path(name)).expect("it was there");
        }
        let said = bench
            .run(&format!("{frames} {memory}"))
            .expect_code(0)
            .stdout;
        assert!(said.contains(" pieces of "), "{said}");
        assert!(["f0.exr", "f1.exr"].map(bytes) == whole, "{said}");
    }
}

#[test]
fn what_a_picture_is_judged_by_is_counted() {
    if !device() {
        return;
    }
    let bench = sky();
    let said = |flags: &str| {
        // A JPEG file isn't written in pieces.
        let line = "render triangle.gltf --look sky.look.toml --size 1000x1000 --spp 1 --memory 1K -o a.jpg";
        let refused = bench.run(&format!("{line} {flags}"));
        refused.expect_error(1, "more than --memory").stderr
    };
    let copies = |method: &str| {
        let said = said(&format!("--device native --method {method}"));
        let (before, _) = (said.split_once(" MiB for files")).expect("it is told");
        let word = before.rsplit_once(' ').map(|(_, word)| word.parse::<u32>());
        word.and_then(Result::ok).expect("a number")
    };
    // Two films of 80 bytes a pixel, in which nothing is written meanwhile.
    let (path, draft) = (copies("path"), copies("draft"));
    assert!((path + 100..path + 160).contains(&draft), "{path}, {draft}");
    // One of several devices has a renderer for it.
    let several = "--device native:1,native:1 --method";
    let films =
        |said: &str| [77, 153].map(|film| said.matches(&format!("film {film} MiB")).count());
    assert_eq!(films(&said(&format!("{several} path"))), [2, 0]);
    assert_eq!(films(&said(&format!("{several} draft"))), [1, 1]);
}

#[test]
fn a_picture_that_a_device_does_not_bind_is_refused_before_it_is_rendered() {
    let bench = Bench::new();
    let list = bench.run("devices").stdout;
    if !list.contains("llvmpipe") || !list.contains("128.0 MiB per storage binding") {
        eprintln!("skipped: no device with small bindings");
        return;
    }
    let line = "render triangle.gltf --device llvmpipe --size 4200x3000 --spp 1 -o a.jpg";
    let refused = bench.run(line).expect_error(1, "201600000 bytes");
    for word in ["can't be rendered in pieces", "JPEG"] {
        assert!(refused.stderr.contains(word), "{}", refused.stderr);
    }
}

/// Renders `a.exr` in pieces, and ends that from outside.
fn kill_after_two_pieces(bench: &Bench, line: &str) {
    let mut killed = bench.command(line).spawn().expect("patina starts");
    let second = bench.path("a.patina-pieces").join("00001.patina-film");
    let start = Instant::now();
    while !second.exists() && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    killed.kill().expect("it can be killed");
    killed.wait().expect("it ends");
    assert!(second.exists(), "it was killed in the middle");
}

#[test]
fn finished_pieces_are_taken_up() {
    if !device() {
        return;
    }
    let bench = sky();
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    let line = "render triangle.gltf --look sky.look.toml --size 100x800 --spp 48 -o a.exr";
    bench.run(line).expect_code(0);
    let whole = bytes("a.exr");
    let memory = memory(&bench, line);
    let line = format!("{line} {memory}");
    kill_after_two_pieces(&bench, &line);
    let folder = bench.path("a.patina-pieces");
    bench
        .run(&format!("{line} --resume --seed 1"))
        .expect_error(1, "seed");
    bench
        .run(&format!("{line} --resume").replace("--spp 48", "--spp 64"))
        .expect_error(1, "after 48 samples");
    fs::remove_file(bench.path("a.exr")).expect("it was there");
    let said = bench.run(&format!("{line} --resume")).expect_code(0).stdout;
    assert!(said.contains("pieces were there already"), "{said}");
    assert!(bytes("a.exr") == whole);
    assert!(!folder.exists(), "the picture is written");
    // Without --resume it begins anew, and what isn't a piece stays where it is.
    fs::create_dir(&folder).expect("a folder");
    // As another run does that is under way: the pieces of both would mix.
    let lock = fs::File::create(folder.join("lock")).expect("written");
    lock.lock().expect("nobody else has it");
    bench.run(&line).expect_error(1, "another render");
    drop(lock);
    fs::write(folder.join("00000.patina-film"), "old").expect("written");
    fs::write(folder.join("mine.txt"), "mine").expect("written");
    bench.run(&line).expect_code(0);
    assert!(bytes("a.exr") == whole);
    assert_eq!(fs::read_dir(&folder).expect("there").count(), 1);
}

/// The line that says how right a biased picture is.
fn bias(run: Outcome) -> String {
    let said = run.expect_code(0).stdout;
    let line = said.lines().find(|line| line.starts_with("biased: "));
    line.unwrap_or_else(|| panic!("nobody looked how right it is: {said}"))
        .to_owned()
}

#[test]
fn how_right_a_picture_is_shows_in_all_pieces_together() {
    if !device() {
        return;
    }
    let bench = sky();
    let bytes = |name: &str| fs::read(bench.path(name)).expect("it was written");
    let line = "render triangle.gltf --look sky.look.toml --size 100x800 --spp 32 --accuracy final -o a.exr";
    let memory = memory(&bench, line);
    let whole = bias(bench.run(line));
    let picture = bytes("a.exr");
    let line = format!("{line} {memory}");
    assert_eq!(bias(bench.run(&line)), whole);
    assert!(bytes("a.exr") == picture);
    // Pieces of a former run are looked at, too.
    kill_after_two_pieces(&bench, &line);
    assert_eq!(bias(bench.run(&format!("{line} --resume"))), whole);
    assert!(bytes("a.exr") == picture);
    let noise = line.replace("--spp 32", "--spp 256 --noise 0.1");
    bias(bench.run(&noise));
}

#[test]
fn limits_end_each_piece() {
    if !device() {
        return;
    }
    let bench = sky();
    let line = "render triangle.gltf --look sky.look.toml --size 48x400 -o a.png";
    let memory = memory(&bench, line);
    for (flags, ended) in [
        ("--noise 0.2", "ended by --noise 0.2"),
        ("--adaptive --noise 0.05", "ended by --noise 0.05"),
        ("--adaptive --spp 64", "on average"),
        ("--time 3s", "ended by --time 3s"),
    ] {
        let run = bench.run(&format!("{line} {memory} {flags}"));
        let said = run.expect_code(0).stdout;
        assert!(said.contains(" pieces of "), "{said}");
        let summary = said
            .lines()
            .find_map(|line| line.strip_prefix("relative error "));
        let summary = summary.unwrap_or_else(|| panic!("no error of the whole: {said}"));
        assert!(summary.contains(ended), "{said}");
        let error = summary
            .split(' ')
            .next()
            .and_then(|n| n.parse::<f64>().ok());
        if let Some((_, limit)) = ended.split_once("--noise ") {
            // How bright the picture is, a few samples have told.
            let most = 1.1 * limit.parse::<f64>().expect("a number");
            assert!(error.is_some_and(|error| error <= most), "{said}");
        }
    }
}

#[test]
fn what_needs_the_whole_picture_is_refused() {
    if !device() {
        return;
    }
    let bench = sky();
    let line = "render triangle.gltf --look sky.look.toml --size 70x500 --spp 1";
    let memory = memory(&bench, &format!("{line} -o a.png"));
    for (flags, because) in [
        ("-o a.jpg", "JPEG"),
        ("-o a.patina-film", ".patina-film is written as a whole"),
        ("-o a.png --refresh", "--refresh"),
        (
            "-o a.png --method draft --turntable 2 --shutter 0.5 --motion-samples 1",
            "for each moment",
        ),
        ("-o a.png --device native:1,native:1", "a single device"),
    ] {
        bench
            .run(&format!("{line} {flags} {memory}"))
            .expect_error(1, because);
    }
    // However much memory there is.
    let large = "render triangle.gltf --size 16384x16384 --spp 1 --memory 9000G -o a.jpg";
    bench.run(large).expect_error(1, "rendered at once");
    assert!(!bench.files().iter().any(|file| file.contains("pieces")));
}
