//! `patina watch` as people meet it: a file is saved, and the picture follows.

#[path = "../engine/tests/suite/session/look.rs"]
mod look;
#[path = "../engine/tests/suite/session/stage.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod stage;
#[path = "../engine/tests/suite/support/mod.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod support;

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use look::{LOOK, RINGS, SQUARES, TEXTURES};
use stage::Stage;
use support::device;

/// A slow machine that others use too needs that long for a kernel.
const PATIENCE: Duration = Duration::from_secs(120);

/// The running program; ended when it is dropped.
struct Watch {
    child: Child,
    lines: Receiver<String>,
}

impl Watch {
    fn start(stage: &Stage) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_patina"))
            .args("watch scene.gltf --look scene.look.toml --textures textures".split(' '))
            .args("-o out.png --size 24x16 --max-depth 2 --spp 16".split(' '))
            .current_dir(stage.path(""))
            .env("PATINA_CACHE", "off")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("patina starts");
        let (sender, lines) = channel();
        let out: Box<dyn Read + Send> = Box::new(child.stdout.take().expect("piped"));
        let err: Box<dyn Read + Send> = Box::new(child.stderr.take().expect("piped"));
        for stream in [out, err] {
            let sender = sender.clone();
            std::thread::spawn(move || {
                for line in BufReader::new(stream).lines().map_while(Result::ok) {
                    let _ = sender.send(line);
                }
            });
        }
        Self { child, lines }
    }

    /// Waits for a line with all these parts.
    #[track_caller]
    fn expect(&self, parts: &[&str]) {
        self.until(parts);
    }

    /// The lines before one with all these parts.
    #[track_caller]
    fn until(&self, parts: &[&str]) -> String {
        let mut seen = Vec::new();
        loop {
            match self.lines.recv_timeout(PATIENCE) {
                Ok(line) if parts.iter().all(|part| line.contains(part)) => return seen.join("\n"),
                Ok(line) => seen.push(line),
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                    panic!("no line with {parts:?} came:\n{}", seen.join("\n"))
                }
            }
        }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn pixels(path: &Path) -> Vec<u8> {
    image::open(path).expect("a picture").to_rgb8().into_raw()
}

#[test]
fn a_saved_texture_is_seen_and_a_wrong_one_is_told() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let watch = Watch::start(&stage);
    for spp in ["1 spp", "4 spp", "16 spp"] {
        watch.expect(&["0: start", spp, "out.png"]);
    }
    let first = pixels(&stage.path("out.png"));

    stage.replace("textures/rings.wgsl", SQUARES);
    watch.expect(&["1: rings.wgsl", ": 1 spp after ", " s: out.png"]);
    watch.expect(&["1: rings.wgsl", "16 spp"]);
    let second = pixels(&stage.path("out.png"));
    assert_ne!(first, second, "the change is seen");

    stage.write(
        "textures/rings.wgsl",
        "fn userProc(count: f32) -> f32 {\n    return cuont;\n}\n",
    );
    watch.expect(&["error"]);
    watch.expect(&["rings.wgsl:2:12"]);
    watch.expect(&["return cuont;"]);
    watch.expect(&["^"]);
    assert_eq!(
        second,
        pixels(&stage.path("out.png")),
        "the picture is not lost"
    );

    stage.write("textures/rings.wgsl", RINGS);
    watch.expect(&["no more problems"]);
    watch.expect(&["rings.wgsl", "16 spp"]);
    assert_eq!(first, pixels(&stage.path("out.png")), "mended");

    // What is odd is told of edits, too.
    let odd = RINGS.replace("rings = 3", "rings [5 .. 1] = 3");
    stage.write("textures/rings.wgsl", &odd);
    watch.expect(&["warning", "not a range"]);

    // A texture that is no mistake, but gives no numbers.
    let broken = "fn userProc(count: f32) -> f32 { return count * sqrt(-1.0 - abs(readAttr(WorldPos).x)); }\n";
    stage.replace("textures/rings.wgsl", broken);
    watch.expect(&["warning", "(texture `rings`)", "not finite"]);
    let told = watch.until(&["rings.wgsl", "16 spp"]);
    assert!(!told.contains("not finite"), "twice: {told}");
    stage.replace("textures/rings.wgsl", RINGS);
    watch.expect(&["rings.wgsl", "16 spp"]);

    // The look, and then the scene.
    let dark = LOOK.replace("intensity = 1.0", "intensity = 0.5");
    stage.replace("scene.look.toml", &dark);
    watch.expect(&["scene.look.toml", "16 spp"]);
    let darker = pixels(&stage.path("out.png"));
    assert_ne!(first, darker);
    // Shown in another way, what there is of samples is enough.
    let agx = format!("{dark}\n[view]\ntransform = \"agx\"\n");
    stage.replace("scene.look.toml", &agx);
    watch.expect(&["scene.look.toml", "16 spp"]);
    assert_ne!(darker, pixels(&stage.path("out.png")));
    stage.replace("scene.look.toml", &dark);
    watch.expect(&["scene.look.toml", "16 spp"]);
    assert_eq!(darker, pixels(&stage.path("out.png")));
    let scene = crate::stage::read(&stage.path("scene.gltf"));
    stage.write("scene.gltf", &scene.replace("[0, 1, -1]", "[0, 1, -0.5]"));
    watch.expect(&["scene.gltf", "16 spp"]);
    assert_ne!(darker, pixels(&stage.path("out.png")));

    // Textures that go and come back, as when another branch is checked out.
    std::fs::rename(stage.path("textures"), stage.path("away")).expect("moved");
    std::fs::create_dir(stage.path("textures")).expect("a folder");
    stage.write("textures/rings.wgsl", SQUARES);
    watch.expect(&["rings.wgsl", "16 spp"]);
}

