//! How the program ends: by signals, without threads, with a terminal or a disk that takes nothing.

use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::*;

/// How long a machine takes to get to the first sample is unknown: tests wait longer until it has.
const WAITS: [u64; 3] = [3, 10, 40];

/// A render that goes on for long enough.
const ENDLESS: &str = "render triangle.gltf --size 256x256 --spp 1000000";

impl Bench {
    fn start(&self, line: &str) -> Child {
        let mut command = self.command(line);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("patina starts")
    }
}

fn signal(child: &Child, name: &str) {
    let is_sent = kill(&[name, &child.id().to_string()]);
    assert!(is_sent, "the program must still be running");
}

/// Whether or not it is still there.
pub(super) fn signal_again(child: &Child, name: &str) {
    let _ = kill(&[name, &child.id().to_string()]);
}

fn outcome(child: Child, line: &str) -> Outcome {
    Outcome::of(child.wait_with_output().expect("patina ends"), line)
}

/// Whether these tests were started with this signal ignored, as by `nohup`: what they start ignores it then, rightly.
fn is_ignored(number: u32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mut lines = status.lines();
    let mask = lines.find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.unwrap_or(0) >> (number - 1) & 1 == 1
}

#[test]
fn signals_end_a_render_with_all_that_was_asked_for() {
    if !device() {
        return;
    }
    for (name, number, code) in [("-TERM", 15, 143), ("-HUP", 1, 129), ("-XCPU", 24, 152)] {
        if is_ignored(number) {
            eprintln!("skipped: {name} is ignored here");
            continue;
        }
        let is_done = WAITS.into_iter().any(|seconds| {
            let bench = Bench::new();
            let line = format!("{ENDLESS} -o a.png -o a.exr -o a.patina-film --stats-json a.json");
            let child = bench.start(&line);
            sleep(Duration::from_secs(seconds));
            signal(&child, name);
            if name == "-XCPU" {
                // The system sends it again with every second more on a processor: later than an echo comes.
                sleep(Duration::from_millis(600));
            }
            // As `timeout` does; the program may have ended before.
            signal_again(&child, name);
            let ended = outcome(child, &line).expect_code(code);
            assert!(ended.stderr.contains("interrupted"), "{}", ended.stderr);
            if bench.files() == ["triangle.gltf"] {
                return false;
            }
            assert_eq!(
                bench.files(),
                ["a.exr", "a.json", "a.patina-film", "a.png", "triangle.gltf"]
            );
            bench.run("merge a.patina-film -o b.png").expect_code(0);
            true
        });
        assert!(is_done, "{name} 40 s into a render wrote nothing");
    }
}

/// While light is found out about there is no sample, however long that takes.
#[test]
fn no_picture_takes_the_place_of_a_former_one_without_a_sample() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    fs::write(bench.path("a.png"), "the former one").expect("written");
    let line = "render triangle.gltf --method cache --size 3000x2000 --spp 64 -o a.png";
    for tenths in [4, 8, 16] {
        let child = bench.start(line);
        sleep(Duration::from_millis(100 * tenths));
        signal(&child, "-INT");
        let said = outcome(child, line).expect_code(130).stderr;
        let is_former = fs::read(bench.path("a.png")).expect("there") == b"the former one";
        assert!(is_former || !said.contains("before there was"), "{said}");
        if !is_former {
            return; // it had samples
        }
    }
}

/// The first piece never is done here; whether it has samples when the signal comes is a matter of moments.
#[test]
fn no_folder_stays_in_which_no_piece_is() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    // Too large to be rendered at once.
    let line = "render triangle.gltf --size 8193x8192 --spp 1000000 --checkpoint -o a.png";
    for pause in [0, 2] {
        let child = bench.start(line);
        let folder = bench.path("a.patina-pieces");
        let start = Instant::now();
        while !folder.exists() && start.elapsed() < Duration::from_secs(60) {
            sleep(Duration::from_millis(1));
        }
        assert!(folder.exists(), "it doesn't begin");
        sleep(Duration::from_secs(pause));
        signal(&child, "-INT");
        outcome(child, line).expect_code(130);
        assert_eq!(bench.files(), ["triangle.gltf"]);
    }
}

#[test]
fn a_second_signal_ends_at_once_and_one_that_was_ignored_stays_so() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let child = bench.start(&format!("{ENDLESS} -o a.png"));
    sleep(Duration::from_secs(2));
    signal(&child, "-INT");
    sleep(Duration::from_millis(600));
    signal_again(&child, "-INT");
    outcome(child, ENDLESS).expect_code(130);
    let left = bench.files();
    assert!(!left.iter().any(|name| name.starts_with('.')), "{left:?}");

    // As under `nohup`.
    let program = env!("CARGO_BIN_EXE_patina");
    let child = Command::new("sh")
        .args([
            "-c",
            &format!("trap '' HUP; exec {program} {ENDLESS} -o b.png"),
        ])
        .current_dir(&bench.dir)
        .env("PATINA_CACHE", "off")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell");
    sleep(Duration::from_secs(1));
    signal(&child, "-HUP");
    sleep(Duration::from_secs(1));
    signal(&child, "-TERM");
    outcome(child, ENDLESS).expect_code(143);
}

