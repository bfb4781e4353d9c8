//! `cargo xtask`: everything a fresh machine needs, as commands that can be read.
//!
//! Kept free of dependencies (but for errors and JSON), as it is built before anything else can happen. What a command
//! does is written here from top to bottom; how to run a step is in `steps`, how to find or install a Vulkan driver in
//! `vulkan`, another one in `swiftshader`, a screen for the window's tests in `screen`, which systems the program must
//! compile for in `targets`, how the program is built to be given away in `dist`, a picture by many machines in `farm`, files for
//! other schedulers in `farm_files`, the comparison with other renderers in `peers`, that of view
//! transforms with OpenColorIO in `views`, reading our files with Blender in `blender`, comparing animated vertices with another
//! evaluation in `poses`, what MaterialX's nodes become with MaterialX's own in `materialx`.

mod blender;
mod dist;
mod farm;
mod farm_files;
mod materialx;
mod peers;
mod poses;
mod screen;
mod steps;
mod swiftshader;
mod targets;
mod views;
mod vulkan;

use std::env;
use std::fs;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};

use steps::{Step, Steps, cargo, root};

/// Picture size and samples of the demo: some seconds of rendering on two cores without a GPU.
const DEMO_SIZE: &str = "640x360";
const DEMO_SPP: &str = "16";
/// The same scene for the README: nobody waits for it, and its noise is taken out.
const PICTURE_SIZE: &str = "800x450";
const PICTURE_SPP: &str = "64";
const PICTURE_FLAGS: [&str; 3] = ["--view", "agx", "--denoise"];

/// The tests of pictures, of rays and of schedules, and of what the window has to show. Of the whole workspace: a package alone would ask for other features, and build its dependencies
/// anew.
const PICTURES: [&str; 5] = ["--workspace", "--test", "suite", "--test", "render"];

/// Devices that the tests of pictures run on beside the usual one, each with the step's name.
const OTHER_DEVICES: [(&str, &str); 1] = [("Tests on a software driver", "llvmpipe")];

/// Tests of pictures that these devices are spared without `--full`: of methods and statistics, which take half of a driver's time, and
/// whose passes are the same texts, made kernels of in the same way, as those of the others.
const LONG_ON_DRIVERS: [&str; 8] = [
    "adaptive::",
    "irradiance::",
    "light_cache::",
    "light_parts::",
    "moments::",
    "photons::",
    "statistics::",
    "transparency::",
];

const DEMO_SCENE: &str = "examples/demo/demo.gltf";
const DEMO_LOOK: &str = "examples/demo/demo.look.toml";

/// Test data that is not part of the project.
const SPONZA: &str = "../shared/scenes/Sponza/Sponza.gltf";
const SPONZA_SIZE: &str = "640x360";
/// Look and picture.
const SPONZA_PICTURES: [(&str, &str); 2] = [
    (
        "examples/sponza-rust.look.toml",
        "docs/images/sponza-rust.jpg",
    ),
    (
        "examples/sponza-scratches.look.toml",
        "docs/images/sponza-scratches.jpg",
    ),
];

/// An interior, with its sky, and how it is shown.
const INTERIOR: &str = "../shared/scenes/interior-living-room/living-room.gltf";
const INTERIOR_PICTURE: &str = "docs/images/living-room.jpg";
const INTERIOR_EXPOSURE: &str = "0.25";

/// Sample models and the light they are shown in.
const MODELS: &str = "../shared/scenes/khronos";
const MODELS_LIGHT: &str = "../shared/scenes/hdri/brown_photostudio_02_1k.hdr";
const MODELS_PICTURE: &str = "docs/images/khronos.jpg";
const MODELS_SPP: &str = "64";
/// Not shown there: one may be used for no commerce, the other comes from a stock of pictures.
const MODELS_HIDDEN: [&str; 2] = ["DamagedHelmet", "EnvironmentTest"];

/// The ball, its materials, and how each is shown.
const GALLERY: &str = "examples/gallery";
const GALLERY_PICTURE: &str = "docs/images/gallery.jpg";
const GALLERY_SIZE: &str = "192x192";
const GALLERY_SPP: &str = "48";

const USAGE: &str = "\
Usage: cargo xtask <COMMAND>

