//! Which files a picture is made of, for those who watch them.

use std::path::{Path, PathBuf};

use crate::scene::import::referenced_files;
use crate::scene::look::{EnvironmentLook, Field, Look, Value};

/// The scene and all files that it and the look name, whether or not they exist; not the look itself, nor textures in
/// WGSL.
pub fn files(scene: &Path, look: Option<&Look>) -> Vec<PathBuf> {
    let mut found = vec![scene.to_owned()];
    found.extend(referenced_files(scene));
    let Some(look) = look else {
        return found;
    };
    for include in &look.includes {
        let path = look.resolve(&include.file.value);
        found.extend(referenced_files(&path));
        found.push(path);
    }
    if let Some(environment) = &look.environment
        && let EnvironmentLook::Image { image, .. } = &environment.value
    {
        found.push(look.resolve(&image.value));
    }
    let mut names = Vec::new();
    for field in look.nodes.iter().flat_map(|node| &node.params) {
        image_names(&field.value.value, &mut names);
    }
    found.extend(names.iter().map(|name| look.resolve(name)));
    found.sort();
    found.dedup();
    found
}

/// Texts that end like a picture's name: which parameters are images is not known here.
fn image_names(value: &Value, names: &mut Vec<String>) {
    const ENDINGS: [&str; 8] = ["png", "jpg", "jpeg", "hdr", "exr", "webp", "bmp", "tga"];
    match value {
        Value::Text(text) => {
            let ending = Path::new(text).extension().and_then(|e| e.to_str());
            if ending.is_some_and(|e| ENDINGS.contains(&e.to_ascii_lowercase().as_str())) {
                names.push(text.clone());
            }
        }
        Value::Table(fields) => {
            for Field { value, .. } in fields {
                image_names(&value.value, names);
            }
        }
        _ => {}
    }
}