#[test]
fn what_is_compiled_is_named_and_can_be_interrupted() {
    use std::io::{BufRead, BufReader};

    if !device() {
        return;
    }
    let bench = Bench::new();
    // Mesa takes minutes for a large array.
    let texture = "fn userProc(x: f32) -> vec3f {\n    var a: array<f32, 1000>;\n\
        \x20   for (var i = 0; i < 1000; i++) { a[i] = x + sin(f32(i)); }\n\
        \x20   return vec3f(a[i32(readAttr(TexCoord0).x * 900.0)]);\n}\n";
    let look =
        "[node.large]\ntexture = \"large\"\nx = 0.5\n[material.Glow]\nbase_color = \"large\"\n";
    fs::create_dir(bench.path("user_textures")).expect("a folder");
    fs::write(bench.path("user_textures/large.wgsl"), texture).expect("written");
    fs::write(bench.path("a.look.toml"), look).expect("written");
    let line = "render triangle.gltf --look a.look.toml --size 32x32 --spp 4 -o a.png";
    let mut child = bench
        .command(line)
        .env("PATINA_CACHE", bench.path("cache"))
        // Mesa's own cache would make the second run a quick one.
        .env("MESA_SHADER_CACHE_DISABLE", "true")
        .env("MESA_GLSL_CACHE_DISABLE", "true")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("patina starts");
    let stderr = BufReader::new(child.stderr.take().expect("piped"));
    let mut lines = stderr.lines().map_while(Result::ok);
    // On a busy machine other kernels take long as well.
    let Some(said) = lines.find(|line| line.contains("the texture")) else {
        child.wait().expect("it ends");
        eprintln!("skipped: this driver compiles a large array within moments");
        return;
    };
    assert!(said.contains("`large`"), "{said}");
    signal(&child, "-INT");
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    let left = bench.files();
    assert_eq!(
        left,
        ["a.look.toml", "cache", "triangle.gltf", "user_textures"]
    );
    let markers = fs::read_dir(bench.path("cache")).expect("a folder").count();
    assert_eq!(markers, 0, "the next start has nobody to blame");
}

#[cfg(target_os = "linux")]
#[test]
fn too_few_threads_are_an_error() {
    use std::os::unix::fs::MetadataExt;
    use std::os::unix::process::CommandExt;

    let mut command = Command::new("sh");
    // dash calls it `-p`.
    let line = "ulimit -u 1 2>/dev/null || ulimit -p 1; exec \"$0\" devices";
    command.args(["-c", line, env!("CARGO_BIN_EXE_patina")]);
    command.current_dir("/");
    // The limit doesn't hold for root.
    if fs::metadata("/proc/self").is_ok_and(|own| own.uid() == 0) {
        command.uid(65_534);
    }
    let ended = command.output().expect("a shell");
    if matches!(ended.status.code(), Some(126 | 127)) {
        eprintln!("skipped: another user can't start the program");
        return;
    }
    Outcome::of(ended, "devices").expect_error(1, "ulimit -u");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_the_output_is_an_error() {
    let bench = Bench::new();
    for line in ["texture list", "texture inspect checker", "--help"] {
        let full = fs::File::options().write(true).open("/dev/full");
        let mut command = bench.command(line);
        command.stdout(full.expect("a device"));
        let ended = command.output().expect("patina starts");
        Outcome::of(ended, line).expect_error(1, "standard output");
    }
}

#[test]
fn the_text_of_a_file_does_not_steer_the_terminal() {
    let bench = Bench::new();
    let images = "\"images\": [{ \"uri\": \"\\u001b]0;owned\\u0007\\u009b2J.png\" }],\n  \
        \"textures\": [{ \"source\": 0 }],\n  \"materials\": [";
    let scene = TRIANGLE.replace("\"materials\": [", images).replace(
        "\"metallicFactor\": 0",
        "\"baseColorTexture\": { \"index\": 0 }",
    );
    fs::write(bench.path("esc.gltf"), scene).expect("written");
    for line in ["render esc.gltf", "render esc.gltf --message-format json"] {
        let said = bench.run(line).expect_code(1).stderr;
        let steering = |c: char| c.is_control() && c != '\n';
        assert!(!said.contains(steering), "{line}: {said:?}");
        assert!(said.contains("owned"), "{line}: {said:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_window_without_a_display_is_refused_in_a_sentence() {
    let bench = Bench::new();
    let mut command = bench.command("view triangle.gltf");
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(variable);
    }
    let ended = command.output().expect("patina starts");
    let ended = Outcome::of(ended, "view").expect_error(1, "there is no display");
    assert!(ended.stderr.contains("`patina render`"), "{}", ended.stderr);
    assert!(!ended.stderr.contains(".rs"), "{}", ended.stderr);
}

#[test]
fn a_quiet_render_says_nothing() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let ended = bench.run("render triangle.gltf --size 8x8 --spp 1 --quiet -o a.png");
    let ended = ended.expect_code(0);
    assert_eq!((ended.stdout.as_str(), ended.stderr.as_str()), ("", ""));
    assert!(bench.path("a.png").exists());
}
