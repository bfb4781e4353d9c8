//! `patina texture` as those who write textures meet it: tables, mistakes, values, pictures.
//!
//! Each test starts the real program. Those that need a device are skipped with a notice where there is none, or fail
//! where `PATINA_REQUIRE_DEVICE` is set.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// A folder of its own in which the program is run.
struct Desk {
    dir: TempDir,
}

struct Outcome {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Desk {
    fn new() -> Self {
        Self {
            dir: tempfile::tempdir().expect("a temporary folder"),
        }
    }

    /// Writes a file.
    fn with(self, name: &str, text: &str) -> Self {
        let path = self.path(name);
        let folder = path.parent().expect("a file lies in a folder");
        fs::create_dir_all(folder).expect("a folder");
        fs::write(path, text).expect("a file");
        self
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    #[track_caller]
    fn run(&self, line: &str, code: i32) -> Outcome {
        self.run_program(env!("CARGO_BIN_EXE_patina").as_ref(), line, code)
    }

    #[track_caller]
    fn run_program(&self, program: &Path, line: &str, code: i32) -> Outcome {
        let output = Command::new(program)
            .args(line.split_whitespace())
            .current_dir(&self.dir)
            .stdin(Stdio::null())
            .output()
            .expect("patina starts");
        let outcome = Outcome {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        };
        assert_eq!(
            outcome.code,
            Some(code),
            "patina {line}\nstdout: {}\nstderr: {}",
            outcome.stdout,
            outcome.stderr
        );
        assert!(!outcome.stderr.contains("panicked"), "{}", outcome.stderr);
        outcome
    }

    /// The numbers that `eval` prints, a list per point.
    #[track_caller]
    fn values(&self, line: &str) -> Vec<Vec<f32>> {
        let stdout = self.run(&format!("texture eval {line}"), 0).stdout;
        let number = |text: &str| text.parse().expect("a number");
        let numbers = |line: &str| line.split_whitespace().map(number).collect();
        stdout.lines().map(numbers).collect()
    }
}

/// Every line as JSON.
fn json(lines: &str) -> Vec<Value> {
    let parse = |line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{line}: {e}"));
    lines.lines().map(parse).collect()
}

/// Whether this machine can render; says so where it can't.
fn device() -> bool {
    let found = Command::new(env!("CARGO_BIN_EXE_patina"))
        .arg("devices")
        .output()
        .is_ok_and(|output| output.status.success());
    if !found {
        assert!(
            std::env::var_os("PATINA_REQUIRE_DEVICE").is_none(),
            "no device can render, but PATINA_REQUIRE_DEVICE is set"
        );
        eprintln!("skipped: no device can render (`cargo xtask test` installs one)");
    }
    found
}

const BAD: &str = "/// @param q nothing is called so
fn helper(x: f32) -> f32 { return vec2f(x); }
fn userProc(scale: f32) -> vec4f {
    return readAttr(TexCoord) * scale;
}
";

#[test]
fn the_list_has_names_parameters_and_documentation() {
    let desk = Desk::new().with(
        "mine/waves.wgsl",
        "/// Waves on water. They are round.
/// @param tint  colour of the water [color] = #204060
/// @param depth how deep [unit m] [0 .. 10] = 2.5
fn userProc(tint: vec3f, depth: f32, photo: sam2D) -> vec3f { return tint * depth * tex2D(photo, vec2f(0.0)).rgb; }",
    );
    let list = desk.run("texture list --textures mine", 0).stdout;
    let waves = (list.split("\n\n")).find(|part| part.trim_start().starts_with("waves -> vec3f"));
    let waves = waves.expect("it is listed");
    for wanted in [
        "waves -> vec3f",
        "Waves on water\n",
        "tint",
        "\"#204060\"",
        "2.5",
        "how deep, m [0 .. 10]",
        "sam2D",
        "(required)",
    ] {
        assert!(waves.contains(wanted), "{wanted}:\n{waves}");
    }
    assert!(
        list.contains("voronoi -> cells vec4f, distance f32"),
        "the standard ones too"
    );

    let line = "texture list --textures mine --message-format json";
    let entries = json(&desk.run(line, 0).stdout);
    let waves = entries.iter().find(|entry| entry["name"] == "waves");
    let waves = waves.expect("it is listed");
    assert_eq!(waves["parameters"][1]["unit"], "m");
    assert_eq!(waves["parameters"][0]["default"], "\"#204060\"");
}

#[test]
fn a_texture_with_errors_is_listed_as_a_warning() {
    let desk = Desk::new().with("user_textures/bad.wgsl", BAD);
    let outcome = desk.run("texture list", 0);
    assert!(
        outcome.stderr.contains("patina texture check bad"),
        "{}",
        outcome.stderr
    );
}

#[test]
fn check_shows_all_mistakes_and_sets_the_exit_code() {
    let desk = Desk::new()
        .with("bad.wgsl", BAD)
        .with("good.wgsl", "fn userProc() -> f32 { return 1.0; }");
    let good = desk.run("texture check good.wgsl", 0);
    assert!(good.stdout.contains("checked 1 texture: 0 errors"));
    let bad = desk.run("texture check good.wgsl bad.wgsl", 1);
    for wanted in [
        "bad.wgsl:2:35",
        "bad.wgsl:4:21",
        "did you mean `TexCoord0`?",
        "2 errors",
    ] {
        assert!(bad.stdout.contains(wanted), "{wanted}:\n{}", bad.stdout);
    }
    assert!(bad.stderr.contains("1 of 2 textures"), "{}", bad.stderr);

    // Without files everything that would be found is checked: here the standard textures, which are good.
    desk.run("texture check", 0);
    let here = desk.run("texture check .", 1);
    assert!(here.stdout.contains("checked 2 textures"));
    // What textures share is checked as they use it.
    let shared = desk
        .with("lib/base.wgsl", "fn base(x: f32) -> f32 { return x; }")
        .with(
            "lib/waves.wgsl",
            "/// @use base\nfn wave(x: f32) -> f32 { return base(x); }",
        )
        .with(
            "lib/wrong.wgsl",
            "fn wrong(x: f32) -> f32 {\n    return y;\n}",
        );
    shared.run("texture check lib/waves.wgsl", 0);
    let outcome = shared.run("texture check lib", 1);
    assert!(
        outcome.stdout.contains("wrong.wgsl:2:12"),
        "{}",
        outcome.stdout
    );
    assert!(
        outcome.stdout.contains("checked 3 textures: 1 error,"),
        "{}",
        outcome.stdout
    );
    let desk = shared;
    let missing = desk.run("texture check vornoi", 1);
    assert!(missing.stdout.contains("did you mean `voronoi`?"));
    desk.run("texture check no/such.wgsl", 1);
}

#[test]
fn mistakes_are_json_lines_for_editors() {
    let desk = Desk::new().with("bad.wgsl", BAD);
    let outcome = desk.run("texture check bad.wgsl --message-format json", 1);
    let messages = json(&outcome.stdout);
    let attribute = &messages[1];
    assert_eq!(attribute["severity"], "error");
    assert_eq!(attribute["file"], "bad.wgsl");
    let place = ["line", "column", "end_line", "end_column"].map(|key| attribute[key].as_u64());
    assert_eq!(place, [Some(4), Some(21), Some(4), Some(29)]);
    let bytes = ["byte_start", "byte_end"].map(|key| attribute[key].as_u64().expect("a number"));
    assert_eq!(&BAD[bytes[0] as usize..bytes[1] as usize], "TexCoord");
    assert_eq!(attribute["label"], "did you mean `TexCoord0`?");
    assert!(attribute["notes"].as_array().is_some_and(|n| !n.is_empty()));

    // Errors without a place are objects too, and so is wrong usage.
    assert_eq!(json(&outcome.stderr)[0]["severity"], "error");
    for line in ["texture eval", "render x.gltf --spp 0"] {
        let usage = desk.run(&format!("{line} --message-format json"), 2);
        assert_eq!(json(&usage.stderr)[0]["severity"], "error", "{line}");
    }
}

#[test]
fn mistakes_in_a_look_are_json_when_rendering() {
    let desk = Desk::new()
        .with(
            "user_textures/warns.wgsl",
            "/// @param y nothing\nfn userProc(x: f32) -> f32 { return x; }",
        )
        .with(
            "a.look.toml",
            "[node.a]\ntexture = \"warns\"\nx = 1.0\n[node.b]\ntexture = \"warns\"\nz = 1.0\n",
        )
        .with("a.gltf", TRIANGLE);
    let outcome = desk.run(
        "render a.gltf --look a.look.toml --message-format json --spp 1 --size 8x8",
        1,
    );
    let messages = json(&outcome.stderr);
    let error = messages.iter().find(|m| m["severity"] == "error");
    let error = error.expect("there is an error");
    assert_eq!(error["line"], 6);
    assert!(
        error["message"]
            .as_str()
            .is_some_and(|m| m.contains("no parameter"))
    );
}

#[test]
fn inspect_shows_kernel_arguments_and_memory_of_a_texture() {
    let desk = Desk::new().with(
        "user_textures/deep.wgsl",
        "fn inner(v: vec4f) -> f32 { return v.x; }
fn userProc(a: f32, b: vec3f, c: ramp1D) -> f32 { var t: array<f32, 16>; t[1] = a; return inner(vec4f(b, t[1])); }",
    );
    let all = desk.run("texture inspect deep", 0).stdout;
    for wanted in [
        "==== kernel ====",
        "fn deep__userProc(",
        "deep(a = 0, b = [0, 0, 0], c = ...)",
        "     1  b                   vec3f      [0, 0, 0]",
        "stops at word 5: [[0, \"#000000\"], [1, \"#ffffff\"]]",
        // A number, a vec3f, the ramp's handle and the table; the helper's vec4f.
        "   100 bytes of parameters and variables: userProc > inner",
        "wgpu does not pass on",
    ] {
        assert!(all.contains(wanted), "{wanted}:\n{all}");
    }
    let kernel = desk.run("texture inspect deep --part kernel", 0).stdout;
    assert!(kernel.starts_with("// Generated") && !kernel.contains("==== memory"));
    desk.run("texture inspect", 2);
    desk.run("texture inspect nope", 1);
}

#[test]
fn inspect_decodes_the_programs_of_a_look_without_its_scene() {
    let desk = Desk::new().with(
        "a.look.toml",
        r#"[ao.near]
distance = 0.1
[node.noise]
texture = "fbm"
scale = 3.0
[node.mix]
texture = "mix_color"
factor = "noise"
[node.rust]
texture = "rust_mask"
[material.Paint]
base_color = "mix"
roughness = "noise"
blend = { base = "Paint", over = "Bare", mask = "rust" }
[material.Bare]
bump = "noise"
"#,
    );
    let programs = desk
        .run("texture inspect --look a.look.toml --part programs", 0)
        .stdout;
    for wanted in [
        "material Paint (surface)\n    program: 2 instructions, 2 stack slots",
        "noise: fbm(scale = 3, octaves = 5",
        "factor = s0",
        "base_color = s1",
        "roughness = s0",
        "of Bare over Paint (surface)",
        "program of the bump height: 1 instruction",
        "AO slots 0 and 0",
    ] {
        assert!(programs.contains(wanted), "{wanted}:\n{programs}");
    }
    let arguments = desk
        .run("texture inspect --look a.look.toml --part arguments", 0)
        .stdout;
    assert!(arguments.contains("from node noise"), "{arguments}");
}

#[test]
fn values_are_those_of_the_formula() {
    if !device() {
        return;
    }
    let desk = Desk::new()
        .with(
            "user_textures/wave.wgsl",
            "fn userProc(scale: f32, tint: vec3f, photo: sam2D, on: bool) -> vec3f {
    let p = readAttr(WorldPos).xyz * scale;
    return (p.x + 10.0 * p.y + 100.0 * p.z) * tint + select(vec3f(0.0), tex2D(photo, readAttr(TexCoord0).xy).rgb, on);
}",
        )
        .with(
            "user_textures/reads.wgsl",
            "fn userProc() -> vec4f {
    return vec4f(readAttr(AO).y, readAttr(Normal).y, readAttr(_WET).x, readGlobal(Resolution).x + readAttr(Time).x);
}",
        )
        .with(
            "user_textures/levels.wgsl",
            "fn userProc(photo: sam2D, lod: f32) -> vec4f { return tex2DLod(photo, vec2f(0.25, 0.5), lod); }",
        )
        .with(
            "user_textures/endless.wgsl",
            "fn userProc(x: f32) -> f32 { var s = x; while s >= 0.0 { s += 1.0; } return s; }",
        )
        .with(
            "a.look.toml",
            "[node.half]\ntexture = \"reads\"\n[node.all]\ntexture = \"mix_color\"\na = \"half\"\nfactor = 0.0\n",
        );
    let mut picture = image::RgbImage::new(2, 1);
    picture.put_pixel(1, 0, image::Rgb([255, 0, 255]));
    picture.save(desk.path("dot.png")).expect("a picture");

