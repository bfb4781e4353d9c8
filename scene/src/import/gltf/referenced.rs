//! Which files a glTF file refers to.

use std::fmt;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::{Deserializer, SeqAccess, Visitor};

use super::document::read;
use super::{container, files};
use crate::input::Files;

/// The members of a file that name others.
#[derive(Deserialize)]
struct Names {
    #[serde(default)]
    buffers: Uris,
    #[serde(default)]
    images: Uris,
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

/// The buffers and images beside a glTF file that its JSON names; none where the file can't be understood.
pub(super) fn referenced_files(from: &dyn Files, path: &Path) -> Vec<PathBuf> {
    let names = || -> Option<Vec<PathBuf>> {
        let bytes = read(from, path).ok()?;
        let parts = container::split(&bytes).ok()?;
        let text = bytes.get(parts.json)?;
        let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
        let Names { buffers, images } = serde_json::from_slice(text).ok()?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let uris = buffers.0.iter().chain(&images.0);
        let files = uris.filter_map(|uri| match files::resolve(from, folder, uri).ok()? {
            files::UriTarget::File(path) => Some(path),
            files::UriTarget::Data(_) => None,
        });
        Some(files.collect())
    };
    names().unwrap_or_default()
}
