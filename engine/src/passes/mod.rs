//! The kernels of the renderer, one folder each with its WGSL beside its Rust. No pass knows another: they share
//! buffers, whose layouts are in `passes/shared`. What a pass does for one path stands apart from its entry point, so that
//! other schedules than this crate's can put the same functions into other kernels.

pub mod accumulate;
pub mod advance;
pub mod ao;
pub mod brdf;
pub mod classify;
pub mod display;
pub mod film_layers;
pub mod guide;
pub mod irradiance;
pub mod light_cache;
pub mod pass;
pub mod photons;
pub mod proctex;
pub mod raygen;
pub mod traverse;
pub mod wgsl;
