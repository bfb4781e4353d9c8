//! Flags of `cargo xtask peers`, understood before anything is opened.

use std::num::NonZero;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Context, Result, bail};

/// All peers, in the order they take turns. The first is what the others are held against.
pub(super) const PEERS: &[&str] = &["patina", "cycles", "mitsuba", "luxcore"];
/// Those that know the procedural textures.
pub(super) const WITH_TEXTURES: &[&str] = &["patina", "cycles"];

pub(super) const USAGE: &str = "\
Usage: cargo xtask peers [OPTIONS]

Patina beside Cycles, Mitsuba and LuxCore; docs/peers.md says how these are installed.

  --python FILE        Python that has them [default: $PATINA_PEERS_PYTHON, else python3]
  --patina FILE        The program to measure [default: a release build]
  --scenes DIR         Folder with Sponza, interior-living-room and khronos/ToyCar [default: ../shared/scenes]
  --reference DIR      Folder with cornell.glb and ref_mitsuba.exr [default: ../shared/reference/cornell]
  --out DIR            Scenes, pictures and the report go here [default: out/peers]
  --only LIST          Of cornell, sponza, living-room, knot, sponza-model; the last two are for textures [default: all]
  --peers LIST         Of patina, cycles, mitsuba, luxcore [default: all]
  --spp LIST           Samples per pixel of the renders whose errors are taken, ascending [default: 4,16,64]
  --reference-spp N    Of references that are made here [default: 1024]
  --reference-by PEER  Makes the references of all peers [default: each makes its own]
  --shrink N           Divides width and height of all pictures [default: 1]
  --texture-spp N      Of the renders with textures [default: 16]
  --ao-rays LIST       Rays of ambient occlusion at a hit of a texture [default: 4,16]
  --runs N             Runs of everything, peers in turn [default: 3]
  --threads N          [default: as many as the machine has]
  --max-depth N        Surface points that scatter light along a path [default: 9]
  --through COMMAND    Prefix of each measured job, such as `taskset -c 0-3`
  --prepare            Only write scenes and references
  --resume             Keep what has been measured in --out by the same jobs";

/// What is measured and with what.
#[derive(Debug, PartialEq)]
pub(super) struct Options {
    pub(super) python: PathBuf,
    pub(super) patina: Option<PathBuf>,
    pub(super) scenes: PathBuf,
    pub(super) reference: PathBuf,
    pub(super) out: PathBuf,
    /// Empty for all.
    pub(super) only: Vec<String>,
    pub(super) peers: Vec<String>,
    pub(super) spp: Vec<u32>,
    pub(super) reference_spp: u32,
    /// `None` where each peer makes its own.
    pub(super) reference_by: Option<String>,
    /// Divides width and height.
    pub(super) shrink: u32,
    pub(super) texture_spp: u32,
    pub(super) ao_rays: Vec<u32>,
    pub(super) runs: u32,
    pub(super) threads: u32,
    pub(super) max_depth: u32,
    pub(super) through: Vec<String>,
    pub(super) prepare: bool,
    pub(super) resume: bool,
}

impl Options {
    /// `python` is what the environment names.
    ///
    /// # Errors
    /// The first flag that makes no sense, with the usage.
    pub(super) fn parse(arguments: &[&str], python: Option<String>) -> Result<Self> {
        let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
        let mut options = Self {
            python: python.unwrap_or_else(|| "python3".to_owned()).into(),
            patina: None,
            scenes: "../shared/scenes".into(),
            reference: "../shared/reference/cornell".into(),
            out: "out/peers".into(),
            only: Vec::new(),
            peers: words(&PEERS.join(",")),
            spp: vec![4, 16, 64],
            reference_spp: 1024,
            reference_by: None,
            shrink: 1,
            texture_spp: 16,
            ao_rays: vec![4, 16],
            runs: 3,
            threads: threads as u32,
            max_depth: 9,
            through: Vec::new(),
            prepare: false,
            resume: false,
        };
        let mut arguments = arguments.iter().copied();
        while let Some(flag) = arguments.next() {
            match flag {
                "--prepare" => options.prepare = true,
                "--resume" => options.resume = true,
                _ => {
                    let value = arguments.next();
                    let value =
                        value.with_context(|| format!("{flag} needs a value\n\n{USAGE}"))?;
                    options.set(flag, value)?;
                }
            }
        }
        Ok(options)
    }

