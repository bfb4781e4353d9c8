//! Puts the passes' WGSL files into the program: each file below `src/passes`, by its path there. So a pass's folder is the only
//! place that says which files it has.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

const PASSES: &str = "src/passes";

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    // With all that is below it, so that new files are noticed.
    println!("cargo::rerun-if-changed={PASSES}");
    let mut files = Vec::new();
    find(Path::new(PASSES), &mut files)?;
    files.sort();
    let mut list = String::from("&[\n");
    for file in files {
        let path = file.to_string_lossy().replace('\\', "/");
        let name = path.trim_start_matches(PASSES).trim_start_matches('/');
        let text = format!("concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/{path}\")");
        // Writing to a string can't fail.
        let _ = writeln!(list, "    (\"{name}\", include_str!({text})),");
    }
    list.push_str("]\n");
    let out = env::var_os("OUT_DIR").map(PathBuf::from);
    let out = out.ok_or_else(|| io::Error::other("Cargo names no OUT_DIR"))?;
    fs::write(out.join("wgsl_files.rs"), list)
}

/// All WGSL files below a folder.
fn find(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            find(&path, files)?;
        } else if path
            .extension()
            .is_some_and(|extension| extension == "wgsl")
        {
            files.push(path);
        }
    }
    Ok(())
}
