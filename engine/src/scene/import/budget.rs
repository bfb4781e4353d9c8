//! Bounds what a file can make the importer hold, relative to the file itself.
//!
//! A kilobyte of JSON can refer to the same accessor or picture a million times. Ordinary files decode to a few times
//! their size; what goes far beyond is refused before it is allocated.

use super::error::Fault;
use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes that may still be allocated; shared by threads.
pub(super) struct Budget {
    left: AtomicU64,
    limit: u64,
}

impl Budget {
    pub(super) fn new(limit: u64) -> Self {
        Self {
            left: AtomicU64::new(limit),
            limit,
        }
    }

    /// For geometry decoded from a file of `file_bytes`: 32 times as much, and 512 MiB that are free.
    pub(super) fn for_geometry(file_bytes: u64) -> Self {
        Self::new((512 << 20) + file_bytes.saturating_mul(32))
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
                    "would take more than {} MiB, far more than the size of the file explains",
                    self.limit >> 20
                )
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn takes_until_nothing_is_left_and_never_overflows() {
        let budget = Budget::new(100);
        budget.take(10, 9).unwrap();
        budget.take(u64::MAX, u64::MAX).unwrap_err();
        budget.take(2, 9).unwrap_err();
        budget.take(1, 10).unwrap();
    }
}
