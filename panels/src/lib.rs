//! The panels of Patina's window that edit a look: as lists of widgets and as node graphs.
//!
//! [`Document`] is the look that is edited, as text with a history. [`TexturesPanel`] shows it and edits it. Whoever
//! owns the window shows the panel each frame and then brings [`Document::take_changes`] to the renderer with
//! [`Change::send`]. Nothing here opens windows, files (but looks and images) or event loops.

mod document;
mod panel;
mod patch;
mod textures;

pub use document::{Change, Document};
pub use panel::{SceneView, TexturesPanel};
pub use textures::Textures;
