//! What tests share: pictures with known error, their comparison, test data that may be absent.
//!
//! The whole program's tests take it in by its path; one that uses only part of it with
//! `#[expect(dead_code, reason = "other tests use the rest")]`.

use std::path::Path;

pub(crate) mod device;
pub(crate) mod estimate;
pub(crate) mod maps;
pub(crate) mod memory;
pub(crate) mod normal;
pub(crate) mod scenes;
pub(crate) mod shared;
pub(crate) mod stats;

/// The checkout's folder.
///
/// # Panics
/// There is none around the crate.
pub(crate) fn root() -> &'static Path {
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let found = folders.find(|folder| folder.join("user_textures").is_dir());
    found.expect("tests run in a checkout")
}
