//! Patina's renderer as a library: a [`scene::Scene`] in, a film out.
//!
//! It knows `texgen`, never prints, and reports every failure as a value.

pub mod alias;
pub mod bench;
pub mod bvh;
pub mod display;
pub mod evaluate;
pub mod film;
pub mod filter;
pub mod frame;
pub mod gpu_scene;
pub mod isolated;
pub mod live;
pub mod load;
pub mod material_record;
pub mod passes;
pub mod pick;
pub mod preview;
pub mod procedural;
pub mod renderer;
pub mod schedule;
pub mod settings;
mod sobol;
pub mod stats;
pub mod wave;

pub use ::scene;
pub use ::scene::{aside, input};
