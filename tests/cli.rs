//! The command line as users and scripts meet it: exit codes, messages, files.
//!
//! Each test starts the real program. Tests that render need a device; where there is none they are skipped with a
//! notice, or fail where `PATINA_REQUIRE_DEVICE` is set, as `cargo xtask test` does.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

#[path = "cli/bake.rs"]
mod bake;
#[path = "cli/bench.rs"]
mod bench;
#[path = "cli/compare.rs"]
mod compare;
#[path = "cli/denoise.rs"]
mod denoise;
#[path = "cli/devices.rs"]
mod devices;
#[cfg(unix)]
#[path = "cli/endings.rs"]
mod endings;
#[path = "cli/farm.rs"]
mod farm;
#[path = "cli/frames.rs"]
mod frames;
#[path = "cli/import.rs"]
mod import;
#[path = "cli/info.rs"]
mod info;
#[path = "cli/layers.rs"]
mod layers;
#[path = "cli/limits.rs"]
mod limits;
#[path = "cli/lost_work.rs"]
mod lost_work;
#[path = "cli/overrides.rs"]
mod overrides;
#[path = "cli/parts_of_pictures.rs"]
mod parts_of_pictures;
#[path = "cli/pieces.rs"]
mod pieces;

/// One triangle that glows, facing +Z; no other file is needed.
const TRIANGLE: &str = r#"{
  "asset": { "version": "2.0" },
  "scene": 0,
  "scenes": [{ "nodes": [0, 1] }],
  "nodes": [{ "mesh": 0 }, { "name": "Front", "camera": 0, "translation": [0, 0, 3] }],
  "cameras": [{ "name": "Front", "type": "perspective", "perspective": { "yfov": 0.9, "znear": 0.1 } }],
  "materials": [{ "name": "Glow", "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": { "metallicFactor": 0 } }],
  "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
  "accessors": [{
    "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]
  }],
  "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
  "buffers": [{
    "byteLength": 36,
    "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"
  }]
}"#;

/// A folder with `triangle.gltf` in which the program is run.
struct Bench {
    dir: TempDir,
}

impl Bench {
    fn new() -> Self {
        let dir = tempfile::tempdir().expect("a temporary folder");
        fs::write(dir.path().join("triangle.gltf"), TRIANGLE).expect("the scene is written");
        Self { dir }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_patina"));
        command
            .args(line.split_whitespace())
            .current_dir(&self.dir)
            .env("PATINA_CACHE", "off")
            .stdin(Stdio::null());
        command
    }

    fn run(&self, line: &str) -> Outcome {
        Outcome::of(self.command(line).output().expect("patina starts"), line)
    }

    /// Names in the folder, sorted.
    fn files(&self) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(&self.dir)
            .expect("the folder is readable")
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .into_string()
                    .expect("UTF-8")
            })
            .collect();
        names.sort();
        names
    }
}

/// Sends a signal, with the words of `kill`; whether that was possible. The one of the shell, as not every system has a program of that
/// name.
#[cfg(unix)]
fn kill(words: &[&str]) -> bool {
    let status = Command::new("sh")
        .args(["-c", "kill \"$@\"", "sh"])
        .args(words)
        .stderr(Stdio::null())
        .status();
    status.expect("sh starts").success()
}

