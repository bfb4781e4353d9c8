//! Whether the program would compile for systems and processors other than this one, as far as Rust's targets for them are
//! installed or can be.

use std::path::Path;

use anyhow::Result;

use crate::steps::{Step, cargo};

/// Targets, each with the package that is checked with all that it depends on: where that is the program itself, no
/// compiler of C is needed for it.
const TARGETS: [(&str, &str); 4] = [
    ("wasm32-unknown-unknown", "engine"),
    ("aarch64-unknown-linux-gnu", "engine"),
    ("aarch64-apple-darwin", "patina"),
    ("x86_64-pc-windows-msvc", "patina"),
];
/// Checks all of them: for browsers the engine, else the program.
///
/// # Errors
/// It doesn't compile for one of them.
pub(crate) fn check_all() -> Result<()> {
    TARGETS.into_iter().try_for_each(check)
}

fn check((target, package): (&str, &str)) -> Result<()> {
    let add = || Step::new("rustup").args(["target", "add", target]);
    if !is_installed(target) && !add().succeeds() {
        println!("skipped: {target} is not installed, nor does `rustup target add {target}` do it");
        return Ok(());
    }
    cargo(["check", "--locked", "--package", package])
        .args(["--target", target])
        .run()
}

/// Whether there is a standard library for a target.
fn is_installed(target: &str) -> bool {
    let folder = Step::new("rustc")
        .args(["--print", "target-libdir", "--target", target])
        .output();
    Path::new(folder.trim()).is_dir()
}
