//! Patina's window: a live render that is looked at, walked through and edited.
//!
//! The way through the crate:
//!
//! 1. [`shell::run`] opens the window and runs until it is closed. What it needs of the program around it (file events, formats of
//!    pictures) is a [`host::Host`].
//! 2. [`viewer::Viewer`] is everything that a user sees and does, free of GPU and window system, so that tests use it without
//!    either; [`navigate`] moves the camera.
//! 3. [`thread::RenderThread`] renders. Both talk over a [`link::Link`]: commands go one way, what is shown lies on a
//!    [`link::Board`], and neither waits for the other. [`pace`] decides how long waves may take, so that the window stays at
//!    hand.
//! 4. [`blit`] paints the picture by a pipeline of its own. Where another device than the window's renders, the [`picture`] comes
//!    as pixels, which are brought to the window's. `file_dialogs` opens the dialogs of the system, `glyphs` finds its
//!    fonts where the window's own lack a character.
//!
//! Panels that edit the look are `patina_panels`. Nothing here prints.

pub mod appearance;
pub mod blit;
mod canvas;
pub mod figures;
mod file_dialogs;
mod glyphs;
pub mod host;
pub mod link;
pub mod navigate;
pub mod pace;
pub mod picture;
mod screen;
pub mod shell;
pub mod thread;
mod upload;
pub mod viewer;