struct Outcome {
    line: String,
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Outcome {
    fn of(output: Output, line: &str) -> Self {
        Self {
            line: line.to_owned(),
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    #[track_caller]
    fn expect_code(self, code: i32) -> Self {
        assert_eq!(
            self.code,
            Some(code),
            "patina {}\nstdout: {}\nstderr: {}",
            self.line,
            self.stdout,
            self.stderr
        );
        self
    }

    #[track_caller]
    fn expect_error(self, code: i32, mentions: &str) -> Self {
        let this = self.expect_code(code);
        assert!(
            this.stderr.contains("error:") && this.stderr.contains(mentions),
            "patina {}: the error should mention '{mentions}':\n{}",
            this.line,
            this.stderr
        );
        assert!(!this.stderr.contains("panicked"), "{}", this.stderr);
        this
    }
}

/// Whether this machine can render; says so where it can't.
fn device() -> bool {
    let found = Bench::new().run("devices").code == Some(0);
    if !found {
        assert!(
            std::env::var_os("PATINA_REQUIRE_DEVICE").is_none(),
            "no device can render, but PATINA_REQUIRE_DEVICE is set"
        );
        eprintln!("skipped: no device can render (`cargo xtask test` installs one)");
    }
    found
}

#[test]
fn help_shows_examples_and_exit_codes() {
    let bench = Bench::new();
    let help = bench.run("render --help").expect_code(0);
    for wanted in [
        "Examples:",
        "-o helmet.exr",
        "--max-depth",
        "--stats-json",
        "Exit codes: 0",
    ] {
        assert!(help.stdout.contains(wanted), "{wanted}:\n{}", help.stdout);
    }
    let help = bench.run("--help").expect_code(0);
    assert!(help.stdout.contains("patina devices"), "{}", help.stdout);
    let version = bench.run("--version").expect_code(0);
    assert!(version.stdout.contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn a_view_is_that_of_the_line_or_the_look() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let look = "[view]\ntransform = \"agx\"\nexposure = 1.0\nwhite_balance = [4000, 0]\n";
    std::fs::write(bench.path("view.look.toml"), look).expect("written");
    let line = "render triangle.gltf --size 16x12 --spp 2 -o";
    let said = "--view agx --exposure 1 --white-balance 4000,0";
    for line in [
        format!("{line} plain.png"),
        format!("{line} said.png {said}"),
        format!("{line} look.png -o sums.patina-film --look view.look.toml"),
        format!("{line} both.png --look view.look.toml --view aces2"),
        "merge sums.patina-film --look view.look.toml -o merged.png".to_owned(),
        format!("merge sums.patina-film {said} -o merged-said.png"),
    ] {
        bench.run(&line).expect_code(0);
    }
    let picture = |name: &str| std::fs::read(bench.path(name)).expect(name);
    let said = picture("said.png");
    assert!(said != picture("plain.png"));
    for same in ["look.png", "merged.png", "merged-said.png"] {
        assert!(picture(same) == said, "{same}");
    }
    assert!(picture("both.png") != said);
}

#[test]
fn wrong_usage_is_code_2_and_says_what_is_right() {
    let bench = Bench::new();
    for (line, mentions) in [
        ("render", "<SCENE>"),
        ("paint", "unrecognized subcommand"),
        ("render triangle.gltf --bogus", "--bogus"),
        ("render triangle.gltf --size 0x0", "width is zero"),
        ("render triangle.gltf --size 1x", "height is missing"),
        ("render triangle.gltf --size 99999999x2", "exceeds"),
        ("render triangle.gltf --size -1", "--size -1"),
        (
            "watch triangle.gltf --size 16384x16384",
            "more than the 67108864",
        ),
        ("render triangle.gltf --spp 0", "--spp 0"),
        ("render triangle.gltf --spp -1", "--spp -1"),
        ("render triangle.gltf --spp 1e3", "whole number"),
        ("render triangle.gltf --max-depth 0", "--max-depth 0"),
        ("render triangle.gltf --seed x", "--seed x"),
        ("render triangle.gltf --exposure nan", "--exposure nan"),
        ("render triangle.gltf --view agxx", "khronos-neutral"),
        (
            "render triangle.gltf --white-balance 10",
            "--white-balance 10",
        ),
        ("render triangle.gltf -o picture.gif", ".exr"),
        ("render triangle.gltf -o picture", ".exr"),
        ("render triangle.gltf -o a.png -o a.png", "twice"),
        ("render triangle.gltf --stats-json triangle.gltf", "input"),
        ("bench", "traverse"),
        ("bench render --runs 0", "--runs 0"),
    ] {
        let outcome = bench.run(line).expect_code(2);
        assert!(
            outcome.stderr.contains(mentions),
            "patina {line}: should mention '{mentions}':\n{}",
            outcome.stderr
        );
        assert!(outcome.stderr.contains("--help") || line == "bench");
    }
    assert_eq!(bench.files(), ["triangle.gltf"], "nothing may be written");
}

#[test]
fn usage_is_judged_before_the_scene_is_read() {
    Bench::new()
        .run("render no/such.glb -o picture.gif")
        .expect_error(2, "picture.gif");
}

#[test]
fn an_output_that_cannot_be_written_is_found_before_the_scene_is_read() {
    let bench = Bench::new();
    fs::create_dir(bench.path("taken.png")).expect("a folder");
    for (output, mentions) in [
        ("no/such/dir/x.png", "does not exist"),
        ("triangle.gltf/x.exr", "cannot write"),
        ("taken.png", "is a folder"),
    ] {
        bench
            .run(&format!("render no/such.glb -o {output}"))
            .expect_error(1, mentions);
        bench
            .run(&format!("render no/such.glb --stats-json {output}"))
            .expect_error(1, mentions);
    }
    // Even root can make no files there.
    if Path::new("/proc/self").is_dir() {
        bench
            .run("render no/such.glb -o /proc/x.png")
            .expect_error(1, "/proc/x.png");
    }
}

#[test]
fn missing_inputs_are_code_1_and_named() {
    let bench = Bench::new();
    bench
        .run("render no/such.glb")
        .expect_error(1, "no/such.glb");
    bench
        .run("render triangle.gltf --look no.look.toml")
        .expect_error(1, "no.look.toml");
    bench
        .run("render triangle.gltf --textures no/folder")
        .expect_error(1, "no/folder");
    bench
        .run("bench traverse no/such.glb")
        .expect_error(1, "no/such.glb");
    bench
        .run("bench render no/such.glb")
        .expect_error(1, "no/such.glb");
    bench.run("render .").expect_error(1, "");
    assert_eq!(bench.files(), ["triangle.gltf"], "nothing may be written");
}

#[test]
fn a_scene_that_is_no_gltf_is_code_1_and_named() {
    let bench = Bench::new();
    for (name, content) in [
        ("empty.gltf", &b""[..]),
        ("text.gltf", b"bad: this is not glTF"),
        ("cut.glb", b"glTF\x02\x00\x00\x00\xff\xff"),
        ("zeros.glb", &[0; 4096]),
    ] {
        fs::write(bench.path(name), content).expect("a file");
        bench.run(&format!("render {name}")).expect_error(1, name);
    }
}

#[test]
fn an_unknown_camera_is_answered_with_those_there_are() {
    Bench::new()
        .run("render triangle.gltf --camera Roof")
        .expect_error(1, "Front");
}

#[test]
fn an_unknown_device_is_code_1() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    bench
        .run("render triangle.gltf --device no-such-device")
        .expect_error(1, "no-such-device");
    bench
        .run("render triangle.gltf --device 4096")
        .expect_error(1, "4096");
}

#[test]
fn devices_lists_numbers_names_and_limits() {
    if !device() {
        return;
    }
    let list = Bench::new().run("devices").expect_code(0).stdout;
    assert!(list.starts_with("0: "), "{list}");
    assert!(list.contains("per storage binding"), "{list}");
}

#[test]
fn a_render_writes_every_output_and_nothing_else() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let outcome = bench
        .run("render triangle.gltf --size 48x32 --spp 4 -o a.png -o b.exr --stats --stats-json s.json --camera Front")
        .expect_code(0);
    assert_eq!(
        bench.files(),
        ["a.png", "b.exr", "s.json", "triangle.gltf"],
        "no temporary file may stay"
    );
    for wanted in [
        "wrote a.png",
        "wrote b.exr",
        "Mrays/s",
        "samples/s",
        "pipelines",
    ] {
        assert!(
            outcome.stdout.contains(wanted),
            "{wanted}:\n{}",
            outcome.stdout
        );
    }
    let drawing: Vec<_> = outcome.stderr.matches(['\r', '\x1b']).collect();
    assert!(drawing.is_empty(), "no bar where stderr is no terminal");

    let picture = image::open(bench.path("a.png")).expect("a PNG").to_rgb8();
    assert_eq!(picture.dimensions(), (48, 32));
    assert_eq!(picture.get_pixel(24, 18).0, [255; 3], "the triangle glows");
    assert_eq!(picture.get_pixel(0, 0).0, [0; 3], "around it is nothing");

    let stats = fs::read_to_string(bench.path("s.json")).expect("a file");
    let stats: serde_json::Value = serde_json::from_str(&stats).expect("JSON");
    assert_eq!(stats["width"], 48);
    assert_eq!(stats["samples_per_pixel_done"], 4);
    assert!(
        stats["stats"]["pipelines_created"]
            .as_u64()
            .is_some_and(|n| n > 0)
    );
}

#[test]
fn a_texture_that_gives_no_number_is_named_once() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let write = |name: &str, text: &str| fs::write(bench.path(name), text).expect("written");
    let broken =
        "fn userProc() -> vec3f { return vec3f(1.0 / floor(0.0 * readAttr(WorldPos).x)); }\n";
    write("broken.wgsl", broken);
    let look = "[node.glow]\ntexture = 'broken'\n[material.Glow]\nemission = 'glow'\n";
    write("broken.look.toml", look);
    let line = "render triangle.gltf --look broken.look.toml --textures . --size 16x16 --spp 4 --stats-json s.json";
    let outcome = bench.run(line).expect_code(0);
    let named = "node `glow` (texture `broken`)";
    assert_eq!(
        outcome.stderr.matches(named).count(),
        1,
        "{}",
        outcome.stderr
    );
    assert_eq!(
        outcome.stderr.matches("warning").count(),
        1,
        "{}",
        outcome.stderr
    );
    let stats = fs::read_to_string(bench.path("s.json")).expect("a file");
    let stats: serde_json::Value = serde_json::from_str(&stats).expect("JSON");
    let stats = &stats["stats"];
    assert_eq!(stats["non_finite_node"]["node"], "glow");
    assert_eq!(stats["non_finite_node"]["texture"], "broken");
    for count in ["non_finite_hits", "invalid_samples"] {
        assert!(stats[count].as_u64().is_some_and(|n| n > 0), "{count}");
    }
}

#[test]
fn without_outputs_the_picture_is_named_after_the_scene() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    bench
        .run("render triangle.gltf --size 8x8 --spp 1")
        .expect_code(0);
    assert_eq!(bench.files(), ["triangle-render.png", "triangle.gltf"]);
}

