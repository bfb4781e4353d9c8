//! Bounds what files can make the importer hold, relative to the files themselves.
//!
//! A kilobyte of JSON can refer to the same accessor or picture a million times. Ordinary files decode to a few times
//! their size; what goes far beyond is refused before it is allocated. One budget is shared by all files of a scene.

use super::error::Fault;
use crate::input::FileId;
use std::collections::HashSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// What geometry may take however small the files are.
const FREE: u64 = 512 << 20;
/// What a byte of a file may become.
const FACTOR: u64 = 32;
/// What files that are included again, and meshes in several poses, may take in addition, all together.
const REPEATED: u64 = 4 << 30;

/// Bytes that may still be allocated; shared by threads.
#[derive(Debug)]
pub(super) struct Budget {
    left: AtomicU64,
    limit: AtomicU64,
    files: Mutex<Files>,
}

/// Files that have been counted.
#[derive(Debug, Default)]
struct Files {
    known: HashSet<FileId>,
    repeated: u64,
}

impl Files {
    /// As much of it as may be taken for what comes again.
    fn repeat(&mut self, more: u64) -> u64 {
        let more = more.min(REPEATED - self.repeated);
        self.repeated += more;
        more
    }
}

impl Budget {
    pub(super) fn new(limit: u64) -> Self {
        Self {
            left: AtomicU64::new(limit),
            limit: AtomicU64::new(limit),
            files: Mutex::default(),
        }
    }

    /// For geometry decoded from files that [`allow`](Self::allow) names: 512 MiB are free.
    pub(super) fn for_geometry() -> Self {
        Self::new(FREE)
    }

    /// A file of `bytes` is read: 32 times as much may be taken, for the same file again only up to 4 GiB in all.
    pub(super) fn allow(&self, file: FileId, bytes: u64) {
        let more = bytes.saturating_mul(FACTOR);
        let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        let more = match files.known.insert(file) {
            true => more,
            false => files.repeat(more),
        };
        self.add(more);
    }

    /// Such a file shows meshes in so many further poses, each of which has vertices of its own: as if it came again for each.
    pub(super) fn allow_poses(&self, bytes: u64, poses: u64) {
        let more = bytes.saturating_mul(FACTOR).saturating_mul(poses);
        let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        self.add(files.repeat(more));
    }

    fn add(&self, more: u64) {
        for counter in [&self.left, &self.limit] {
            let add = |old: u64| Some(old.saturating_add(more));
            // The closure always gives a value, so this can't fail.
            let _ = counter.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add);
        }
    }

    /// Begins anew with `bytes` taken: what is held, of all that was taken.
    pub(super) fn hold(&self, bytes: u64) {
        let limit = self.limit.load(Ordering::Relaxed);
        self.left
            .store(limit.saturating_sub(bytes), Ordering::Relaxed);
    }

    /// Bytes that may still be taken.
    pub(super) fn left(&self) -> u64 {
        self.left.load(Ordering::Relaxed)
    }

    /// Takes `count` items of `size` bytes. Nothing is ever given back, so this bounds time as well.
    pub(super) fn take(&self, count: u64, size: u64) -> Result<(), Fault> {
        let bytes = count.saturating_mul(size);
        self.left
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| {
                left.checked_sub(bytes)
            })
            .map(drop)
            .map_err(|_| {
                format!(
                    "the scene would take more than {} MiB, far more than the size of its files explains, poses of meshes included",
                    self.limit.load(Ordering::Relaxed) >> 20
                )
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn takes_until_nothing_is_left_and_never_overflows() {
        let budget = Budget::new(100);
        budget.take(10, 9).unwrap();
        budget.take(u64::MAX, u64::MAX).unwrap_err();
        budget.take(2, 9).unwrap_err();
        budget.take(1, 10).unwrap();
    }

    #[test]
    fn a_file_that_comes_again_allows_less_and_less() {
        let budget = Budget::new(0);
        let file = |name: &str| FileId::of(Path::new(name));
        budget.allow(file("missing-a"), 10);
        budget.allow(file("missing-b"), 10);
        assert_eq!(budget.left(), 640);
        for _ in 0..100 {
            budget.allow(file("missing-a"), 1 << 30);
        }
        assert_eq!(budget.left(), 640 + REPEATED);
        budget.allow_poses(1 << 20, 100);
        assert_eq!(budget.left(), 640 + REPEATED, "it is the same allowance");
        budget.allow(file("missing-c"), u64::MAX);
        assert_eq!(budget.left(), u64::MAX);
    }

    #[test]
    fn poses_allow_as_much_as_files_that_come_again() {
        let budget = Budget::new(0);
        budget.allow(FileId::of(Path::new("missing")), 10);
        budget.allow_poses(10, 3);
        assert_eq!(budget.left(), 4 * 320);
        budget.allow_poses(u64::MAX, u64::MAX);
        assert_eq!(budget.left(), 320 + REPEATED);
    }
}
