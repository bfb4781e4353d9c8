//! `cargo xtask materialx`: what MaterialX's nodes become beside MaterialX's own OSL, run by Cycles, at 256 points each.
//!
//! Python does what takes MaterialX and Blender, in `benches/materialx`. It is optional: nothing that a build needs asks for it.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::steps::{cargo, root};

/// What the command can be told.
pub(crate) const USAGE: &str = "\
Usage: cargo xtask materialx [OPTIONS]

Nodes of MaterialX's standard library beside its own OSL in Cycles; docs/materialx.md says how both are installed.

  --python FILE  Python that has them [default: $PATINA_PEERS_PYTHON, else python3]
  --out DIR      Documents and values go here [default: out/materialx]; values of a former run are used again";

const SCRIPT: &str = "benches/materialx/judge.py";

#[derive(Debug)]
struct Options {
    python: PathBuf,
    out: PathBuf,
}

impl Options {
    fn parse(arguments: &[&str], python: Option<String>) -> Result<Self> {
        let mut options = Self {
            python: python.unwrap_or_else(|| "python3".to_owned()).into(),
            out: "out/materialx".into(),
        };
        let mut arguments = arguments.iter();
        while let Some(&flag) = arguments.next() {
            let value = arguments.next();
            let value = value.with_context(|| format!("{flag} needs a value\n\n{USAGE}"));
            match flag {
                "--python" => options.python = value?.into(),
                "--out" => options.out = value?.into(),
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
    let folder = out.to_str();
    let folder = folder.with_context(|| format!("{} is no text", out.display()))?;
    let points = format!("{folder}/points.f32");
    cargo(["run", "--locked", "--quiet", "--package", "engine"])
        .args(["--example", "materialx_values", "--", folder, &points])
        .run()?;
    script("check")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn flags_are_understood_or_refused() {
        let options = Options::parse(&["--python", "p"], None).expect("flags");
        assert_eq!(options.python, Path::new("p"));
        for line in [&["--out"][..], &["--wrong", "x"]] {
            let error = Options::parse(line, None)
                .expect_err("no flags")
                .to_string();
            assert!(error.contains("Usage"), "{error}");
        }
    }
}
