//! The panels of Patina's window that edit a look: as lists of widgets and as node graphs.
//!
//! [`Document`](engine::session::Document) is the look that is edited, as text with a history. [`TexturesPanel`] shows it
//! and edits it. Whoever owns the window shows the panel each frame and then brings what the document has changed to
//! the [`Session`](engine::session::Session). Nothing here opens windows, files (but looks and images) or event loops.

mod context;
mod edits;
mod graph;
mod library;
mod light;
mod links;
mod list;
mod material;
mod model;
mod panel;
mod preview;
#[cfg(test)]
mod random_tests;
mod rename;
mod textures;
mod widgets;

pub use panel::{Form, SceneView, TexturesPanel};
pub use preview::Previews;
pub use textures::Textures;
