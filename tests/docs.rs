//! The documents, held to what is there.

use std::fs;
use std::path::{Path, PathBuf};

/// README, changelog and everything in `docs/`.
fn documents() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = fs::read_dir(root.join("docs")).expect("the folder docs is part of the project");
    docs.map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .chain([root.join("README.md"), root.join("CHANGELOG.md")])
        .collect()
}

/// Targets of `[text](target)` and `![text](target)`.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
}

#[test]
fn links_lead_to_files_that_exist() {
    let mut broken = Vec::new();
    for document in documents() {
        let text = fs::read_to_string(&document).expect("a document is UTF-8");
        let folder = document.parent().expect("a file lies in a folder");
        for link in links(&text) {
            let file = link.split('#').next().unwrap_or_default();
            let elsewhere = link.contains("://") || file.is_empty();
            if !elsewhere && !folder.join(file).exists() {
                broken.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(broken.is_empty(), "broken links:\n{}", broken.join("\n"));
}

#[test]
fn every_command_in_the_documents_is_understood() {
    let mut understood = 0;
    for document in documents() {
        let text = fs::read_to_string(&document).expect("a document is UTF-8");
        for line in text.lines() {
            let Some((_, command)) = line.split_once("cargo run --release -- ") else {
                continue;
            };
            let command = command.split('#').next().unwrap_or_default();
            // With `--help` at the end the flags before it are parsed and nothing is done.
            let output = std::process::Command::new(env!("CARGO_BIN_EXE_patina"))
                .args(command.split_whitespace())
                .arg("--help")
                .output()
                .expect("patina starts");
            assert!(
                output.status.success(),
                "{}: {line}\n{}",
                document.display(),
                String::from_utf8_lossy(&output.stderr)
            );
            understood += 1;
        }
    }
    assert!(understood > 3, "the README shows commands");
}

/// The first block of a language in the README.
fn readme_block(language: &str) -> String {
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let text = fs::read_to_string(readme).expect("the README is UTF-8");
    let (_, block) = text
        .split_once(&format!("```{language}\n"))
        .expect("the README has such a block");
    let (block, _) = block.split_once("```").expect("the block ends");
    block.to_owned()
}

#[test]
fn the_readmes_texture_and_look_work_as_they_stand() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| {
        let path = dir.path().join(name);
        fs::write(&path, text).expect("a file");
        path
    };
    let scene = write("helmet.gltf", HELMET);
    let look = write("helmet.look.toml", &readme_block("toml"));
    write("stripes.wgsl", &readme_block("wgsl"));
    let loaded = engine::load::load(&scene, Some(&look), &[dir.path().to_owned()]);
    if let Err(error) = loaded {
        panic!("the README misleads its readers:\n{error}");
    }
}

/// A triangle of the material the README's look drives.
const HELMET: &str = r#"{
  "asset": { "version": "2.0" },
  "scene": 0,
  "scenes": [{ "nodes": [0] }],
  "nodes": [{ "mesh": 0 }],
  "materials": [{ "name": "Helmet" }],
  "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
  "accessors": [{
    "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]
  }],
  "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
  "buffers": [{
    "byteLength": 36,
    "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"
  }]
}"#;
