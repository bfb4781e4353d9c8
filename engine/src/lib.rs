//! Patina's renderer as a library: a [`scene::Scene`] in, a film out.
//!
//! It knows `texgen`, never prints, and reports every failure as a value.

pub mod alias;
pub mod aside;
pub mod bench;
pub mod bvh;
pub mod display;
pub mod evaluate;
pub mod film;
pub mod filter;
pub mod fingerprint;
pub mod frame;
pub mod gpu_scene;
pub mod input;
pub mod isolated;
pub mod live;
pub mod load;
pub mod passes;
pub mod pick;
pub mod preview;
pub mod procedural;
pub mod renderer;
pub mod scene;
pub mod schedule;
pub mod settings;
mod sobol;
pub mod stats;
pub mod wave;