#[test]
fn textures_may_come_in_a_folder_that_was_not_there() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let watch = Watch::start(&stage);
    watch.expect(&["0: start", "16 spp"]);
    let look = LOOK.replacen("texture = \"rings\"", "texture = \"late\"", 1);
    stage.replace("scene.look.toml", &look);
    watch.expect(&["there is no texture called `late`"]);
    std::fs::create_dir(stage.path("user_textures")).expect("a folder");
    stage.write("user_textures/late.wgsl", SQUARES);
    watch.expect(&["no more problems"]);
    watch.expect(&["late.wgsl", "16 spp"]);
    let first = pixels(&stage.path("out.png"));
    stage.write("user_textures/late.wgsl", RINGS);
    watch.expect(&["late.wgsl", "16 spp"]);
    assert_ne!(first, pixels(&stage.path("out.png")), "edits are seen");
}

#[test]
fn what_could_not_be_written_is_no_picture() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let watch = Watch::start(&stage);
    watch.expect(&["0: start", "16 spp", "out.png"]);
    // A folder is in the way.
    std::fs::remove_file(stage.path("out.png")).expect("it is there");
    std::fs::create_dir(stage.path("out.png")).expect("a folder");
    stage.replace("textures/rings.wgsl", SQUARES);
    watch.expect(&["error", "out.png"]);
    std::fs::remove_dir(stage.path("out.png")).expect("it is empty");
    let look = LOOK.replace("intensity = 1.0", "intensity = 0.5");
    stage.replace("scene.look.toml", &look);
    let before = watch.until(&["2: scene.look.toml", "16 spp", "out.png"]);
    let is_nothing = |line: &str| line.contains(" spp after ") && line.trim_end().ends_with(':');
    assert!(!before.lines().any(is_nothing), "{before}");
}

#[cfg(unix)]
#[test]
fn a_signal_ends_it_and_leaves_the_picture() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut watch = Watch::start(&stage);
    watch.expect(&["0: start", "1 spp", "out.png"]);
    // The shell's own: not every system has a program of that name.
    let kill = Command::new("sh")
        .args(["-c", "kill \"$@\"", "sh", "-TERM"])
        .arg(watch.child.id().to_string())
        .status();
    assert!(kill.expect("sh starts").success());
    let status = watch.child.wait().expect("it ends");
    assert_eq!(status.code(), Some(143));
    pixels(&stage.path("out.png"));
    let left = std::fs::read_dir(stage.path("")).expect("a folder");
    let names: Vec<_> = left.flatten().map(|entry| entry.file_name()).collect();
    let is_aside = |name: &std::ffi::OsString| name.to_string_lossy().starts_with(".patina-");
    assert!(!names.iter().any(is_aside), "{names:?}");
}

#[test]
fn what_can_not_be_watched_is_refused() {
    let run = |line: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_patina"))
            .args(line.split(' '))
            .stdin(Stdio::null())
            .output()
            .expect("patina starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), said)
    };
    let (code, said) = run("watch no-such-scene.glb -o /tmp/x.gif");
    assert_eq!(code, Some(2), "{said}");
    let (code, said) = run("watch no-such-scene.glb --spp 0");
    assert_eq!(code, Some(2), "{said}");
    let (code, said) = run("watch no-such-scene.glb");
    assert!(
        code == Some(1) && said.contains("no-such-scene.glb"),
        "{said}"
    );
}
