//! `cargo xtask materialx`: what MaterialX's nodes become beside MaterialX's own OSL, run by Cycles, at 256 points each; and twelve
//! of its example materials beside Cycles' pictures of them.
//!
//! Python does what takes MaterialX and Blender, in `benches/materialx`. It is optional: nothing that a build needs asks for it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::steps::{cargo, root};

/// What the command can be told.
pub(crate) const USAGE: &str = "\
Usage: cargo xtask materialx [OPTIONS]

Nodes of MaterialX's standard library beside its own OSL in Cycles; docs/materialx.md says how both are installed.

  --python FILE  Python that has them [default: $PATINA_PEERS_PYTHON, else python3]
  --out DIR      Documents and values go here [default: out/materialx]; values of a former run are used again
  --examples DIR In place of nodes, twelve materials of the documents below DIR: pictures go to OUT/examples, the sheet of all
                 is OUT/examples/sheet.jpg";

const SCRIPT: &str = "benches/materialx/judge.py";
const EXAMPLES: &str = "benches/materialx/examples.py";
/// As the script renders its own.
const SHOT: [&str; 8] = [
    "--size",
    "192x192",
    "--spp",
    "256",
    "--max-depth",
    "12",
    "--device",
    "native",
];

#[derive(Debug)]
struct Options {
    python: PathBuf,
    out: PathBuf,
    examples: Option<PathBuf>,
}

impl Options {
    fn parse(arguments: &[&str], python: Option<String>) -> Result<Self> {
        let mut options = Self {
            python: python.unwrap_or_else(|| "python3".to_owned()).into(),
            out: "out/materialx".into(),
            examples: None,
        };
        let mut arguments = arguments.iter();
        while let Some(&flag) = arguments.next() {
            let value = arguments.next();
            let value = value.with_context(|| format!("{flag} needs a value\n\n{USAGE}"));
            match flag {
                "--python" => options.python = value?.into(),
                "--out" => options.out = value?.into(),
                "--examples" => options.examples = Some(value?.into()),
                _ => bail!("there is no {flag}\n\n{USAGE}"),
            }
        }
        Ok(options)
    }
}

/// Renders the references, computes our values, compares.
///
/// # Errors
/// A flag that makes no sense, Python without what it needs.
pub(crate) fn run(arguments: &[&str]) -> Result<()> {
    let options = Options::parse(arguments, std::env::var("PATINA_PEERS_PYTHON").ok())?;
    let out = root().join(&options.out);
    fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
    if let Some(examples) = &options.examples {
        return pictures(&options.python, &out.join("examples"), examples);
    }
    let script = |step: &str| -> Result<()> {
        let mut command = Command::new(&options.python);
        command.arg(root().join(SCRIPT)).arg(step).arg(&out);
        let status = command.status();
        let status = status.with_context(|| format!("cannot start {command:?}"))?;
        match status.success() {
            true => Ok(()),
            false => bail!("{command:?} failed: {status}"),
        }
    };
    script("make")?;
    script("images")?;
    let folder = out.to_str();
    let folder = folder.with_context(|| format!("{} is no text", out.display()))?;
    let points = format!("{folder}/points.f32");
    cargo(["run", "--locked", "--quiet", "--package", "engine"])
        .args(["--example", "materialx_values", "--", folder, &points])
        .run()?;
    script("check")
}

/// Renders the examples, says how far each is from Cycles' picture, puts all on one sheet.
fn pictures(python: &Path, out: &Path, examples: &Path) -> Result<()> {
    let examples = std::path::absolute(examples)?;
    let script = |arguments: [&Path; 3]| {
        let mut command = Command::new(python);
        let status = command.arg(root().join(EXAMPLES)).args(arguments).status();
        let status = status.with_context(|| format!("cannot start {command:?}"))?;
        ensure!(status.success(), "{command:?} failed: {status}");
        Ok(())
    };
    script([Path::new("make"), out, &examples])?;
    let patina = |command: &str| {
        let start = ["run", "--locked", "--quiet", "--package", "patina", "--"];
        cargo(start).args([command])
    };
    let text = |path: &Path| path.to_string_lossy().into_owned();
    let mut looks: Vec<String> = (fs::read_dir(out)?)
        .map(|entry| entry.map(|entry| text(&entry.path())))
        .collect::<Result<_, _>>()?;
    looks.retain(|path| path.ends_with(".look.toml"));
    looks.sort();
    let scene = text(&out.join("ball.gltf"));
    for look in &looks {
        let name = look.trim_end_matches(".look.toml");
        let (ours, theirs) = (format!("{name}.patina.exr"), format!("{name}.cycles.exr"));
        let render = patina("render").args([&*scene, "--look", look, "-o", &ours]);
        render.args(SHOT).run()?;
        patina("compare").args([&*ours, &theirs]).run()?;
    }
    script([Path::new("sheet"), out, &out.join("sheet.jpg")])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_understood_or_refused() {
        let options = Options::parse(&["--python", "p"], None).expect("flags");
        assert_eq!(options.python, Path::new("p"));
        let options = Options::parse(&["--examples", "e"], None).expect("flags");
        assert_eq!(options.examples.as_deref(), Some(Path::new("e")));
        for line in [&["--out"][..], &["--wrong", "x"]] {
            let error = Options::parse(line, None)
                .expect_err("no flags")
                .to_string();
            assert!(error.contains("Usage"), "{error}");
        }
    }
}
