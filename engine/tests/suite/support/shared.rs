//! Test data that is not part of the project (references, large scenes): found beside the checkout, or not at all.

use std::path::PathBuf;

/// The path `shared/NAME` beside the checkout; `None`, with a notice, where it is absent: the test is to be skipped.
pub(crate) fn find(name: &str) -> Option<PathBuf> {
    let path = super::root().join("../shared").join(name);
    if path.exists() {
        Some(path)
    } else {
        eprintln!("skipped: the test data shared/{name} is not on this machine");
        None
    }
}
