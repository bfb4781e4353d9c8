//! Which files a glTF file refers to.

use std::fmt;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::{Deserializer, SeqAccess, Visitor};
use serde_json::Value;

use super::document::read;
use super::{container, environment, files};
use crate::input::Files;

/// The members of a file that name others.
#[derive(Deserialize)]
struct Names {
    #[serde(default)]
    buffers: Uris,
    #[serde(default)]
    images: Uris,
    #[serde(default)]
    scenes: Vec<Shown>,
}

/// A scene, for the picture around it.
#[derive(Deserialize)]
struct Shown {
    /// Anything.
    #[serde(default)]
    extras: Value,
}

impl Shown {
    fn uris(&self) -> impl Iterator<Item = &str> {
        let own = self.extras.get("environment");
        let uris = environment::NAMES
            .iter()
            .filter_map(move |key| own?.get(*key)?.as_str());
        uris.filter(|uri| !uri.starts_with("data:"))
    }
}

/// The URIs of a list, without those that are the data itself.
#[derive(Default)]
struct Uris(Vec<String>);

#[derive(Deserialize)]
struct Entry {
    uri: Option<String>,
}

impl<'de> Deserialize<'de> for Uris {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct List;
        impl<'de> Visitor<'de> for List {
            type Value = Uris;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a list")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Uris, A::Error> {
                let mut uris = Vec::new();
                while let Some(entry) = list.next_element::<Entry>()? {
                    uris.extend(entry.uri.filter(|uri| !uri.starts_with("data:")));
                }
                Ok(Uris(uris))
            }
        }
        source.deserialize_seq(List)
    }
}

/// The buffers, images and environments beside a glTF file that its JSON names; none where the file can't be understood.
pub(super) fn referenced_files(from: &dyn Files, path: &Path) -> Vec<PathBuf> {
    let names = || -> Option<Vec<PathBuf>> {
        let bytes = read(from, path).ok()?;
        let parts = container::split(&bytes).ok()?;
        let text = bytes.get(parts.json)?;
        let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
        let Names {
            buffers,
            images,
            scenes,
        } = serde_json::from_slice(text).ok()?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let uris = (buffers.0.iter().chain(&images.0)).map(String::as_str);
        let uris = uris.chain(scenes.iter().flat_map(Shown::uris));
        let files = uris.filter_map(|uri| match files::resolve(from, folder, uri).ok()? {
            files::UriTarget::File(path) => Some(path),
            files::UriTarget::Data(_) => None,
        });
        Some(files.collect())
    };
    names().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Disk;

    #[test]
    fn all_files_beside_it_are_named() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.gltf");
        let text = r#"{
            "asset": { "version": "2.0" },
            "buffers": [{ "uri": "corners.bin", "byteLength": 3 }, { "uri": "data:,abc" }],
            "images": [{ "uri": "a%20picture.png" }, { "bufferView": 0 }],
            "scenes": [
                { "nodes": [0], "extras": { "environment": { "uri": "sky.exr", "scale": 2 } } },
                { "extras": { "environment": { "file": "room.hdr" } } },
                { "extras": { "environment": { "uri": "data:,abc" } } },
                { "extras": { "environment": "studio" } }, { "extras": [1] }, {}
            ]
        }"#;
        std::fs::write(&path, text).expect("written");
        let found = referenced_files(&Disk, &path);
        let expected = ["corners.bin", "a picture.png", "sky.exr", "room.hdr"];
        assert_eq!(found, expected.map(|name| folder.path().join(name)));
    }
}