    let set = "--set photo=dot.png --set tint=1,2,-1 --set scale=0.5";
    let values = desk.values(&format!("wave {set} --at WorldPos=2,4,6 --at WorldPos=-2"));
    assert_eq!(values, [[321.0, 642.0, -321.0], [-1.0, -2.0, 1.0]]);
    let values = desk.values(&format!("wave {set} --set on=true --at TexCoord0=0.75,0.5"));
    assert_eq!(values, [[1.0, 0.0, 1.0]]);

    let picture = "--set photo={file=\"dot.png\",color_space=\"linear\"}";
    let level = |lod| desk.values(&format!("levels {picture} --set lod={lod}"))[0][0];
    assert_eq!(level(0), 0.0);
    assert!((level(1) - 0.5).abs() < 0.01, "the last level is the mean");

    assert_eq!(desk.values("reads"), [[1.0, 1.0, 0.0, 1280.0]]);
    let at = "--at AO=0.25;Normal=0,-1,0;_WET=7;Resolution=64,32;Time=2";
    assert_eq!(
        desk.values(&format!("reads {at}")),
        [[0.25, -1.0, 7.0, 66.0]]
    );
    let linked = desk.values(&format!("all --look a.look.toml {at}"));
    assert_eq!(linked, [[0.25, -1.0, 7.0, 66.0]], "a node with its links");

