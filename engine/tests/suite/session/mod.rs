//! A session of files: after whatever edits, failures and losses the film is, bit by bit, that of a fresh render of the
//! look as it is then.

mod edits;
mod files;
mod layers;
mod lights;
pub(crate) mod look;
mod losses;
mod random;
pub(crate) mod stage;
mod view;
