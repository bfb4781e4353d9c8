//! The panels of Patina's window that edit a look: as lists of widgets and as node graphs.
//!
//! [`Document`] is the look that is edited, as text with a history. [`TexturesPanel`] shows it and edits it. Whoever
//! owns the window shows the panel each frame and then brings [`Document::take_changes`] to the renderer with
//! [`Change::send`]. Nothing here opens windows, files (but looks and images) or event loops.

mod context;
mod document;
mod edits;
mod graph;
mod library;
mod light;
mod links;
mod list;
mod material;
mod model;
mod panel;
mod patch;
mod preview;
#[cfg(test)]
mod random_tests;
mod rename;
mod scene_view;
mod textures;
mod widgets;

pub use document::{Change, Document};
pub use panel::{Form, TexturesPanel};
pub use preview::Previews;
pub use scene_view::SceneView;
pub use textures::Textures;
