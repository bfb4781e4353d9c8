//! The tests of the measurements, as one program with one support.

#[path = "../../../engine/tests/suite/support/mod.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod support;

mod forms;
mod kernels;
mod methods;
mod traversal;