#[test]
fn the_same_seed_gives_the_same_files() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    const KINDS: [&str; 4] = ["exr", "png", "jpg", "patina-film"];
    // The names of inputs and outputs are in the files, or not: outputs differ in their folder.
    for (folder, seed, threads) in [("a", 7, "1"), ("b", 7, "2"), ("c", 7, "5"), ("d", 8, "2")] {
        fs::create_dir(bench.path(folder)).expect("a folder");
        let outputs = KINDS.map(|kind| format!("-o {folder}/x.{kind}")).join(" ");
        let line = format!("render triangle.gltf --size 33x31 --spp 3 --seed {seed} {outputs}");
        let threads = ["RAYON_NUM_THREADS", "LP_NUM_THREADS"].map(|name| (name, threads));
        let output = bench.command(&line).envs(threads).output();
        Outcome::of(output.expect("patina starts"), &line).expect_code(0);
    }
    let bytes = |folder, kind| {
        let path = bench.path(folder).join(format!("x.{kind}"));
        fs::read(path).expect("it was written")
    };
    for kind in KINDS {
        assert!(bytes("a", kind) == bytes("b", kind), "{kind}");
        assert!(bytes("a", kind) == bytes("c", kind), "{kind}");
        assert!(bytes("a", kind) != bytes("d", kind), "{kind}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_writes_what_has_been_rendered() {
    use std::thread::sleep;
    use std::time::Duration;

    if !device() {
        return;
    }
    // How long a machine takes to get to the first sample is unknown: wait longer until it worked.
    for seconds in [3, 10, 40] {
        let bench = Bench::new();
        let line = "render triangle.gltf --size 512x512 --spp 1000000 -o a.png";
        let child = bench
            .command(line)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("patina starts");
        sleep(Duration::from_secs(seconds));
        assert!(
            kill(&["-INT", &child.id().to_string()]),
            "the render must still be running"
        );
        let output = child.wait_with_output().expect("patina ends");
        let outcome = Outcome::of(output, line);
        assert_eq!(outcome.code, Some(130), "{}", outcome.stderr);
        if bench.path("a.png").exists() {
            assert!(outcome.stderr.contains("interrupted"), "{}", outcome.stderr);
            assert_eq!(bench.files(), ["a.png", "triangle.gltf"]);
            return;
        }
        assert_eq!(
            bench.files(),
            ["triangle.gltf"],
            "no sample: nothing written"
        );
    }
    panic!("Ctrl-C 40 s into a render wrote nothing");
}

#[test]
fn parts_of_a_picture_are_merged_to_exactly_the_whole() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let render = |flags: &str| {
        bench.run(&format!(
            "render triangle.gltf --size 33x17 --max-depth 2 {flags}"
        ))
    };
    render("--spp 11 -o whole.png -o whole.exr -o whole.patina-film").expect_code(0);
    for (name, range) in [("a", "0..2"), ("b", "2..9"), ("c", "9..11"), ("d", "8..10")] {
        render(&format!("--sample-range {range} -o {name}.patina-film")).expect_code(0);
    }
    render("--sample-range 9..11 --seed 1 -o other.patina-film").expect_code(0);
    let merged = bench
        .run("merge c.patina-film a.patina-film -o ac.patina-film")
        .expect_code(0);
    assert!(merged.stdout.contains("0..2, 9..11: 4 per pixel"));
    bench
        .run("merge ac.patina-film b.patina-film -o merged.exr -o merged.patina-film -o m.png")
        .expect_code(0);
    let bytes = |name| fs::read(bench.path(name)).expect("it was written");
    assert!(bytes("whole.png") == bytes("m.png"));
    assert!(bytes("whole.exr") == bytes("merged.exr"));
    assert!(bytes("whole.patina-film") == bytes("merged.patina-film"));

    let whole = bytes("c.patina-film");
    fs::write(bench.path("short.patina-film"), &whole[..whole.len() - 1]).expect("written");
    let mut changed = whole;
    let middle = changed.len() / 2;
    changed[middle] ^= 1;
    fs::write(bench.path("changed.patina-film"), changed).expect("written");
    for (parts, mentions) in [
        ("a b d c", "samples 8..9 are in two of the partial renders"),
        ("a b other", "seed is 1, but in the parts before it 0"),
        ("a short", "is damaged"),
        ("a changed", "checksum"),
        ("a missing", "missing.patina-film"),
    ] {
        let parts: String = parts
            .split(' ')
            .map(|part| format!("{part}.patina-film "))
            .collect();
        bench
            .run(&format!("merge {parts} -o refused.exr"))
            .expect_error(1, mentions);
    }
    bench
        .run("merge triangle.gltf -o refused.exr")
        .expect_error(1, "no film of Patina");
    assert!(!bench.path("refused.exr").exists());
}

