//! Packs the program for those who build nothing, and holds what it is built of to `deny.toml`. `cargo xtask dist` and
//! `cargo xtask test` call it; it is no part of `xtask`, which has to be built before anything else can happen.

mod archive;
mod arrows;
mod licences;
mod metadata;
mod paths;
mod policy;
mod rooms;

use std::path::Path;
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

use metadata::Metadata;
use policy::Policy;

const USAGE: &str = "\
Usage: dist check                  Hold all dependencies to deny.toml, and crates and modules to their arrows
       dist pack PROGRAM FOLDER    Pack a program that has been built into FOLDER/patina-VERSION-PLATFORM.tar.gz
       dist paths PROGRAM PATH...  Fail where a program holds one of these paths of this machine";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match arguments[..] {
        ["check"] => check(),
        ["pack", program, folder] => pack(program, folder),
        ["paths", program, ref paths @ ..] => paths::check(program.as_ref(), paths),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The tests do so as well.
fn check() -> Result<()> {
    let metadata = Metadata::read(root(), None)?;
    let violations = Policy::read()?.violations(&metadata);
    if !violations.is_empty() {
        bail!("deny.toml forbids:\n  {}", violations.join("\n  "));
    }
    let wrong = arrows::wrong_arrows(&metadata);
    if !wrong.is_empty() {
        bail!("crates know what they must not:\n  {}", wrong.join("\n  "));
    }
    let wrong = rooms::wrong_rooms(&metadata)?;
    match wrong.is_empty() {
        true => Ok(()),
        false => bail!("modules know what they must not:\n  {}", wrong.join("\n  ")),
    }
}

fn pack(program: &str, folder: &str) -> Result<()> {
    let archive = archive::pack(program.as_ref(), folder.as_ref())?;
    println!("{}", archive.display());
    Ok(())
}

/// The folder of the workspace.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("this crate lies inside the workspace")
}

/// The platform that programs are built for, as rustc calls it.
///
/// # Errors
/// There is no rustc.
pub(crate) fn platform() -> Result<String> {
    let output = Command::new("rustc").arg("-vV").output();
    let output = output.context("cannot start rustc")?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    match text.lines().find_map(|line| line.strip_prefix("host: ")) {
        Some(host) => Ok(host.to_owned()),
        None => bail!("rustc doesn't tell its platform"),
    }
}
