//! Work that must end soon and hold little, and the smallest scene, for tests with hostile files.

use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use serde_json::{Value, json};

use super::memory;

/// No case may take longer; all of them together take a second or two.
const TIME_LIMIT: Duration = Duration::from_secs(20);
/// No case may hold more. The largest file of them has 120 kB.
const MEMORY_LIMIT: usize = 256 << 20;

/// What is held beside the input: stacks, queues, allocators of threads.
const SLACK: usize = 4 << 20;

/// Runs `work` on a thread of its own and fails where it panics, hangs or holds too much.
pub(super) fn bounded<T: Send + 'static>(
    what: &Path,
    work: impl FnOnce() -> T + Send + 'static,
) -> T {
    let before = memory::restart();
    let (sender, receiver) = mpsc::channel();
    let thread = std::thread::spawn(move || {
        // The receiver is gone only after a time-out, which has failed the test already.
        let _ = sender.send(work());
    });
    let result = match receiver.recv_timeout(TIME_LIMIT) {
        Ok(result) => result,
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("{} hangs", what.display()),
        Err(mpsc::RecvTimeoutError::Disconnected) => panic!("{} panics", what.display()),
    };
    thread.join().expect("the thread has sent its result");
    let held = memory::peak().saturating_sub(before);
    assert!(
        held < MEMORY_LIMIT,
        "{} takes {} MiB",
        what.display(),
        held >> 20
    );
    result
}

/// Runs `work` and fails where it holds more than four times `needed` bytes.
pub(super) fn within<T: Send + 'static>(
    what: &str,
    needed: usize,
    work: impl FnOnce() -> T + Send + 'static,
) -> T {
    let before = memory::held();
    let result = bounded(Path::new(what), work);
    let held = memory::peak().saturating_sub(before);
    eprintln!("  {what}: {:.1} MiB for {:.1}", mib(held), mib(needed));
    assert!(
        held <= 4 * needed + SLACK,
        "{what} takes {:.1} MiB, four times {:.1} are allowed",
        mib(held),
        mib(needed)
    );
    result
}

pub(super) fn mib(bytes: usize) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

/// One triangle, whose three corners lie in the file `name`.
pub(super) fn triangle(name: &str) -> Value {
    json!({
        "asset": { "version": "2.0" },
        "buffers": [{ "uri": name, "byteLength": 36 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "nodes": [{ "mesh": 0 }],
    })
}

pub(super) fn corners() -> Vec<u8> {
    let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    corners.iter().flat_map(|n| n.to_le_bytes()).collect()
}

pub(super) fn write(folder: &Path, name: &str, tree: &Value) -> std::path::PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, serde_json::to_vec(tree).unwrap()).unwrap();
    path
}
