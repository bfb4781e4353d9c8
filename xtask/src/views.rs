//! `cargo xtask views`: our view transforms beside OpenColorIO's with Blender's configuration, at thousands of colours; with
//! `--write`, the tables that AgX and Filmic are made of.
//!
//! Python does what takes OpenColorIO, in `benches/views`. It is optional: nothing that a build needs asks for it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::steps::{cargo, root};

/// What the command can be told.
pub(crate) const USAGE: &str = "\
Usage: cargo xtask views [OPTIONS]

View transforms beside OpenColorIO with Blender's configuration; docs/view-transforms.md says how both are installed.

  --python FILE  Python that has them [default: $PATINA_PEERS_PYTHON, else python3]
  --config FILE  Blender's config.ocio [default: that of the module bpy]
  --out DIR      Colours and codes go here [default: out/views]
  --write        Sample the tables of AgX and Filmic anew first; needs --config";

const SCRIPTS: &str = "benches/views";
const TABLES: &str = "engine/src/view/tables";
/// As `ViewTransform::name` has them.
const TRANSFORMS: [&str; 5] = ["standard", "agx", "khronos-neutral", "aces2", "filmic"];

struct Options {
    python: PathBuf,
    config: Option<PathBuf>,
    out: PathBuf,
    writes_tables: bool,
}

impl Options {
    fn parse(arguments: &[&str], python: Option<String>) -> Result<Self> {
        let mut options = Self {
            python: python.unwrap_or_else(|| "python3".to_owned()).into(),
            config: None,
            out: "out/views".into(),
            writes_tables: false,
        };
        let mut arguments = arguments.iter();
        while let Some(&flag) = arguments.next() {
            let mut value = || {
                let value = arguments.next();
                value.with_context(|| format!("{flag} needs a value\n\n{USAGE}"))
            };
            match flag {
                "--python" => options.python = value()?.into(),
                "--config" => options.config = Some(value()?.into()),
                "--out" => options.out = value()?.into(),
                "--write" => options.writes_tables = true,
                _ => bail!("there is no {flag}\n\n{USAGE}"),
            }
        }
        if options.writes_tables && options.config.is_none() {
            bail!("--write needs --config\n\n{USAGE}");
        }
        Ok(options)
    }
}

/// Compares, and fails where a code is off by more than 1/255.
///
/// # Errors
/// A flag that makes no sense, Python without what it needs, a difference that is too large.
pub(crate) fn run(arguments: &[&str]) -> Result<()> {
    let options = Options::parse(arguments, std::env::var("PATINA_PEERS_PYTHON").ok())?;
    let out = root().join(&options.out);
    fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
    if let (true, Some(config)) = (options.writes_tables, &options.config) {
        let mut tables = script(&options, "tables.py");
        tables.arg(config).arg(root().join(TABLES));
        finish(tables)?;
    }
    let colors = out.join("colors.f32");
    let mut make = script(&options, "compare.py");
    make.arg("colors").arg(&colors);
    finish(make)?;
    for name in TRANSFORMS {
        let codes = out.join(format!("{name}.f32"));
        cargo(["run", "--locked", "--quiet", "--package", "engine"])
            .args(["--example", "view_colors", "--", name])
            .args([text(&colors)?, text(&codes)?])
            .run()?;
    }
    let mut check = script(&options, "compare.py");
    check.arg("check").arg(&colors).arg(&out);
    check.args(&options.config);
    finish(check)
}

fn script(options: &Options, name: &str) -> Command {
    let mut command = Command::new(&options.python);
    command.arg(root().join(SCRIPTS).join(name));
    command
}

fn finish(mut command: Command) -> Result<()> {
    let status = command.status();
    let status = status.with_context(|| format!("cannot start {command:?}"))?;
    match status.success() {
        true => Ok(()),
        false => bail!("{command:?} failed: {status}"),
    }
}

fn text(path: &Path) -> Result<&str> {
    let text = path.to_str();
    text.with_context(|| format!("{} is no text", path.display()))
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
        let options = parse("--python p --config c --write").expect("flags");
        assert_eq!(options.python, Path::new("p"));
        assert!(options.writes_tables);
        for line in ["--write", "--python", "--wrong"] {
            let error = parse(line).err().expect(line).to_string();
            assert!(error.contains("Usage"), "{error}");
        }
    }
}
