//! The kernels of the renderer, one folder each with its WGSL beside its Rust. No pass knows another: they share
//! buffers, whose layouts are in `passes/shared`.

pub mod accumulate;
pub mod advance;
pub mod ao;
pub mod brdf;
pub mod classify;
pub mod display;
pub mod guide;
pub mod proctex;
pub mod raygen;
pub mod traverse;
