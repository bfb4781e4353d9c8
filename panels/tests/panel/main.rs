//! The panel as its user has it.

mod editing;
mod files;
mod history;
mod large;
mod names;
mod picture;
mod selecting;
mod snapshots;
mod support;