    for (line, mentions) in [
        ("wave", "set `photo`"),
        ("wave --set scal=1", "did you mean `scale`?"),
        ("wave --set scale=[1,2]", "expected a number"),
        ("wave --set photo=no.png", "no.png"),
        ("reads --at WorldPso=1", "did you mean `WorldPos`?"),
        ("reads --at _WED=1", "did you mean `_WET`?"),
        ("endless", "endless"),
        ("half --look b.look.toml", "b.look.toml"),
        ("hlaf --look a.look.toml", "did you mean `half`?"),
    ] {
        let outcome = desk.run(&format!("texture eval {line}"), 1);
        assert!(
            outcome.stderr.contains(mentions),
            "{line}:\n{}",
            outcome.stderr
        );
    }
}

#[test]
fn many_points_are_evaluated_at_once_by_the_library() {
    use ::device::Device;
    use engine::evaluate::{Evaluator, Point};

    if !device() {
        return;
    }
    let desk = Desk::new().with(
        "square.wgsl",
        "fn userProc(k: f32) -> f32 { let x = readAttr(TexCoord0).x; return k * x * x; }",
    );
    let device = Device::best().expect("there is a device");
    let mut square =
        Evaluator::of_file(&device, &desk.path("square.wgsl")).expect("a good texture");
    square.set("k", "2").expect("a number");
    let points: Vec<Point> = (0..70_000)
        .map(|i| Point::new().with("TexCoord0", &[i as f32]))
        .collect();
    let before = device.counts().pipelines;
    let values = square.evaluate(&points).expect("values");
    assert_eq!(values.len(), points.len());
    for (i, value) in values.iter().enumerate() {
        let x = i as f32;
        assert_eq!(*value, [2.0 * x * x; 4], "point {i}");
    }
    square
        .set_value("k", texgen::Value::F32(3.0))
        .expect("a number");
    let again = square.evaluate(&points[..3]).expect("values");
    assert_eq!(again[2], [12.0; 4]);
    assert_eq!(
        device.counts().pipelines,
        before + 1,
        "one kernel does for all"
    );
}

