//! Tests of the whole crate, as its users see it.

mod common;
mod docs;
mod errors;
mod first_steps;
mod graph;
mod inputs;
mod kernel;
mod language;
mod messages;
mod mistakes;
mod outputs;
mod robustness;
mod shipped;
