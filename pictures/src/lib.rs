//! Picture files as numbers, and how far two pictures are apart.
//!
//! For whoever asks about pictures, be they Patina's or not: [`Picture::read`] gives all layers of a file as floats, [`Facts::read`]
//! what its header says, and [`Distance::between`] compares two layers: mean squared errors, and the difference that people
//! see ([`flip`]), with a map of it ([`heat`]). How much of a picture's noise is seen while its truth isn't known, [`seen`] tells.
//!
//! The crate opens no files: it is given bytes. They are foreign input, so that none of them leads to a panic, and memory is bounded
//! by their number. Of how a picture was rendered it knows nothing; films are turned into a [`Picture`] by their owner.
//!
//! ```
//! use pictures::{Distance, Layer};
//!
//! let layer = |grey: f32| Layer::rgb("", [2, 1], &[[grey; 3], [0.5; 3]]);
//! let distance = Distance::between(&layer(0.5), &layer(0.4), 0.0)?;
//! assert!((distance.mse - 0.005).abs() < 1e-6);
//! assert!(distance.flip.is_some_and(|flip| flip > 0.01));
//! # Ok::<(), pictures::DistanceError>(())
//! ```
//!
//! Row 0 is on top, colours are linear Rec.709.

mod distance;
mod error;
mod exr;
mod facts;
pub mod flip;
pub mod heat;
mod layer;
mod read;
pub mod seen;

pub use distance::{Distance, DistanceError};
pub use error::PictureError;
pub use facts::{ChannelFacts, Facts, PartFacts};
pub use layer::{Channel, Layer, Picture};