Commands:
  demo          Render the example scene to out/demo.png and out/demo.exr
  test          Check formatting, lints and documentation, and run all tests
  test --full   The same with the tests that take long
  dist          Pack the program with its manual and all licences: out/patina-VERSION-PLATFORM.tar.gz
  pictures      Render the README's pictures to docs/images/
  contact-sheet Render Khronos' sample models, where they lie beside the checkout, to docs/images/khronos.jpg
  gallery       Render the materials of examples/gallery to docs/images/gallery.jpg
  blender       Read our layers with Blender; `cargo xtask blender --help` lists the options
  farm          Render a picture in parts by Slurm on this host, lose a node, compare with the whole
  farm-files    Judge files for other schedulers; `cargo xtask farm-files --help` lists the options
  materialx     Compare MaterialX's nodes with its own; `cargo xtask materialx --help` lists the options
  peers         Compare with other renderers that are installed; `cargo xtask peers --help` lists the options
  poses         Compare vertices of animated models with another evaluation; `cargo xtask poses --help` lists the options
  views         Compare view transforms with OpenColorIO; `cargo xtask views --help` lists the options

`test` first finds a Vulkan driver, or installs Mesa's on Debian and Ubuntu; the others need none.";

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match arguments[..] {
        ["demo"] => demo(),
        ["test"] => test(false),
        ["test", "--full"] => test(true),
        ["dist"] => dist::run(),
        ["pictures"] => pictures(),
        ["contact-sheet"] => contact_sheet(),
        ["gallery"] => gallery(),
        ["blender", "--help" | "-h"] => {
            println!("{}", blender::USAGE);
            Ok(())
        }
        ["blender", ref rest @ ..] => blender::run(rest),
        ["farm"] => farm::run(),
        ["farm-files", "--help" | "-h"] => {
            println!("{}", farm_files::USAGE);
            Ok(())
        }
        ["farm-files", ref rest @ ..] => farm_files::run(rest),
        ["materialx", "--help" | "-h"] => {
            println!("{}", materialx::USAGE);
            Ok(())
        }
        ["materialx", ref rest @ ..] => materialx::run(rest),
        ["peers", "--help" | "-h"] => {
            println!("{}", peers::USAGE);
            Ok(())
        }
        ["peers", ref rest @ ..] => peers::run(rest),
        ["poses", "--help" | "-h"] => {
            println!("{}", poses::USAGE);
            Ok(())
        }
        ["poses", ref rest @ ..] => poses::run(rest),
        ["views", "--help" | "-h"] => {
            println!("{}", views::USAGE);
            Ok(())
        }
        ["views", ref rest @ ..] => views::run(rest),
        ["help" | "--help" | "-h"] => {
            println!("{USAGE}");
            Ok(())
        }
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("\nerror: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// A fresh machine to a first picture.
fn demo() -> Result<()> {
    let mut steps = Steps::new();
    steps.run("Release build", || {
        cargo(["build", "--locked", "--release", "--package", "patina"]).run()
    })?;
    let out = root().join("out");
    fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
    steps.run("Render", || {
        render_demo(DEMO_SIZE, DEMO_SPP, &["out/demo.png", "out/demo.exr"])
    })?;
    steps.finish();
    println!("The pictures are in");
    for name in ["demo.png", "demo.exr"] {
        println!("  {}", out.join(name).display());
    }
    Ok(())
}

/// Everything that must hold before a change is taken in.
fn test(full: bool) -> Result<()> {
    let mut steps = Steps::new();
    steps.run("Vulkan driver", vulkan::ensure)?;
    steps.run("Toolchain", ensure_components)?;
    steps.run("Formatting", || cargo(["fmt", "--all", "--check"]).run())?;
    steps.run("Dependencies", || dist::dependencies(full))?;
    steps.run("Lock of the fuzz targets", fuzz_lock)?;
    steps.run("Lints", || {
        cargo(["clippy", "--locked", "--workspace", "--all-targets"])
            .args(["--", "-D", "warnings"])
            .run()
    })?;
    if full {
        steps.run("Other systems", targets::check_all)?;
    }
    steps.run("Documentation", || {
        cargo(["doc", "--locked", "--workspace", "--no-deps"])
            .env("RUSTDOCFLAGS", "-Dwarnings")
            .run()
    })?;
    steps.run("Test build", || {
        cargo(["test", "--locked", "--workspace", "--no-run"]).run()
    })?;
    steps.run("Devices", || {
        tested_patina()?.args(["devices"]).run()?;
        ensure_driver(|| Ok(tested_patina()?.args(["devices"]).output()))
    })?;
    let short_tests = |scope: &[&'static str]| {
        let tests = cargo(["test", "--locked"]).args(scope.iter().copied());
        tests.env("PATINA_REQUIRE_DEVICE", "1")
    };
    let tests = |scope: &[&'static str]| match full {
        true => short_tests(scope).env("PATINA_FULL", "1"),
        false => short_tests(scope),
    };
    if full {
        steps.run("Screen", || {
            screen::ensure();
            Ok(())
        })?;
    }
    let name = if full { "All tests" } else { "Tests" };
    steps.run(name, || tests(&["--workspace"]).run())?;
    for (name, device) in OTHER_DEVICES {
        let skipped = if full { &[][..] } else { &LONG_ON_DRIVERS };
        let skips = skipped.iter().flat_map(|&tests| ["--skip", tests]);
        let tests = tests(&PICTURES).args(["--"]).args(skips);
        steps.run(name, || tests.env("PATINA_DEVICE", device).run())?;
    }
    if full {
        // It is several times as slow as Mesa's: as a second opinion the short forms will do.
        steps.run("Tests on SwiftShader", || match swiftshader::manifest() {
            // The loader looks for no other driver then; older ones know the other name.
            Some(manifest) => ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"]
                .into_iter()
                .fold(short_tests(&PICTURES), |tests, name| {
                    tests.env(name, &manifest.to_string_lossy())
                })
                .env("PATINA_DEVICE", swiftshader::DEVICE)
                .run(),
            None => Ok(()),
        })?;
        steps.run("Fuzz targets", fuzz_targets)?;
    }
    steps.finish();
    Ok(())
}

/// Where libFuzzer's programs are, no part of the workspace.
const FUZZ_MANIFEST: &str = "engine/fuzz/Cargo.toml";

/// Whether what libFuzzer's programs are built of is as the workspace has it: a package that is added here must be added to their lock,
/// too.
fn fuzz_lock() -> Result<()> {
    let metadata = ["metadata", "--locked", "--quiet", "--format-version", "1"];
    match (cargo(metadata).args(["--manifest-path", FUZZ_MANIFEST])).succeeds() {
        true => Ok(()),
        false => bail!(
            "the lock of {FUZZ_MANIFEST} is out of date; bring it up to date with\n    \
             cargo metadata --format-version 1 --manifest-path {FUZZ_MANIFEST} > /dev/null"
        ),
    }
}

/// Whether libFuzzer's programs would compile. They are no part of the workspace, and what they try has been tried by the
/// tests; libFuzzer itself, which takes a compiler of C++, is linked only where they are run.
fn fuzz_targets() -> Result<()> {
    cargo(["check", "--locked"])
        .args(["--manifest-path", FUZZ_MANIFEST])
        .args(["--target-dir", "target/fuzz"])
        // Its folder is all that is asked for.
        .env("CUSTOM_LIBFUZZER_PATH", "target/none.a")
        .run()
}

/// The README's pictures: the example scene, and Sponza where its test data lies beside the checkout.
fn pictures() -> Result<()> {
    let mut steps = Steps::new();
    steps.run("Release build", || {
        cargo(["build", "--locked", "--release", "--package", "patina"]).run()
    })?;
    let images = root().join("docs/images");
    fs::create_dir_all(&images).with_context(|| format!("cannot create {}", images.display()))?;
    steps.run("docs/images/demo.jpg", || {
        let shot = ["--look", DEMO_LOOK, "--size", PICTURE_SIZE];
        render_picture(DEMO_SCENE, &shot, "docs/images/demo.jpg")
    })?;
    if root().join(INTERIOR).is_file() {
        steps.run(INTERIOR_PICTURE, || {
            let shot = ["--exposure", INTERIOR_EXPOSURE, "--size", PICTURE_SIZE];
            render_picture(INTERIOR, &shot, INTERIOR_PICTURE)
        })?;
    } else {
        println!("{INTERIOR_PICTURE}: skipped, {INTERIOR} is not on this machine");
    }
    for (look, picture) in SPONZA_PICTURES {
        if root().join(SPONZA).is_file() {
            steps.run(picture, || {
                let shot = ["--look", look, "--size", SPONZA_SIZE];
                render_picture(SPONZA, &shot, picture)
            })?;
        } else {
            println!("{picture}: skipped, {SPONZA} is not on this machine");
        }
    }
    steps.finish();
    Ok(())
}

/// All sample models in one picture; fails where one can't be rendered or has samples that are not finite.
fn contact_sheet() -> Result<()> {
    if !root().join(MODELS).is_dir() {
        bail!("{MODELS} is not on this machine: glTF models, each in a folder of its own");
    }
    let mut steps = Steps::new();
    steps.run(MODELS_PICTURE, || {
        cargo([
            "run",
            "--locked",
            "--release",
            "--example",
            "contact_sheet",
            "--",
        ])
        .args([MODELS, MODELS_PICTURE, MODELS_LIGHT, MODELS_SPP])
        .args(MODELS_HIDDEN)
        .run()
    })?;
    steps.finish();
    Ok(())
}

/// All materials of the gallery in one picture.
fn gallery() -> Result<()> {
    let mut steps = Steps::new();
    steps.run("Release build", || {
        cargo(["build", "--locked", "--release", "--package", "patina"])
            .args(["--bin", "patina", "--example", "gallery_sheet"])
            .run()
    })?;
    let tiles = root().join("out/gallery");
    fs::create_dir_all(&tiles).with_context(|| format!("cannot create {}", tiles.display()))?;
    let scene = format!("{GALLERY}/gallery.gltf");
    steps.run("Materials", || {
        for entry in fs::read_dir(root().join(GALLERY))? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            let Some(material) = name.strip_suffix(".look.toml") else {
                continue;
            };
            let look = format!("{GALLERY}/{name}");
            let tile = format!("out/gallery/{material}.png");
            let shot = [
                "--look",
                &look,
                "--size",
                GALLERY_SIZE,
                "--spp",
                GALLERY_SPP,
            ];
            patina(["render", &scene])
                .args(shot)
                .args(["--denoise", "-o", &tile])
                .run()?;
        }
        Ok(())
    })?;
    steps.run(GALLERY_PICTURE, || {
        cargo(["run", "--locked", "--release", "--example", "gallery_sheet"])
            .args(["--", "out/gallery", GALLERY_PICTURE])
            .run()
    })?;
    steps.finish();
    Ok(())
}

fn render_demo(size: &str, spp: &str, outputs: &[&str]) -> Result<()> {
    for input in [DEMO_SCENE, DEMO_LOOK] {
        if !root().join(input).is_file() {
            bail!("{input} is missing; is this a complete checkout?");
        }
    }
    patina(["render", DEMO_SCENE, "--look", DEMO_LOOK])
        .args(["--size", size, "--spp", spp, "--stats"])
        .args(outputs.iter().flat_map(|output| ["-o", output]))
        .run()
}

/// A picture for a page: without noise, which needs Open Image Denoise.
fn render_picture(scene: &str, shot: &[&str], output: &str) -> Result<()> {
    patina(["render", scene])
        .args(shot.iter().copied())
        .args(PICTURE_FLAGS)
        .args(["--spp", PICTURE_SPP, "--stats", "-o", output])
        .run()
}

/// The program, built if it has to be.
fn patina<const N: usize>(arguments: [&str; N]) -> Step {
    cargo([
        "run",
        "--locked",
        "--release",
        "--quiet",
        "--package",
        "patina",
        "--",
    ])
    .args(arguments)
}

/// Looks for a driver's device in the list of `patina devices`. A driver may be installed and still find none (a GPU's
/// driver in a container without that GPU): Mesa's software driver is then added.
fn ensure_driver(devices: impl Fn() -> Result<String>) -> Result<()> {
    let is_there = || Ok::<_, anyhow::Error>(devices()?.contains("vulkan"));
    if cfg!(target_os = "linux") && !is_there()? {
        vulkan::install()?;
        if !is_there()? {
            bail!("the installed Vulkan drivers find no device that can render");
        }
    }
    Ok(())
}

/// The program of the test build. `cargo run` would build it again: alone, its dependencies have fewer features than
/// together with those of the tests.
fn tested_patina() -> Result<Step> {
    let xtask = env::current_exe().context("the path of xtask is unknown")?;
    let patina = xtask.with_file_name(format!("patina{}", env::consts::EXE_SUFFIX));
    Ok(Step::new(patina))
}

/// rustfmt and clippy, which a minimal toolchain lacks.
fn ensure_components() -> Result<()> {
    for (command, component) in [("fmt", "rustfmt"), ("clippy", "clippy")] {
        if cargo([command, "--version"]).succeeds() {
            continue;
        }
        Step::new("rustup")
            .args(["component", "add", component])
            .run()
            .with_context(|| {
                format!("`cargo {command}` is missing; install the component {component} of your Rust toolchain")
            })?;
    }
    Ok(())
}
