//! The panel as its user has it.

mod editing;
mod large;
mod names;
mod picture;
mod snapshots;
mod support;