#[test]
fn a_preview_shows_a_material_on_a_ball() {
    if !device() {
        return;
    }
    let desk = Desk::new().with(
        "a.look.toml",
        "[material.Red]\nbase_color = [0.9, 0.02, 0.02]\n[material.Blue]\nbase_color = [0.02, 0.02, 0.9]\n",
    );
    desk.run(
        "texture preview --look a.look.toml --material Red -o a.png --size 80",
        0,
    );
    let image = image::open(desk.path("a.png"))
        .expect("a picture")
        .to_rgb8();
    assert_eq!(image.dimensions(), (80, 60));
    let [r, g, _] = image.get_pixel(40, 26).0;
    assert!(r > 2 * g, "red: {r} {g}");
    let [r, g, b] = image.get_pixel(4, 56).0;
    assert!(
        r.abs_diff(g) < 60 && g.abs_diff(b) < 60,
        "grey floor: {r} {g} {b}"
    );
    desk.run("texture preview --look a.look.toml --material Rad", 1);
    desk.run("texture preview Red --look a.look.toml --material Red", 2);
}

#[test]
fn a_preview_shows_the_texture() {
    if !device() {
        return;
    }
    let desk = Desk::new().with(
        "user_textures/halves.wgsl",
        "fn userProc(level: f32) -> f32 { return select(-1.0, level, readAttr(LocalPos).y > 0.0); }",
    );
    desk.run(
        "texture preview halves --set level=1 --range -1..1 -o a.png --size 160",
        0,
    );
    let picture = image::open(desk.path("a.png")).expect("a PNG").to_luma8();
    assert_eq!(picture.dimensions(), (160, 64));
    // On sphere, plane and cube: bright above, black below.
    for x in [24, 80, 134] {
        let mean = |rows: std::ops::Range<u32>| {
            let count = rows.len() as u32;
            rows.map(|y| u32::from(picture.get_pixel(x, y).0[0]))
                .sum::<u32>()
                / count
        };
        let (above, below) = (mean(18..27), mean(38..46));
        assert!(above > below + 60, "column {x}: {above} and {below}");
    }
    desk.run("texture preview halves --size 64", 0);
    assert!(desk.path("halves-preview.png").exists());
    for line in ["--size 8", "--range 2..1", "-o a.gif", "--set level"] {
        desk.run(&format!("texture preview halves {line}"), 2);
    }
}

