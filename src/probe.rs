//! The one process that this program starts and waits for: it ends with it, whatever ends it.

use std::process::{Child, ExitStatus};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The process, while there is one.
static PROBE: Mutex<Option<Child>> = Mutex::new(None);

/// Ends the process, if there is one, and keeps all others from being waited for: this program is about to end.
pub(crate) fn end() {
    let mut probe = PROBE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(child) = probe.as_mut() {
        // It may have ended just now.
        let _ = child.kill();
    }
    // None is started any more.
    std::mem::forget(probe);
}

/// How a process ended; none that took too long, and is ended then.
pub(crate) fn wait(child: Child, patience: Duration) -> Option<ExitStatus> {
    let start = Instant::now();
    let lock = || PROBE.lock().unwrap_or_else(PoisonError::into_inner);
    *lock() = Some(child);
    while start.elapsed() < patience {
        let ended = lock().as_mut().map(Child::try_wait);
        if let Some(Ok(Some(status))) = ended {
            *lock() = None;
            return Some(status);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut child = lock().take()?;
    // It may have ended just now; nothing is wrong with that.
    let _ = child.kill();
    let _ = child.wait();
    None
}
