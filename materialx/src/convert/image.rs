//! File names of images.

use std::path::{Component, Path, PathBuf};

use crate::document::ElementId;
use crate::types::Type;
use crate::value::Value;

use super::Converter;

impl Converter<'_> {
    /// An image that an input names.
    pub(super) fn file(&mut self, id: ElementId, text: &str) -> Option<Value> {
        let document = self.document;
        let mut name = format!("{}{text}", document.file_prefix(id)).replace('\\', "/");
        for (token, number) in [("<UDIM>", "1001"), ("<UVTILE>", "u1_v1")] {
            if name.contains(token) {
                self.warn(
                    id,
                    format!("of tiled images only the first tile is used, {number}"),
                );
                name = name.replace(token, number);
            }
        }
        let path = document.folder(id).join(&name);
        if !self.files.has(&path) {
            self.warn(
                id,
                format!(
                    "the image {} is not there; its default stands for it",
                    path.display()
                ),
            );
            return None;
        }
        let start = self.files.read_start(&path, 12);
        if start.is_ok_and(|start| !is_readable(&start)) {
            let message = format!(
                "the image {} is no PNG, JPEG or WebP; its default stands for it",
                path.display()
            );
            self.warn(id, message);
            return None;
        }
        let space = document.inherited(id, "colorspace").unwrap_or("lin_rec709");
        let is_srgb = matches!(space, "srgb_texture" | "srgb_rec709_scene" | "srgb");
        let is_linear = matches!(
            space,
            "lin_rec709" | "lin_rec709_scene" | "none" | "raw" | "linear"
        );
        // Numbers of other types than colours aren't converted in MaterialX either.
        let node = document.element(id).parent;
        let ty = node.and_then(|node| document.element(node).attribute("type"));
        let ty = Type::of(ty.unwrap_or(""));
        if !is_srgb && !is_linear && (ty.is_color() || ty == Type::Other) {
            self.warn(
                id,
                format!("images of the colour space `{space}` are not converted: its numbers are taken for linear Rec.709"),
            );
        }
        Some(Value::File {
            path: relative(&path, self.folder),
            is_srgb,
        })
    }
}

/// Whether a file that begins so is an image that looks can have.
fn is_readable(start: &[u8]) -> bool {
    let is_webp = start.starts_with(b"RIFF") && start.get(8..12) == Some(b"WEBP");
    is_webp || start.starts_with(b"\x89PNG") || start.starts_with(&[0xff, 0xd8, 0xff])
}

/// A path as it is written in a file of that folder.
fn relative(path: &Path, folder: &Path) -> String {
    let whole = |path: &Path| {
        let path = if path.as_os_str().is_empty() {
            Path::new(".")
        } else {
            path
        };
        std::path::absolute(path).unwrap_or(path.to_owned())
    };
    let (path, folder) = (whole(path), whole(folder));
    let (path, folder) = (plain(&path), plain(&folder));
    let mut rest = path.components().peekable();
    let mut from = folder.components().peekable();
    let mut shared = 0;
    while let (Some(a), Some(b)) = (rest.peek(), from.peek()) {
        if a != b {
            break;
        }
        shared += usize::from(matches!(a, Component::Normal(_)));
        rest.next();
        from.next();
    }
    // Nothing in common but the root: such a path says more as it is.
    if shared == 0 {
        return path.display().to_string();
    }
    let ups = from.map(|_| Component::ParentDir);
    let out: PathBuf = ups.chain(rest).collect();
    out.to_string_lossy().replace('\\', "/")
}

fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                out.pop();
            }
            part => out.push(part),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_known_by_their_contents() {
        assert!(is_readable(b"\x89PNG\r\n\x1a\n\0\0\0\r"));
        assert!(is_readable(b"RIFF\x24\0\0\0WEBP"));
        assert!(is_readable(&[0xff, 0xd8, 0xff, 0xe0]));
        assert!(!is_readable(b"II*\0"));
        assert!(!is_readable(b"#?RADIANCE\n"));
        assert!(!is_readable(b""));
    }

    #[test]
    fn paths_are_relative_to_the_look() {
        let of = |path: &str, folder: &str| relative(Path::new(path), Path::new(folder));
        assert_eq!(of("/a/b/c.png", "/a/b"), "c.png");
        assert_eq!(of("/a/b/../t/c.png", "/a/b"), "../t/c.png");
        assert_eq!(of("/a/b/c.png", "/x"), "/a/b/c.png");
        assert_eq!(of("maps/c.png", ""), "maps/c.png");
    }
}
