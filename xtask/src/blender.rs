//! `cargo xtask blender`: whether Blender reads the layers of our EXR files by name, whether the parts of the light add up to
//! the picture there, and whether its Cryptomatte node finds what materials cover.
//!
//! Python does what takes Blender, in `benches/blender`. It is optional: nothing that a build needs asks for it.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::DEMO_SCENE;
use crate::steps::{cargo, root};

/// What the command can be told.
pub(crate) const USAGE: &str = "\
Usage: cargo xtask blender [OPTIONS]

Reads layers of a render with Blender; docs/layers.md says how it is installed.

  --python FILE  Python that has the module bpy [default: $PATINA_PEERS_PYTHON, else python3]
  --out DIR      Pictures go here [default: out/blender]";

const SCRIPT: &str = "benches/blender/layers.py";
/// The demo's materials whose coverage is looked at.
const MATTES: [&str; 3] = ["ValvePaint", "BoltIron", "Meadow"];
/// What the demo's own look hasn't: groups of lights, a shadow catcher, and a node that is a layer.
const LOOK: &str = "environment = { sky = { sun_elevation = 30 }, group = \"day\" }\n[light.sun]\ngroup = \"sun\"\n\
    [node.wear]\ntexture = \"fbm\"\n[material.ValvePaint]\nroughness = \"wear.x\"\n[material.Meadow]\nshadow_catcher = true\n";
const NODE: &str = "node:wear";
const SHOT: [&str; 6] = ["--size", "160x90", "--spp", "64", "--device", "native"];

struct Options {
    python: PathBuf,
    out: PathBuf,
}

impl Options {
    fn parse(arguments: &[&str], python: Option<String>) -> Result<Self> {
        let mut options = Self {
            python: python.unwrap_or_else(|| "python3".to_owned()).into(),
            out: "out/blender".into(),
        };
        let mut arguments = arguments.iter();
        while let Some(&flag) = arguments.next() {
            let mut value = || {
                let value = arguments.next();
                value.with_context(|| format!("{flag} needs a value\n\n{USAGE}"))
            };
            match flag {
                "--python" => options.python = value()?.into(),
                "--out" => options.out = value()?.into(),
                _ => bail!("there is no {flag}\n\n{USAGE}"),
            }
        }
        Ok(options)
    }
}

/// Renders, and fails where Blender sees something else.
///
/// # Errors
/// A flag that makes no sense, Python without Blender, a layer that is missing or wrong.
pub(crate) fn run(arguments: &[&str]) -> Result<()> {
    let options = Options::parse(arguments, std::env::var("PATINA_PEERS_PYTHON").ok())?;
    let out = root().join(&options.out);
    fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
    cargo(["build", "--locked", "--release", "--package", "patina"]).run()?;
    let (picture, facts) = (out.join("layers.exr"), out.join("layers.json"));
    let look = out.join("groups.look.toml");
    fs::write(&look, LOOK)?;
    let help = output(patina().args(["render", "--help"]))?;
    let layers = format!("{},{NODE}", every_layer(&help)?);
    let mut render = render(&look);
    render
        .args(["--exr-float", "all", "--layers", &layers, "-o"])
        .arg(&picture);
    output(&mut render)?;
    let mut info = patina();
    info.args(["info", "--json"]).arg(&picture);
    fs::write(&facts, output(&mut info)?)?;

    let names = material_names()?;
    let mut check = Command::new(&options.python);
    check
        .arg(root().join(SCRIPT))
        .args([&picture, &facts, &out]);
    for matte in MATTES {
        ensure!(
            names.iter().any(|n| n == matte),
            "the demo has no material {matte}"
        );
        let (look, truth) = (
            out.join("matte.look.toml"),
            out.join(format!("{matte}.exr")),
        );
        fs::write(&look, matte_look(&names, matte))?;
        let mut render = self::render(&look);
        render
            .args(["--exr-float", "all", "--max-depth", "1", "-o"])
            .arg(&truth);
        output(&mut render)?;
        check.arg(matte).arg(&truth);
    }
    let status = check.status();
    let status = status.with_context(|| format!("cannot start {check:?}"))?;
    ensure!(status.success(), "Blender sees something else: {status}");
    Ok(())
}

/// The program as it is built for release: Cargo's folder isn't always the usual one, but is the one that this program lies in.
fn patina() -> Command {
    let name = format!("patina{}", std::env::consts::EXE_SUFFIX);
    let own = std::env::current_exe().unwrap_or_default();
    let folder = own.ancestors().nth(2).map(Path::to_owned);
    let folder = folder.unwrap_or_else(|| root().join("target"));
    Command::new(folder.join("release").join(name))
}

fn render(look: &Path) -> Command {
    let mut command = patina();
    command.arg("render").arg(root().join(DEMO_SCENE));
    command.arg("--look").arg(look).args(SHOT);
    command
}

/// What a command prints.
fn output(command: &mut Command) -> Result<String> {
    let output = command.output();
    let output = output.with_context(|| format!("cannot start {command:?}"))?;
    let errors = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{command:?} failed: {errors}");
    Ok(String::from_utf8(output.stdout)?)
}

/// The words that `--layers` takes, as its help lists them.
fn every_layer(help: &str) -> Result<String> {
    let (_, flag) = help
        .split_once("--layers ")
        .context("no --layers in the help")?;
    let words = flag.split_once("[possible values: ");
    let (_, words) = words.context("the help lists no layers")?;
    let (words, _) = words.split_once(']').context("the list has no end")?;
    let words = words
        .split(',')
        .map(str::trim)
        .filter(|word| *word != "combined");
    Ok(words.collect::<Vec<_>>().join(","))
}

fn material_names() -> Result<Vec<String>> {
    let text = output(
        patina()
            .args(["info", "--json"])
            .arg(root().join(DEMO_SCENE)),
    )?;
    let facts: serde_json::Value = serde_json::from_str(&text)?;
    let list = facts["materials"].as_array().context("no materials")?;
    let names = list.iter().filter_map(|material| material["name"].as_str());
    Ok(names.map(str::to_owned).collect())
}

/// A look in which one material is white, all others are black, and nothing has a shade.
fn matte_look(names: &[String], white: &str) -> String {
    let mut look = "environment = { color = [0, 0, 0] }\n".to_owned();
    for name in names {
        let value = if name == white { "1.0" } else { "0.0" };
        let _ = writeln!(
            look,
            "[material.{name:?}]\nunlit = true\nbase_color = [{value}, {value}, {value}]"
        );
    }
    look
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_understood_or_refused() {
        let options = Options::parse(&["--out", "x"], Some("py".to_owned())).expect("fine");
        assert_eq!((options.out, options.python), ("x".into(), "py".into()));
        assert!(Options::parse(&["--out"], None).is_err());
        assert!(Options::parse(&["--nonsense"], None).is_err());
    }

    #[test]
    fn a_matte_is_one_material() {
        let names = ["A".to_owned(), "B b".to_owned()];
        let look = matte_look(&names, "A");
        assert!(look.contains("[material.\"A\"]\nunlit = true\nbase_color = [1.0, 1.0, 1.0]"));
        assert!(look.contains("[material.\"B b\"]\nunlit = true\nbase_color = [0.0, 0.0, 0.0]"));
    }
}
