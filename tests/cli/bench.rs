//! `patina bench` on the command line, and its reports.

use super::*;

#[test]
fn textures_are_compared_with_plain_gray() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let textures = concat!(env!("CARGO_MANIFEST_DIR"), "/user_textures");
    let outcome = bench
        .run(&format!(
            "bench textures --size 16x16 --spp 4 --runs 1 --max-depth 1 --ao-rays 4 --json t.json --textures {textures}"
        ))
        .expect_code(0);
    assert!(outcome.stdout.contains("over grey"), "{}", outcome.stdout);
    let text = fs::read_to_string(bench.path("t.json")).expect("it was written");
    let report: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
    let rows = report["results"].as_array().expect("there are rows");
    assert_eq!(rows.len(), 6);
    for row in rows {
        assert!(row["ms_per_spp"].as_f64() > Some(0.0), "{row}");
        assert!(row["increase_spread"].as_f64() >= Some(0.0), "{row}");
        // What an edit costs is a buffer write in one form, a kernel in the other.
        let created = u64::from(row["mode"] == "inlined" && row["texture"] != "gray");
        assert_eq!(row["pipelines_created"], created, "{row}");
    }
    // The built-in model is neither tiny nor all there is.
    let coverage = report["coverage"].as_f64().expect("a number");
    assert!((0.05..0.6).contains(&coverage), "{coverage}");
}

#[cfg(target_os = "linux")]
#[test]
fn without_a_driver_the_processor_compares_what_it_can() {
    let bench = Bench::new();
    let textures = concat!(env!("CARGO_MANIFEST_DIR"), "/user_textures");
    let run = |modes: &str| {
        let line = format!(
            "bench textures {modes} --size 16x16 --spp 2 --runs 1 --max-depth 1 --ao-rays 4 --textures {textures}"
        );
        let mut command = bench.command(&line);
        // As where none is installed.
        command.env("VK_DRIVER_FILES", "/dev/null");
        Outcome::of(command.output().expect("patina starts"), &line)
    };
    for modes in ["", "--modes stack,rayquery"] {
        let told = run(modes).expect_code(0).stdout;
        assert!(told.contains("over grey"), "{told}");
        let absent = told.lines().find(|line| line.starts_with("rayquery:"));
        assert!(
            absent.is_some_and(|line| line.contains("no ray queries")),
            "{told}"
        );
    }
    run("--modes rayquery").expect_error(1, "no device with ray queries");
}

#[test]
fn reports_of_textures_are_pages_figures_and_charts() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let textures = concat!(env!("CARGO_MANIFEST_DIR"), "/user_textures");
    bench
        .run(&format!(
            "bench textures --scene triangle.gltf --material Glow --modes stack --size 16x16 --spp 4 --runs 1 \
             --ao-rays 1 --sweep bounces -o r.html -o r.json -o r.svg --textures {textures}"
        ))
        .expect_code(0);
    let read = |name: &str| fs::read_to_string(bench.path(name)).expect("it was written");
    let (page, chart) = (read("r.html"), read("r.svg"));
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("data:image/jpeg;base64,"));
    assert!(chart.starts_with("<svg") && page.contains(chart.trim()));
    let report: serde_json::Value = serde_json::from_str(&read("r.json")).expect("it is JSON");
    let points = report["sweeps"][0]["points"].as_array().expect("a list");
    let rows: Vec<_> = (points.iter())
        .map(|point| (point["value"].as_f64(), point["mode"].as_str()))
        .collect();
    let expected = [1.0, 2.0, 4.0, 8.0, 16.0].map(|value| (Some(value), Some("stack")));
    assert_eq!(rows, expected);
    for point in points {
        for name in ["ms_per_spp", "gray_ms_per_spp"] {
            assert!(point[name].as_f64() > Some(0.0), "{point}");
        }
    }
    // A triangle with corners at the middle of a side: its half of what the lens sees, by its size and distance.
    let side = 2.0 * 3.0 * (0.45_f64).tan();
    let coverage = report["coverage"].as_f64().expect("a number");
    let expected = 2.0 / (side * side);
    assert!(
        (coverage - expected).abs() < 0.03,
        "{coverage}, expected {expected}"
    );
}

#[test]
fn a_model_is_inserted_to_be_textured() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    fs::write(bench.path("model.gltf"), TRIANGLE).expect("the model is written");
    let textures = concat!(env!("CARGO_MANIFEST_DIR"), "/user_textures");
    let outcome = bench
        .run(&format!(
            "bench textures --scene triangle.gltf --insert model.gltf --modes stack --size 16x16 --spp 4 --runs 1 \
             --ao-rays 1 -o r.json --textures {textures}"
        ))
        .expect_code(0);
    assert!(
        outcome.stdout.contains("model covers"),
        "{}",
        outcome.stdout
    );
    let text = fs::read_to_string(bench.path("r.json")).expect("it was written");
    let report: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
    assert!(report["coverage"].as_f64() > Some(0.03), "{text}");
    assert_eq!(report["triangles"], 2);
}

#[test]
fn senseless_measurements_of_textures_are_refused_with_a_remedy() {
    let bench = Bench::new();
    for (line, remedy) in [
        ("--modes fast", "inlined"),
        ("--sweep depth", "bounces"),
        ("--ao-rays 0", "from 1 to 255"),
        ("--spp 1", "from 2 to"),
        ("-o report.pdf", ".html"),
        ("--scene triangle.gltf", "--material NAME"),
        ("--insert triangle.gltf", "--scene"),
    ] {
        bench
            .run(&format!("bench textures {line}"))
            .expect_error(2, remedy);
    }
    if device() {
        bench
            .run("bench textures --scene triangle.gltf --material Glov --size 8x8")
            .expect_error(1, "did you mean `Glow`?");
        bench
            .run("bench textures --scene triangle.gltf --insert none.glb --size 8x8")
            .expect_error(1, "none.glb");
    }
}

