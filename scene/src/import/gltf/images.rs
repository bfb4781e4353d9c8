//! Where the pictures of a glTF file are.

use super::document::{Document, offset};
use super::files::{self, UriTarget};
use crate::import::error::Fault;
use crate::import::pictures::{Album, Key, MAX_FILE};
use std::borrow::Cow;
use std::path::Path;

impl Album for Document {
    fn path(&self) -> &Path {
        &self.path
    }

    fn key(&self, index: usize) -> Key {
        let entry = || Key::Entry(self.id().clone(), index);
        let Some(image) = self.root.images.get(index) else {
            return entry();
        };
        match (&image.uri, image.buffer_view) {
            // What is there already need not be decoded to be told from others.
            (Some(uri), _) if uri.starts_with("data:") => entry(),
            (Some(uri), _) => match files::resolve(&*self.files, self.folder(), uri) {
                Ok(UriTarget::File(path)) => Key::File(self.files.id(&path)),
                _ => entry(),
            },
            (None, Some(view)) => match self.root.buffer_views.get(view.value()) {
                Some(view) => Key::Bytes(
                    self.id().clone(),
                    view.buffer.value(),
                    offset(view.byte_offset),
                    view.byte_length.0,
                ),
                None => entry(),
            },
            (None, None) => entry(),
        }
    }

    fn name(&self, index: usize) -> String {
        let source = &self.root.images[index];
        let uri = source
            .uri
            .as_deref()
            .filter(|uri| !uri.starts_with("data:"));
        match uri.or(source.name.as_deref()) {
            Some(name) => format!("image {index} \"{name}\""),
            None => format!("image {index}"),
        }
    }

    fn bytes(&self, index: usize) -> Result<Cow<'_, [u8]>, Fault> {
        let source = &self.root.images[index];
        if let Some(uri) = &source.uri {
            return match files::resolve(&*self.files, self.folder(), uri)? {
                UriTarget::Data(bytes) => Ok(Cow::Owned(bytes)),
                UriTarget::File(path) => (self.files.read(&path, MAX_FILE))
                    .map(Cow::Owned)
                    .map_err(|error| format!("cannot read {}: {error}", path.display())),
            };
        }
        match source.buffer_view {
            Some(view) => self
                .view(view.value())
                .map(|(bytes, _)| Cow::Borrowed(bytes)),
            None => Err("has neither a uri nor a bufferView".into()),
        }
    }
}
