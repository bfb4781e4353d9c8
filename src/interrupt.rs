//! Ctrl-C: the first one asks the render to end after its wave, the second one ends the process.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Starts listening. Where the system refuses, Ctrl-C keeps its usual meaning.
pub(crate) fn listen() {
    let _ = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            process::exit(1);
        }
    });
}

/// Whether Ctrl-C has been pressed since [`listen`].
pub(crate) fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}
