//! Which files a picture is made of, for those who watch them, or must not overwrite them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::procedural::expanded;
use crate::scene::import::referenced_files;
use crate::scene::look::{EnvironmentLook, Field, Look, MODEL_IMAGE, Value};
use crate::system::{Disk, Files};

/// The scene and all files that it and the look name, whether or not they exist; not the look itself, nor textures in
/// WGSL.
pub fn files(scene: &Path, look: Option<&Look>) -> Vec<PathBuf> {
    files_from(&Disk, scene, look)
}

/// As [`files`], from files of one's own.
pub fn files_from(files: &dyn Files, scene: &Path, look: Option<&Look>) -> Vec<PathBuf> {
    let mut found = vec![scene.to_owned()];
    found.extend(referenced_files(files, scene));
    let Some(look) = look else {
        return found;
    };
    let included: BTreeSet<&str> = (look.includes.iter())
        .map(|include| include.file.value.as_str())
        .collect();
    for file in included {
        let path = look.resolve(file);
        found.extend(referenced_files(files, &path));
        found.push(path);
    }
    if let Some(environment) = &look.environment
        && let EnvironmentLook::Image { image, .. } = &environment.value
    {
        found.push(look.resolve(&image.value));
    }
    for document in &look.materialx {
        let path = look.resolve(&document.file.value);
        if let Ok(document) = materialx::Document::open(files, &path, document.drafts) {
            found.extend(document.paths().iter().cloned());
        }
        found.push(path);
    }
    // What their nodes name is read, too. Where they can't be read, that is said elsewhere.
    let whole = expanded(look, files, None);
    let look = whole.as_ref().map_or(look, |(whole, _)| whole);
    let mut names = Vec::new();
    for field in look.nodes.iter().flat_map(|node| &node.params) {
        image_names(&field.value.value, &mut names);
    }
    found.extend(names.iter().map(|name| look.resolve(name)));
    found.extend(other_texts(look).filter(|path| files.has(path)));
    found.sort();
    found.dedup();
    found
}

/// What the values of nodes name, whatever its ending: an image is known by its contents.
fn other_texts(look: &Look) -> impl Iterator<Item = PathBuf> {
    let fields = look.nodes.iter().flat_map(|node| &node.params);
    fields.filter_map(|field| match &field.value.value {
        Value::Text(text) if !text.starts_with(MODEL_IMAGE) => Some(look.resolve(text)),
        Value::Table(fields) => match &crate::scene::look::find(fields, "file")?.value {
            Value::Text(text) => Some(look.resolve(text)),
            _ => None,
        },
        _ => None,
    })
}

/// Texts that end like a picture's name: which parameters are images is not known here.
fn image_names(value: &Value, names: &mut Vec<String>) {
    const ENDINGS: [&str; 8] = ["png", "jpg", "jpeg", "hdr", "exr", "webp", "bmp", "tga"];
    match value {
        Value::Text(text) => {
            let ending = Path::new(text).extension().and_then(|e| e.to_str());
            let is_file = !text.starts_with(MODEL_IMAGE);
            if is_file && ending.is_some_and(|e| ENDINGS.contains(&e.to_ascii_lowercase().as_str()))
            {
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