    fn set(&mut self, flag: &str, value: &str) -> Result<()> {
        match flag {
            "--python" => self.python = value.into(),
            "--patina" => self.patina = Some(value.into()),
            "--scenes" => self.scenes = value.into(),
            "--reference" => self.reference = value.into(),
            "--out" => self.out = value.into(),
            "--only" => self.only = words(value),
            "--peers" => {
                self.peers = words(value);
                for name in &self.peers {
                    known(flag, name)?;
                }
            }
            "--spp" => {
                self.spp = numbers(flag, value)?;
                if !self.spp.is_sorted_by(|a, b| a < b) {
                    bail!("--spp {value}: numbers must ascend");
                }
            }
            "--reference-spp" => self.reference_spp = number(flag, value)?,
            "--reference-by" => {
                known(flag, value)?;
                self.reference_by = Some(value.to_owned());
            }
            "--shrink" => self.shrink = number(flag, value)?,
            "--texture-spp" => {
                self.texture_spp = number(flag, value)?;
                // Patina holds its pictures against each other, by standard errors.
                if self.texture_spp < 2 {
                    bail!("{flag} {value}: not a number from 2");
                }
            }
            "--ao-rays" => self.ao_rays = numbers(flag, value)?,
            "--runs" => self.runs = number(flag, value)?,
            "--threads" => self.threads = number(flag, value)?,
            "--max-depth" => self.max_depth = number(flag, value)?,
            "--through" => self.through = value.split_whitespace().map(str::to_owned).collect(),
            _ => bail!("there is no flag {flag}\n\n{USAGE}"),
        }
        Ok(())
    }
}

/// # Errors
/// There is no peer of that name.
fn known(flag: &str, name: &str) -> Result<()> {
    if !PEERS.contains(&name) {
        bail!("{flag}: there is no `{name}`, but {}", PEERS.join(", "));
    }
    Ok(())
}

fn words(list: &str) -> Vec<String> {
    list.split(',').map(|word| word.trim().to_owned()).collect()
}

/// A number from 1.
fn number(flag: &str, value: &str) -> Result<u32> {
    match u32::from_str(value.trim()) {
        Ok(number) if number > 0 => Ok(number),
        _ => bail!("{flag} {value}: not a number from 1"),
    }
}

fn numbers(flag: &str, value: &str) -> Result<Vec<u32>> {
    value.split(',').map(|word| number(flag, word)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_measure_everything() {
        let options = Options::parse(&[], None).unwrap();
        assert_eq!(options.peers, PEERS);
        assert_eq!(options.python, PathBuf::from("python3"));
        assert!(options.only.is_empty() && options.through.is_empty());
    }

    #[test]
    fn flags_are_understood() {
        let line = "--peers patina,cycles --spp 1,8 --only knot --through \"nice -n 1\" --resume";
        let mut given: Vec<&str> = line.split(' ').collect();
        // As a shell passes it.
        given.splice(7..10, ["nice -n 1"]);
        let options = Options::parse(&given, Some("/venv/bin/python".to_owned())).unwrap();
        assert_eq!(options.python, PathBuf::from("/venv/bin/python"));
        assert_eq!(options.peers, ["patina", "cycles"]);
        assert_eq!(options.spp, [1, 8]);
        assert_eq!(options.through, ["nice", "-n", "1"]);
        assert!(options.resume && !options.prepare);
    }

    #[test]
    fn senseless_flags_are_refused() {
        for (given, because) in [
            (["--peers", "povray"], "povray"),
            (["--spp", "64,4"], "ascend"),
            (["--runs", "0"], "--runs 0"),
            (["--texture-spp", "1"], "from 2"),
            (["--reference-by", "nobody"], "nobody"),
            (["--speed", "fast"], "--speed"),
            (["--resume", "--runs"], "needs a value"),
        ] {
            let error = Options::parse(&given, None).unwrap_err().to_string();
            assert!(error.contains(because), "{given:?}: {error}");
        }
    }
}
