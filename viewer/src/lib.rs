//! Patina's window: a live render that is looked at, walked through and edited.
//!
//! [`shell::run`] opens it. Inside, [`viewer::Viewer`] is everything that a user sees and does, free of GPU and window
//! system, and [`thread::RenderThread`] renders; they talk over a [`link::Link`], and neither waits for the other. What
//! the window needs of the program around it (file events, formats of pictures) is a [`host::Host`]. Nothing here
//! prints.

pub mod blit;
pub mod host;
pub mod link;
pub mod navigate;
pub mod pace;
pub mod shell;
pub mod thread;
pub mod viewer;