#[test]
fn a_new_texture_is_a_good_texture_and_replaces_nothing() {
    let desk = Desk::new();
    let outcome = desk.run("texture new old_paint", 0);
    assert!(outcome.stdout.contains("old_paint.wgsl"));
    let checked = desk.run("texture check old_paint", 0).stdout;
    assert!(
        checked.contains("1 texture: 0 errors, 0 warnings"),
        "{checked}"
    );

    fs::write(desk.path("user_textures/old_paint.wgsl"), "mine").expect("a file");
    let again = desk.run("texture new old_paint", 1);
    assert!(again.stderr.contains("exists already"), "{}", again.stderr);
    let text = fs::read_to_string(desk.path("user_textures/old_paint.wgsl")).expect("a file");
    assert_eq!(text, "mine");

    let shadowing = desk.run("texture new voronoi --dir more", 0);
    assert!(shadowing.stderr.contains("already"), "{}", shadowing.stderr);
    for name in ["2d", "a/b", "paint.wgsl", "..", "a=b"] {
        desk.run(&format!("texture new {name}"), 2);
    }
}

#[test]
fn a_copy_of_a_texture_has_the_shared_files_that_it_uses() {
    let text = "/// @use hills\nfn userProc() -> f32 { return hills(2.0); }\n";
    let desk = (Desk::new().with("own/a.wgsl", text)).with(
        "own/lib/hills.wgsl",
        "fn hills(x: f32) -> f32 { return 3.0 * x; }\n",
    );
    desk.run("texture new b --from a --textures own --dir other", 0);
    assert_eq!(desk.values("b --textures other"), [[6.0]]);
    let desk = desk.with(
        "other/lib/hills.wgsl",
        "fn hills(x: f32) -> f32 { return x; }\n",
    );
    let told = desk.run("texture new c --from a --textures own --dir other", 0);
    assert!(told.stderr.contains("is another one"), "{}", told.stderr);
    assert_eq!(desk.values("c --textures other"), [[2.0]]);
}

