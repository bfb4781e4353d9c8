//! Tells the program which commit it is built from, for the reports of `patina bench`. Without git, or outside of a
//! repository, the commit is `unknown`; nothing fails.

use std::path::Path;
use std::process::Command;

/// Crates that are in the program, besides this one.
const CRATES: [&str; 11] = [
    "bench",
    "device",
    "engine",
    "kernel_ir",
    "kernels",
    "materialx",
    "panels",
    "pictures",
    "scene",
    "texgen",
    "viewer",
];
/// What else it is made of.
const FILES: [&str; 8] = [
    "Cargo.lock",
    "Cargo.toml",
    "build.rs",
    "engine/build.rs",
    "kernels/build.rs",
    "materialx/textures",
    "src",
    "user_textures",
];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=PATINA_COMMIT={}", commit());
}

fn commit() -> String {
    // A repository somewhere above an unpacked archive says nothing about the archive.
    let is_own = git(&["rev-parse", "--show-prefix"]).is_some_and(|prefix| prefix.is_empty());
    let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]).filter(|_| is_own) else {
        return "unknown".to_owned();
    };
    // A commit or a checkout changes these; what isn't there would make Cargo build again each time.
    for name in ["HEAD", "logs/HEAD"] {
        if let Some(path) =
            git(&["rev-parse", "--git-path", name]).filter(|p| Path::new(p).exists())
        {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    // What the program is made of: any change of it builds the program again anyway.
    let mut sources: Vec<String> = FILES.map(str::to_owned).into();
    for folder in CRATES {
        sources.extend(["Cargo.toml", "src"].map(|name| format!("{folder}/{name}")));
    }
    for source in &sources {
        println!("cargo::rerun-if-changed={source}");
    }
    // A source that nobody has added yet is compiled like any other.
    let mut changes = vec!["status", "--porcelain", "--untracked-files=normal", "--"];
    changes.extend(sources.iter().map(String::as_str));
    match git(&changes) {
        Some(none) if none.is_empty() => commit,
        _ => commit + "-modified",
    }
}

/// What a command of git prints, if it succeeds.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git")
        // The index is left as it is.
        .env("GIT_OPTIONAL_LOCKS", "0")
        .args(arguments)
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
