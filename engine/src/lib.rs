//! Patina's renderer as a library: a scene and a look in, a film out.
//!
//! The picture is computed by kernels in WGSL that a [`device`] runs, one after the other, over thousands of paths at a time.
//! Users program one of them: the value of a texture at a hit.
//!
//! The way through the crate:
//!
//! 1. [`load::load`] reads a scene ([`scene::Scene`]: meshes, materials, lights, cameras, as plain data) and the look beside it
//!    ([`scene::look::Look`]), and builds the texture graph, [`procedural::Procedural`], from the textures in some folders.
//! 2. [`renderer::Renderer`] uploads them ([`gpu_scene`]), compiles the kernels ([`passes`]) and renders wave by wave, in the order
//!    that a [`schedule`] says. Another order, with other kernels, is another [`schedule::Schedule`].
//! 3. What it gathers is a [`film::Film`]: sums that are exact in any order, so that parts of a picture can be merged
//!    ([`film::Part`]). [`stats`] says where the time went.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use device::Device;
//! use engine::{load, renderer::Renderer, settings::RenderSettings};
//!
//! let loaded = load::load(Path::new("scene.glb"), None, &[])?;
//! let settings = RenderSettings::new(640, 360, &loaded.camera);
//! let device = Device::best()?;
//! let mut renderer = Renderer::new(&device, &loaded.scene, &loaded.procedural, &settings)?;
//! renderer.render(64)?;
//! let rgb = renderer.film()?.mean();
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Around that:
//!
//! - [`session`] opens, edits, renders and saves: what programs use, who need nothing below it. [`display`] and [`pick`]
//!   are what a window wants besides.
//! - [`fleet`] has several devices render one picture.
//! - [`denoise`] takes the noise out of a film's picture.
//! - [`evaluate`], [`preview`] and [`isolated`] are about one texture, or one node of a look, without its scene.
//! - [`bake`] writes what materials look like into pictures over texture coordinates.
//! - [`wave`], [`frame`] and [`texturing`] are what passes, uploads and texture programs hand each other.
//!
//! The crate never prints: every failure is a value that names file, place and remedy, and what is odd but not wrong is a
//! warning in the result. `docs/architecture.md` has the whole picture.

pub mod adaptive;
pub mod alias;
pub mod audit;
pub mod bake;
pub mod bvh;
pub mod denoise;
pub mod display;
pub mod evaluate;
pub mod film;
pub mod filter;
pub mod fingerprint;
pub mod fleet;
pub mod frame;
pub mod gpu_scene;
pub mod isolated;
pub mod load;
pub mod material_record;
mod morton;
pub mod passes;
pub mod pick;
pub mod preview;
pub mod procedural;
pub mod renderer;
pub mod schedule;
pub mod session;
pub mod settings;
mod sobol;
pub mod stats;
pub mod system;
pub mod texturing;
pub mod view;
pub mod wave;

pub use ::scene;
pub use ::scene::{aside, input};