#[test]
fn a_preview_never_replaces_an_image_that_it_reads() {
    let desk = (Desk::new().with("wood.png", "no picture")).with("it's.png", "no picture");
    for (value, output) in [
        ("wood.png", "wood.png"),
        ("{file=\"wood.png\",filter=\"nearest\"}", "wood.png"),
        ("'wood.png'", "wood.png"),
        ("\"wo\\u006fd.png\"", "wood.png"),
        ("it's.png", "it's.png"),
        ("{file=\"it's.png\"}", "it's.png"),
    ] {
        let line = format!("texture preview image --set file={value} -o {output}");
        let told = desk.run(&line, 2);
        assert!(told.stderr.contains("is an input"), "{}", told.stderr);
    }
}

#[test]
fn what_is_in_the_way_of_a_new_texture_is_named() {
    let desk = Desk::new().with("taken", "a file");
    let told = desk.run("texture new waves --dir taken", 1).stderr;
    assert!(told.contains("--dir taken: it is no folder"), "{told}");
    let told = desk.run("texture new waves --dir taken/below", 1).stderr;
    assert!(told.contains("cannot create the folder"), "{told}");
}

#[test]
fn a_page_that_cannot_have_its_sheets_is_not_written() {
    let desk = Desk::new().with("taken", "a file");
    for (line, said) in [
        ("--sheets taken -o page.md", "cannot create taken"),
        (
            "--sheets sheets --device no-such-device -o page.md",
            "no-such-device",
        ),
        ("-o no/such/page.md", "the folder no/such does not exist"),
    ] {
        let told = desk.run(&format!("texture doc {line}"), 1);
        assert!(told.stderr.contains(said), "{line}: {}", told.stderr);
        assert!(!desk.path("page.md").exists(), "{line}");
    }
    desk.run("texture doc -o page.md", 0);
    assert!(desk.path("page.md").exists());
}

/// Whether a line of output is what a document shows: numbers up to rounding, `...` stands for any rest.
fn is_shown(shown: &str, line: &str) -> bool {
    if let Some(beginning) = shown.strip_suffix("...") {
        return line.starts_with(beginning.trim_end());
    }
    let (a, b) = (shown.split_whitespace(), line.split_whitespace());
    let same = |(a, b): (&str, &str)| match (a.parse::<f32>(), b.parse::<f32>()) {
        (Ok(a), Ok(b)) => (a - b).abs() < 1.0e-3,
        _ => a == b,
    };
    a.clone().count() == b.clone().count() && a.zip(b).all(same)
}

#[test]
fn a_node_that_needs_too_much_at_once_is_named() {
    if !device() {
        return;
    }
    // A chain there and back: all of the way there is read again on the way back.
    let node = |name: String, a: String, b: String| {
        format!("[node.{name}]\ntexture = \"add\"\na = {a}\nb = {b}\n")
    };
    let link = |name: &str, i: usize| format!("\"{name}{i}\"");
    let mut look = node("there0".into(), "1.0".into(), "1.0".into());
    for i in 1..300 {
        look += &node(format!("there{i}"), link("there", i - 1), "1.0".into());
    }
    look += &node("back299".into(), link("there", 299), "1.0".into());
    for i in 0..299 {
        look += &node(format!("back{i}"), link("back", i + 1), link("there", i));
    }
    let desk = Desk::new().with("long.look.toml", &look).with(
        "user_textures/add.wgsl",
        "fn userProc(a: f32, b: f32) -> f32 { return a + 0.5 * b; }",
    );
    let outcome = desk.run("texture eval back0 --look long.look.toml", 1);
    for part in [
        "node `back0` of long.look.toml",
        "intermediate results",
        "fewer nodes",
    ] {
        assert!(outcome.stderr.contains(part), "{}", outcome.stderr);
    }
}