#[test]
fn whole_renders_are_measured_in_turn() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    fs::write(bench.path("other.gltf"), TRIANGLE).expect("the scene is written");
    let outcome = bench
        .run("bench render triangle.gltf other.gltf --size 16x16 --spp 2 --runs 2 --json b.json")
        .expect_code(0);
    for wanted in [
        "other.gltf",
        "samples/s",
        "closest, Mrays/s",
        "bytes per path",
    ] {
        let text = &outcome.stdout;
        assert!(text.contains(wanted), "{wanted}:\n{text}");
    }
    let text = fs::read_to_string(bench.path("b.json")).expect("a file");
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(report["runs"], 2);
    assert!(report["device"]["driver"].is_string());
    let scenes = report["scenes"].as_array().expect("a list");
    assert_eq!(scenes.len(), 2);
    for scene in scenes {
        assert_eq!(scene["triangles"], 1);
        assert_eq!(scene["samples"], 16 * 16 * 2);
        assert_eq!(scene["invalid_samples"], 0);
        // One camera ray for each sample, and what the triangle scatters.
        assert!(scene["closest"]["rays"].as_u64() >= Some(512), "{scene}");
        let figures = [
            &scene["samples_per_second"],
            &scene["closest"]["mrays_per_second"],
        ];
        for figure in figures {
            let part = |name: &str| figure[name].as_f64().expect("a number");
            assert!(
                part("low") > 0.0 && part("low") <= part("median"),
                "{scene}"
            );
            assert!(part("median") <= part("high"), "{scene}");
        }
        let passes = scene["passes"].as_array().expect("a list");
        for wanted in ["raygen", "traverse_closest", "brdf", "accumulate"] {
            assert!(passes.iter().any(|pass| pass["name"] == wanted), "{scene}");
        }
        assert!(scene["path_bytes"]["rays"].as_u64() >= Some(96), "{scene}");
    }
}

#[test]
fn a_reference_is_not_overwritten_however_it_is_spelled() {
    let bench = Bench::new();
    fs::write(bench.path("ref.exr"), "a picture").expect("written");
    for written in ["--json ./ref.exr", "--json no/../ref.exr"] {
        fs::create_dir_all(bench.path("no")).expect("a folder");
        bench
            .run(&format!("bench methods --reference ref.exr {written}"))
            .expect_error(2, "input");
    }
    let kept = fs::read_to_string(bench.path("ref.exr")).expect("it is there");
    assert_eq!(kept, "a picture");
}

#[test]
fn a_reference_is_a_picture_of_linear_light() {
    let bench = Bench::new();
    super::compare::grey(&bench, "ref.png", [8, 8], 128);
    // Whatever its name says.
    fs::copy(bench.path("ref.png"), bench.path("ref.exr")).expect("copied");
    for name in ["ref.png", "ref.exr"] {
        bench
            .run(&format!("bench methods --size 8x8 --reference {name}"))
            .expect_error(1, "PNG files hold what a screen shows");
    }
}

#[test]
fn a_comparison_of_textures_is_written_before_its_sweeps() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let textures = concat!(env!("CARGO_MANIFEST_DIR"), "/user_textures");
    // A driver may be compiling for a sweep when a signal comes, and isn't waited for then.
    let mut command = bench.command(&format!(
        "bench textures --scene triangle.gltf --material Glow --modes stack --size 16x16 --spp 4 --runs 1 \
         --ao-rays 1 --sweep bounces,ao -o r.json --textures {textures}"
    ));
    command.stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().expect("patina starts");
    let lines = std::io::BufReader::new(child.stdout.take().expect("piped"));
    let mut told = std::io::BufRead::lines(lines).map_while(Result::ok);
    // The first sweep is done, the second isn't.
    let is_begun = told.any(|line| line.contains("most scattering points"));
    child.kill().expect("killed");
    child.wait().expect("it ends");
    assert!(is_begun, "it has ended before");
    let text = fs::read_to_string(bench.path("r.json")).expect("it was written");
    let report: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
    assert!(
        report["results"]
            .as_array()
            .is_some_and(|rows| !rows.is_empty())
    );
}

#[cfg(unix)]
#[test]
fn measurements_that_are_interrupted_give_what_there_is() {
    let bench = Bench::new();
    // The first picture is done in no time, the second never.
    let line = "bench scaling --device native:1 --threads 1 --sizes 8,512 --tiles 8 --spp 1024 --runs 1 --minutes 9999 \
                -o s.json";
    let mut command = bench.command(line);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("patina starts");
    let lines = std::io::BufReader::new(child.stderr.take().expect("piped"));
    let mut told = std::io::BufRead::lines(lines).map_while(Result::ok);
    let is_begun = told.any(|line| line.contains("threads, 512x512"));
    assert!(is_begun, "it has ended before");
    assert!(kill(&["-INT", &child.id().to_string()]));
    // What else it says isn't to fill the pipe.
    let rest: Vec<String> = told.collect();
    let status = child.wait().expect("it ends");
    assert_eq!(status.code(), Some(130), "{rest:?}");
    let text = fs::read_to_string(bench.path("s.json")).expect("it was written");
    let report: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
    assert_eq!(report["threads"][0]["side"], 8);
    assert_eq!(report["left_out"][0]["reason"], "interrupted");
}

#[test]
fn a_device_that_is_not_there_is_found_before_anything_is_measured() {
    let ended = Bench::new().run("bench scaling --device no-such-device");
    let told = ended.expect_error(1, "no-such-device").stderr;
    assert!(!told.contains("measuring"), "{told}");
}
