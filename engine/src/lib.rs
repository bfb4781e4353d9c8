//! Patina's renderer as a library: a [`scene::Scene`] in, a film out.
//!
//! It knows `texgen`, never prints, and reports every failure as a value.

pub mod load;
pub mod procedural;
pub mod scene;
