//! The panels of Patina's window that edit a look: as lists of widgets and as node graphs.
//!
//! The way through the crate, once a frame:
//!
//! 1. [`Document`](engine::session::Document) is the look that is edited, as text with a history.
//! 2. [`TexturesPanel::show`] shows one material of it in one of its [`Form`]s, beside what the scene says ([`SceneView`]) and what the
//!    texture files are ([`Textures`]). Nothing is changed while it is shown: edits are collected, and made in the document when all
//!    has been shown.
//! 3. Whoever owns the window brings what the document has changed to the [`Session`](engine::session::Session).
//!
//! [`Previews`] paints small pictures of nodes in the background; a [`Browser`] asks the system for files through what it is handed.
//! Nothing here opens windows, files (but looks and images) or event loops, and nothing renders the scene.

mod clipboard;
mod context;
mod edits;
mod environments;
mod framing;
mod graph;
mod history;
mod lamps;
mod library;
mod light;
mod links;
mod list;
mod maps;
mod material;
mod model;
mod model_image;
mod node;
mod panel;
mod pictures;
mod preview;
#[cfg(test)]
mod random_tests;
mod relight;
mod rename;
mod scene_view;
mod textures;
mod view;
mod widgets;

pub use environments::surround_with;
pub use lamps::place_light;
pub use model_image::ModelImage;
pub use panel::{Form, TexturesPanel};
pub use pictures::{DraggedMaterial, PictureUse, give_material};
pub use preview::Previews;
pub use relight::relight;
pub use scene_view::{Placing, SceneView};
pub use textures::Textures;
pub use widgets::{
    Answer, Browser, Choice, FileDialogs, FileRequest, Purpose, asks_for_menu, keyboard_is_used,
    named_from, number_field, show_focus,
};
