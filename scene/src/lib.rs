//! A scene as plain data: what was read from files, before any device sees it.
//!
//! This crate is for programs that read, make or change what Patina renders. It knows neither a device nor how anything
//! is rendered, and of `texgen` only plain types (places in texts, messages, swizzles).
//!
//! # What is here
//!
//! - [`Scene`] is everything that is rendered: [`Mesh`]es placed by [`Instance`]s, [`Material`]s with their [`Image`]s,
//!   [`PunctualLight`]s, [`Camera`]s and the [`Environment`]. All of it is public data that refers to each other by index;
//!   nothing is cached, so that it can be changed freely.
//! - [`import`] makes a scene from files. Each format is a folder of its own below it.
//! - [`look`] is the second file of a scene, which says what its format can't: textures and what they drive, blends,
//!   overrides. [`look::Look`] is what it means, [`look::LookDocument`] its text as something to edit.
//! - [`material_parameters`] is the one table of what a material has: the look's reader, panels, kernels and
//!   documentation all read it.
//! - [`sky`] computes the environment and the sun of a clear day.
//! - [`input`] opens every file that is read, [`aside`] writes every file that is saved.
//!
//! # The way through
//!
//! ```no_run
//! use std::path::Path;
//!
//! use scene::look::Look;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let imported = scene::import::load(Path::new("valve.gltf"))?;
//! for warning in &imported.warnings {
//!     eprintln!("{warning}");
//! }
//! let look = Look::load(Path::new("valve.look.toml"))?;
//! let camera = scene::default_camera(&imported.scene);
//! println!(
//!     "{} triangles, {} materials, seen from {}; the look changes {} materials",
//!     imported.scene.instanced_triangles(),
//!     imported.scene.materials.len(),
//!     camera.transform.translation,
//!     look.materials.len(),
//! );
//! # Ok(())
//! # }
//! ```
//!
//! Applying a look to a scene needs the textures it names, and is done where those are known: in the engine.
//!
//! # Conventions
//!
//! Y up, right-handed, metres, radians, linear Rec.709, row 0 of a picture on top. Input is foreign: no file leads to a
//! panic, and memory is bounded by the size of the files. Every error says which file, which place in it, and what to do.

pub mod aside;
mod atmosphere;
mod camera;
mod environment;
pub mod export;
mod image;
pub mod import;
pub mod input;
mod light;
mod light_groups;
pub mod look;
mod material;
pub mod material_parameters;
mod mesh;
mod moment;
mod name_id;
mod scene;
pub mod sky;
pub mod view;

pub use self::image::{FloatImage, Image};
pub use camera::{Camera, Projection, default_camera};
pub use environment::Environment;
pub use light::{LightKind, MAX_ANGULAR_DIAMETER, PunctualLight};
pub use light_groups::{LightGroups, LightSource, MAX_LIGHT_GROUPS, TooManyLightGroups, UNGROUPED};
pub use material::{
    AlphaMode, Filter, Material, SURFACE_TEXTURES, Sampler, TEXTURES, TextureRef, Wrap, absorption,
};
pub use mesh::{CustomAttribute, Instance, Mesh};
pub use moment::{Animation, Moment, Motion};
pub use name_id::{murmur3, name_id};
pub use scene::Scene;
