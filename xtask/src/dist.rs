//! The program as it is given away, and what it may be built of. Packing itself is the crate `dist`.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::steps::{Step, Steps, cargo, root};

/// What is built here stays apart: other flags build everything anew.
const TARGET: &str = "target/dist";
const OUT: &str = "out";

/// Builds the program without anything of this machine in it, and packs it.
pub(crate) fn run() -> Result<()> {
    let mut steps = Steps::new();
    let places = Places::of_this_machine()?;
    steps.run("Release build", || {
        cargo(["build", "--locked", "--release", "--package", "patina"])
            .args(["--target-dir", TARGET])
            .args(["--config", "profile.release.strip=true"])
            .args(["--config", "profile.release.debug=false"])
            .env("CARGO_ENCODED_RUSTFLAGS", &places.flags())
            .run()
    })?;
    let program = format!("{TARGET}/release/patina{}", env::consts::EXE_SUFFIX);
    steps.run("Paths of this machine", || {
        packer("paths")
            .args([program.as_str()])
            .args(places.names().iter().map(String::as_str))
            .run()
    })?;
    steps.run("Archive", || packer("pack").args([&program, OUT]).run())?;
    steps.finish();
    Ok(())
}

/// What cargo-deny says of `deny.toml`. The tests hold all of the file but its advisories against Cargo's own
/// information, so that nothing depends on this tool; it takes long to build and is installed for long runs only.
pub(crate) fn dependencies(full: bool) -> Result<()> {
    let is_there = || cargo(["deny", "--version"]).succeeds();
    if full && !is_there() {
        cargo(["install", "--locked", "cargo-deny"]).run()?;
    }
    if !is_there() {
        println!(
            "cargo-deny is not installed: the tests check licences, bans and sources, nothing checks advisories.\n\
             `cargo xtask test --full` installs it, or `cargo install --locked cargo-deny`."
        );
        return Ok(());
    }
    let check = || cargo(["deny", "--locked", "check"]);
    check().args(["licenses", "bans", "sources"]).run()?;
    // The list of advisories is fetched from another place than packages, which not every machine reaches.
    match cargo(["deny", "--locked", "fetch", "db"]).succeeds() {
        true => cargo(["deny", "--frozen", "check", "advisories"]).run(),
        false => {
            println!("the list of advisories can't be fetched: they are not checked");
            Ok(())
        }
    }
}

fn packer(what: &str) -> Step {
    cargo([
        "run",
        "--locked",
        "--quiet",
        "--package",
        "dist",
        "--",
        what,
    ])
}

/// Folders that compilers write into programs.
struct Places {
    /// The folder and what is written instead.
    renamed: Vec<(PathBuf, &'static str)>,
    /// Flags of the user.
    flags: Vec<String>,
}

impl Places {
    fn of_this_machine() -> Result<Self> {
        let home = |variable: &str, folder: &str| {
            let named = env::var_os(variable).map(PathBuf::from);
            named.or_else(|| Some(env::home_dir()?.join(folder)))
        };
        let cargo = home("CARGO_HOME", ".cargo").context("there is no home folder")?;
        let sysroot = Step::new("rustc").args(["--print", "sysroot"]).output();
        let given = match env::var("CARGO_ENCODED_RUSTFLAGS") {
            Ok(flags) => flags.split('\u{1f}').map(str::to_owned).collect(),
            Err(_) => {
                let flags = env::var("RUSTFLAGS").unwrap_or_default();
                flags.split_whitespace().map(str::to_owned).collect()
            }
        };
        // The last that fits is taken: what lies inside another one comes later.
        let sources = cargo.join("registry/src");
        let mut renamed = vec![(sources.clone(), "registry")];
        let registries = fs::read_dir(sources).into_iter().flatten().flatten();
        renamed.extend(registries.map(|registry| (registry.path(), "registry")));
        let standard_library = Path::new(sysroot.trim()).join("lib/rustlib/src/rust");
        renamed.push((standard_library, "rust"));
        renamed.push((root().to_owned(), "patina"));
        renamed.push((root().join(TARGET), "build"));
        Ok(Self {
            renamed,
            flags: given,
        })
    }

    /// For `CARGO_ENCODED_RUSTFLAGS`.
    fn flags(&self) -> String {
        let renamed = self.renamed.iter();
        let renamed =
            renamed.map(|(from, to)| format!("--remap-path-prefix={}={to}", from.display()));
        let flags: Vec<String> = self.flags.iter().cloned().chain(renamed).collect();
        flags.join("\u{1f}")
    }

    /// What the program must not hold.
    fn names(&self) -> Vec<String> {
        let folders = self.renamed.iter().map(|(folder, _)| folder.clone());
        let mut names: Vec<String> = folders
            .chain(env::home_dir())
            .map(|folder| format!("{}/", folder.display()))
            .collect();
        names.sort();
        names.dedup();
        names
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_of_this_machine_are_renamed_and_looked_for() {
        let places = Places::of_this_machine().expect("a machine that builds has them");
        let flags = places.flags();
        let own = format!("--remap-path-prefix={}=patina", root().display());
        assert!(flags.split('\u{1f}').any(|flag| flag == own), "{flags}");
        let names = places.names();
        assert!(
            names.contains(&format!("{}/", root().display())),
            "{names:?}"
        );
    }
}
