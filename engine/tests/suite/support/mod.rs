//! What the whole-system tests share: pictures with known error, their comparison, test data that may be absent.
//!
//! A test file takes it in with `mod support;`. One that uses only part of it writes
//! `#[expect(dead_code, reason = "other tests use the rest")] mod support;`.

pub(crate) mod device;
pub(crate) mod estimate;
pub(crate) mod maps;
pub(crate) mod memory;
pub(crate) mod normal;
pub(crate) mod scenes;
pub(crate) mod shared;
pub(crate) mod stats;
