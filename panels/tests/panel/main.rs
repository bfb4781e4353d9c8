//! The panel as its user has it.

mod dropping;
mod editing;
mod files;
mod history;
mod keyboard;
mod large;
mod names;
mod numbers;
mod picture;
mod placing;
mod selecting;
mod snapshots;
mod support;
