//! Whether the program would compile for systems and processors other than this one, as far as Rust's targets for them are
//! installed or can be.

use std::path::Path;

use anyhow::Result;

use crate::steps::{Step, cargo};

/// Targets, each with the package that is checked with all that it depends on: where that is the program itself, no
/// compiler of C is needed for it.
const TARGETS: [(&str, &str); 4] = [
    WEB_ASSEMBLY,
    ("aarch64-unknown-linux-gnu", "engine"),
    ("aarch64-apple-darwin", "patina"),
    ("x86_64-pc-windows-msvc", "patina"),
];
const WEB_ASSEMBLY: (&str, &str) = ("wasm32-unknown-unknown", "engine");

/// Whether the engine would compile for browsers.
///
/// # Errors
/// It doesn't.
pub(crate) fn check_web_assembly() -> Result<()> {
    check(WEB_ASSEMBLY)
}

/// All others.
///
/// # Errors
/// One of them doesn't compile.
pub(crate) fn check_others() -> Result<()> {
    let others = TARGETS.into_iter().filter(|of| *of != WEB_ASSEMBLY);
    others.into_iter().try_for_each(check)
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
