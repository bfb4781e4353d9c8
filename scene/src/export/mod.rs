//! A [`Scene`] as a glTF 2.0 binary: meshes, instances, materials with their pictures, lights, cameras.
//!
//! Everything is in one file. What glTF has no word for is left out with a warning: pictures of the environment, the size of
//! lights, lenses of cameras, priorities of bodies, what only catches shadows.

mod buffer;
mod materials;
mod objects;
mod shear;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use serde_json::{Map, Value, json};

use crate::{Environment, Scene};

use buffer::Buffer;

/// A container's parts can't be longer.
const MOST_BYTES: usize = u32::MAX as usize;

/// Why there is no file.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A picture can't be encoded.
    #[error("picture \"{name}\" can't be encoded as PNG: {reason}")]
    Picture {
        /// Which.
        name: String,
        /// What the encoder says.
        reason: String,
    },
    /// A container holds 4 GiB at most.
    #[error(
        "the scene takes {bytes} bytes as a glTF binary, which may have 4 GiB at most; bake smaller pictures (--size)"
    )]
    TooLarge {
        /// As many as there would be.
        bytes: usize,
    },
}

/// A file, and what of the scene isn't in it.
#[derive(Debug)]
pub struct Exported {
    /// The glTF binary.
    pub glb: Vec<u8>,
    /// A sentence each.
    pub warnings: Vec<String>,
}

/// The file's JSON while it is made.
#[derive(Debug, Default)]
struct Tree {
    buffer: Buffer,
    extensions: BTreeSet<&'static str>,
    warnings: Vec<String>,
}

impl Tree {
    /// Notes that an extension is used.
    fn uses(&mut self, extension: &'static str) -> &'static str {
        self.extensions.insert(extension);
        extension
    }
}

/// Writes a scene as a glTF binary.
///
/// # Errors
/// A picture can't be encoded, or there is more than a container can hold.
pub fn glb(scene: &Scene) -> Result<Exported, ExportError> {
    let mut tree = Tree::default();
    let mut root = Map::new();
    root.insert(
        "asset".to_owned(),
        json!({ "version": "2.0", "generator": concat!("Patina ", env!("CARGO_PKG_VERSION")) }),
    );
    let (nodes, shown) = objects::nodes(scene, &mut tree, &mut root);
    let meshes = objects::meshes(scene, &mut tree);
    let materials = materials::materials(scene, &mut tree, &mut root)?;
    let mut shown = json!({ "nodes": (0..shown).collect::<Vec<_>>() });
    match &scene.environment {
        Environment::Constant(color) if color.max_element() > 0.0 => {
            shown["extras"] = json!({ "environment": { "constant": color.to_array() } });
        }
        Environment::Constant(_) => {}
        Environment::Image { .. } => tree.warnings.push(
            "glTF has no environment: the picture around the scene is not in the file, render it with --environment"
                .to_owned(),
        ),
    }
    let mut put = |key: &str, list: Vec<Value>| {
        // Lists that are there may not be empty (glTF 2.0, section 5.17).
        if !list.is_empty() {
            root.insert(key.to_owned(), Value::Array(list));
        }
    };
    if nodes.is_empty() {
        shown = json!({});
    }
    put("scenes", vec![shown]);
    put("nodes", nodes);
    put("meshes", meshes);
    put("materials", materials);
    let Buffer {
        bytes,
        views,
        accessors,
    } = std::mem::take(&mut tree.buffer);
    put("accessors", accessors);
    put("bufferViews", views);
    if !bytes.is_empty() {
        put("buffers", vec![json!({ "byteLength": bytes.len() })]);
    }
    let extensions = tree.extensions.iter().map(|name| json!(name));
    put("extensionsUsed", extensions.collect());
    root.insert("scene".to_owned(), json!(0));
    Ok(Exported {
        glb: container(&Value::Object(root), bytes)?,
        warnings: tree.warnings,
    })
}

/// The two chunks with their header (glTF 2.0, section 4.4).
fn container(root: &Value, mut binary: Vec<u8>) -> Result<Vec<u8>, ExportError> {
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let chunks = 12
        + 8
        + text.len()
        + if binary.is_empty() {
            0
        } else {
            8 + binary.len()
        };
    if chunks > MOST_BYTES {
        return Err(ExportError::TooLarge { bytes: chunks });
    }
    let mut glb = Vec::with_capacity(chunks);
    let word = |glb: &mut Vec<u8>, word: usize| glb.extend((word as u32).to_le_bytes());
    glb.extend(b"glTF");
    word(&mut glb, 2);
    word(&mut glb, chunks);
    word(&mut glb, text.len());
    glb.extend(b"JSON");
    glb.extend(text);
    if !binary.is_empty() {
        word(&mut glb, binary.len());
        glb.extend(b"BIN\0");
        glb.extend(binary);
    }
    Ok(glb)
}
