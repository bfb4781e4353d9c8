//! Compiled kernels give what WGSL says, and what another device gives.

mod host;
mod operations;
mod programs;
mod random;
mod support;
