//! MaterialX documents (.mtlx, versions 1.38 and 1.39) as nodes and materials of Patina's looks.
//!
//! [`Document`] is a file as it is written, with what it includes; [`convert`] turns it into what a look has, so that every value
//! remains one that can be edited; [`look_text`] writes that down. [`textures`] are what the nodes of MaterialX's standard library
//! become: a WGSL function each. What can't be expressed is a warning with its line.
//!
//! Of `scene` this crate uses the plain values of looks and the files, of `texgen` messages and the interfaces of textures. It knows
//! no engine and no device. Input is foreign: no document leads to a panic, and what it becomes is bounded.
//!
//! ```no_run
//! use std::path::Path;
//!
//! use materialx::{Document, Wanted, convert, look_text};
//! use scene::input::Disk;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let document = Document::read(&Disk, Path::new("brass.mtlx"))?;
//! let converted = convert(&document, &Disk, &Wanted::default())?;
//! for warning in converted.warnings.iter() {
//!     eprintln!("{}", warning.render());
//! }
//! std::fs::write("brass.look.toml", look_text(&converted))?;
//! # Ok(())
//! # }
//! ```

mod convert;
mod document;
mod import;
mod look;
mod procedurals;
mod read;
mod shader;
#[cfg(test)]
mod tests;
pub mod textures;
mod types;
mod value;

pub use convert::{Converted, Material, Node, Wanted};
pub use document::{Document, Element, ElementId};
pub use import::convert;
pub use look::look_text;
pub use types::Type;
