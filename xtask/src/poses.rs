//! `cargo xtask poses`: where the vertices of animated sample models are, beside an evaluation in Python that shares nothing with the
//! program's own: it reads the files by itself, in `benches/poses`.
//!
//! It is optional: nothing that a build needs asks for it.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::MODELS;
use crate::steps::{cargo, root};

/// What the command can be told.
pub(crate) const USAGE: &str = "\
Usage: cargo xtask poses [OPTIONS]

Vertices of animated sample models at three times each, beside an evaluation by numpy.

  --python FILE  Python that has numpy [default: $PATINA_PEERS_PYTHON, else python3]
  --models DIR   The models, each in a folder of its own [default: ../shared/scenes/khronos]";

const SCRIPT: &str = "benches/poses/compare.py";
/// Skins, morph targets, every kind of interpolation, nodes, a hierarchy of skeletons.
const ANIMATED: [&str; 8] = [
    "CesiumMan",
    "MorphStressTest",
    "InterpolationTest",
    "BoxAnimated",
    "AnimatedMorphCube",
    "SimpleSkin",
    "RiggedSimple",
    "RecursiveSkeletons",
];
/// Seconds: at the first key, between keys, later.
const TIMES: [&str; 3] = ["0", "0.37", "1.234"];

struct Options {
    python: PathBuf,
    models: PathBuf,
}

impl Options {
    fn parse(arguments: &[&str], python: Option<String>) -> Result<Self> {
        let mut options = Self {
            python: python.unwrap_or_else(|| "python3".to_owned()).into(),
            models: root().join(MODELS),
        };
        let mut arguments = arguments.iter();
        while let Some(&flag) = arguments.next() {
            let value = arguments.next();
            let value = value.with_context(|| format!("{flag} needs a value\n\n{USAGE}"));
            match flag {
                "--python" => options.python = value?.into(),
                "--models" => options.models = value?.into(),
                _ => bail!("there is no {flag}\n\n{USAGE}"),
            }
        }
        Ok(options)
    }
}

/// Compares, and fails where a vertex is somewhere else.
///
/// # Errors
/// A flag that makes no sense, no models, Python without numpy, a difference.
pub(crate) fn run(arguments: &[&str]) -> Result<()> {
    let options = Options::parse(arguments, std::env::var("PATINA_PEERS_PYTHON").ok())?;
    let mut compared = 0;
    for name in ANIMATED {
        let Some(model) = model(&options.models.join(name)) else {
            println!("{name}: skipped, it is not in {}", options.models.display());
            continue;
        };
        let path = model.to_str();
        let path = path.with_context(|| format!("{} is no text", model.display()))?;
        let lines = cargo(["run", "--locked", "--quiet", "--package", "scene"])
            .args(["--example", "positions", "--", path])
            .args(TIMES)
            .output();
        if lines.lines().count() != TIMES.len() {
            bail!("{name}: its vertices can't be read");
        }
        let mut python = Command::new(&options.python)
            .arg(root().join(SCRIPT))
            .arg(&model)
            .stdin(Stdio::piped())
            .spawn()
            .with_context(|| format!("cannot start {}", options.python.display()))?;
        if let Some(mut stdin) = python.stdin.take() {
            // One that has given up says why by itself.
            let _ = stdin.write_all(lines.as_bytes());
        }
        let status = python.wait()?;
        if !status.success() {
            bail!("{name}: {SCRIPT} failed: {status}");
        }
        compared += 1;
    }
    match compared {
        0 => bail!("there are no models in {}", options.models.display()),
        _ => Ok(()),
    }
}

/// The glTF file in a folder.
fn model(folder: &Path) -> Option<PathBuf> {
    let files = std::fs::read_dir(folder).ok()?;
    let mut files = files.filter_map(|file| Some(file.ok()?.path()));
    files.find(|file| file.extension().is_some_and(|e| e == "glb" || e == "gltf"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_understood_or_refused() {
        let parse = |line: &str| {
            let words: Vec<&str> = line.split_whitespace().collect();
            Options::parse(&words, None)
        };
        let options = parse("--python p --models m").expect("flags");
        assert_eq!((options.python, options.models), ("p".into(), "m".into()));
        for line in ["--python", "--wrong x"] {
            let error = parse(line).err().expect(line).to_string();
            assert!(error.contains("Usage"), "{error}");
        }
    }
}
