//! How fast Patina's parts are, and how fast other forms of them would be.
//!
//! The renderer's own [`engine::renderer::Renderer`] is what is measured; nothing is built here a second time. Two things are
//! added to it: *scenes* that need no file, so that figures of two machines can be compared ([`scenes`]), and *schedules* that
//! cut the same work into other kernels ([`engine::schedule::Schedule`]), so that a comparison is of one thing only:
//!
//! - [`inlined`]: textures pasted into their kernel, as renderers do whose materials are code;
//! - [`rayquery`]: a whole path tracer in one kernel on the hardware's ray queries.
//!
//! [`forms::Form`] names them, and makes a renderer of each.
//!
//! | to measure | |
//! |---|---|
//! | [`render`] | whole renders: samples and rays per second, the time of each pass |
//! | [`textures`], [`sweeps`] | what textures cost over plain grey in each form, and what changes that |
//! | [`kernel`] | building the texture kernel, and a hit beside unused textures |
//! | [`scaling`] | how rendering scales with threads, sizes of pieces, and devices that render together |
//! | [`methods`] | how long ways to find light take until the picture is good enough |
//! | [`gather`] | finding photons by the octree, a grid and a kd-tree |
//! | [`edit`] | live edits of a look of a thousand nodes |
//! | [`traverse`] | rays per second of the traversal kernel |
//! | [`traffic`] | bytes that each pass reads and writes: no measurement, but held to the kernels by tests |
//!
//! Whatever is compared is run in turn, A B C A B C, so that a machine that slows down slows down all of them, and figures are
//! medians with the lowest and the highest run ([`spread::Spread`]). [`report`] makes tables, charts and pages of them. This
//! crate prints nothing and writes no file but temporary ones; `patina bench` does.

pub mod coverage;
pub mod edit;
pub mod error;
pub mod forms;
pub mod gather;
mod graphs;
mod in_turn;
pub mod inlined;
pub mod insert;
pub mod inspect;
pub mod kernel;
pub mod methods;
pub mod rayquery;
pub mod render;
pub mod report;
pub mod scaling;
pub mod scenes;
pub mod spread;
pub mod sweeps;
pub mod textures;
pub mod traffic;
pub mod traverse;
mod wgsl;
