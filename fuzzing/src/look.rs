//! Looks: parsed, applied to a small scene with all that they name, and as the viewer edits them.

use std::path::PathBuf;
use std::str;

use engine::load;
use engine::scene::look::{Look, LookDocument};
use serde_json::json;

use crate::{check_message, check_report, file, memory, scratch, seeds};

/// Held beside what the look needs: sources of textures, generated kernels, pictures that it names.
const SLACK: usize = 128 << 20;
/// A table of a few bytes is a tree with places; see the engine's tests of malformed files.
const PER_BYTE: usize = 100;

/// Names of the scene's materials: those of the documentation and of the demo.
const MATERIALS: [&str; 8] = [
    "A",
    "B",
    "Helmet",
    "ValvePaint",
    "WheelPaint",
    "Copper",
    "Steel",
    "Floor",
];

pub(crate) fn run(data: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(data) else {
        return false;
    };
    let scene = scene();
    let path = scratch().join("input.look.toml");
    memory::within(data.len() * PER_BYTE, SLACK, || {
        let look = match Look::parse(&path, text) {
            Ok(look) => look,
            Err(problems) => {
                assert!(!problems.is_empty(), "refused without a reason");
                check_report(&problems);
                return false;
            }
        };
        let document = LookDocument::parse(&path, text).expect("a look can be edited");
        assert!(Look::parse(&path, &document.text()).is_ok(), "as it was");
        match load::load_with(&scene, Some(look), &[]) {
            Ok(loaded) => {
                crate::gltf::check(&loaded.scene);
                if !loaded.warnings.is_empty() {
                    check_report(&loaded.warnings);
                }
            }
            Err(error) => check_message(&error.to_string()),
        }
        true
    })
}

/// The file of the scene, which is written anew where the folder has been taken away.
fn scene() -> PathBuf {
    const NAME: &str = "under-a-look.gltf";
    let path = scratch().join(NAME);
    if path.is_file() {
        return path;
    }
    let mut tree = seeds::triangle();
    tree["materials"] = MATERIALS
        .iter()
        .map(|name| json!({ "name": name }))
        .collect();
    file(NAME, tree.to_string().as_bytes())
}