#[test]
fn the_documents_show_what_the_tools_print() {
    if !device() {
        return;
    }
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/texture-language.md");
    let page = fs::read_to_string(page).expect("the page is part of the project");
    let (_, example) = page.split_once("```wgsl,error\n").expect("it has one");
    let (example, _) = example.split_once("```").expect("the block ends");
    let desk = Desk::new().with("example.wgsl", example);
    let mut commands = 0;
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let Some(command) = line.strip_prefix("    $ patina ") else {
            continue;
        };
        commands += 1;
        let output = Command::new(env!("CARGO_BIN_EXE_patina"))
            .args(command.replace('"', "").split_whitespace())
            .current_dir(&desk.dir)
            .output()
            .expect("patina starts");
        let output = String::from_utf8_lossy(&output.stdout).into_owned();
        let mut printed = output.lines();
        for shown in lines.by_ref().take_while(|line| !line.is_empty()) {
            let found = printed.next().unwrap_or_default();
            assert!(
                is_shown(shown.trim_start(), found),
                "{command}\nis said to print: {shown}\nbut prints:       {found}"
            );
        }
    }
    assert!(commands >= 3, "the page shows commands with their output");
}

/// One triangle; no other file is needed.
const TRIANGLE: &str = r#"{
  "asset": { "version": "2.0" },
  "scene": 0,
  "scenes": [{ "nodes": [0] }],
  "nodes": [{ "mesh": 0 }],
  "materials": [{ "name": "Glow" }],
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

#[test]
fn standard_textures_are_part_of_the_program() {
    let desk = Desk::new();
    // Elsewhere than in the checkout, whose folder would win.
    let program = desk.path("patina");
    let built = Path::new(env!("CARGO_BIN_EXE_patina"));
    fs::hard_link(built, &program)
        .or_else(|_| fs::copy(built, &program).map(drop))
        .expect("the program can be copied");
    let run = |line: &str, code: i32| desk.run_program(&program, line, code);

    let list = run("texture list", 0).stdout;
    assert!(list.contains("fbm -> f32  (built in)"), "{list}");
    let objects = json(&run("texture list --message-format json", 0).stdout);
    let fbm = objects.iter().find(|object| object["name"] == "fbm");
    let fbm = fbm.expect("it is listed");
    assert_eq!(fbm["built_in"], true);
    assert_eq!(fbm["file"], "<built-in>/fbm.wgsl");

    run("texture check <built-in>/fbm.wgsl", 0);
    run("texture check", 0);
    let kernel = run("texture inspect fbm --part kernel", 0).stdout;
    assert!(kernel.contains("// ==== fbm ===="), "{kernel}");
    run("texture new mine --from fbm", 0);
    let copy = fs::read_to_string(desk.path("user_textures/mine.wgsl")).expect("a copy");
    assert!(copy.contains("fn userProc("), "{copy}");
    let error = run("texture new other --from fmb", 1).stderr;
    assert!(error.contains("did you mean `fbm`?"), "{error}");

    let warning = run("texture new fbm", 0).stderr;
    assert!(
        warning.contains("standard texture of this name"),
        "{warning}"
    );
    let list = run("texture list", 0).stdout;
    assert!(
        list.contains("fbm -> vec3f  (user_textures/fbm.wgsl)"),
        "{list}"
    );
    fs::write(desk.path("user_textures/fbm.wgsl"), BAD).expect("a file");
    let error = run("texture inspect fbm", 1).stderr;
    assert!(error.contains("--> user_textures/fbm.wgsl:"), "{error}");
}
