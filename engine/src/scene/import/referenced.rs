//! Which files a glTF file refers to: for those who watch them. Nothing of it is checked; importing does that.

use std::path::{Path, PathBuf};

use super::{container, files};

/// The buffers and images beside a glTF file that its JSON names; none where the file can't be understood.
pub fn referenced_files(path: &Path) -> Vec<PathBuf> {
    let names = || -> Option<Vec<PathBuf>> {
        let bytes = files::read_file(path, u64::MAX).ok()?;
        let parts = container::split(&bytes).ok()?;
        let json: serde_json::Value = serde_json::from_slice(bytes.get(parts.json)?).ok()?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let entries = ["buffers", "images"]
            .into_iter()
            .filter_map(|key| json.get(key)?.as_array());
        let uris = entries
            .flatten()
            .filter_map(|entry| entry.get("uri")?.as_str());
        let files = uris
            .filter(|uri| !uri.starts_with("data:"))
            .filter_map(|uri| match files::resolve(folder, uri).ok()? {
                files::Source::File(path) => Some(path),
                files::Source::Data(_) => None,
            });
        Some(files.collect())
    };
    names().unwrap_or_default()
}