/// Runs the program and fails where it doesn't end.
#[cfg(unix)]
fn ends(bench: &Bench, line: &str) -> Outcome {
    let mut child = bench
        .command(line)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("patina starts");
    let start = std::time::Instant::now();
    while child.try_wait().expect("it is ours").is_none() {
        if start.elapsed().as_secs() > 60 {
            child.kill().expect("it is ours");
            panic!("patina {line} hangs");
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    Outcome::of(child.wait_with_output().expect("it has ended"), line)
}

/// A pipe that nothing is written into would be waited for, and a device may never end.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_as_inputs_of_every_kind() {
    let bench = Bench::new();
    let pipe = Command::new("mkfifo").arg(bench.path("pipe")).status();
    assert!(pipe.expect("mkfifo starts").success());
    std::os::unix::fs::symlink("/dev/zero", bench.path("zero")).expect("a link");
    for (name, kind) in [("pipe", "a named pipe"), ("zero", "a device")] {
        for extension in ["glb", "wgsl", "look.toml", "patina-film"] {
            let link = bench.path(&format!("{name}.{extension}"));
            std::os::unix::fs::symlink(bench.path(name), link).expect("a link");
        }
        let write = |file: &str, text: String| fs::write(bench.path(file), text).expect("written");
        let buffer = TRIANGLE.split_once("\"data:").expect("its buffer").0;
        write("buffer.gltf", format!("{buffer}\"{name}\"}}]}}"));
        let image = format!(
            r#""images": [{{ "uri": "{name}" }}], "textures": [{{ "source": 0 }}],
            "materials": [{{ "emissiveTexture": {{ "index": 0 }}, "#
        );
        write(
            "image.gltf",
            TRIANGLE.replacen(r#""materials": [{ "#, &image, 1),
        );
        write(
            "include.look.toml",
            format!("[[include]]\nfile = '{name}'\n"),
        );
        write(
            "environment.look.toml",
            format!("environment = {{ image = '{name}' }}\n"),
        );
        for line in [
            format!("render {name}.glb -o a.png"),
            "render buffer.gltf -o a.png".to_owned(),
            "render image.gltf -o a.png".to_owned(),
            format!("render triangle.gltf --look {name}.look.toml -o a.png"),
            "render triangle.gltf --look include.look.toml -o a.png".to_owned(),
            "render triangle.gltf --look environment.look.toml -o a.png".to_owned(),
            format!("merge {name}.patina-film -o a.png"),
        ] {
            ends(&bench, &line).expect_error(1, kind);
        }
        // What is wrong with textures is the result of a check.
        let checked = ends(&bench, &format!("texture check {name}.wgsl")).expect_code(1);
        assert!(checked.stdout.contains(kind), "{}", checked.stdout);
    }
}

/// Where memory was taken for what is there once, or for nothing, the limit would end the program.
#[cfg(target_os = "linux")]
#[test]
fn a_small_address_space_suffices_for_inputs_that_hold_little() {
    const KIBIBYTES: u32 = 1_500_000;
    let bench = Bench::new();
    let buffer = fs::File::create(bench.path("large.bin")).expect("a file");
    buffer.set_len(16 << 20).expect("it grows");
    let buffers = vec![r#"{"uri":"large.bin","byteLength":16777216}"#; 1000].join(",");
    let scene = |members: &str| format!(r#"{{"asset":{{"version":"2.0"}},{members}}}"#);
    let write = |name: &str, text: String| fs::write(bench.path(name), text).expect("written");
    write("buffers.gltf", scene(&format!(r#""buffers":[{buffers}]"#)));
    let list = "[],".repeat(64 << 20 >> 2);
    write("json.gltf", scene(&format!(r#""extras":[{list}0]"#)));
    for name in ["buffers.gltf", "json.gltf"] {
        let line = format!(
            "ulimit -v {KIBIBYTES}; exec {} render {name} -o a.png",
            env!("CARGO_BIN_EXE_patina")
        );
        let run = Command::new("sh")
            .args(["-c", &line])
            .current_dir(&bench.dir)
            .env("PATINA_CACHE", "off")
            .output();
        // All of it could be read; there is nothing in it.
        Outcome::of(run.expect("sh starts"), name).expect_error(1, "nothing to render");
    }
}
