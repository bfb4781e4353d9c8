//! `cargo xtask farm-files`: the files that `patina farm export` writes, judged by what their schedulers' makers give away:
//! `OpenCue`'s by its own writer of jobs, Open Job Description's by its own checker, Flamenco's compiled by node with a stand-in for
//! its manager. Slurm's are run for real by `cargo xtask farm`.
//!
//! It is optional: nothing that a build needs asks for it.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::DEMO_SCENE;
use crate::steps::{Step, cargo, root};

/// What the command can be told.
pub(crate) const USAGE: &str = "\
Usage: cargo xtask farm-files [OPTIONS]

Files of `patina farm export`, judged by tools of the schedulers' makers; docs/farm.md says which, and how they are installed.

  --python FILE  Python that has them [default: $PATINA_PEERS_PYTHON, else python3]
  --node FILE    Node [default: node]";

const SCRIPTS: &str = "benches/farm";
const PARTS: &str = "7";

struct Options {
    python: PathBuf,
    node: PathBuf,
}

impl Options {
    fn parse(arguments: &[&str], python: Option<String>) -> Result<Self> {
        let mut options = Self {
            python: python.unwrap_or_else(|| "python3".to_owned()).into(),
            node: "node".into(),
        };
        let mut arguments = arguments.iter();
        while let Some(&flag) = arguments.next() {
            let value = arguments.next();
            let value = value.with_context(|| format!("{flag} needs a value\n\n{USAGE}"));
            match flag {
                "--python" => options.python = value?.into(),
                "--node" => options.node = value?.into(),
                _ => bail!("there is no {flag}\n\n{USAGE}"),
            }
        }
        Ok(options)
    }
}

/// Writes the files, and has them judged.
///
/// # Errors
/// A flag that makes no sense, tools that aren't there, files that are wrong.
pub(crate) fn run(arguments: &[&str]) -> Result<()> {
    let options = Options::parse(arguments, std::env::var("PATINA_PEERS_PYTHON").ok())?;
    // Words that need care in a shell and in XML.
    let out = root().join("out/farm files & more");
    let _ = fs::remove_dir_all(&out);
    fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
    let export = |scheduler: &str, file: &str| {
        let words = "run --locked --quiet --package patina -- farm export --parts";
        let job = text(&out.join(scheduler))?;
        let scene = text(&root().join(DEMO_SCENE))?;
        cargo(words.split(' '))
            .args([PARTS, "--to", scheduler, "--result", "a.png"])
            .args(["-o", &job, &scene])
            .run()?;
        text(&Path::new(&job).join(file))
    };
    let script = |name: &str| text(&root().join(SCRIPTS).join(name));
    let job = export("opencue", "job.opencue.xml")?;
    Step::new(&options.python)
        .args([script("opencue.py")?.as_str(), &job])
        .run()?;
    let job = export("openjd", "job.openjd.json")?;
    Step::new(&options.python)
        .args(["-m", "openjd", "check", &job])
        .run()?;
    let job = export("flamenco", "patina.js")?;
    Step::new(&options.node)
        .args([script("flamenco.js")?.as_str(), &job, PARTS])
        .run()
}

fn text(path: &Path) -> Result<String> {
    let text = path.to_str().map(str::to_owned);
    text.with_context(|| format!("{} is no text", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_understood_or_refused() {
        let parse = |line: &str| {
            let words: Vec<&str> = line.split_whitespace().collect();
            Options::parse(&words, Some("q".to_owned()))
        };
        let options = parse("--node n").expect("flags");
        assert_eq!((options.python, options.node), ("q".into(), "n".into()));
        for line in ["--python", "--wrong x"] {
            let error = parse(line).err().expect(line).to_string();
            assert!(error.contains("Usage"), "{error}");
        }
    }
}
